//! The panels around the 3D view, one file each. A panel draws from the state, edits the state, and
//! returns what it asks for; it starts nothing itself.

pub mod fields;
pub mod flank;
pub mod part;
pub mod plots;
pub mod policies;
pub mod positions;
pub mod problems;
pub mod section;
pub mod setup;
pub mod status;
pub mod timeline;
pub mod tools;
pub mod verdict;
pub mod whatif;
