//! Which tools of a large library the choice looks at: its time grows with the square of their number, and a
//! library of a maker has thousands.
//!
//! Up to [`ALL_TOOLS`] every tool is looked at. Of more, those wider than the channel, and those much
//! thinner than need be, are left out; the others are put into classes of diameters. From each class come, for
//! each of [`REACHES`] of the overhangs that the channel asks for, the tool that removes most and the one
//! with the slimmest holder.

use super::fit::Rules;
use crate::plunge::spacing::{step_limit, stepover};
use crate::plunge::survey::Survey;
use crate::setup::{PlungeSetup, Tool};

/// Number of tools that are all looked at.
const ALL_TOOLS: usize = 100;
/// Classes of diameters between the least and the greatest that may be of use.
const CLASSES: usize = 20;
/// Shares of the stations whose overhang a tool of a class reaches.
const REACHES: [f64; 3] = [0.4, 0.75, 1.0];
/// Diameter below which a tool is of no use, in widths of the narrowest passage.
const LEAST_SHARE: f64 = 0.15;

/// The tools that a choice for plunges has to look at, in the order given: cylindrical ones with a flat bottom,
/// where there are such, and not too many.
pub fn preselect(tools: &[Tool], survey: &Survey, rules: &Rules, plunge: &PlungeSetup) -> Vec<Tool> {
    let suited = |tool: &&Tool| !tool.is_tapered() && tool.is_flat();
    let cylindrical = |tool: &&Tool| !tool.is_tapered();
    let mut list: Vec<&Tool> = tools.iter().filter(suited).collect();
    if list.is_empty() {
        list = tools.iter().filter(cylindrical).collect();
    }
    if list.len() > ALL_TOOLS {
        list = thinned(&list, survey, rules, plunge);
    }
    list.into_iter().cloned().collect()
}

fn thinned<'t>(list: &[&'t Tool], survey: &Survey, rules: &Rules, plunge: &PlungeSetup) -> Vec<&'t Tool> {
    let widths = survey.stations.iter().map(|station| rules.free_width(station.narrowest));
    let widths: Vec<f64> = widths.filter(|width| width.is_finite()).collect();
    let widest = widths.iter().copied().fold(0.0, f64::max);
    let narrowest = widths.iter().copied().fold(f64::INFINITY, f64::min);
    let thinnest = list.iter().map(|tool| tool.diameter).fold(f64::INFINITY, f64::min);
    let most = widest.max(thinnest);
    let fitting: Vec<&Tool> = list.iter().copied().filter(|tool| tool.diameter <= most).collect();
    let thickest = fitting.iter().map(|tool| tool.diameter).fold(0.0, f64::max);
    let least = (LEAST_SHARE * narrowest).min(thickest);
    let mut overhangs: Vec<f64> = survey.stations.iter().map(|station| rules.overhang(station)).collect();
    overhangs.sort_by(f64::total_cmp);
    let needed = REACHES.map(|share| {
        let last = overhangs.len().saturating_sub(1);
        overhangs.get((share * last as f64).round() as usize).copied().unwrap_or(0.0)
    });
    let mut classes: Vec<Vec<usize>> = vec![Vec::new(); CLASSES];
    let span = (thickest / least).ln().max(1e-9);
    for (index, tool) in fitting.iter().enumerate().filter(|(_, tool)| tool.diameter >= least) {
        let class = (CLASSES as f64 * (tool.diameter / least).ln() / span) as usize;
        classes[class.min(CLASSES - 1)].push(index);
    }
    let removal = |index: usize| {
        let tool = fitting[index];
        tool.plunge_feed * step_limit(plunge, tool, false) * stepover(plunge, tool)
    };
    let mut taken = vec![false; fitting.len()];
    for class in &classes {
        for reach in needed {
            let long = || class.iter().copied().filter(|&index| fitting[index].overhang >= reach);
            let fastest = long().max_by(|&a, &b| removal(a).total_cmp(&removal(b)));
            let slimmest = long().min_by(|&a, &b| {
                let holders = fitting[a].holder_diameter().total_cmp(&fitting[b].holder_diameter());
                holders.then(removal(b).total_cmp(&removal(a)))
            });
            // Where none is long enough the longest.
            let longest = class
                .iter()
                .copied()
                .max_by(|&a, &b| fitting[a].overhang.total_cmp(&fitting[b].overhang))
                .filter(|_| fastest.is_none());
            for index in [fastest, slimmest, longest].into_iter().flatten() {
                taken[index] = true;
            }
        }
    }
    fitting.into_iter().zip(taken).filter(|(_, is_taken)| *is_taken).map(|(tool, _)| tool).collect()
}
