//! The menu bar.

use std::path::PathBuf;

use egui::containers::menu::MenuConfig;
use egui::{MenuBar, RichText, Ui};

use super::command::Command;
use super::dock::{PanelRequest, panel_menu};
use super::long_menu::long_content;
use super::overlay;
use super::panels::part::name_in_list;
use crate::app::App;
use crate::app::control::unsaved::Pending;
use crate::app::model::panels::DockPanel;
use crate::app::views::theme;

/// The menus: groups of commands, with separators between the groups.
const MENUS: [(&str, &[&[Command]]); 3] = [
    (
        "File",
        &[
            &[
                Command::NewProject,
                Command::OpenProject,
                Command::OpenPart,
                Command::AssignRoles,
                Command::OpenSetup,
                Command::OpenBlank,
                Command::OpenStudy,
            ],
            &[Command::ToolLibrary],
            &[Command::CheckProgram, Command::CheckAgain, Command::CloseProgram],
            &[Command::SaveProject, Command::SaveProjectAs],
            &[
                Command::SaveSetup,
                Command::ExportCl,
                Command::ExportClSome,
                Command::ExportClAll,
                Command::ExportFlank,
                Command::ExportNc,
                Command::ExportSheet,
                Command::ExportScene,
                Command::ExportStock,
                Command::SavePicture,
            ],
            &[Command::Quit],
        ],
    ),
    ("Edit", &[&[Command::Undo, Command::Redo], &[Command::KeepSet], EDITS, &[Command::Palette]]),
    (
        "Plan",
        &[
            &[Command::Assess, Command::TimeAgainstStock, Command::StudyResults],
            &[Command::Plan, Command::PlanFlank, Command::Cancel, Command::FollowEdits],
            &[
                Command::NextFault,
                Command::PreviousFault,
                Command::NextRow,
                Command::PreviousRow,
                Command::Deselect,
            ],
            &[
                Command::Play,
                Command::StepForward,
                Command::StepBack,
                Command::LeapForward,
                Command::LeapBack,
            ],
            &[
                Command::NextTool,
                Command::PreviousTool,
                Command::NextSection,
                Command::PreviousSection,
                Command::ToBlank,
                Command::ToEnd,
            ],
        ],
    ),
];

/// Edits of the selected plunge and its row.
const EDITS: &[Command] = &[
    Command::EditPlunge,
    Command::DeletePlunge,
    Command::LockPlunge,
    Command::CutEarlier,
    Command::CutLater,
    Command::DeleteRow,
    Command::LockRow,
    Command::CutRowEarlier,
    Command::CutRowLater,
];

/// Groups of the View menu; the layers follow them.
const VIEWS: &[&[Command]] = &[
    &[Command::BeforeAfter, Command::SideBySide, Command::Wipe, Command::Difference],
    &[
        Command::Fit,
        Command::FlyToSelection,
        Command::ViewIso,
        Command::ViewFront,
        Command::ViewTop,
        Command::ViewChannel,
        Command::ViewSection,
        Command::Perspective,
    ],
    &[Command::SectionPlane, Command::Measure, Command::Plots, Command::FlankCurves],
    &[Command::SwitchTheme],
];

/// Groups of the Help menu.
const HELP: &[&[Command]] =
    &[&[Command::ShowTour, Command::ShowShortcuts, Command::ShowGlossary], &[Command::ShowAbout]];

/// A menu that scrolls where the window is too low for it.
fn long_menu(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    let bar = ui.max_rect().bottom();
    ui.menu_button(name, |ui| long_content(ui, name, bar, content));
}

/// The menu of the size of texts, with the present one in percent of the usual; returns what was chosen.
fn text_size_menu(ui: &mut Ui) -> Option<Command> {
    ui.label(RichText::new(format!("{:.0} %", 100.0 * ui.ctx().zoom_factor())).weak());
    let sizes = [Command::TextLarger, Command::TextSmaller, Command::TextUsual];
    sizes.into_iter().filter(|size| size.menu_item(ui, true)).last()
}

