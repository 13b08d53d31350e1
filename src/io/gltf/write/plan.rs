//! Scene of a plunge plan: the part, the residual stock on the channel floor, and the cutters at the ends of
//! their plunges.

use serde_json::{Value, json};

use super::builder::{AccessorUse, GltfBuilder};
use super::cutter::{primitives, quaternion, rotation_from_z};
use super::part::{direction, glass, linear, matt, metres, unlit};
use super::{GltfScene, part};
use crate::geometry::{Point, Vector};
use crate::mesh::tessellate::Tessellation;
use crate::palette::{self, ColourMap, Rgb, Theme, colour_of_value};
use crate::part::Impeller;
use crate::plunge::plan::Position;
use crate::plunge::{Condition, PlungePlan};
use crate::setup::Setup;
use crate::stock::FloorGrid;
use crate::stock::surface::{FloorSurface, MAX_LINES, is_uncut};

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Displayed length of a sound cutter, in diameters; others are longer, so that they differ in more than
/// colour.
const SHOWN_LENGTH: f64 = 0.15;

/// How cutters are written to a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutterNodes {
    /// One node per tool and condition, with instances by `EXT_mesh_gpu_instancing`. A viewer without the
    /// extension displays only the first cutter of each node.
    #[default]
    Instanced,
    /// One node per cutter, for any viewer.
    Plain,
}

/// A plan and everything that is displayed of it.
#[derive(Clone, Copy, Debug)]
pub struct PlanScene<'a> {
    /// The part.
    pub part: &'a Impeller,
    /// Its triangles.
    pub shape: &'a Tessellation,
    /// The setup of the plan.
    pub setup: &'a Setup,
    /// The plan.
    pub plan: &'a PlungePlan,
    /// Grid of the floor of the active channel.
    pub grid: &'a FloorGrid,
    /// Residual stock on each of its cells, mm.
    pub heights: &'a [f32],
    /// Range of the colour scale of the stock, mm.
    pub range: (f32, f32),
    /// The scale's colours.
    pub map: ColourMap,
    /// How the cutters are written.
    pub cutters: CutterNodes,
}

impl GltfScene {
    /// Scene of a plunge plan.
    pub fn of_plan(scene: &PlanScene) -> Self {
        let mut builder = GltfBuilder::default();
        let mut nodes =
            part::part_nodes(&mut builder, scene.part, scene.shape, part::WallColours::Highlighted);
        nodes.extend(stock(&mut builder, scene));
        nodes.push(cutters(&mut builder, scene));
        let root = part::root(&mut builder, scene.part, scene.shape, &nodes, facts(scene));
        Self { builder, root }
    }
}

/// Figures of the setup and of its plan.
fn facts(scene: &PlanScene) -> Value {
    let PlanScene { plan, setup, .. } = scene;
    let count = |of: Condition| plan.positions.iter().filter(|p| p.condition() == of).count();
    let sections: Vec<Value> = plan
        .sections
        .iter()
        .map(|section| {
            json!({
                "tool": section.tool.number,
                "diameter": section.tool.diameter,
                "corner_radius": section.tool.corner_radius,
                "core_radius": section.tool.core_radius(),
                "from": section.from,
                "to": section.to,
                "feed": section.feed,
                "rows": section.rows,
            })
        })
        .collect();
    json!({
        "policy": plan.policy.name(),
        "hub_allowance": setup.allowances.hub_allowance,
        "blade_allowance": setup.allowances.blade_allowance,
        "safety_distance": setup.allowances.safety_distance,
        "sections": sections,
        "positions": plan.positions.len(),
        "interferential": count(Condition::Interfering),
        "blocked": count(Condition::Blocked),
        "unfinished": plan.is_unfinished(),
        "stock_scale": [scene.range.0, scene.range.1],
    })
}

/// The residual stock as colours on the allowance surface of the hub; `None` if `heights` does not match
/// the grid.
fn stock(builder: &mut GltfBuilder, scene: &PlanScene) -> Option<usize> {
    let PlanScene { grid, heights, .. } = scene;
    if heights.len() != grid.points.len() {
        return None;
    }
    let surface = FloorSurface::new(grid, MAX_LINES);
    if surface.triangles.is_empty() {
        return None;
    }
    // The surface is raised to the allowance, at least in front of the hub mesh, to avoid z-fighting.
    let raise = scene.setup.allowances.hub_allowance.max(2.0 * scene.shape.chord_error);
    let vector = |v: [f32; 3]| Vector::from(v.map(f64::from));
    let normals: Vec<[f32; 3]> =
        surface.cells.iter().map(|&cell| direction(&vector(grid.normals[cell]).normalize())).collect();
    let positions: Vec<[f32; 3]> = surface
        .cells
        .iter()
        .map(|&cell| metres(&Point::from(vector(grid.points[cell]) + vector(grid.normals[cell]) * raise)))
        .collect();
    let (table, uncut) = (scene.map.table(), Theme::Light.greys().uncut);
    let colours: Vec<Rgb> = surface
        .cells
        .iter()
        .map(|&cell| {
            let height = heights[cell];
            let shown = if is_uncut(grid, cell, height) {
                uncut
            } else {
                colour_of_value(&table, height, scene.range)
            };
            linear(shown)
        })
        .collect();
    // Rows run along s, columns from the suction wall: the winding depends on the sense of rotation.
    let outside = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| vector(grid.points[surface.cells[k as usize]]));
        (b - a).cross(&(c - a)).dot(&vector(grid.normals[surface.cells[t[0] as usize]])) >= 0.0
    };
    let mut indices = Vec::with_capacity(3 * surface.triangles.len());
    for t in &surface.triangles {
        indices.extend(if outside(t) { *t } else { [t[0], t[2], t[1]] });
    }
    let material = unlit(builder, "stock", [1.0; 3]);
    let primitive = json!({
        "attributes": {
            "POSITION": builder.floats(&positions, AccessorUse::Positions),
            "NORMAL": builder.floats(&normals, AccessorUse::Corners),
            "COLOR_0": builder.colours(&colours),
        },
        "indices": builder.indices(&indices, positions.len()),
        "material": material,
    });
    let mesh = builder.mesh("stock", vec![primitive]);
    Some(builder.node(json!({ "name": "stock", "mesh": mesh })))
}

