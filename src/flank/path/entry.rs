//! How a pass is reached: over the layer from the pass before, or from above the blank.

use std::cell::OnceCell;

use super::approach::{ApproachStep, approach, needs_ramp};
use super::cut_space::CutSpace;
use super::inputs::{LayerPasses, Pass, PathMaker};
use super::moves::is_same;
use crate::cutting::retract::{RetractSurface, bottom_clearance, retract_clear};
use crate::flank::layer::LayerPoint;
use crate::geometry::{Point, Vector};
use crate::toolpath::RAPID_MM_PER_MIN;

/// Maximum turn of the axis on a link, rad.
const MAX_LINK_TURN: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Spacing of positions along a link, mm.
const LINK_STEP: f64 = 0.5;
/// Maximum turn of the axis between them, rad: the far end of a long tool then swings by half a millimetre.
const LINK_TURN: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// An end of a pass.
#[derive(Clone, Copy)]
pub(super) struct PassEnd {
    /// Its layer point.
    pub(super) place: LayerPoint,
    /// Tip and unit axis.
    pub(super) position: (Point, Vector),
}

impl PassEnd {
    /// One of both ends of a pass.
    fn of(pass: &Pass, end: usize) -> Self {
        let last = pass.positions.len() - 1;
        Self { place: pass.ends[end], position: pass.positions[end * last] }
    }

    /// Turn of the axis to that of another end, rad.
    fn turn_to(&self, other: &Self) -> f64 {
        self.position.1.angle(&other.position.1)
    }
}

/// How a pass is reached.
pub(super) struct PassEntry {
    /// The end of the pass: 0 or 1.
    pub(super) end: usize,
    /// The moves to it.
    pub(super) moves: EntryMoves,
}

/// The moves to a pass.
pub(super) enum EntryMoves {
    /// Over the layer, through these positions.
    Link(Vec<(Point, Vector)>),
    /// From a point above the blank, with its axis, down and then over the layer.
    Descent { above: (Point, Vector), steps: Vec<ApproachStep>, link: Vec<(Point, Vector)> },
}

impl PassEntry {
    /// The point above the blank that it comes down from.
    fn above(&self) -> Option<Point> {
        match &self.moves {
            EntryMoves::Link(_) => None,
            EntryMoves::Descent { above, .. } => Some(above.0),
        }
    }
}

/// A way from above the blank down to a position.
struct Descent {
    /// The point above the blank, with its axis.
    above: (Point, Vector),
    steps: Vec<ApproachStep>,
    /// Height of the stock above the position, mm.
    stands: f64,
    /// Time from the point above, min.
    minutes: f64,
}

/// The positions of a pass from one of its ends on.
pub(super) fn positions_from(pass: &Pass, end: usize) -> Vec<(Point, Vector)> {
    match end {
        0 => pass.positions.clone(),
        _ => pass.positions.iter().rev().copied().collect(),
    }
}

/// Finds the entries of passes, given those that are cut.
pub(super) struct EntryFinder<'a> {
    maker: &'a PathMaker<'a>,
    top: RetractSurface<'a>,
    /// What is cut so far.
    cut: CutSpace<'a>,
    /// The ends of the passes that are cut on the layer.
    ends: Vec<PassEnd>,
}

impl<'a> EntryFinder<'a> {
    /// Before the first pass.
    pub(super) fn new(maker: &'a PathMaker<'a>) -> Self {
        let top = RetractSurface::new(maker.blank, maker.safety_distance + maker.tool.corner_radius);
        Self { maker, top, cut: CutSpace::new(maker.tool, maker.blank), ends: Vec::new() }
    }

    /// Begins a layer.
    pub(super) fn begin_layer(&mut self) {
        self.ends.clear();
    }

    /// Adds a pass to those that are cut.
    pub(super) fn add_cut(&mut self, pass: &Pass) {
        self.cut.add(&pass.positions);
        let ends = [pass.positions.first(), pass.positions.last()].into_iter().flatten().zip(pass.ends);
        self.ends.extend(ends.map(|(&position, place)| PassEnd { place, position }));
    }

    /// The tip of a cutter after retracting along its axis until its bottom is clear of the blank.
    pub(super) fn above(&self, (tip, axis): (Point, Vector)) -> Point {
        let tool = self.maker.tool;
        let above = tip + axis * (self.top.height(&tip, &axis, tool.radius() - tool.corner_radius) + 1e-6);
        let (cutter, blank) = (tool.placed(above, axis), self.maker.blank);
        retract_clear(&cutter, bottom_clearance(&cutter, blank), blank, self.maker.safety_distance).0
    }

