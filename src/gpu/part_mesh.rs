//! Meshes of an impeller: hub with body, blades, shroud, the floor of the active channel.
//!
//! The active channel is channel 1: between the suction side of the main blade and the pressure side of the
//! next one.

use std::f64::consts::TAU;

use glam::Vec3;

use super::mesh::{
    LineColour, Mesh, PointGrid, ProfilePoint, Segment, even_steps, polyline, rotate_about_z, thin_parameters,
};
use super::view::{ViewTarget, ViewTargets};
use crate::geometry::{Point, wrap_angle};
use crate::part::body::{body_outline, nose, up_sign};
use crate::part::{Blade, BladeSide, Channel, Flowpath, Impeller};

/// Tessellation density of a part.
#[derive(Clone, Copy, Debug)]
struct Detail {
    /// Angular steps per revolution.
    turn: usize,
    /// Steps along the meridian.
    meridian: usize,
    /// Steps of a blade from hub to tip.
    span: usize,
    /// Minimum number of steps of a blade along its chord.
    chord: usize,
    /// Largest deviation of a blade's mesh lines, in blade lengths.
    tolerance: f32,
}

/// For still pictures.
const FINE: Detail = Detail { turn: 240, meridian: 40, span: 8, chord: 16, tolerance: 4e-4 };
/// For pictures in motion: about a tenth of the triangles.
const DRAFT: Detail = Detail { turn: 96, meridian: 14, span: 2, chord: 8, tolerance: 4e-3 };

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
    floor_columns: usize,
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

fn vec3(p: Point) -> Vec3 {
    Vec3::new(p.x as f32, p.y as f32, p.z as f32)
}

impl PartMesh {
    /// Tessellates a part for still pictures.
    pub fn new(part: &Impeller) -> Self {
        Self::with_detail(part, &FINE)
    }

    /// Tessellates a part coarsely, for pictures in motion.
    pub fn draft(part: &Impeller) -> Self {
        Self::with_detail(part, &DRAFT)
    }

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
        // The blades lie on the inlet side of the hub, which is to face up in the view.
        let height = |mesh: &Mesh| {
            mesh.vertices.iter().map(|v| v.position[2]).sum::<f32>() / mesh.vertices.len().max(1) as f32
        };
        let stand = blades.vertices.is_empty() || hub.vertices.is_empty() || height(&blades) >= height(&hub);
        let up_sign = if stand { 1.0 } else { -1.0 };
        let (center, radius) = ((low + high) / 2.0, ((high - low).length() / 2.0).max(1e-3));
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

