//! The stock as a glTF scene.

use std::collections::HashMap;

use serde_json::json;

use super::GltfScene;
use super::builder::{AccessorUse, GltfBuilder};
use super::part::{direction, matt, metres};
use crate::palette::Theme;
use crate::stock::solid::StockSurface;

impl GltfScene {
    /// Scene of the stock of the part `name`, volume in mm³. On sharp edges the corners of both sides have
    /// normals of their own.
    pub fn of_stock(name: &str, surface: &StockSurface, volume: f64) -> Self {
        let mut builder = GltfBuilder::default();
        let mut positions: Vec<[f32; 3]> = surface.points.iter().map(metres).collect();
        let mut normals: Vec<[f32; 3]> = surface.normals.iter().map(direction).collect();
        let mut indices: Vec<u32> = surface.triangles.iter().flatten().copied().collect();
        // A vertex on an edge has no normal; its triangles get corners by the normals of their other ends.
        let mut used: HashMap<(u32, [i32; 3]), u32> = HashMap::new();
        for (triangle, t) in indices.chunks_exact_mut(3).zip(&surface.triangles) {
            for corner in triangle {
                let own = *corner as usize;
                if surface.normals[own].norm_squared() > 0.25 {
                    continue;
                }
                let mut normal: crate::geometry::Vector =
                    t.iter().map(|&i| surface.normals[i as usize]).sum();
                if normal.norm_squared() < 1e-6 {
                    let [a, b, c] = t.map(|i| surface.points[i as usize]);
                    normal = (b - a).cross(&(c - a));
                }
                let normal = normal.try_normalize(1e-300).unwrap_or_else(crate::geometry::Vector::z);
                let key = (*corner, [normal.x, normal.y, normal.z].map(|x| (8.0 * x).round() as i32));
                *corner = *used.entry(key).or_insert_with(|| {
                    positions.push(positions[own]);
                    normals.push(direction(&normal));
                    positions.len() as u32 - 1
                });
            }
        }
        // Corners without a normal are not used any more; the format wants unit vectors all the same.
        normals.iter_mut().filter(|n| n.iter().all(|x| *x == 0.0)).for_each(|n| *n = [0.0, 0.0, 1.0]);
        let material = matt(&mut builder, "stock", Theme::Light.greys().hub);
        let primitive = json!({
            "attributes": {
                "POSITION": builder.floats(&positions, AccessorUse::Positions),
                "NORMAL": builder.floats(&normals, AccessorUse::Corners),
            },
            "indices": builder.indices(&indices, positions.len()),
            "material": material,
        });
        let mesh = builder.mesh("stock", vec![primitive]);
        let node = builder.node(json!({ "name": "stock", "mesh": mesh }));
        let root = builder.node(json!({
            "name": name,
            "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1],
            "children": [node],
            "extras": { "vanecut": {
                "rotation_axis": "z", "unit": "mm", "part": name, "volume": volume,
            } },
        }));
        Self { builder, root }
    }
}
