//! The dialog that assigns roles (hub, shroud, blade, ...) to the nodes of a mesh file or the bodies of one
//! from CAD, where names and shapes do not determine them or the user wants to change them, and takes unit,
//! axis, number of blades and sense of rotation.

mod form;
mod preview;

use egui::{Button, Color32, Key, Modal, Modifiers, RichText, Ui};

use crate::mesh::{MeshOptions, Role};

use crate::app::App;
use crate::app::model::document::OpenPart;
use crate::app::model::part_source::PartSource;
use crate::app::model::role_choices::{RoleChoices, hint_for_dialog};
use crate::app::tasks::mesh_nodes::UnassignedRoles;
use crate::app::tasks::open_task::OpenTask;
use crate::app::views::list_keys::take_presses;
use crate::app::views::modal::is_dismissed;
use crate::app::views::pictures::Pictures;
use crate::app::views::theme::{self, Condition};
use crate::report::words::as_sentence;
use preview::{PreviewInput, RolesPreview};

/// Keys that set the role of the selected node.
const KEYS: [(Key, Option<Role>); 6] = [
    (Key::H, Some(Role::Hub)),
    (Key::S, Some(Role::Shroud)),
    (Key::B, Some(Role::Blade)),
    (Key::P, Some(Role::Splitter)),
    (Key::I, Some(Role::Ignored)),
    (Key::Delete, None),
];
/// Width of the picture, points.
const PICTURE: f32 = 250.0;

/// A mesh file whose nodes need roles, with the picture and the choices.
struct RolesForm {
    unassigned: UnassignedRoles,
    preview: RolesPreview,
    choices: RoleChoices,
    /// The options that the fault is of.
    faulty: MeshOptions,
}

/// The roles dialog.
#[derive(Default)]
pub(in crate::app) struct RolesDialog {
    asked: Option<RolesForm>,
    /// Whether the part is being opened with the choices.
    waiting: bool,
}

impl RolesDialog {
    /// Whether it is open.
    pub(in crate::app) fn is_open(&self) -> bool {
        self.asked.is_some()
    }

    /// Opens the dialog for a file; if it is open for that file already, only the error is replaced.
    pub(in crate::app) fn ask(&mut self, unassigned: UnassignedRoles) {
        self.waiting = false;
        match &mut self.asked {
            Some(asked) if asked.unassigned.path == unassigned.path => {
                asked.unassigned.fault = unassigned.fault;
                asked.faulty = asked.choices.options(&asked.unassigned.nodes);
            }
            asked => {
                let preview = RolesPreview::new(unassigned.meshes.clone());
                let UnassignedRoles { nodes, unit, said, fault, .. } = &unassigned;
                let choices = RoleChoices::new(nodes, *unit, said, fault.is_some());
                let faulty = choices.options(nodes);
                *asked = Some(RolesForm { unassigned, preview, choices, faulty });
            }
        }
    }

    /// Closes it.
    pub(in crate::app) fn close(&mut self) {
        *self = Self::default();
    }

    /// Enables the dialog again after opening has ended.
    pub(in crate::app) fn enable(&mut self) {
        self.waiting = false;
    }

