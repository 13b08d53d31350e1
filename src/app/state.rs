//! What is open, what is being edited and what is shown; no drawing.

use std::path::PathBuf;
use std::sync::Arc;

use crate::gpu::scene::FloorColours;
use crate::part::{Impeller, Setup};

use super::engine::PartSource;
use super::planned::{Planned, Side, condition};
use super::theme::Condition;

/// What the 3D view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers {
    /// Hub, coloured by the stock left.
    pub hub: bool,
    /// Blades.
    pub blades: bool,
    /// Shroud, as glass.
    pub shroud: bool,
    /// Cutters at the end of their plunges.
    pub cutters: bool,
    /// Axes up to the retract points.
    pub axes: bool,
    /// What colours the floor of the channel in work.
    pub floor: FloorColours,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            hub: true,
            blades: true,
            shroud: false,
            cutters: true,
            axes: false,
            floor: FloorColours::Residual,
        }
    }
}

/// How a line of the status bar is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Something was done.
    Done,
    /// Something did not work; the text says what to do.
    Fault,
}

/// The latest message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// How it is meant.
    pub tone: Tone,
    /// One line.
    pub text: String,
}

/// What rows the table of positions shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// All.
    #[default]
    All,
    /// Those whose core meets stock.
    Interferential,
    /// Those whose axis could not be had.
    Blocked,
}

impl Filter {
    /// All filters.
    pub const ALL: [Self; 3] = [Self::All, Self::Interferential, Self::Blocked];

    /// Word in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::All => "All positions",
            Self::Interferential => "Interferential only",
            Self::Blocked => "Blocked only",
        }
    }
}

/// The part that is open.
#[derive(Clone, Debug)]
pub struct OpenPart {
    /// Where it came from.
    pub source: PartSource,
    /// The part.
    pub impeller: Arc<Impeller>,
}

/// Everything but the drawing.
#[derive(Debug, Default)]
pub struct State {
    /// The part.
    pub part: Option<OpenPart>,
    /// The setup being edited.
    pub setup: Setup,
    /// Whether all policies are planned, for comparison.
    pub compare: bool,
    /// File the setup was read from or written to.
    pub setup_path: Option<PathBuf>,
    /// Latest good plan of the part.
    pub planned: Option<Arc<Planned>>,
    /// Side that is shown.
    pub side: Side,
    /// Selected position of the shown side, in cutting order.
    pub selected: Option<usize>,
    /// Whether the table should scroll to the selection.
    pub reveal_selection: bool,
    /// Rows of the table.
    pub filter: Filter,
    /// Layers of the 3D view.
    pub layers: Layers,
    /// Latest message.
    pub notice: Option<Notice>,
    /// What is being opened.
    pub opening: Option<PartSource>,
}

impl State {
    /// Whether the setup was edited after the plan that is shown was asked for.
    pub fn out_of_date(&self) -> bool {
        self.planned.as_ref().is_some_and(|planned| planned.setup != self.setup)
    }

    /// Takes a part in; a plan of another part goes.
    pub fn open(&mut self, source: PartSource, impeller: Arc<Impeller>) {
        self.part = Some(OpenPart { source, impeller });
        self.planned = None;
        self.selected = None;
        self.side = Side::After;
        self.filter = Filter::All;
        self.notice = None;
    }

    /// Takes a plan in. The selection stays where the new plan still has that position.
    pub fn take_plan(&mut self, planned: Planned) {
        self.planned = Some(Arc::new(planned));
        self.selected = self.selected.filter(|&k| k < self.position_count());
        self.notice = None;
    }

    /// Number of positions of the side that is shown.
    pub fn position_count(&self) -> usize {
        self.planned.as_ref().map_or(0, |planned| planned.plan(self.side).positions.len())
    }

    /// Shows the other side, and there the same number if it exists.
    pub fn show(&mut self, side: Side) {
        self.side = side;
        self.selected = self.selected.filter(|&k| k < self.position_count());
    }

    /// Positions that pass the filter, in cutting order.
    pub fn filtered(&self) -> Vec<usize> {
        let Some(planned) = &self.planned else { return Vec::new() };
        let positions = planned.plan(self.side).positions.iter().enumerate();
        let passes = |filter, of| match filter {
            Filter::All => true,
            Filter::Interferential => of == Condition::Interferential,
            Filter::Blocked => of == Condition::Blocked,
        };
        positions.filter(|(_, p)| passes(self.filter, condition(p))).map(|(k, _)| k).collect()
    }

    /// Selects the position `step` places on from the selected one, around the end; with
    /// `faults_only`, among the interferential ones.
    pub fn step_selection(&mut self, step: isize, faults_only: bool) {
        let Some(planned) = &self.planned else { return };
        let positions = planned.plan(self.side).positions.iter().enumerate();
        let candidates: Vec<usize> =
            positions.filter(|(_, p)| !faults_only || p.contact.interferes()).map(|(k, _)| k).collect();
        let Some((&first, &last)) = candidates.first().zip(candidates.last()) else { return };
        let next = match self.selected {
            None => Some(if step > 0 { first } else { last }),
            Some(now) if step > 0 => candidates.iter().copied().find(|&k| k > now).or(Some(first)),
            Some(now) => candidates.iter().copied().rev().find(|&k| k < now).or(Some(last)),
        };
        self.select(next);
    }

    /// Selects a position and brings it into sight in the table.
    pub fn select(&mut self, position: Option<usize>) {
        self.selected = position;
        self.reveal_selection = position.is_some();
    }

    /// Says that something was done.
    pub fn done(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { tone: Tone::Done, text: text.into() });
    }

    /// Says that something did not work.
    pub fn fault(&mut self, text: impl Into<String>) {
        self.notice = Some(Notice { tone: Tone::Fault, text: text.into() });
    }
}
