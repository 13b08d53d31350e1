//! Creases of a blade: edges that divide its faces although the triangles beside them meet at a flat angle.
//!
//! A blunt end of a blade that leans has one obtuse corner, and a nose may meet the sides at an angle. The
//! facets of a round nose meet at angles as large. A crease turns further than the surface does beside it: a
//! straight walk over the mesh to either side meets smaller turns only. Creases are lines: a chain of edges
//! is one as a whole, so that sections at all heights have their corners at the same places.

use std::collections::{HashMap, HashSet};

use super::disjoint_sets::DisjointSets;
use super::normals::ExactNormals;
use super::surface::{MeshSurface, SHARP};
use super::weld::NONE;

/// Cosine of the angle between triangles from which on they always divide.
const CREASED: f64 = 0.5;
/// Mean angle between the exact normals of two faces along the line where they meet that divides them, rad.
const FACES_TURN: f64 = 0.437;
/// Smallest turn of a crease of a mesh without faces, rad, and how many times the turns beside it.
const TURN: f64 = 0.3;
const OVER_BESIDE: f64 = 2.5;
/// Smallest turn over the border of a face that bends, rad.
const LEAST_TURN: f64 = 0.05;
/// The same beside a side that is straight, rad, how many times as much as that side bends, and how many
/// times the reach it is looked at.
const LEAST_OF_STRAIGHT: f64 = 0.02;
const OVER_STRAIGHT: f64 = 5.0;
const STRAIGHT_REACH: f64 = 4.0;
/// Distance up to which the turns beside an edge are looked at, and smallest length of a crease, as a share
/// of the extent of the blade.
const REACH: f64 = 0.05;
/// Largest number of triangles of a walk.
const MAX_STEPS: usize = 200;

/// An edge of a triangle that may be part of a crease.
struct CreaseEdge {
    /// The faces beside it; the same for all candidates of a mesh without faces.
    faces: [u32; 2],
    corners: [u32; 2],
    length: f64,
    turn: f64,
}

/// Of each triangle, which of its edges are creases.
pub fn find_creases(surface: &MeshSurface, exact: &ExactNormals) -> Vec<[bool; 3]> {
    let mut creases: Vec<[bool; 3]> = Vec::with_capacity(surface.triangles.len());
    let reach = REACH * surface.extent().norm();
    let mut candidates: Vec<CreaseEdge> = Vec::new();
    for (t, neighbours) in surface.neighbours.iter().enumerate() {
        creases.push([false; 3]);
        for (k, &n) in neighbours.iter().enumerate() {
            if n == NONE {
                continue;
            }
            let cosine = surface.normals[t].dot(&surface.normals[n as usize]);
            creases[t][k] = cosine < CREASED;
            // Each edge once.
            if creases[t][k] || n < t as u32 {
                continue;
            }
            let found = match exact.is_empty() {
                true => bend(surface, (t, k), reach).map(|turn| ([NONE; 2], turn)),
                false => turn_of_faces(surface, exact, (t, k)),
            };
            if let Some((faces, turn)) = found {
                let corners = [surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]];
                let [a, b] = corners.map(|i| surface.points[i as usize]);
                candidates.push(CreaseEdge { faces, corners, length: (b - a).norm(), turn });
            }
        }
    }
    let least = if exact.is_empty() { (reach, 0.0) } else { (0.0, FACES_TURN) };
    let lines = lines_of(&candidates, least);
    for (t, corners) in surface.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            creases[t][k] |= lines.contains(&(a.min(b), a.max(b)));
        }
    }
    creases
}

/// Of each triangle, over which of its edges the curvature jumps, as it does where a fillet begins: the
/// surface bends there and on one side, but not on the other. A smooth function through the corners on both
/// sides would follow neither.
pub fn find_curvature_jumps(surface: &MeshSurface) -> Vec<[bool; 3]> {
    let reach = REACH * surface.extent().norm();
    let mut jumps = vec![[false; 3]; surface.triangles.len()];
    for (t, neighbours) in surface.neighbours.iter().enumerate() {
        for (k, &n) in neighbours.iter().enumerate() {
            // Each edge once.
            if n == NONE || n < t as u32 {
                continue;
            }
            let turn = surface.normals[t].angle(&surface.normals[n as usize]);
            let back = (0..3).find(|&m| surface.neighbours[n as usize][m] as usize == t);
            let (true, Some(back)) = (turn > LEAST_OF_STRAIGHT, back) else { continue };
            let sides = [(t, k), (n as usize, back)];
            let walks = sides.map(|side| walk_beside(surface, side, reach));
            let [one, other] = walks.map(|walk| turn > OVER_BESIDE * walk.turn);
            // Where a side is straight, as that of a plate or a nose up to its tip, the first facet of a
            // fillet may turn little.
            let from_straight = |a: usize| {
                let is_straight = |walk: WalkTurns| turn > OVER_STRAIGHT * walk.bend;
                walks[a].is_whole
                    && is_straight(walks[a])
                    && turn < OVER_BESIDE * walks[1 - a].bend
                    && is_straight(walk_beside(surface, sides[a], STRAIGHT_REACH * reach))
            };
            if (one != other && turn > LEAST_TURN) || from_straight(0) || from_straight(1) {
                sides.into_iter().for_each(|(t, k)| jumps[t][k] = true);
            }
        }
    }
    jumps
}

