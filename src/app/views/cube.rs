//! The view cube: shows the orientation of the wheel; a click on a face looks from that side.

use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, Ui};
use glam::Vec3;

use crate::gpu::camera::Camera;

use crate::app::views::theme;

/// Faces: outward normal, letter, name. "Top" is the side of the inlet, which [`Camera::up_sign`] keeps
/// upward.
const FACES: [(Vec3, &str, &str); 6] = [
    (Vec3::X, "X", "View from +X"),
    (Vec3::NEG_X, "−X", "View from −X"),
    (Vec3::Y, "Y", "View from +Y"),
    (Vec3::NEG_Y, "−Y", "View from −Y"),
    (Vec3::Z, "Z", "View from +Z"),
    (Vec3::NEG_Z, "−Z", "View from −Z"),
];
/// Smallest height of the view in which the cube fits between its buttons, points.
pub const MIN_VIEW_HEIGHT: f32 = 230.0;
/// Half an edge, points.
const HALF: f32 = 19.0;
/// Cosine between face normal and view direction below which a face is neither drawn nor clickable.
const MIN_FACING: f32 = 0.12;

/// Draws the cube around `center`; returns the direction to look from when a face was clicked.
pub fn show(ui: &mut Ui, center: Pos2, camera: &Camera) -> Option<Vec3> {
    let (right, up, back) = camera.basis();
    let place = |p: Vec3| center + egui::vec2(p.dot(right), -p.dot(up)) * HALF;
    let mut chosen = None;
    let mut faces: Vec<(f32, (Vec3, &str, &str))> =
        FACES.iter().map(|&face| (face.0.dot(back), face)).collect();
    faces.retain(|(facing, _)| *facing > MIN_FACING);
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (facing, (normal, letter, name)) in faces {
        // Edges run along the other two axes.
        let u = Vec3::new(normal.y, normal.z, normal.x);
        let v = normal.cross(u);
        let corners: Vec<Pos2> = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(a, b)| place(normal + u * a + v * b))
            .into();
        let middle = place(normal);
        let size = 2.0 * HALF * facing.sqrt() * 0.8;
        let response = ui.interact(
            Rect::from_center_size(middle, egui::Vec2::splat(size.max(10.0))),
            ui.scope_id().with(name),
            Sense::click(),
        );
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
        let visuals = ui.visuals();
        let base = if visuals.dark_mode { 70.0 } else { 190.0 };
        let lit = (base + 50.0 * facing) as u8;
        let fill = if response.hovered() || response.has_focus() {
            theme::accent(visuals)
        } else {
            Color32::from_gray(lit)
        };
        let edge = Stroke::new(1.0, visuals.widgets.noninteractive.fg_stroke.color.gamma_multiply(0.6));
        ui.painter().add(egui::Shape::convex_polygon(corners, fill, edge));
        let ink = visuals.strong_text_color();
        ui.painter().text(middle, Align2::CENTER_CENTER, letter, FontId::proportional(11.0), ink);
        if response.on_hover_text(name).clicked() {
            chosen = Some(normal);
        }
    }
    chosen
}
