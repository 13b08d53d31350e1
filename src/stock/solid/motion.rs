//! Moves of a tool as pieces that each travel on a straight line without turning.

use super::assembly::{OVERLAP, SolidTool};
use super::near::NearStock;
use super::outline::Outline;
use super::part::{Action, ToolPart};
use super::piece::Piece;
use crate::cutting::link::AxisTurn;
use crate::geometry::{Point, Vector};
use crate::toolpath::is_axial;

/// Turn of the axis below which a move counts as straight, rad.
const STRAIGHT_RAD: f64 = 1e-7;
/// Distance across its axis up to which a move counts as one along it, as a share of its travel, and mm.
const AXIAL: (f64, f64) = (1e-4, 1e-4);
/// Largest number of steps into which one move is divided.
const MAX_STEPS: f64 = 20_000.0;
/// A cut ends a plunge, and is not a pass, if more than this share of its length is up along the axis.
const LEAVING_SHARE: f64 = 0.5;

/// Tip and unit axis of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    /// Centre of the bottom, mm.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
}

/// One move of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidMove {
    /// Number of the move in its program, from 0.
    pub number: u32,
    /// Index of the tool.
    pub tool: usize,
    /// Whether it is a rapid, which removes nothing.
    pub rapid: bool,
    /// Whether its core must not meet stock where it goes down along its axis: not in an approach to a pass.
    pub checks_core: bool,
    /// Where it starts; where that is unknown, its end.
    pub from: ToolPose,
    /// Where it ends.
    pub to: ToolPose,
}

impl SolidMove {
    /// The pose at a share 0…1 of the move. Under feed the axis is interpolated linearly and normalised, as
    /// by a control; in rapid it turns at a constant rate, as links are planned.
    pub fn pose(&self, share: f64) -> ToolPose {
        let (from, to) = (self.from, self.to);
        let axis = if self.rapid {
            AxisTurn::new(from.axis, &to.axis).at(share).0
        } else {
            (from.axis + (to.axis - from.axis) * share).try_normalize(1e-9).unwrap_or(to.axis)
        };
        ToolPose { tip: from.tip + (to.tip - from.tip) * share, axis }
    }

    fn turn(&self) -> f64 {
        self.from.axis.angle(&self.to.axis)
    }

    /// How far up it goes, mm; `None` where it does not go along its axis.
    fn height_along_axis(&self) -> Option<f64> {
        let travel = self.to.tip - self.from.tip;
        is_axial(&travel, &self.from.axis, &self.to.axis).then(|| travel.dot(&self.to.axis))
    }

    /// Whether it goes down along its axis under feed.
    fn goes_in(&self) -> bool {
        !self.rapid && self.height_along_axis().is_some_and(|height| height < 0.0)
    }

    /// Whether it goes up along its axis in rapid.
    pub fn is_retract(&self) -> bool {
        self.rapid && self.height_along_axis().is_some_and(|height| height > 0.0)
    }

    /// Whether it ends a plunge before it: a rapid, or a cut that mainly goes up along the axis.
    fn leaves(&self) -> bool {
        let travel = self.to.tip - self.from.tip;
        let up = travel.dot(&self.to.axis);
        self.rapid || (self.turn() < STRAIGHT_RAD && up > LEAVING_SHARE * travel.norm())
    }

    /// Whether the move is never part of a run: a rapid, or a cut along its own axis.
    pub(super) fn is_whole(&self) -> bool {
        self.rapid || self.axial().is_some()
    }

    /// Travel along the axis if the tool moves along it and does not turn, mm; negative downwards.
    fn axial(&self) -> Option<f64> {
        let travel = self.to.tip - self.from.tip;
        let along = travel.dot(&self.to.axis);
        let across = (travel - self.to.axis * along).norm();
        (across < AXIAL.1.min(AXIAL.0 * (1.0 + travel.norm())) && self.turn() < 1e-5).then_some(along)
    }
}

