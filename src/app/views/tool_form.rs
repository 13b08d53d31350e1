//! The fields of a tool, below its drawing: cutter, shank, holder, cutting data.

use std::cell::RefCell;

use egui::{DragValue, Id, Rect, Response, TextEdit, Ui};

use super::panels::fields::{self, FieldSpec};
use super::theme::Condition;
use super::typed::{self, Typed, TypedLimits};
use super::{field_faults, tool_drawing, units};
use crate::app::model::number::Quantity;
use crate::app::model::units::DisplayUnits;
use crate::geometry::without_conversion_error;
use crate::io::tool_file::{MAX_NAME, MAX_NUMBER, MAX_SEGMENTS, MAX_TEETH};
use crate::setup::Tool;
use crate::setup::cutting_data::{CuttingData, fill_rates};

const DIAMETER: FieldSpec = FieldSpec::mm("Diameter", "", 0.1, 200.0).sliding(4.0, 50.0);
const CORNER: FieldSpec = FieldSpec::mm("Corner radius", "", 0.0, 100.0);
const INSERT: FieldSpec = FieldSpec::mm(
    "Insert width",
    "Radial width of the cutting edges; the core inside has no edge",
    0.01,
    100.0,
)
.sliding(0.5, 25.0);
const OVERHANG: FieldSpec =
    FieldSpec::mm("Stick-out", "Free length from tip to holder. In setup files: overhang", 0.5, 1000.0);
const FLUTES: FieldSpec =
    FieldSpec::mm("Flute length", "Length of the cutting edges; the shank begins there", 0.1, 1000.0);
const FEED: FieldSpec = FieldSpec {
    tip: "Feed rate of a plunge. Automatic: by feed per tooth, teeth and spindle speed, else by the material",
    ..FieldSpec::whole("Feed rate", Quantity::FeedRate, 10_000.0)
};
const SPINDLE: FieldSpec = FieldSpec {
    tip: "Automatic: by the cutting speed of the tool, else by the material",
    ..FieldSpec::whole("Spindle speed", Quantity::SpindleSpeed, 100_000.0)
};
const TEETH: FieldSpec = FieldSpec {
    label: "Teeth",
    tip: "Number of teeth; with it the feed rate of a plunge follows its engagement",
    quantity: Quantity::Count,
    min: 1.0,
    max: MAX_TEETH as f64,
    speed: 0.1,
    decimals: 0,
    slide: None,
    absent: "auto",
    why_most: "",
};
const TAPER_ANGLE: FieldSpec = FieldSpec {
    label: "Taper",
    tip: "Half angle of edges that widen towards the shank; plans take cylindrical cutters only",
    quantity: Quantity::Angle,
    min: 0.1,
    max: 60.0,
    decimals: 2,
    absent: "none",
    ..TEETH
};
const TOOTH_FEED: FieldSpec = FieldSpec {
    label: "Feed per tooth",
    tip: "With the teeth and the spindle speed it gives the feed rate where a library has none",
    quantity: Quantity::Length,
    min: 1e-4,
    max: 5.0,
    speed: 0.005,
    decimals: 4,
    absent: "none",
    ..TEETH
};
const CUTTING_SPEED: FieldSpec = FieldSpec {
    label: "Cutting speed",
    tip: "With the diameter it gives the spindle speed where a library has none",
    quantity: Quantity::CuttingSpeed,
    min: 0.1,
    max: 1e4,
    speed: 1.0,
    decimals: 1,
    absent: "none",
    ..TEETH
};
const LENGTH_OFFSET: FieldSpec = FieldSpec {
    label: "Length offset",
    tip: "Number of the length offset in the control; the setup sheet names it",
    max: MAX_NUMBER as f64,
    absent: "as the tool",
    ..TEETH
};
const DIAMETER_OFFSET: FieldSpec = FieldSpec {
    label: "Diameter offset",
    tip: "Number of the diameter offset in the control; the setup sheet names it",
    ..LENGTH_OFFSET
};
/// What sets the greatest insert width and corner radius, and how more is possible.
const RADIUS: &str = ", the radius. For more, make the diameter larger first";
/// The same of the flute length.
const STICK_OUT: &str = ", the stick-out. For more, make that longer first";