/// Colour of a condition, and factor on its displayed length.
fn condition_style(condition: Condition) -> (Rgb, f64) {
    match condition {
        Condition::Sound => (palette::SOUND, 1.0),
        Condition::Blocked => (palette::BLOCKED, 1.5),
        Condition::Interfering => (palette::INTERFERING, 2.0),
    }
}

/// Figures of one plunge; `index` is in cutting order.
fn position_facts(index: usize, p: &Position) -> Value {
    json!({
        "position": index + 1,
        "section": p.section + 1,
        "row": p.row + 1,
        "s": p.s,
        "lambda": p.lambda,
        "tip": [p.tip.x, p.tip.y, p.tip.z],
        "axis": [p.axis.x, p.axis.y, p.axis.z],
        "retract": [p.evaluation.retract.x, p.evaluation.retract.y, p.evaluation.retract.z],
        "condition": p.condition().word(),
        "contact_depth": p.evaluation.contact.depth,
        "hub_clearance": p.hub_clearance,
        "blade_clearance": p.blade_clearance,
    })
}

/// Adds the cutters; returns their parent node.
fn cutters(builder: &mut GltfBuilder, scene: &PlanScene) -> usize {
    let plan = scene.plan;
    let mut children = Vec::new();
    for condition in [Condition::Sound, Condition::Blocked, Condition::Interfering] {
        let (colour, stretch) = condition_style(condition);
        let of = |section: usize| {
            let all = plan.positions.iter().enumerate();
            all.filter(move |(_, p)| p.section == section && p.condition() == condition).collect::<Vec<_>>()
        };
        let mut materials = None;
        for (index, section) in plan.sections.iter().enumerate() {
            let positions = of(index);
            if positions.is_empty() {
                continue;
            }
            let word = condition.word();
            let (solid, clear) = *materials.get_or_insert_with(|| {
                (matt(builder, word, colour), glass(builder, &format!("{word} wall"), colour, 0.3))
            });
            let height = section.tool.diameter * SHOWN_LENGTH * stretch;
            let name = format!("cutter {} {word}", section.tool.number);
            let primitives = primitives(builder, &section.tool, height, solid, clear);
            let mesh = builder.mesh(&name, primitives);
            match scene.cutters {
                CutterNodes::Plain => children.extend(positions.iter().map(|&(k, p)| {
                    builder.node(json!({
                        "name": format!("cutter_{}", k + 1),
                        "mesh": mesh,
                        "translation": metres(&p.tip),
                        "rotation": quaternion(&rotation_from_z(&p.axis)),
                        "extras": { "vanecut": position_facts(k, p) },
                    }))
                })),
                CutterNodes::Instanced => children.push(instances(builder, &name, mesh, &positions)),
            }
        }
    }
    let mut node = json!({ "name": "cutters" });
    if !children.is_empty() {
        node["children"] = json!(children);
    }
    builder.node(node)
}

/// Adds one node with an instance per position. The node has the pose of the first position, and the
/// instances are relative to it.
fn instances(builder: &mut GltfBuilder, name: &str, mesh: usize, positions: &[(usize, &Position)]) -> usize {
    builder.uses(INSTANCING);
    let first = positions[0].1;
    let back = rotation_from_z(&first.axis).inverse();
    let shifts: Vec<[f32; 3]> =
        positions.iter().map(|(_, p)| metres(&Point::from(back * (p.tip - first.tip)))).collect();
    let turns: Vec<[f32; 4]> =
        positions.iter().map(|(_, p)| quaternion(&(back * rotation_from_z(&p.axis)))).collect();
    let facts: Vec<Value> = positions.iter().map(|&(k, p)| position_facts(k, p)).collect();
    let attributes = json!({
        "TRANSLATION": builder.floats(&shifts, AccessorUse::Instances),
        "ROTATION": builder.floats(&turns, AccessorUse::Instances),
    });
    builder.node(json!({
        "name": name,
        "mesh": mesh,
        "translation": metres(&first.tip),
        "rotation": quaternion(&rotation_from_z(&first.axis)),
        "extensions": { INSTANCING: { "attributes": attributes } },
        "extras": { "vanecut": { "positions": facts } },
    }))
}
