//! What the fields of the edits of a plunge hold until they are applied.

use crate::setup::PlungeMove;

/// What the fields of the edit tab say, until it is applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EditFields {
    /// Whether the whole row is edited.
    pub whole_row: bool,
    /// By how much to stop short, mm.
    pub lift: f64,
    /// Where to move, and how to turn.
    pub by: PlungeMove,
}

impl Default for EditFields {
    fn default() -> Self {
        Self { whole_row: false, lift: 0.5, by: PlungeMove::default() }
    }
}
