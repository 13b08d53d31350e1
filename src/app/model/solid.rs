//! The stock as a solid that the views show: of which plans or program, after how many moves, in which
//! colours.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::app::model::checked::CheckedProgram;
use crate::app::model::flank_run::FlankRun;
use crate::app::model::planned::DisplayPlan;
use crate::setup::AxisPolicy;

/// What the colours of the solid show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolidColours {
    /// Distance of the cut surface to the finished part.
    #[default]
    Distance,
    /// The tool that cut it.
    Tool,
    /// The section of the plan or program that cut it.
    Section,
    /// Whether the plunge that cut it is sound, blocked, or meets stock with its core; of a program, whether
    /// its move has a fault.
    Fault,
}

impl SolidColours {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Distance, Self::Tool, Self::Section, Self::Fault];

    /// Label in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::Distance => "Distance to part",
            Self::Tool => "Tool",
            Self::Section => "Section",
            Self::Fault => "Fault",
        }
    }
}

/// What is simulated.
#[derive(Clone, Debug)]
pub enum SolidSource {
    /// A plunge plan, and after it a flank plan.
    Plans(PlannedSolid),
    /// A checked program, alone.
    Program(Arc<CheckedProgram>),
}

/// A plunge plan, and after it a flank plan.
#[derive(Clone, Debug)]
pub struct PlannedSolid {
    /// The set of plans.
    pub planned: Arc<DisplayPlan>,
    /// Policy of the plunge plan.
    pub policy: AxisPolicy,
    /// Number of channels that it mills.
    pub channels: usize,
    /// The flank plan that follows it, in its channels.
    pub flank: Option<Arc<FlankRun>>,
}

impl PartialEq for SolidSource {
    /// Plans and checked programs are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Plans(a), Self::Plans(b)) => {
                let flank = match (&a.flank, &b.flank) {
                    (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                    (a, b) => a.is_none() && b.is_none(),
                };
                flank
                    && (a.policy, a.channels) == (b.policy, b.channels)
                    && Arc::ptr_eq(&a.planned, &b.planned)
            }
            (Self::Program(a), Self::Program(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// How much of the plans, or of the program, is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StockMoment {
    /// Everything.
    End,
    /// The first n plunges.
    Plunges(usize),
    /// All plunges, and the first n moves of the flank plan.
    FlankMoves(usize),
    /// The first n moves of a checked program.
    Moves(usize),
}

/// A state of the stock, with its colours.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidRequest {
    /// The plans, or the program.
    pub source: SolidSource,
    /// How much of them is made.
    pub moment: StockMoment,
    /// Colours.
    pub colours: SolidColours,
}
