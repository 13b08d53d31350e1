//! The context menu of a 3D view.

use egui::{Popup, Ui};

use crate::gpu::camera::Camera;

use super::App;
use super::command::Command;
use super::overlay;
use super::view3d::view_point;
use super::viewport::Pane;

/// Commands for the position under the pointer.
const WITH_POSITION: [Command; 4] =
    [Command::ShowInTable, Command::OpenSection, Command::ScrubHere, Command::FlyToSelection];
/// Commands that do not need a position.
const VIEWS: [Command; 7] = [
    Command::Fit,
    Command::ViewIso,
    Command::ViewFront,
    Command::ViewTop,
    Command::ViewChannel,
    Command::ViewSection,
    Command::SectionPlane,
];

impl App {
    /// Opens the context menu at a right click, selects the position under it, and runs the chosen command. A
    /// drag with the right button is not a click.
    pub(super) fn point_menu(&mut self, panes: &[Pane], camera: &Camera) {
        let clicked = panes.iter().find_map(|pane| {
            let at = pane.response.interact_pointer_pos().filter(|_| pane.response.secondary_clicked())?;
            pane.visible.contains(at).then_some((pane, at))
        });
        if let Some((pane, at)) = clicked {
            let options = self.options(pane.side);
            let picture = self.pictures.as_mut().and_then(|pictures| pictures.side(pane.side));
            let hit = picture
                .map(|picture| picture.hit(camera, &options, view_point(pane.rect, at), pane.rect.size()));
            let hit = hit.unwrap_or_default();
            if self.state.look.side != pane.side {
                self.state.show(pane.side);
            }
            // The menu's commands act on the selected position.
            if hit.position.is_some() {
                self.state.look.select(hit.position);
            }
            self.context_hit = Some(hit);
        }
        let (mut chosen, mut open) = (None, false);
        let mut last = None;
        for pane in panes {
            // Both halves of a wipe share one area.
            if last.replace(pane.response.id) == Some(pane.response.id) {
                continue;
            }
            if let Some(menu) = Popup::context_menu(&pane.response).show(|ui| self.menu_here(ui)) {
                (chosen, open) = (menu.inner, true);
            }
        }
        if let Some(command) = chosen
            && let Some(pane) = panes.first()
        {
            self.run_command(&pane.response.ctx, command);
        }
        if !open {
            self.context_hit = None;
        }
    }

    fn menu_here(&mut self, ui: &mut Ui) -> Option<Command> {
        let mut chosen = None;
        let mut item = |ui: &mut Ui, command: Command, can: bool| {
            if command.menu_item(ui, can) {
                chosen = Some(command);
            }
        };
        if let Some(k) = self.context_hit.and_then(|hit| hit.position) {
            ui.label(egui::RichText::new(format!("Position {}", k + 1)).strong());
            for command in WITH_POSITION {
                item(ui, command, self.is_available(command));
            }
        }
        item(ui, Command::MeasureHere, self.is_available(Command::MeasureHere));
        ui.separator();
        for command in VIEWS {
            item(ui, command, self.is_available(command));
        }
        ui.separator();
        ui.menu_button("Layers", |ui| {
            for (shown, command) in overlay::switches(&mut self.state.look.layers) {
                ui.checkbox(shown, command.label()).on_hover_text(command.tip());
            }
        });
        chosen
    }

    /// Start of a measurement: the right-clicked point, else the tip of the selected position, mm.
    pub(super) fn measure_start(&self) -> Option<glam::Vec3> {
        let tip =
            || self.state.selected().map(|p| glam::vec3(p.tip.x as f32, p.tip.y as f32, p.tip.z as f32));
        self.context_hit.and_then(|hit| hit.point).or_else(tip)
    }
}