    /// The way to `pass` from `at`, the end of the last pass if that is on its layer: over the layer where
    /// that is free, turns the axis little and takes no longer than from above; otherwise from above.
    pub(super) fn entry(
        &self,
        layer: &LayerPasses,
        pass: &Pass,
        at: Option<PassEnd>,
        feed: f64,
    ) -> PassEntry {
        let from_above = OnceCell::new();
        let descent = || self.fastest_descent(layer, pass, feed);
        if let Some(from) = at.filter(|_| pass.linked) {
            let up = self.above(from.position);
            let retract = (up - from.position.0).norm() / RAPID_MM_PER_MIN;
            let is_slower = |minutes: f64| {
                minutes > retract && {
                    let (entry, down): &(PassEntry, f64) = from_above.get_or_init(descent);
                    let flown = (entry.above().unwrap_or(up) - up).norm() / RAPID_MM_PER_MIN;
                    minutes > retract + flown + down
                }
            };
            let mut links = [0, 1].map(|end| (layer.layer.segment_length(from.place, pass.ends[end]), end));
            links.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (long, end) in links {
                let target = PassEnd::of(pass, end);
                if from.turn_to(&target) > MAX_LINK_TURN || is_slower(long / feed) {
                    continue;
                }
                if let Some(positions) = self.link(layer, [&from, &target], long) {
                    return PassEntry { end, moves: EntryMoves::Link(positions) };
                }
            }
        }
        from_above.into_inner().unwrap_or_else(descent).0
    }

    /// The fastest way from above the blank to `pass`, and how long it takes from there, min: down to one of
    /// its ends, or, where that takes a ramp, down to an end of a pass that is cut, and over the layer to the
    /// nearer of both.
    fn fastest_descent(&self, layer: &LayerPasses, pass: &Pass, feed: f64) -> (PassEntry, f64) {
        let down = |end: usize| {
            let descent = self.descent(&positions_from(pass, end), pass.open[end], feed);
            let moves = EntryMoves::Descent { above: descent.above, steps: descent.steps, link: Vec::new() };
            (PassEntry { end, moves }, descent.minutes, needs_ramp(descent.stands))
        };
        let mut direct = down(usize::from(!pass.open[0] && pass.open[1]));
        if direct.2 {
            let other = down(1 - direct.0.end);
            if other.1 < direct.1 {
                direct = other;
            }
        }
        let (entry, minutes, ramps) = direct;
        if !ramps || !pass.linked || self.maker.ramp_height.is_some() {
            return (entry, minutes);
        }
        let link_feed = self.maker.link_feed(feed);
        let beside = |end: usize| {
            let target = PassEnd::of(pass, end);
            let reached = self.ends.iter().filter(|cut| cut.turn_to(&target) <= MAX_LINK_TURN);
            let nearest = reached.map(|cut| (layer.layer.segment_length(cut.place, target.place), cut));
            let (long, cut) = nearest.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if long / link_feed >= minutes {
                return None;
            }
            let descent = self.descent(&[cut.position], false, feed);
            let beside = descent.minutes + long / link_feed;
            if beside >= minutes || needs_ramp(descent.stands) {
                return None;
            }
            let link = self.link(layer, [cut, &target], long)?;
            let moves = EntryMoves::Descent { above: descent.above, steps: descent.steps, link };
            Some((PassEntry { end, moves }, beside))
        };
        let fastest = [0, 1].into_iter().filter_map(beside).min_by(|a, b| a.1.total_cmp(&b.1));
        fastest.unwrap_or((entry, minutes))
    }

    /// The way down to the first of `positions`, of a pass with the rate `feed`. `is_open`: that position is
    /// beyond the part.
    fn descent(&self, positions: &[(Point, Vector)], is_open: bool, feed: f64) -> Descent {
        let (tip, axis) = positions[0];
        let above = self.above((tip, axis));
        let top = (above - tip).norm();
        let (stands, distance) = match self.maker.ramp_height {
            None => (self.cut.standing_height((tip, axis), top), self.maker.safety_distance),
            Some(height) => (if is_open { 0.0 } else { height }, f64::INFINITY),
        };
        let steps = approach(positions, top, stands, distance);
        let (mut at, mut minutes) = (above, 0.0);
        for step in &steps {
            minutes += (step.position.0 - at).norm() / self.maker.approach_feed(step.feed, feed);
            at = step.position.0;
        }
        Descent { above: (above, axis), steps, stands, minutes }
    }

    /// Positions of a link of `long` mm over the layer from one end of a pass to another; `None` if it is not
    /// free.
    fn link(
        &self,
        layer: &LayerPasses,
        [from, to]: [&PassEnd; 2],
        long: f64,
    ) -> Option<Vec<(Point, Vector)>> {
        if is_same(from.position, to.position) {
            return Some(Vec::new());
        }
        let tool = self.maker.tool;
        let plain = |p: LayerPoint, axis: &Vector| {
            let (contact, normal) = layer.layer.point_and_normal(p);
            tool.tip_at_contact(&contact, &normal, axis)
        };
        let ((tip, axis), (to_tip, to_axis)) = (from.position, to.position);
        // Interpolate the offset of both ends from the layer.
        let offset = [tip - plain(from.place, &axis), to_tip - plain(to.place, &to_axis)];
        let count = (long / LINK_STEP).max(from.turn_to(to) / LINK_TURN).ceil().max(1.0) as usize;
        (1..=count)
            .map(|k| {
                let share = k as f64 / count as f64;
                let p = from.place.lerp(to.place, share);
                let axis = (axis + (to_axis - axis) * share).normalize();
                let tip = plain(p, &axis) + offset[0] * (1.0 - share) + offset[1] * share;
                (layer.fits)(p, tip, axis).then_some((tip, axis))
            })
            .collect()
    }
}
