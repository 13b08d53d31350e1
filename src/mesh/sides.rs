//! Splits a slice of a blade into its two sides at leading and trailing edge.

use super::end_faces::{EndFaces, find_nose_line, find_nose_seam};
use super::sections::{SlicePiece, SlicePoint, knots_of};
use crate::geometry::cubic::{Cubic, chord_lengths};
use crate::geometry::{Point, Vector, wrap_angle};

/// Shares of the length within which a sharp edge is the leading or trailing edge.
const AT_LEADING: f64 = 0.05;
const AT_TRAILING: f64 = 0.15;
/// Share of the length within which both ends of a flat trailing edge are from the point furthest downstream.
const NEAR_TAIL: f64 = 0.02;
/// Largest rise of a flat trailing edge over the chord between its ends, as a share of that. A semicircle
/// rises by half of it.
const FLAT: f64 = 0.25;
/// Points closer together than this share of the local spacing are merged.
const CROWDED: f64 = 0.35;
/// Points that are nearer to each other than they were moved off their chords are merged up to this distance,
/// mm.
const CERTAIN: f64 = 0.01;
/// Share of the parameter range of a side that its nose takes (and a round trailing edge as much again).
const NOSE_SHARE: f64 = 0.35;
/// Both ends of a gap at an open leading or trailing edge are within this share of the length from it.
const AT_GAP: f64 = 0.05;
/// Widest gap that is bridged anywhere else, as a share of the length.
const BRIDGED: f64 = 0.01;
/// Way back of a side around the hindmost point from which on its trailing edge is round, as a share of the
/// length.
const BACK: f64 = 1e-4;
/// How many times the distance of points further than the nearest one a point of a seam may be from the place
/// where it is expected.
const LINE_NEAR: f64 = 3.0;
/// Fewest points of a slice, as of a plate, and that a side is interpolated through.
const FEWEST: usize = 4;
/// Share of a side's length at which the thickness of the nose is measured.
const NOSE_END: f64 = 0.04;

/// One side of a slice, from leading to trailing edge.
#[derive(Clone, Debug)]
pub struct SideCurve {
    /// x, y, z (mm) and the relative position from inlet to outlet, over chord length.
    curve: Cubic<4>,
    /// Pairs of chord length and parameter, which is 0 at the leading and 1 at the trailing edge.
    table: Vec<(f64, f64)>,
}

/// Where the two sides of a slice are to begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BeginRule {
    /// At corners, faces or seams of the leading edge where there are any, else at the foremost point.
    AsFound,
    /// At the one line where the faces of both sides meet, even if it is at the end of the nose.
    AtLine,
    /// At the foremost point.
    AtForemost,
    /// Near this place.
    Near(Point),
}

/// Where the two sides of a slice are to begin and to end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitRule {
    /// Where they begin.
    pub begin: BeginRule,
    /// Where they end: near a place, or, without one, at corners, faces or seams of the trailing edge where
    /// there are any, else at the hindmost point.
    pub end: Option<Point>,
}

impl SplitRule {
    /// Where corners, faces and seams of the edges are.
    pub const AS_FOUND: Self = Self { begin: BeginRule::AsFound, end: None };
}

/// What is where two sides of a slice begin, or end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// A face of the edge.
    Face,
    /// The line where the faces of both sides meet: a corner, or a seam.
    Line,
    /// Neither: the foremost or the hindmost point.
    Round,
}

/// Both sides of a slice: first the one at the smaller angle about the axis.
#[derive(Clone, Debug)]
pub struct SpanSection {
    /// The sides.
    pub sides: [SideCurve; 2],
    /// Gap between the ends of the slice at leading and trailing edge, mm; 0 where the blade is closed.
    pub gaps: [f64; 2],
    /// Whether both sides go round to one point at the trailing edge.
    pub has_round_tail: bool,
    /// What is at leading and trailing edge.
    pub edges: [EdgeKind; 2],
}

