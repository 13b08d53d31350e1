//! The tool for what stands above the shroud: the fastest that is long enough.

use super::chosen::ChosenSection;
use super::times::{MoveTimes, PlungeMoves};
use crate::part::Impeller;
use crate::plunge::opening::{Opening, OpeningRow};
use crate::setup::{SectionKind, SectionSetup, Setup, Tool};

/// Height of the stock above the shroud from which on a section of its own removes it, as a share of the
/// greatest distance between hub and shroud: the plunges of the channel cut through less than that.
const MIN_HEIGHT_SHARE: f64 = 0.25;
/// Smallest and largest diameter that is considered, in diameters of the largest cutter of the channel.
const MIN_DIAMETERS: f64 = 0.99;
const MAX_DIAMETERS: f64 = 4.0;
/// Places along the channel at which its height is measured.
const PLACES: u32 = 20;

/// A section for what stands above the shroud in the blank of `setup`, with one of `tools`, before a channel
/// whose largest cutter is `largest`, and whose first tool has the number `first`; `None` where
/// nothing, or too little for a section, stands there. `times` tells how long moves take.
pub fn choose_opening(
    setup: &Setup,
    tools: &[Tool],
    part: &Impeller,
    largest: &Tool,
    first: Option<u32>,
    times: MoveTimes,
) -> Option<ChosenSection> {
    let blank = setup.allowances.blank_of(part);
    blank.outline()?;
    let opening = Opening::new(part, &blank, setup);
    let height = |i: u32| {
        let s = f64::from(i) / f64::from(PLACES);
        part.hub.point(s).distance(part.shroud.point(s))
    };
    let channel_height = (0..=PLACES).map(height).fold(0.0, f64::max);
    if deepest(&opening.rows(largest)) < MIN_HEIGHT_SHARE * channel_height {
        return None;
    }
    let is_considered = |tool: &&Tool| {
        let share = tool.diameter / largest.diameter;
        (MIN_DIAMETERS..=MAX_DIAMETERS).contains(&share)
    };
    let estimates = tools.iter().filter(is_considered).map(|tool| {
        let rows = opening.rows(tool);
        let needed = deepest(&rows) + setup.allowances.safety_distance;
        let lacking = (needed - tool.overhang).max(0.0);
        let change = if first == Some(tool.number) { 0.0 } else { times.tool_change_s() };
        (lacking, change + seconds(&rows, tool, setup.allowances.safety_distance, times), needed, tool)
    });
    let (lacking, _, needed, tool) =
        estimates.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
    let mut reason = format!(
        "what stands up to {:.0} mm above the shroud, by plunges along the axis of rotation",
        needed - setup.allowances.safety_distance
    );
    reason += &match lacking > 0.0 {
        true => format!("; the longest tool, {:.0} mm, but {needed:.0} mm are needed", tool.overhang),
        false => "; the fastest tool that is long enough".to_owned(),
    };
    let section = SectionSetup {
        tool: tool.number,
        from: 1.0,
        to: 0.0,
        cut_direction: None,
        kind: SectionKind::Opening,
    };
    Some(ChosenSection { section, reason, places: 0.0, misfits: 0 })
}

/// Greatest height of stock above a tip, mm.
fn deepest(rows: &[OpeningRow]) -> f64 {
    rows.iter().flat_map(|row| &row.depths).copied().fold(0.0, f64::max)
}

/// Time of the rows of one pitch, s; links between them are left out.
fn seconds(rows: &[OpeningRow], tool: &Tool, safety: f64, times: MoveTimes) -> f64 {
    let depths = rows.iter().flat_map(|row| &row.depths);
    let plunge = |depth: &f64| PlungeMoves { length: depth + safety, ..PlungeMoves::default() };
    depths.map(|depth| times.plunge_s(tool, &plunge(depth))).sum()
}
