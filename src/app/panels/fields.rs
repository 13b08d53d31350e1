//! Rows of a form. Number fields: number and unit in one box, drag or type, arithmetic allowed. Lists to choose from. Both
//! with a dot where the value differs from the default (a click on it resets), and an accessible name.

use egui::{Color32, ComboBox, DragValue, Response, Sense, Slider, Ui, Vec2};

use super::super::{number, theme};

/// What a field holds.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Name, sentence case.
    pub label: &'static str,
    /// What it means, and what limits it.
    pub tip: &'static str,
    /// Unit shown behind the number, with its leading space where there is one.
    pub unit: &'static str,
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub greatest: f64,
    /// Change per dragged point.
    pub speed: f64,
    /// Decimals shown at most.
    pub decimals: usize,
    /// Ends of the slider under the box, if there is one: what is usual, well inside what is allowed.
    pub slide: Option<(f64, f64)>,
}

impl Spec {
    /// A length in mm.
    pub const fn mm(label: &'static str, tip: &'static str, least: f64, greatest: f64) -> Self {
        Self { label, tip, unit: " mm", least, greatest, speed: 0.05, decimals: 3, slide: None }
    }

    /// An angle in degrees.
    pub const fn degrees(label: &'static str, tip: &'static str, least: f64, greatest: f64) -> Self {
        Self { label, tip, unit: "°", least, greatest, speed: 0.1, decimals: 2, slide: None }
    }

    /// A plain number with a unit.
    pub const fn plain(label: &'static str, unit: &'static str, greatest: f64) -> Self {
        Self { label, tip: "", unit, least: 1.0, greatest, speed: 1.0, decimals: 0, slide: None }
    }
}

impl Spec {
    /// With a slider under the box.
    pub const fn sliding(self, low: f64, high: f64) -> Self {
        Self { slide: Some((low, high)), ..self }
    }
}

/// Number with unit, as the field shows it: no trailing zeros.
fn show(value: f64, spec: &Spec) -> String {
    let mut text = format!("{value:.*}", spec.decimals);
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    text + spec.unit
}

/// The bare box. `automatic`: the words shown when the value is 0 or typed as nothing.
pub fn number_box(ui: &mut Ui, value: &mut f64, spec: &Spec, automatic: Option<&str>) -> Response {
    let least = if automatic.is_some() { 0.0 } else { spec.least };
    let unit = spec.unit;
    let words = automatic.map(str::to_owned);
    let parser_words = words.clone();
    let spec_copy = *spec;
    let mut field = DragValue::new(value)
        .speed(spec.speed)
        .range(least..=spec.greatest)
        // A value from a file that is out of range stays as it is until somebody edits it.
        .clamp_existing_to_range(false)
        .custom_formatter(move |v, _| match &words {
            Some(words) if v <= 0.0 => words.clone(),
            _ => show(v, &spec_copy),
        })
        .custom_parser(move |text| match &parser_words {
            Some(words) if text.trim().is_empty() || text.trim() == words => Some(0.0),
            _ => number::parse(text.trim().strip_suffix(unit.trim()).unwrap_or(text)),
        })
        .update_while_editing(false);
    if spec.decimals == 0 {
        field = field.speed(1.0);
    }
    let response = ui.add_sized(Vec2::new(84.0, 20.0), field);
    if spec.tip.is_empty() {
        return response;
    }
    let limits =
        format!("{}\n{} to {}", spec.tip, show(least.max(spec.least), spec), show(spec.greatest, spec));
    response.on_hover_text(limits)
}

/// A row of the form: name, box, dot, slider. `true` when the value changed.
pub fn row(ui: &mut Ui, value: &mut f64, default: f64, spec: &Spec) -> bool {
    labelled(ui, value, Some(default), spec, None)
}

/// The same for a value without a default.
pub fn plain_row(ui: &mut Ui, value: &mut f64, spec: &Spec) -> bool {
    labelled(ui, value, None, spec, None)
}

/// The same for a limit that may be left to the program: 0 stands for none given. `now`: what the program took for it,
/// where the slider then stands.
pub fn optional_row(ui: &mut Ui, value: &mut Option<f64>, spec: &Spec, now: Option<f64>) -> bool {
    let mut number = value.unwrap_or(0.0);
    let changed = labelled(ui, &mut number, Some(0.0), spec, Some(("auto", now)));
    if changed {
        *value = (number > 0.0).then(|| number.max(spec.least));
    }
    changed
}

