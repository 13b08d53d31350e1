//! The exported program of what is shown, for the line beside the timeline.

use std::sync::Arc;

use super::Repaint;
use crate::app::model::listing::ProgramListing;
use crate::app::model::state::AppState;
use crate::app::model::timeline_program::TimelineProgram;
use crate::app::tasks::latest::Latest;
use crate::io::apt::{read_apt_bytes, write_apt};
use crate::toolpath::Travel;

/// Lists the program in the background.
pub(in crate::app) struct ListingWork(Latest<TimelineProgram, Arc<ProgramListing>>);

impl ListingWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        Self(Latest::new("listing", repaint, listing_of))
    }

    /// Requests the program of the shown plan for one channel, or the checked program as its file has it.
    /// Returns it once it is known.
    pub(in crate::app) fn follow(&mut self, state: &AppState) -> Option<Arc<ProgramListing>> {
        let wanted = state.timeline_program();
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
fn listing_of(listed: &TimelineProgram) -> Arc<ProgramListing> {
    let (program, ends) = match listed {
        TimelineProgram::Checked(checked) => return Arc::clone(&checked.listing),
        of_plan => of_plan.moves(),
    };
    let text = write_apt(&program);
    let read = read_apt_bytes("", text.as_bytes());
    let moves = read.as_ref().map_or(&[][..], |program| &program.moves);
    let line = |index: usize| moves.get(index).map(|step| step.line);
    let lines = ends.iter().map(|end| end.and_then(line)).collect();
    let clock = listed.clock(&program, &ends, &Travel::clock(&program));
    Arc::new(ProgramListing::new(text, lines, clock))
}
