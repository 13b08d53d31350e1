//! Plunge plans of real and random parts, and the stages of the planner.

mod assess;
mod channel;
mod floor;
mod free_of_contact;
mod inspect;
mod plan;
mod probe;
mod program;
mod slotting;
mod tool_choice;
