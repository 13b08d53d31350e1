//! Rapid links above the blank: the tip moves straight from one position to another while the axis turns at a
//! constant rate.

use rayon::prelude::*;

use super::retract::{NearBottom, RetractSurface};
use crate::geometry::{Point, Vector, frame_about, search};
use crate::part::Blank;
use crate::setup::Tool;

/// Spacing of the samples along a link, in cutter diameters.
const SAMPLE_DIAMETERS: f64 = 0.25;
/// Maximum number of samples along a link.
const MAX_SAMPLES: usize = 400;

/// A rapid link of a tool between two positions, each a tip (mm) and a unit axis.
#[derive(Clone, Copy, Debug)]
pub struct LinkMove<'a> {
    /// The tool.
    pub tool: &'a Tool,
    /// The blank to stay clear of.
    pub blank: &'a Blank,
    /// Start of the link.
    pub from: (Point, Vector),
    /// End of the link.
    pub to: (Point, Vector),
}

/// Depth of the tool in the blank above which a link is raised, mm.
const MAX_TOOL_DEPTH: f64 = 1e-3;
/// Cosine of the turn up to which the axis certainly turns the shorter way round.
const MIN_TURN_COS: f64 = -0.99;
/// Maximum turn of the axis between two samples, rad.
const SAMPLE_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Turn of an axis at a constant rate (spherical linear interpolation).
#[derive(Clone, Copy, Debug)]
pub struct AxisTurn {
    from: Vector,
    /// Unit vector across `from`, towards the other end.
    across: Vector,
    angle: f64,
}

impl AxisTurn {
    /// Turn from one unit axis to another; between opposite axes an arbitrary one of the possible turns.
    pub fn new(from: Vector, to: &Vector) -> Self {
        let across = (to - from * from.dot(to)).try_normalize(1e-12);
        Self { from, across: across.unwrap_or_else(|| frame_about(&from).0), angle: from.angle(to) }
    }

    /// The axis at `share` (0…1) of the turn, and its derivative by the share.
    pub fn at(&self, share: f64) -> (Vector, Vector) {
        let (sin, cos) = (share * self.angle).sin_cos();
        (self.from * cos + self.across * sin, (self.across * cos - self.from * sin) * self.angle)
    }
}

impl LinkMove<'_> {
    /// Whether the tool, taken as an endless cylinder, is more than `distance` mm away from a ball about the
    /// blank all the way. Where that takes a search, false.
    pub fn is_far(&self, distance: f64) -> bool {
        let (centre, radius) = self.blank.ball();
        let tips = [self.from.0 - centre, self.to.0 - centre];
        let axes = [self.from.1, self.to.1];
        // Where no way from the centre to the tip points against the axis, no place of the tool's axis is
        // nearer than the tip. An axis between both is a sum of them with positive shares.
        let is_outward = tips.iter().all(|tip| axes.iter().all(|axis| tip.dot(axis) >= 0.0));
        if !is_outward || axes[0].dot(&axes[1]) < MIN_TURN_COS {
            return false;
        }
        let way = tips[1] - tips[0];
        let share = (-tips[0].dot(&way) / way.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        (tips[0] + way * share).norm() > radius + self.tool.radius() + distance
    }

    /// Number of samples between both ends for at most `spacing` mm between them.
    fn samples(&self, turn: &AxisTurn, spacing: f64) -> usize {
        let looks = ((self.to.0 - self.from.0).norm() / spacing).max(turn.angle / SAMPLE_TURN);
        (looks.ceil() as usize).clamp(1, MAX_SAMPLES)
    }

    /// Minimum distance of the cutter's bottom to the blank between both ends, mm; if a sample is below
    /// `enough`, that minimum is not refined further. `ends` are the bottoms at start and end.
    pub fn clearance(&self, ends: [&NearBottom; 2], enough: f64) -> f64 {
        let (from, to) = (self.from, self.to);
        let (motion, turn) = (to.0 - from.0, AxisTurn::new(from.1, &to.1));
        let samples = self.samples(&turn, SAMPLE_DIAMETERS * self.tool.diameter);
        let spacing = 1.0 / (samples + 1) as f64;
        // Clearance at a share of the link, and its derivative by the share.
        let look = |share: f64, known: Option<&NearBottom>| {
            let (axis, turning) = turn.at(share);
            let cutter = self.tool.placed(from.0 + motion * share, axis);
            let near = known.copied().unwrap_or_else(|| NearBottom::from_cutter(&cutter, self.blank));
            (near.clearance, near.clearance_rate(&cutter, &motion, &turning))
        };
        let at = |i: usize| match i {
            0 => look(0.0, Some(ends[0])),
            i if i == samples + 1 => look(1.0, Some(ends[1])),
            i => look(spacing * i as f64, None),
        };
        let looks: Vec<(f64, f64)> = (0..samples + 2).into_par_iter().with_min_len(16).map(at).collect();
        let mut least = looks[1..=samples].iter().map(|look| look.0).fold(f64::INFINITY, f64::min);
        // Where the clearance falls at one sample and rises at the next, it has a minimum in between.
        for (i, pair) in looks.windows(2).enumerate() {
            let (from, to) = (pair[0], pair[1]);
            if least < enough || from.1 >= 0.0 || to.1 <= 0.0 {
                continue;
            }
            let start = spacing * i as f64;
            let ends = ((start, from.1), (start + spacing, to.1));
            least = least.min(search::min_between_slopes(|x| look(x, None), ends.0, ends.1, 0.02 * spacing));
        }
        least
    }

    /// Minimum distance of the bottom to the blank between both ends, mm, not refined further below `safety`;
    /// and what the link lacks of being clear: of the safety distance, or by the depth of the tool in the
    /// blank, mm, 0 where it is clear. `ends` and `surface` as in [`Self::clearance`] and
    /// [`Self::max_tool_depth`].
    pub fn needed_lift(&self, ends: [&NearBottom; 2], surface: &RetractSurface, safety: f64) -> (f64, f64) {
        let clearance = self.clearance(ends, safety);
        if clearance < safety {
            return (clearance, safety - clearance);
        }
        let depth = self.max_tool_depth(surface);
        (clearance, if depth > MAX_TOOL_DEPTH { depth } else { 0.0 })
    }

    /// Maximum depth over the link to which the tool, taken as an endless cylinder, is in the blank, measured
    /// from its bottom, mm; 0 where it is clear. `surface` is that of the blank at the distance of the corner
    /// radius.
    pub fn max_tool_depth(&self, surface: &RetractSurface) -> f64 {
        let (motion, turn) = (self.to.0 - self.from.0, AxisTurn::new(self.from.1, &self.to.1));
        let samples = self.samples(&turn, self.tool.diameter);
        let flat = self.tool.radius() - self.tool.corner_radius;
        let height = |i: usize| {
            let share = i as f64 / samples as f64;
            surface.height(&(self.from.0 + motion * share), &turn.at(share).0, flat)
        };
        (1..=samples).map(height).fold(0.0, f64::max)
    }
}
