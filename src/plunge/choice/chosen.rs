//! A section as it was chosen, with the reason.

use crate::setup::SectionSetup;

/// A chosen section with the reason for it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenSection {
    /// The section, without a cutting direction.
    pub section: SectionSetup,
    /// The reason, one line.
    pub reason: String,
    /// Estimated number of places in its rows; 0 without rows.
    pub places: f64,
    /// Number of stations at which its tool is wider than the passage or too short for it.
    pub misfits: u32,
}
