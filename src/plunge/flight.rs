//! Flights above the blank: the tip runs straight from one place to another while the axis turns evenly.

use rayon::prelude::*;

use super::retract::NearBottom;
use crate::geometry::{Point, Vector, search};
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

impl Flight<'_> {
    /// Least distance of the cutter's bottom to the blank between both ends, mm; any of its distances below `enough` when
    /// there is one. `ends`: the bottom where the flight begins and ends.
    pub fn clearance(&self, ends: [&NearBottom; 2], enough: f64) -> f64 {
        let (from, to) = (self.from, self.to);
        let (motion, tilt) = (to.0 - from.0, to.1 - from.1);
        let looks = motion.norm() / (SAMPLE_DIAMETERS * self.tool.diameter);
        let samples = (looks.ceil() as usize).clamp(1, MAX_SAMPLES);
        let spacing = 1.0 / (samples + 1) as f64;
        // Clearance at a share of the way, and its slope there.
        let look = |share: f64, known: Option<&NearBottom>| {
            let between = from.1 + tilt * share;
            let axis = between.normalize();
            let cutter = self.tool.placed(from.0 + motion * share, axis);
            let near = known.copied().unwrap_or_else(|| NearBottom::of(&cutter, self.blank));
            let turning = (tilt - axis * axis.dot(&tilt)) / between.norm();
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
}
