//! Rows of a form: number fields (number and unit in one box, drag or type, arithmetic allowed) and lists.
//! Both have an accessible name, and a dot where the value differs from the default; a click on the dot
//! resets it.

use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::path::Path;

use egui::{Color32, ComboBox, DragValue, Grid, Response, Sense, Slider, Ui, Vec2};

use crate::app::model::machine_list::MachineList;
use crate::app::model::number::Quantity;
use crate::app::model::step_note::FieldNote;
use crate::app::model::units::DisplayUnits;
use crate::app::views::theme::Condition;
use crate::app::views::typed::{self, Typed, TypedLimits};
use crate::app::views::{field_faults, list_keys, theme, units};
use crate::geometry::without_conversion_error;

/// Description of a number field.
#[derive(Clone, Copy, Debug)]
pub struct FieldSpec {
    /// Name, sentence case.
    pub label: &'static str,
    /// Tooltip: meaning.
    pub tip: &'static str,
    /// What the number measures; its unit stands behind it.
    pub quantity: Quantity,
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// Change per dragged point.
    pub speed: f64,
    /// Maximum number of decimals.
    pub decimals: usize,
    /// Range of the slider under the box, if there is one: usual values, well within the limits.
    pub slide: Option<(f64, f64)>,
    /// Text that stands for an optional value that is absent.
    pub absent: &'static str,
    /// What sets the maximum and how more is possible, as the end of a sentence that names it.
    pub why_most: &'static str,
}

impl FieldSpec {
    /// A number without name, limits and unit, which the others complete.
    const PLAIN: Self = Self {
        label: "",
        tip: "",
        quantity: Quantity::Plain,
        min: 0.0,
        max: f64::INFINITY,
        speed: 1.0,
        decimals: 0,
        slide: None,
        absent: "auto",
        why_most: "",
    };

    /// A length in mm.
    pub const fn mm(label: &'static str, tip: &'static str, least: f64, greatest: f64) -> Self {
        Self {
            label,
            tip,
            quantity: Quantity::Length,
            min: least,
            max: greatest,
            speed: 0.05,
            decimals: 3,
            ..Self::PLAIN
        }
    }

    /// An angle in degrees.
    pub const fn degrees(label: &'static str, tip: &'static str, least: f64, greatest: f64) -> Self {
        Self {
            label,
            tip,
            quantity: Quantity::Angle,
            min: least,
            max: greatest,
            speed: 0.1,
            decimals: 2,
            ..Self::PLAIN
        }
    }

    /// A whole number of at least one.
    pub const fn whole(label: &'static str, quantity: Quantity, greatest: f64) -> Self {
        Self { label, quantity, min: 1.0, max: greatest, ..Self::PLAIN }
    }

    /// An optional value without which something is left out: "none".
    pub const fn or_none(self) -> Self {
        Self { absent: "none", ..self }
    }

    /// The same with another maximum, and what sets it.
    pub const fn at_most(self, max: f64, why_most: &'static str) -> Self {
        Self { max, why_most, ..self }
    }

    /// Adds a slider under the box.
    pub const fn sliding(self, low: f64, high: f64) -> Self {
        Self { slide: Some((low, high)), ..self }
    }
}

/// Number with unit, without trailing zeros.
pub fn show(value: f64, spec: &FieldSpec, units: DisplayUnits) -> String {
    let number = |units: DisplayUnits| units.short(value, spec.decimals);
    match spec.quantity {
        Quantity::Length => format!("{} {}", number(units), units.length_unit()),
        Quantity::FeedRate => format!("{} {}", number(units), units.feed_unit()),
        Quantity::Angle => number(DisplayUnits::Metric) + spec.quantity.unit(),
        Quantity::Plain | Quantity::Count => number(DisplayUnits::Metric),
        Quantity::SpindleSpeed | Quantity::CuttingSpeed | Quantity::RemovalRate | Quantity::Duration => {
            format!("{} {}", number(DisplayUnits::Metric), spec.quantity.unit())
        }
    }
}

/// What stands for an optional value that is absent.
#[derive(Clone, Copy)]
pub struct Automatic<'a> {
    /// Its text.
    pub words: &'a str,
    /// The number that is then taken, if one is known: dragging the field and its slider begin there.
    pub now: Option<f64>,
}

