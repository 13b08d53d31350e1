//! An impeller as nodes of a glTF scene.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::builder::{AccessorUse, GltfBuilder};
use crate::geometry::{Point, Vector};
use crate::mesh::solid::{FaceKind, Solid, SolidFace};
use crate::mesh::tessellate::Tessellation;
use crate::palette::{Rgb, Theme};
use crate::part::Impeller;

const UNLIT: &str = "KHR_materials_unlit";

/// Metres per mm.
const METRES: f64 = 1e-3;

/// A point of the part frame (mm) in metres.
pub fn metres(p: &Point) -> [f32; 3] {
    [p.x, p.y, p.z].map(|x| (x * METRES) as f32)
}

/// A direction in single precision.
pub fn direction(v: &Vector) -> [f32; 3] {
    [v.x, v.y, v.z].map(|x| x as f32)
}

/// Converts an sRGB colour to linear RGB, as glTF requires.
pub fn linear(colour: Rgb) -> Rgb {
    colour.map(|x| if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) })
}

/// Adds a matt material of one colour.
pub fn matt(builder: &mut GltfBuilder, name: &str, colour: Rgb) -> usize {
    builder.material(json!({ "name": name, "pbrMetallicRoughness": factors(colour, 1.0) }))
}

/// Adds a transparent, double-sided material.
pub fn glass(builder: &mut GltfBuilder, name: &str, colour: Rgb, opacity: f64) -> usize {
    builder.material(json!({
        "name": name, "pbrMetallicRoughness": factors(colour, opacity),
        "alphaMode": "BLEND", "doubleSided": true,
    }))
}

/// Adds an unlit material, so that the colours of a scale can be read off.
pub fn unlit(builder: &mut GltfBuilder, name: &str, colour: Rgb) -> usize {
    builder.uses(UNLIT);
    builder.material(json!({
        "name": name, "pbrMetallicRoughness": factors(colour, 1.0), "extensions": { UNLIT: {} },
    }))
}

fn factors(colour: Rgb, opacity: f64) -> Value {
    let [r, g, b] = linear(colour).map(|x| (f64::from(x) * 1e5).round() / 1e5);
    json!({ "baseColorFactor": [r, g, b, opacity], "metallicFactor": 0.0, "roughnessFactor": 0.75 })
}

/// Quaternion of a rotation by `angle` (rad) about the part's axis Z.
pub fn quaternion_about_z(angle: f64) -> Value {
    let (sin, cos) = (0.5 * angle).sin_cos();
    json!([0.0, 0.0, sin as f32, cos as f32])
}

/// Whether the walls of the active channel have their own colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallColours {
    /// All blades have the same colour.
    Alike,
    /// The two walls of channel 1 and the splitters between them are highlighted.
    Highlighted,
}

/// Adds the part; returns its nodes `hub`, `shroud`, `blade_1`…, `splitter_1`…, in the part frame.
pub fn part_nodes(
    builder: &mut GltfBuilder,
    part: &Impeller,
    shape: &Tessellation,
    walls: WallColours,
) -> Vec<usize> {
    let greys = Theme::Light.greys();
    let hub = matt(builder, "hub", greys.hub);
    let shroud = glass(builder, "shroud", greys.shroud, 0.25);
    let blade = matt(builder, "blade", greys.blade);
    let mut nodes = Vec::new();
    for (name, solid, material) in [("hub", &shape.hub, hub), ("shroud", &shape.shroud, shroud)] {
        let faces = primitives(builder, solid);
        let mesh = builder.mesh(name, painted(&faces, material));
        nodes.push(builder.node(json!({ "name": name, "mesh": mesh })));
    }
    let highlighted = (walls == WallColours::Highlighted).then(|| matt(builder, "wall", greys.wall));
    let mut rows = vec![("blade", &shape.main, 2)];
    rows.extend(shape.splitters.iter().map(|s| ("splitter", s, 1)));
    let mut count = 0;
    for (index, (name, solid, lit)) in rows.into_iter().enumerate() {
        let faces = primitives(builder, solid);
        let plain = builder.mesh(name, painted(&faces, blade));
        let wall =
            highlighted.map(|material| builder.mesh(&format!("{name} (active)"), painted(&faces, material)));
        // Splitters of several kinds are numbered consecutively.
        if index < 2 {
            count = 0;
        }
        for k in 0..part.blade_count {
            count += 1;
            let mesh = wall.filter(|_| k < lit).unwrap_or(plain);
            let mut node = json!({ "name": format!("{name}_{count}"), "mesh": mesh });
            if k > 0 {
                node["rotation"] = quaternion_about_z((k as f64 * part.pitch()) % TAU);
            }
            nodes.push(builder.node(node));
        }
    }
    nodes
}

/// The faces of a solid as primitives without material; foot and edges of a blade are joined with its tip.
fn primitives(builder: &mut GltfBuilder, solid: &Solid) -> Vec<Value> {
    let group = |kind: FaceKind| match kind {
        FaceKind::Foot | FaceKind::LeadingEdge | FaceKind::TrailingEdge => FaceKind::Tip,
        own => own,
    };
    let mut kinds: Vec<FaceKind> = Vec::new();
    for face in &solid.faces {
        if !kinds.contains(&group(face.kind)) {
            kinds.push(group(face.kind));
        }
    }
    kinds
        .into_iter()
        .map(|kind| {
            let faces: Vec<&SolidFace> = solid.faces.iter().filter(|face| group(face.kind) == kind).collect();
            primitive(builder, &solid.points, &faces)
        })
        .collect()
}

fn primitive(builder: &mut GltfBuilder, points: &[Point], faces: &[&SolidFace]) -> Value {
    let corners = || faces.iter().flat_map(|face| &face.corners);
    let positions: Vec<[f32; 3]> = corners().map(|c| metres(&points[c.point as usize])).collect();
    let normals: Vec<[f32; 3]> = corners().map(|c| direction(&c.normal)).collect();
    let mut indices = Vec::new();
    let mut first = 0;
    for face in faces {
        indices.extend(face.triangles.iter().flatten().map(|i| first + i));
        first += face.corners.len() as u32;
    }
    json!({
        "attributes": {
            "POSITION": builder.floats(&positions, AccessorUse::Positions),
            "NORMAL": builder.floats(&normals, AccessorUse::Corners),
        },
        "indices": builder.indices(&indices, positions.len()),
    })
}

fn painted(primitives: &[Value], material: usize) -> Vec<Value> {
    let paint = |primitive: &Value| {
        let mut primitive = primitive.clone();
        primitive["material"] = json!(material);
        primitive
    };
    primitives.iter().map(paint).collect()
}

/// Adds the root node of a scene: it rotates the part's axis Z to the file's Y, and has the figures of the
/// part, extended by `more`.
pub fn root(
    builder: &mut GltfBuilder,
    part: &Impeller,
    shape: &Tessellation,
    children: &[usize],
    more: Value,
) -> usize {
    let mut facts = json!({
        "rotation_axis": "z",
        "unit": "mm",
        "part": part.name,
        "rotation": part.rotation().name(),
        "blades": part.blade_count,
        "splitters": part.blade_count * part.splitters.len(),
        "chord_error": shape.chord_error,
    });
    if let (Some(facts), Value::Object(more)) = (facts.as_object_mut(), more) {
        facts.extend(more);
    }
    builder.node(json!({
        "name": part.name,
        // Column-major: x stays, y becomes −z, z becomes y. A matrix is exact, a quaternion is not.
        "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1],
        "children": children,
        "extras": { "vanecut": facts },
    }))
}
