//! Work in the background: reading, planning, writing, simulating. Nothing here draws or knows egui.

use std::sync::Arc;

pub(in crate::app) mod assess;
pub mod check;
pub(in crate::app) mod documents;
pub mod engine;
pub(in crate::app) mod files;
pub(in crate::app) mod flank_runs;
pub(in crate::app) mod home;
pub(in crate::app) mod latest;
pub(in crate::app) mod listing;
pub(in crate::app) mod lock;
pub(in crate::app) mod machine;
pub(in crate::app) mod machine_name;
pub(in crate::app) mod mesh_nodes;
pub(in crate::app) mod open_task;
pub(in crate::app) mod opening;
pub(in crate::app) mod part_meshes;
pub(in crate::app) mod program_watch;
pub(in crate::app) mod programs;
pub(in crate::app) mod project;
pub(in crate::app) mod scrub;
pub mod solid;
pub(in crate::app) mod tradeoff;
pub(in crate::app) mod work;

/// Asks the window to draw itself again, from any thread.
pub type Repaint = Arc<dyn Fn() + Send + Sync>;
