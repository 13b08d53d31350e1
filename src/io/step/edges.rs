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
/// Number of points of an edge of which the distance from another edge is looked at.
const COMPARED: usize = 9;
/// Largest number of edges between the same two vertices that are looked at.
const MAX_BETWEEN: usize = 32;

/// How fine a body is meshed.
#[derive(Clone, Copy, Debug)]
pub struct StepFineness {
    /// Largest distance of a chord from its curve or surface, mm.
    pub chord_mm: f64,
    /// Largest angle between neighbouring chords, rad.
    pub turn_rad: f64,
    /// Distance within which vertices, and edges between the same vertices, are one, mm: 0 for solids, whose
    /// faces share them.
    pub join_mm: f64,
}

/// The points of a body, with those of its edges.
pub struct EdgePoints<'m, 'a> {
    reader: ShapeReader<'m, 'a>,
    fineness: StepFineness,
    /// All points, mm, in the frame of the body's representation.
    pub points: Vec<Point>,
    vertices: HashMap<u32, u32>,
    edges: HashMap<u32, Vec<u32>>,
    /// Vertices by cells of the joining distance, and edges by their ends, of sheets that are to be joined.
    cells: HashMap<[i64; 3], Vec<u32>>,
    between: HashMap<(u32, u32), Vec<u32>>,
    /// Whole circles and ellipses of them, by cells of their centres: seams may be at different places.
    rounds: HashMap<[i64; 3], Vec<u32>>,
    /// Edges of faces that are curved in both directions.
    curved: HashSet<u32>,
}

impl<'m, 'a> EdgePoints<'m, 'a> {
    /// No points yet; `curved` are the edges of faces that are curved in both directions.
    pub fn new(reader: ShapeReader<'m, 'a>, fineness: StepFineness, curved: HashSet<u32>) -> Self {
        let (vertices, edges) = (HashMap::new(), HashMap::new());
        let (cells, between, rounds) = (HashMap::new(), HashMap::new(), HashMap::new());
        Self { reader, fineness, points: Vec::new(), vertices, edges, cells, between, rounds, curved }
    }

    /// The number of a vertex at a place: that of one nearby where sheets are joined.
    fn vertex_at(&mut self, p: Point) -> u32 {
        let join = self.fineness.join_mm;
        if join <= 0.0 {
            return self.add(p);
        }
        let cell = cell_of(&p, join);
        let known = cells_about(cell).filter_map(|cell| self.cells.get(&cell)).flatten();
        let distance = |i: &u32| (self.points[*i as usize] - p).norm();
        let nearest = known.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(near) = nearest.copied().filter(|i| distance(i) <= join) {
            return near;
        }
        let number = self.add(p);
        self.cells.entry(cell).or_default().push(number);
        number
    }

    /// Whether points lie along a known edge, within `limit`, mm.
    fn is_along(&self, edge: &[u32], points: &[Point], limit: f64) -> bool {
        let place = |i: u32| self.points[i as usize];
        let off = |p: &Point| {
            let pieces = edge.windows(2).map(|w| off_piece(p, &place(w[0]), &place(w[1])));
            pieces.fold(f64::INFINITY, f64::min)
        };
        let step = points.len().div_ceil(COMPARED).max(1);
        points.iter().skip(step / 2).step_by(step).all(|p| off(p) < limit)
    }

    /// As [`Self::joined`], of a whole circle or ellipse about `centre` from `start`: the points of the known
    /// one, from that which is nearest to `start`.
    fn joined_round(&self, centre: &Point, start: &Point, inner: &[Point]) -> Option<Vec<u32>> {
        let (join, limit) = (self.fineness.join_mm, self.fineness.join_mm + 2.0 * self.fineness.chord_mm);
        let known = cells_about(cell_of(centre, join)).filter_map(|cell| self.rounds.get(&cell)).flatten();
        let mut known = known.take(MAX_BETWEEN).filter_map(|id| self.edges.get(id));
        let edge = known.find(|edge| self.is_along(edge, inner, limit))?;
        self.ring_from(edge, start, inner)
    }

