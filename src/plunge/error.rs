//! Why planning fails.

use crate::error::UserError;
use crate::monitor::Cancelled;
use crate::setup::SetupFault;

/// Why planning failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Part and setup do not match.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

impl From<PlanError> for UserError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(cancelled) => cancelled.into(),
            PlanError::Setup(fault) => fault.into(),
        }
    }
}