/// The same of a piece of the shank, where the flutes have what it leaves of the stick-out.
const FLUTES_AUTO: &str =
    ", as the flutes need some of the stick-out. For more, make that longer or give the flute length first";
/// Least length that the shank leaves of the stick-out to flutes without a length of their own, mm.
const MIN_FLUTES: f64 = FLUTES.min;

/// Draws the tool and its fields, and keeps what hangs together within its limits. Rates that are not given
/// are those for the `material`.
pub fn show(ui: &mut Ui, tool: &mut Tool, material: Option<&CuttingData>) {
    tool_drawing::show(ui, tool);
    show_fields(ui, tool, material);
}

/// Draws the fields alone, for where the drawing stays while they scroll.
pub fn show_fields(ui: &mut Ui, tool: &mut Tool, material: Option<&CuttingData>) {
    let more = &mut tool.assembly;
    text_row(ui, "Name", "What the shop calls it", &mut more.name);
    fields::form(ui, "tool fields", |ui| {
        let form = ui.scope_id();
        let radius = tool.radius();
        fields::plain_row(ui, &mut tool.diameter, &DIAMETER);
        fields::plain_row(ui, &mut tool.insert_width, &INSERT.at_most(radius.min(INSERT.max), RADIUS));
        fields::plain_row(ui, &mut tool.corner_radius, &CORNER.at_most(radius.min(CORNER.max), RADIUS));
        let least = match tool.assembly.flute_length {
            None if !tool.assembly.shank.is_empty() => shank_length(tool) + MIN_FLUTES,
            _ => OVERHANG.min,
        };
        let overhang = FieldSpec { min: least.max(OVERHANG.min).min(tool.overhang), ..OVERHANG };
        fields::plain_row(ui, &mut tool.overhang, &overhang);
        let flutes = FLUTES.at_most(tool.overhang.min(FLUTES.max), STICK_OUT);
        fields::optional_row(ui, &mut tool.assembly.flute_length, &flutes, None);
        let mut teeth = tool.assembly.teeth.map(f64::from);
        if fields::optional_row(ui, &mut teeth, &TEETH, None) {
            tool.assembly.teeth = teeth.map(|teeth| teeth as u32);
        }
        let missing = &mut tool.assembly.missing_rates;
        rate_row(ui, &mut tool.plunge_feed, &mut missing.plunge_feed, &FEED);
        rate_row(ui, &mut tool.spindle, &mut missing.spindle, &SPINDLE);
        fit_and_say(ui, form, tool);
    });
    let overhang = tool.overhang;
    // No thinner than the cutter: one that is not looked at is not too small for the checks.
    let shank = [tool.diameter, 0.5 * overhang];
    let room = tool.assembly.flute_length.is_none().then_some(overhang);
    let rows = segments(ui, "Shank", &["diameter", "length"], &mut tool.assembly.shank, (shank, room));
    if let Some((at, text)) = rows.zip(beyond_stick_out(tool, units::display_units(ui))) {
        field_faults::mark(ui, at, &text, (Condition::Blocked, 1.0));
    }
    let lower = 2.0 * tool.diameter;
    let heads = ["lower diameter", "upper diameter", "length"];
    segments(ui, "Holder", &heads, &mut tool.assembly.holder, ([lower, lower, 2.0 * lower], None));
    more_fields(ui, tool);
    fit(tool);
    // What they follow from may have been edited.
    fill_rates(tool, material);
}

/// Length of all pieces of the shank, mm.
fn shank_length(tool: &Tool) -> f64 {
    tool.assembly.shank.iter().map(|[_, length]| length).sum()
}

/// Row of a rate, which is automatic while it is missing.
fn rate_row(ui: &mut Ui, rate: &mut f64, is_missing: &mut bool, spec: &FieldSpec) {
    let mut given = (!*is_missing).then_some(*rate);
    if fields::derived_row(ui, &mut given, *rate, spec) {
        *is_missing = given.is_none();
        *rate = given.unwrap_or(*rate);
    }
}

