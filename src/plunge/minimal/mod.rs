//! Stage 3 by the policy `minimal`: minimum residual layer under the constraint that the core meets no stock.
//!
//! Contact of the core with stock is the constraint, the layer left on the hub the objective. A row is a path
//! through candidate axes: dynamic programming over lead angles, one stage per position, pruned by a beam. A
//! state costs the layer that its position leaves. Where the core would meet stock, the plunge stops short of
//! it, and the layer left by that counts as well, so the search weighs other inclinations against lifts.
//! Finally single plunges are added where the rows left the most (lazy greedy).

mod axes;
mod axis_frame;
mod axis_limits;
mod candidate;
mod crossing;
mod extras;
mod floor;
mod free_leads;
mod path;
mod pool_rounds;
mod row_path;
mod row_stages;
mod rows;
mod second_pass;
mod section;
mod stages;
mod touch_up;
mod uncut_floor;
mod visit_order;

pub use candidate::CandidateMaker;
pub use crossing::RowCrossing;
pub use extras::ExtraSearch;
pub use floor::FloorHeightMap;
pub(super) use free_leads::{LeadBlockage, lead_blockage};
pub use path::{MINIMAL_MAX_LIFT_SHARE, PathSearch};
pub use row_path::RowPath;
pub(super) use section::plan_section;
pub(super) use touch_up::rest_section;
