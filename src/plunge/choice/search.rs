//! The cheapest choice of sections, by dynamic programming over their borders.
//!
//! Cutters are ordered large to small from the outlet inwards, as they cut. A section runs from station to
//! station, none crosses a joint, none is shorter than [`MIN_SECTION_S`]. Let `after[n][i][t]` be the minimum
//! cost of everything outside station i with n cutters used, t the last of them, and `ready[n][i][t]` the
//! same with t about to begin a section at i. Then:
//!
//! - `ready[n][i][t]` = minimum of `after[n−1][i][u]` + change from u to t over larger u; at a joint also
//!   `after[n][i][t]`, as the same cutter continues in a new section;
//! - `after[n][i][t]` = minimum of `ready[n][j][t]` + cost of t from j to i over the stations j outside i.

use super::estimate::{Cost, Estimator};
use crate::setup::Tool;

/// Maximum number of cutters of a choice.
pub const MAX_TOOLS: usize = 4;
/// Factor by which a choice with fewer cutters may take longer: a further cutter leaves a seam on the floor,
/// and has to save more time than the error of the estimate.
const WORTH_A_TOOL: f64 = 1.05;
/// Minimum length of a section, in s.
pub const MIN_SECTION_S: f64 = 0.04;

/// A section of a choice: index of its tool, stations at its outlet and its inlet end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolStretch {
    /// Index in the list of tools.
    pub tool: usize,
    /// Station at the outlet end.
    pub from: usize,
    /// Station at the inlet end.
    pub to: usize,
}

/// A choice with its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionChoice {
    /// Sections, outlet to inlet.
    pub stretches: Vec<ToolStretch>,
    /// Their cost.
    pub cost: Cost,
}

/// A cost with its back-pointer: the previous tool, or the station at which the section began.
#[derive(Clone, Copy, Debug)]
struct CostStep {
    cost: Cost,
    origin: usize,
}

/// Keeps the lower cost; of equal costs the first.
fn keep_cheaper(best: &mut Option<CostStep>, cost: Cost, origin: usize) {
    if best.is_none_or(|best| cost < best.cost) {
        *best = Some(CostStep { cost, origin });
    }
}

/// The best costs by number of cutters used so far, station and tool.
struct CostTable {
    tools: usize,
    stations: usize,
    steps: Vec<Option<CostStep>>,
}

impl CostTable {
    fn new(tools: usize, stations: usize) -> Self {
        Self { tools, stations, steps: vec![None; (MAX_TOOLS + 1) * stations * tools] }
    }

    fn index(&self, used: usize, station: usize, tool: usize) -> usize {
        (used * self.stations + station) * self.tools + tool
    }

    fn at(&self, used: usize, station: usize, tool: usize) -> Option<CostStep> {
        self.steps[self.index(used, station, tool)]
    }

    fn at_mut(&mut self, used: usize, station: usize, tool: usize) -> &mut Option<CostStep> {
        let index = self.index(used, station, tool);
        &mut self.steps[index]
    }
}

/// Whether a section may run between these stations.
pub fn is_section(estimator: &Estimator, from: usize, to: usize) -> bool {
    let survey = estimator.survey;
    let crosses = survey.joints.iter().any(|&joint| to < joint && joint < from);
    !crosses && survey.stations[from].s - survey.stations[to].s >= MIN_SECTION_S - 1e-9
}

/// The cheapest choice from `tools` (large to small) among those whose stretches are all `allowed`, with as
/// few tools as [`worthwhile`] finds. `None` when there is no such choice.
pub fn cheapest(
    estimator: &Estimator,
    tools: &[&Tool],
    allowed: impl Fn(ToolStretch) -> bool,
) -> Option<SectionChoice> {
    let stations = estimator.survey.stations.len();
    let rim = stations - 1;
    let mut ready = CostTable::new(tools.len(), stations);
    let mut after = CostTable::new(tools.len(), stations);
    for from in (0..stations).rev() {
        for (t, &tool) in tools.iter().enumerate() {
            for used in 1..=MAX_TOOLS {
                *ready.at_mut(used, from, t) = begin_section(estimator, tools, &after, (used, from, t));
            }
            if (1..=MAX_TOOLS).all(|used| ready.at(used, from, t).is_none()) {
                continue;
            }
            for (to, cost) in (0..from).rev().zip(estimator.inwards(tool, from)) {
                if !is_section(estimator, from, to) || !allowed(ToolStretch { tool: t, from, to }) {
                    continue;
                }
                for used in 1..=MAX_TOOLS {
                    if let Some(step) = ready.at(used, from, t) {
                        keep_cheaper(after.at_mut(used, to, t), step.cost.and(cost), from);
                    }
                }
            }
        }
    }
    let ends = (1..=MAX_TOOLS).map(|used| {
        let ends = (0..tools.len()).filter_map(|t| Some((after.at(used, 0, t)?.cost, t)));
        ends.reduce(|best, end| if end.0 < best.0 { end } else { best })
    });
    let ends: Vec<Option<(Cost, usize)>> = ends.collect();
    let costs: Vec<Option<Cost>> = ends.iter().map(|end| end.map(|(cost, _)| cost)).collect();
    let mut used = worthwhile(&costs)? + 1;
    let (cost, mut tool) = ends[used - 1]?;
    let mut stretches = Vec::new();
    let mut to = 0;
    while to < rim {
        let from = after.at(used, to, tool)?.origin;
        stretches.push(ToolStretch { tool, from, to });
        let before = ready.at(used, from, tool)?.origin;
        if before != tool {
            used -= 1;
        }
        (to, tool) = (from, before);
    }
    stretches.reverse();
    Some(SectionChoice { stretches, cost })
}

/// Index into `costs`, the minimum costs with one cutter, two, and so on: the first that breaks the rules no
/// more than the best and takes hardly longer. `None` without any cost.
pub fn worthwhile(costs: &[Option<Cost>]) -> Option<usize> {
    let best = costs.iter().flatten().copied().reduce(|a, b| if b < a { b } else { a })?;
    let most = Cost { seconds: WORTH_A_TOOL * best.seconds, ..best };
    costs.iter().position(|cost| cost.is_some_and(|cost| cost <= most))
}

/// Entry of `ready` at (number of cutters used, station, tool).
fn begin_section(
    estimator: &Estimator,
    tools: &[&Tool],
    after: &CostTable,
    (used, from, t): (usize, usize, usize),
) -> Option<CostStep> {
    let tool = tools[t];
    let mut best = None;
    if from + 1 == estimator.survey.stations.len() {
        if used == 1 {
            keep_cheaper(&mut best, estimator.beginning(tool, from, None), t);
        }
        return best;
    }
    if estimator.survey.joints.contains(&from)
        && let Some(step) = after.at(used, from, t)
    {
        keep_cheaper(&mut best, step.cost.and(estimator.beginning(tool, from, Some(tool))), t);
    }
    for before in (0..t).filter(|&before| tools[before].diameter > tool.diameter) {
        if let Some(step) = after.at(used - 1, from, before) {
            let begun = estimator.beginning(tool, from, Some(tools[before]));
            keep_cheaper(&mut best, step.cost.and(begun), before);
        }
    }
    best
}
