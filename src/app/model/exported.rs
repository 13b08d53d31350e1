//! The program files that were written of a plan, for its setup sheet.

use std::sync::{Arc, Weak};

use crate::app::model::planned::DisplayPlan;
use crate::job::flank::FlankOutcome;
use crate::report::sheet::ProgramFile;
use crate::setup::AxisPolicy;

/// The plan of a program.
#[derive(Clone, Debug)]
pub enum ProgramPlan {
    /// That of plunges by a policy, for that number of channels.
    Plunges(Weak<DisplayPlan>, AxisPolicy, usize),
    /// A flank plan, for that number of channels.
    Flank(Weak<FlankOutcome>, usize),
}

/// Maximum number of files that are remembered; the oldest are forgotten first.
const MAX_FILES: usize = 50;

/// The program files that were written of plans since the part was opened.
#[derive(Clone, Debug, Default)]
pub struct ExportedPrograms(Vec<(ProgramPlan, ProgramFile)>);

impl ExportedPrograms {
    /// Remembers a file of a plan; one of the same name is replaced by it.
    pub fn note(&mut self, plan: ProgramPlan, file: ProgramFile) {
        self.0.retain(|(_, known)| known.name != file.name);
        if self.0.len() >= MAX_FILES {
            self.0.remove(0);
        }
        self.0.push((plan, file));
    }

    /// The number of channels of the program that was written last of `planned` by `policy`, and its files of
    /// that number.
    pub fn of_plunges(&self, planned: &Arc<DisplayPlan>, policy: AxisPolicy) -> (usize, Vec<ProgramFile>) {
        self.last(|plan| match plan {
            ProgramPlan::Plunges(of, by, channels)
                if *by == policy && of.as_ptr() == Arc::as_ptr(planned) =>
            {
                Some(*channels)
            }
            _ => None,
        })
    }

    /// The same of a flank plan.
    pub fn of_flank(&self, outcome: &Arc<FlankOutcome>) -> (usize, Vec<ProgramFile>) {
        self.last(|plan| match plan {
            ProgramPlan::Flank(of, channels) if of.as_ptr() == Arc::as_ptr(outcome) => Some(*channels),
            _ => None,
        })
    }

    /// The number of channels of the last program of a plan, by `channels_of`, and the files of that number.
    fn last(&self, channels_of: impl Fn(&ProgramPlan) -> Option<usize>) -> (usize, Vec<ProgramFile>) {
        let Some(channels) = self.0.iter().rev().find_map(|(plan, _)| channels_of(plan)) else {
            return (1, Vec::new());
        };
        let of = self.0.iter().filter(|(plan, _)| channels_of(plan) == Some(channels));
        (channels, of.map(|(_, file)| file.clone()).collect())
    }
}
