//! Mesh of a plunge cutter: the core is opaque, the ring of inserts and the outer wall are transparent.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::UnitQuaternion;
use serde_json::{Value, json};

use super::builder::{AccessorUse, GltfBuilder};
use super::part::{direction, metres};
use crate::geometry::{Meridional, Vector};
use crate::setup::Tool;

/// Facets around the axis.
const STEPS: u32 = 72;
/// Chords of a rounded corner's profile.
const CORNER_STEPS: u32 = 6;

/// A point of a profile and its normal, in the plane of radius and axis.
type CutterProfilePoint = (Meridional, Meridional);

/// Primitives of a cutter of `height` mm, bottom at the origin, axis along Z: the core in material `solid`,
/// the rest in material `glass`.
pub fn primitives(
    builder: &mut GltfBuilder,
    tool: &Tool,
    height: f64,
    solid: usize,
    glass: usize,
) -> Vec<Value> {
    let at = |r: f64, z: f64| Meridional { r, z };
    let (down, up, out) = (at(0.0, -1.0), at(0.0, 1.0), at(1.0, 0.0));
    let radius = tool.radius();
    let core = tool.core_radius().clamp(0.0, radius);
    let corner = tool.corner_radius.clamp(0.0, (radius - core).min(height));
    let mut made = Vec::new();
    if core > 0.0 {
        let bands: [Vec<CutterProfilePoint>; 3] = [
            vec![(at(0.0, 0.0), down), (at(core, 0.0), down)],
            vec![(at(core, 0.0), out), (at(core, height), out)],
            vec![(at(core, height), up), (at(0.0, height), up)],
        ];
        made.push(primitive(builder, &bands, solid));
    }
    let mut bands: Vec<Vec<CutterProfilePoint>> =
        vec![vec![(at(core, 0.0), down), (at(radius - corner, 0.0), down)]];
    if corner > 0.0 {
        let arc = (0..=CORNER_STEPS).map(|i| {
            let (sin, cos) = (FRAC_PI_2 * f64::from(i) / f64::from(CORNER_STEPS)).sin_cos();
            (at(radius - corner + corner * sin, corner - corner * cos), at(sin, -cos))
        });
        bands.push(arc.collect());
    }
    bands.push(vec![(at(radius, corner), out), (at(radius, height), out)]);
    made.push(primitive(builder, &bands, glass));
    made
}

fn primitive(builder: &mut GltfBuilder, bands: &[Vec<CutterProfilePoint>], material: usize) -> Value {
    let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for band in bands {
        for (row, (place, normal)) in band.iter().enumerate() {
            let first = positions.len() as u32;
            for j in 0..STEPS {
                let angle = TAU * f64::from(j) / f64::from(STEPS);
                positions.push(metres(&place.at_angle(angle)));
                normals.push(direction(&normal.direction_at_angle(angle)));
                if row > 0 {
                    let next = (j + 1) % STEPS;
                    let [a, b] = [first - STEPS + j, first - STEPS + next];
                    let [c, d] = [first + j, first + next];
                    let on_axis = |k: usize| band[k].0.r == 0.0;
                    if !on_axis(row - 1) {
                        indices.extend([a, b, d]);
                    }
                    if !on_axis(row) {
                        indices.extend([a, d, c]);
                    }
                }
            }
        }
    }
    json!({
        "attributes": {
            "POSITION": builder.floats(&positions, AccessorUse::Positions),
            "NORMAL": builder.floats(&normals, AccessorUse::Corners),
        },
        "indices": builder.indices(&indices, positions.len()),
        "material": material,
    })
}

/// The shortest rotation from Z to `axis`; a half turn about X for −Z.
pub fn rotation_from_z(axis: &Vector) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector::z(), axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector::x_axis(), PI))
}

/// A rotation as a glTF quaternion x y z w.
pub fn quaternion(turn: &UnitQuaternion<f64>) -> [f32; 4] {
    [turn.i, turn.j, turn.k, turn.w].map(|x| x as f32)
}