/// What is said where flutes and shank together are longer than the stick-out; `None` where they are not.
fn beyond_stick_out(tool: &Tool, units: DisplayUnits) -> Option<String> {
    /// Less is rounding, mm.
    const TOLERANCE: f64 = 1e-6;
    let more = &tool.assembly;
    let flutes = more.flutes_end(tool.overhang);
    let shank = shank_length(tool);
    let length = |mm: f64| format!("{} {}", units.short(mm, 3), units.length_unit());
    (flutes + shank > tool.overhang + TOLERANCE).then(|| {
        format!(
            "flutes of {} and shank of {} are longer than the stick-out of {}: the shank is taken to end \
             there; make the stick-out longer, or the shank shorter",
            length(flutes),
            length(shank),
            length(tool.overhang)
        )
    })
}

/// Fits the tool, and says at its fields in `form` what that changed.
fn fit_and_say(ui: &Ui, form: Id, tool: &mut Tool) {
    let units = units::display_units(ui);
    let values = |tool: &Tool| {
        let flutes = tool.assembly.flute_length;
        [
            (INSERT.label, Some(tool.insert_width)),
            (CORNER.label, Some(tool.corner_radius)),
            (FLUTES.label, flutes),
        ]
    };
    let before = values(tool);
    fit(tool);
    for ((label, was), (_, is)) in before.into_iter().zip(values(tool)) {
        let Some((was, is)) = was.zip(is).filter(|(was, is)| was != is) else { continue };
        let with = if label == FLUTES.label { "stick-out" } else { "diameter" };
        let [was_text, is_text] = [units.short(was, 3), units.short(is, 3)];
        typed::say(ui, form, label, is, format!("{was_text} made {is_text} with the {with}"));
    }
}

/// A text of a tool, in a line of its own: names of makers are long.
fn text_row(ui: &mut Ui, label: &str, tip: &str, text: &mut Option<String>) {
    ui.horizontal(|ui| {
        let label = ui.label(label).on_hover_text(tip);
        let mut edited = text.clone().unwrap_or_default();
        let width = ui.available_width() - 8.0;
        let field = TextEdit::singleline(&mut edited).char_limit(MAX_NAME).desired_width(width);
        if ui.add(field).labelled_by(label.id).changed() {
            *text = (!edited.trim().is_empty()).then_some(edited);
        }
    });
}

/// What most tools do without, folded away: taper, cutting data, offsets, words.
fn more_fields(ui: &mut Ui, tool: &mut Tool) {
    // Not indented: the fields of a form take the width of the panel, with their dots.
    egui::CollapsingHeader::new("More").show_unindented(ui, |ui| {
        let more = &mut tool.assembly;
        text_row(ui, "Description", "Maker, order number, use", &mut more.description);
        text_row(ui, "Cutter material", "Such as carbide", &mut more.material);
        fields::form(ui, "more tool fields", |ui| {
            let mut degrees = more.taper_rad.map(|taper| without_conversion_error(taper.to_degrees()));
            if fields::optional_row(ui, &mut degrees, &TAPER_ANGLE, None) {
                more.taper_rad = degrees.map(f64::to_radians);
            }
            fields::optional_row(ui, &mut more.feed_per_tooth, &TOOTH_FEED, None);
            fields::optional_row(ui, &mut more.cutting_speed, &CUTTING_SPEED, None);
            for (offset, spec) in
                [(&mut more.length_offset, &LENGTH_OFFSET), (&mut more.diameter_offset, &DIAMETER_OFFSET)]
            {
                let mut number = offset.map(f64::from);
                if fields::optional_row(ui, &mut number, spec, None) {
                    *offset = number.map(|number| number as u32);
                }
            }
        });
    });
}

