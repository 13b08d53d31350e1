//! The residual layer as a heightfield over one channel's hub floor: the fast picture of what a
//! plan leaves (DESIGN section 5). Single precision, same arithmetic as the WGSL kernel.

pub mod field;
pub mod grid;
pub mod statistics;
pub mod tiles;

pub use field::{CutterGpu, PositionTrace, ResidualField, residual_field};
pub use grid::FloorGrid;
pub use statistics::{ResidualStatistics, statistics};
pub use tiles::TileBins;
