//! An impeller as meshes: hub with body, blades, shroud, the floor of the active channel.

use std::f64::consts::{PI, TAU};

use glam::Vec3;

use crate::geometry::{Point, wrap_angle};
use crate::gpu::mesh::{
    LineColour, Mesh, PointGrid, ProfilePoint, Vertex, even_steps, polyline, quads, rotate_about_z,
    thin_parameters,
};
use crate::gpu::part_mesh::{BladeMesh, PartMesh, close_blade};
use crate::gpu::view::{ViewTarget, ViewTargets};
use crate::part::body::{body_outline, up_sign};
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

impl Detail {
    /// Stations of hub and floor from the leading edge to the rim, as s.
    fn stations(&self) -> Vec<f64> {
        even_steps(self.meridian.next_power_of_two())
    }
}

/// s ahead of the leading edge up to which the hub is drawn in even steps.
const EVEN_AHEAD: f64 = 0.12;
/// Steps of the hub further ahead, before they are thinned.
const NOSE_STEPS: usize = 400;

/// For still pictures.
const FINE: Detail = Detail { turn: 240, meridian: 40, span: 8, chord: 16, tolerance: 4e-4 };
/// For pictures in motion: about a tenth of the triangles.
const DRAFT: Detail = Detail { turn: 96, meridian: 14, span: 2, chord: 8, tolerance: 4e-3 };

fn vec3(p: Point) -> Vec3 {
    Vec3::new(p.x as f32, p.y as f32, p.z as f32)
}

/// The meshes of a part for still pictures.
pub fn part_mesh(part: &Impeller) -> PartMesh {
    mesh_with(part, &FINE)
}

/// Coarse meshes of a part, for pictures in motion.
pub fn draft_part_mesh(part: &Impeller) -> PartMesh {
    mesh_with(part, &DRAFT)
}

fn mesh_with(part: &Impeller, detail: &Detail) -> PartMesh {
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
            let (colour, width) = if k < lit { (LineColour::WallEdge, 1.8) } else { (LineColour::Edge, 1.0) };
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
    PartMesh { hub, floor, floor_columns, main, splitters, shroud, edges, framing }
}

