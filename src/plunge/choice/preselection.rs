//! Which tools of a large library the choice looks at: its time grows with the square of their number, and a
//! library of a maker has thousands.
//!
//! A library of up to `ALL_TOOLS` is used whole. From a larger one, tools wider than the channel or much
//! thinner than necessary are removed. If more than `ALL_TOOLS` remain, three are taken for each station and
//! each of the `DIAMETER_SHARES`, among the tools of at most that diameter that are long enough: the two with
//! the highest removal rate, and the one with the slimmest holder.

use super::fit::{Rules, TILT_ROOM};
use crate::plunge::spacing::{step_limit, stepover};
use crate::plunge::survey::Survey;
use crate::setup::{PlungeSetup, Tool};

/// Largest number of tools that is used whole.
const ALL_TOOLS: usize = 100;
/// Maximum diameters for which tools are taken, as shares of the largest one that can tilt at a station.
/// Between twisted walls that one itself does not fit.
const DIAMETER_SHARES: [f64; 4] = [1.0, 0.85, 0.7, 0.5];
/// Diameter below which a tool is not considered, in widths of the narrowest passage.
const MIN_SHARE: f64 = 0.15;

/// The tools that a choice for plunges has to look at, in the order given: cylindrical ones with a flat
/// bottom, where there are such, and not too many.
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
    let range = (MIN_SHARE * narrowest).min(thinnest.max(widest))..=thinnest.max(widest);
    let fitting: Vec<&Tool> = list.iter().copied().filter(|tool| range.contains(&tool.diameter)).collect();
    if fitting.len() <= ALL_TOOLS {
        // Not all of them may be too thin.
        return if fitting.is_empty() { list[..ALL_TOOLS].to_vec() } else { fitting };
    }
    let removal: Vec<f64> = fitting
        .iter()
        .map(|tool| tool.plunge_feed * step_limit(plunge, tool, false) * stepover(plunge, tool))
        .collect();
    let mut taken = vec![false; fitting.len()];
    for station in &survey.stations {
        // Largest diameter of a cutter that can tilt, mm.
        let can_tilt = rules.free_width(station.narrowest).min(widest) / TILT_ROOM;
        let needed = rules.overhang(station);
        for share in DIAMETER_SHARES {
            let good = |index: &usize| {
                fitting[*index].diameter <= share * can_tilt && fitting[*index].overhang >= needed
            };
            let good: Vec<usize> = (0..fitting.len()).filter(good).collect();
            let fastest = good.iter().copied().max_by(|&a, &b| removal[a].total_cmp(&removal[b]));
            let second = good
                .iter()
                .copied()
                .filter(|index| Some(*index) != fastest)
                .max_by(|&a, &b| removal[a].total_cmp(&removal[b]));
            let slimmest = good.iter().copied().min_by(|&a, &b| {
                let holders = fitting[a].holder_diameter().total_cmp(&fitting[b].holder_diameter());
                holders.then(removal[b].total_cmp(&removal[a]))
            });
            // Where none fits well the thinnest of those that are long enough, and the longest.
            let all = || (0..fitting.len()).filter(|_| fastest.is_none());
            let long = all().filter(|&index| fitting[index].overhang >= needed);
            let thinnest = long.min_by(|&a, &b| fitting[a].diameter.total_cmp(&fitting[b].diameter));
            let longest = all().max_by(|&a, &b| fitting[a].overhang.total_cmp(&fitting[b].overhang));
            for index in [fastest, second, slimmest, thinnest, longest].into_iter().flatten() {
                taken[index] = true;
            }
        }
    }
    fitting.into_iter().zip(taken).filter(|(_, is_taken)| *is_taken).map(|(tool, _)| tool).collect()
}
