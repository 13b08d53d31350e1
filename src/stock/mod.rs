//! The residual stock as a heightfield over one channel's hub floor: a fast estimate of what a plan leaves.
//! Single precision, same arithmetic as the WGSL kernel. And the stock of a whole wheel as a solid
//! ([`solid`]).

use crate::plunge::{PlungePlan, Position, SectionPlan};
use crate::setup::{SectionKind, SectionSetup, Setup, Tool};

mod bounds;
mod corner;
pub mod cover;
pub mod excess;
pub mod field;
mod field_cutter;
mod floor_source;
pub mod grid;
mod grid_fill;
mod hub_patch;
pub mod levels;
pub(crate) mod meeting;
pub mod obstacles;
mod overhang;
pub mod reach;
pub mod solid;
pub mod statistics;
pub mod surface;
pub mod tiles;
pub(crate) mod trace;

pub use corner::CornerLimit;
pub use field::{FieldCache, ResidualField, residual_field};
pub use field_cutter::FieldCutter;
pub use floor_source::{CutterStretch, FloorSource};
pub use grid::FloorGrid;
pub use levels::{FieldProgram, FloorLevel, FloorLevels};
pub use obstacles::{FloorObstacle, InaccessibleFloor};
pub use statistics::{ExcessStock, ResidualStatistics, statistics};
pub use tiles::TileBins;
pub use trace::PositionTrace;

/// The plunges of a plan, in cutting order, as input of the kernels.
pub fn field_cutters<E>(plan: &PlungePlan<E>) -> Vec<FieldCutter> {
    let tool = |p: &Position<E>| &plan.sections[p.section].tool;
    plan.positions.iter().map(|p| FieldCutter::from_tool(tool(p), p.tip, p.axis)).collect()
}

/// The ranges of s of the sections of a setup, with the cutter of each; all sections only if the setup is
/// resolved. Those of another kind do not count: the rows define which floor is reachable.
pub fn stretches_of_setup(setup: &Setup) -> Vec<CutterStretch> {
    let radius = |number: u32| setup.tools.iter().find(|tool| tool.number == number).map(Tool::radius);
    let stretch = |s: &SectionSetup| {
        Some(CutterStretch { from: s.from, to: s.to, radius: radius(s.tool)?, tool: s.tool })
    };
    setup
        .plunge
        .sections
        .iter()
        .filter(|section| section.kind == SectionKind::Rows)
        .filter_map(stretch)
        .collect()
}

/// As [`stretches_of_setup`], of the sections of a plan or program.
pub fn stretches_of(sections: &[SectionPlan]) -> Vec<CutterStretch> {
    let stretch = |s: &SectionPlan| {
        let tool = &s.tool;
        CutterStretch { from: s.from, to: s.to, radius: tool.radius(), tool: tool.number }
    };
    sections.iter().filter(|section| section.kind == SectionKind::Rows).map(stretch).collect()
}
