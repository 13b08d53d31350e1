//! The residual layer as a heightfield over one channel's hub floor: the fast picture of what a
//! plan leaves (DESIGN section 5). Single precision, same arithmetic as the WGSL kernel.

use crate::plunge::PlungePlan;

mod bounds;
pub mod field;
pub mod grid;
mod meeting;
pub mod statistics;
pub mod tiles;
pub(crate) mod trace;

pub use field::{FieldCutter, ResidualField, residual_field};
pub use grid::FloorGrid;
pub use statistics::{ResidualStatistics, statistics};
pub use tiles::TileBins;
pub use trace::PositionTrace;

/// The plunges of a plan, in cutting order, as the kernels take them.
pub fn cutters_of(plan: &PlungePlan) -> Vec<FieldCutter> {
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    plan.positions
        .iter()
        .map(|p| {
            let tool = &plan.sections[p.section].tool;
            FieldCutter {
                tip: single(p.tip.coords.into()),
                radius: tool.radius() as f32,
                axis: single(p.axis.into()),
                core_radius: tool.core_radius() as f32,
                corner_radius: tool.corner_radius as f32,
            }
        })
        .collect()
}