    /// A known closed edge from its point nearest to `start`, in the direction of `inner`.
    fn ring_from(&self, edge: &[u32], start: &Point, inner: &[Point]) -> Option<Vec<u32>> {
        let mut ring = edge.get(1..)?.to_vec();
        let nearest = |ring: &[u32], p: &Point| {
            let distance = |k: &usize| (self.points[ring[*k] as usize] - p).norm();
            (0..ring.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let first = nearest(&ring, start)?;
        ring.rotate_left(first);
        if 2 * nearest(&ring, inner.get(inner.len() / 4)?)? > ring.len() {
            ring[1..].reverse();
        }
        ring.push(*ring.first()?);
        Some(ring)
    }

    /// The points, from `first` to `second`, of a known edge between these vertices along which `inner` are.
    fn joined(&self, first: u32, second: u32, inner: &[Point]) -> Option<Vec<u32>> {
        let limit = self.fineness.join_mm + 2.0 * self.fineness.chord_mm;
        let is_along = |edge: &&Vec<u32>| match inner {
            // A straight one, of which the other may have points in between.
            [] => {
                let (a, b) = (self.points[first as usize], self.points[second as usize]);
                edge.iter().all(|i| off_piece(&self.points[*i as usize], &a, &b) < limit)
            }
            _ => self.is_along(edge, inner, limit),
        };
        let known = self.between.get(&(first.min(second), first.max(second)))?;
        let mut known = known.iter().take(MAX_BETWEEN).filter_map(|id| self.edges.get(id));
        let mut edge = known.find(is_along)?.clone();
        if first == second {
            return self.ring_from(&edge, &self.points[first as usize], inner);
        }
        if edge.first() != Some(&first) {
            edge.reverse();
        }
        Some(edge)
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
        let number = self.vertex_at(p);
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
        let whole = a.reference(1)? == a.reference(2)?;
        let same = a.is_true(4)?;
        let mut curve = self.reader.curve(id, a.reference(3)?)?;
        // The vertices trim it.
        while let Curve::Trimmed(basis, _) = curve {
            curve = *basis;
        }
        let (p, q) = (self.points[first as usize], self.points[second as usize]);
        let (start, end) = if same { (p, q) } else { (q, p) };
        let mut inner = self.inner_points(&curve, &start, &end, whole, self.curved.contains(&id));
        if !same {
            inner.reverse();
        }
        self.reader.spend(id, inner.len() + 2)?;
        if inner.iter().any(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(EntityFault::new(id, "has points that are not finite"));
        }
        if self.fineness.join_mm > 0.0 {
            let centre = match curve {
                Curve::Ellipse(frame, ..) if whole => Some(frame.origin),
                _ => None,
            };
            let round = centre.and_then(|centre| self.joined_round(&centre, &start, &inner));
            if let Some(edge) = round.or_else(|| self.joined(first, second, &inner)) {
                self.edges.insert(id, edge.clone());
                return Ok(edge);
            }
            if let Some(centre) = centre {
                let cell = cell_of(&centre, self.fineness.join_mm);
                self.rounds.entry(cell).or_default().push(id);
            }
            self.between.entry((first.min(second), first.max(second))).or_default().push(id);
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
        let StepFineness { chord_mm, turn_rad, .. } = self.fineness;
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

/// The cell of a place in a grid of a width, mm.
fn cell_of(p: &Point, width: f64) -> [i64; 3] {
    [p.x, p.y, p.z].map(|x| (x / width).floor() as i64)
}

/// A cell and those that touch it.
fn cells_about(cell: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let steps = (0..27_i64).map(|k| [k % 3, k / 3 % 3, k / 9]);
    steps.map(move |d| [0, 1, 2].map(|k: usize| cell[k].saturating_add(d[k] - 1)))
}

/// Distance of `p` from the line through `a` and `b`, mm.
pub fn off_line(p: &Point, a: &Point, b: &Point) -> f64 {
    let d = b - a;
    d.try_normalize(1e-12).map_or((p - a).norm(), |d: Vector| (p - a).cross(&d).norm())
}

/// Distance of `p` from the straight piece between `a` and `b`, mm.
fn off_piece(p: &Point, a: &Point, b: &Point) -> f64 {
    let d = b - a;
    let share = ((p - a).dot(&d) / d.norm_squared().max(1e-300)).clamp(0.0, 1.0);
    (p - (a + d * share)).norm()
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
