//! Order and cutting direction of chosen sections.
//!
//! Sections are cut from the outlet inwards, each from its outlet end, so that every one begins beside floor
//! that is already cut. Where strongly wrapped blades lean along the rows, no axis may lean towards the
//! inlet, and every core would land in the step of the plunge before it; such sections are cut from the open
//! inlet outwards instead, the innermost one first. Where both kinds are in one channel, the sections cut
//! from either end meet. Where a plan shows that its rows starve for another reason, the channel is cut from
//! both ends up to an s at which they meet, or all of it from the inlet ([`from_both_ends`]).

use super::choice::search::MIN_SECTION_S;
use super::minimal::{LeadBlockage, lead_blockage};
use super::opening_section::plan_context;
use super::row_density::RowDensity;
use super::sections::Resolved;
use crate::part::Workpiece;
use crate::setup::{CutDirection, SectionKind, SectionSetup};

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
    let context = plan_context(workpiece, &resolved.setup, RowDensity::Dense);
    // A section whose tool is missing is reported when it is planned.
    let blockages: Option<Vec<LeadBlockage>> =
        rows.iter().map(|&i| lead_blockage(&context, i).ok()).collect();
    let from_outlet = blockages.map_or(rows.len(), |blockages| sections_from_outlet(&blockages));
    cut_from_inlet(&mut resolved, rows.get(from_outlet..).unwrap_or_default(), NO_LEAN);
    resolved
}

/// `resolved` with its chosen sections of rows cut from both ends of the channel, for a plan whose rows
/// starve: those outside `s` from the outlet inwards, those inside from the inlet outwards, the innermost
/// first. Of several outside, that at `s` is the last of all: between floor that is cut on both sides more of
/// its cores are free. The section across `s` is divided there, unless less than [`MIN_SECTION_S`] would
/// remain on one side. If s is 1, all are cut from the inlet, if it is 0 from the outlet. Returns `None` if
/// this is the order of `resolved`, or if there is a single section (it tries both directions anyway).
pub fn from_both_ends(resolved: &Resolved, s: f64) -> Option<Resolved> {
    let mut arranged = from_outlet(resolved);
    let rows = chosen_rows(&arranged);
    let (&first, &last) = rows.first().zip(rows.last())?;
    let Resolved { setup, reasons } = &mut arranged;
    let sections = &mut setup.plunge.sections;
    let is_across = |section: &SectionSetup| {
        section.from - s >= MIN_SECTION_S - 1e-9 && s - section.to >= MIN_SECTION_S - 1e-9
    };
    let mut rows = first..last + 1;
    if let Some(across) = rows.clone().find(|&index| is_across(&sections[index])) {
        let inner = SectionSetup { from: s, ..sections[across].clone() };
        sections[across].to = s;
        sections.insert(across + 1, inner);
        reasons.insert(across + 1, reasons[across].clone());
        rows.end += 1;
    }
    if rows.len() < 2 {
        return None;
    }
    let is_outside = |section: &SectionSetup| 0.5 * (section.from + section.to) > s;
    let outer = sections[rows.clone()].iter().take_while(|section| is_outside(section)).count();
    let (outer, inner) = (rows.start..rows.start + outer, rows.start + outer..rows.end);
    if !inner.is_empty() {
        for index in outer.clone() {
            sections[index].cut_direction = Some(CutDirection::OutletToInlet);
        }
        cut_from_inlet(&mut arranged, &inner.clone().collect::<Vec<_>>(), STARVED);
        if outer.len() > 1 {
            let Resolved { setup, reasons } = &mut arranged;
            setup.plunge.sections[outer.end - 1..inner.end].rotate_left(1);
            reasons[outer.end - 1..inner.end].rotate_left(1);
        }
    }
    (arranged.setup.plunge.sections != resolved.setup.plunge.sections).then_some(arranged)
}

/// `resolved` with its chosen sections of rows as they were chosen: from the outlet inwards, without a
/// direction. They stand one after the other.
fn from_outlet(resolved: &Resolved) -> Resolved {
    let mut resolved = resolved.clone();
    let rows = chosen_rows(&resolved);
    let Resolved { setup, reasons } = &mut resolved;
    let mut chosen: Vec<(SectionSetup, Option<String>)> = rows
        .iter()
        .map(|&index| {
            let section = SectionSetup { cut_direction: None, ..setup.plunge.sections[index].clone() };
            (section, reasons[index].as_deref().map(without_direction))
        })
        .collect();
    chosen.sort_by(|(a, _), (b, _)| b.from.total_cmp(&a.from));
    for (index, (section, reason)) in rows.into_iter().zip(chosen) {
        setup.plunge.sections[index] = section;
        reasons[index] = reason;
    }
    resolved
}