/// The edges of the chains of `candidates` that are at least as long, and turn as much in the mean, as
/// `least` says (mm, rad).
fn lines_of(candidates: &[CreaseEdge], least: (f64, f64)) -> HashSet<(u32, u32)> {
    // Chains have the ends of their edges in common, and the faces beside them.
    let mut number: HashMap<([u32; 2], u32), u32> = HashMap::new();
    let mut sets = DisjointSets::default();
    let ends: Vec<[u32; 2]> = candidates
        .iter()
        .map(|c| c.corners.map(|corner| *number.entry((c.faces, corner)).or_insert_with(|| sets.add())))
        .collect();
    ends.iter().for_each(|[a, b]| sets.join(*b, *a));
    let chain: Vec<u32> = ends.iter().map(|[a, _]| sets.root(*a)).collect();
    let mut sums: HashMap<u32, (f64, f64)> = HashMap::new();
    for (c, chain) in candidates.iter().zip(&chain) {
        let sum = sums.entry(*chain).or_default();
        *sum = (sum.0 + c.length, sum.1 + c.length * c.turn);
    }
    let is_line = |chain: &u32| {
        let (length, turns) = sums[chain];
        length > least.0 && turns > least.1 * length
    };
    let lines = candidates.iter().zip(&chain).filter(|(_, chain)| is_line(chain));
    lines.map(|(c, _)| (c.corners[0].min(c.corners[1]), c.corners[0].max(c.corners[1]))).collect()
}

/// The faces beside an edge between two of them, and the angle between their exact normals there, rad.
fn turn_of_faces(
    surface: &MeshSurface,
    exact: &ExactNormals,
    (t, k): (usize, usize),
) -> Option<([u32; 2], f64)> {
    let n = surface.neighbours[t][k] as usize;
    let (a, b) = (surface.faces[t], surface.faces[n]);
    if a == b || a == NONE || b == NONE {
        return None;
    }
    let ends = [surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]];
    let turn = |corner: u32| {
        let p = &surface.points[corner as usize];
        let normal = |t: usize| exact.near(p, &surface.normals[t]).unwrap_or(surface.normals[t]);
        normal(t).angle(&normal(n))
    };
    Some(([a.min(b), a.max(b)], 0.5 * (turn(ends[0]) + turn(ends[1]))))
}

/// The turn over an edge that turns further than the surface beside it, rad.
fn bend(surface: &MeshSurface, (t, k): (usize, usize), reach: f64) -> Option<f64> {
    let n = surface.neighbours[t][k] as usize;
    let cosine = surface.normals[t].dot(&surface.normals[n]);
    if cosine > TURN.cos() {
        return None;
    }
    let turn = cosine.acos();
    let back = (0..3).find(|&m| surface.neighbours[n][m] as usize == t)?;
    let beside = walk_beside(surface, (t, k), reach).turn.max(walk_beside(surface, (n, back), reach).turn);
    (turn > OVER_BESIDE * beside).then_some(turn)
}

/// What a straight walk over a mesh meets, rad.
#[derive(Clone, Copy, Default)]
struct WalkTurns {
    /// Largest angle between triangles.
    turn: f64,
    /// Largest turn of the way itself: 0 along the straight lines of a cylinder.
    bend: f64,
    /// Whether it went all the way: one that a sharp edge ends may have met nothing yet.
    is_whole: bool,
}

