//! Numbers that a field does not take: it keeps its value, and says beside it why, and what to do. What a
//! field changes by itself, since it hangs together with another one, is said below it.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use egui::{Context, DragValue, Id, Rect, Response, Ui};

use super::field_faults;
use super::theme::Condition;
use crate::app::model::look::Operation;
use crate::app::model::number::Quantity;
use crate::app::model::units::DisplayUnits;

/// What came of the text of a field when it was left.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Typed {
    /// No text was typed.
    #[default]
    Nothing,
    /// It was left as it was.
    Unchanged,
    /// It was taken.
    Taken,
    /// It was not: the reason, with what to do.
    Refused(String),
}

/// The numbers that a field takes.
pub struct TypedLimits<'a> {
    /// What it measures.
    pub quantity: Quantity,
    /// Units of the window.
    pub units: DisplayUnits,
    /// Least and greatest value.
    pub range: RangeInclusive<f64>,
    /// What sets the least value and how less is possible, as an end of a sentence; may be empty.
    pub why_least: &'a str,
    /// What sets the greatest value and how more is possible, as an end of a sentence; may be empty.
    pub why_most: &'a str,
    /// Text of a value, with its unit.
    pub show: &'a dyn Fn(f64) -> String,
}

impl TypedLimits<'_> {
    /// The value of `text`, or why it is not taken.
    fn value(&self, text: &str) -> Result<f64, String> {
        let typed = text.trim();
        let Some(value) = self.units.parse(text, self.quantity) else {
            return Err(format!("“{typed}” is not {}", what_it_is(self.quantity)));
        };
        if value > *self.range.end() {
            let most = (self.show)(*self.range.end());
            return Err(format!("{typed} is too much: at most {most}{}", self.why_most));
        }
        if value < *self.range.start() {
            let least = (self.show)(*self.range.start());
            return Err(format!("{typed} is too little: at least {least}{}", self.why_least));
        }
        Ok(value)
    }

    /// The value of `text` in a field that shows `shown`: what is not taken gives none, and its reason goes
    /// to `typed`. A text that is left as it was gives none either: it may be rounded.
    pub fn parse(&self, text: &str, shown: &str, typed: &RefCell<Typed>) -> Option<f64> {
        if text == shown {
            typed.replace(Typed::Unchanged);
            return None;
        }
        match self.value(text) {
            Ok(value) => {
                typed.replace(Typed::Taken);
                Some(value)
            }
            Err(reason) => {
                typed.replace(Typed::Refused(reason));
                None
            }
        }
    }
}

/// What a text should have been, with examples.
fn what_it_is(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Length => "a length: 12.5, 30/4 mm or 0.5 in are",
        Quantity::Angle => "an angle: 30, 12.5° or 0.5 rad are",
        Quantity::FeedRate => "a feed rate: 300, 300 mm/min or 12 in/min are",
        Quantity::SpindleSpeed => "a speed: 1200 or 1200 rpm are",
        Quantity::CuttingSpeed => "a cutting speed: 200, 200 m/min or 650 ft/min are",
        Quantity::RemovalRate => "a rate of removal: 800, 800 mm³/min or 0.8 cm³/min are",
        Quantity::Duration => "a time: 90, 90 min or 1.5 h are",
        Quantity::Plain => "a number: 12.5 or 30/4 are",
        Quantity::Count => "a whole number: 3 or 12/2 are",
    }
}

/// A field without label that takes what is within `limits` and changes by `speed` per dragged point, with
/// what came of a typed text.
pub fn limited_field<N: egui::emath::Numeric>(
    ui: &mut Ui,
    value: &mut N,
    limits: &TypedLimits<'_>,
    speed: f64,
) -> (Response, Typed) {
    let (shown, typed) = ((limits.show)(value.to_f64()), RefCell::default());
    let field = DragValue::new(value)
        .speed(speed)
        .range(N::from_f64(*limits.range.start())..=N::from_f64(*limits.range.end()))
        // What is out of range already is kept until it is edited.
        .clamp_existing_to_range(false)
        .custom_formatter(|value, _| (limits.show)(value))
        .custom_parser(|text| limits.parse(text, &shown, &typed))
        .update_while_editing(false);
    let response = ui.add(field);
    (response, typed.into_inner())
}

/// A text at a field, as long as this has the value that it had.
#[derive(Clone, Debug, PartialEq)]
struct Note {
    text: String,
    value: f64,
    /// Of a text that was not taken, when that was.
    refused: Option<Refusal>,
}

/// When a text was not taken. The reason disappears when another text is typed anywhere, or when the pointer
/// is pressed outside the field: it covers other parts of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Refusal {
    /// How many texts were typed up to it.
    count: TypedCount,
    /// The frame in which it was refused: the press that moved the focus out of the field falls in it, and
    /// does not count.
    frame: u64,
}

