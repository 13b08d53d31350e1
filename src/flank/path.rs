//! From passes to a program: the order of the passes and the moves between them.
//!
//! Layers are cut from the top down, a layer region by region: first the inner passes of each fixed axis,
//! zigzag from side to side, then the passes along the walls. A pass begins at an end beyond the part if it
//! has one; otherwise the tool ramps down along it. Between passes the tool links over the layer at feed rate
//! where that is short and free of collision. Otherwise it retracts along its axis, moves in rapid above the
//! blank, and comes down again. Each pass has one feed rate, by its engagement: full stock on both sides,
//! beside a cut pass, or along a wall.

mod approach;

use super::engagement::CutPasses;
use super::layer::{LayerPoint, LayerSurface};
use super::region::Region;
use super::strategies::PassRole;
use crate::cutting::link::LinkMove;
use crate::cutting::retract::{NearBottom, RetractSurface, bottom_clearance, retract_clear};
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::{FlankFeedRates, Tool};
use crate::toolpath::RAPID_MM_PER_MIN;
use approach::{ApproachStep, approach, ramp_length_on};

/// Kind of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MoveKind {
    /// Rapid: above the blank, or retracting along the tool axis.
    Rapid,
    /// At feed rate down to the start of a pass, or along it while still descending.
    Approach,
    /// Along a pass.
    Cut,
    /// At feed rate over the layer from one pass to the next.
    Link,
}

/// A straight move to a position, in the frame of the part.
#[derive(Clone, Copy, Debug)]
pub struct FlankMove {
    /// Kind of the move.
    pub kind: MoveKind,
    /// Tip of the tool at its end.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Feed rate, mm/min; for a rapid the speed that the time estimate assumes.
    pub feed_mm_per_min: f64,
    /// Its layer, 0 at the hub.
    pub layer: usize,
    /// Its region.
    pub region: Region,
    /// Whether it belongs to a pass along a wall.
    pub along_wall: bool,
}

/// One continuous cut: a whole pass curve, or a piece of it with one fixed axis.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Purpose of the pass.
    pub role: PassRole,
    /// Its region.
    pub region: Region,
    /// Index of the fixed axis within the region; passes along walls come last.
    pub group: usize,
    /// Tip and unit axis (tip → holder) along it, in the frame of the part.
    pub positions: Vec<(Point, Vector)>,
    /// Layer points of both ends.
    pub ends: [LayerPoint; 2],
    /// Whether the ends are beyond the part.
    pub open: [bool; 2],
    /// Whether a link over the layer may lead to it; otherwise the tool approaches from above.
    pub linked: bool,
}

/// The pass that a move of a program belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MoveOrigin {
    /// Index of the layer in cutting order.
    pub layer: usize,
    /// Index of the pass on that layer: the one that the move follows or leads to, or that a retract leaves.
    pub pass: usize,
    /// Index of the position of the pass at the end of the move.
    pub to: usize,
    /// Index of the position at its start, for a move along the pass.
    pub from: Option<usize>,
}

/// Moves with their origins.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The moves.
    pub moves: Vec<FlankMove>,
    /// One origin per move.
    pub origins: Vec<MoveOrigin>,
}

/// Maximum turn of the axis on a link, rad.
const MAX_LINK_TURN: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Spacing of positions along a link, mm.
const LINK_STEP: f64 = 0.5;
/// Maximum turn of the axis between them, rad: the far end of a long tool then swings by half a millimetre.
const LINK_TURN: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Distance (mm) and turn (rad) below which two positions are the same in a program: it has six decimals.
const SAME_POSITION: f64 = 5e-6;
const SAME_AXIS: f64 = 1e-6;
/// Maximum number of iterations that raise the ends of a rapid until it is clear.
const MAX_RAISE_ITERATIONS: usize = 30;

/// Added to the safety distance of rapids, mm: where the tool bottom is near the blank at two points, the
/// nearer one may swap between two samples.
pub(super) const RAPID_MARGIN: f64 = 0.05;

/// Inputs of the program.
pub struct PathMaker<'a> {
    /// The tool.
    pub tool: &'a Tool,
    /// Feed rates by engagement.
    pub feeds: FlankFeedRates,
    /// The blank, which rapids clear.
    pub blank: &'a Blank,
    /// Clearance of the tool above the blank before a rapid, mm.
    pub safety_distance: f64,
    /// Depth of a layer, mm: the height of a ramp.
    pub layer_depth: f64,
}

/// Whether cutter and holder are free of collision, for a layer point and the tip and axis of a tool there.
pub type CollisionCheck<'a> = dyn Fn(LayerPoint, Point, Vector) -> bool + Sync + 'a;

