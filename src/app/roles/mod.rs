//! Which node of a mesh file is what: the dialog that asks where names do not tell, or where the user wants another
//! choice, and what becomes of the answer.

mod choices;
mod form;
mod preview;

use std::path::{Path, PathBuf};

use egui::{Button, Color32, Key, Modal, Modifiers, RichText, Ui};

use crate::formats::InputError;
use crate::formats::gltf::read_meshes;
use crate::mesh::nodes::{MeshNode, nodes};
use crate::mesh::{MeshOptions, Role};

use super::App;
use super::engine::PartSource;
use super::picture::Pictures;
use super::state::Problem;
use super::theme::{self, Condition};
use super::work::OpenTask;
use choices::Choices;
use preview::{Preview, Shown};

/// Keys that give the node in work a role.
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

/// A mesh file whose nodes are to be told apart.
pub(super) struct Untold {
    path: PathBuf,
    /// What opens the part once they are.
    task: OpenTask,
    nodes: Vec<MeshNode>,
    preview: Preview,
    choices: Choices,
    fault: Option<Problem>,
}

impl Untold {
    /// Reads the nodes of the file at `path`, of which `said` is known and which did not open because of `fault`.
    /// `task` is to open its part.
    ///
    /// # Errors
    /// When the file cannot be read, or holds no triangles.
    pub(super) fn read(
        path: &Path,
        said: &MeshOptions,
        task: OpenTask,
        fault: Option<&InputError>,
    ) -> Result<Self, InputError> {
        let meshes = read_meshes(path)?;
        let nodes = nodes(&meshes);
        if nodes.is_empty() {
            let file = path.display().to_string();
            return Err(InputError::new(
                &file,
                0,
                "holds no triangles",
                "export the impeller's surfaces as meshes",
            ));
        }
        Ok(Self {
            path: path.to_owned(),
            task,
            preview: Preview::new(&meshes, &nodes),
            choices: Choices::new(&nodes, said),
            nodes,
            // The file is named above.
            fault: fault.map(|fault| Problem::new(fault.what.clone(), fault.cure.clone())),
        })
    }
}

/// The dialog, while it is open.
#[derive(Default)]
pub(super) struct RolesDialog {
    asked: Option<Untold>,
    /// Whether the part is being opened with what was chosen.
    waiting: bool,
}

impl RolesDialog {
    /// Whether it is open.
    pub(super) fn is_open(&self) -> bool {
        self.asked.is_some()
    }

    /// Asks about a file; where it is open for that file already, only the fault is new.
    pub(super) fn ask(&mut self, untold: Untold) {
        self.waiting = false;
        match &mut self.asked {
            Some(asked) if asked.path == untold.path => asked.fault = untold.fault,
            asked => *asked = Some(untold),
        }
    }

    /// Closes it.
    pub(super) fn close(&mut self) {
        *self = Self::default();
    }

    /// Goes on after opening ended otherwise.
    pub(super) fn stop_waiting(&mut self) {
        self.waiting = false;
    }

