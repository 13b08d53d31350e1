//! Why a program cannot run on a machine.

use super::limits::LimitFault;
use crate::error::{ErrorCode, UserError};
use crate::monitor::Cancelled;

/// Reach below which no plan can keep to it, degrees.
const MIN_USEFUL_REACH_DEG: f64 = 1.0;

/// Why a program cannot run on a machine. `line` is that of the program, 0 where it has none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", self.explained())]
pub enum MotionFault {
    /// A position is out of the reach or the limits of the axes.
    OutOfLimits {
        /// Line of the first.
        line: usize,
        /// What keeps the machine from the first.
        first: LimitFault,
        /// What keeps it from the one that is furthest beyond the limits of a linear axis.
        worst: Option<LimitFault>,
        /// Number of directions of the tool without a solution.
        count: usize,
        /// Largest angle of one of them from the table's normal, rad.
        steepest_rad: f64,
        /// Largest tilt up to which the machine reaches every direction, rad.
        reach_rad: f64,
    },
    /// An axis would have to turn back in the middle of a cut.
    TurnsBack {
        /// Line of the move.
        line: usize,
        /// The axis.
        letter: char,
    },
    /// A move that cannot be followed: the axis passes a pole or a limit.
    CannotFollow {
        /// Line of the move.
        line: usize,
        /// Tolerance, in words.
        tolerance: String,
    },
    /// A tool meets the table.
    MeetsTable {
        /// Line of the move.
        line: usize,
        /// Number of the tool.
        tool: u32,
        /// Whether it is the holder, not the cutter.
        is_holder: bool,
        /// How far it is below the table's upper face, mm.
        depth: f64,
    },
    /// The program lacks something that a control needs.
    Lacks {
        /// Line of the move.
        line: usize,
        /// What, and what to do.
        error: UserError,
    },
    /// The work was cancelled.
    Cancelled,
}

impl MotionFault {
    /// What is wrong and what to do.
    pub fn explained(&self) -> UserError {
        match self {
            Self::OutOfLimits { first, worst, count, steepest_rad, reach_rad, .. } => {
                let others = match count {
                    1 => "the only such direction".to_owned(),
                    n if first.is_of_linear_axis() => match worst {
                        Some(worst) if worst != first => {
                            format!("{n} such directions, up to {}", worst.where_to())
                        }
                        _ => format!("{n} such directions"),
                    },
                    n => {
                        let steepest = steepest_rad.to_degrees();
                        format!("{n} such directions, tilted by up to {steepest:.1}°")
                    }
                };
                let reach = reach_rad.to_degrees();
                let help = if first.is_of_linear_axis() {
                    "place the part elsewhere ([part] origin of the machine file), or choose a machine with \
                     more travel"
                        .to_owned()
                } else if reach < MIN_USEFUL_REACH_DEG {
                    "choose another machine".to_owned()
                } else {
                    format!(
                        "plan with this machine as [machine] file of the setup, without a max_axis_tilt above \
                         the {reach:.1}° that it reaches, or choose another machine"
                    )
                };
                UserError::new(ErrorCode::AxisLimits, format!("{first} ({others})"), help)
            }
            Self::TurnsBack { letter, .. } => UserError::new(
                ErrorCode::AxisTurnsBack,
                format!("{letter} meets its limit in the middle of a cut"),
                format!("choose a machine with a wider or endless {letter}"),
            ),
            Self::CannotFollow { tolerance, .. } => UserError::new(
                ErrorCode::AxisCannotFollow,
                format!(
                    "the axis turns so that the machine cannot follow within {tolerance} of the planned turn"
                ),
                "add positions there",
            ),
            Self::MeetsTable { tool, is_holder, depth, .. } => UserError::new(
                ErrorCode::AssemblyCollides,
                format!(
                    "the {} of tool {tool} would go {depth:.1} mm below the upper face of the table",
                    if *is_holder { "holder" } else { "cutter" }
                ),
                "raise the part ([part] origin of the machine file), give the tool more overhang, or plan with a \
                 smaller max_axis_tilt",
            ),
            Self::Lacks { error, .. } => error.clone(),
            Self::Cancelled => Cancelled.into(),
        }
    }

    /// Line of the program, 0 where there is none.
    pub fn line(&self) -> usize {
        match self {
            Self::OutOfLimits { line, .. }
            | Self::TurnsBack { line, .. }
            | Self::CannotFollow { line, .. }
            | Self::MeetsTable { line, .. }
            | Self::Lacks { line, .. } => *line,
            Self::Cancelled => 0,
        }
    }

    /// Number of positions beyond limits.
    pub fn limits_exceeded(&self) -> usize {
        match self {
            Self::OutOfLimits { count, .. } => *count,
            Self::TurnsBack { .. } => 1,
            _ => 0,
        }
    }
}

impl From<Cancelled> for MotionFault {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