/// Values of s at which the hub is drawn, from its beginning to the rim: those of its nose far ahead of the
/// blades thinned (Douglas–Peucker).
fn hub_range(hub: &Flowpath, detail: &Detail) -> Vec<f64> {
    let (from, near) = (hub.wheel_from(), hub.wheel_from().max(-EVEN_AHEAD));
    let mut range = Vec::new();
    if from < near {
        let along = |s: f64| {
            let p = hub.point(s);
            Vec3::new(p.r as f32, 0.0, p.z as f32)
        };
        let fine: Vec<f64> = even_steps(NOSE_STEPS).iter().map(|t| from + (near - from) * t).collect();
        range = thin_parameters(&fine, along, detail.tolerance * hub.length() as f32);
        range.pop();
    }
    // The floor lies on the hub: with other stations than its own one would come through the other.
    let stations = detail.stations();
    let ahead = (-near * (stations.len() - 1) as f64).ceil() as usize;
    range.extend((0..ahead).map(|k| near * (1.0 - k as f64 / ahead as f64)));
    range.extend(stations);
    range
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

/// Angles of the active channel's walls at the hub along s.
struct WallAngles {
    /// s of each station, even from 0 to 1.
    stations: Vec<f64>,
    /// Angles (rad) of the suction-side wall and of the pressure-side wall, the latter unwrapped.
    angles: Vec<[f64; 2]>,
}

impl WallAngles {
    fn new(part: &Impeller) -> Self {
        let passage = Channel::from_part(part).full;
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

    /// By how much a triangle of the floor between two stations dips below the round hub, as a share of its
    /// radius: in a wrapped channel its edges turn from station to station.
    fn sagitta(&self, s: f64, other: f64, columns: usize) -> f64 {
        let turn = wrap_angle(self.theta(s, 0.5) - self.theta(other, 0.5)).abs();
        let [low, high] = [0.0, 1.0].map(|lambda| self.theta(s, lambda));
        let column = wrap_angle(high - low).abs() / columns as f64;
        1.0 - ((turn + column).min(PI) / 2.0).cos()
    }

    /// Raised by what its triangles dip below the hub, which would come through it.
    fn floor_mesh(&self, hub: &Flowpath, columns: usize, detail: &Detail) -> Mesh {
        let lambdas = even_steps(columns);
        let mut mesh = Mesh::default();
        let stations = detail.stations();
        for (k, &s) in stations.iter().enumerate() {
            let (p, n) = (hub.point(s), hub.normal(s));
            let beside = [k.saturating_sub(1), (k + 1).min(stations.len() - 1)];
            let raised = beside.map(|other| self.sagitta(s, stations[other], columns) * p.r);
            let raised = raised[0].max(raised[1]);
            let (r, z) = (p.r + raised * n.r, p.z + raised * n.z);
            for &lambda in &lambdas {
                let (sin, cos) = self.theta(s, lambda).sin_cos();
                // Ambient shading darkens the corners beside the walls.
                let wall = (lambda.min(1.0 - lambda) * 8.0).min(1.0);
                mesh.vertices.push(Vertex {
                    position: [(r * cos) as f32, (r * sin) as f32, z as f32],
                    value: wall as f32,
                    normal: [(n.r * cos) as f32, (n.r * sin) as f32, n.z as f32],
                    uncut: 0.0,
                });
            }
        }
        mesh.indices = quads(stations.len(), lambdas.len());
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
    use crate::part::{Blank, CurveDescription, Meridional};
    use crate::stock::solid::TurnedOutline;

    /// A compressor whose hub runs on for 60 mm ahead of its blades: nearly as far as its channels are long.
    fn with_boss() -> Impeller {
        let file = std::path::Path::new("tests/data/wheels/kj66_sections.toml");
        let mut part = crate::io::part_file::read_part(file).expect("a part");
        let CurveDescription::Points(hub) = &mut part.hub else { panic!("points") };
        let ahead = [100.0, 80.0, 65.0, 55.0].map(|z| Meridional { r: 6.5, z });
        hub.splice(0..0, ahead);
        Impeller::build(&part).expect("a part with a boss")
    }

    #[test]
    fn the_hub_does_not_come_through_the_floor() {
        let part = with_boss();
        for mesh in [part_mesh(&part), draft_part_mesh(&part)] {
            let place = |v: &Vertex| (v.position[0].hypot(v.position[1]), v.position[2]);
            let rings: Vec<(f32, f32)> = mesh.hub.vertices.iter().map(place).collect();
            let lines: Vec<&[Vertex]> = mesh.floor.vertices.chunks(mesh.floor_columns).collect();
            // The ring of the hub under each line of the floor.
            let ring = |line: &[Vertex]| {
                let (r, z) = place(&line[0]);
                let apart = |ring: &&(f32, f32)| (ring.0 - r).hypot(ring.1 - z);
                let near = rings.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).expect("a ring");
                assert!(apart(&near) < 0.02 * r, "no ring of the hub at r = {r}, z = {z} mm");
                near.0
            };
            for pair in lines.windows(2) {
                let radius = (ring(pair[0]) + ring(pair[1])) / 2.0;
                for (a, b) in pair[0].iter().zip(&pair[1][1..]).chain(pair[0][1..].iter().zip(pair[1])) {
                    let [x, y] = [0, 1].map(|k| (a.position[k] + b.position[k]) / 2.0);
                    // The shader lifts it by more than that.
                    let lowest = radius - 2e-4 * mesh.framing.wheel.radius;
                    assert!(x.hypot(y) > lowest, "{} mm below {radius}", radius - x.hypot(y));
                }
            }
        }
    }

    #[test]
    fn the_hub_is_drawn_and_met_to_its_end() {
        let part = with_boss();
        for mesh in [part_mesh(&part), draft_part_mesh(&part)] {
            let end = mesh.hub.vertices.iter().map(|v| v.position[2]).fold(f32::NEG_INFINITY, f32::max);
            assert!((end - 100.0).abs() < 1e-3, "drawn up to z = {end}");
            // The nose before it is thinned would have 96,000 alone.
            assert!(mesh.hub.vertices.len() < 25_000, "{} corners", mesh.hub.vertices.len());
        }
        let blank = Blank::from_part(&part, 0.0);
        let (_, high) = TurnedOutline::of_blank(&part, &blank).bounds();
        assert!((high.z - 100.0).abs() < 1e-6, "the solid ends at z = {}", high.z);
        for (r, distance) in [(4.5, -2.0), (9.5, 3.0)] {
            let clearance = blank.clearance(Meridional { r, z: 90.0 }, &mut None);
            assert!((clearance - distance).abs() < 0.1, "{clearance} mm at r = {r} mm beside the boss");
        }
        assert!(
            part.notes.iter().any(|note| note.contains("ahead of the blades; all of it counts")),
            "{:?}",
            part.notes
        );
    }
}