impl Refusal {
    /// Whether what is said of it at the box `at` of the field is over.
    fn is_over(self, ui: &Ui, at: Rect) -> bool {
        let pressed_beside = || {
            ui.input(|input| {
                let pointer = &input.pointer;
                pointer.any_pressed() && pointer.interact_pos().is_some_and(|place| !at.contains(place))
            })
        };
        self.count != typed_count(ui) || ui.ctx().cumulative_frame_nr() > self.frame && pressed_beside()
    }
}

/// How many texts were typed into fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct TypedCount(u64);

fn typed_count(ui: &Ui) -> TypedCount {
    ui.data(|data| data.get_temp(Id::unique("count of typed values"))).unwrap_or_default()
}

/// Ends what is said at fields: an input that was not taken is over once another step is undone, or
/// another operation looked at.
pub fn forget(ctx: &Context) {
    ctx.data_mut(|data| data.remove_by_type::<Note>());
}

/// Ends what is said at fields where `operation` is another one than in the frame before.
pub fn follow(ctx: &Context, operation: Operation) {
    let key = Id::unique("operation of typed values");
    let before = ctx.data_mut(|data| data.get_temp::<Operation>(key));
    if before != Some(operation) {
        ctx.data_mut(|data| data.insert_temp(key, operation));
        forget(ctx);
    }
}

fn key(form: Id, label: &str) -> Id {
    form.with(("note of a field", label))
}

/// Keeps what came of the text of the field of this label in `form`, whose value is `value` now.
pub fn keep(ui: &Ui, form: Id, label: &str, value: f64, typed: Typed) {
    if typed == Typed::Nothing {
        return;
    }
    let count = TypedCount(typed_count(ui).0 + 1);
    let frame = ui.ctx().cumulative_frame_nr();
    let key = key(form, label);
    ui.data_mut(|data| {
        data.insert_temp(Id::unique("count of typed values"), count);
        match typed {
            Typed::Refused(text) => {
                data.insert_temp(key, Note { text, value, refused: Some(Refusal { count, frame }) });
            }
            Typed::Taken => data.remove::<Note>(key),
            // With the count, a text that was refused is over.
            Typed::Nothing | Typed::Unchanged => {}
        }
    });
    ui.ctx().request_repaint();
}

/// Says `text` below the field of this label in `form`, until its value is another than `value`.
pub fn say(ui: &Ui, form: Id, label: &str, value: f64, text: String) {
    ui.data_mut(|data| data.insert_temp(key(form, label), Note { text, value, refused: None }));
    ui.ctx().request_repaint();
}

/// Draws what is said of the field of this label in `form`, whose value is `value` and whose box is `at`.
pub fn show(ui: &mut Ui, form: Id, label: &str, value: f64, at: Rect) {
    let key = key(form, label);
    let Some(note) = ui.data(|data| data.get_temp::<Note>(key)) else { return };
    if note.value != value || note.refused.is_some_and(|refusal| refusal.is_over(ui, at)) {
        ui.data_mut(|data| data.remove::<Note>(key));
        return;
    }
    let style = (Condition::Blocked, 1.0);
    match note.refused {
        Some(_) => field_faults::mark_beside(ui, key, at, &note.text, style),
        None => field_faults::mark(ui, at, &note.text, style),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_taken_has_a_reason_and_gives_no_value() {
        let show = |mm: f64| format!("{mm} mm");
        let limits = TypedLimits {
            quantity: Quantity::Length,
            units: DisplayUnits::Metric,
            range: 0.5..=15.0,
            why_least: ", as the form says",
            why_most: ", the radius",
            show: &show,
        };
        let typed = RefCell::default();
        assert_eq!(limits.parse("10 mm", "10 mm", &typed), None);
        assert_eq!(*typed.borrow(), Typed::Unchanged, "it was left as it was");
        for (text, value, word) in [
            ("12", Some(12.0), None),
            ("20", None, Some("20 is too much: at most 15 mm, the radius")),
            ("1 in", None, Some("1 in is too much: at most 15 mm, the radius")),
            ("-3", None, Some("-3 is too little: at least 0.5 mm, as the form says")),
            ("1e9", None, Some("1e9 is too much: at most 15 mm, the radius")),
            ("5 ft", None, Some("“5 ft” is not a length: 12.5, 30/4 mm or 0.5 in are")),
        ] {
            assert_eq!(limits.parse(text, "10 mm", &typed), value, "{text}");
            let refusal = |word: &str| Typed::Refused(word.to_owned());
            assert_eq!(*typed.borrow(), word.map_or(Typed::Taken, refusal), "{text}");
        }
    }
}
