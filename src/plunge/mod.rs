//! The plunge planner ([plunge paper], fig. 16), one file per stage.
//!
//! | stage | file |
//! |---|---|
//! | which tool cuts which section | [`sections`], [`survey`], [`choice`] |
//! | axes that clear the walls | [`lane`] |
//! | 1 conventional positions, 2 step inspection | [`row`] |
//! | 3 axis optimisation | [`monotone`], `minimal`; rows of the policies that plan row by row: `attempts` |
//! | 4 drop-cutter depth (slotting depth in the paper) | [`crate::cutting::drop_cutter`] |
//! | 5 safe height | [`crate::cutting::retract`], [`links`] |
//! | 6 the loop, the cache of sections, the warm start | [`cycle`], [`SectionCache`], `carried` |
//! | layout of a section, shared by all policies | `ground` |
//! | the finished plan, over several channels, as a program | [`plan`], [`whole`], `program` |
//! | sectional view through one position | [`inspect`] |

mod assembly;
mod attempts;
mod carried;
pub mod choice;
pub mod cycle;
mod fit_table;
mod ground;
pub mod inspect;
mod known;
pub mod lane;
pub mod links;
mod minimal;
pub mod monotone;
pub mod plan;
mod program;
pub mod row;
pub mod sections;
pub mod survey;
pub mod whole;

pub use cycle::{PlacedPlan, PlanError, Planner};
pub use known::SectionCache;
pub use plan::{Blocked, DropReason, Dropped, LimitedBy, PlungePlan, Position, SectionPlan, StopReason};
