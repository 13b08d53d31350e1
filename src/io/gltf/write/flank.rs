//! Scene of a flank plan: the part, and the passes of each layer as lines.

use serde_json::json;

use super::GltfScene;
use super::builder::{AccessorUse, GltfBuilder};
use super::part::{WallColours, metres, part_nodes, root, unlit};
use crate::io::flank_file::StoredFlank;
use crate::mesh::tessellate::Tessellation;
use crate::palette::{ColourMap, colour_of_value};

/// glTF primitive mode of a polyline.
const LINE_STRIP: u32 = 3;

impl GltfScene {
    /// Scene of a flank plan, with passes coloured by layer: dark near the hub, light at the top.
    pub fn of_flank(plan: &StoredFlank, shape: &Tessellation) -> Self {
        let mut builder = GltfBuilder::default();
        let mut nodes = part_nodes(&mut builder, &plan.part, shape, WallColours::Highlighted);
        let table = ColourMap::Viridis.table();
        let highest = plan.layers.saturating_sub(1).max(1) as f32;
        for layer in 0..plan.layers {
            let curves: Vec<_> =
                plan.passes.iter().filter(|c| c.layer == layer && c.points.len() > 1).collect();
            if curves.is_empty() {
                continue;
            }
            let name = format!("layer_{}", layer + 1);
            let material = unlit(&mut builder, &name, colour_of_value(&table, layer as f32, (0.0, highest)));
            let lines = curves
                .iter()
                .map(|curve| {
                    let points: Vec<[f32; 3]> = curve.points.iter().map(metres).collect();
                    let positions = builder.floats(&points, AccessorUse::Positions);
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
            "curves": plan.passes.len(),
            "feed": plan.feed_mm_per_min,
            "blade_allowance": plan.setup.allowances.blade_allowance,
            "hub_allowance": plan.setup.allowances.hub_allowance,
        });
        let root = root(&mut builder, &plan.part, shape, &nodes, facts);
        Self { builder, root }
    }
}
