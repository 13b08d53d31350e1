//! Places that a timeline jumps to.

/// Where a timeline jumps to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// The first plunge of a tool.
    Tool,
    /// The first plunge of a section; of a flank plan the first move of a layer; of a checked program that of
    /// a section that it names.
    Section,
}
