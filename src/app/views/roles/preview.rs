//! The picture of a mesh file in the roles dialog: nodes are drawn by role, the selected one is highlighted.

use egui::{Color32, Rect, Sense, Ui, Vec2};

use crate::gpu::camera::Camera;
use crate::gpu::mesh::Mesh;
use crate::gpu::part_mesh::PartMesh;
use crate::gpu::scene::{FloorColours, SceneOptions};
use crate::gpu::{CutterFilter, Theme, View};
use crate::mesh::Role;
use crate::mesh::axis::Axis;

use crate::app::views::picture::SidePicture;
use crate::app::views::pictures::Pictures;

/// Zoom exponent per point of scrolling.
const ZOOM: f32 = 0.0025;

/// Inputs of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewInput<'a> {
    /// Roles of the nodes.
    pub roles: &'a [Option<Role>],
    /// Axis of rotation in the file; it is drawn vertical.
    pub axis: Axis,
    /// Index of the highlighted node.
    pub chosen: Option<usize>,
}

/// The picture with its meshes and camera.
#[derive(Default)]
pub struct RolesPreview {
    /// Mesh of each node, in the file's axes, centred and scaled.
    meshes: Vec<Mesh>,
    picture: Option<SidePicture>,
    camera: Option<Camera>,
    /// Roles and axis for which the picture was made.
    made_for: Option<(Vec<Option<Role>>, Axis)>,
    lit: Option<usize>,
}

/// Rotates a direction of the file so that its axis of rotation becomes Z.
fn rotate_to_z(axis: Axis, [x, y, z]: [f32; 3]) -> [f32; 3] {
    match axis {
        Axis::X => [y, z, x],
        Axis::Y => [x, -z, y],
        Axis::Z => [x, y, z],
    }
}

impl RolesPreview {
    /// A picture of the meshes of the nodes of a file; see [`crate::app::tasks::mesh_nodes`].
    pub fn new(meshes: Vec<Mesh>) -> Self {
        Self { meshes, ..Self::default() }
    }

    /// The nodes for which `wanted` holds as one mesh, with the axis vertical.
    fn join_nodes(&self, axis: Axis, wanted: impl Fn(usize) -> bool) -> Mesh {
        let mut all = Mesh::default();
        for (_, mesh) in self.meshes.iter().enumerate().filter(|(k, _)| wanted(*k)) {
            all.append(mesh);
        }
        for vertex in &mut all.vertices {
            vertex.position = rotate_to_z(axis, vertex.position);
            vertex.normal = rotate_to_z(axis, vertex.normal);
        }
        all
    }

    fn rebuild(&mut self, pictures: &Pictures, shown: &PreviewInput<'_>, aspect: f32) {
        let of = |role: &[Option<Role>]| self.join_nodes(shown.axis, |k| role.contains(&shown.roles[k]));
        let blades = of(&[Some(Role::Blade), Some(Role::Splitter)]);
        // Nodes without a role are drawn too; only ignored ones are not.
        let mesh = PartMesh::from_roles(of(&[Some(Role::Hub), None]), blades, of(&[Some(Role::Shroud)]));
        let picture = pictures.picture_of_mesh(mesh);
        let axis_changed = self.made_for.as_ref().is_none_or(|(_, axis)| *axis != shown.axis);
        if axis_changed || self.camera.is_none() {
            self.camera = Some(Camera::standard(View::Iso, picture.framing(), aspect));
        }
        self.picture = Some(picture);
        self.made_for = Some((shown.roles.to_vec(), shown.axis));
        self.lit = None;
    }

    /// Draws the picture of `size` points; the mouse orbits and zooms it.
    pub fn show(&mut self, ui: &mut Ui, pictures: Option<&Pictures>, size: Vec2, shown: &PreviewInput<'_>) {
        let (rect, response) = ui.allocate_exact_size(size, Sense::drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Picture of the nodes"));
        let Some(pictures) = pictures else {
            ui.painter().text(
                rect.center(),
                egui::Align2::CENTER_CENTER,
                "no 3D view on this device",
                egui::FontId::default(),
                ui.visuals().weak_text_color(),
            );
            return;
        };
        if self
            .made_for
            .as_ref()
            .is_none_or(|(roles, axis)| (roles.as_slice(), *axis) != (shown.roles, shown.axis))
        {
            self.rebuild(pictures, shown, size.x / size.y);
        }
        if self.lit != shown.chosen {
            let lit = shown.chosen.map(|chosen| self.join_nodes(shown.axis, |k| k == chosen));
            if let Some(picture) = &mut self.picture {
                picture.highlight(lit);
            }
            self.lit = shown.chosen;
        }
        let (Some(picture), Some(camera)) = (&mut self.picture, &mut self.camera) else { return };
        if response.dragged() {
            let d = response.drag_delta();
            camera.orbit(glam::vec2(d.x, d.y), picture.framing().wheel.center);
        }
        if response.hovered() {
            let factor = (-ZOOM * ui.input(|i| i.smooth_scroll_delta.y)).exp();
            camera.zoom(factor, picture.framing().wheel.center);
        }
        let dark = ui.visuals().dark_mode;
        let options = SceneOptions {
            show_shroud: true,
            show_cutters: CutterFilter::Hidden,
            show_floor_colours: FloorColours::Values,
            range_mm: (0.0, 1.0),
            cut_away: false,
            theme: if dark { Theme::Dark } else { Theme::Light },
            pixel_scale: ui.pixels_per_point(),
            ..SceneOptions::default()
        };
        let pixels = (size * ui.pixels_per_point()).round();
        if let Some(texture) =
            picture.show(*camera, options, [pixels.x as u32, pixels.y as u32], response.dragged())
        {
            let all = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter().image(texture, rect, all, Color32::WHITE);
        }
    }
}