/// Rows of the segments of a shank or holder, from the cutter towards the spindle, with buttons to add and
/// remove. `new` is the piece that the button adds first. All of them together stay shorter than `room`, mm.
/// Returns where the last one is.
fn segments<const N: usize>(
    ui: &mut Ui,
    what: &str,
    heads: &[&str; N],
    rows: &mut Vec<[f64; N]>,
    (new, room): ([f64; N], Option<f64>),
) -> Option<Rect> {
    let (mut remove, mut last) = (None, None);
    let form = ui.scope_id();
    if !rows.is_empty() {
        ui.label(egui::RichText::new(format!("{what}: {}", heads.join(", "))).weak());
    }
    let together = |rows: &[[f64; N]]| rows.iter().filter_map(|row| row.last()).sum::<f64>();
    for k in 0..rows.len() {
        let left = room.map(|room| room - MIN_FLUTES - together(&rows[..k]) - together(&rows[k + 1..]));
        let row = &mut rows[k];
        let name = format!("{what} {}", k + 1);
        let line = ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let label = ui.label(&name);
            for (column, (value, head)) in row.iter_mut().zip(heads).enumerate() {
                let most = left.filter(|_| column + 1 == N);
                length_box(ui, form, (&name, head), value, most).labelled_by(label.id);
            }
            let button = ui.small_button("×").on_hover_text("Removes this piece");
            let name = format!("Remove {}", name.to_lowercase());
            button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
            if button.clicked() {
                remove = Some(k);
            }
        });
        last = Some(line.response.rect);
        typed::show(ui, form, &name, PIECE, line.response.rect);
    }
    if let Some(k) = remove {
        rows.remove(k);
    }
    let add = egui::Button::new(format!("Add {}", what.to_lowercase()));
    // Half of what is left is for the new piece.
    let half = room.map(|room| 0.5 * (room - together(rows)));
    let has_room = half.is_none_or(|half| half > MIN_FLUTES);
    let add = ui.add_enabled(rows.len() < MAX_SEGMENTS && has_room, add);
    let tip = format!("Adds a piece towards the spindle: {}", heads.join(", "));
    if add.on_hover_text(tip).clicked() {
        let mut row = rows.last().copied().unwrap_or(new);
        if let Some((length, half)) = row.last_mut().zip(half) {
            *length = length.min(half);
        }
        rows.push(row);
    }
    last
}

/// Greatest length of a piece, mm.
const MAX_PIECE: f64 = 1000.0;
/// Value that the notes of a piece go by: it has several fields.
const PIECE: f64 = 0.0;

/// A length of a piece: `name` is that of the piece, and what the length is; `most` what flutes leave for it.
fn length_box(
    ui: &mut Ui,
    form: Id,
    (name, what): (&str, &str),
    value: &mut f64,
    most: Option<f64>,
) -> Response {
    ui.spacing_mut().interact_size.x = 50.0;
    let units = units::display_units(ui);
    let show = |mm: f64| format!("{} {}", units.short(mm, 3), units.length_unit());
    // A greater one that it has stays until it is edited.
    let range = 0.1..=most.map_or(MAX_PIECE, |most| most.max(*value).min(MAX_PIECE));
    let limits = TypedLimits {
        quantity: Quantity::Length,
        units,
        range: range.clone(),
        why_least: "",
        why_most: if most.is_some() { FLUTES_AUTO } else { "" },
        show: &show,
    };
    let (shown, refused) = (units.short(*value, 3), RefCell::default());
    let field = DragValue::new(value)
        .speed(0.1)
        .range(range)
        .custom_formatter(|length, _| units.short(length, 3))
        .custom_parser(|text| limits.parse(text, &shown, &refused))
        .update_while_editing(false);
    let field = ui.add(field).on_hover_text(format!("{what}, {}", units.length_unit()));
    let said = match refused.into_inner() {
        Typed::Refused(reason) => Typed::Refused(format!("{what}: {reason}")),
        other => other,
    };
    typed::keep(ui, form, name, PIECE, said);
    field
}

/// Keeps what hangs on radius and stick-out of a tool within them, as a setup file must have it.
pub fn fit(tool: &mut Tool) {
    tool.insert_width = tool.insert_width.min(tool.radius());
    tool.corner_radius = tool.corner_radius.min(tool.radius());
    let shank = shank_length(tool);
    let assembly = &mut tool.assembly;
    if assembly.flute_length.is_none() && shank >= tool.overhang {
        assembly.flute_length = Some(tool.diameter.min(0.5 * tool.overhang));
    }
    assembly.flute_length = assembly.flute_length.map(|flutes| flutes.min(tool.overhang));
}