impl SideCurve {
    fn new(points: &[SlicePoint]) -> Option<Self> {
        let mut raw: Vec<([f64; 4], bool)> =
            thinned(points).iter().map(|p| ([p.point.x, p.point.y, p.point.z, p.along], p.edge)).collect();
        raw.dedup_by(|(a, _), (b, _)| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() + (a[2] - b[2]).abs() < 1e-9);
        if raw.len() < 2 {
            return None;
        }
        // A plane side may have corners at its ends only.
        while raw.len() < FEWEST {
            let length = |k: &usize| (0..3).map(|i| (raw[k + 1].0[i] - raw[*k].0[i]).powi(2)).sum::<f64>();
            let longest = (0..raw.len() - 1).max_by(|a, b| length(a).total_cmp(&length(b)))?;
            let middle = std::array::from_fn(|i| 0.5 * (raw[longest].0[i] + raw[longest + 1].0[i]));
            raw.insert(longest + 1, (middle, false));
        }
        let places: Vec<[f64; 3]> = raw.iter().map(|(p, _)| [p[0], p[1], p[2]]).collect();
        // A blunt edge has a corner where the side begins.
        let corners: Vec<usize> = (0..raw.len()).filter(|&k| raw[k].1).collect();
        let values: Vec<[f64; 4]> = raw.into_iter().map(|(p, _)| p).collect();
        let curve = Cubic::interpolate_with_corners(&chord_lengths(&places), &values, &corners);
        Some(Self { curve, table: Vec::new() })
    }

    fn length(&self) -> f64 {
        self.curve.domain().1
    }

    fn raw(&self, t: f64) -> Point {
        let [x, y, z, _] = self.curve.point(t);
        Point::new(x, y, z)
    }

    /// Defines the parameter: by position along the channel, and by arc length around the nose (half
    /// thickness `nose`, mm) and around a round trailing edge (half thickness `tail`), where the position
    /// hardly changes.
    fn parametrise(&mut self, nose: f64, tail: Option<f64>) {
        let length = self.length();
        let knots = self.curve.knots();
        let mut nodes: Vec<f64> = Vec::with_capacity(4 * knots.len());
        for pair in knots.windows(2) {
            nodes.extend((0..4).map(|k| pair[0] + (pair[1] - pair[0]) * f64::from(k) / 4.0));
        }
        nodes.push(length);
        let approached = |t: f64| 1.0 - (-t / (1.2 * nose)).exp();
        let mut along = vec![0.0];
        let mut total = 0.0;
        for pair in nodes.windows(2) {
            let gain = (self.curve.point(pair[1])[3] - self.curve.point(pair[0])[3])
                .max(1e-9 * (pair[1] - pair[0]) / length);
            let middle = 0.5 * (pair[0] + pair[1]);
            total += gain
                * approached(middle)
                * tail.map_or(1.0, |b| 1.0 - (-(length - middle) / (1.2 * b)).exp());
            along.push(total);
        }
        let round = |t: f64, a: f64| NOSE_SHARE * (1.0 - (-t / (2.0 * a)).exp());
        let value = |i: usize| {
            let end = tail.map_or(0.0, |b| round(length, b) - round(length - nodes[i], b));
            along[i] / total.max(1e-300) + round(nodes[i], nose) + end
        };
        let whole = value(nodes.len() - 1);
        self.table = (0..nodes.len()).map(|i| (nodes[i], value(i) / whole)).collect();
    }

    /// Point at parameter `w` (0 leading, 1 trailing edge).
    pub fn point(&self, w: f64) -> Point {
        self.raw(self.way_mm(w))
    }

    fn way_mm(&self, w: f64) -> f64 {
        let i = self.table.partition_point(|(_, v)| *v < w).clamp(1, self.table.len() - 1);
        let ((t0, w0), (t1, w1)) = (self.table[i - 1], self.table[i]);
        let share = if w1 > w0 { ((w - w0) / (w1 - w0)).clamp(0.0, 1.0) } else { 0.0 };
        t0 + (t1 - t0) * share
    }

    /// Way along the side at parameter `w`, as a share of its length.
    pub fn way(&self, w: f64) -> f64 {
        self.way_mm(w) / self.length()
    }

    /// Gives the side the parameters with these ways, at even steps from 0 to 1.
    pub fn set_ways(&mut self, ways: &[f64]) {
        let (length, last) = (self.length(), ways.len().saturating_sub(1).max(1) as f64);
        self.table = ways.iter().enumerate().map(|(k, way)| (way * length, k as f64 / last)).collect();
    }

    /// Change of the angle about the axis from leading to trailing edge, rad.
    pub fn wrap_rad(&self) -> f64 {
        let angle = |p: Point| p.y.atan2(p.x);
        (0..64)
            .map(|i| {
                let w = |i: i32| f64::from(i) / 64.0;
                wrap_angle(angle(self.point(w(i + 1))) - angle(self.point(w(i))))
            })
            .sum()
    }
}

