//! Order and cutting direction of chosen sections.
//!
//! Sections are cut from the outlet inwards, each from its outlet end, so that every one begins beside floor
//! that is already cut. Where strongly wrapped blades lean along the rows, no axis may lean towards the
//! inlet, and every core would land in the step of the plunge before it; such sections are cut from the open
//! inlet outwards instead, the innermost one first. Where both kinds are in one channel, the sections cut
//! from either end meet. Where a plan shows that rows from the outlet starve for another
//! reason, all are cut from the inlet ([`all_from_inlet`]).

use super::context::PlanContext;
use super::minimal::{LeadBlockage, lead_blockage};
use super::row_density::RowDensity;
use super::sections::Resolved;
use crate::part::Workpiece;
use crate::setup::{CutDirection, SectionKind};

/// Share of the open floor that must gain an axis by it for sections to be cut from the inlet.
const WORTHWHILE_SHARE: f64 = 0.25;
/// Added to the reason of a section that is cut from the inlet: by its axes, or as a plan from the outlet
/// shows.
const NO_LEAN: &str = "cut from the inlet, as the blades let no axis lean that way in the other direction";
const STARVED: &str =
    "cut from the inlet, as rows from the outlet would find no free core and leave more uncut";

/// `resolved` with those of its chosen sections of rows cut from the inlet that have few free axes from the
/// outlet; sections given by the setup stay as they are.
pub fn arrange(workpiece: &Workpiece, mut resolved: Resolved) -> Resolved {
    let rows = chosen_rows(&resolved);
    if rows.len() < 2 {
        return resolved;
    }
    let context = PlanContext::new(workpiece, &resolved.setup, RowDensity::Dense);
    // A section whose tool is missing is reported when it is planned.
    let blockages: Option<Vec<LeadBlockage>> =
        rows.iter().map(|&i| lead_blockage(&context, i).ok()).collect();
    let from_outlet = blockages.map_or(rows.len(), |blockages| sections_from_outlet(&blockages));
    cut_from_inlet(&mut resolved, rows.get(from_outlet..).unwrap_or_default(), NO_LEAN);
    resolved
}

/// `resolved` with all of its chosen sections of rows cut from the inlet, the innermost first, for a plan
/// that starves from the outlet; `None` where there is one such section only, or some is cut from the inlet
/// already.
pub fn all_from_inlet(resolved: &Resolved) -> Option<Resolved> {
    let rows = chosen_rows(resolved);
    let is_open = |index: &usize| resolved.setup.plunge.sections[*index].cut_direction.is_none();
    if rows.len() < 2 || !rows.iter().all(is_open) {
        return None;
    }
    let mut turned = resolved.clone();
    cut_from_inlet(&mut turned, &rows, STARVED);
    Some(turned)
}

/// Indices of the chosen sections of rows.
fn chosen_rows(resolved: &Resolved) -> Vec<usize> {
    let sections = &resolved.setup.plunge.sections;
    let is_chosen_row =
        |index: &usize| sections[*index].kind == SectionKind::Rows && resolved.reasons[*index].is_some();
    (0..sections.len()).filter(is_chosen_row).collect()
}

/// Has the `inner` sections cut from the inlet, the last one first. Chosen sections of rows stand one after
/// the other, between the opening and rest milling.
fn cut_from_inlet(resolved: &mut Resolved, inner: &[usize], why: &str) {
    let (Some(&first), Some(&last)) = (inner.first(), inner.last()) else { return };
    let Resolved { setup, reasons } = resolved;
    setup.plunge.sections[first..=last].reverse();
    reasons[first..=last].reverse();
    for index in first..=last {
        setup.plunge.sections[index].cut_direction = Some(CutDirection::InletToOutlet);
        reasons[index] = reasons[index].as_ref().map(|reason| format!("{reason}; {why}"));
    }
}

/// How many of the sections, listed from the outlet inwards, are cut from the outlet: all of them, or as many
/// as leave the least floor without a free axis, if that is much less and the tool is long enough to
/// begin at the inlet.
fn sections_from_outlet(blockages: &[LeadBlockage]) -> usize {
    let all = blockages.len();
    if blockages.last().is_none_or(|innermost| innermost.too_short_at_inlet) {
        return all;
    }
    let blocked = |from_outlet: usize| -> f64 {
        let (outer, inner) = blockages.split_at(from_outlet);
        outer.iter().map(|b| b.inward).sum::<f64>() + inner.iter().map(|b| b.outward).sum::<f64>()
    };
    let open: f64 = blockages.iter().map(|b| b.open).sum();
    let best = (0..=all).rev().min_by(|&a, &b| blocked(a).total_cmp(&blocked(b))).unwrap_or(all);
    if blocked(all) - blocked(best) > WORTHWHILE_SHARE * open { best } else { all }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blockage(inward: f64, outward: f64) -> LeadBlockage {
        LeadBlockage { inward, outward, open: 0.3, too_short_at_inlet: false }
    }

    #[test]
    fn sections_that_only_open_towards_the_inlet_stay_as_they_are() {
        assert_eq!(sections_from_outlet(&[blockage(0.0, 0.2), blockage(0.0, 0.3), blockage(0.0, 0.0)]), 3);
    }

    #[test]
    fn sections_that_are_blocked_from_the_outlet_are_cut_from_the_inlet() {
        assert_eq!(sections_from_outlet(&[blockage(0.0, 0.2), blockage(0.2, 0.0), blockage(0.3, 0.0)]), 1);
        assert_eq!(sections_from_outlet(&[blockage(0.2, 0.0), blockage(0.2, 0.0)]), 0);
    }

    #[test]
    fn no_section_is_cut_from_an_inlet_that_is_too_deep_for_its_tool() {
        let deep = LeadBlockage { too_short_at_inlet: true, ..blockage(0.3, 0.0) };
        assert_eq!(sections_from_outlet(&[blockage(0.2, 0.0), deep]), 2);
    }

    #[test]
    fn a_small_gain_changes_nothing() {
        assert_eq!(sections_from_outlet(&[blockage(0.02, 0.0), blockage(0.02, 0.0)]), 2);
    }
}
