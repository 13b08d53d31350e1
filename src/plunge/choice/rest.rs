//! Smaller cutters for what the sections leave beside leaning walls.
//!
//! The flat bottom of a cutter that leans with its wall leaves a wedge on the hub, about 2R·tan(lean) high, whatever its
//! axis. Only a smaller cutter makes it thinner.

use super::Chosen;
use super::fit::{Fit, Rules};
use crate::part::setup::SectionSetup;
use crate::part::{Setup, Tool};
use crate::plunge::sections::{SetupFault, tool_of};
use crate::plunge::survey::Survey;

/// Largest cutter for the rest, in diameters of the one whose rest it cuts.
const LARGEST: f64 = 0.6;
/// Layer above the allowance from which on it is worth a plunge of the cutter for the rest, in its radii.
const THICK_RADII: f64 = 0.25;

/// Layer above the allowance from which on it is worth a plunge of `tool`, which cuts the rest, mm.
pub fn thick(tool: &Tool) -> f64 {
    THICK_RADII * tool.radius()
}

/// The same for the cutter that cuts the rest of section `index`; `None` where none does.
///
/// # Errors
/// When that cutter is missing.
pub fn thick_after(setup: &Setup, index: usize) -> Result<Option<f64>, SetupFault> {
    let sections = &setup.plunge.sections;
    let this = &sections[index];
    let overlaps = |other: &&SectionSetup| other.rest && other.to < this.from && this.to < other.from;
    let rest = sections[index + 1..].iter().find(overlaps);
    rest.map(|rest| tool_of(setup, rest.tool).map(thick)).transpose()
}

/// Sections that cut the rest of `sections` with `tools`, large to small: for each the largest that is small enough and has
/// room and length. One where neighbours get the same.
pub fn rest_of(sections: &[SectionSetup], tools: &[&Tool], survey: &Survey, rules: &Rules) -> Vec<Chosen> {
    let mut rest: Vec<(&Tool, Chosen)> = Vec::new();
    for section in sections {
        let Some(main) = tools.iter().find(|tool| tool.number == section.tool) else { continue };
        let fits = |tool: &&&Tool| {
            let covered = survey.covered(section.from, section.to);
            tool.diameter <= LARGEST * main.diameter
                && covered.into_iter().all(|i| rules.fit(tool, &survey.stations[i]) == Fit::Good)
        };
        let Some(tool) = tools.iter().find(fits) else { continue };
        if let Some((_, last)) = rest.last_mut()
            && last.section.tool == tool.number
            && last.section.to == section.from
        {
            last.section.to = section.to;
            continue;
        }
        let section = SectionSetup { tool: tool.number, feed: None, rest: true, ..*section };
        let thick = thick(tool);
        let reason = format!(
            "cuts what D {} leaves thicker than {thick:.2} mm above the allowance, as beside leaning walls; by `minimal` \
             alone; `rest = false` in [plunge] leaves it out",
            main.diameter
        );
        rest.push((*tool, Chosen { section, reason }));
    }
    rest.sort_by(|a, b| b.0.diameter.total_cmp(&a.0.diameter));
    rest.into_iter().map(|(_, chosen)| chosen).collect()
}