/// A straight walk over the mesh from the middle of an edge of a triangle at right angles to it, for the
/// distance `reach` or up to a sharp edge.
fn walk_beside(surface: &MeshSurface, (mut t, mut entered): (usize, usize), reach: f64) -> WalkTurns {
    let edge = |t: usize, k: usize| {
        let corners = surface.triangles[t];
        [corners[k], corners[(k + 1) % 3]].map(|i| surface.points[i as usize])
    };
    let inwards = |t: usize, k: usize| {
        let [a, b] = edge(t, k);
        surface.normals[t].cross(&(b - a))
    };
    let [a, b] = edge(t, entered);
    let (mut from, mut way, mut most) = (a + (b - a) * 0.5, 0.0, WalkTurns::default());
    let Some(mut direction) = inwards(t, entered).try_normalize(1e-12) else { return most };
    for _ in 0..MAX_STEPS {
        let exits = (0..3).filter(|&k| k != entered).filter_map(|k| {
            let inwards = inwards(t, k);
            let speed = direction.dot(&inwards);
            (speed < -1e-12).then(|| (((edge(t, k)[0] - from).dot(&inwards) / speed).max(0.0), k))
        });
        let Some((step, k)) = exits.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        let next = surface.neighbours[t][k];
        way += step;
        most.is_whole = way > reach;
        if most.is_whole || next == NONE {
            break;
        }
        let cosine = surface.normals[t].dot(&surface.normals[next as usize]);
        if cosine < SHARP {
            break;
        }
        most.turn = most.turn.max(cosine.min(1.0).acos());
        from += direction * step;
        let normal = surface.normals[next as usize];
        let Some(on) = (direction - normal * normal.dot(&direction)).try_normalize(1e-12) else { break };
        most.bend = most.bend.max(direction.cross(&on).norm());
        let back = (0..3).find(|&m| surface.neighbours[next as usize][m] as usize == t);
        (direction, entered, t) = (on, back.unwrap_or(0), next as usize);
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::mesh::TriangleMesh;

    /// A cylinder over a line, 10 mm high and of one facet from point to point.
    fn cylinder(line: &[(f64, f64)]) -> MeshSurface {
        let points = line.iter().flat_map(|(x, y)| [0.0, 10.0].map(|z| Point::new(*x, *y, z))).collect();
        let facets = (0..line.len() as u32 - 1).map(|k| 2 * k);
        let triangles = facets.flat_map(|k| [[k, k + 2, k + 1], [k + 1, k + 2, k + 3]]).collect();
        MeshSurface::from_mesh(&TriangleMesh { points, triangles })
    }

    /// A line that turns at each point by an angle, rad, and goes on by a length.
    fn line(steps: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
        let (mut at, mut heading) = ((0.0, 0.0), 0.0_f64);
        let mut points = vec![at];
        for (turn, length) in steps {
            heading += turn;
            at = (at.0 + length * heading.cos(), at.1 + length * heading.sin());
            points.push(at);
        }
        points
    }

    /// The points of the line at which edges up the cylinder are marked.
    fn marked(surface: &MeshSurface, edges: &[[bool; 3]]) -> Vec<u32> {
        let mut at: Vec<u32> = Vec::new();
        for (t, marks) in surface.triangles.iter().zip(edges) {
            let ends = (0..3).filter(|k| marks[*k]).map(|k| [t[k] / 2, t[(k + 1) % 3] / 2]);
            at.extend(ends.filter(|[a, b]| a == b).map(|[a, _]| a));
        }
        at.sort_unstable();
        at.dedup();
        at
    }

    #[test]
    fn an_obtuse_corner_is_a_crease_and_a_coarse_nose_is_not() {
        let bent = |at: usize| (0..40).map(move |k| (if k == at { 0.54 } else { 0.02 }, 0.5));
        let corner = cylinder(&line(bent(20)));
        assert_eq!(marked(&corner, &find_creases(&corner, &ExactNormals::default())), [20]);
        let turn = |k: usize| if (15..=20).contains(&k) { 0.5 } else { 0.02 };
        let nose = cylinder(&line((0..40).map(|k| (turn(k), 0.5))));
        assert_eq!(marked(&nose, &find_creases(&nose, &ExactNormals::default())), [0_u32; 0]);
    }

    #[test]
    fn the_curvature_jumps_where_a_fillet_begins() {
        let side = (0..4).map(|_| (0.0, 5.0));
        let filleted = cylinder(&line(side.chain([(0.1, 0.2)]).chain((0..6).map(|_| (0.2, 0.2)))));
        // The end of the surface is as good as straight.
        assert_eq!(marked(&filleted, &find_curvature_jumps(&filleted)), [4, 10]);
        // Its first facet may turn little beside a side that is straight.
        let shallow = (0..4).map(|_| (0.0, 5.0)).chain([(0.03, 0.2)]).chain((0..6).map(|_| (0.06, 0.2)));
        let shallow = cylinder(&line(shallow));
        assert!(marked(&shallow, &find_curvature_jumps(&shallow)).contains(&4));
        let round = cylinder(&line((0..20).map(|_| (0.2, 0.2))));
        let jumps = marked(&round, &find_curvature_jumps(&round));
        assert!(jumps.iter().all(|k| [1, 19].contains(k)), "{jumps:?}");
    }
}
