//! Parts of a tool, and what they do to stock.

/// What a piece does to the stock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Action {
    /// It removes stock.
    Cut,
    /// It must not meet stock.
    Check(ToolPart),
}

/// The part of a tool that meets stock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ToolPart {
    /// The core of a plunging cutter, which has no edges.
    Core,
    /// The cutter in rapid.
    Cutter,
    /// The shank.
    Shank,
    /// The holder.
    Holder,
}

impl ToolPart {
    /// Its name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Core => "core",
            Self::Cutter => "cutter",
            Self::Shank => "shank",
            Self::Holder => "holder",
        }
    }
}
