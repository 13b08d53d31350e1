//! The program that the timeline of the shown operation runs through.

use std::borrow::Cow;
use std::sync::Arc;

use super::checked::CheckedProgram;
use super::flank_run::FlankRun;
use super::planned::DisplayPlan;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Impeller;
use crate::setup::{AllowanceSetup, AxisPolicy};
use crate::toolpath::ClProgram;

/// What the timeline runs through.
#[derive(Clone, Debug)]
pub enum TimelineProgram {
    /// The plunge plan of a policy for that number of channels, plunge by plunge.
    Plunges(Arc<DisplayPlan>, AxisPolicy, usize),
    /// A flank plan in the shown channels, move by move.
    Flank(Arc<FlankRun>),
    /// A checked program, move by move.
    Checked(Arc<CheckedProgram>),
}

impl PartialEq for TimelineProgram {
    /// Plans and checked programs are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Plunges(a, policy, channels), Self::Plunges(b, wanted, count)) => {
                (policy, channels) == (wanted, count) && Arc::ptr_eq(a, b)
            }
            (Self::Flank(a), Self::Flank(b)) => Arc::ptr_eq(a, b),
            (Self::Checked(a), Self::Checked(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl TimelineProgram {
    /// The whole program, and for each step of the timeline the index of the move that ends it; `None` of a
    /// step without a move.
    pub fn moves(&self) -> (Cow<'_, ClProgram>, Vec<Option<usize>>) {
        match self {
            Self::Plunges(planned, policy, channels) => {
                let (outcome, result) = (&planned.outcome, planned.result(*policy));
                // Nothing cancels a program that is listed or shown on its machine.
                let plan = outcome.plan_of_channels(result, *channels, &Monitor::default());
                let plan = plan.unwrap_or_else(|Cancelled| result.plan.clone());
                let program = ClProgram::of_plan(&outcome.workpiece.part.name, &plan);
                let bottoms = program.bottoms_of(&plan);
                (Cow::Owned(program), bottoms)
            }
            Self::Flank(run) => {
                // The timeline does not include the plunges that open the stock before the passes.
                let (program, passes) = run.program();
                (program, passes.into_iter().map(Some).collect())
            }
            Self::Checked(checked) => {
                (Cow::Borrowed(&checked.program), (0..checked.program.moves.len()).map(Some).collect())
            }
        }
    }

    /// Time from the start of the program to the end of each of its `steps`, s, by that of each of its
    /// `moves`; see [`Self::moves`]. A step without a move takes no time.
    pub fn clock(&self, program: &ClProgram, steps: &[Option<usize>], moves: &[f64]) -> Vec<f64> {
        // The rapid out of the stock belongs to its plunge.
        if let Self::Plunges(..) = self {
            return program.at_plunge_ends(moves);
        }
        let mut now = 0.0;
        let ends = steps.iter().map(|end| {
            now = end.and_then(|end| moves.get(end).copied()).unwrap_or(now);
            now
        });
        ends.collect()
    }

    /// The part, and the allowances that say what its blank is.
    pub fn part(&self) -> (&Impeller, &AllowanceSetup) {
        match self {
            Self::Plunges(planned, ..) => {
                (&planned.outcome.workpiece.part, &planned.outcome.setup.allowances)
            }
            Self::Flank(run) => (&run.outcome.workpiece.part, &run.outcome.setup.allowances),
            Self::Checked(checked) => (&checked.request.part, &checked.request.setup.allowances),
        }
    }
}
