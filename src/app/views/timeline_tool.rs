//! The tool of a flank plan or checked program where the timeline stands.

use crate::app::model::preview::ShownCutters;
use crate::app::model::state::AppState;
use crate::app::model::timeline_program::TimelineProgram;
use crate::drawing::cutters::single_cutter;
use crate::geometry::{Point, Vector};
use crate::gpu::cutters::CutterState;
use crate::setup::Tool;

/// The tool after a move, kept until program or timeline change: the picture is drawn again for another one.
#[derive(Debug, Default)]
pub(in crate::app) struct TimelineTool(Option<(TimelineProgram, usize, ShownCutters)>);

impl TimelineTool {
    /// The tool to show now; `None` at the end of the timeline, before its first move, or of plunge plans,
    /// whose cutters are shown all.
    pub(in crate::app) fn follow(&mut self, state: &AppState) -> Option<ShownCutters> {
        let made = state.timeline_cut().filter(|_| state.shows_timeline_tool());
        let last = made.and_then(|cut| cut.checked_sub(1));
        let Some((program, last)) = state.timeline_program().zip(last) else {
            self.0 = None;
            return None;
        };
        let is_known = |(of, at, _): &&(TimelineProgram, usize, ShownCutters)| *at == last && *of == program;
        if self.0.as_ref().filter(is_known).is_none() {
            let (tool, tip, axis) = tool_after(&program, last)?;
            let cutter = single_cutter(&tool, tip, axis, CutterState::Selected);
            let shown = ShownCutters { cutters: [cutter].into(), program: None };
            self.0 = Some((program, last, shown));
        }
        self.0.as_ref().map(|(_, _, shown)| shown.clone())
    }
}

/// The tool of move `index` with tip and axis at its end.
fn tool_after(program: &TimelineProgram, index: usize) -> Option<(Tool, Point, Vector)> {
    match program {
        TimelineProgram::Plunges(..) => None,
        TimelineProgram::Flank(run) => {
            let step = run.moves().get(index)?;
            Some((run.outcome.plan.tool.clone(), step.tip, step.axis))
        }
        TimelineProgram::Checked(checked) => {
            let step = checked.program.moves.get(index)?;
            let tool = checked.program.tools.get(step.tool?)?.completed(&checked.request.setup);
            Some((tool, step.tip, step.axis))
        }
    }
}
