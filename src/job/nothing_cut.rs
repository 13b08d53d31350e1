//! What is said where no plunge of a plan cuts anything.

use crate::error::ErrorCode;
use crate::part::Impeller;
use crate::plunge::{DropReason, PlungePlan};
use crate::setup::{Setup, SetupFault};

/// Factor by which an axis may be longer than the channel is high, as it leans (30°).
const LEAN_LENGTH: f64 = 1.155;

/// The overhang that frees every position which some overhang frees, mm.
fn longest_asked_for(plan: &PlungePlan) -> Option<f64> {
    plan.dropped.iter().filter_map(|dropped| dropped.stick_out).reduce(f64::max)
}

/// An overhang with which a tool reaches the hub from above the shroud, in whole mm; `None` where the blank
/// stands higher than that.
fn overhang_for(setup: &Setup, part: &Impeller) -> Option<f64> {
    if setup.allowances.blank_of(part).outline().is_some() {
        return None;
    }
    let height = |i: u32| {
        let s = f64::from(i) / 40.0;
        part.hub.point(s).distance(part.shroud.point(s))
    };
    let deepest = (0..=40).map(height).fold(0.0, f64::max);
    Some((LEAN_LENGTH * deepest + setup.allowances.safety_distance).ceil())
}

/// The fault of a plan that cuts nothing, by the reason for which most of its positions are dropped.
pub(super) fn nothing_cut(plan: &PlungePlan, setup: &Setup, part: &Impeller) -> SetupFault {
    let count = |why: DropReason| plan.dropped.iter().filter(|dropped| dropped.why == why).count();
    let most = DropReason::ALL.into_iter().max_by_key(|&why| (count(why), why == DropReason::Blades));
    match most {
        Some(DropReason::Contact) => SetupFault::new(
            ErrorCode::CoreContact,
            "the core of every plunge would meet stock before it has cut a fifth of its depth",
            "begin a section at the outlet (from = 1), give a cutter with wider inserts, or plan with \
             axis = \"staircase\"",
        ),
        Some(DropReason::Overhang) => SetupFault::new(
            ErrorCode::OverhangTooShort,
            "no tool reaches down to the hub: each is shorter below its holder than its plunges are deep",
            match longest_asked_for(plan).or_else(|| overhang_for(setup, part)) {
                Some(overhang) => format!("give an overhang of {overhang} mm"),
                None => "give more overhang, or open the blank first".to_owned(),
            },
        ),
        Some(DropReason::Shank) => SetupFault::new(
            ErrorCode::AssemblyCollides,
            "the shank of every plunge would come too near to part or blank",
            "give a thinner shank, or a smaller [clearance] shank",
        ),
        Some(DropReason::Holder) => {
            let help = match longest_asked_for(plan) {
                Some(overhang) => format!("give an overhang of {overhang} mm, or a thinner holder"),
                None => "give a thinner holder, or allow more tilt".to_owned(),
            };
            SetupFault::new(
                ErrorCode::AssemblyCollides,
                "the holder of every plunge would come too near to part or blank",
                help,
            )
        }
        _ => {
            let tilt = setup.machine.max_axis_tilt_rad.to_degrees();
            SetupFault::new(
                ErrorCode::NoFreeAxis,
                format!("no plunge has an axis that blades, tilt limits and the machine ({tilt:.0}°) allow"),
                "allow more tilt, or use smaller cutters",
            )
        }
    }
}
