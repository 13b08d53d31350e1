//! The flank milling planner [flank paper]: layers of constant depth, regions, and passes that are true
//! offsets of the walls.
//!
//! | file | contents |
//! |---|---|
//! | [`choice`] | choice of the tool |
//! | [`stepover`] | stepover from scallop height, tool and curvature |
//! | [`layer`] | layer surfaces and geodesics on them |
//! | [`region`] | names of the walls and of the regions between them |
//! | [`layer_walls`] | the walls on a layer and the fans of geodesics that leave them |
//! | [`layer_regions`] | the regions between these walls |
//! | [`chart`] | distance fields of the walls over a layer |
//! | [`strategies`] | strategies: isoparametric, by layers, by regions, balanced |
//! | [`curves`] | passes on all layers of a channel, and figures to compare the strategies |
//! | [`wall`] | tool axes of the passes along walls, fitted to the wall |
//! | [`fixed_axis`] | tool axes of inner passes: fewest fixed axes that are free of collision |
//! | `passes` | tool positions along the passes |
//! | `engagement` | which passes run through full stock |
//! | [`fault_removal`] | removal of the moves that a check of the whole program rejects |
//! | `opening` | plunges above the shroud that come before the passes |
//! | [`path`] | order, links and rapids: from passes to a program |
//! | [`channels`] | the program for several channels, with the links between them |
//! | [`plan`](mod@plan) | the whole plan, stage by stage |
//! | `program` | the plan as a cutter-location program |

pub mod channels;
pub mod chart;
pub mod choice;
pub mod curves;
mod engagement;
pub mod fault_removal;
pub mod fixed_axis;
pub mod layer;
pub mod layer_regions;
pub mod layer_walls;
mod offset;
mod opening;
mod passes;
pub mod path;
pub mod plan;
mod program;
pub mod region;
pub mod stepover;
pub mod strategies;
mod uncut;
pub mod wall;

pub use curves::{FlankError, FlankLayout, LayoutInputs};
pub use opening::FlankOpening;
pub use path::{FlankMove, MoveKind};
pub use plan::{FlankPlan, FlankStages, plan};
pub use uncut::{UncutLength, UncutReason};
pub use wall::MilledWall;
