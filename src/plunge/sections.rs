//! Sections: stretches of the channel with their tool, given by the setup or chosen automatically; checks of
//! the setup against the part.

use std::collections::HashSet;

use super::choice::fit::{Rules, cylinders};
use super::choice::preselection::preselect;
use super::choice::search::MIN_SECTION_S;
use super::choice::times::MoveTimes;
use super::choice::{ChosenSection, choose, choose_opening, choose_rest};
use super::position_limit::{MAX_POSITIONS, too_many_positions};
use super::spacing::{step_limit, stepover};
use super::survey::Survey;
use super::thoroughness::MANY_PLACES;
use crate::error::ErrorCode;
use crate::machine::MachineTool;
use crate::part::{Impeller, Workpiece};
use crate::setup::{
    PlungeChange, SectionKind, SectionSetup, Setup, SetupFault, SetupPlace, Tool, check_taper, round_down,
    tool_of,
};

/// Number of given tools up to which a plan keeps those that it does not use.
const MAX_KEPT_TOOLS: usize = 500;
/// Largest diameters, as shares of the free width at the outlet, with which three rows fit there, or two.
const SHARE_OF_THREE_ROWS: f64 = 0.65;
const SHARE_OF_TWO_ROWS: f64 = 0.85;
/// Share of the places up to which the larger cutter is worth the stock that it leaves.
const WORTH_TWO_ROWS: f64 = 0.7;
/// s from which on the channel counts as its outlet where the free width is measured.
const OUTLET_FROM_S: f64 = 0.7;
/// Largest diameter to choose from a library, in radii of the rim: a wider one bridges the curvature of the
/// hub.
const RIM_RADIUS_SHARE: f64 = 0.12;
/// The same, in depths of the outlet.
const OUTLET_DEPTHS: f64 = 2.0;
/// Largest hub allowance, as a share of the greatest height of the channel: with more, next to nothing is
/// left to plunge.
const MAX_ALLOWANCE_SHARE: f64 = 0.9;
/// Width that the smallest cutter needs to cut at all, in diameters.
const MIN_WIDTH_DIAMETERS: f64 = 1.25;

/// A setup with all defaults filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The setup, with tools and sections.
    pub setup: Setup,
    /// For each section why it was chosen; `None` where the setup defines it.
    pub reasons: Vec<Option<String>>,
}

/// Fills in tools and sections where the setup gives none: tools from `library`, which must not be empty,
/// sections by [`choose`], by their times on `machine` if it is known.
///
/// # Errors
/// When part and setup do not match, a section uses a missing tool, or the plan would be too large.
pub fn resolve(
    setup: &Setup,
    library: &[Tool],
    workpiece: &Workpiece,
    machine: Option<&MachineTool>,
) -> Result<Resolved, SetupFault> {
    let part = &workpiece.part;
    check_part(setup, part)?;
    check_hub_allowance(setup, part)?;
    let mut survey = Survey::from_workpiece(workpiece, MIN_SECTION_S);
    let given = !setup.tools.is_empty();
    let mut resolved = setup.clone();
    if !given {
        resolved.tools = setup.allowances.tools_for_material(library).into_owned();
    }
    let mut reasons = vec![None; setup.plunge.sections.len()];
    if setup.plunge.sections.is_empty() {
        let rules = Rules::new(&setup.allowances);
        survey.set_inaccessible_aside(|across| rules.any_reaches(&resolved.tools, across));
        let tools = preselect(&resolved.tools, &survey, &rules, &setup.plunge);
        survey.try_cylinders(workpiece, &setup.allowances, &cylinders(&tools));
        survey.try_assemblies(workpiece, setup, &tools);
        let times = MoveTimes::on(machine);
        let mut chosen = match given {
            true => choose(&tools, None, &survey, setup, times),
            false => choose_from_library(&tools, setup, part, &survey, times),
        };
        if setup.plunge.rest {
            let sections: Vec<SectionSetup> = chosen.iter().map(|chosen| chosen.section.clone()).collect();
            chosen.extend(choose_rest(&sections, &tools, &survey, &setup.allowances));
        }
        let first = chosen.first().map(|chosen| chosen.section.tool);
        let used = |tool: &&Tool| chosen.iter().any(|chosen| chosen.section.tool == tool.number);
        let largest = tools.iter().filter(used).max_by(|a, b| a.diameter.total_cmp(&b.diameter));
        let opening = largest.and_then(|largest| choose_opening(setup, &tools, part, largest, first, times));
        for chosen in opening.into_iter().chain(chosen) {
            resolved.plunge.sections.push(chosen.section);
            reasons.push(Some(chosen.reason));
        }
    }
    for (index, section) in resolved.plunge.sections.iter().enumerate() {
        let place = SetupPlace::Section { index, tool: section.tool };
        let tool = tool_of(&resolved, section.tool).map_err(|fault| fault.at(place))?;
        check_taper(tool)?;
    }
    if resolved.plunge.sections.is_empty() {
        // All that are given are tapered.
        resolved.tools.iter().try_for_each(check_taper)?;
    }
    check_blade_allowance(&resolved, &survey)?;
    check_some_fit(&resolved, &survey, library)?;
    if !given {
        resolved.tools = used_tools(&resolved);
    } else {
        keep_needed_tools(&mut resolved, None);
    }
    check_size(&resolved, part, &survey)?;
    Ok(Resolved { setup: resolved, reasons })
}

