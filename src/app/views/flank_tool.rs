//! The tool of the flank plan where the timeline stands.

use std::sync::Arc;

use crate::app::model::preview::ShownCutters;
use crate::app::model::state::AppState;
use crate::drawing::cutters::single_cutter;
use crate::gpu::cutters::CutterState;
use crate::job::flank::FlankOutcome;

/// The tool after a move, kept until plan or timeline change: the picture is drawn again for another one.
#[derive(Debug, Default)]
pub(in crate::app) struct FlankTool(Option<(Arc<FlankOutcome>, usize, ShownCutters)>);

impl FlankTool {
    /// The tool to show now; `None` at the end of the timeline, before its first move, or of other
    /// operations.
    pub(in crate::app) fn follow(&mut self, state: &AppState) -> Option<ShownCutters> {
        let made = state.look.flank.cut.and_then(|cut| cut.checked_sub(1));
        let shown = state.shown_flank().map(|(outcome, _)| outcome).zip(made);
        let Some((outcome, last)) = shown else {
            self.0 = None;
            return None;
        };
        let is_known =
            |(of, at, _): &&(Arc<FlankOutcome>, usize, ShownCutters)| *at == last && Arc::ptr_eq(of, outcome);
        if self.0.as_ref().filter(is_known).is_none() {
            let step = outcome.plan.moves.get(last)?;
            let cutter = single_cutter(&outcome.plan.tool, step.tip, step.axis, CutterState::Selected);
            let shown = ShownCutters { cutters: [cutter].into(), program: None };
            self.0 = Some((Arc::clone(outcome), last, shown));
        }
        self.0.as_ref().map(|(_, _, shown)| shown.clone())
    }
}
