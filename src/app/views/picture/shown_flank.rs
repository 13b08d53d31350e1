//! What a picture shows of a flank plan.

use std::sync::Arc;

use crate::drawing::flank::{self, FlankColours};
use crate::gpu::mesh::Segment;
use crate::io::flank_file::shown_passes;
use crate::job::flank::FlankOutcome;

/// What is shown of a flank plan.
#[derive(Clone)]
pub struct ShownFlank {
    /// The plan.
    pub outcome: Arc<FlankOutcome>,
    /// What the colours show.
    pub colours: FlankColours,
    /// Number of moves made; `None`: all.
    pub made: Option<usize>,
    /// Moves of the selected pass: index of the first position, and index after the last one.
    pub selected: Option<[usize; 2]>,
}

impl PartialEq for ShownFlank {
    /// Plans are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        (self.colours, self.made, self.selected) == (other.colours, other.made, other.selected)
            && Arc::ptr_eq(&self.outcome, &other.outcome)
    }
}

impl ShownFlank {
    /// The whole plan as passes; until a moment of the timeline as moves; and the selected pass.
    pub(super) fn lines(&self) -> Vec<Segment> {
        let plan = &self.outcome.plan;
        let layers = plan.layout.layers.len();
        let mut lines = match self.made {
            None => flank::toolpath_lines(&shown_passes(plan), &plan.moves, layers, self.colours),
            Some(made) => flank::move_lines(
                &plan.moves[..made.min(plan.moves.len())],
                &plan.moves,
                layers,
                self.colours,
            ),
        };
        if let Some(moves) = self.selected.and_then(|[from, end]| plan.moves.get(from..end)) {
            lines.extend(flank::selected_lines(moves));
        }
        lines
    }
}