/// A number box without label. `automatic`: what stands for 0; an empty input means 0, too. What is typed and
/// not taken is returned with the reason.
pub fn number_box(
    ui: &mut Ui,
    value: &mut f64,
    spec: &FieldSpec,
    automatic: Option<Automatic>,
) -> (Response, Typed) {
    let least = if automatic.is_some() { 0.0 } else { spec.min };
    let (quantity, units) = (spec.quantity, units::display_units(ui));
    let held = Cell::new(*value);
    let stand_in = automatic.and_then(|automatic| automatic.now);
    let number = || stand_in.filter(|_| held.get() <= 0.0).unwrap_or(held.get());
    let write = |number: f64| match automatic {
        Some(automatic) if held.get() <= 0.0 => automatic.words.to_owned(),
        _ => show(number, spec, units),
    };
    let shown = write(number());
    let show_limit = |limit: f64| show(limit, spec, units);
    let limits = TypedLimits {
        quantity,
        units,
        range: least.max(spec.min)..=spec.max,
        why_least: "",
        why_most: spec.why_most,
        show: &show_limit,
    };
    let typed = RefCell::default();
    let take = |edited: Option<f64>| {
        edited.into_iter().for_each(|edited| held.set(edited));
        number()
    };
    let mut field = DragValue::from_get_set(take)
        .speed(spec.speed)
        .range(least..=spec.max)
        // An out-of-range value from a file is kept until it is edited.
        .clamp_existing_to_range(false)
        .custom_formatter(|number, _| write(number))
        .custom_parser(|text| match automatic {
            Some(Automatic { words, .. })
                if ["", words, spec.absent].contains(&text.trim()) || is_zero(text) =>
            {
                typed.replace(Typed::Taken);
                Some(0.0)
            }
            _ => limits.parse(text, &shown, &typed),
        })
        .update_while_editing(false);
    if spec.decimals == 0 {
        field = field.speed(1.0);
    }
    let response = ui.add_sized(Vec2::new(theme::FIELD_WIDTH, 20.0), field);
    *value = held.get();
    let typed = typed.into_inner();
    if spec.tip.is_empty() {
        return (response, typed);
    }
    let limits = [least.max(spec.min), spec.max].map(show_limit);
    let limits = format!("{}\n{} to {}", spec.tip, limits[0], limits[1]);
    (response.on_hover_text(limits), typed)
}

/// Whether a typed text is the number 0.
fn is_zero(text: &str) -> bool {
    text.trim().parse() == Ok(0.0)
}

/// A form row with label, box, dot and slider; `true` when the value changed.
pub fn number_row(ui: &mut Ui, value: &mut f64, default: f64, spec: &FieldSpec) -> bool {
    labelled(ui, value, Some(default), (spec, None), None)
}

/// Like [`number_row`], for a value without a default.
pub fn plain_row(ui: &mut Ui, value: &mut f64, spec: &FieldSpec) -> bool {
    labelled(ui, value, None, (spec, None), None)
}

/// Like [`number_row`], for an optional value: 0 means that it is absent, in most cases automatic. `now`: the
/// automatic value, at which the slider stands then, and dragging begins.
pub fn optional_row(ui: &mut Ui, value: &mut Option<f64>, spec: &FieldSpec, now: Option<f64>) -> bool {
    row_or_automatic(ui, value, (spec, None), Automatic { words: spec.absent, now })
}

/// What is said at a field that has a value: the line below it, and the whole text.
type NoteOf<'a> = &'a dyn Fn(f64) -> Option<FieldNote>;

/// Like [`optional_row`]; `note`: what is said at a value that is not taken as it is.
pub fn noted_row(
    ui: &mut Ui,
    value: &mut Option<f64>,
    spec: &FieldSpec,
    now: Option<f64>,
    note: NoteOf<'_>,
) -> bool {
    row_or_automatic(ui, value, (spec, Some(note)), Automatic { words: spec.absent, now })
}

/// Like [`optional_row`], where the automatic value follows from others: it is shown as such.
pub fn derived_row(ui: &mut Ui, value: &mut Option<f64>, automatic: f64, spec: &FieldSpec) -> bool {
    let words = format!("{} {}", spec.absent, show(automatic, spec, units::display_units(ui)));
    row_or_automatic(ui, value, (spec, None), Automatic { words: &words, now: Some(automatic) })
}

/// Row of an optional value, with what stands for an absent one.
fn row_or_automatic(
    ui: &mut Ui,
    value: &mut Option<f64>,
    (spec, note): (&FieldSpec, Option<NoteOf<'_>>),
    absent: Automatic,
) -> bool {
    let mut number = value.unwrap_or(0.0);
    let changed = labelled(ui, &mut number, Some(0.0), (spec, note), Some(absent));
    if changed {
        *value = (number > 0.0).then(|| number.max(spec.min));
    }
    changed
}

/// Like [`number_row`], for an angle stored in radians and shown in degrees.
pub fn angle_row(ui: &mut Ui, radians: &mut f64, default: f64, spec: &FieldSpec) -> bool {
    let mut degrees = without_conversion_error(radians.to_degrees());
    let changed = number_row(ui, &mut degrees, without_conversion_error(default.to_degrees()), spec);
    if changed {
        *radians = degrees.to_radians();
    }
    changed
}

/// Description of a list field: label, options, and name and meaning of each option.
pub struct ChoiceSpec<T: 'static> {
    /// Name, sentence case.
    pub label: &'static str,
    /// Tooltip: effect of the choice.
    pub tip: &'static str,
    /// Options, in list order.
    pub all: &'static [T],
    /// Name of an option.
    pub name: fn(T) -> &'static str,
    /// Tooltip of an option.
    pub meaning: fn(T) -> &'static str,
}