impl SpanSection {
    /// Joins the pieces of a slice, longest first, and splits them into sides. `None` where they do not form
    /// a blade section.
    pub fn from_cuts(cuts: &[SlicePiece], rule: SplitRule) -> Option<Self> {
        let (line, gaps) = chain_pieces(cuts)?;
        let SplitSlice { mut first, mut second, round_tail, edges } = split(&line, rule)?;
        let mut sides = [SideCurve::new(&first)?, SideCurve::new(&second)?];
        let at = |side: &SideCurve, share: f64| side.raw(share * side.length());
        // The sides are ordered by their angle half way along, where both are at nearly the same radius.
        let (a, b) = (at(&sides[0], 0.5), at(&sides[1], 0.5));
        if wrap_angle(a.y.atan2(a.x) - b.y.atan2(b.x)) > 0.0 {
            sides.swap(0, 1);
            std::mem::swap(&mut first, &mut second);
        }
        let mut section = Self { sides, gaps, has_round_tail: round_tail, edges };
        section.parametrise(round_tail);
        Some(section)
    }

    /// Defines the parameters of both sides, with a round trailing edge or without. Those of sections that
    /// the sides of a blade are laid through have to agree in it.
    pub fn parametrise(&mut self, round_tail: bool) {
        let at = |side: &SideCurve, share: f64| side.raw(share * side.length());
        let sides = &self.sides;
        let thickness = |share: f64| {
            let from = at(&sides[0], share);
            (0..=200)
                .map(|k| (at(&sides[1], share + 0.1 * (f64::from(k) / 100.0 - 1.0)) - from).norm())
                .fold(f64::INFINITY, f64::min)
        };
        let least = 1e-4 * sides[0].length();
        let nose = (0.5 * thickness(NOSE_END)).max(least);
        let tail = round_tail.then(|| (0.5 * thickness(1.0 - NOSE_END)).max(least));
        self.has_round_tail = round_tail;
        self.sides.iter_mut().for_each(|s| s.parametrise(nose, tail));
    }
}

/// Merges points that are too close together: keeps the one of two that was moved less off its chord, and all
/// on sharp edges.
fn thinned(points: &[SlicePoint]) -> Vec<SlicePoint> {
    let last = points.len() - 1;
    let mut kept: Vec<SlicePoint> = vec![points[0]];
    for i in 1..=last {
        let (from, to) = (i.saturating_sub(2), (i + 2).min(last));
        let spacing = (points[to].point - points[from].point).norm() / (to - from) as f64;
        let (Some(previous), point) = (kept.last().copied(), points[i]) else { break };
        // Nearer to each other than they are certain, two points tell no direction.
        let certain = (previous.chord_offset_mm + point.chord_offset_mm).min(CERTAIN);
        let is_crowded = (point.point - previous.point).norm() < certain.max(CROWDED * spacing);
        let replaces = i == last || point.edge || point.chord_offset_mm < previous.chord_offset_mm;
        if is_crowded && replaces && !previous.edge && kept.len() > 1 {
            kept.pop();
            kept.push(point);
        } else if !is_crowded || point.edge || i == last {
            kept.push(point);
        }
    }
    kept
}

