//! Directions of the lines that the sharp edges of a mesh form. Estimated normals of two faces tell the
//! direction of the edge between them badly where a face is narrow, as that of a blunt trailing edge is.

use std::collections::HashMap;

use super::surface::{MeshSurface, SHARP};
use super::weld::NONE;
use crate::geometry::{Point, Vector};

/// Of the corners of a mesh, the other ends of the sharp edges that meet there.
#[derive(Debug, Default)]
pub struct EdgeLines {
    ends: HashMap<u32, Vec<u32>>,
}

impl EdgeLines {
    /// The lines of the edges over which triangles do not meet smoothly, and of borders.
    pub fn new(surface: &MeshSurface, smooth: &[[bool; 3]]) -> Self {
        let mut ends: HashMap<u32, Vec<u32>> = HashMap::new();
        for (t, corners) in surface.triangles.iter().enumerate() {
            for k in (0..3).filter(|k| !smooth[t][*k]) {
                let across = surface.neighbours[t][k];
                // Each edge once.
                if across == NONE || t < across as usize {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    ends.entry(a).or_default().push(b);
                    ends.entry(b).or_default().push(a);
                }
            }
        }
        Self { ends }
    }

    /// The tangents at both ends of an edge, as long as the edge, of the line that it is part of: half way
    /// between the directions of two edges that are equally long. Beside a shorter one, at which a bend may
    /// begin, the edge is straighter. Where the line ends or has a corner the edge is a parabola. `None` for
    /// an edge of no line.
    pub fn tangents(&self, surface: &MeshSurface, edge: [u32; 2]) -> Option<[Vector; 2]> {
        let [a, b] = edge.map(|i| surface.points[i as usize]);
        let chord = b - a;
        let from = self.tangent(&surface.points, edge)?;
        let to = self.tangent(&surface.points, [edge[1], edge[0]])?.map(|tangent| -tangent);
        Some(match (from, to) {
            (Some(from), Some(to)) => [from, to],
            (Some(from), None) => [from, 2.0 * chord - from],
            (None, Some(to)) => [2.0 * chord - to, to],
            (None, None) => [chord; 2],
        })
    }

    /// The tangent at the beginning of an edge towards its end, as long as the edge; `Some(None)` where no
    /// other edge goes on smoothly there.
    fn tangent(&self, points: &[Point], [at, to]: [u32; 2]) -> Option<Option<Vector>> {
        let ends = self.ends.get(&at).filter(|ends| ends.contains(&to))?;
        let [origin, to_point] = [at, to].map(|i| points[i as usize]);
        let ahead = to_point - origin;
        let length = ahead.norm();
        let behind = ends.iter().filter(|end| **end != to).filter_map(|end| {
            let back = origin - points[*end as usize];
            let distance = back.norm();
            let cosine = back.dot(&ahead) / (distance * length);
            (cosine > SHARP).then_some((cosine, back / distance, distance))
        });
        let straightest = behind.max_by(|a, b| a.0.total_cmp(&b.0));
        Some(straightest.map(|(_, direction, distance)| {
            ahead + (direction * length - ahead) * (length.min(distance) / (length + distance))
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;

    #[test]
    fn a_sharp_edge_follows_its_line_and_stops_at_its_corners() {
        // A strip along an arc of 10 mm, and on straight behind a corner.
        let arc =
            |k: u32| Point::new(10.0 * (0.2 * f64::from(k)).sin(), 10.0 * (0.2 * f64::from(k)).cos(), 0.0);
        let mut line: Vec<Point> = (0..6).map(arc).collect();
        line.extend([3.0, 6.0].map(|x| arc(5) + Vector::new(x, x, 0.0)));
        let points = line.iter().flat_map(|p| [*p, p + Vector::new(0.0, 0.0, 1.0)]).collect();
        let triangles =
            (0..7).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3]]);
        let surface = MeshSurface::from_mesh(&TriangleMesh { points, triangles: triangles.collect() });
        let smooth: Vec<[bool; 3]> = surface.neighbours.iter().map(|n| n.map(|n| n != NONE)).collect();
        let lines = EdgeLines::new(&surface, &smooth);
        let along = |k: u32| Vector::new((0.2 * f64::from(k)).cos(), -(0.2 * f64::from(k)).sin(), 0.0);
        for k in 0..5 {
            let tangents = lines.tangents(&surface, [2 * k, 2 * k + 2]).expect("a border");
            for (tangent, at) in tangents.into_iter().zip([k, k + 1]) {
                assert!(tangent.angle(&along(at)) < 0.01, "{tangent} at {at}");
            }
        }
        let straight = lines.tangents(&surface, [10, 12]).expect("a border");
        assert!(straight.iter().all(|t| (t - Vector::new(3.0, 3.0, 0.0)).norm() < 1e-9), "{straight:?}");
        assert_eq!(lines.tangents(&surface, [0, 3]), None);
    }
}
