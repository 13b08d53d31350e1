//! Largest distances between plunges: along a row, between rows on the hub, and at the shroud.

use crate::geometry::Vector;
use crate::setup::cutting_data::step_by_stick_out;
use crate::setup::{PlungeSetup, Tool};

/// Default step along a row, in insert widths: with a reserve to the whole width, which is the most that a
/// step may be.
const STEP_INSERT_WIDTHS: f64 = 0.8;
/// Default stepover between rows, in cutter radii.
const STEPOVER_RADII: f64 = 4.0 / 3.0;

/// Step along a row where the setup gives none, mm; a long stick-out permits less, see [`step_limit`].
pub fn default_step(tool: &Tool) -> f64 {
    STEP_INSERT_WIDTHS * tool.insert_width
}

/// The most that a step along a row of `tool` may be, whatever the setup asks for, mm: what insert width and
/// stick-out permit, and its radius.
pub fn max_step(tool: &Tool) -> f64 {
    step_by_stick_out(tool).min(tool.radius())
}

/// Stepover between rows where the setup gives none, mm.
pub fn default_stepover(tool: &Tool) -> f64 {
    STEPOVER_RADII * tool.radius()
}

/// Upper limit of the step along a row, mm: what insert width and stick-out permit and the `step` of the
/// setup, and for wall rows the step S ≤ 2·√(2Rh − h²) that leaves the scallop height h.
pub fn step_limit(plunge: &PlungeSetup, tool: &Tool, wall_row: bool) -> f64 {
    let asked = plunge.step.unwrap_or_else(|| default_step(tool));
    let limit = max_step(tool).min(asked);
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
    plunge.stepover.unwrap_or_else(|| default_stepover(tool))
}

/// Distance of rows that are `gap` apart: perpendicular to the flow or to the axis, whichever is smaller, mm.
/// `None` where neither of these has a length.
pub fn row_distance(gap: Vector, flow: Vector, axis: Vector) -> Option<f64> {
    let across = |along: Vector| {
        let along = along.try_normalize(1e-9)?;
        Some((gap - along * gap.dot(&along)).norm())
    };
    [across(flow), across(axis)].into_iter().flatten().reduce(f64::min)
}

/// Maximum distance of neighbouring axes at the shroud without uncut stock between them, mm.
pub fn max_shroud_spacing(tool: &Tool) -> f64 {
    1.9 * tool.radius()
}
