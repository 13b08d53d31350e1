//! Faults at their fields: a frame round the field, and what is wrong below it.

use std::sync::Arc;

use egui::{
    Color32, Context, Id, Label, Popup, PopupKind, Rect, RectAlign, Response, RichText, Role, Stroke,
    StrokeKind, Ui, WidgetInfo,
};

use super::theme::{self, Condition};
use crate::app::model::field_faults::{FaultyField, FieldFault, FieldScope};

/// Space between a field and what is said beside it, and width of that, points.
const BESIDE_FIELD: f32 = 40.0;
const MAX_SAID_WIDTH: f32 = 280.0;

/// What is shown in this frame, and what was edited in it.
#[derive(Clone, Default)]
struct ShownFaults {
    faults: Arc<[FieldFault]>,
    scope: FieldScope,
    edited: Vec<FaultyField>,
}

fn key() -> Id {
    Id::unique("field faults")
}

/// Makes `faults` those that all fields show from now on.
pub fn set(ctx: &Context, faults: Arc<[FieldFault]>) {
    let shown = ShownFaults { faults, ..ShownFaults::default() };
    ctx.data_mut(|data| data.insert_temp(key(), shown));
}

/// The faulty fields that were edited since.
pub fn edited(ctx: &Context) -> Vec<FaultyField> {
    ctx.data(|data| data.get_temp::<ShownFaults>(key())).unwrap_or_default().edited
}

/// Draws a form: its fields are those of `scope`.
pub fn within<R>(ui: &mut Ui, scope: FieldScope, form: impl FnOnce(&mut Ui) -> R) -> R {
    let enter = |ui: &Ui, scope: FieldScope| {
        ui.data_mut(|data| {
            let shown = data.get_temp_mut_or_default::<ShownFaults>(key());
            std::mem::replace(&mut shown.scope, scope)
        })
    };
    let outer = enter(ui, scope);
    let drawn = form(ui);
    enter(ui, outer);
    drawn
}

/// Whether a field of `scope` has a fault.
pub fn is_any(ui: &Ui, scope: FieldScope) -> bool {
    let shown = ui.data(|data| data.get_temp::<ShownFaults>(key())).unwrap_or_default();
    shown.faults.iter().any(|fault| fault.field.scope == scope)
}

/// What is wrong with the field of this label; `None` for nothing.
fn fault_of(ui: &Ui, label: &str) -> Option<FieldFault> {
    ui.data(|data| {
        let shown = data.get_temp::<ShownFaults>(key())?;
        let is_it = |fault: &&FieldFault| fault.field.scope == shown.scope && fault.field.label == label;
        shown.faults.iter().find(is_it).cloned()
    })
}

/// Draws what is wrong with the field of this label, whose box is `at`. `edited`: the user changed it, which
/// ends the fault; so does keeping the default that stands there. Returns whether there was a fault.
pub fn show(ui: &mut Ui, label: &str, at: Rect, edited: bool) -> bool {
    let Some(fault) = fault_of(ui, label) else { return false };
    mark(ui, at, &fault.text, (Condition::Interfering, 1.5));
    let tip = "The value in the field is meant: the fault is settled as if it had been entered";
    let is_kept = fault.is_default && ui.small_button("Keep the default").on_hover_text(tip).clicked();
    if edited || is_kept {
        ui.data_mut(|data| {
            data.get_temp_mut_or_default::<ShownFaults>(key()).edited.push(fault.field);
        });
    }
    true
}

/// Draws a frame in the colour of a condition and of a width, points, round the box `at` of a field, and
/// `text` below it.
pub fn mark(ui: &mut Ui, at: Rect, text: &str, style: (Condition, f32)) {
    draw_mark(ui, at, text, style, Label::wrap);
}

/// As [`mark`], with one `line` below the field, so that the fields below it stay where they are looked for.
/// Tooltip and accessible label have the whole `text`.
pub fn mark_in_a_line(ui: &mut Ui, at: Rect, [line, text]: [&str; 2], style: (Condition, f32)) {
    let one_line = |label: Label| label.truncate().show_tooltip_when_elided(false);
    let label = draw_mark(ui, at, line, style, one_line).on_hover_text(text);
    label.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
}

/// As [`mark`], with `text` beside the field, over what is there: the fields below it stay where they are. A
/// click goes through it.
pub fn mark_beside(ui: &Ui, id: Id, at: Rect, text: &str, (condition, width): (Condition, f32)) {
    if !ui.clip_rect().intersects(at) {
        return;
    }
    let colour = condition.text(ui.visuals());
    draw_frame(ui, at, colour, width);
    let popup = Popup::new(id.with("beside the field"), ui.ctx().clone(), at, ui.layer_id());
    let popup = popup.kind(PopupKind::Tooltip).align(RectAlign::RIGHT).align_alternatives(&[RectAlign::LEFT]);
    popup.gap(BESIDE_FIELD).interactable(false).show(|ui| {
        ui.set_max_width(MAX_SAID_WIDTH);
        ui.add(Label::new(RichText::new(text).color(colour)).wrap());
    });
}

/// The frame round the box `at` of a field.
fn draw_frame(ui: &Ui, at: Rect, colour: Color32, width: f32) {
    ui.painter().rect_stroke(at, 3.0, Stroke::new(width, colour), StrokeKind::Outside);
}

fn draw_mark(
    ui: &mut Ui,
    at: Rect,
    text: &str,
    (condition, width): (Condition, f32),
    fitted: fn(Label) -> Label,
) -> Response {
    let colour = condition.text(ui.visuals());
    draw_frame(ui, at, colour, width);
    ui.scope(|ui| {
        ui.set_max_width(theme::FIELD_WIDTH + 20.0);
        ui.add(fitted(Label::new(RichText::new(text).small().color(colour))))
    })
    .inner
}