/// The passes of a layer, and the layer.
pub struct LayerPasses<'a> {
    /// Number of the layer, 0 at the hub.
    pub number: usize,
    /// The surface.
    pub layer: &'a LayerSurface,
    /// Stepover, mm.
    pub stepover: f64,
    /// Corner radius of the tool, mm.
    pub corner_radius: f64,
    /// The passes, in any order.
    pub passes: Vec<Pass>,
    /// Collision check for links.
    pub fits: Box<CollisionCheck<'a>>,
}

impl PathMaker<'_> {
    /// The program of all `layers`, given in cutting order.
    ///
    /// # Errors
    /// When the monitor is cancelled.
    pub fn program(&self, layers: &[LayerPasses], monitor: &Monitor) -> Result<Program, Cancelled> {
        let top = RetractSurface::new(self.blank, self.safety_distance + self.tool.corner_radius);
        let mut writer = ProgramWriter {
            maker: self,
            top,
            moves: Vec::new(),
            origins: Vec::new(),
            at: None,
            rapids: Vec::new(),
        };
        for (index, layer) in layers.iter().enumerate() {
            let mut rest: Vec<(usize, &Pass)> = layer.passes.iter().enumerate().collect();
            // Regions from the inlet on; in each the inner passes by axis, then the walls, side by side.
            rest.sort_by(|(_, a), (_, b)| {
                let key = |p: &Pass| (p.region, matches!(p.role, PassRole::Wall(_)), p.group);
                let side = |p: &Pass| p.ends[0].y + p.ends[1].y;
                key(a).cmp(&key(b)).then(side(a).total_cmp(&side(b)))
            });
            let mut cut = CutPasses::new(self.tool, layer.stepover);
            for (number, pass) in rest {
                monitor.check()?;
                writer.write_pass(layer, pass, (index, number), self.feed_of(pass, &cut));
                cut.add(&pass.positions);
            }
        }
        writer.retract();
        writer.raise_rapids(monitor)?;
        Ok(Program { moves: writer.moves, origins: writer.origins })
    }

    /// Feed rate along a pass, mm/min, after those of `cut` on its layer.
    fn feed_of(&self, pass: &Pass, cut: &CutPasses) -> f64 {
        let feeds = &self.feeds;
        let slots = cut.are_far_from(&pass.positions);
        match pass.role {
            PassRole::Wall(_) if slots => feeds.wall_mm_per_min.min(feeds.slot_mm_per_min),
            PassRole::Wall(_) => feeds.wall_mm_per_min,
            PassRole::Inner if slots => feeds.slot_mm_per_min,
            PassRole::Inner => feeds.step_mm_per_min,
        }
    }
}

struct ProgramWriter<'a> {
    maker: &'a PathMaker<'a>,
    top: RetractSurface<'a>,
    moves: Vec<FlankMove>,
    /// One per move.
    origins: Vec<MoveOrigin>,
    /// Layer number and layer point of the tool after a pass.
    at: Option<(usize, LayerPoint)>,
    /// Indices of the rapids from above the end of a pass to above the start of the next.
    rapids: Vec<usize>,
}

