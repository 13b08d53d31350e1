//! Programs of several channels of a flank plan, judged as they are written.

use super::JobError;
use super::flank::{FlankJob, FlankOutcome, FlankRequest};
use super::flank_check::{NAME, WheelPlanner};
use crate::flank::FlankPlan;
use crate::flank::channels::FlankChannels;
use crate::flank::path::Times;
use crate::io::apt::as_written;
use crate::machine::MachineTime;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::toolpath::{ClProgram, Motion, Travel};
use crate::verify::{Fault, FaultKind, FlankVerdict, FlankVerifier, VerifyError};

/// How often a program is written anew with other retracts under feed.
const MAX_ROUNDS: usize = 4;

/// A program of a flank plan, with what `verify` says of it as it is written.
#[derive(Clone, Debug)]
pub struct FlankProgram {
    /// Number of channels.
    pub channels: usize,
    /// The plan of one of them: that of the outcome, but for retracts that only a program of several channels
    /// needs to make under feed.
    pub plan: FlankPlan,
    /// The program.
    pub program: ClProgram,
    /// Its faults.
    pub faults: Vec<Fault>,
    /// The other findings; `None` if it cannot be verified.
    pub verdict: Option<FlankVerdict>,
    /// Lengths and times by kind of move. Of several channels plunges above the shroud count in the rapids.
    pub times: Times,
    /// Its time on the machine of the setup; `None` without one, and where it cannot run the program.
    pub machine_time: Option<MachineTime>,
    /// Its estimated time, s: feed rates and rapids, without tool changes and accelerations.
    pub time_estimate: f64,
}

/// The fault of a program that is too long to be read back.
fn unreadable() -> Fault {
    Fault {
        line: 0,
        kind: FaultKind::NotJudged,
        value: None,
        message: "the program is too long to be read back".to_owned(),
        help: "write fewer channels".to_owned(),
        overhang: None,
    }
}

impl FlankProgram {
    /// Number of its moves under feed.
    pub fn positions(&self) -> usize {
        self.program.moves.iter().filter(|step| matches!(step.motion, Motion::Feed(_))).count()
    }

    /// The best known time of the program, s: on the machine of the setup, or else the estimate.
    pub fn time_s(&self) -> f64 {
        self.machine_time.map_or(self.time_estimate, |time| time.total_s)
    }
}

impl FlankJob {
    /// Plans as [`Self::run_for_channels`], with the program of these channels as
    /// [`FlankOutcome::program_for_channels`] makes it, in less time: of several channels the planner has
    /// judged most of it.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn run_to_program(
        &self,
        request: &FlankRequest,
        channels: usize,
        monitor: &Monitor,
    ) -> Result<(FlankOutcome, FlankProgram), JobError> {
        let cancelled = |_: Cancelled| JobError::Cancelled;
        let (outcome, program) = self.run_then(request, channels, monitor, |outcome, planner| {
            let WheelPlanner { verifier, retracts_in_stock } = planner;
            let verifier = FlankVerifier::new(&outcome.workpiece, &outcome.setup).taking_over(verifier);
            let plan = outcome.plan.with_retracts_under_feed(&retracts_in_stock);
            let plan = plan.unwrap_or_else(|| outcome.plan.clone());
            outcome.judged_for_channels((plan, channels), verifier, &monitor.silent()).map_err(cancelled)
        })?;
        let program = match program {
            Some(program) => program,
            None => outcome.program_for_channels(channels, &monitor.silent()).map_err(cancelled)?,
        };
        Ok((outcome, program))
    }
}

impl FlankOutcome {
    /// The moves of the first `channels` channels in the order of the setup.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn in_channels(&self, channels: usize, monitor: &Monitor) -> Result<FlankChannels, Cancelled> {
        let Workpiece { part, blank, .. } = &*self.workpiece;
        self.plan.in_one_channel(&part.name).in_channels(part, blank, &self.setup, channels, monitor)
    }

    /// The program of the first `channels` channels in the order of the setup, judged as a whole. The stock
    /// that `verify` looks at has a grid, on which channels differ: thin stock may count in one of them, and
    /// a retract past it in rapid is a fault there. Such a retract is made under feed, in all channels.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn program_for_channels(
        &self,
        channels: usize,
        monitor: &Monitor,
    ) -> Result<FlankProgram, Cancelled> {
        if channels <= 1 {
            return Ok(FlankProgram {
                channels,
                plan: self.plan.clone(),
                program: self.program(),
                faults: self.faults.clone(),
                verdict: self.verdict.clone(),
                times: self.plan.times,
                machine_time: self.machine_time,
                time_estimate: self.time_estimate,
            });
        }
        let verifier = FlankVerifier::new(&self.workpiece, &self.setup);
        self.judged_for_channels((self.plan.clone(), channels), verifier, monitor)
    }

    /// The program of `plan` for the first `channels` channels, more than one, judged by `verifier`; see
    /// [`Self::program_for_channels`].
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    fn judged_for_channels(
        &self,
        (mut plan, channels): (FlankPlan, usize),
        mut verifier: FlankVerifier,
        monitor: &Monitor,
    ) -> Result<FlankProgram, Cancelled> {
        let Workpiece { part, blank, .. } = &*self.workpiece;
        let mut round = 0;
        let (program, faults, verdict) = loop {
            let one = plan.in_one_channel(&part.name);
            let FlankChannels { program, origins } =
                one.in_channels(part, blank, &self.setup, channels, monitor)?;
            let Ok(written) = as_written(NAME, &program) else { break (program, vec![unreadable()], None) };
            let verdict = match verifier.verdict(&written, monitor) {
                Err(VerifyError::Cancelled(cancelled)) => return Err(cancelled),
                Err(VerifyError::Program(fault)) => break (program, vec![fault], None),
                Ok(verdict) => verdict,
            };
            round += 1;
            let origin = |line: usize| {
                let index = written.moves.partition_point(|step| step.line < line);
                one.index_of_pass(origins.get(index).copied().flatten()?.index)
            };
            let in_stock = verdict.faults.iter().filter(|fault| fault.kind == FaultKind::RapidInStock);
            let lines = in_stock.map(|fault| fault.line).chain(verifier.grazing_rapids().iter().copied());
            let rapids: Vec<usize> = lines.filter_map(origin).collect();
            match plan.with_retracts_under_feed(&rapids).filter(|_| round <= MAX_ROUNDS) {
                Some(slower) => plan = slower,
                None => break (program, verdict.faults.clone(), Some(verdict)),
            }
        };
        let machine_time = self.clock.as_ref().and_then(|clock| clock.time(&program));
        let travel = Travel::from_program(&program);
        let one = Times::from_moves(&plan.moves);
        let times = Times {
            cut_length: one.cut_length * channels as f64,
            link_length: one.link_length * channels as f64,
            rapid_length: travel.rapid,
            cut_time: one.cut_time * channels as f64,
            link_time: one.link_time * channels as f64,
            rapid_time: travel.time - travel.feed_time,
        };
        let time_estimate = travel.time;
        Ok(FlankProgram { channels, plan, program, faults, verdict, times, machine_time, time_estimate })
    }
}
