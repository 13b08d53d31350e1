//! Scene of a flank plan: the part, and the passes of each layer as lines.

use serde_json::json;

use super::GltfScene;
use super::builder::{Builder, Use};
use super::part::{Walls, metres, part_nodes, root, unlit};
use crate::formats::flank_file::StoredFlank;
use crate::mesh::tessellate::Tessellation;
use crate::palette::{ColourMap, looked_up};

/// glTF primitive mode of a polyline.
const LINE_STRIP: u32 = 3;

impl GltfScene {
    /// Scene of a flank plan, with passes coloured by layer: dark near the hub, light at the top.
    pub fn of_flank(plan: &StoredFlank, shape: &Tessellation) -> Self {
        let mut builder = Builder::default();
        let mut nodes = part_nodes(&mut builder, &plan.part, shape, Walls::InWork);
        let table = ColourMap::Viridis.table();
        let highest = plan.layers.saturating_sub(1).max(1) as f32;
        for layer in 0..plan.layers {
            let curves: Vec<_> =
                plan.curves.iter().filter(|c| c.layer == layer && c.points.len() > 1).collect();
            if curves.is_empty() {
                continue;
            }
            let name = format!("layer_{}", layer + 1);
            let material = unlit(&mut builder, &name, looked_up(&table, layer as f32, (0.0, highest)));
            let lines = curves
                .iter()
                .map(|curve| {
                    let points: Vec<[f32; 3]> = curve.points.iter().map(metres).collect();
                    let positions = builder.floats(&points, Use::Positions);
                    json!({
                        "attributes": { "POSITION": positions }, "mode": LINE_STRIP, "material": material,
                    })
                })
                .collect();
            let mesh = builder.mesh(&name, lines);
            let facts = json!({ "vanecut": { "curves": curves.len() } });
            nodes.push(builder.node(json!({ "name": name, "mesh": mesh, "extras": facts })));
        }
        let facts = json!({
            "scheme": plan.scheme.name(),
            "layers": plan.layers,
            "curves": plan.curves.len(),
            "feed": plan.feed,
            "blade_allowance": plan.setup.stock.blade_allowance,
            "hub_allowance": plan.setup.stock.hub_allowance,
        });
        let root = root(&mut builder, &plan.part, shape, &nodes, facts);
        Self { builder, root }
    }
}