impl ProgramWriter<'_> {
    fn push(&mut self, step: FlankMove, origin: MoveOrigin) {
        self.moves.push(step);
        self.origins.push(origin);
    }

    /// Writes `pass`, given the indices of its layer and of itself.
    fn write_pass(&mut self, layer: &LayerPasses, pass: &Pass, (index, number): (usize, usize), feed: f64) {
        // Start where the tool is, otherwise at an end beyond the part.
        let open_end = usize::from(!pass.open[0] && pass.open[1]);
        let link = if pass.linked { self.link(layer, pass, open_end, feed) } else { None };
        let reversed = link.as_ref().map_or(open_end, |(_, end)| *end) == 1;
        let count = pass.positions.len();
        let positions: Vec<(Point, Vector)> =
            if reversed { pass.positions.iter().rev().copied().collect() } else { pass.positions.clone() };
        let (first, last) = if reversed { (1, 0) } else { (0, 1) };
        let about = |kind: MoveKind, (tip, axis): (Point, Vector)| FlankMove {
            kind,
            tip,
            axis,
            feed_mm_per_min: if kind == MoveKind::Rapid { RAPID_MM_PER_MIN } else { feed },
            layer: layer.number,
            region: pass.region,
            along_wall: matches!(pass.role, PassRole::Wall(_)),
        };
        let in_pass = |k: usize| if reversed { count - 1 - k } else { k };
        let origin = |k: usize| MoveOrigin { layer: index, pass: number, to: in_pass(k), from: None };
        match link {
            Some((poses, _)) => {
                poses.into_iter().for_each(|p| self.push(about(MoveKind::Link, p), origin(0)));
            }
            None => {
                self.retract();
                let approach = approach(&positions, pass.open[first], self.maker.layer_depth);
                let highest = approach.first().map_or(positions[0], |step| step.position);
                let above = about(MoveKind::Rapid, (self.above(highest), positions[0].1));
                if !self.moves.is_empty() {
                    self.rapids.push(self.moves.len());
                    self.push(above, origin(0));
                }
                self.push(above, origin(0));
                for ApproachStep { position, over, on_ramp } in approach {
                    let mut step = about(MoveKind::Approach, position);
                    if on_ramp {
                        step.feed_mm_per_min = self.maker.feeds.ramp_mm_per_min;
                    }
                    self.push(step, origin(over));
                }
            }
        }
        for (k, &p) in positions.iter().enumerate().skip(1) {
            self.push(about(MoveKind::Cut, p), MoveOrigin { from: Some(in_pass(k - 1)), ..origin(k) });
        }
        self.at = Some((layer.number, pass.ends[last]));
    }

    /// The link over the layer from the current position to an end of `pass`, and which end. `None` when it
    /// is not free, turns the axis too far, or takes longer than the rapid to the end `flown_to`.
    fn link(
        &self,
        layer: &LayerPasses,
        pass: &Pass,
        flown_to: usize,
        feed: f64,
    ) -> Option<(Vec<(Point, Vector)>, usize)> {
        let (number, at) = self.at?;
        let from = self.moves.last()?;
        if number != layer.number {
            return None;
        }
        let position = |end: usize| match end {
            0 => pass.positions[0],
            _ => pass.positions[pass.positions.len() - 1],
        };
        let ramp = if pass.open[flown_to] {
            0.0
        } else {
            ramp_length_on(path_length(&pass.positions), self.maker.layer_depth)
                / self.maker.feeds.ramp_mm_per_min
        };
        let rapid_time = self.estimate_rapid_time((from.tip, from.axis), position(flown_to), feed) + ramp;
        let mut ends = [0, 1].map(|end| (layer.layer.segment_length(at, pass.ends[end]), end));
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.into_iter().find_map(|(long, end)| {
            let target = position(end);
            if long / feed > rapid_time || from.axis.angle(&target.1) > MAX_LINK_TURN {
                return None;
            }
            Some((self.link_positions(layer, (at, from), (pass.ends[end], target), long)?, end))
        })
    }

    /// Positions of a link from one layer point to another; `None` if it is not free.
    fn link_positions(
        &self,
        layer: &LayerPasses,
        (at, from): (LayerPoint, &FlankMove),
        (to, target): (LayerPoint, (Point, Vector)),
        long: f64,
    ) -> Option<Vec<(Point, Vector)>> {
        if is_same((from.tip, from.axis), target) {
            return Some(Vec::new());
        }
        let tool = self.maker.tool;
        let plain = |p: LayerPoint, axis: &Vector| {
            let (contact, normal) = layer.layer.point_and_normal(p);
            tool.tip_at_contact(&contact, &normal, axis)
        };
        // Interpolate the offset of both ends from the layer.
        let offset = [from.tip - plain(at, &from.axis), target.0 - plain(to, &target.1)];
        let turn = from.axis.angle(&target.1);
        let count = (long / LINK_STEP).max(turn / LINK_TURN).ceil().max(1.0) as usize;
        (1..=count)
            .map(|k| {
                let share = k as f64 / count as f64;
                let p = at.lerp(to, share);
                let axis = (from.axis + (target.1 - from.axis) * share).normalize();
                let tip = plain(p, &axis) + offset[0] * (1.0 - share) + offset[1] * share;
                (layer.fits)(p, tip, axis).then_some((tip, axis))
            })
            .collect()
    }

    /// Estimated time to retract, move in rapid and approach a position, without ramp, min.
    fn estimate_rapid_time(&self, from: (Point, Vector), to: (Point, Vector), feed: f64) -> f64 {
        let (up, down) = (self.above(from), self.above(to));
        let flown = (up - from.0).norm() + (down - up).norm();
        flown / RAPID_MM_PER_MIN + (down - to.0).norm() / feed
    }

    /// Retracts along the axis until the bottom of the tool is clear of the blank.
    fn retract(&mut self) {
        let Some(&last) = self.moves.last() else { return };
        if last.kind != MoveKind::Rapid {
            let tip = self.above((last.tip, last.axis));
            if let Some(&origin) = self.origins.last() {
                self.push(
                    FlankMove { kind: MoveKind::Rapid, tip, feed_mm_per_min: RAPID_MM_PER_MIN, ..last },
                    origin,
                );
            }
        }
        self.at = None;
    }

    fn above(&self, (tip, axis): (Point, Vector)) -> Point {
        let tool = self.maker.tool;
        let above = tip + axis * (self.top.height(&tip, &axis, tool.radius() - tool.corner_radius) + 1e-6);
        let (cutter, blank) = (tool.placed(above, axis), self.maker.blank);
        retract_clear(&cutter, bottom_clearance(&cutter, blank), blank, self.maker.safety_distance).0
    }

    /// Raises both ends of every rapid until the bottom of the tool stays clear of the blank all along.
    ///
    /// # Errors
    /// When the monitor is cancelled.
    fn raise_rapids(&mut self, monitor: &Monitor) -> Result<(), Cancelled> {
        let rapids = std::mem::take(&mut self.rapids);
        for round in 0..MAX_RAISE_ITERATIONS {
            let mut clear = true;
            for &k in &rapids {
                monitor.check()?;
                let short = self.missing_clearance(k);
                if short > 0.0 {
                    clear = false;
                    let lift = (1.0 + 0.3 * round as f64) * short + 0.25 * self.maker.safety_distance + 1e-3;
                    for end in [k - 1, k] {
                        let axis = self.moves[end].axis;
                        self.moves[end].tip += axis * lift;
                    }
                }
            }
            if clear {
                break;
            }
        }
        self.drop_repeated_positions();
        Ok(())
    }

    /// Removes the moves of no length: a rapid that was not raised ends where the approach begins, and a
    /// curve may be split at one of its points.
    fn drop_repeated_positions(&mut self) {
        let mut last: Option<FlankMove> = None;
        let is_kept = |step: &FlankMove| {
            let moves = last.is_none_or(|last| !is_same((last.tip, last.axis), (step.tip, step.axis)));
            if moves {
                last = Some(*step);
            }
            moves
        };
        let kept: Vec<bool> = self.moves.iter().map(is_kept).collect();
        let (mut of_moves, mut of_origins) = (kept.iter().copied(), kept.iter().copied());
        self.moves.retain(|_| of_moves.next().unwrap_or(true));
        self.origins.retain(|_| of_origins.next().unwrap_or(true));
    }

    /// Missing clearance of the tool bottom above the blank on the rapid to move `k`, mm; not positive where
    /// it is clear.
    fn missing_clearance(&self, k: usize) -> f64 {
        let PathMaker { tool, blank, .. } = *self.maker;
        let [from, to] = [k - 1, k].map(|k| (self.moves[k].tip, self.moves[k].axis));
        let [start, end] =
            [from, to].map(|(tip, axis)| NearBottom::from_cutter(&tool.placed(tip, axis), blank));
        let wanted = self.maker.safety_distance + RAPID_MARGIN;
        let between = LinkMove { tool, blank, from, to }.clearance([&start, &end], wanted);
        wanted - between.min(start.clearance).min(end.clearance)
    }
}

