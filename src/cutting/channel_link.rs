//! Rapids from channel to channel: the tool leaves the part along its axis and goes round the axis of
//! rotation, outside the blank, to above the place where it enters the next channel.

use super::link::{AxisTurn, LinkMove};
use super::retract::{NearBottom, RetractSurface, max_retract};
use crate::geometry::{Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::setup::Tool;

/// Turn about the axis of rotation of one move, rad: a straight move over 30° comes nearer to that axis by
/// 3 % of its distance.
const MAX_STEP_RAD: f64 = std::f64::consts::PI / 6.0;
/// Maximum number of times that the ends are raised until the link is clear.
const MAX_RAISES: usize = 30;

/// Lift of the ends of a link that is worth moves of its own, mm.
pub const MIN_LIFT: f64 = 1e-6;

/// A rapid of a tool from a position in one channel to a position in another, each a tip (mm) and a unit
/// axis.
#[derive(Clone, Copy, Debug)]
pub struct ChannelLink<'a> {
    /// The tool.
    pub tool: &'a Tool,
    /// The blank to stay clear of.
    pub blank: &'a Blank,
    /// Distance to keep from it, mm.
    pub safety: f64,
    /// Where the tool has left the part.
    pub from: (Point, Vector),
    /// Where it begins to approach it.
    pub to: (Point, Vector),
    /// Signed turn about the axis of rotation from the one channel to the other, rad.
    pub turn_rad: f64,
}

impl ChannelLink<'_> {
    /// The positions of the link: first `from` and last `to`, both raised along their axes until the tool is
    /// clear of the blank on all moves between them. In a frame that turns at a constant rate the tip moves
    /// straight, and so does each link within a channel.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn positions(&self, monitor: &Monitor) -> Result<Vec<(Point, Vector)>, Cancelled> {
        let surface = RetractSurface::new(self.blank, self.tool.corner_radius);
        let limit = max_retract(self.blank);
        let mut raised = 0.0;
        let mut positions = self.raised_by(raised);
        for round in 0..MAX_RAISES {
            monitor.check()?;
            let needed = self.needed_lift(&positions, &surface);
            if needed <= 0.0 || raised >= limit {
                break;
            }
            // Lifts grow: where the axes lean towards the part, a lift gains less than its length.
            raised = (raised + (1.0 + 0.3 * round as f64) * needed + 0.25 * self.safety + 1e-3).min(limit);
            positions = self.raised_by(raised);
        }
        Ok(positions)
    }

    /// The positions with both ends raised by `raised` mm.
    fn raised_by(&self, raised: f64) -> Vec<(Point, Vector)> {
        let count = (self.turn_rad.abs() / MAX_STEP_RAD).ceil().max(1.0);
        let (from, to) = (self.from.0 + self.from.1 * raised, self.to.0 + self.to.1 * raised);
        let back = rotate_z(&to, -self.turn_rad) - from;
        let axes = AxisTurn::new(self.from.1, &rotate_vector_z(&self.to.1, -self.turn_rad));
        let between = (1..count as usize).map(|k| {
            let share = k as f64 / count;
            let turn = share * self.turn_rad;
            (rotate_z(&(from + back * share), turn), rotate_vector_z(&axes.at(share).0, turn))
        });
        // The ends are not turned to and fro: they stay what the plan says, bit by bit.
        [(from, self.from.1)].into_iter().chain(between).chain([(to, self.to.1)]).collect()
    }

    /// What the moves between `positions` lack of being clear, mm; not positive where they are clear.
    fn needed_lift(&self, positions: &[(Point, Vector)], surface: &RetractSurface) -> f64 {
        let Self { tool, blank, safety, .. } = *self;
        let bottom = |&(tip, axis): &(Point, Vector)| NearBottom::from_cutter(&tool.placed(tip, axis), blank);
        let bottoms: Vec<NearBottom> = positions.iter().map(bottom).collect();
        let lift = |k: usize| {
            let link = LinkMove { tool, blank, from: positions[k], to: positions[k + 1] };
            let between = link.needed_lift([&bottoms[k], &bottoms[k + 1]], surface, safety).1;
            between.max(safety - bottoms[k].clearance).max(safety - bottoms[k + 1].clearance)
        };
        (0..positions.len() - 1).map(lift).fold(0.0, f64::max)
    }
}