impl App {
    /// Draws the menu bar.
    pub(in crate::app) fn menu(&mut self, ui: &mut Ui) {
        let (mut chosen, mut recent, mut changed) = (None, None, None);
        let menus = MenuConfig::new().style(theme::menu_style);
        MenuBar::new().config(menus).style(theme::menu_style).ui(ui, |ui| {
            for (name, groups) in MENUS {
                long_menu(ui, name, |ui| {
                    // The recent files stand below the commands that open others.
                    let first = usize::from(name == "File" && !self.state.recents.is_empty());
                    chosen = self.menu_groups(ui, &groups[..first]).or(chosen);
                    if first > 0 {
                        recent = self.recent_menu(ui).or(recent.take());
                        ui.separator();
                    }
                    chosen = self.menu_groups(ui, &groups[first..]).or(chosen);
                });
            }
            long_menu(ui, "View", |ui| {
                if let Some(command) = self.menu_groups(ui, VIEWS) {
                    chosen = Some(command);
                }
                ui.menu_button("Panels", |ui| changed = self.panels_menu(ui));
                ui.menu_button("Mouse", |ui| {
                    let command = overlay::mouse_choice(ui, self.state.look.mouse);
                    chosen = command.or(chosen);
                });
                let size = ui.menu_button("Text size", text_size_menu).inner.flatten();
                chosen = size.or(chosen);
                ui.menu_button("Units", |ui| {
                    let command = overlay::unit_choice(ui, self.state.look.units);
                    chosen = command.or(chosen);
                });
                ui.separator();
                theme::draw_box_edges(ui);
                self.layer_switches(ui);
            });
            ui.menu_button("Help", |ui| {
                if let Some(command) = self.menu_groups(ui, HELP) {
                    chosen = Some(command);
                }
            });
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let search = ui.button(Command::Palette.label());
                if search.on_hover_text(Command::Palette.tip_with_keys(ui.ctx())).clicked() {
                    chosen = Some(Command::Palette);
                }
                let document = &self.state.document;
                if document.part.is_some() {
                    let name = document.path.as_ref().and_then(|path| path.file_stem());
                    let name = name.map_or_else(|| "not saved yet".into(), |name| name.to_string_lossy());
                    let mark = if document.is_unsaved() { " •" } else { "" };
                    let label = ui.label(RichText::new(format!("{name}{mark}")).weak());
                    label.on_hover_text(if mark.is_empty() {
                        "Everything is saved"
                    } else {
                        "There are unsaved changes"
                    });
                }
            });
        });
        if let Some(command) = chosen {
            self.run_command(ui.ctx(), command);
        }
        if let Some((panel, request)) = changed {
            self.change_panel(ui.ctx(), panel, request);
        }
        if let Some(path) = recent {
            self.run_guarded(ui.ctx(), Pending::Open(path));
        }
    }

    /// The menu of the recent projects and parts; returns the one that was chosen.
    fn recent_menu(&self, ui: &mut Ui) -> Option<PathBuf> {
        let menu = ui.menu_button("Open recent", |ui| {
            let mut chosen = None;
            for path in &self.state.recents {
                let name = name_in_list(path, &self.state.recents);
                if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                    chosen = Some(path.clone());
                    ui.close();
                }
            }
            chosen
        });
        menu.inner.flatten()
    }

    /// The menu of the panels: which are shown, and where; returns what was chosen for one.
    fn panels_menu(&mut self, ui: &mut Ui) -> Option<(DockPanel, PanelRequest)> {
        let mut changed = None;
        ui.scope(|ui| {
            theme::draw_box_edges(ui);
            for panel in DockPanel::ALL.into_iter().filter(|panel| panel.can_leave()) {
                let mut is_open = self.state.look.panels.is_open(panel);
                let item = ui.checkbox(&mut is_open, panel.title()).on_hover_text(panel.tip());
                if item.changed() {
                    self.switch_panel(ui.ctx(), panel);
                }
            }
        });
        ui.separator();
        ui.menu_button("Arrange", |ui| {
            for panel in DockPanel::ALL {
                ui.menu_button(panel.title(), |ui| {
                    let is_floating = self.state.look.panels.floats(panel);
                    let request = panel_menu(ui, panel, is_floating);
                    changed = request.map(|request| (panel, request)).or(changed);
                });
            }
        });
        ui.separator();
        if Command::ResetLayout.menu_item(ui, true) {
            self.state.look.panels.reset();
        }
        changed
    }

    fn menu_groups(&self, ui: &mut Ui, groups: &[&[Command]]) -> Option<Command> {
        let mut chosen = None;
        for (k, group) in groups.iter().enumerate() {
            if k > 0 {
                ui.separator();
            }
            for &command in *group {
                let clicked = match command {
                    Command::FollowEdits => command.menu_switch(ui, self.state.auto_update),
                    _ => command.menu_item(ui, self.is_available(command)),
                };
                chosen = clicked.then_some(command).or(chosen);
            }
        }
        chosen
    }
}
