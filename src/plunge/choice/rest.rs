//! Rest milling: smaller cutters for the stock that the sections leave beside leaning walls.
//!
//! The flat bottom of a cutter that is inclined with its wall leaves a wedge on the hub, about 2R·tan(tilt
//! angle) high. Only a smaller cutter makes it thinner.

use super::chosen::ChosenSection;
use super::fit::{Rules, ToolFit};
use super::search::MIN_SECTION_S;
use crate::plunge::survey::Survey;
use crate::setup::{SectionKind, SectionSetup, Setup, SetupFault, Tool, tool_of};

/// Maximum diameter for rest milling, in diameters of the previous cutter.
const MAX_DIAMETER_SHARE: f64 = 0.6;
/// Layer above the allowance from which on rest milling is worthwhile, in radii of its cutter.
const THICK_RADII: f64 = 0.25;

/// Layer above the allowance from which on rest milling with `tool` is worthwhile, mm.
pub fn rest_threshold(tool: &Tool) -> f64 {
    THICK_RADII * tool.radius()
}

/// Stretches of a section, each from s to s, from the outlet inwards.
type RestStretches = Vec<(f64, f64)>;

/// As [`rest_threshold`], for the rest-milling section after section `index` that covers all of it; `None`
/// where none does.
///
/// # Errors
/// When the tool of the rest-milling section is missing.
pub fn rest_threshold_after(setup: &Setup, index: usize) -> Result<Option<f64>, SetupFault> {
    let sections = &setup.plunge.sections;
    let this = &sections[index];
    let covers = |other: &&SectionSetup| {
        other.kind == SectionKind::Rest && other.to <= this.to && this.from <= other.from
    };
    let rest = sections[index + 1..].iter().find(covers);
    rest.map(|rest| tool_of(setup, rest.tool).map(rest_threshold)).transpose()
}

/// Rest-milling sections after `sections`, large cutters first. Each uses the largest of `tools` (large to
/// small) that is small enough and fits everywhere in its section; where none does, the one that fits along
/// most of it, in the stretches where it does. Neighbours with the same tool are merged.
pub fn rest_sections(
    sections: &[SectionSetup],
    tools: &[&Tool],
    survey: &Survey,
    rules: &Rules,
) -> Vec<ChosenSection> {
    let mut rest: Vec<(&Tool, ChosenSection)> = Vec::new();
    for section in sections {
        let Some(main) = tools.iter().find(|tool| tool.number == section.tool) else { continue };
        let Some((tool, stretches)) = rest_tool(section, main, tools, survey, rules) else { continue };
        for (from, to) in stretches {
            if let Some((_, last)) = rest.last_mut()
                && last.section.tool == tool.number
                && last.section.to == from
            {
                last.section.to = to;
                continue;
            }
            let kind = SectionKind::Rest;
            let section = SectionSetup { tool: tool.number, from, to, cut_direction: None, kind };
            let thick = rest_threshold(tool);
            let reason = format!(
                "rest milling: what D {} leaves thicker than {thick:.2} mm above the allowance, as beside \
                 leaning walls; only with `minimal`; `rest = false` in [plunge] disables it",
                main.diameter
            );
            rest.push((tool, ChosenSection { section, reason, places: 0.0, misfits: 0 }));
        }
    }
    rest.sort_by(|a, b| b.0.diameter.total_cmp(&a.0.diameter));
    rest.into_iter().map(|(_, chosen)| chosen).collect()
}

/// The tool for the rest of `section`, whose own is `main`, and the stretches from s to s in which it fits,
/// from the outlet inwards; `None` where none of `tools` is small enough and fits somewhere.
fn rest_tool<'t>(
    section: &SectionSetup,
    main: &Tool,
    tools: &[&'t Tool],
    survey: &Survey,
    rules: &Rules,
) -> Option<(&'t Tool, RestStretches)> {
    let whole = section.from - section.to;
    let mut best: Option<(f64, &Tool, RestStretches)> = None;
    for tool in tools.iter().filter(|tool| tool.diameter <= MAX_DIAMETER_SHARE * main.diameter) {
        let stretches = fitting_stretches(section, tool, survey, rules);
        let length: f64 = stretches.iter().map(|(from, to)| from - to).sum();
        if length > best.as_ref().map_or(0.0, |(most, ..)| *most) {
            best = Some((length, tool, stretches));
        }
        if length >= whole {
            break;
        }
    }
    best.map(|(_, tool, stretches)| (tool, stretches))
}

/// The stretches of `section`, from s to s, from the outlet inwards, at whose stations `tool` fits; without
/// those shorter than a section may be, unless that is all of it.
fn fitting_stretches(section: &SectionSetup, tool: &Tool, survey: &Survey, rules: &Rules) -> RestStretches {
    let covered = survey.covered(section.from, section.to).rev();
    let fits: Vec<(f64, bool)> = covered
        .map(|i| &survey.stations[i])
        .map(|station| (station.s.clamp(section.to, section.from), rules.fit(tool, station) == ToolFit::Good))
        .collect();
    if fits.iter().all(|(_, fits)| *fits) {
        return vec![(section.from, section.to)];
    }
    let mut stretches = RestStretches::new();
    for run in fits.chunk_by(|(_, a), (_, b)| a == b) {
        if let ([(from, true), ..], [.., (to, _)]) = (run, run) {
            stretches.push((*from, *to));
        }
    }
    stretches.retain(|(from, to)| from - to >= MIN_SECTION_S);
    stretches
}