/// Leaves in a setup that has a whole library the tools that it names, in sections, edits, and for flank
/// passes, and that of number `more`.
pub fn keep_needed_tools(setup: &mut Setup, more: Option<u32>) {
    if setup.tools.len() <= MAX_KEPT_TOOLS {
        return;
    }
    let sections = setup.plunge.sections.iter().map(|section| section.tool);
    let locked = setup.plunge.edits.iter().filter_map(|edit| match edit.change {
        PlungeChange::Lock { tool, .. } => Some(tool),
        _ => None,
    });
    let needed: HashSet<u32> = sections.chain(locked).chain(setup.flank.tool).chain(more).collect();
    setup.tools.retain(|tool| needed.contains(&tool.number));
}

/// The tools that sections use, in cutting order.
fn used_tools(setup: &Setup) -> Vec<Tool> {
    let mut used: Vec<Tool> = Vec::new();
    for section in &setup.plunge.sections {
        if used.iter().all(|tool| tool.number != section.tool) {
            used.extend(tool_of(setup, section.tool).ok().cloned());
        }
    }
    used
}

/// The sections with tools of a library of all sizes. By the estimate of time alone, the largest cutter that
/// fits would be chosen, and it leaves the most stock on the floor. Therefore about three rows have to fit
/// side by side at the outlet. Two rows are enough where such a cutter needs very many places, and one where
/// only a larger cutter is long enough for the channel.
fn choose_from_library(
    tools: &[Tool],
    setup: &Setup,
    part: &Impeller,
    survey: &Survey,
    times: MoveTimes,
) -> Vec<ChosenSection> {
    let by_share = |share| {
        let limit = largest_diameter(share, setup, part, survey);
        let chosen = choose(tools, Some(limit), survey, setup, times);
        (chosen.iter().map(|chosen| chosen.places).sum::<f64>(), chosen)
    };
    let misfits = |chosen: &[ChosenSection]| chosen.iter().map(|chosen| chosen.misfits).sum::<u32>();
    let (places, mut best) = by_share(SHARE_OF_THREE_ROWS);
    if places > MANY_PLACES || misfits(&best) > 0 {
        let (places_of_two, chosen) = by_share(SHARE_OF_TWO_ROWS);
        let is_shorter = places > MANY_PLACES && places_of_two < WORTH_TWO_ROWS * places;
        if is_shorter || misfits(&chosen) < misfits(&best) {
            best = chosen;
        }
    }
    if misfits(&best) > 0 {
        let (_, chosen) = by_share(f64::INFINITY);
        if misfits(&chosen) < misfits(&best) {
            best = chosen;
        }
    }
    best
}

/// Largest diameter to choose from a library, mm: at most this `share` of the free width at the outlet. The
/// cutter also must not bridge the curvature of the hub, nor be much wider than the outlet is deep.
fn largest_diameter(share: f64, setup: &Setup, part: &Impeller, survey: &Survey) -> f64 {
    let outlet = survey.stations.iter().filter(|station| station.s >= OUTLET_FROM_S - 1e-9);
    let width = outlet.map(|station| station.narrowest).fold(f64::INFINITY, f64::min);
    let free_width = width - 2.0 * setup.allowances.blade_allowance;
    let depth = part.hub.point(1.0).distance(part.shroud.point(1.0));
    (share * free_width).min(RIM_RADIUS_SHARE * part.rim_radius()).min(OUTLET_DEPTHS * depth)
}

/// Checks that the setup is for this part.
///
/// # Errors
/// When the setup names another part.
pub fn check_part(setup: &Setup, part: &Impeller) -> Result<(), SetupFault> {
    match &setup.part {
        Some(name) if *name != part.name => Err(SetupFault::new(
            ErrorCode::WrongPart,
            format!("the setup is for part \"{name}\", not for \"{}\"", part.name),
            "give the setup of this part, or change its `part` key",
        )
        .at(SetupPlace::Part)),
        _ => setup.allowances.check_blank(part),
    }
}

