//! Meshes of a wheel: hub with body, blades, shroud, the floor of the active channel.
//!
//! The active channel is channel 1: between the suction side of the main blade and the pressure side of the
//! next one.

use glam::Vec3;

use super::mesh::{Mesh, PointGrid, Segment, Vertex};
use super::view::{ViewTarget, ViewTargets};

/// From this share of the radius of a mesh on, its corners are those of the rim.
const RIM_SHARE: f32 = 0.9;

/// Mesh of one blade; the other blades of its row are rotated copies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BladeMesh {
    /// Suction side.
    pub suction: Mesh,
    /// Pressure side.
    pub pressure: Mesh,
    /// Tip, leading and trailing edge.
    pub closing: Mesh,
    /// Closes the blade at the hub; visible only where the section plane cuts it.
    pub foot: Mesh,
    /// Leading edge, trailing edge, tip and foot as polylines.
    pub edges: Vec<Vec<Vec3>>,
    /// Rotation of each copy about Z, rad. The copies of a main blade start with the two walls of the active
    /// channel, those of a splitter with the one inside it.
    pub rotations_rad: Vec<f64>,
}

/// All meshes of a part that are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct PartMesh {
    /// Hub of the whole wheel with rim, back and bore.
    pub hub: Mesh,
    /// Floor of the active channel: evenly spaced lines across it from s = 0 to 1.
    pub floor: Mesh,
    /// Number of corners of one such line.
    pub floor_columns: usize,
    /// Main blade.
    pub main: BladeMesh,
    /// Splitters.
    pub splitters: Vec<BladeMesh>,
    /// Shroud over the whole wheel.
    pub shroud: Mesh,
    /// Edges of hub, body and all blades.
    pub edges: Vec<Segment>,
    /// Targets of the standard views; without sections.
    pub framing: ViewTargets,
}

impl PartMesh {
    /// Meshes of an imported file before it becomes a part, grouped by role; Z is the axis of rotation.
    pub fn from_roles(hub: Mesh, blades: Mesh, shroud: Mesh) -> Self {
        let corners = || [&hub, &blades, &shroud].into_iter().flat_map(|m| &m.vertices);
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for p in corners().map(|v| Vec3::from_array(v.position)) {
            (low, high) = (low.min(p), high.max(p));
        }
        if corners().next().is_none() {
            (low, high) = (Vec3::NEG_ONE, Vec3::ONE);
        }
        let (center, radius) = ((low + high) / 2.0, ((high - low).length() / 2.0).max(1e-3));
        // The inlet is to face up in the view. The blades lie on its side of the hub; where they are one
        // body, the rim tells: it lies on the other side.
        let height = |mesh: &Mesh| {
            mesh.vertices.iter().map(|v| v.position[2]).sum::<f32>() / mesh.vertices.len().max(1) as f32
        };
        let stand = if blades.vertices.is_empty() || hub.vertices.is_empty() {
            let reach = |v: &Vertex| v.position[0].hypot(v.position[1]);
            let rim = RIM_SHARE * corners().map(reach).fold(0.0, f32::max);
            let above: f32 = corners().filter(|v| reach(v) >= rim).map(|v| v.position[2] - center.z).sum();
            above <= 0.0
        } else {
            height(&blades) >= height(&hub)
        };
        let up_sign = if stand { 1.0 } else { -1.0 };
        let whole = ViewTarget { center, radius, from: Vec3::new(0.7, -0.7, 0.85 * up_sign).normalize() };
        let stride = (corners().count() / 2000).max(1);
        let outline: Vec<Vec3> = corners().step_by(stride).map(|v| Vec3::from_array(v.position)).collect();
        let framing = ViewTargets {
            wheel: whole,
            channel: whole,
            sections: Vec::new(),
            wheel_outline: outline.clone(),
            channel_outline: outline,
            up_sign,
        };
        let main = BladeMesh { closing: blades, rotations_rad: vec![0.0], ..BladeMesh::default() };
        let (floor, splitters, edges) = (Mesh::default(), Vec::new(), Vec::new());
        Self { hub, floor, floor_columns: 1, main, splitters, shroud, edges, framing }
    }

