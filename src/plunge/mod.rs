//! The plunge planner (paper A, fig. 16): each stage its own file.

pub mod plan;

pub use plan::{Blocked, CoreContact, PlungePlan, Position, SectionPlan};
pub mod contact;
pub mod slotting;
