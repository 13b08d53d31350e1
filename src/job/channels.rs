//! Plans, programs and times of several channels.

use super::outcome::{PlanOutcome, PolicyResult};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Workpiece;
use crate::plunge::PlungePlan;
use crate::plunge::channels::{count_tool_loads, link_channels, plan_channels};
use crate::toolpath::ClProgram;

impl PlanOutcome {
    /// The plan of the first `channels` channels of `result`, one of the results of this outcome, in the
    /// order of the setup.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn plan_of_channels(
        &self,
        result: &PolicyResult,
        channels: usize,
        monitor: &Monitor,
    ) -> Result<PlungePlan, Cancelled> {
        let Workpiece { part, blank, .. } = &*self.workpiece;
        plan_channels(&result.plan, part, blank, &self.setup, channels, monitor)
    }

    /// The program of [`Self::plan_of_channels`].
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn program_for_channels(
        &self,
        result: &PolicyResult,
        channels: usize,
        monitor: &Monitor,
    ) -> Result<ClProgram, Cancelled> {
        let plan = self.plan_of_channels(result, channels, monitor)?;
        Ok(ClProgram::of_plan(&self.workpiece.part.name, &plan))
    }

    /// Tells the times of several channels in the order of the setup. That of all channels is the time of
    /// their program, but for plunges that are lifted in it.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub(super) fn time_wheel(&mut self, monitor: &Monitor) -> Result<(), Cancelled> {
        let order = self.setup.channels;
        let Self { before, after, others, .. } = self;
        for result in [before, after].into_iter().chain(others) {
            let loads = |channels| count_tool_loads(&result.plan, order.order, channels) as f64;
            let further = (loads(2) - loads(1)) / loads(1).max(1.0);
            let summary = &mut result.summary;
            summary.further_tool_changes_s =
                summary.machine_time.map_or(0.0, |time| further * time.tool_changes_s);
        }
        let Workpiece { part, blank, .. } = &*self.workpiece;
        let plan = &self.after.plan;
        let wheel = link_channels(plan, part, blank, &self.setup, part.blade_count, monitor)?;
        self.after.summary.wheel_time_s = self.clock.program_time_s(&ClProgram::of_plan("", &wheel));
        Ok(())
    }
}