fn check_hub_allowance(setup: &Setup, part: &Impeller) -> Result<(), SetupFault> {
    let height_at = |s: f64| part.hub.point(s).distance(part.shroud.point(s));
    let height = (0..=50).map(|i| height_at(f64::from(i) / 50.0)).fold(0.0, f64::max);
    if setup.allowances.hub_allowance < MAX_ALLOWANCE_SHARE * height {
        return Ok(());
    }
    Err(SetupFault::new(
        ErrorCode::HubAllowance,
        format!(
            "`hub_allowance` is {}, but hub and shroud are {height:.2} mm apart at most",
            setup.allowances.hub_allowance
        ),
        format!("give less than {:.2} mm", MAX_ALLOWANCE_SHARE * height),
    )
    .at(SetupPlace::Stock("hub_allowance")))
}

/// Errors when the plan would have more than [`MAX_POSITIONS`] positions by a low estimate.
fn check_size(setup: &Setup, part: &Impeller, survey: &Survey) -> Result<(), SetupFault> {
    let plunge = &setup.plunge;
    let mut total = 0.0;
    // The section in which the limit is exceeded.
    let mut beyond = None;
    for (index, section) in
        plunge.sections.iter().enumerate().filter(|(_, section)| section.kind == SectionKind::Rows)
    {
        let tool = tool_of(setup, section.tool)?;
        let length = (section.from - section.to) * part.hub.length().max(part.shroud.length());
        let width = survey.max_width(section.from, section.to);
        let free_width = (width - tool.diameter - 2.0 * setup.allowances.blade_allowance).max(0.0);
        let inner =
            (free_width / stepover(plunge, tool) - 1.0).max(0.0) * length / step_limit(plunge, tool, false);
        let walls = 2.0 * length / step_limit(plunge, tool, true);
        total += inner + walls;
        if total > MAX_POSITIONS as f64 {
            beyond.get_or_insert((tool, SetupPlace::Section { index, tool: section.tool }));
        }
    }
    beyond.map_or(Ok(()), |(tool, place)| Err(too_many_positions(total, plunge, tool, place)))
}

/// Errors when no cutter fits anywhere in the channel because of the blade allowance.
fn check_blade_allowance(setup: &Setup, survey: &Survey) -> Result<(), SetupFault> {
    let widest = survey.max_width(1.0, 0.0);
    let smallest = setup.tools.iter().map(|tool| tool.diameter).fold(f64::INFINITY, f64::min);
    let most = 0.5 * (widest - MIN_WIDTH_DIAMETERS * smallest);
    let allowance = setup.allowances.blade_allowance;
    if widest == 0.0 || allowance <= most || most <= 0.0 {
        return Ok(());
    }
    Err(SetupFault::new(
        ErrorCode::BladeAllowance,
        format!("`blade_allowance` is {allowance}, but the blades are {widest:.2} mm apart at most"),
        format!("give at most {:.2} mm, less to cut where they come closer", round_down(most, 2)),
    )
    .at(SetupPlace::Stock("blade_allowance")))
}

/// Errors when no section has a station that its cutter fits. Where a cutter fits in a part of its section,
/// that part is planned.
fn check_some_fit(setup: &Setup, survey: &Survey, library: &[Tool]) -> Result<(), SetupFault> {
    let allowance = setup.allowances.blade_allowance;
    let mut widest = None;
    let rows = |(_, section): &(usize, &SectionSetup)| section.kind != SectionKind::Opening;
    for (index, section) in setup.plunge.sections.iter().enumerate().filter(rows) {
        let tool = tool_of(setup, section.tool)?;
        let stations = &survey.stations[survey.covered(section.from, section.to)];
        let width = stations.iter().map(|station| station.narrowest).fold(0.0, f64::max);
        if width >= tool.diameter + 2.0 * allowance {
            return Ok(());
        }
        widest.get_or_insert((width, tool, SetupPlace::Section { index, tool: section.tool }));
    }
    let Some((width, tool, place)) = widest else { return Ok(()) };
    let free_width = width - 2.0 * allowance;
    let fitting = library.iter().map(|tool| tool.diameter).filter(|&d| d < free_width);
    let help = match fitting.max_by(f64::total_cmp) {
        Some(d) => format!("use a cutter of at most D {d}"),
        None => "lower the blade allowance".to_string(),
    };
    let what = format!(
        "tool {} (D {}) is wider than the channel: at most {width:.2} mm between the walls, {free_width:.2} mm \
         inside the allowances",
        tool.number, tool.diameter
    );
    Err(SetupFault::new(ErrorCode::CutterTooWide, what, help).at(place))
}
