//! Lengths of passes that are not cut, and why.

use super::region::Region;
use crate::setup::AssemblyPart;

/// Why a length of passes is not cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UncutReason {
    /// The reason, as a message.
    pub message: &'static str,
    /// The part of the tool above its cutter that is in the way; `None` where something else is.
    pub hindered_by: Option<AssemblyPart>,
}

impl UncutReason {
    /// A reason that has nothing to do with shank or holder.
    pub const fn new(message: &'static str) -> Self {
        Self { message, hindered_by: None }
    }

    /// The shank is in the way.
    pub const fn shank(message: &'static str) -> Self {
        Self { message, hindered_by: Some(AssemblyPart::Shank) }
    }

    /// The holder is in the way.
    pub const fn holder(message: &'static str) -> Self {
        Self { message, hindered_by: Some(AssemblyPart::Holder) }
    }

    /// Whether this part of the tool is in the way.
    pub fn is_by(&self, part: AssemblyPart) -> bool {
        self.hindered_by == Some(part)
    }
}

/// A length of passes that is not cut, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct UncutLength {
    /// Layer, 0 at the hub.
    pub layer: usize,
    /// Region.
    pub region: Region,
    /// Length of the passes there, mm.
    pub length: f64,
    /// The reason.
    pub why: UncutReason,
    /// Smallest overhang with which the tool would have an axis there, mm; `None` where something else than
    /// shank or holder is in the way, or no overhang within reason suffices.
    pub overhang: Option<f64>,
}

impl UncutLength {
    /// Adds a length (mm) that is left out for the same reason, and could be cut with an `overhang`.
    pub fn add(&mut self, length: f64, overhang: Option<f64>) {
        self.length += length;
        self.overhang = self.overhang.zip(overhang).map(|(a, b)| a.max(b));
    }
}
