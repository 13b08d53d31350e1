//! The menu, and what each command does.

use egui::{Context, MenuBar, Ui, ViewportCommand};

use crate::gpu::view::View;

use super::App;
use super::command::Command;
use super::dialogs::Purpose;

impl App {
    /// Draws the menu bar.
    pub(super) fn menu(&mut self, ui: &mut Ui) {
        let mut chosen = None;
        MenuBar::new().ui(ui, |ui| {
            let mut items = |ui: &mut Ui, name: &str, commands: &[Option<Command>]| {
                ui.menu_button(name, |ui| {
                    for command in commands {
                        match command {
                            Some(command) if command.menu_item(ui, self.can(*command)) => {
                                chosen = Some(*command)
                            }
                            Some(_) => {}
                            None => {
                                ui.separator();
                            }
                        }
                    }
                });
            };
            use Command::{
                Cancel, ExportCl, NextFault, NextPosition, OpenPart, OpenSetup, Plan, PreviousFault,
                PreviousPosition, Quit, Redo, SavePicture, SaveSetup, Undo,
            };
            items(
                ui,
                "File",
                &[
                    Some(OpenPart),
                    Some(OpenSetup),
                    None,
                    Some(SaveSetup),
                    Some(ExportCl),
                    Some(SavePicture),
                    None,
                    Some(Quit),
                ],
            );
            items(ui, "Edit", &[Some(Undo), Some(Redo)]);
            items(
                ui,
                "Plan",
                &[
                    Some(Plan),
                    Some(Cancel),
                    None,
                    Some(NextFault),
                    Some(PreviousFault),
                    Some(NextPosition),
                    Some(PreviousPosition),
                ],
            );
            if let Some(command) = self.view_menu(ui) {
                chosen = Some(command);
            }
        });
        if let Some(command) = chosen {
            self.obey(ui.ctx(), command);
        }
    }

    fn view_menu(&mut self, ui: &mut Ui) -> Option<Command> {
        let mut chosen = None;
        ui.menu_button("View", |ui| {
            use Command::{
                Axes, BeforeAfter, Blades, Cutters, Fit, Hub, Perspective, Shroud, SwitchTheme, ViewChannel,
                ViewFront, ViewIso, ViewSection, ViewTop,
            };
            let views =
                [BeforeAfter, Fit, ViewIso, ViewFront, ViewTop, ViewChannel, ViewSection, Perspective];
            for command in views {
                if command.menu_item(ui, self.can(command)) {
                    chosen = Some(command);
                }
            }
            ui.separator();
            let layers = self.state.layers;
            for (command, mut on) in [
                (Hub, layers.hub),
                (Blades, layers.blades),
                (Shroud, layers.shroud),
                (Cutters, layers.cutters),
                (Axes, layers.axes),
            ] {
                if ui.checkbox(&mut on, command.label()).on_hover_text(command.tip()).clicked() {
                    chosen = Some(command);
                }
            }
            ui.separator();
            if SwitchTheme.menu_item(ui, true) {
                chosen = Some(SwitchTheme);
            }
        });
        chosen
    }

    /// Whether a command makes sense now.
    pub(super) fn can(&self, command: Command) -> bool {
        use Command::{
            BeforeAfter, Cancel, ExportCl, Fit, NextFault, NextPosition, Perspective, Plan, PreviousFault,
            PreviousPosition, Redo, SavePicture, SaveSetup, Undo, ViewChannel, ViewFront, ViewIso,
            ViewSection, ViewTop,
        };
        match command {
            SaveSetup | Plan | Fit | ViewIso | ViewFront | ViewTop | ViewChannel | Perspective => {
                self.state.part.is_some()
            }
            SavePicture => self.state.part.is_some() && self.picture.is_some(),
            ExportCl | BeforeAfter | NextPosition | PreviousPosition | NextFault | PreviousFault
            | ViewSection => self.state.planned.is_some(),
            Cancel => self.work.running().is_some(),
            Undo => self.undoer.has_undo(&self.state.setup),
            Redo => self.undoer.has_redo(&self.state.setup),
            _ => true,
        }
    }

    /// Does a command.
    pub(super) fn obey(&mut self, ctx: &Context, command: Command) {
        let layers = &mut self.state.layers;
        match command {
            Command::OpenPart => self.dialogs.ask(ctx, Purpose::OpenPart, String::new()),
            Command::OpenSetup => self.dialogs.ask(ctx, Purpose::OpenSetup, String::new()),
            Command::SaveSetup => self.dialogs.ask(ctx, Purpose::SaveSetup, self.suggest("setup.toml")),
            Command::ExportCl => self.dialogs.ask(ctx, Purpose::ExportCl, self.suggest("plunge.apt")),
            Command::SavePicture => self.dialogs.ask(ctx, Purpose::SavePicture, self.suggest("picture.png")),
            Command::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
            Command::Undo => {
                if let Some(setup) = self.undoer.undo(&self.state.setup) {
                    self.state.setup = setup.clone();
                }
            }
            Command::Redo => {
                if let Some(setup) = self.undoer.redo(&self.state.setup) {
                    self.state.setup = setup.clone();
                }
            }
            Command::Plan => self.plan(),
            Command::Cancel => self.cancel(),
            Command::NextFault => self.state.step_selection(1, true),
            Command::PreviousFault => self.state.step_selection(-1, true),
            Command::NextPosition => self.state.step_selection(1, false),
            Command::PreviousPosition => self.state.step_selection(-1, false),
            Command::BeforeAfter => self.show_side(self.state.side.other()),
            Command::Fit => {
                if let Some(framing) = self.picture.as_ref().and_then(|picture| picture.framing()) {
                    self.view.fit(framing);
                }
            }
            Command::ViewIso => self.view.look(View::Iso),
            Command::ViewFront => self.view.look(View::Front),
            Command::ViewTop => self.view.look(View::Top),
            Command::ViewChannel => self.view.look(View::Channel),
            Command::ViewSection => self.view.look(View::Section(self.section_in_work() + 1)),
            Command::Perspective => self.view.switch_projection(),
            Command::Hub => layers.hub ^= true,
            Command::Blades => layers.blades ^= true,
            Command::Shroud => layers.shroud ^= true,
            Command::Cutters => layers.cutters ^= true,
            Command::Axes => layers.axes ^= true,
            Command::SwitchTheme => {
                let dark = ctx.theme() == egui::Theme::Dark;
                ctx.set_theme(if dark { egui::Theme::Light } else { egui::Theme::Dark });
            }
        }
        ctx.request_repaint();
    }

    /// Name offered where something of the part is saved.
    fn suggest(&self, ending: &str) -> String {
        match &self.state.part {
            Some(part) => format!("{}_{ending}", part.impeller.name),
            None => ending.to_owned(),
        }
    }

    /// Section of the selected position, else the first.
    fn section_in_work(&self) -> usize {
        let plan = self.state.planned.as_ref().map(|planned| planned.plan(self.state.side));
        let position = plan.zip(self.state.selected).and_then(|(plan, k)| plan.positions.get(k));
        position.map_or(0, |position| position.section)
    }
}