    /// Points (mm) across the floor at `s` (0…1) with their unit normals, from wall to wall.
    pub fn floor_line(&self, s: f64) -> Vec<(Vec3, Vec3)> {
        let rows: Vec<_> = self.floor.vertices.chunks_exact(self.floor_columns).collect();
        let Some(last) = rows.len().checked_sub(2) else { return Vec::new() };
        let x = s.clamp(0.0, 1.0) * (last + 1) as f64;
        let i = (x as usize).min(last);
        let share = (x - i as f64) as f32;
        let mix = |a: [f32; 3], b: [f32; 3]| Vec3::from_array(a).lerp(Vec3::from_array(b), share);
        let pairs = rows[i].iter().zip(rows[i + 1]);
        pairs
            .map(|(a, b)| (mix(a.position, b.position), mix(a.normal, b.normal).normalize_or_zero()))
            .collect()
    }

    /// Number of triangles of the whole wheel as drawn, including the shroud.
    pub fn triangles(&self) -> usize {
        let blade = |b: &BladeMesh| {
            (b.suction.triangles() + b.pressure.triangles() + b.closing.triangles()) * b.rotations_rad.len()
        };
        self.hub.triangles()
            + self.floor.triangles()
            + self.shroud.triangles()
            + blade(&self.main)
            + self.splitters.iter().map(blade).sum::<usize>()
    }
}

/// A blade from grids of its sides (rows LE → TE, columns hub → tip, same shape).
pub fn close_blade(suction: &PointGrid, pressure: &PointGrid) -> BladeMesh {
    let (last_row, last_column) = (suction.rows - 1, suction.columns - 1);
    // Ambient shading darkens the foot, which makes the junction with the hub visible.
    let open = |_: usize, j: usize| (j as f32 / last_column as f32 * 2.5).min(1.0);
    let strip = |a: Vec<Vec3>, b: Vec<Vec3>, outside: Vec3| {
        let grid = PointGrid { rows: 2, columns: a.len(), points: [a, b].concat() };
        grid.mesh(|_, _| outside, |_, _| 1.0)
    };
    let middle = last_row / 2;
    let up = suction.at(middle, last_column) - suction.at(middle, 0);
    let along = suction.at(last_row, last_column / 2) - suction.at(last_row - 1, last_column / 2);
    let mut closing = strip(suction.column(last_column), pressure.column(last_column), up);
    closing.append(&strip(suction.row(0), pressure.row(0), suction.at(0, 0) - suction.at(1, 0)));
    closing.append(&strip(suction.row(last_row), pressure.row(last_row), along));
    let foot = strip(suction.column(0), pressure.column(0), -up);
    BladeMesh {
        foot,
        suction: suction.mesh(|i, j| suction.at(i, j) - pressure.at(i, j), open),
        pressure: pressure.mesh(|i, j| pressure.at(i, j) - suction.at(i, j), open),
        closing,
        edges: vec![
            suction.column(last_column),
            pressure.column(last_column),
            suction.column(0),
            pressure.column(0),
            suction.row(0),
            suction.row(last_row),
            pressure.row(last_row),
        ],
        rotations_rad: vec![0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh::even_steps;
    use super::*;

    #[test]
    fn a_blade_is_closed_and_its_sides_face_apart() {
        let sample = |y: f32| {
            PointGrid::sample(&even_steps(12), &even_steps(6), |u, v| {
                let thickness = 4.0 * u.min(1.0 - u).min(0.2) as f32;
                Vec3::new(60.0 * u as f32, y * thickness, 20.0 * v as f32)
            })
        };
        let blade = close_blade(&sample(1.0), &sample(-1.0));
        for (mesh, facing) in [(&blade.suction, 1.0), (&blade.pressure, -1.0)] {
            for vertex in &mesh.vertices {
                assert!(vertex.normal[1] * facing > 0.5, "{vertex:?}");
            }
        }
        let tip: Vec<_> = blade.closing.vertices.iter().take(26).collect();
        assert!(tip.iter().filter(|v| v.normal[2] > 0.9).count() >= 20, "tip faces up");
        assert_eq!(blade.edges.len(), 7);
    }
}
