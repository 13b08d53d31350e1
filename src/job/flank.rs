//! The flank planning job that window and command line share.

use std::sync::{Arc, Mutex, PoisonError};

use super::JobError;
use crate::flank::choice::choose_tool;
use crate::flank::{FlankError, FlankPlan, FlankStages, plan};
use crate::formats::tool_library::flank_cutters;
use crate::monitor::Monitor;
use crate::part::{Channel, Impeller, Setup};
use crate::plunge::sections::check_part;

/// What to plan.
#[derive(Clone, Debug)]
pub struct FlankRequest {
    /// The part.
    pub part: Arc<Impeller>,
    /// The setup as the programmer gave it.
    pub setup: Setup,
}

/// Result of a [`FlankRequest`].
#[derive(Clone, Debug)]
pub struct FlankOutcome {
    /// The part that was planned.
    pub part: Arc<Impeller>,
    /// The setup with the cutter filled in.
    pub setup: Setup,
    /// The plan.
    pub plan: FlankPlan,
    /// Wall time of the work, s.
    pub elapsed: f64,
}

impl From<FlankError> for JobError {
    fn from(error: FlankError) -> Self {
        match error {
            FlankError::Cancelled(_) => Self::Cancelled,
            FlankError::Setup(fault) => fault.into(),
        }
    }
}

/// Plans flank curves and remembers the stages of the last plan, so that only stale ones are made again.
#[derive(Debug, Default)]
pub struct FlankJob {
    last: Mutex<Option<(Arc<Impeller>, FlankStages)>>,
}

impl FlankJob {
    /// Plans one channel.
    ///
    /// # Errors
    /// [`JobError::Cancelled`] soon after `monitor` is told so; [`JobError::Setup`] when part and setup do not go
    /// together.
    pub fn run(&self, request: &FlankRequest, monitor: &Monitor) -> Result<FlankOutcome, JobError> {
        let started = std::time::Instant::now();
        let part = &request.part;
        check_part(&request.setup, part)?;
        let channel = Channel::of(part);
        let chosen = choose_tool(part, &channel, &request.setup, flank_cutters())?;
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let known = last.take().filter(|(known, _)| Arc::ptr_eq(known, part)).map(|(_, stages)| stages);
        let mut stages = known.unwrap_or_default();
        let planned = plan(part, &channel, &request.setup, &chosen, &mut stages, monitor);
        *last = Some((part.clone(), stages));
        let plan = planned?;
        let mut setup = request.setup.clone();
        if !setup.tools.contains(&chosen.tool) {
            setup.tools.push(chosen.tool.clone());
        }
        setup.flank.tool = Some(chosen.tool.number);
        Ok(FlankOutcome { part: part.clone(), setup, plan, elapsed: started.elapsed().as_secs_f64() })
    }
}
