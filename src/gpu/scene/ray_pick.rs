//! Picking: which surface or cutter a ray through a pixel hits first.

use glam::{Vec2, Vec3};

use super::{FloorColours, Scene, SceneOptions, SolidBuffers};
use crate::gpu::camera::{Camera, ViewRay};
use crate::gpu::cutters;
use crate::gpu::mesh::{MeshHit, rotate_about_z};
use crate::gpu::part_mesh::BladeMesh;

/// Result of picking a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Nearest surface point of the part, or of a cutter if that is nearer, mm.
    pub point: Vec3,
    /// Index of the position whose cutter is under the pixel.
    pub position: Option<usize>,
    /// Value there, if the surface has values ([`FloorColours::Walls`], what is cut of a solid stock).
    pub value: Option<f32>,
    /// Whether the point is on material cut by the section plane.
    pub on_section: bool,
}

/// A surface hit by a picking ray.
#[derive(Clone, Copy)]
struct SurfaceHit {
    /// Distance along the ray, mm.
    distance: f32,
    value: Option<f32>,
    on_section: bool,
}

/// The ray rotated by −`angle` about Z, which is cheaper than rotating a blade.
fn rotated_back(ray: &ViewRay, angle: f64) -> ViewRay {
    ViewRay { origin: rotate_about_z(ray.origin, -angle), direction: rotate_about_z(ray.direction, -angle) }
}

impl Scene {
    /// Picks the surface or cutter under a pixel of a picture of `size` by ray casting, if any.
    pub fn pick(&self, camera: &Camera, options: &SceneOptions, pixel: Vec2, size: Vec2) -> Option<Pick> {
        let ray = camera.ray(pixel, size);
        let kept = kept_of(&ray, options);
        let surface = self.surface_under(&ray, options);
        let choice = options.cutter_choice();
        let shown = self.cutters.iter().filter(|_| self.preview.is_none());
        let cutter = shown
            .filter_map(|c| choice.instance(c))
            .filter_map(|i| Some((cutters::ray_distance(&i, &ray, kept?)?, i.id as usize)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let at = |distance: f32| ray.origin + ray.direction * distance;
        match cutter {
            Some((distance, id)) if surface.is_none_or(|s| distance <= s.distance) => {
                Some(Pick { point: at(distance), position: Some(id), value: None, on_section: false })
            }
            _ => surface.map(|s| Pick {
                point: at(s.distance),
                position: None,
                value: s.value,
                on_section: s.on_section,
            }),
        }
    }

    /// Nearest surface of the part as drawn, including the section plane where it cuts material.
    fn surface_under(&self, whole: &ViewRay, options: &SceneOptions) -> Option<SurfaceHit> {
        let (start, end) = kept_of(whole, options)?;
        // Start the ray where it enters the unclipped side of the section plane.
        let ray = ViewRay { origin: whole.origin + whole.direction * start, ..*whole };
        if start > 0.0 && self.is_inside(&ray, options) {
            return Some(SurfaceHit { distance: start, value: None, on_section: true });
        }
        let mut nearest: Option<SurfaceHit> = None;
        let mut near = |hit: Option<MeshHit>, has_value: bool| {
            let Some(hit) = hit else { return };
            let distance = start + hit.distance;
            if distance <= end && nearest.is_none_or(|n| distance < n.distance) {
                let value = has_value.then_some(hit.value);
                nearest = Some(SurfaceHit { distance, value, on_section: false });
            }
        };
        if let Some(SolidBuffers { mesh, .. }) = self.solid.as_ref().filter(|_| options.show_solid) {
            let hit = mesh.hit(&ray);
            // The surface of the blank has a grey of its own, and no value.
            near(hit, hit.is_some_and(|hit| !hit.is_uncut));
            return nearest;
        }
        if options.show_hub {
            near(self.part.hub.hit(&ray), false);
        }
        let walls = self.floor.as_ref().filter(|_| options.show_floor_colours == FloorColours::Walls);
        if let Some(walls) = walls {
            let hit = walls.mesh.hit(&ray);
            near(hit, hit.is_some_and(|hit| !hit.is_uncut));
        }
        let blades = self.blades().filter(|_| options.show_blades);
        for (blade, lit) in blades {
            for (k, &angle) in blade.rotations_rad.iter().enumerate() {
                let back = rotated_back(&ray, angle);
                for (side, mesh) in [&blade.suction, &blade.pressure].into_iter().enumerate() {
                    if k >= lit || !options.cut_away {
                        near(mesh.hit(&back), false);
                    } else if lit == 2 && side == k {
                        // Walls drawn transparent cannot be picked; surfaces behind them can.
                        near(mesh.hit(&back).filter(|hit| hit.normal.dot(back.direction) < 0.0), false);
                    }
                }
            }
        }
        nearest
    }

    /// Whether a ray begins inside the shown hub or blades. Both are closed, so it then crosses an odd number
    /// of their faces: the parity rule with which the renderer fills the section plane.
    fn is_inside(&self, ray: &ViewRay, options: &SceneOptions) -> bool {
        let odd = |count: usize| count % 2 == 1;
        if let Some(SolidBuffers { mesh, .. }) = self.solid.as_ref().filter(|_| options.show_solid) {
            return odd(mesh.crossings(ray));
        }
        let in_blades = || {
            let of = |blade: &BladeMesh| -> usize {
                let faces = [&blade.suction, &blade.pressure, &blade.closing, &blade.foot];
                let copies = blade.rotations_rad.iter().map(|&angle| rotated_back(ray, angle));
                copies.map(|back| faces.iter().map(|mesh| mesh.crossings(&back)).sum::<usize>()).sum()
            };
            self.blades().map(|(blade, _)| of(blade)).sum()
        };
        options.show_hub && odd(self.part.hub.crossings(ray)) || options.show_blades && odd(in_blades())
    }

    fn blades(&self) -> impl Iterator<Item = (&BladeMesh, usize)> {
        std::iter::once((&self.part.main, 2)).chain(self.part.splitters.iter().map(|s| (s, 1)))
    }
}

/// Interval of a ray, mm along it, that the section plane leaves; `None` when nothing is left.
fn kept_of(ray: &ViewRay, options: &SceneOptions) -> Option<(f32, f32)> {
    options.section.map_or(Some((0.0, f32::INFINITY)), |plane| plane.unclipped_interval(ray))
}
