//! The plunge planner ([plunge paper], fig. 16), one file per stage. [`Planner`] is what others use. Every
//! step is a function over its context (`context`): the workpiece, the complete setup, and what follows from
//! both whichever policy plans.
//!
//! | policy | where it decides the axes, from its `plan_section` on |
//! |---|---|
//! | `conventional`, `staircase` | `conventional`, `staircase` |
//! | `monotone` | [`monotone`] |
//! | `minimal` | `minimal`, with rest milling (`rest_section`) |
//!
//! | stage | file |
//! |---|---|
//! | which tool cuts which section | [`sections`], [`survey`], [`choice`] |
//! | which sections are cut from the inlet | [`cutting_order`] |
//! | axes that clear the walls | [`lane`] |
//! | 1 conventional positions, 2 step inspection | [`row`] |
//! | 3 axis optimisation | the policies; what those share that plan row by row: `row_plan` |
//! | 4 drop-cutter depth (slotting depth in the paper) | [`crate::cutting::drop_cutter`] |
//! | 5 safe height | [`crate::cutting::retract`], [`links`] |
//! | which policy plans a section | `policies` |
//! | rows and sections as they are cut | `cut` |
//! | contact and retract points of a placed plan | `evaluation` |
//! | 6 the loop, the cache of sections, the warm start | [`cycle`], [`SectionCache`], `warm_start` |
//! | what stands above the shroud | [`opening`] |
//! | layout of a section, shared by all policies | `section_layout` |
//! | largest distances between plunges | [`spacing`] |
//! | how closely rows lie | [`RowDensity`] |
//! | how the plunges of a plan are moved | `motion` |
//! | a plan with some plunges left out | `subset` |
//! | a plan edited by hand | `edits`, `edit_pose`, `edit_report` |
//! | plunges that the user locked | `locked` |
//! | the finished plan, over several channels, as a program | [`plan`], [`channels`], `program` |
//! | sectional view through one position | [`inspect`] |

mod approach;
mod assembly;
pub mod channels;
pub mod choice;
mod context;
mod conventional;
mod cut;
pub mod cutting_order;
pub mod cycle;
mod edit_pose;
mod edit_report;
mod edits;
mod error;
mod evaluation;
pub mod inspect;
pub mod lane;
pub mod links;
mod locked;
mod locked_plunge;
mod minimal;
pub mod monotone;
mod motion;
mod needed_opening;
pub mod opening;
mod opening_section;
mod placed_cutter;
pub mod plan;
mod planner;
mod policies;
mod position_limit;
mod program;
mod reasons;
pub mod row;
mod row_density;
mod row_places;
mod row_plan;
mod section_cache;
mod section_layout;
pub mod sections;
pub mod spacing;
mod staircase;
mod subset;
pub mod survey;
mod thoroughness;
mod warm_start;
mod whole_plan;

pub use edit_report::{EditReport, NearPlunge, PlungeMark, UnappliedEdit, UnappliedReason};
pub use error::PlanError;
pub use plan::{Dropped, Evaluation, Pecking, PlungeMotion, PlungePlan, Position, SectionPlan, Unevaluated};
pub use planner::Planner;
pub use position_limit::MAX_POSITIONS;
pub use reasons::{AddedPlunges, Blocked, Breach, Condition, DropReason, LimitedBy, StopReason};
pub use row_density::RowDensity;
pub use section_cache::SectionCache;
pub use whole_plan::PlacedPlan;