/// Sets [`SolidMove::checks_core`] in programs that mill along curves: what goes down along its axis is a
/// plunge where a retract follows, maybe after further pecks, and the approach to a pass where a pass
/// follows.
pub fn tell_plunges_from_approaches(moves: &mut [SolidMove]) {
    let mut leaves_next = true;
    let mut next_tool = None;
    for step in moves.iter_mut().rev() {
        leaves_next |= next_tool != Some(step.tool);
        next_tool = Some(step.tool);
        step.checks_core = step.goes_in() && leaves_next;
        let stays = !step.rapid && step.from == step.to;
        if !(step.goes_in() || stays) {
            leaves_next = step.leaves();
        }
    }
}

/// Divides moves into pieces whose distance from the true sweep stays below a tolerance.
pub struct PieceMaker<'a> {
    /// The tools.
    pub tools: &'a [SolidTool],
    /// Largest distance of the swept pieces from the true sweep, mm.
    pub tolerance: f64,
    /// Lower and upper corner of the box that holds the stock, mm.
    pub bounds: (Point, Point),
    /// Where stock is.
    pub near: &'a NearStock,
}

/// A slice of a tool in one move.
struct Slice {
    outline: Outline,
    /// Height of its lower end above the tip, mm.
    from: f64,
    /// The same above the lower end of its part.
    above: f64,
    action: Action,
}