/// Chains the pieces of a slice, nearest ends first, to a line that is closed or open at the trailing edge.
/// Also returns the widths of the gaps that were bridged at leading and trailing edge, mm. `None` where
/// another gap is too wide.
fn chain_pieces(cuts: &[SlicePiece]) -> Option<(SlicePiece, [f64; 2])> {
    let longest = cuts.first()?;
    if longest.closed {
        return Some((longest.clone(), [0.0; 2]));
    }
    let length =
        |cut: &SlicePiece| cut.points.windows(2).map(|w| (w[1].point - w[0].point).norm()).sum::<f64>();
    let whole = length(longest);
    let mut rest: Vec<SlicePiece> =
        cuts[1..].iter().filter(|c| !c.closed && length(c) > 0.01 * whole).take(16).cloned().collect();
    let (low, high) = cuts
        .iter()
        .map(|c| extent(&c.points))
        .fold(extent(&longest.points), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    // A blade may be open at leading and trailing edge; a wide gap elsewhere is a hole.
    let sound = |a: &SlicePoint, b: &SlicePoint| {
        let near = |end: f64| (a.along - end).abs().max((b.along - end).abs()) < AT_GAP * (high - low);
        near(low) || near(high) || (a.point - b.point).norm() < BRIDGED * whole
    };
    let mut gaps: [f64; 2] = [0.0; 2];
    let mut bridge = |a: &SlicePoint, b: &SlicePoint| {
        let gap = &mut gaps[usize::from(a.along + b.along > low + high)];
        *gap = gap.max((a.point - b.point).norm());
    };
    let mut line = longest.points.clone();
    while !rest.is_empty() {
        let (first, last) = (line[0].point, line[line.len() - 1].point);
        let mut best: Option<(f64, usize, bool, bool)> = None;
        for (k, cut) in rest.iter().enumerate() {
            for (at_end, from) in [(true, last), (false, first)] {
                for (reversed, to) in [(false, cut.points[0]), (true, cut.points[cut.points.len() - 1])] {
                    let gap = (to.point - from).norm();
                    if best.is_none_or(|b| gap < b.0) {
                        best = Some((gap, k, at_end, reversed));
                    }
                }
            }
        }
        let (_, k, at_end, reversed) = best?;
        let mut piece = rest.remove(k).points;
        if reversed == at_end {
            piece.reverse();
        }
        if !at_end {
            std::mem::swap(&mut line, &mut piece);
        }
        if !sound(&line[line.len() - 1], &piece[0]) {
            return None;
        }
        bridge(&line[line.len() - 1], &piece[0]);
        line.extend(piece);
    }
    let (first, last) = (line[0], line[line.len() - 1]);
    if !sound(&first, &last) {
        return None;
    }
    bridge(&first, &last);
    let gap_at_leading = 0.5 * (first.along + last.along) < 0.5 * (low + high);
    let met = (first.point - last.point).norm() < 1e-3 * whole;
    Some((SlicePiece { points: line, closed: met || gap_at_leading }, gaps))
}

fn extent(points: &[SlicePoint]) -> (f64, f64) {
    points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.along), high.max(p.along)))
}

struct SplitSlice {
    first: Vec<SlicePoint>,
    second: Vec<SlicePoint>,
    round_tail: bool,
    edges: [EdgeKind; 2],
}

