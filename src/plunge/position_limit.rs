//! The largest plan.

use super::spacing::{default_step, default_stepover, step_limit};
use crate::error::ErrorCode;
use crate::setup::{PlungeSetup, SetupFault, SetupPlace, Tool};

/// Maximum number of positions in the plan of one channel. Planning half as many takes about a gigabyte.
pub const MAX_POSITIONS: usize = 200_000;

/// The fault of a plan with about `positions` positions, at the key that is finest in relation to its
/// default.
pub(super) fn too_many_positions(
    positions: f64,
    plunge: &PlungeSetup,
    tool: &Tool,
    place: SetupPlace,
) -> SetupFault {
    let asked = [
        (plunge.step, default_step(tool), "step"),
        (plunge.stepover, default_stepover(tool), "stepover"),
        (Some(step_limit(plunge, tool, true)), step_limit(plunge, tool, false), "wall_scallop"),
    ];
    let finest = asked
        .into_iter()
        .filter_map(|(value, usual, key)| Some((value? / usual, key)))
        .filter(|(share, _)| *share < 0.4)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let (help, place) = match finest {
        Some((_, key)) => (format!("give a greater `{key}`"), SetupPlace::Plunge(key)),
        None => (format!("use a larger cutter or wider inserts than those of tool {}", tool.number), place),
    };
    let count = if positions < 1e6 { format!("about {positions:.0}") } else { "over a million".to_owned() };
    let what = format!("the plan would have {count} positions; the limit is {MAX_POSITIONS}");
    SetupFault::new(ErrorCode::TooManyPositions, what, help).at(place)
}
