//! The per-picture uniform of the scene shader.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, UVec2, Vec2, Vec3};

use super::camera::{Camera, Projection};
use super::mesh::LineColour;
use super::scene::{FloorColours, SceneOptions};
use super::view::ViewTargets;
use crate::palette::{self, Rgb, TABLE_LEN};
use crate::stock::surface::UNCUT_TOLERANCE;

/// Uniform of `shaders/scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct FrameUniform {
    clip_from_world: [[f32; 4]; 4],
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    back: [f32; 4],
    viewport: [f32; 4],
    range: [f32; 4],
    look: [f32; 4],
    plane: [f32; 4],
    greys: [[f32; 4]; 9],
    lines: [[f32; 4]; 8],
    states: [[f32; 4]; 5],
    table: [[f32; 4]; TABLE_LEN],
}

impl FrameUniform {
    /// The uniform for one picture of `size` pixels.
    pub fn new(framing: &ViewTargets, camera: &Camera, options: &SceneOptions, size: UVec2) -> Self {
        let vec = |v: Vec3| v.extend(0.0).to_array();
        let rgb = |c: Rgb| [c[0], c[1], c[2], 1.0];
        let g = options.theme.greys();
        let (right, up, back) = camera.basis();
        let size = size.as_vec2();
        let contact = options.show_floor_colours == FloorColours::Interference;
        let heights = options.show_floor_colours == FloorColours::Residual;
        let map = if contact { palette::ColourMap::Contact } else { options.map };
        let on = |yes: bool| f32::from(u8::from(yes));
        let mut lines = [[0.0; 4]; 8];
        let darker = |c: Rgb| c.map(|x| x * 0.55);
        for (colour, value) in [
            (LineColour::Edge, g.edge),
            (LineColour::WallEdge, g.wall_edge),
            (LineColour::Axis, g.axis),
            (LineColour::Sound, darker(palette::SOUND)),
            (LineColour::Blocked, darker(palette::BLOCKED)),
            (LineColour::Interfering, darker(palette::INTERFERING)),
            (LineColour::Selected, darker(palette::SELECTED)),
            (LineColour::Unevaluated, darker(palette::UNEVALUATED)),
        ] {
            lines[colour as usize] = rgb(value);
        }
        let perspective = on(camera.projection == Projection::Perspective);
        Self {
            clip_from_world: camera.clip_from_world(size.x / size.y).to_cols_array_2d(),
            eye: camera.eye().extend(perspective).to_array(),
            right: vec(right),
            up: vec(up),
            back: vec(back),
            viewport: [size.x, size.y, options.pixel_scale, framing.wheel.radius * 8e-4],
            range: [options.range_mm.0, options.range_mm.1, 1.0, on(options.relief && heights)],
            look: [on(options.cut_away), on(heights), UNCUT_TOLERANCE, 0.0],
            plane: options.section.map_or([0.0; 4], |s| s.normal.extend(s.offset).to_array()),
            greys: [
                g.background_top,
                g.background_bottom,
                g.hub,
                g.floor,
                g.blade,
                g.wall,
                g.shroud,
                g.uncut,
                g.section,
            ]
            .map(rgb),
            lines,
            states: [
                palette::SOUND,
                palette::BLOCKED,
                palette::INTERFERING,
                palette::SELECTED,
                palette::UNEVALUATED,
            ]
            .map(rgb),
            table: map.table().map(|c| [c[0], c[1], c[2], 255].map(|x| f32::from(x) / 255.0)),
        }
    }

    /// The same picture, cropped to a window of `pixels` × `pixels` about one of its pixels, for picking.
    pub fn cropped_about(mut self, pixel: Vec2, size: Vec2, pixels: f32) -> Self {
        let middle = Vec2::new(2.0 * pixel.x / size.x - 1.0, 1.0 - 2.0 * pixel.y / size.y);
        let scale = size / pixels;
        let window =
            Mat4::from_translation((-middle * scale).extend(0.0)) * Mat4::from_scale(scale.extend(1.0));
        let clip = Mat4::from_cols_array_2d(&self.clip_from_world);
        self.clip_from_world = (window * clip).to_cols_array_2d();
        self
    }
}
