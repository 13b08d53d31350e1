//! Why a program cannot run on a machine.

use crate::error::{ErrorCode, UserError};
use crate::monitor::Cancelled;

/// Why a program cannot run on a machine. `line` is that of the program, 0 where it has none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", self.explained())]
pub enum MotionFault {
    /// A position is out of the reach or the limits of the axes.
    OutOfLimits {
        /// Line of the first.
        line: usize,
        /// The first, in words.
        what: String,
        /// Number of directions of the tool without a solution.
        count: usize,
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
            Self::OutOfLimits { what, count, .. } => UserError::new(
                ErrorCode::AxisLimits,
                format!("{what} ({count} directions like this)"),
                "choose a machine that reaches it, or give the planner less max_axis_tilt",
            ),
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
