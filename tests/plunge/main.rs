//! Plunge plans of real and made parts, and what they are made from.

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