/// An option of a list field: its value, name and tooltip.
pub struct ListEntry<'a, T> {
    /// Its value.
    pub value: T,
    /// Its name.
    pub name: Cow<'a, str>,
    /// Its tooltip.
    pub meaning: Cow<'a, str>,
}

/// A form row with label, list and dot.
pub fn choice_row<T: Copy + PartialEq>(ui: &mut Ui, value: &mut T, default: T, choice: &ChoiceSpec<T>) {
    let entry = |&value: &T| {
        let (name, meaning) = ((choice.name)(value).into(), (choice.meaning)(value).into());
        ListEntry { value, name, meaning }
    };
    let entries: Vec<_> = choice.all.iter().map(entry).collect();
    list_row(ui, value, default, (choice.label, choice.tip), &entries);
}

/// Like [`choice_row`], with options that are known only now; that of `value` is among them.
pub fn list_row<T: Copy + PartialEq>(
    ui: &mut Ui,
    value: &mut T,
    default: T,
    (label, tip): (&str, &str),
    entries: &[ListEntry<T>],
) {
    let title = ui.label(label).on_hover_text(tip);
    let before = *value;
    let shown = entries.iter().find(|entry| entry.value == before).map_or("", |entry| &entry.name);
    ui.vertical(|ui| {
        let mut at = egui::Rect::NOTHING;
        ui.horizontal(|ui| {
            let list = ComboBox::from_id_salt(label)
                .width(theme::FIELD_WIDTH)
                .truncate()
                .selected_text(shown)
                .show_ui(ui, |ui| {
                    for entry in entries {
                        let line = ui.selectable_value(value, entry.value, &*entry.name);
                        line.on_hover_text(&*entry.meaning);
                    }
                });
            let now = entries.iter().position(|entry| entry.value == *value);
            let step = list_keys::step(ui, &list.response);
            if let Some(to) = now.and_then(|now| list_keys::moved(now, step, entries.len())) {
                *value = entries[to].value;
            }
            at = list.response.labelled_by(title.id).rect;
            if *value == default {
                reserve_dot(ui);
            } else if reset_dot(ui, label) {
                *value = default;
            }
        });
        field_faults::show(ui, label, at, *value != before);
    });
    ui.end_row();
}

/// A form row with label, check box and dot. `words`: what is so while it is checked.
pub fn switch_row(ui: &mut Ui, value: &mut bool, default: bool, name: &str, (words, tip): (&str, &str)) {
    let before = *value;
    ui.label(name).on_hover_text(tip);
    ui.vertical(|ui| {
        let mut at = egui::Rect::NOTHING;
        ui.horizontal(|ui| {
            let box_width = Vec2::new(theme::FIELD_WIDTH, 20.0);
            let layout = egui::Layout::left_to_right(egui::Align::Center);
            let field = ui.allocate_ui_with_layout(box_width, layout, |ui| {
                ui.set_min_width(theme::FIELD_WIDTH);
                ui.checkbox(value, words)
            });
            at = field.inner.rect;
            field.inner.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, *value, name));
            field.inner.on_hover_text(tip);
            if *value == default {
                reserve_dot(ui);
            } else if reset_dot(ui, name) {
                *value = default;
            }
        });
        field_faults::show(ui, name, at, *value != before);
    });
    ui.end_row();
}

/// A row with a list of machines.
pub fn machine_row(ui: &mut Ui, (name, tip): (&str, &str), chosen: &mut String, machines: &MachineList) {
    let known = machines.entries(Some(chosen));
    name_row(ui, (name, tip), chosen, known, |machine| machines.label_of(machine), |_| {});
}

/// A row with a list of controls; the chosen one may be the file of a post, which stands before the others.
pub fn control_row(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    chosen: &mut String,
    known: impl Iterator<Item = &'static str>,
    more: impl FnOnce(&mut Ui),
) {
    let known: Vec<String> = known.map(str::to_owned).collect();
    let own: Vec<String> = Some(chosen.clone()).into_iter().filter(|name| !known.contains(name)).collect();
    let short = |name: &str| match Path::new(name).file_name() {
        Some(file) => file.to_string_lossy().into_owned(),
        None => name.to_owned(),
    };
    name_row(ui, (name, tip), chosen, [own, known].concat(), short, more);
}

