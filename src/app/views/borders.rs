//! Borders between sections: lines across the channel floor in the 3D view, each with a handle to drag along
//! the hub.

use egui::{CursorIcon, Pos2, Rect, Sense, Stroke, Ui, Vec2};
use glam::Vec3;

use crate::gpu::camera::Camera;
use crate::gpu::mesh::Segment;
use crate::setup::{SectionKind, SectionSetup};

use crate::app::App;
use crate::app::views::panels::tools;
use crate::app::views::theme;
use crate::app::views::viewport::Pane;

/// Number of s values that a drag compares.
const STEPS: usize = 200;
/// Size of a drag handle, points.
const HANDLE_SIZE: f32 = 16.0;

impl App {
    /// Draws the borders with their handles. A drag is one undo step; it copies tools and sections that the
    /// program chose into the setup.
    pub(in crate::app) fn section_borders(&mut self, ui: &mut Ui, panes: &[Pane], camera: &Camera) {
        self.is_dragging_border = false;
        let chosen = self.state.results.planned.as_ref().map(|planned| planned.outcome.setup.clone());
        let sections = self.sections_with_borders();
        for (k, next) in borders_of(&sections) {
            for pane in panes {
                let Some((grip, line)) = self.border_line(pane, camera, sections[k].to) else { continue };
                if !pane.visible.shrink(HANDLE_SIZE).contains(grip) {
                    continue;
                }
                let at = Rect::from_center_size(grip, Vec2::splat(HANDLE_SIZE));
                let id = pane.response.id.with(("border", k, pane.side as usize));
                let response = ui.interact(at, id, Sense::drag());
                let name = format!("Border {} | {} in the view", k + 1, next + 1);
                let s = sections[k].to;
                response.widget_info(|| egui::WidgetInfo::slider(true, s, &name));
                let held = response.dragged() || response.hovered();
                let colour = theme::accent(ui.visuals());
                let painter = ui.painter_at(pane.visible);
                // The renderer draws the visible parts of the line; the dashes hint at the hidden parts.
                if held {
                    painter.line(line, Stroke::new(3.0, colour));
                } else {
                    let faint = Stroke::new(1.2, colour.gamma_multiply(0.75));
                    painter.extend(egui::Shape::dashed_line(&line, faint, 5.0, 4.0));
                }
                painter.circle(grip, 0.35 * HANDLE_SIZE, colour, Stroke::new(1.5, egui::Color32::WHITE));
                if response.drag_started() {
                    self.state.document.step();
                    if let Some(chosen) = chosen.as_ref().filter(|_| own_is_empty(&self.state)) {
                        tools::copy_sections(&mut self.state.document.edited.setup, chosen);
                    }
                }
                if let Some(to) = response.interact_pointer_pos().filter(|_| response.dragged()) {
                    self.is_dragging_border = true;
                    if let Some(s) = self.nearest_border_s(pane, camera, &sections, k, to) {
                        tools::move_border(&mut self.state.document.edited.setup.plunge.sections, k, s);
                    }
                }
                if response.drag_stopped() {
                    self.state.document.step();
                }
                response.on_hover_and_drag_cursor(CursorIcon::Grab).on_hover_text(format!(
                    "Border of sections {} and {} at s {s:.3}; drag to move it",
                    k + 1,
                    next + 1
                ));
            }
        }
    }

    /// Sections of the setup, or of the plan where the setup has none; empty while the hub is hidden.
    fn sections_with_borders(&self) -> Vec<SectionSetup> {
        if !self.state.look.layers.hub {
            return Vec::new();
        }
        let own = &self.state.document.edited.setup.plunge.sections;
        match &self.state.results.planned {
            Some(planned) if own.is_empty() => planned.outcome.setup.plunge.sections.clone(),
            _ => own.clone(),
        }
    }

    /// The borders as line segments of the 3D scene, with depth test.
    pub(in crate::app) fn border_segments(&self, visuals: &egui::Visuals) -> Vec<Segment> {
        let Some(pictures) = &self.pictures else { return Vec::new() };
        let sections = self.sections_with_borders();
        let colour = theme::accent(visuals).to_normalized_gamma_f32();
        let colour = [colour[0], colour[1], colour[2]];
        let lines = borders_of(&sections).filter_map(|(k, _)| pictures.floor_line(sections[k].to));
        let segment = |pair: &[(Vec3, Vec3)]| {
            Segment::coloured(pair[0].0.to_array(), pair[1].0.to_array(), 2.0, colour).on_part()
        };
        lines.flat_map(|line| line.windows(2).map(segment).collect::<Vec<_>>()).collect()
    }

    /// The line across the floor at `s` on the screen, with its midpoint; `None` where the floor there faces
    /// away.
    fn border_line(&self, pane: &Pane, camera: &Camera, s: f64) -> Option<(Pos2, Vec<Pos2>)> {
        let points = self.pictures.as_ref()?.floor_line(s)?;
        let place = |p: Vec3| {
            let pixel = camera.project(p, glam::vec2(pane.rect.width(), pane.rect.height()))?;
            Some(pane.rect.min + egui::vec2(pixel.x, pixel.y))
        };
        let (middle, normal) = points[points.len() / 2];
        if normal.dot(camera.eye() - middle) <= 0.0 {
            return None;
        }
        Some((place(middle)?, points.iter().filter_map(|&(p, _)| place(p)).collect()))
    }

    /// Value of s within the range of border `k` whose line midpoint is nearest to the pointer.
    fn nearest_border_s(
        &self,
        pane: &Pane,
        camera: &Camera,
        sections: &[SectionSetup],
        k: usize,
        to: Pos2,
    ) -> Option<f64> {
        let range = tools::border_range(sections, k);
        let at = |i: usize| range.start() + (range.end() - range.start()) * i as f64 / STEPS as f64;
        let far = |s: f64| Some(self.border_line(pane, camera, s)?.0.distance(to));
        let near = (0..=STEPS).map(at).filter_map(|s| Some((far(s)?, s)));
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, s)| (s * 1e3).round() / 1e3)
    }
}

/// The borders between sections, as the indices of both. Rest milling has no handles: its sections lie over
/// the others, and their handles would lie on those of the others.
fn borders_of(sections: &[SectionSetup]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let cut = (0..sections.len()).filter(|&k| sections[k].kind == SectionKind::Rows);
    cut.filter_map(|k| Some((k, tools::adjoining(sections, k)?)))
}

fn own_is_empty(state: &crate::app::model::state::AppState) -> bool {
    state.document.edited.setup.plunge.sections.is_empty()
}