fn split(cut: &SlicePiece, rule: SplitRule) -> Option<SplitSlice> {
    let points = &cut.points;
    let n = points.len();
    if n < FEWEST {
        return None;
    }
    let (low, high) = extent(points);
    let range = high - low;
    let lowest = (0..n).min_by(|&a, &b| points[a].along.total_cmp(&points[b].along))?;
    let step = |i: usize, forward: bool| -> Option<usize> {
        match (forward, cut.closed) {
            (true, true) => Some((i + 1) % n),
            (false, true) => Some((i + n - 1) % n),
            (true, false) => Some(i + 1).filter(|i| *i < n),
            (false, false) => i.checked_sub(1),
        }
    };
    // The leading edge is a sharp edge, the middle of two (blunt), or else the point furthest upstream.
    let edge_from = |forward: bool| {
        let mut at = lowest;
        for _ in 0..n {
            if points[at].edge && points[at].along < low + AT_LEADING * range {
                return Some(at);
            }
            at = step(at, forward)?;
            if points[at].along > low + AT_LEADING * range {
                return None;
            }
        }
        None
    };
    // Faces of its own tell it best.
    let as_found = rule.begin == BeginRule::AsFound;
    let faces = if as_found { EndFaces::find(points, &step, lowest) } else { None };
    let is_corner = faces.is_some_and(|faces| faces.from == faces.to);
    let faces = faces.and_then(|faces| faces.middle(points, &step));
    let edges = if as_found { [edge_from(true), edge_from(false)] } else { [None; 2] };
    let line = match rule.begin {
        BeginRule::AsFound => find_nose_seam(points, &step, lowest),
        BeginRule::AtLine => Some(find_nose_line(points, &step, lowest)?),
        BeginRule::AtForemost => None,
        BeginRule::Near(place) => nearest_line(points, &place),
    };
    let beginning = match (&faces, edges, line) {
        (Some(_), ..) if is_corner => EdgeKind::Line,
        (None, [Some(a), Some(b)], _) if a == b => EdgeKind::Line,
        (Some(_), ..) | (None, [Some(_), Some(_)], _) => EdgeKind::Face,
        (.., Some(_)) => EdgeKind::Line,
        _ => EdgeKind::Round,
    };
    let mut starts = [lowest; 2];
    let leading = match (faces, edges[0], edges[1]) {
        (Some((middle, beside)), ..) => {
            starts = beside;
            middle
        }
        (None, Some(a), Some(b)) if a == b => points[a],
        (None, Some(a), Some(b)) => {
            let middle = points[a].point + (points[b].point - points[a].point) * 0.5;
            SlicePoint {
                point: middle,
                along: 0.5 * (points[a].along + points[b].along),
                edge: true,
                seam: false,
                chord_offset_mm: 0.0,
            }
        }
        _ => match line {
            Some(seam) => {
                starts = [seam; 2];
                points[seam]
            }
            None => refine_extreme(points, lowest, &step, 1.0),
        },
    };
    let highest = (0..n).max_by(|&a, &b| points[a].along.total_cmp(&points[b].along))?;
    let flat_tail = flat_tail(points, &step, high - NEAR_TAIL * range);
    let tail = match rule.end {
        Some(place) => nearest_line(points, &place).map(|at| EndFaces { from: at, to: at }),
        None => EndFaces::find(points, &step, highest),
    };
    let side = |forward: bool| {
        let mut line = vec![leading];
        let start = starts[usize::from(!forward)];
        let mut at = start;
        let mut round = true;
        for k in 0..n {
            let p = points[at];
            // Near the nose, points on the other side of the leading edge belong to the other side of the
            // blade.
            if k > 2 || faces.is_some() || ahead(points, &step, start, forward, &leading.point, &p.point) {
                line.push(p);
            }
            let at_flat_tail = flat_tail.is_some_and(|ends| ends.contains(&at));
            let at_end = match tail {
                Some(tail) => at == tail.from || at == tail.to,
                None => p.edge && p.along > high - AT_TRAILING * range,
            };
            if at_flat_tail || at_end && k > 0 {
                round = false;
                break;
            }
            match step(at, forward) {
                Some(next) => at = next,
                None => {
                    round = false;
                    break;
                }
            }
            // A round trailing edge may have its corner, where both sides meet, beside its hindmost point.
            if round
                && tail.is_none()
                && points[at].along < p.along
                && p.along > high - 0.02 * range
                && k > n / 8
            {
                break;
            }
        }
        (line, round)
    };
    let ((mut first, round_first), (mut second, round_second)) = (side(true), side(false));
    let mut round_tail = round_first && round_second;
    if round_tail {
        let trailing = refine_extreme(points, highest, &step, -1.0);
        for line in [&mut first, &mut second] {
            line.retain(|p| (p.point - trailing.point).norm() > 1e-9);
            line.push(trailing);
        }
    }
    let end = match tail {
        Some(tail) if tail.from == tail.to => EdgeKind::Line,
        None if round_tail => EdgeKind::Round,
        _ => EdgeKind::Face,
    };
    let turns_back =
        |line: &[SlicePoint]| line.last().is_some_and(|end| extent(line).1 - end.along > BACK * range);
    round_tail |= end == EdgeKind::Line && (turns_back(&first) || turns_back(&second));
    let edges = [beginning, end];
    (first.len() > 1 && second.len() > 1).then_some(SplitSlice { first, second, round_tail, edges })
}

