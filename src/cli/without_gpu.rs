//! What the commands answer that draw pictures, in a program that was built without the feature `gpu`.

use super::Failure;

pub fn no_pictures<T>() -> Result<T, Failure> {
    Err(Failure::not_built_in("pictures", "build it with --features gpu"))
}

/// Stands in for the pictures of plans and parts.
pub mod render {
    use super::{Failure, no_pictures};
    use crate::cli::args::RenderArgs;

    /// # Errors
    /// Always [`Failure::work`].
    pub fn run(_: &RenderArgs) -> Result<(), Failure> {
        no_pictures()
    }
}