    /// Draws it; returns what is to be opened once that is agreed.
    fn show(&mut self, ui: &Ui, pictures: Option<&Pictures>) -> Option<OpenTask> {
        let asked = self.asked.as_mut()?;
        let (mut open, mut close) = (false, false);
        let waiting = self.waiting;
        let modal = Modal::new(egui::Id::unique("roles")).show(ui.ctx(), |ui| {
            ui.set_width(720.0_f32.min(ui.ctx().content_rect().width() - 40.0));
            if !waiting {
                open = asked.keys(ui);
            }
            let file = asked.path.file_name().unwrap_or_default().to_string_lossy();
            ui.label(RichText::new(format!("What is what in {file}?")).strong());
            if let Some(fault) = &asked.fault {
                let red = Condition::Interferential.text(ui.visuals());
                ui.label(RichText::new(&fault.what).color(red));
                ui.label(format!("To do: {}", asked_in_words(&fault.cure)));
            }
            ui.separator();
            ui.add_enabled_ui(!waiting, |ui| {
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| {
                        ui.set_width(PICTURE);
                        let shown = Shown {
                            roles: &asked.choices.roles,
                            axis: asked.choices.upright(&asked.nodes),
                            chosen: asked.choices.chosen,
                        };
                        asked.preview.show(ui, pictures, egui::vec2(PICTURE, PICTURE - 40.0), &shown);
                        form::file(ui, &asked.nodes, &mut asked.choices);
                    });
                    ui.vertical(|ui| {
                        form::nodes(ui, &asked.nodes, &mut asked.choices, 270.0);
                        ui.checkbox(&mut asked.choices.alike, "Nodes of one shape together").on_hover_text(
                            "A role goes to all nodes with as many triangles and the same area",
                        );
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
                close = ui.button("Leave it").clicked();
                if waiting {
                    ui.label("Opening…");
                }
            });
        });
        if close || modal.should_close() && !waiting {
            self.close();
            return None;
        }
        open.then(|| {
            self.waiting = true;
            let options = asked.choices.options(&asked.nodes);
            asked.task.clone().with_part(PartSource::Mesh(asked.path.clone(), options))
        })
    }
}

impl Untold {
    /// Does what keys ask for; `true` when the part is to be opened.
    fn keys(&mut self, ui: &Ui) -> bool {
        if ui.memory(|memory| memory.focused().is_some()) || egui::Popup::is_any_open(ui.ctx()) {
            return false;
        }
        let pressed = |key| ui.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        let (last, choices) = (self.nodes.len() - 1, &mut self.choices);
        for (key, role) in KEYS {
            if pressed(key) {
                choices.give(&self.nodes, role);
            }
        }
        let next = match (pressed(Key::ArrowDown), pressed(Key::ArrowUp)) {
            (true, _) => Some(choices.chosen.map_or(0, |k| (k + 1).min(last))),
            (_, true) => Some(choices.chosen.map_or(last, |k| k.saturating_sub(1))),
            _ => None,
        };
        if next.is_some() {
            (choices.chosen, choices.moved) = (next, true);
        }
        pressed(Key::Enter)
    }
}

/// What to do, for somebody who sees the dialog and not the command line.
pub(super) fn asked_in_words(cure: &str) -> String {
    [
        ("--role NODE=", "the role "),
        ("NODE=", ""),
        ("--rotation-axis", "the axis of rotation"),
        ("--rotation", "the sense of rotation"),
        ("--blades N", "the number of main blades"),
        ("--unit", "the unit"),
    ]
    .iter()
    .fold(cure.to_owned(), |text, (option, words)| text.replace(option, words))
}

impl App {
    /// Asks which node of the open part's mesh file is what.
    pub(super) fn assign_roles(&mut self) {
        let source = self.state.document.part.as_ref().map(|part| part.source.clone());
        if let Some(source) = source.filter(|source| source.mesh().is_some()) {
            self.submit_open(OpenTask::Nodes(source));
        }
    }

    /// Draws the dialog.
    pub(super) fn ask_roles(&mut self, ui: &Ui) {
        let mut dialog = std::mem::take(&mut self.roles);
        let task = dialog.show(ui, self.pictures.as_ref());
        self.roles = dialog;
        if let Some(task) = task {
            self.submit_open(task);
        }
    }

    /// Whether the open part is of a mesh file.
    pub(super) fn is_mesh(&self) -> bool {
        self.state.document.part.as_ref().is_some_and(|part| part.source.mesh().is_some())
    }

    /// Whether `path` is the file of the open part.
    pub(super) fn is_of_open_part(&self, path: &Path) -> bool {
        let part = self.state.document.part.as_ref();
        part.and_then(|part| part.source.file()).is_some_and(|(own, _)| own == path)
    }
}