    fn with_detail(part: &Impeller, detail: &Detail) -> Self {
        let channel = WallAngles::new(part);
        let up_sign = up_sign(part) as f32;
        let body = body_outline(part).map(|p| (p.r as f32, p.z as f32));
        let angles: Vec<f64> = even_steps(detail.turn).iter().map(|t| t * TAU).collect();
        let mut hub = Mesh::revolve(&profile(&part.hub, &hub_range(&part.hub, detail)), &angles, |_, _| 1.0);
        let mut edges = Vec::new();
        for pair in body.windows(2) {
            let along = Vec3::new(pair[1].0 - pair[0].0, 0.0, pair[1].1 - pair[0].1).normalize_or_zero();
            // The profile runs inlet → rim → back → bore, so the material is always on the same side.
            let point = |(r, z): (f32, f32)| ProfilePoint {
                r,
                z,
                normal_r: -along.z * up_sign,
                normal_z: along.x * up_sign,
            };
            hub.append(&Mesh::revolve(&[point(pair[0]), point(pair[1])], &angles, |_, _| 1.0));
        }
        for &(r, z) in &body {
            let circle: Vec<Vec3> =
                angles.iter().map(|a| Vec3::new(r * a.cos() as f32, r * a.sin() as f32, z)).collect();
            edges.extend(polyline(&circle, 1.0, LineColour::Edge));
        }

        let pitch = part.pitch();
        let row = |blade: &Blade| {
            let turns = (0..part.blade_count).map(|k| k as f64 * pitch).collect();
            BladeMesh { rotations_rad: turns, ..blade_mesh(blade, detail) }
        };
        let main = row(&part.main);
        let splitters: Vec<BladeMesh> = part.splitters.iter().map(row).collect();
        let walls =
            [(&main, 2.min(main.rotations_rad.len()))].into_iter().chain(splitters.iter().map(|s| (s, 1)));
        for (blade, lit) in walls {
            for (k, &angle) in blade.rotations_rad.iter().enumerate() {
                let (colour, width) =
                    if k < lit { (LineColour::WallEdge, 1.8) } else { (LineColour::Edge, 1.0) };
                for edge in &blade.edges {
                    let turned: Vec<Vec3> = edge.iter().map(|&p| rotate_about_z(p, angle)).collect();
                    edges.extend(polyline(&turned, width, colour));
                }
            }
        }
        let shroud_steps = even_steps(detail.meridian);
        let shroud = Mesh::revolve(&profile(&part.shroud, &shroud_steps), &angles, |_, _| 1.0);
        let floor_columns = (detail.turn / part.blade_count.max(1) + 8).clamp(12, 96);
        let floor = channel.floor_mesh(&part.hub, floor_columns, detail);
        let floor_columns = even_steps(floor_columns).len();
        let framing = channel.framing(part, up_sign, &body);
        Self { hub, floor, floor_columns, main, splitters, shroud, edges, framing }
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

/// Values of s at which the hub is drawn: from a short nose ahead of the blades to the rim.
fn hub_range(hub: &Flowpath, detail: &Detail) -> Vec<f64> {
    let nose = nose(hub);
    even_steps(detail.meridian).iter().map(|t| nose + (1.0 - nose) * t).collect()
}

fn profile(path: &Flowpath, at: &[f64]) -> Vec<ProfilePoint> {
    at.iter()
        .map(|&s| {
            let (p, n) = (path.point(s), path.normal(s));
            ProfilePoint { r: p.r as f32, z: p.z as f32, normal_r: n.r as f32, normal_z: n.z as f32 }
        })
        .collect()
}

/// Parameters u of the mesh lines of a blade: the knots of its surfaces, thinned (Douglas–Peucker).
fn blade_lines(blade: &Blade, detail: &Detail) -> Vec<f64> {
    let mut us: Vec<f64> = blade.suction.u_knots().to_vec();
    us.extend_from_slice(blade.pressure.u_knots());
    us.extend(even_steps(16));
    us.retain(|u| (0.0..=1.0).contains(u));
    us.sort_by(f64::total_cmp);
    us.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    let length = (blade.suction.point(1.0, 0.5) - blade.suction.point(0.0, 0.5)).norm() as f32;
    let mut kept: Vec<f64> = even_steps(detail.chord);
    for side in [&blade.suction, &blade.pressure] {
        for v in [0.0, 1.0] {
            kept.extend(thin_parameters(&us, |u| vec3(side.point(u, v)), length * detail.tolerance));
        }
    }
    kept.sort_by(f64::total_cmp);
    kept.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    kept
}

/// Tessellates one blade: both sides, and the strips that close it at tip, LE and TE.
fn blade_mesh(blade: &Blade, detail: &Detail) -> BladeMesh {
    let us = blade_lines(blade, detail);
    let vs = even_steps(detail.span);
    let side = |side: &BladeSide| PointGrid::sample(&us, &vs, |u, v| vec3(side.point(u, v)));
    close_blade(&side(&blade.suction), &side(&blade.pressure))
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

/// Angles of the active channel's walls at the hub along s.
struct WallAngles {
    /// s of each station, even from 0 to 1.
    stations: Vec<f64>,
    /// Angles (rad) of the suction-side wall and of the pressure-side wall, the latter unwrapped.
    angles: Vec<[f64; 2]>,
}

impl WallAngles {
    fn new(part: &Impeller) -> Self {
        let passage = Channel::of(part).full;
        let stations = even_steps(64);
        let mut angles: Vec<[f64; 2]> = Vec::with_capacity(stations.len());
        for &s in &stations {
            // Beyond the ends of a wall the last angle is kept.
            let last = angles.last().copied().unwrap_or([0.0, part.pitch()]);
            angles.push(passage.wall_angles(part, s, 0.0).unwrap_or(last));
        }
        Self { stations, angles }
    }

    /// Angle (rad) at s and λ, interpolated between stations.
    fn theta(&self, s: f64, lambda: f64) -> f64 {
        let x = s.clamp(0.0, 1.0) * (self.stations.len() - 1) as f64;
        let k = (x as usize).min(self.stations.len() - 2);
        let at = |[low, high]: [f64; 2]| low + lambda * (high - low);
        let (a, b) = (at(self.angles[k]), at(self.angles[k + 1]));
        // Angles of neighbouring stations may differ by 2π.
        a + wrap_angle(b - a) * (x - k as f64)
    }

    fn floor_mesh(&self, hub: &Flowpath, columns: usize, detail: &Detail) -> Mesh {
        let lambdas = even_steps(columns);
        let mut mesh = Mesh::default();
        let stations = even_steps(detail.meridian.next_power_of_two());
        for &s in &stations {
            let (p, n) = (hub.point(s), hub.normal(s));
            for &lambda in &lambdas {
                let (sin, cos) = self.theta(s, lambda).sin_cos();
                // Ambient shading darkens the corners beside the walls.
                let wall = (lambda.min(1.0 - lambda) * 8.0).min(1.0);
                mesh.vertices.push(super::mesh::Vertex {
                    position: [(p.r * cos) as f32, (p.r * sin) as f32, p.z as f32],
                    value: wall as f32,
                    normal: [(n.r * cos) as f32, (n.r * sin) as f32, n.z as f32],
                    uncut: 0.0,
                });
            }
        }
        mesh.indices = super::mesh::quads(stations.len(), lambdas.len());
        mesh
    }

    fn framing(&self, part: &Impeller, up_sign: f32, body: &[(f32, f32)]) -> ViewTargets {
        let (inlet, rim) = (part.shroud.point(0.0), part.shroud.point(1.0));
        let mut low = f32::INFINITY;
        let mut high = f32::NEG_INFINITY;
        for z in body.iter().map(|p| p.1).chain([inlet.z as f32, rim.z as f32]) {
            low = low.min(z);
            high = high.max(z);
        }
        let widest = body.iter().map(|p| p.0).fold(rim.r as f32, f32::max);
        let center = Vec3::new(0.0, 0.0, (low + high) / 2.0);
        let radius = widest.hypot((high - low) / 2.0);

        let ring = |r: f32, z: f32| {
            even_steps(24).into_iter().map(move |t| rotate_about_z(Vec3::new(r, 0.0, z), t * TAU))
        };
        let wheel_outline = body
            .iter()
            .map(|&(r, z)| (r, z))
            .chain([inlet, rim].map(|m| (m.r as f32, m.z as f32)))
            .flat_map(|(r, z)| ring(r, z))
            .collect();

        let at = |path: &Flowpath, s: f64, lambda: f64| {
            let (p, (sin, cos)) = (path.point(s), self.theta(s, lambda).sin_cos());
            Vec3::new((p.r * cos) as f32, (p.r * sin) as f32, p.z as f32)
        };
        let mut corners = Vec::new();
        for s in [0.0, 0.25, 0.5, 0.75, 1.0] {
            for lambda in [0.0, 0.5, 1.0] {
                corners.extend([at(&part.hub, s, lambda), at(&part.shroud, s, lambda)]);
            }
        }
        let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
        let reach = corners.iter().map(|c| c.distance(middle)).fold(0.0, f32::max);

        // Look along the hub normal near mid-channel, inclined towards the rim: from there neither wall hides
        // the floor.
        let (sin, cos) = self.theta(0.6, 0.5).sin_cos();
        let (sin, cos) = (sin as f32, cos as f32);
        let n = part.hub.normal(0.55);
        let onto = Vec3::new(n.r as f32 * cos, n.r as f32 * sin, n.z as f32);
        let outward = Vec3::new(cos, sin, 0.0);
        // Iso view: the outlet of the channel at the rim to the front.
        let (rim_sin, rim_cos) = self.theta(0.8, 0.5).sin_cos();
        let iso = Vec3::new(rim_cos as f32, rim_sin as f32, 0.0);
        ViewTargets {
            wheel: ViewTarget { center, radius, from: (iso + Vec3::Z * 0.85 * up_sign).normalize() },
            channel: ViewTarget {
                center: middle,
                radius: reach,
                from: (onto + outward * 0.35).normalize_or(Vec3::Z),
            },
            sections: Vec::new(),
            wheel_outline,
            channel_outline: corners,
            up_sign,
        }
    }
}

#[cfg(test)]
mod tests {
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
