//! The exported program of what is shown, for the line beside the timeline.

use std::sync::Arc;

use super::Repaint;
use super::programs::{PlungeSource, cl_text, flank_text};
use crate::app::model::listing::ProgramListing;
use crate::app::model::look::Operation;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::state::AppState;
use crate::app::tasks::latest::Latest;
use crate::io::apt::read_apt_bytes;
use crate::job::flank::FlankOutcome;
use crate::setup::AxisPolicy;
use crate::toolpath::ClProgram;

/// The plan whose program is listed.
#[derive(Clone)]
enum ListedPlan {
    Plunges(Arc<DisplayPlan>, AxisPolicy),
    Flank(Arc<FlankOutcome>),
}

impl PartialEq for ListedPlan {
    /// Plans are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Plunges(a, policy), Self::Plunges(b, wanted)) => policy == wanted && Arc::ptr_eq(a, b),
            (Self::Flank(a), Self::Flank(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl ListedPlan {
    /// The plan of the shown operation.
    fn shown(state: &AppState) -> Option<Self> {
        match state.look.operation {
            Operation::Roughing => {
                state.shown().map(|shown| Self::Plunges(Arc::clone(shown.planned), shown.policy))
            }
            Operation::Flank => state.results.flank.clone().map(Self::Flank),
            Operation::Program => None,
        }
    }
}

/// Lists the program in the background.
pub(in crate::app) struct ListingWork(Latest<ListedPlan, Arc<ProgramListing>>);

impl ListingWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        Self(Latest::new("listing", repaint, |listed: &ListedPlan| Arc::new(listing_of(listed))))
    }

    /// Requests the program of the shown plan for one channel. Returns it once it is known.
    pub(in crate::app) fn follow(&mut self, state: &AppState) -> Option<Arc<ProgramListing>> {
        let wanted = ListedPlan::shown(state);
        self.0.request(wanted.clone());
        // Lines of another program would mislead.
        let (of, listing) = self.0.answer()?;
        wanted.filter(|wanted| wanted == of).map(|_| Arc::clone(listing))
    }

    /// Whether a program is being listed.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }
}

/// The program as it is written, read back for the lines of its moves; without lines where that fails.
fn listing_of(listed: &ListedPlan) -> ProgramListing {
    let (text, ends): (String, Vec<Option<usize>>) = match listed {
        ListedPlan::Plunges(planned, policy) => {
            let plan = planned.plan(*policy);
            let bottoms = ClProgram::of_plan("", plan).bottoms_of(plan);
            (cl_text(&PlungeSource { planned: Arc::clone(planned), policy: *policy, channels: 1 }), bottoms)
        }
        ListedPlan::Flank(outcome) => {
            let plan = &outcome.plan;
            // The timeline does not include the plunges that open the stock before the passes.
            let all = ClProgram::of_flank("", &plan.tool, &plan.moves).after_opening(plan.opening.as_ref());
            let before = all.moves.len() - plan.moves.len();
            (flank_text(outcome), (before..all.moves.len()).map(Some).collect())
        }
    };
    let read = read_apt_bytes("", text.as_bytes());
    let moves = read.as_ref().map_or(&[][..], |program| &program.moves);
    let line = |index: usize| moves.get(index).map(|step| step.line);
    let lines = ends.into_iter().map(|end| end.and_then(line)).collect();
    ProgramListing::new(text, lines)
}
