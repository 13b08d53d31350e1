//! Rest milling: smaller cutters for the stock that the sections leave beside leaning walls.
//!
//! The flat bottom of a cutter that is inclined with its wall leaves a wedge on the hub, about 2R·tan(tilt
//! angle) high. Only a smaller cutter makes it thinner.

use super::ChosenSection;
use super::fit::{Rules, ToolFit};
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

/// As [`rest_threshold`], for the rest-milling section that follows section `index`; `None` where none does.
///
/// # Errors
/// When the tool of the rest-milling section is missing.
pub fn rest_threshold_after(setup: &Setup, index: usize) -> Result<Option<f64>, SetupFault> {
    let sections = &setup.plunge.sections;
    let this = &sections[index];
    let overlaps = |other: &&SectionSetup| {
        other.kind == SectionKind::Rest && other.to < this.from && this.to < other.from
    };
    let rest = sections[index + 1..].iter().find(overlaps);
    rest.map(|rest| tool_of(setup, rest.tool).map(rest_threshold)).transpose()
}

/// Rest-milling sections after `sections`, large cutters first. Each uses the largest of `tools` (large to
/// small) that is small enough and fits; neighbours with the same tool are merged.
pub fn rest_sections(
    sections: &[SectionSetup],
    tools: &[&Tool],
    survey: &Survey,
    rules: &Rules,
) -> Vec<ChosenSection> {
    let mut rest: Vec<(&Tool, ChosenSection)> = Vec::new();
    for section in sections {
        let Some(main) = tools.iter().find(|tool| tool.number == section.tool) else { continue };
        let fits = |tool: &&&Tool| {
            let covered = survey.covered(section.from, section.to);
            tool.diameter <= MAX_DIAMETER_SHARE * main.diameter
                && covered.into_iter().all(|i| rules.fit(tool, &survey.stations[i]) == ToolFit::Good)
        };
        let Some(tool) = tools.iter().find(fits) else { continue };
        if let Some((_, last)) = rest.last_mut()
            && last.section.tool == tool.number
            && last.section.to == section.from
        {
            last.section.to = section.to;
            continue;
        }
        let section =
            SectionSetup { tool: tool.number, cut_direction: None, kind: SectionKind::Rest, ..*section };
        let thick = rest_threshold(tool);
        let reason = format!(
            "rest milling: what D {} leaves thicker than {thick:.2} mm above the allowance, as beside \
             leaning walls; only with `minimal`; `rest = false` in [plunge] disables it",
            main.diameter
        );
        rest.push((*tool, ChosenSection { section, reason }));
    }
    rest.sort_by(|a, b| b.0.diameter.total_cmp(&a.0.diameter));
    rest.into_iter().map(|(_, chosen)| chosen).collect()
}
