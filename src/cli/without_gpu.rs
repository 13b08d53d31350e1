//! What the commands answer that draw pictures, in a program that was built without the feature `gpu`.

use super::Failure;

fn no_pictures<T>() -> Result<T, Failure> {
    Err(Failure::not_built_in("pictures", "build it with --features gpu"))
}

/// Stands in for the pictures of plans and parts.
pub mod render {
    use std::path::Path;

    use super::{Failure, no_pictures};
    use crate::cli::args::RenderArgs;
    use crate::job::PlanOutcome;

    /// # Errors
    /// Always [`Failure::work`].
    pub fn run(_: &RenderArgs) -> Result<(), Failure> {
        no_pictures()
    }

    /// None: a setup sheet has its drawings all the same.
    ///
    /// # Errors
    /// Never.
    pub fn write_pictures(_: &Path, _: &PlanOutcome) -> Result<Vec<(String, String)>, Failure> {
        Ok(Vec::new())
    }
}

/// Stands in for the pictures of an assessment.
pub mod assess_pictures {
    use std::path::Path;

    use super::{Failure, no_pictures};
    use crate::assess::Assessment;
    use crate::part::Workpiece;
    use crate::setup::Setup;

    /// # Errors
    /// Always [`Failure::work`].
    pub fn write(_: &Path, _: &Workpiece, _: &Setup, _: &Assessment) -> Result<String, Failure> {
        no_pictures()
    }
}
