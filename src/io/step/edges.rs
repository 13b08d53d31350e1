//! Points of edges, computed once so that the faces on both sides share them.

use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};

use super::curve::Curve;
use super::model::{EntityFault, EntityResult};
use super::shape::ShapeReader;
use crate::geometry::{Point, Vector};

/// Pieces of a straight edge of a face that is not straight, so that its triangles are not slivers.
const STRAIGHT_PIECES: usize = 8;
/// Deepest halving of a piece of an edge.
const MAX_HALVINGS: usize = 9;
/// Vertices nearer than this are one point, mm.
const ONE_POINT: f64 = 1e-6;

/// How fine a body is meshed.
#[derive(Clone, Copy, Debug)]
pub struct StepFineness {
    /// Largest distance of a chord from its curve or surface, mm.
    pub chord_mm: f64,
    /// Largest angle between neighbouring chords, rad.
    pub turn_rad: f64,
}

/// The points of a body, with those of its edges.
pub struct EdgePoints<'m, 'a> {
    reader: ShapeReader<'m, 'a>,
    fineness: StepFineness,
    /// All points, mm, in the frame of the body's representation.
    pub points: Vec<Point>,
    vertices: HashMap<u32, u32>,
    edges: HashMap<u32, Vec<u32>>,
    /// Edges of faces that are curved in both directions.
    curved: HashSet<u32>,
}

impl<'m, 'a> EdgePoints<'m, 'a> {
    /// No points yet; `curved` are the edges of faces that are curved in both directions.
    pub fn new(reader: ShapeReader<'m, 'a>, fineness: StepFineness, curved: HashSet<u32>) -> Self {
        let (vertices, edges) = (HashMap::new(), HashMap::new());
        Self { reader, fineness, points: Vec::new(), vertices, edges, curved }
    }

    /// Adds a point and returns its number.
    pub fn add(&mut self, p: Point) -> u32 {
        self.points.push(p);
        (self.points.len() - 1) as u32
    }

    /// The number of a vertex, or of a corner of a polygon.
    ///
    /// # Errors
    /// When instance `id` is neither.
    pub fn vertex(&mut self, from: u32, id: u32) -> EntityResult<u32> {
        if let Some(known) = self.vertices.get(&id) {
            return Ok(*known);
        }
        let mm = self.reader.units.mm;
        let is_point = self.reader.model.instance(from, id)?.record("CARTESIAN_POINT").is_some();
        let p = if is_point {
            self.reader.model.point(from, id, mm)?
        } else {
            let a = self.reader.model.expect(from, id, &["VERTEX_POINT"])?;
            self.reader.model.point(id, a.reference(1)?, mm)?
        };
        let number = self.add(p);
        self.vertices.insert(id, number);
        Ok(number)
    }

    /// Points of an edge from its first to its second vertex.
    ///
    /// # Errors
    /// When instance `id` is not an edge, or its curve is not understood.
    pub fn edge(&mut self, from: u32, id: u32) -> EntityResult<Vec<u32>> {
        if let Some(known) = self.edges.get(&id) {
            return Ok(known.clone());
        }
        let a = self.reader.model.expect(from, id, &["EDGE_CURVE"])?;
        let (first, second) = (self.vertex(id, a.reference(1)?)?, self.vertex(id, a.reference(2)?)?);
        let same = a.is_true(4)?;
        let mut curve = self.reader.curve(id, a.reference(3)?)?;
        // The vertices trim it.
        while let Curve::Trimmed(basis, _) = curve {
            curve = *basis;
        }
        let (p, q) = (self.points[first as usize], self.points[second as usize]);
        let (start, end) = if same { (p, q) } else { (q, p) };
        let mut inner = self.inner_points(&curve, &start, &end, first == second, self.curved.contains(&id));
        if !same {
            inner.reverse();
        }
        self.reader.spend(id, inner.len() + 2)?;
        if inner.iter().any(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(EntityFault::new(id, "has points that are not finite"));
        }
        let mut edge = vec![first];
        edge.extend(inner.into_iter().map(|p| self.add(p)));
        edge.push(second);
        self.edges.insert(id, edge.clone());
        Ok(edge)
    }

