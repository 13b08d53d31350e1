//! In which direction the walls let a section be cut: which lead angles they leave free.
//!
//! Along a row the core of each plunge lands in the step of the previous one unless the axes lean towards the
//! side that is still uncut ([`super`]). Blades that lean along the row may leave no such axis in one cutting
//! direction and many in the other.

use rayon::prelude::*;

use super::CandidateMaker;
use super::rows::candidate_maker;
use crate::cutting::contact::BlankTop;
use crate::monitor::Monitor;
use crate::plunge::context::PlanContext;
use crate::plunge::error::PlanError;
use crate::plunge::row::RowMaker;
use crate::plunge::row_places::row_maker;
use crate::plunge::section_layout::StretchLayout;
use crate::setup::CutDirection;

/// Positions along a stretch that are looked at.
const STATIONS: usize = 9;
/// Lead angles that are tried, the smallest first, degrees.
const LEADS_DEG: [f64; 9] = [0.0, 2.0, 4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 40.0];
/// Tilt angles that are tried, as shares from the row's own tilt angle (0) to zero tilt (1).
const TILT_SHARES: [f64; 2] = [0.0, 0.7];

/// Of [`STATIONS`], those at the inlet end at which rows that are cut from there begin.
const STATIONS_AT_INLET: usize = 3;

/// Length of floor of a section on which some axis is free, and the part of it on which none of them leans
/// towards the uncut side, by the direction in which the section is cut: in s, summed over rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::plunge) struct LeadBlockage {
    /// When cut from the outlet to the inlet.
    pub inward: f64,
    /// When cut from the inlet to the outlet.
    pub outward: f64,
    /// On which some axis is free at all.
    pub open: f64,
    /// Whether the tool is too short for most of the axes with which rows would begin at the inlet end.
    pub too_short_at_inlet: bool,
}

/// Whether there is an axis that leans towards the uncut side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lean {
    Free,
    /// Only one for which the tool is too short.
    TooShort,
    Blocked,
}

/// The blockage of section `index`.
///
/// # Errors
/// When the tool of the section is missing.
pub(in crate::plunge) fn lead_blockage(
    context: &PlanContext,
    index: usize,
) -> Result<LeadBlockage, PlanError> {
    let tool = context.tool_of_section(index)?;
    let top = BlankTop::new(&context.workpiece.blank);
    let monitor = &Monitor::default();
    let mut sum = LeadBlockage::default();
    let mut at_inlet: Vec<Lean> = Vec::new();
    for layout in context.layouts(index)? {
        let rows = layout.rows.len();
        let across: Vec<f64> = [0, rows / 2, rows.saturating_sub(1)]
            .into_iter()
            .filter_map(|row| Some(layout.rows.get(row)?.lambda))
            .collect();
        let StretchLayout { stretch, .. } = layout;
        let weight = (stretch.from - stretch.to).abs() / STATIONS as f64 / across.len().max(1) as f64
            * (stretch.lambdas.1 - stretch.lambdas.0).abs();
        // From the inlet end on.
        let places: Vec<(f64, f64)> = (0..STATIONS)
            .map(|i| stretch.s_at(1.0 - (i as f64 + 0.5) / STATIONS as f64))
            .flat_map(|s| across.iter().map(move |&lambda| (lambda, s)))
            .collect();
        let leans: Vec<[Lean; 2]> = places
            .into_par_iter()
            .map(|(lambda, s)| {
                [CutDirection::OutletToInlet, CutDirection::InletToOutlet].map(|direction| {
                    let maker = row_maker(context, layout, tool, (lambda, rows), direction, monitor);
                    lean_at(&candidate_maker(context, &maker, &top), &maker, s)
                })
            })
            .collect();
        if stretch.to <= context.section(index).to {
            at_inlet.extend(leans[..STATIONS_AT_INLET * across.len()].iter().map(|[_, outward]| outward));
        }
        for at in leans {
            let [inward, outward] = at.map(|lean| lean == Lean::Free);
            sum.inward += if !inward && outward { weight } else { 0.0 };
            sum.outward += if inward && !outward { weight } else { 0.0 };
            sum.open += if inward || outward { weight } else { 0.0 };
        }
    }
    let count = |wanted: Lean| at_inlet.iter().filter(|lean| **lean == wanted).count();
    Ok(LeadBlockage { too_short_at_inlet: count(Lean::TooShort) > count(Lean::Free), ..sum })
}

/// The axes at `s` that lean towards the uncut side.
fn lean_at(candidates: &CandidateMaker, maker: &RowMaker, s: f64) -> Lean {
    let leads = LEADS_DEG.iter().map(|lead| lead.to_radians());
    let leans = |lead: f64| lead * maker.direction_sign >= -0.5f64.to_radians();
    let fan = candidates.axis_fan(s, leads, &TILT_SHARES);
    let mut lean = Lean::Blocked;
    for station in &fan {
        if leans(station.alpha_rad) && candidates.is_allowed(station) {
            if candidates.is_long_enough(station) {
                return Lean::Free;
            }
            lean = Lean::TooShort;
        }
    }
    lean
}
