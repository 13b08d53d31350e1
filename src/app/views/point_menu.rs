//! The context menu of a 3D view.

use egui::{Popup, Ui};

use crate::gpu::camera::Camera;

use crate::app::App;
use crate::app::views::command::Command;
use crate::app::views::overlay;
use crate::app::views::panels::positions::{is_for_position, position_menu};
use crate::app::views::view3d::view_point;
use crate::app::views::viewport::Pane;

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
    /// Opens the context menu at a right click, and runs the chosen command on the position under it, which
    /// is selected only then. A drag with the right button is not a click.
    pub(in crate::app) fn point_menu(&mut self, panes: &[Pane], camera: &Camera) {
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
            self.context_hit = Some((pane.side, hit));
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
            let ctx = pane.response.ctx.clone();
            let hit = self.context_hit;
            match hit.and_then(|(side, hit)| Some((side, hit.position?))) {
                Some((side, k)) if is_for_position(command) => {
                    if self.state.look.side != side {
                        self.state.show(side);
                    }
                    self.run_for_position(&ctx, Some((command, k)));
                }
                _ => self.run_command(&ctx, command),
            }
        }
        if !open {
            self.context_hit = None;
        }
    }

    /// Runs a command from the context menu of a position on that position.
    pub(in crate::app) fn run_for_position(&mut self, ctx: &egui::Context, chosen: Option<(Command, usize)>) {
        if let Some((command, k)) = chosen {
            self.state.look.select(Some(k));
            self.run_command(ctx, command);
        }
    }

    fn menu_here(&mut self, ui: &mut Ui) -> Option<Command> {
        let position = self.context_hit.and_then(|(side, hit)| Some((side, hit.position?)));
        let of_position = position.and_then(|(side, k)| {
            let can_edit = side == self.state.look.side && self.state.editable_plan().is_some();
            position_menu(ui, k, can_edit)
        });
        let mut chosen = None;
        let mut item = |ui: &mut Ui, command: Command, can: bool| {
            if command.menu_item(ui, can) {
                chosen = Some(command);
            }
        };
        item(ui, Command::MeasureHere, self.is_available(Command::MeasureHere));
        ui.separator();
        for command in VIEWS {
            item(ui, command, self.is_available(command));
        }
        ui.separator();
        ui.menu_button("Layers", |ui| self.layer_switches(ui));
        of_position.or(chosen)
    }

    /// The switches of the layers.
    pub(in crate::app) fn layer_switches(&mut self, ui: &mut Ui) {
        let mut layers = self.state.look.layers;
        overlay::switch_rows(ui, &mut layers, |layer| self.is_available(layer));
        self.state.look.layers = layers;
    }

    /// Start of a measurement: the right-clicked point, else the tip of the selected position, mm.
    pub(in crate::app) fn measure_start(&self) -> Option<glam::Vec3> {
        let tip =
            || self.state.selected_in_channel().map(|(p, _)| glam::vec3(p.x as f32, p.y as f32, p.z as f32));
        self.context_hit.and_then(|(_, hit)| hit.point).or_else(tip)
    }
}