/// An angle held in radians and shown in degrees.
pub fn angle_row(ui: &mut Ui, radians: &mut f64, default: f64, spec: &Spec) -> bool {
    let mut degrees = round(radians.to_degrees());
    let changed = row(ui, &mut degrees, round(default.to_degrees()), spec);
    if changed {
        *radians = degrees.to_radians();
    }
    changed
}

/// A choice of a few: how it is called, what there is to choose from, and each one's name and meaning.
pub struct Choice<T: 'static> {
    /// Name, sentence case.
    pub label: &'static str,
    /// What it decides.
    pub tip: &'static str,
    /// All there are, in the order of the list.
    pub all: &'static [T],
    /// Name of one of them.
    pub name: fn(T) -> &'static str,
    /// What one of them means.
    pub meaning: fn(T) -> &'static str,
}

/// A row of the form with a list to choose from: name, list, dot.
pub fn choice_row<T: Copy + PartialEq>(ui: &mut Ui, value: &mut T, default: T, choice: &Choice<T>) {
    let label = ui.label(choice.label).on_hover_text(choice.tip);
    ui.horizontal(|ui| {
        ComboBox::from_id_salt(choice.label)
            .width(104.0)
            .selected_text((choice.name)(*value))
            .show_ui(ui, |ui| {
                for &one in choice.all {
                    ui.selectable_value(value, one, (choice.name)(one)).on_hover_text((choice.meaning)(one));
                }
            })
            .response
            .labelled_by(label.id);
        if *value != default && reset_dot(ui, choice.label) {
            *value = default;
        }
    });
    ui.end_row();
}

/// 5° went through radians and comes back as 5.000000000000001.
fn round(degrees: f64) -> f64 {
    (degrees * 1e9).round() / 1e9
}

/// `automatic`: the word for 0, and the value the program takes then.
fn labelled(
    ui: &mut Ui,
    value: &mut f64,
    default: Option<f64>,
    spec: &Spec,
    automatic: Option<(&str, Option<f64>)>,
) -> bool {
    let before = *value;
    let label = ui.label(spec.label).on_hover_text(spec.tip);
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        ui.horizontal(|ui| {
            number_box(ui, value, spec, automatic.map(|(word, _)| word)).labelled_by(label.id);
            if let Some(default) = default.filter(|default| default != value)
                && reset_dot(ui, spec.label)
            {
                *value = default;
            }
        });
        if let Some((low, high)) = spec.slide {
            let stand_in = automatic.and_then(|(_, now)| now).filter(|_| *value <= 0.0);
            ui.spacing_mut().slider_width = 104.0;
            let start = stand_in.unwrap_or(*value);
            let (response, moved) = slider(ui, start, low..=high, step_of(spec));
            response.labelled_by(label.id);
            *value = moved.unwrap_or(*value);
        }
    });
    ui.end_row();
    *value != before
}

/// A bare slider at `value`; the value it was moved to, if it was. What lies between its steps or beyond its ends stays
/// as it is until somebody moves it.
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
    // Snapping to the nearest step is no move.
    let moved = response.changed() && (at - start).abs() > 0.5 * step;
    (response, moved.then(|| round(at)))
}

/// Sliders move in steps that read well.
fn step_of(spec: &Spec) -> f64 {
    match spec.slide {
        Some((low, high)) if high - low > 20.0 => 0.5,
        Some((low, high)) if high - low > 4.0 => 0.1,
        _ => 0.01,
    }
}

/// The dot beside a value that differs from its default; `true` when it was clicked.
pub fn reset_dot(ui: &mut Ui, label: &str) -> bool {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(14.0), Sense::click());
    let fill: Color32 = theme::accent(ui.visuals());
    let radius = if response.hovered() { 4.5 } else { 3.0 };
    ui.painter().circle_filled(rect.center(), radius, fill);
    let name = format!("Reset {}", label.to_lowercase());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    response.on_hover_text("Differs from the default; click to reset").clicked()
}
