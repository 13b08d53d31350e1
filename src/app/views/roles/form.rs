//! Forms of the roles dialog: the table of nodes, and the settings of the file.

use std::ops::RangeInclusive;

use egui::{Button, ComboBox, DragValue, Grid, Label, RichText, Ui};

use crate::app::views::scroll_area;
use crate::mesh::axis::Axis;
use crate::mesh::nodes::MeshNode;
use crate::mesh::options::{FileUnit, likely_unit};
use crate::mesh::{LengthUnit, Role};
use crate::part::Rotation;

use crate::app::model::role_choices::RoleChoices;
use crate::app::model::units::DisplayUnits;
use crate::app::views::theme::Condition;
use crate::app::views::units;

/// Range of the number of main blades; 0: automatic.
const BLADES: RangeInclusive<usize> = 0..=200;
/// Number of nodes that are named in a line.
const NAMED: usize = 4;
/// Width of a node's name, points.
const NAME_WIDTH: f32 = 130.0;

/// Label of a role; `are_found`: whether the reader finds those that are not assigned.
fn word(role: Option<Role>, are_found: bool) -> &'static str {
    role.map_or(if are_found { "automatic" } else { "unassigned" }, Role::name)
}

/// A list with an accessible name; returns the new choice.
fn list<T: PartialEq + Copy>(
    ui: &mut Ui,
    name: &str,
    now: T,
    all: impl IntoIterator<Item = T>,
    word: impl Fn(T) -> String,
) -> Option<T> {
    let mut chosen = now;
    let shown =
        ComboBox::from_id_salt(name.to_owned()).width(112.0).selected_text(word(now)).show_ui(ui, |ui| {
            for item in all {
                ui.selectable_value(&mut chosen, item, word(item));
            }
        });
    shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, name));
    (chosen != now).then_some(chosen)
}

/// The table of nodes. A click on a name highlights the node; with `Choices::alike` a role applies to all
/// nodes of its shape.
pub fn nodes(ui: &mut Ui, nodes: &[MeshNode], choices: &mut RoleChoices, height: f32) {
    let (scale, units) = (choices.unit.mm(), units::display_units(ui));
    let size_title = match units {
        DisplayUnits::Metric => "Size, mm",
        DisplayUnits::Inch => "Size, in",
    };
    scroll_area(height).auto_shrink([false, true]).show(ui, |ui| {
        Grid::new("nodes").num_columns(4).striped(true).show(ui, |ui| {
            for title in ["Node", "Triangles", size_title, "Role"] {
                ui.label(RichText::new(title).weak());
            }
            ui.end_row();
            for (k, node) in nodes.iter().enumerate() {
                let name = Button::selectable(choices.selected == Some(k), &node.name).truncate();
                // From the left, as its head.
                let name = ui
                    .vertical(|ui| {
                        ui.set_width(NAME_WIDTH);
                        ui.add(name.min_size(egui::vec2(NAME_WIDTH, 20.0)))
                    })
                    .inner
                    .on_hover_text(&node.name);
                if name.clicked() {
                    choices.selected = Some(k);
                }
                if choices.scroll_to_selected && choices.selected == Some(k) {
                    name.scroll_to_me(None);
                }
                ui.label(node.triangles.to_string());
                let [x, y, z] = <[f64; 3]>::from((node.high - node.low) * scale).map(|mm| size(mm, units));
                ui.label(format!("{x} × {y} × {z}"));
                let all = Role::ALL.into_iter().map(Some).chain([None]);
                let name = format!("Role of {}", node.key);
                let are_found = choices.are_roles_found();
                let role = list(ui, &name, choices.roles[k], all, |r| word(r, are_found).to_owned());
                if let Some(role) = role {
                    choices.selected = Some(k);
                    choices.set_role(nodes, role);
                }
                ui.end_row();
            }
        });
    });
    choices.scroll_to_selected = false;
}

/// Says which nodes are left out, the first few by `names`.
pub fn left_out(ui: &mut Ui, names: &[&str]) {
    if names.is_empty() {
        return;
    }
    let mut text = format!("Left out, without a role: {}", names[..names.len().min(NAMED)].join(", "));
    if names.len() > NAMED {
        text += &format!(" and {} more", names.len() - NAMED);
    }
    ui.add(Label::new(RichText::new(text).color(Condition::Blocked.text(ui.visuals()))).wrap());
}

fn size(mm: f64, units: DisplayUnits) -> String {
    units.number(mm, usize::from(mm.abs() < 10.0))
}

/// Settings of the file: unit, axis, number of blades, sense of rotation.
pub fn file(ui: &mut Ui, nodes: &[MeshNode], choices: &mut RoleChoices) {
    let units = units::display_units(ui);
    Grid::new("mesh file").num_columns(2).show(ui, |ui| {
        ui.label("Unit");
        ui.horizontal(|ui| {
            if choices.file_unit == FileUnit::Stated {
                ui.label("as in the file").on_hover_text("The file says in which unit it is");
            } else {
                let all = LengthUnit::ALL;
                let unit = list(ui, "Unit of the file", choices.unit, all, |unit| unit.name().to_owned());
                choices.unit = unit.unwrap_or(choices.unit);
            }
            let across = choices.wheel_width(nodes);
            let text = RichText::new(format!(
                "{} {} across",
                size(across * choices.unit.mm(), units),
                units.length_unit()
            ));
            let possible = likely_unit(across, choices.unit) == Some(choices.unit);
            let doubt = Condition::Interfering.text(ui.visuals());
            let text = if possible { text.weak() } else { text.color(doubt) };
            ui.label(text).on_hover_text(match choices.file_unit {
                FileUnit::Stated => "Impellers are 3 mm to 5 m across.",
                FileUnit::Specified(_) => {
                    "Impellers are 3 mm to 5 m across. The glTF specification asks for metres."
                }
                FileUnit::Assumed(_) => "Impellers are 3 mm to 5 m across. STL files name no unit.",
            });
        });
        ui.end_row();
        ui.label("Axis of rotation");
        let axes = [None, Some(Axis::X), Some(Axis::Y), Some(Axis::Z)];
        let axis = list(ui, "Axis of rotation of the file", choices.axis, axes, |axis| {
            axis.map_or("Auto (from hub)", Axis::name).to_owned()
        });
        choices.axis = axis.unwrap_or(choices.axis);
        ui.end_row();
        ui.label("Main blades");
        let mut blades = choices.blades.unwrap_or(0);
        let field =
            DragValue::new(&mut blades).range(BLADES).speed(0.1).custom_formatter(|n, _| match n as usize {
                0 => "Auto".to_owned(),
                n => n.to_string(),
            });
        let field = ui.add(field).on_hover_text("Needed if the file has only one blade; 0: automatic");
        field.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::SpinButton, true, "Main blades of the file")
        });
        choices.blades = (blades > 0).then_some(blades);
        ui.end_row();
        ui.label("Rotation");
        let senses = [None, Some(Rotation::Clockwise), Some(Rotation::Counterclockwise)];
        let rotation = list(ui, "Sense of rotation", choices.rotation, senses, |sense| {
            sense.map_or_else(|| "Auto (from sweep)".to_owned(), |sense| sense.to_string())
        });
        choices.rotation = rotation.unwrap_or(choices.rotation);
        ui.end_row();
    });
}
