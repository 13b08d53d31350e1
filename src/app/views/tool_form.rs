//! The fields of a tool, below its drawing: cutter, shank, holder, cutting data.

use egui::{DragValue, Response, TextEdit, Ui};

use super::panels::fields::{self, FieldSpec};
use super::{tool_drawing, units};
use crate::app::model::number::Quantity;
use crate::io::tool_file::{MAX_NAME, MAX_SEGMENTS, MAX_TEETH};
use crate::setup::Tool;

const DIAMETER: FieldSpec = FieldSpec::mm("Diameter", "", 0.1, 200.0).sliding(4.0, 50.0);
const CORNER: FieldSpec = FieldSpec::mm("Corner radius", "", 0.0, 100.0);
const INSERT: FieldSpec = FieldSpec::mm(
    "Insert width",
    "Radial width of the cutting edges; the core inside has no edge",
    0.01,
    100.0,
)
.sliding(0.5, 25.0);
const OVERHANG: FieldSpec = FieldSpec::mm("Stick-out", "Free length from tip to holder", 0.5, 1000.0);
const FLUTES: FieldSpec =
    FieldSpec::mm("Flute length", "Length of the cutting edges; the shank begins there", 0.1, 1000.0);
const FEED: FieldSpec = FieldSpec::plain("Feed rate", " mm/min", 10_000.0);
const SPINDLE: FieldSpec = FieldSpec::plain("Spindle speed", " rev/min", 100_000.0);
const TEETH: FieldSpec = FieldSpec {
    label: "Teeth",
    tip: "Number of teeth; with it the feed rate of a plunge follows its engagement",
    unit: "",
    min: 1.0,
    max: MAX_TEETH as f64,
    speed: 0.1,
    decimals: 0,
    slide: None,
    absent: "auto",
};

/// Draws the tool and its fields, and keeps what hangs together within its limits.
pub fn show(ui: &mut Ui, tool: &mut Tool) {
    tool_drawing::show(ui, tool);
    fields::form(ui, "tool fields", |ui| {
        name_row(ui, tool);
        fields::plain_row(ui, &mut tool.diameter, &DIAMETER);
        fields::plain_row(ui, &mut tool.insert_width, &INSERT);
        fields::plain_row(ui, &mut tool.corner_radius, &CORNER);
        fields::plain_row(ui, &mut tool.overhang, &OVERHANG);
        fields::optional_row(ui, &mut tool.assembly.flute_length, &FLUTES, None);
        let mut teeth = tool.assembly.teeth.map(f64::from);
        if fields::optional_row(ui, &mut teeth, &TEETH, None) {
            tool.assembly.teeth = teeth.map(|teeth| teeth as u32);
        }
        fields::plain_row(ui, &mut tool.plunge_feed, &FEED);
        fields::plain_row(ui, &mut tool.spindle, &SPINDLE);
    });
    let overhang = tool.overhang;
    segments(ui, "Shank", &["diameter", "length"], &mut tool.assembly.shank, [10.0, 0.5 * overhang]);
    let lower = 2.0 * tool.diameter;
    let heads = ["lower diameter", "upper diameter", "length"];
    segments(ui, "Holder", &heads, &mut tool.assembly.holder, [lower, lower, 2.0 * lower]);
    fit(tool);
}

fn name_row(ui: &mut Ui, tool: &mut Tool) {
    let label = ui.label("Name").on_hover_text("What the shop calls it");
    let mut name = tool.assembly.name.clone().unwrap_or_default();
    let field = TextEdit::singleline(&mut name).char_limit(MAX_NAME).desired_width(120.0);
    if ui.add(field).labelled_by(label.id).changed() {
        tool.assembly.name = (!name.trim().is_empty()).then_some(name);
    }
    ui.end_row();
}

/// Rows of the segments of a shank or holder, from the cutter towards the spindle, with buttons to add and
/// remove.
fn segments<const N: usize>(
    ui: &mut Ui,
    what: &str,
    heads: &[&str; N],
    rows: &mut Vec<[f64; N]>,
    new: [f64; N],
) {
    let mut remove = None;
    for (k, row) in rows.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let label = ui.label(format!("{what} {}", k + 1));
            for (value, head) in row.iter_mut().zip(heads) {
                length_box(ui, value, head).labelled_by(label.id);
            }
            let button = ui.small_button("×").on_hover_text("Removes this piece");
            let name = format!("Remove {} {}", what.to_lowercase(), k + 1);
            button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
            if button.clicked() {
                remove = Some(k);
            }
        });
    }
    if let Some(k) = remove {
        rows.remove(k);
    }
    let add = egui::Button::new(format!("Add {}", what.to_lowercase()));
    let add = ui.add_enabled(rows.len() < MAX_SEGMENTS, add);
    let tip = format!("Adds a piece towards the spindle: {}", heads.join(", "));
    if add.on_hover_text(tip).clicked() {
        let last = rows.last().copied();
        rows.push(last.unwrap_or(new));
    }
}

fn length_box(ui: &mut Ui, value: &mut f64, what: &str) -> Response {
    ui.spacing_mut().interact_size.x = 50.0;
    let units = units::of(ui);
    let field = DragValue::new(value)
        .speed(0.1)
        .range(0.1..=1000.0)
        .custom_formatter(move |length, _| units.short(length, 3))
        .custom_parser(move |text| units.parse(text, Quantity::Length));
    ui.add(field).on_hover_text(format!("{what}, {}", units.length_unit()))
}

/// Keeps what hangs on radius and stick-out of a tool within them, as a setup file must have it.
pub fn fit(tool: &mut Tool) {
    tool.insert_width = tool.insert_width.min(tool.radius());
    tool.corner_radius = tool.corner_radius.min(tool.radius());
    let assembly = &mut tool.assembly;
    let shank: f64 = assembly.shank.iter().map(|[_, length]| length).sum();
    if assembly.flute_length.is_none() && shank >= tool.overhang {
        assembly.flute_length = Some(tool.diameter.min(0.5 * tool.overhang));
    }
    assembly.flute_length = assembly.flute_length.map(|flutes| flutes.min(tool.overhang));
}