/// The point of a seam or a corner that is nearest to `place`, or, where none is near it, the nearest of all.
fn nearest_line(points: &[SlicePoint], place: &Point) -> Option<usize> {
    let off = |i: &usize| (points[*i].point - place).norm();
    let nearest = |keep: &dyn Fn(&SlicePoint) -> bool| {
        (0..points.len()).filter(|i| keep(&points[*i])).min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    let any = nearest(&|_| true)?;
    let about = |i: usize| (points[(i + 1) % points.len()].point - points[i].point).norm();
    let reach = off(&any) + LINE_NEAR * about(any);
    nearest(&|p| p.edge || p.seam).filter(|line| off(line) < reach).or(Some(any))
}

/// The seams at both ends of a trailing edge that is nearly flat and has a face of its own: its corners may
/// be too obtuse for sharp edges. `None` unless there are exactly two seams beyond `level`.
fn flat_tail(
    points: &[SlicePoint],
    step: &impl Fn(usize, bool) -> Option<usize>,
    level: f64,
) -> Option<[usize; 2]> {
    let highest = (0..points.len()).max_by(|&a, &b| points[a].along.total_cmp(&points[b].along))?;
    let walk = |forward: bool| {
        let beyond = move |at: &usize| step(*at, forward).filter(|next| points[*next].along > level);
        std::iter::successors(beyond(&highest), beyond).take(points.len() / 2)
    };
    let mut run: Vec<usize> = walk(false).collect();
    run.reverse();
    run.push(highest);
    run.extend(walk(true));
    let mut seams = (0..run.len()).filter(|&k| points[run[k]].seam);
    let (Some(from), Some(to), None) = (seams.next(), seams.next(), seams.next()) else { return None };
    let ends = [run[from], run[to]];
    let chord = points[ends[1]].point - points[ends[0]].point;
    let across = chord.try_normalize(1e-9)?;
    let rise = |at: &usize| (points[*at].point - points[ends[0]].point).cross(&across).norm();
    let is_flat = run[from..=to].iter().all(|at| rise(at) < FLAT * chord.norm());
    is_flat.then_some(ends)
}

/// Whether `p`, near the leading edge, is ahead of it in the direction `forward`.
fn ahead(
    points: &[SlicePoint],
    step: &impl Fn(usize, bool) -> Option<usize>,
    lowest: usize,
    forward: bool,
    leading: &Point,
    p: &Point,
) -> bool {
    let (Some(next), Some(previous)) = (step(lowest, forward), step(lowest, !forward)) else { return true };
    let step: Vector = points[next].point - points[previous].point;
    (p - leading).dot(&step) > 0.05 * (points[next].point - points[lowest].point).norm() * step.norm() * 0.2
}

/// The minimum of `sign` · along on a cubic spline through the points around `at`, by dense sampling.
fn refine_extreme(
    points: &[SlicePoint],
    at: usize,
    step: &impl Fn(usize, bool) -> Option<usize>,
    sign: f64,
) -> SlicePoint {
    let (mut before, mut after) = (vec![at], vec![at]);
    for (line, forward) in [(&mut before, false), (&mut after, true)] {
        for _ in 0..4 {
            let Some(next) = line.last().and_then(|i| step(*i, forward)) else { break };
            line.push(next);
        }
    }
    before.reverse();
    let around: Vec<usize> = before.iter().chain(&after[1..]).copied().collect();
    let raw: Vec<[f64; 4]> = around.iter().map(|&i| points[i].values()).collect();
    let Some(knots) = knots_of(&raw).filter(|_| before.len() > 1 && after.len() > 1) else {
        return points[at];
    };
    let curve = Cubic::interpolate(&knots, &raw);
    let (from, to) = (knots[before.len() - 2], knots[before.len()]);
    let best = (0..=400)
        .map(|k| curve.point(from + (to - from) * f64::from(k) / 400.0))
        .min_by(|a, b| (sign * a[3]).total_cmp(&(sign * b[3])));
    best.map_or(points[at], SlicePoint::from_values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_trailing_edge_ends_the_sides_at_its_obtuse_corners() {
        // Half a section from its nose to the middle of a flat end 1 mm wide, chamfered on both sides.
        let half = |sign: f64| {
            let sides = (1..=40).map(move |k| (40.0 * f64::from(k) / 40.0, sign));
            let tail = [(40.5, 0.5 * sign), (40.5 - 1e-4, 0.3 * sign), (40.5, 0.1 * sign)];
            sides.chain(tail)
        };
        let outline = std::iter::once((0.0, 0.0))
            .chain(half(1.0))
            .chain(half(-1.0).collect::<Vec<_>>().into_iter().rev());
        let points: Vec<SlicePoint> = outline
            .map(|(x, y)| {
                let seam = x == 40.5 && y.abs() == 0.5;
                SlicePoint { point: Point::new(x, y, 0.0), along: x, edge: false, seam, chord_offset_mm: 0.0 }
            })
            .collect();
        let split =
            split(&SlicePiece { points, closed: true }, SplitRule::AS_FOUND).expect("it has two sides");
        assert!(!split.round_tail);
        let ends = [split.first, split.second].map(|side| side.last().map(|p| (p.point.x, p.point.y.abs())));
        assert_eq!(ends, [Some((40.5, 0.5)); 2]);
    }
}
