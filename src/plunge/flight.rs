//! Flights above the blank: the tip runs straight from one place to another while the axis turns evenly.

use rayon::prelude::*;

use super::retract::{NearBottom, RetractSurface};
use crate::geometry::{Point, Vector, frame_about, search};
use crate::part::{Blank, Tool};

/// Places looked at along a flight, in cutter diameters, and the most of them.
const SAMPLE_DIAMETERS: f64 = 0.25;
/// See [`SAMPLE_DIAMETERS`].
const MAX_SAMPLES: usize = 400;

/// A flight of a cutter from one position to another, each a tip and the unit axis there.
#[derive(Clone, Copy, Debug)]
pub struct Flight<'a> {
    /// The cutter.
    pub tool: &'a Tool,
    /// What it flies over.
    pub blank: &'a Blank,
    /// Where it begins.
    pub from: (Point, Vector),
    /// Where it ends.
    pub to: (Point, Vector),
}

/// Greatest turn of the axis between two places looked at, rad.
const SAMPLE_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// An even turn of an axis (spherical linear interpolation).
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    from: Vector,
    /// Unit vector across `from`, towards the other end.
    across: Vector,
    angle: f64,
}

impl Turn {
    /// From one unit axis to another; between opposite axes it is one of many.
    pub fn new(from: Vector, to: &Vector) -> Self {
        let across = (to - from * from.dot(to)).try_normalize(1e-12);
        Self { from, across: across.unwrap_or_else(|| frame_about(&from).0), angle: from.angle(to) }
    }

    /// The axis at a share of the turn, and its derivative by the share.
    pub fn at(&self, share: f64) -> (Vector, Vector) {
        let (sin, cos) = (share * self.angle).sin_cos();
        (self.from * cos + self.across * sin, (self.across * cos - self.from * sin) * self.angle)
    }
}

impl Flight<'_> {
    /// Number of places to look at between both ends, `spacing` mm apart or nearer.
    fn samples(&self, turn: &Turn, spacing: f64) -> usize {
        let looks = ((self.to.0 - self.from.0).norm() / spacing).max(turn.angle / SAMPLE_TURN);
        (looks.ceil() as usize).clamp(1, MAX_SAMPLES)
    }

    /// Least distance of the cutter's bottom to the blank between both ends, mm; any of its distances below `enough` when
    /// there is one. `ends`: the bottom where the flight begins and ends.
    pub fn clearance(&self, ends: [&NearBottom; 2], enough: f64) -> f64 {
        let (from, to) = (self.from, self.to);
        let (motion, turn) = (to.0 - from.0, Turn::new(from.1, &to.1));
        let samples = self.samples(&turn, SAMPLE_DIAMETERS * self.tool.diameter);
        let spacing = 1.0 / (samples + 1) as f64;
        // Clearance at a share of the way, and its slope there.
        let look = |share: f64, known: Option<&NearBottom>| {
            let (axis, turning) = turn.at(share);
            let cutter = self.tool.placed(from.0 + motion * share, axis);
            let near = known.copied().unwrap_or_else(|| NearBottom::of(&cutter, self.blank));
            (near.clearance, near.growth(&cutter, &motion, &turning))
        };
        let at = |i: usize| match i {
            0 => look(0.0, Some(ends[0])),
            i if i == samples + 1 => look(1.0, Some(ends[1])),
            i => look(spacing * i as f64, None),
        };
        let looks: Vec<(f64, f64)> = (0..samples + 2).into_par_iter().with_min_len(16).map(at).collect();
        let mut least = looks[1..=samples].iter().map(|look| look.0).fold(f64::INFINITY, f64::min);
        // Where it falls at one and rises at the next it comes nearer still between them.
        for (i, pair) in looks.windows(2).enumerate() {
            let (from, to) = (pair[0], pair[1]);
            if least < enough || from.1 >= 0.0 || to.1 <= 0.0 {
                continue;
            }
            let start = spacing * i as f64;
            let ends = ((start, from.1), (start + spacing, to.1));
            least = least.min(search::least_in_dip(|x| look(x, None), ends.0, ends.1, 0.02 * spacing));
        }
        least
    }

    /// How far above its bottom the tool, as a cylinder without end, reaches into the blank somewhere on the way, mm; 0
    /// where it does not. `surface`: of the blank, at the distance of the cutter's corner radius.
    pub fn depth_of_tool(&self, surface: &RetractSurface) -> f64 {
        let (motion, turn) = (self.to.0 - self.from.0, Turn::new(self.from.1, &self.to.1));
        let samples = self.samples(&turn, self.tool.diameter);
        let flat = self.tool.radius() - self.tool.corner_radius;
        let height = |i: usize| {
            let share = i as f64 / samples as f64;
            surface.height(&(self.from.0 + motion * share), &turn.at(share).0, flat)
        };
        (1..=samples).map(height).fold(0.0, f64::max)
    }
}