impl PieceMaker<'_> {
    /// Appends the pieces of a move, in the order in which they act.
    ///
    /// Shank and holder follow the cutter where it advances along its axis, and meet what it leaves; where it
    /// draws back they go ahead of it.
    pub fn add(&self, step: &SolidMove, into: &mut Vec<Piece>) {
        let advances = (step.to.tip - step.from.tip).dot(&step.to.axis) <= 1e-9;
        if advances && !step.rapid {
            self.add_core(step, into);
            self.add_cutter(step, into);
            self.add_bodies(step, into);
        } else {
            self.add_bodies(step, into);
            self.add_core(step, into);
            self.add_cutter(step, into);
        }
    }

    /// Appends the pieces of shank and holder.
    pub fn add_bodies(&self, step: &SolidMove, into: &mut Vec<Piece>) {
        let Some(tool) = self.tools.get(step.tool) else { return };
        for segment in &tool.segments {
            let first = tool.segments.iter().find(|s| s.part == segment.part).map_or(0.0, |s| s.from);
            let slice = Slice {
                outline: Outline::cone(segment.lower, segment.upper, segment.length),
                from: segment.from,
                above: segment.from - first,
                action: Action::Check(segment.part),
            };
            self.add_slice(step, tool, &slice, into);
        }
    }

    /// Appends the piece of the core in a plunge.
    fn add_core(&self, step: &SolidMove, into: &mut Vec<Piece>) {
        let Some(tool) = self.tools.get(step.tool).filter(|tool| tool.core_radius > 0.0) else { return };
        if step.checks_core && step.axial().is_some_and(|travel| !step.rapid && travel < 0.0) {
            // Pieces of a plunge are prolonged upwards by its travel; this one only checks.
            let outline = Outline::cone(tool.core_radius, tool.core_radius, 1e-9);
            let action = Action::Check(ToolPart::Core);
            self.add_slice(step, tool, &Slice { outline, from: 0.0, above: 0.0, action }, into);
        }
    }

    /// Appends the pieces of the cutter, which cuts, or in rapid must not meet stock.
    pub fn add_cutter(&self, step: &SolidMove, into: &mut Vec<Piece>) {
        let Some(tool) = self.tools.get(step.tool) else { return };
        let action = if step.rapid { Action::Check(ToolPart::Cutter) } else { Action::Cut };
        for (from, outline) in tool.cutter(step.axial().is_some(), 0.5 * self.tolerance) {
            self.add_slice(step, tool, &Slice { outline, from, above: from, action }, into);
        }
    }

    fn add_slice(&self, step: &SolidMove, tool: &SolidTool, slice: &Slice, into: &mut Vec<Piece>) {
        match step.axial() {
            Some(travel) => self.along_axis(step, slice, travel, into),
            None => self.across(step, tool, slice, into),
        }
    }

    /// A slice that moves along its axis sweeps itself in the lower position, prolonged upwards: exact.
    fn along_axis(&self, step: &SolidMove, slice: &Slice, travel: f64, into: &mut Vec<Piece>) {
        let low = if travel < 0.0 { step.to } else { step.from };
        let (outline, travel) = (slice.outline, travel.abs());
        let upper = outline.radius_at(outline.length);
        let lower = outline.radius_at(0.0);
        let mut put = |outline: Outline, up: f64| {
            into.extend(self.placed(outline, low.tip, low.axis, Vector::zeros(), slice, up, step.number));
        };
        if (upper - lower).abs() < 1e-12 {
            put(Outline::cone(upper, upper, outline.length + travel), 0.0);
        } else if upper >= lower {
            put(outline, 0.0);
            if travel > 0.0 {
                put(Outline::cone(upper, upper, travel + OVERLAP), outline.length - OVERLAP);
            }
        } else {
            if travel > 0.0 {
                put(Outline::cone(lower, lower, travel + OVERLAP), 0.0);
            }
            put(outline, travel);
        }
    }

    /// A slice that moves across its axis or turns: steps in which every point of the slice is within the
    /// tolerance of one that does not turn.
    fn across(&self, step: &SolidMove, tool: &SolidTool, slice: &Slice, into: &mut Vec<Piece>) {
        let turn = step.turn();
        let outline = slice.outline;
        if turn < STRAIGHT_RAD {
            let travel = step.to.tip - step.from.tip;
            into.extend(self.placed(outline, step.from.tip, step.from.axis, travel, slice, 0.0, step.number));
            return;
        }
        // Beyond the stock nothing needs to be exact: a slice ends where it certainly leaves the box.
        let reach = (self.bounds.1 - self.bounds.0).norm()
            + [step.from.tip, step.to.tip]
                .map(|tip| (tip - self.bounds.0).norm())
                .into_iter()
                .fold(0.0, f64::max);
        let length = outline.length.min((reach - slice.from).max(0.0));
        if length <= 0.0 {
            return;
        }
        // A point at distance q from the middle of a slice moves by q · dθ / 2 when the slice takes the
        // middle axis of a step; the middle itself leaves its chord by z · dθ² / 8. Short slices need few
        // steps, so their number hardly matters: as many as leave one step, but none much shorter than wide.
        let tolerance = if step.rapid { 2.5 * self.tolerance } else { self.tolerance };
        let (lateral, bow) = (0.8 * tolerance, 0.2 * tolerance);
        // A ball is one slice: its centre does not feel the turn, and its parts are no cones.
        let count = match outline.ball_radius() {
            Some(_) => 1.0,
            None => (length / (4.0 * lateral / turn).max(outline.radius)).ceil().clamp(1.0, 1000.0),
        };
        let high = length / count;
        for i in 0..count as usize {
            let up = i as f64 * high;
            // Neighbouring slices overlap, so that nothing stays between them.
            let top = if i + 1 < count as usize { high + 0.5 * tolerance } else { high };
            let part = cut_out(&outline, up, top.min(outline.length - up));
            // The centre of a ball does not feel a turn. Of a bottom or a corner the whole radius counts, of
            // a cylinder only its height, as its ends are inside its neighbours.
            let (centre, off) = match outline.ball_radius() {
                Some(radius) => (slice.from + radius, 0.0),
                None => {
                    let is_end = (i == 0 && slice.above < 1e-9)
                        || slice.from + up < tool.corner_radius - 1e-9
                        || part.radius_at(0.0) != part.radius_at(part.length);
                    let wide = if is_end { outline.radius } else { 0.0 };
                    (slice.from + up + 0.5 * high, wide.hypot(0.5 * high))
                }
            };
            let steps = (turn * off / (2.0 * lateral))
                .max(turn * (centre / (8.0 * bow)).sqrt())
                .ceil()
                .clamp(1.0, MAX_STEPS);
            for k in 0..steps as usize {
                let pose = |share: f64| step.pose((k as f64 + share) / steps);
                let (start, middle, end) = (pose(0.0), pose(0.5), pose(1.0));
                let from = start.tip + start.axis * centre - middle.axis * centre;
                let travel = end.tip + end.axis * centre - (start.tip + start.axis * centre);
                into.extend(self.placed(part, from, middle.axis, travel, slice, up, step.number));
            }
        }
    }

    /// The piece of a slice with the tip of its tool at `tip`, `up` mm above the slice's lower end; `None`
    /// where it does not reach stock.
    #[expect(clippy::too_many_arguments, reason = "a piece has that many independent properties")]
    fn placed(
        &self,
        outline: Outline,
        tip: Point,
        axis: Vector,
        travel: Vector,
        slice: &Slice,
        up: f64,
        number: u32,
    ) -> Option<Piece> {
        let base = tip + axis * (slice.from + up);
        let piece =
            Piece { outline, base, axis, travel, action: slice.action, number, above: slice.above + up };
        let (low, high) = piece.bounds();
        let apart = (0..3).any(|k| high[k] < self.bounds.0[k] || low[k] > self.bounds.1[k]);
        (!apart && self.near.may_meet(&piece)).then_some(piece)
    }
}

