//! The panels around the 3D view, one file each. A panel draws and edits the state and returns the requested
//! command or action; it does not execute it.

mod assess;
mod axis_demand;
mod cells;
pub mod edit_plunge;
pub mod fields;
mod figures;
pub mod flank;
pub mod flank_passes;
pub mod flank_results;
pub mod goal;
mod hand_mark;
pub mod library;
pub mod machine;
pub mod operations;
pub mod part;
pub mod plots;
pub mod policies;
pub mod positions;
pub mod problems;
pub mod program;
pub mod rotary;
pub mod section;
pub mod setup;
pub mod status;
pub mod study;
pub mod study_plot;
pub mod timeline;
pub mod tools;
mod tradeoff;
mod tradeoff_plot;
pub mod verdict;
pub mod whatif;
