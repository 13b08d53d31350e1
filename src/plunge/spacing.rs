//! Largest distances between plunges: along a row, between rows on the hub, and at the shroud.

use crate::setup::cutting_data::step_by_stick_out;
use crate::setup::{PlungeSetup, Tool};

/// Upper limit of the step along a row, mm: what insert width and stick-out permit and the `step` of the
/// setup, and for wall rows the step S ≤ 2·√(2Rh − h²) that leaves the scallop height h.
pub fn step_limit(plunge: &PlungeSetup, tool: &Tool, wall_row: bool) -> f64 {
    let radius = tool.radius();
    let limit = step_by_stick_out(tool).min(radius).min(plunge.step.unwrap_or(0.8 * tool.insert_width));
    if wall_row { limit.min(scallop_step(plunge, tool)) } else { limit }
}

/// Step S = 2·√(2Rh − h²) along a wall that leaves the scallop height h of the setup between two plunges, mm.
pub fn scallop_step(plunge: &PlungeSetup, tool: &Tool) -> f64 {
    let radius = tool.radius();
    let h = plunge.wall_scallop.min(radius);
    2.0 * (2.0 * radius * h - h * h).sqrt()
}

/// Maximum stepover between rows on the hub, mm.
pub fn stepover(plunge: &PlungeSetup, tool: &Tool) -> f64 {
    plunge.stepover.unwrap_or(4.0 / 3.0 * tool.radius())
}

/// Maximum distance of neighbouring axes at the shroud without uncut stock between them, mm.
pub fn max_shroud_spacing(tool: &Tool) -> f64 {
    1.9 * tool.radius()
}