/// The part of an outline from `from` over `length`, mm.
fn cut_out(outline: &Outline, from: f64, length: f64) -> Outline {
    if from == 0.0 && length >= outline.length {
        return *outline;
    }
    Outline::cone(outline.radius_at(from), outline.radius_at(from + length), length)
}

impl Piece {
    /// Lower and upper corner of the box around what it sweeps, mm.
    pub fn bounds(&self) -> (Point, Point) {
        let (mut low, mut high) = (self.base, self.base);
        for k in 0..3 {
            let side = self.outline.radius * (1.0 - self.axis[k] * self.axis[k]).max(0.0).sqrt();
            let along = self.axis[k] * self.outline.length;
            low[k] += along.min(0.0) + self.travel[k].min(0.0) - side;
            high[k] += along.max(0.0) + self.travel[k].max(0.0) + side;
        }
        (low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moves of one tool with a vertical axis through points, with whether each is a rapid.
    fn moves(points: &[([f64; 3], bool)]) -> Vec<SolidMove> {
        let pose = |p: [f64; 3]| ToolPose { tip: Point::from(p), axis: Vector::z() };
        let ends = points.windows(2).enumerate();
        ends.map(|(k, pair)| SolidMove {
            number: k as u32,
            tool: 0,
            rapid: pair[1].1,
            checks_core: true,
            from: pose(pair[0].0),
            to: pose(pair[1].0),
        })
        .collect()
    }

    #[test]
    fn what_a_pass_follows_is_an_approach_and_what_a_retract_follows_a_plunge() {
        let (start, top, bottom) = ([0.0, 0.0, 20.0], [0.0, 0.0, 5.0], [0.0, 0.0, 0.0]);
        let (beside, off) = ([9.0, 0.0, 0.0], [1.0, 0.0, 2.0]);
        for (what, points, expected) in [
            ("retract", vec![(start, true), (bottom, false), (start, true)], vec![0]),
            ("retract under feed", vec![(start, true), (bottom, false), (start, false)], vec![0]),
            (
                "lead-out off the stock",
                vec![(start, true), (bottom, false), (off, false), (start, true)],
                vec![0],
            ),
            ("pass", vec![(start, true), (bottom, false), (beside, false), (start, true)], vec![]),
            ("pecks", vec![(start, true), (top, false), (bottom, false), (start, true)], vec![0, 1]),
            ("pecks and a pass", vec![(start, true), (top, false), (bottom, false), (beside, false)], vec![]),
            (
                "no move between",
                vec![(start, true), (bottom, false), (bottom, false), (beside, false)],
                vec![],
            ),
            ("nothing", vec![(start, true), (bottom, false)], vec![0]),
        ] {
            let mut moves = moves(&points);
            tell_plunges_from_approaches(&mut moves);
            let found: Vec<usize> = (0..moves.len()).filter(|&k| moves[k].checks_core).collect();
            assert_eq!(found, expected, "{what}");
            // Another tool goes on.
            if let Some(last) = moves.last_mut().filter(|_| what == "pass") {
                last.tool = 1;
                let cut = SolidMove { tool: 1, ..moves[1] };
                moves[1] = cut;
                tell_plunges_from_approaches(&mut moves);
                assert!(moves[0].checks_core, "{what} of another tool");
            }
        }
    }
}
