//! Modal dialogs: what they do to the window below, what closes them, and questions with a few answers.

use egui::{Context, Id, Key, LayerId, Modal, ModalResponse, Modifiers, Popup, RichText, Ui};

use super::scroll_area;

/// Takes the tooltips of the window away when a modal dialog opens: they would stay over it as long as the
/// pointer rests. Lists and menus that were open are closed: what is asked comes first. To be called before
/// the window is drawn.
pub fn hide_tooltips_below(ctx: &Context) {
    let is_open = ctx.memory(|memory| memory.top_modal_layer()).is_some();
    let was_open = ctx.data_mut(|data| std::mem::replace(data.get_temp_mut_or_default(key()), is_open));
    if is_open && !was_open {
        // A tooltip stays while the pointer is where it was.
        ctx.input_mut(|input| input.pointer = egui::PointerState::default());
        Popup::close_all(ctx);
    }
}

/// Keeps open lists above the modal dialog that they belong to. A press in a dialog raises it; where press
/// and release fall in one frame, the list opens in that frame, too, and egui keeps the order that both had
/// before: a list that was open in an earlier dialog would open behind this one. To be called after the
/// window is drawn.
pub fn keep_lists_above(ctx: &Context) {
    let Some(dialog) = ctx.memory(|memory| memory.top_modal_layer()) else { return };
    let is_list =
        |layer: &LayerId| layer.order == dialog.order && *layer != dialog && Popup::is_id_open(ctx, layer.id);
    let shown = ctx.memory(|memory| memory.areas().visible_layer_ids());
    for list in shown.into_iter().filter(is_list) {
        ctx.set_sublayer(dialog, list);
    }
}

/// Whether a dialog is closed without an answer, by Escape. A click beside it closes nothing: what was
/// entered would be lost.
pub fn is_dismissed<T>(dialog: &ModalResponse<T>) -> bool {
    let escape = || dialog.response.ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape));
    dialog.response.should_close() || dialog.is_top_modal && !dialog.any_popup_open && escape()
}

/// Whether Enter confirms a dialog: while no field, button or list in it takes the key. To be asked before it
/// is drawn, as a field that takes the key is left with it.
pub fn is_confirmed(ctx: &Context) -> bool {
    let is_taken = ctx.memory(|memory| memory.focused().is_some()) || Popup::is_any_open(ctx);
    !is_taken && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter))
}

/// Least space around the content of a dialog, both sides together, points.
const AROUND: f32 = 40.0;
/// Upper edge of a dialog whose height changes while it is open, points.
pub const TOP: f32 = 0.5 * AROUND;

/// Draws the content of a dialog that is `width` points wide, or as wide as the window allows. It scrolls
/// where the window is too low for it.
pub fn fitting<R>(ui: &mut Ui, width: f32, content: impl FnOnce(&mut Ui) -> R) -> R {
    set_fitting_width(ui, width);
    scroll_area(ui.ctx().content_rect().height() - AROUND).show(ui, content).inner
}

/// Makes the content of a dialog `width` points wide, or as wide as the window allows.
pub fn set_fitting_width(ui: &mut Ui, width: f32) {
    ui.set_width(width.min(ui.ctx().content_rect().width() - AROUND));
}

/// A question with one button for each answer.
pub struct Question<'a> {
    /// Distinguishes it from other dialogs.
    pub id: &'static str,
    /// Width, points.
    pub width: f32,
    /// The question.
    pub title: &'a str,
    /// What is asked about.
    pub text: &'a str,
}

impl Question<'_> {
    /// Draws the question with its `answers`: label, tooltip, and meaning. Returns the answer once; Escape is
    /// `dismissed`.
    pub fn ask<A: Copy>(
        &self,
        ui: &Ui,
        answers: impl IntoIterator<Item = (&'static str, &'static str, A)>,
        dismissed: A,
    ) -> Option<A> {
        let mut answer = None;
        let content = |ui: &mut Ui| {
            ui.label(RichText::new(self.title).strong());
            ui.label(self.text);
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                for (name, tip, meaning) in answers {
                    let button = ui.button(name);
                    let button = if tip.is_empty() { button } else { button.on_hover_text(tip) };
                    if button.clicked() {
                        answer = Some(meaning);
                    }
                }
            });
        };
        let modal = Modal::new(Id::unique(self.id)).show(ui.ctx(), |ui| fitting(ui, self.width, content));
        answer.or(is_dismissed(&modal).then_some(dismissed))
    }
}

/// An answer of a [`Question`] without a tooltip.
pub fn choice<A>(name: &'static str, meaning: A) -> (&'static str, &'static str, A) {
    (name, "", meaning)
}

fn key() -> Id {
    Id::unique("whether a modal dialog was open")
}
