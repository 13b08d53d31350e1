//! What is wrong with a program, in words: the same for plunges and flank curves.

use crate::geometry::Vector;
use crate::part::setup::Stock;
use crate::part::{Impeller, Setup, Tool};

/// By how much less than the safety distance a rapid may keep: rounding, mm.
const RAPID_TOLERANCE: f64 = 1e-3;
/// Tilt beyond the machine's limit that is put down to rounding, rad.
const TILT_TOLERANCE: f64 = 1e-6;

/// A fault of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Line of the program, 0 when there is none.
    pub line: usize,
    /// What is wrong.
    pub what: String,
}

impl Fault {
    pub(super) fn before_tool(line: usize) -> Self {
        Self { line, what: "cuts before any tool is loaded; add LOADTL and CUTTER before it".to_owned() }
    }

    pub(super) fn without_diameter(line: usize, tool: &Tool) -> Self {
        let what =
            format!("tool {} has the diameter {}; give CUTTER/ its diameter", tool.number, tool.diameter);
        Self { line, what }
    }
}

/// What is wrong with a cut `distance` mm from the finished hub, which may miss its allowance by `tolerance`.
pub(super) fn near_hub(distance: f64, stock: &Stock, tolerance: f64) -> Option<String> {
    let allowance = stock.hub_allowance;
    (distance < allowance - tolerance)
        .then(|| format!("comes {distance:.4} mm near the hub; the allowance is {allowance} mm"))
}

/// The same of the finished blades.
pub(super) fn near_blade(distance: f64, stock: &Stock, tolerance: f64) -> Option<String> {
    let allowance = stock.blade_allowance;
    (distance < allowance - tolerance)
        .then(|| format!("comes {distance:.4} mm near a blade; the allowance is {allowance} mm"))
}

/// What is wrong with a rapid `distance` mm from the blank.
pub(super) fn rapid_near_blank(distance: f64, stock: &Stock) -> Option<String> {
    let safety = stock.safety_distance;
    (distance < safety - RAPID_TOLERANCE).then(|| {
        format!("moves in rapid {distance:.3} mm from the blank; the safety distance is {safety} mm")
    })
}

/// What is wrong with a tool axis that the machine of `setup` does not reach.
pub(super) fn beyond_machine(part: &Impeller, setup: &Setup, axis: &Vector) -> Option<String> {
    let (limit, beyond) = (setup.machine.max_axis_tilt, setup.machine.beyond(part, axis));
    (beyond > TILT_TOLERANCE).then(|| {
        format!(
            "tilts the axis by {:.2}° from the part's; the machine reaches {:.2}°",
            (beyond + limit).to_degrees(),
            limit.to_degrees()
        )
    })
}