/// Whether two positions of tip and axis are the same in a program.
fn is_same((tip, axis): (Point, Vector), (other_tip, other_axis): (Point, Vector)) -> bool {
    (other_tip - tip).norm() < SAME_POSITION && other_axis.angle(&axis) < SAME_AXIS
}

/// Path length of the tip, mm.
pub(super) fn path_length(positions: &[(Point, Vector)]) -> f64 {
    positions.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).sum()
}

/// Lengths and times of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Times {
    /// Length along passes, mm.
    pub cut_length: f64,
    /// Length of links and approaches, mm.
    pub link_length: f64,
    /// Length of rapids, mm.
    pub rapid_length: f64,
    /// Time along passes, s.
    pub cut_time: f64,
    /// Time of links and approaches, s.
    pub link_time: f64,
    /// Time of rapids at 10 m/min, s.
    pub rapid_time: f64,
}

impl Times {
    /// Lengths and times of `moves` at their feed rates, without accelerations.
    pub fn from_moves(moves: &[FlankMove]) -> Self {
        let mut times = Self::default();
        for pair in moves.windows(2) {
            let length = (pair[1].tip - pair[0].tip).norm();
            let (lengths, time) = match pair[1].kind {
                MoveKind::Cut => (&mut times.cut_length, &mut times.cut_time),
                MoveKind::Approach | MoveKind::Link => (&mut times.link_length, &mut times.link_time),
                MoveKind::Rapid => (&mut times.rapid_length, &mut times.rapid_time),
            };
            *lengths += length;
            *time += 60.0 * length / pair[1].feed_mm_per_min;
        }
        times
    }

    /// Total time of the program, s.
    pub fn total(&self) -> f64 {
        self.cut_time + self.link_time + self.rapid_time
    }
}