/// A row with a list of `names`, as `short` shows them.
fn name_row(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    chosen: &mut String,
    names: Vec<String>,
    short: impl Fn(&str) -> String,
    more: impl FnOnce(&mut Ui),
) {
    let label = ui.label(name).on_hover_text(tip);
    ui.horizontal(|ui| {
        let list = ComboBox::from_id_salt(name).width(theme::FIELD_WIDTH).truncate();
        let list = list.selected_text(short(chosen)).show_ui(ui, |ui| {
            for name in names {
                let label = short(&name);
                ui.selectable_value(chosen, name, label);
            }
        });
        list.response.labelled_by(label.id).on_hover_text(tip);
        more(ui);
    });
    ui.end_row();
}

/// A form row; `true` when the value changed. `automatic`: what stands for 0.
fn labelled(
    ui: &mut Ui,
    value: &mut f64,
    default: Option<f64>,
    (spec, note): (&FieldSpec, Option<NoteOf<'_>>),
    automatic: Option<Automatic>,
) -> bool {
    let (before, form) = (*value, ui.scope_id());
    let label = ui.label(spec.label).on_hover_text(spec.tip);
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        let mut at = egui::Rect::NOTHING;
        ui.horizontal(|ui| {
            let (field, typed) = number_box(ui, value, spec, automatic);
            typed::keep(ui, form, spec.label, *value, typed);
            at = field.labelled_by(label.id).rect;
            match default.filter(|default| default != value) {
                Some(default) if reset_dot(ui, spec.label) => *value = default,
                Some(_) => {}
                None => reserve_dot(ui),
            }
        });
        if let Some((low, high)) = spec.slide {
            let stand_in = automatic.and_then(|automatic| automatic.now).filter(|_| *value <= 0.0);
            ui.spacing_mut().slider_width = theme::FIELD_WIDTH;
            let start = stand_in.unwrap_or(*value);
            let (response, moved) = slider(ui, start, low..=high, step_of(spec));
            response.labelled_by(label.id);
            *value = moved.unwrap_or(*value);
        }
        field_faults::show(ui, spec.label, at, *value != before);
        typed::show(ui, form, spec.label, *value, at);
        if let Some([line, text]) = note.filter(|_| *value > 0.0).and_then(|note| note(*value)) {
            field_faults::mark_in_a_line(ui, at, [&line, &text], (Condition::Blocked, 1.0));
        }
    });
    ui.end_row();
    *value != before
}

/// A slider without label at `value`; returns its response and the new value if it was moved. A value between
/// steps or out of range is kept until the slider is moved.
pub fn slider(
    ui: &mut Ui,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    step: f64,
) -> (Response, Option<f64>) {
    let start = value.clamp(*range.start(), *range.end());
    let mut at = start;
    ui.spacing_mut().interact_size.y = 12.0;
    let response = ui.add(Slider::new(&mut at, range).show_value(false).step_by(step));
    // Snapping to the nearest step does not count as a move.
    let moved = response.changed() && (at - start).abs() > 0.5 * step;
    (response, moved.then(|| without_conversion_error(at)))
}

/// Step of a field's slider: a round value that suits its range.
fn step_of(spec: &FieldSpec) -> f64 {
    match spec.slide {
        Some((low, high)) if high - low > 20.0 => 0.5,
        Some((low, high)) if high - low > 4.0 => 0.1,
        _ => 0.01,
    }
}

/// Side of the dot beside a value, points.
const DOT: f32 = 14.0;

/// Keeps the space of the dot, so that the form does not become wider with it.
fn reserve_dot(ui: &mut Ui) {
    ui.allocate_space(Vec2::splat(DOT));
}

/// A form: labels at the left, fields at the right, in columns of the same widths in every form.
pub fn form(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    let columns = Grid::new(name).num_columns(2).spacing([8.0, 4.0]);
    columns.min_col_width(theme::LABEL_WIDTH).max_col_width(theme::LABEL_WIDTH + 30.0).show(ui, content);
}

/// The dot beside a value that differs from its default; `true` when it was clicked to reset.
pub fn reset_dot(ui: &mut Ui, label: &str) -> bool {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(DOT), Sense::click());
    let fill: Color32 = theme::accent(ui.visuals());
    let radius = if response.hovered() { 4.5 } else { 3.0 };
    ui.painter().circle_filled(rect.center(), radius, fill);
    let name = format!("Reset {}", label.to_lowercase());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    response.on_hover_text("Differs from the default; click to reset").clicked()
}