    /// Points of a curve between two of its points.
    fn inner_points(
        &self,
        curve: &Curve,
        start: &Point,
        end: &Point,
        whole: bool,
        curved: bool,
    ) -> Vec<Point> {
        let StepFineness { chord_mm, turn_rad } = self.fineness;
        let even = |from: f64, to: f64, n: usize| -> Vec<Point> {
            (1..n).map(|k| curve.at(from + (to - from) * k as f64 / n as f64)).collect()
        };
        match curve {
            Curve::Line(..) => {
                let n = if curved { STRAIGHT_PIECES } else { 1 };
                (1..n).map(|k| start + (end - start) * (k as f64 / n as f64)).collect()
            }
            Curve::Ellipse(_, a, b) => {
                let from = curve.anomaly(start).unwrap_or(0.0);
                let mut to = curve.anomaly(end).unwrap_or(0.0);
                while to <= from + 1e-9 {
                    to += TAU;
                }
                if !whole && to - from > PI && (start - end).norm() < ONE_POINT {
                    to -= TAU;
                }
                let step = (2.0 * (1.0 - chord_mm / a.max(*b)).clamp(-1.0, 1.0).acos()).min(turn_rad);
                even(from, to, (((to - from) / step.max(1e-4)).ceil() as usize).clamp(2, 100_000))
            }
            _ => {
                let (low, high) = curve.span();
                let period = high - low;
                let closed = curve.is_closed();
                let (mut from, mut to) = (curve.nearest(start), curve.nearest(end));
                if closed {
                    if whole {
                        to = from + period;
                    } else if to <= from + 1e-9 * period {
                        to += period;
                    }
                } else {
                    // A curve that nearly meets itself may be near to its other end.
                    if (curve.at(low) - start).norm() < ONE_POINT {
                        from = low;
                    }
                    if (curve.at(high) - end).norm() < ONE_POINT {
                        to = high;
                    }
                }
                let at = |t: f64| curve.at(if closed && t > high { t - period } else { t });
                let mut breaks = vec![from];
                for turn in [0.0, period] {
                    let shifted = curve.breaks().into_iter().map(|b| b + turn);
                    breaks.extend(shifted.filter(|b| *b > from + 1e-9 * period && *b < to - 1e-9 * period));
                    if !closed {
                        break;
                    }
                }
                breaks.push(to);
                breaks.sort_by(f64::total_cmp);
                let mut inner = Vec::new();
                for (k, w) in breaks.windows(2).enumerate() {
                    if k > 0 {
                        inner.push(at(w[0]));
                    }
                    halve(&at, (w[0], w[1]), self.fineness, MAX_HALVINGS, &mut inner);
                }
                if inner.is_empty() && curved {
                    let n = STRAIGHT_PIECES;
                    inner = (1..n).map(|k| at(from + (to - from) * k as f64 / n as f64)).collect();
                }
                inner
            }
        }
    }
}

/// Distance of `p` from the line through `a` and `b`, mm.
pub fn off_line(p: &Point, a: &Point, b: &Point) -> f64 {
    let d = b - a;
    d.try_normalize(1e-12).map_or((p - a).norm(), |d: Vector| (p - a).cross(&d).norm())
}

/// Halves a piece of a curve until its chords are fine enough, and adds the points between its ends.
fn halve(
    at: &impl Fn(f64) -> Point,
    piece: (f64, f64),
    fineness: StepFineness,
    left: usize,
    out: &mut Vec<Point>,
) {
    let (a, b) = piece;
    let m = 0.5 * (a + b);
    let (p, q, r) = (at(a), at(m), at(b));
    let (s, t) = (at(0.75 * a + 0.25 * b), at(0.25 * a + 0.75 * b));
    let off = [s, q, t].iter().map(|x| off_line(x, &p, &r)).fold(0.0, f64::max);
    let (first, last) = (s - p, r - t);
    let turn = if first.norm() > 1e-9 && last.norm() > 1e-9 { first.angle(&last) } else { 0.0 };
    if left > 0 && (off > fineness.chord_mm || turn > fineness.turn_rad) {
        halve(at, (a, m), fineness, left - 1, out);
        out.push(q);
        halve(at, (m, b), fineness, left - 1, out);
    }
}
