//! Panel "Machine": the machine of the setup, one of the program or of a machine file.

use egui::{ComboBox, Ui};

use super::fields;
use crate::app::model::field_faults::FaultyField;
use crate::app::model::machine_list::{MachineList, fault_words};
use crate::app::views::command::Command;
use crate::app::views::field_faults;
use crate::app::views::theme::{self, Condition};
use crate::setup::Setup;

const TIP: &str = "Machine that the program is for. The timeline shows where its axes stand, and the\n\
     planner keeps to the tilt that it reaches. One of your own is a machine file: a copy\n\
     of one in assets/machines with your axes, limits and zero point";
/// Entry for no machine.
const NONE: &str = "None";

/// What was chosen in the list of machines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MachineChoice {
    /// No machine.
    None,
    /// The machine of this name or file.
    Named(String),
    /// A file that is to be asked for.
    OpenFile,
}

/// Draws the list of machines; returns what was chosen.
pub fn show(ui: &mut Ui, setup: &Setup, machines: &MachineList) -> Option<MachineChoice> {
    let mut choice = None;
    ui.horizontal(|ui| {
        let label = ui.label(FaultyField::MACHINE.label).on_hover_text(TIP);
        // From the label to where fields end: machines have longer names than settings have values.
        let width = theme::LABEL_WIDTH + theme::FIELD_WIDTH - label.rect.width();
        let chosen = setup.machine.file.as_deref();
        ui.vertical(|ui| {
            let mut at = egui::Rect::NOTHING;
            ui.horizontal(|ui| {
                let shown = chosen.map_or_else(|| NONE.to_owned(), |chosen| machines.label_of(chosen));
                // A long name is shortened: the list would take the place of the dot otherwise.
                let list = ui.scope(|ui| {
                    ui.set_max_width(width);
                    ComboBox::from_id_salt("machine")
                        .width(width)
                        .truncate()
                        .selected_text(shown)
                        .show_ui(ui, |ui| entries(ui, chosen, machines))
                });
                let list = list.inner;
                choice = list.inner.flatten();
                let tip = chosen.map_or_else(|| TIP.to_owned(), |chosen| format!("{chosen}\n{TIP}"));
                at = list.response.labelled_by(label.id).on_hover_text(tip).rect;
                if chosen.is_some() && fields::reset_dot(ui, FaultyField::MACHINE.label) {
                    choice = Some(MachineChoice::None);
                }
            });
            let is_edited = choice.as_ref().is_some_and(|choice| *choice != MachineChoice::OpenFile);
            let is_reported = field_faults::show(ui, FaultyField::MACHINE.label, at, is_edited);
            if let Some(error) = chosen.and_then(|chosen| machines.fault_of(chosen)).filter(|_| !is_reported)
            {
                let (what, help) = fault_words(error);
                field_faults::mark(ui, at, &format!("{what}; {help}"), (Condition::Blocked, 1.0));
            }
        });
    });
    choice
}

/// The entries of the list: none, those that are known, and one that asks for a file.
fn entries(ui: &mut Ui, chosen: Option<&str>, machines: &MachineList) -> Option<MachineChoice> {
    let mut choice = None;
    if ui.selectable_label(chosen.is_none(), NONE).clicked() {
        choice = Some(MachineChoice::None);
    }
    for machine in machines.entries(chosen) {
        let entry = ui.selectable_label(chosen == Some(&machine), machines.label_of(&machine));
        if entry.on_hover_text(&machine).clicked() {
            choice = Some(MachineChoice::Named(machine));
        }
    }
    ui.separator();
    let open = ui.selectable_label(false, Command::OpenMachine.label());
    if open.on_hover_text(Command::OpenMachine.tip()).clicked() {
        choice = Some(MachineChoice::OpenFile);
    }
    if choice.is_some() {
        ui.close();
    }
    choice
}
