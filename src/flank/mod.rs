//! Flank milling: cutters beside the walls and across the floor of a passage.

pub mod fixed_axis;
pub mod wall;
