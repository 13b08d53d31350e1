//! Shank and holder while planning: a position is kept only where both are clear of the finished part and of
//! the whole blank, or, where the blank stands above the shroud, of what earlier plunges left of it. Tools
//! without a given shank or holder are not held to this.

use super::reasons::{Breach, DropReason};
use crate::cutting::assembly::{ASSEMBLY_TOLERANCE, AssemblySurroundings, part_in_stock};
use crate::cutting::contact::Earlier;
use crate::geometry::{Point, Vector};
use crate::part::{Blank, FinishedPart};
use crate::setup::{AssemblyPart, AssemblySegment, Setup, Tool};

/// Clearance missing by rounding that a planned position may have, mm: below what `verify` tolerates.
const PLANNED_TOLERANCE: f64 = 5e-4;

/// Why a position is left out, and the overhang with which it could be cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DropCause {
    /// The reason.
    pub why: DropReason,
    /// Smallest overhang with which the holder would be clear, mm; `None` where more than the holder is in
    /// the way.
    pub stick_out: Option<f64>,
}

impl From<DropReason> for DropCause {
    fn from(why: DropReason) -> Self {
        Self { why, stick_out: None }
    }
}

/// Judges poses of one tool.
#[derive(Clone, Debug)]
pub struct AssemblyRule<'a> {
    around: AssemblySurroundings<'a>,
    tool: &'a Tool,
    /// Shank and holder, with what they pass on the way out.
    segments: Vec<AssemblySegment>,
}

/// `segments` and, above those that are wider than one further up, what they pass on the way out: a plunge
/// leaves along its axis until the tip is out of the blank. Shanks come first.
fn with_passages(segments: &[AssemblySegment]) -> Vec<AssemblySegment> {
    let top = segments.last().map_or(0.0, |last| last.from + last.length);
    let passage = |(index, segment): (usize, &AssemblySegment)| {
        let [lower, upper] = segment.radii;
        let widest = lower.max(upper);
        let from = if lower > upper { segment.from } else { segment.from + segment.length };
        let is_narrower = |above: &AssemblySegment| above.radii[0].min(above.radii[1]) < widest;
        let narrows = lower > upper || segments[index + 1..].iter().any(is_narrower);
        narrows.then_some(AssemblySegment { from, length: top - from, radii: [widest; 2], ..*segment })
    };
    let passages = segments.iter().enumerate().filter_map(passage);
    let mut all: Vec<AssemblySegment> = segments.iter().copied().chain(passages).collect();
    all.sort_by_key(|segment| segment.part == AssemblyPart::Holder);
    all
}

impl<'a> AssemblyRule<'a> {
    /// The rule for `tool`; `None` where neither shank nor holder is given.
    pub fn new(tool: &'a Tool, finished: &'a FinishedPart, blank: &'a Blank, setup: &Setup) -> Option<Self> {
        let around = AssemblySurroundings::new(finished, setup).with_blank(blank);
        let segments = with_passages(&tool.assembly.segments(tool.overhang));
        (!segments.is_empty()).then_some(Self { around, tool, segments })
    }

    /// The rule after `earlier` plunges, where the blank stands above the shroud.
    pub fn after<'e>(&self, earlier: Earlier<'e>) -> AssemblyRule<'e>
    where
        'a: 'e,
    {
        let around = match self.around.blank.is_some_and(|blank| blank.outline().is_some()) {
            true => self.around.after(earlier),
            false => self.around,
        };
        AssemblyRule { around, tool: self.tool, segments: self.segments.clone() }
    }

    /// What is in the way with the tip and axis at `pose`, the shank first.
    pub fn obstacle(&self, pose: (Point, Vector)) -> Option<DropReason> {
        let part = self.around.first_obstacle(self.tool, &self.segments, pose, PLANNED_TOLERANCE)?;
        Some(match part {
            AssemblyPart::Shank => DropReason::Shank,
            AssemblyPart::Holder => DropReason::Holder,
        })
    }

    /// What is too near to the finished part with the tip and axis at `pose`, or in what the plunges `until`
    /// then left of the `blank`, by more than `verify` tolerates.
    pub fn breach(&self, pose: (Point, Vector), until: Earlier, blank: &Blank) -> Option<Breach> {
        let part = AssemblySurroundings { blank: None, earlier: None, ..self.around };
        let near = || part.first_obstacle(self.tool, &self.segments, pose, ASSEMBLY_TOLERANCE);
        let cutter = self.tool.placed(pose.0, pose.1);
        let in_stock = || part_in_stock(self.tool, &cutter, until, blank);
        let part = near().or_else(|| in_stock().map(|(part, _)| part))?;
        Some(match part {
            AssemblyPart::Shank => Breach::Shank,
            AssemblyPart::Holder => Breach::Holder,
        })
    }

    /// `why`, with the smallest overhang that makes the holder clear at `pose`, if that is at most `limit`
    /// mm.
    pub fn cause(&self, why: DropReason, pose: (Point, Vector), limit: f64) -> DropCause {
        let by_length = matches!(why, DropReason::Holder | DropReason::Overhang);
        DropCause {
            why,
            stick_out: by_length.then(|| self.around.stick_out(self.tool, pose, limit)).flatten(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_passes_a_height_on_the_way_out_is_the_widest_below_it() {
        let shank = |from, length, radii| AssemblySegment { part: AssemblyPart::Shank, from, length, radii };
        let holder = |from, length, radii| AssemblySegment {
            part: AssemblyPart::Holder,
            ..shank(from, length, radii)
        };
        let stepped = [
            shank(20.0, 5.0, [6.0; 2]),
            shank(25.0, 45.0, [5.5; 2]),
            holder(70.0, 30.0, [14.0, 20.0]),
            holder(100.0, 50.0, [25.0, 18.0]),
            holder(150.0, 10.0, [22.0; 2]),
        ];
        let widest_at = |of: &[AssemblySegment], height: f64| {
            let at = |segment: &AssemblySegment| {
                let share = (height - segment.from) / segment.length;
                let [lower, upper] = segment.radii;
                (0.0..=1.0).contains(&share).then_some(lower + (upper - lower) * share)
            };
            of.iter().filter_map(at).fold(0.0, f64::max)
        };
        let passing = with_passages(&stepped);
        let mut passed: f64 = 0.0;
        for tenths in 200..1600 {
            let height = f64::from(tenths) / 10.0;
            passed = passed.max(widest_at(&stepped, height));
            assert!((widest_at(&passing, height) - passed).abs() < 1e-9, "{passed} at {height}");
        }
        let widening = [shank(20.0, 5.0, [4.0; 2]), holder(25.0, 30.0, [10.0, 20.0])];
        assert_eq!(with_passages(&widening), widening, "nothing is passed that is not there");
        assert!(passing.is_sorted_by_key(|segment| segment.part), "the shank first");
    }
}