/// A reason without what [`cut_from_inlet`] adds to it.
fn without_direction(reason: &str) -> String {
    let added = [NO_LEAN, STARVED].into_iter().find_map(|why| reason.strip_suffix(why)?.strip_suffix("; "));
    added.unwrap_or(reason).to_owned()
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
    use crate::setup::Setup;

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

    /// Chosen sections from the outlet inwards, as (tool, from, to).
    fn chosen(sections: &[(u32, f64, f64)]) -> Resolved {
        let mut setup = Setup::default();
        let kind = SectionKind::Rows;
        let section = |&(tool, from, to)| SectionSetup { tool, from, to, cut_direction: None, kind };
        setup.plunge.sections = sections.iter().map(section).collect();
        Resolved { setup, reasons: vec![Some("chosen".to_owned()); sections.len()] }
    }

    #[test]
    fn the_last_section_from_the_outlet_waits_for_those_from_the_inlet() {
        let three = chosen(&[(1, 1.0, 0.6), (2, 0.6, 0.4), (2, 0.4, 0.0)]);
        let met = from_both_ends(&three, 0.4).expect("another order");
        let expected = [(1, 1.0, 0.6, FROM_OUTLET), (2, 0.4, 0.0, FROM_INLET), (2, 0.6, 0.4, FROM_OUTLET)];
        assert_eq!(order(&met), expected, "between floor that is cut on both sides");
        assert_eq!(
            met.reasons.iter().map(|reason| reason.as_ref().map(String::len)).collect::<Vec<_>>(),
            [Some("chosen".len()), Some("chosen".len() + "; ".len() + STARVED.len()), Some("chosen".len()),]
        );
        assert_eq!(from_both_ends(&met, 0.4), None, "the order that it has");
    }

    /// Tool, ends and direction of the sections.
    fn order(resolved: &Resolved) -> Vec<(u32, f64, f64, Option<CutDirection>)> {
        let sections = resolved.setup.plunge.sections.iter();
        sections.map(|section| (section.tool, section.from, section.to, section.cut_direction)).collect()
    }

    const FROM_OUTLET: Option<CutDirection> = Some(CutDirection::OutletToInlet);
    const FROM_INLET: Option<CutDirection> = Some(CutDirection::InletToOutlet);

    #[test]
    fn the_section_where_rows_from_both_ends_meet_is_divided() {
        let one = from_both_ends(&chosen(&[(1, 1.0, 0.0)]), 0.6).expect("another order");
        assert_eq!(order(&one), [(1, 1.0, 0.6, FROM_OUTLET), (1, 0.6, 0.0, FROM_INLET)]);
        assert_eq!(one.reasons.len(), 2);
        let two = from_both_ends(&chosen(&[(1, 1.0, 0.5), (2, 0.5, 0.0)]), 0.7).expect("another order");
        let expected = [(1, 1.0, 0.7, FROM_OUTLET), (2, 0.5, 0.0, FROM_INLET), (1, 0.7, 0.5, FROM_INLET)];
        assert_eq!(order(&two), expected, "the innermost one first");
    }

    #[test]
    fn no_sliver_of_a_section_is_left() {
        let two = chosen(&[(1, 1.0, 0.5), (2, 0.5, 0.0)]);
        let at_border = from_both_ends(&two, 0.52).expect("another order");
        assert_eq!(order(&at_border), [(1, 1.0, 0.5, FROM_OUTLET), (2, 0.5, 0.0, FROM_INLET)]);
        let all = from_both_ends(&two, 1.0).expect("another order");
        assert_eq!(order(&all), [(2, 0.5, 0.0, FROM_INLET), (1, 1.0, 0.5, FROM_INLET)]);
    }

    #[test]
    fn a_single_section_stays_as_it_is() {
        let one = chosen(&[(1, 1.0, 0.0)]);
        assert_eq!(from_both_ends(&one, 1.0), None, "it tries both directions by itself");
        assert_eq!(from_both_ends(&one, 0.0), None);
    }

    #[test]
    fn sections_that_are_cut_from_the_inlet_are_turned_to_the_outlet_too() {
        let two = chosen(&[(1, 1.0, 0.5), (2, 0.5, 0.0)]);
        let mut inwards = two.clone();
        cut_from_inlet(&mut inwards, &[0, 1], NO_LEAN);
        assert_eq!(order(&inwards), [(2, 0.5, 0.0, FROM_INLET), (1, 1.0, 0.5, FROM_INLET)]);
        assert_eq!(from_both_ends(&inwards, 0.0), Some(two), "as they were chosen, reasons too");
        assert_eq!(from_both_ends(&inwards, 1.0), None, "the order that it has");
        let both = from_both_ends(&inwards, 0.5).expect("another order");
        assert_eq!(order(&both), [(1, 1.0, 0.5, FROM_OUTLET), (2, 0.5, 0.0, FROM_INLET)]);
    }

    #[test]
    fn sections_of_the_setup_stay_where_they_are() {
        let mut given = chosen(&[(1, 1.0, 0.5), (2, 0.5, 0.0)]);
        given.setup.plunge.sections[1].cut_direction = FROM_INLET;
        given.reasons = vec![None; 2];
        assert_eq!(from_both_ends(&given, 0.7), None);
    }
}
