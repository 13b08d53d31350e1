//! What a picture shows of a flank plan.

use std::sync::Arc;

use crate::app::model::flank_run::FlankRun;
use crate::drawing::flank::{self, FlankColours};
use crate::geometry::rotate_z;
use crate::gpu::mesh::Segment;
use crate::io::flank_file::{ShownPass, shown_passes};

/// What is shown of a flank plan.
#[derive(Clone)]
pub struct ShownFlank {
    /// The plan, in the shown channels.
    pub run: Arc<FlankRun>,
    /// What the colours show.
    pub colours: FlankColours,
    /// Number of moves made; `None`: all.
    pub made: Option<usize>,
    /// Whether the passes are drawn, and not only the selected one.
    pub passes: bool,
    /// Whether rapids are drawn with them.
    pub rapids: bool,
    /// Moves of the selected pass: index of the first position, and index after the last one.
    pub selected: Option<[usize; 2]>,
}

impl PartialEq for ShownFlank {
    /// Plans are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        (self.colours, self.made, self.passes, self.rapids, self.selected)
            == (other.colours, other.made, other.passes, other.rapids, other.selected)
            && Arc::ptr_eq(&self.run, &other.run)
    }
}

impl ShownFlank {
    /// The whole plan as passes; until a moment of the timeline as moves; and the selected pass.
    pub(super) fn lines(&self) -> Vec<Segment> {
        let (plan, moves) = (&self.run.outcome.plan, self.run.moves());
        let layers = plan.layout.layers.len();
        let mut lines = match self.made {
            _ if !self.passes => Vec::new(),
            None => flank::toolpath_lines(&self.all_passes(), moves, layers, self.colours, self.rapids),
            Some(made) => {
                let made = &moves[..made.min(moves.len())];
                flank::move_lines(made, moves, layers, self.colours, self.rapids)
            }
        };
        if let Some(moves) = self.selected.and_then(|[from, end]| moves.get(from..end)) {
            lines.extend(flank::selected_lines(moves));
        }
        lines
    }

    /// The passes in all channels.
    fn all_passes(&self) -> Vec<ShownPass> {
        let of_one = shown_passes(&self.run.outcome.plan);
        let turned = |turn_rad: f64| {
            of_one.iter().map(move |pass| {
                let points = pass.points.iter().map(|point| rotate_z(point, turn_rad)).collect();
                ShownPass { points, ..pass.clone() }
            })
        };
        self.run.turns_rad().into_iter().flat_map(turned).collect()
    }
}
