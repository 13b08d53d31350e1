//! The flank region planner (paper B): layers of constant depth, regions, and curves that are true offsets of the walls.
//!
//! | file | holds |
//! |---|---|
//! | [`choice`] | the cutter |
//! | [`interval`] | distance of neighbouring curves |
//! | [`layer`] | the surfaces, geodesics on them |
//! | [`border`] | the walls on a layer, and the fans that leave them |
//! | [`chart`] | distances from the walls over a layer |
//! | [`schemes`] | curves: isoparametric, by layers, by regions, balanced |
//! | [`curves`] | all layers of a channel, and how the schemes compare |
//! | [`wall`] | cutters beside the walls: the axes of the curves along them |
//! | [`fixed_axis`] | axes of the inner curves: as few as are free of collision |
//! | `passes` | from curves to positions of the cutter |
//! | `engagement` | which passes run through full stock |
//! | [`checked`] | what a check of the whole program finds fault with, left out |
//! | [`path`] | order, links and flights: from positions to a program |
//! | [`plan`] | the whole plan, stage by stage |

pub mod border;
pub mod chart;
pub mod checked;
pub mod choice;
pub mod curves;
mod engagement;
pub mod fixed_axis;
pub mod interval;
pub mod layer;
mod passes;
pub mod path;
pub mod plan;
pub mod schemes;
pub mod wall;

pub use curves::{CurveSource, FlankCurves, FlankError};
pub use passes::LeftOut;
pub use path::{FlankMove, MoveKind};
pub use plan::{FlankPlan, FlankStages, MilledWall, plan};