    /// Draws it; returns the opening task when the choices are confirmed.
    fn show(&mut self, ui: &Ui, pictures: Option<&Pictures>) -> Option<OpenTask> {
        let asked = self.asked.as_mut()?;
        let (mut open, mut close) = (false, false);
        let waiting = self.waiting;
        let modal = Modal::new(egui::Id::unique("roles")).show(ui.ctx(), |ui| {
            ui.set_width(720.0_f32.min(ui.ctx().content_rect().width() - 40.0));
            if !waiting {
                open = asked.handle_keys(ui);
            }
            let file = asked.unassigned.path.file_name().unwrap_or_default().to_string_lossy();
            ui.label(RichText::new(format!("Assign surfaces, {file}")).strong());
            if let Some(fault) = &asked.unassigned.fault {
                let red = Condition::Interfering.text(ui.visuals());
                let is_of_choices = asked.faulty == asked.choices.options(&asked.unassigned.nodes);
                let message = RichText::new(as_sentence(fault.message.clone()));
                let fix = RichText::new(format!("Fix: {}", hint_for_dialog(&fault.help)));
                // Of choices that were changed since, nothing is known.
                let [message, fix] = match is_of_choices {
                    true => [message.color(red), fix],
                    false => [message.weak(), fix.weak()],
                };
                ui.label(message);
                ui.label(fix);
            }
            ui.separator();
            ui.add_enabled_ui(!waiting, |ui| {
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| {
                        ui.set_width(PICTURE);
                        let shown = PreviewInput {
                            roles: &asked.choices.roles,
                            axis: asked.choices.vertical_axis(&asked.unassigned.nodes),
                            chosen: asked.choices.selected,
                        };
                        asked.preview.show(ui, pictures, egui::vec2(PICTURE, PICTURE - 40.0), &shown);
                        form::file(ui, &asked.unassigned.nodes, &mut asked.choices);
                    });
                    ui.vertical(|ui| {
                        form::nodes(ui, &asked.unassigned.nodes, &mut asked.choices, 270.0);
                        form::left_out(ui, &asked.choices.left_out(&asked.unassigned.nodes));
                        ui.checkbox(&mut asked.choices.apply_to_identical, "Apply to identical meshes")
                            .on_hover_text("A role applies to all nodes with the same area, within 1 %");
                        ui.label(
                            RichText::new("Keys: up, down; H hub, S shroud, B blade, P splitter, I ignore")
                                .weak(),
                        );
                    });
                });
            });
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                let text = RichText::new("Open the part").color(Color32::WHITE).strong();
                open |= ui.add_enabled(!waiting, Button::new(text).fill(theme::PRIMARY)).clicked();
                close = ui.button("Cancel").clicked();
                if waiting {
                    ui.label("Opening…");
                }
            });
        });
        if close || is_dismissed(&modal) && !waiting {
            self.close();
            return None;
        }
        open.then(|| {
            self.waiting = true;
            let options = asked.choices.options(&asked.unassigned.nodes);
            asked.unassigned.task.clone().with_part(PartSource::Mesh(asked.unassigned.path.clone(), options))
        })
    }
}

impl RolesForm {
    /// Handles the keyboard; `true` when Enter confirms the choices.
    fn handle_keys(&mut self, ui: &Ui) -> bool {
        if ui.memory(|memory| memory.focused().is_some()) || egui::Popup::is_any_open(ui.ctx()) {
            return false;
        }
        let role_of = |key| KEYS.iter().find(|(known, _)| *known == key).map(|(_, role)| *role);
        let presses = take_presses(ui.ctx(), |key, modifiers| {
            let is_known =
                matches!(key, Key::ArrowDown | Key::ArrowUp | Key::Enter) || role_of(key).is_some();
            (is_known && modifiers.matches_logically(Modifiers::NONE)).then_some(key)
        });
        let (last, choices) = (self.unassigned.nodes.len() - 1, &mut self.choices);
        for key in presses {
            let next = match key {
                Key::Enter => return true,
                Key::ArrowDown => choices.selected.map_or(0, |k| (k + 1).min(last)),
                Key::ArrowUp => choices.selected.map_or(last, |k| k.saturating_sub(1)),
                _ => {
                    let role = role_of(key);
                    role.into_iter().for_each(|role| choices.set_role(&self.unassigned.nodes, role));
                    continue;
                }
            };
            (choices.selected, choices.scroll_to_selected) = (Some(next), true);
        }
        false
    }
}

impl App {
    /// Opens the roles dialog for the open part's file.
    pub(in crate::app) fn assign_roles(&mut self) {
        let part = self.state.document.part.as_ref().filter(|part| part.source.mesh().is_some());
        if let Some(OpenPart { source, impeller, .. }) = part {
            let roles_by_shape = impeller.roles_by_shape;
            self.submit_open(OpenTask::Nodes { source: source.clone(), roles_by_shape });
        }
    }

    /// Draws the dialog.
    pub(in crate::app) fn ask_roles(&mut self, ui: &Ui) {
        let mut dialog = std::mem::take(&mut self.roles);
        let task = dialog.show(ui, self.pictures.as_ref());
        self.roles = dialog;
        if let Some(task) = task {
            self.submit_open(task);
        }
    }
}
