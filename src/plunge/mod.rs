//! The plunge planner (paper A, fig. 16): each stage its own file.
//!
//! | stage | file |
//! |---|---|
//! | which cutter works where | [`sections`], [`survey`], [`choice`] |
//! | axes that clear the walls | [`lane`] |
//! | 1 conventional positions, 2 step inspection | [`row`] |
//! | 3 axis optimisation | [`monotone`] |
//! | 4 slotting depth | [`slotting`] |
//! | 5 safe height | [`retract`], [`flight`], [`links`] |
//! | 6 the loop | [`cycle`], and what still holds of the plan before: [`KnownSections`], `carried` |
//! | the truth: contact of the core, clearances | [`contact`], [`clearance`] |
//! | a look at one position of a plan | [`inspect`] |

mod attempts;
mod carried;
pub mod choice;
pub mod clearance;
pub mod contact;
pub mod cycle;
mod fit_table;
pub mod flight;
mod ground;
pub mod inspect;
mod known;
pub mod lane;
pub mod links;
mod minimal;
pub mod monotone;
pub mod plan;
pub mod retract;
pub mod row;
pub mod sections;
pub mod slotting;
pub mod survey;
pub mod whole;

pub use cycle::{PlacedPlan, PlanError, Planner};
pub use known::KnownSections;
pub use plan::{Blocked, CoreContact, Dropped, Held, NoPlace, PlungePlan, Position, SectionPlan, Stopped};
