//! What is said where no plunge of a plan cuts anything.

use crate::error::ErrorCode;
use crate::plunge::{DropReason, PlungePlan};
use crate::setup::{Setup, SetupFault};

/// The fault of a plan that cuts nothing, by the reason for which most of its positions are dropped.
pub(super) fn nothing_cut(plan: &PlungePlan, setup: &Setup) -> SetupFault {
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
            "give more overhang",
        ),
        Some(DropReason::Shank) => SetupFault::new(
            ErrorCode::AssemblyCollides,
            "the shank of every plunge would come too near to part or blank",
            "give a thinner shank, or a smaller [clearance] shank",
        ),
        Some(DropReason::Holder) => {
            let least = plan.dropped.iter().filter_map(|d| d.stick_out).reduce(f64::max);
            let help = match least {
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
