//! Automatic choice of sections: which tools are used, and where each takes over from the previous one.
//!
//! Among all choices of one to four cutters, large to small from the outlet inwards, the one with the
//! shortest estimated time is taken. The sections cover the whole floor from the rim to the leading edge;
//! where no cutter keeps the rules of [`fit`], the choice that breaks them at the fewest stations is taken.
//!
//! | question | file |
//! |---|---|
//! | when does a cutter fit | [`fit`] |
//! | how much time does it take | [`estimate`], [`times`] |
//! | which choice is the cheapest | [`search`] |
//! | why was it chosen (text) | `reason` |
//! | the tool for what stands above the shroud | `opening` |
//! | rest milling beside leaning walls | [`rest`] |
//! | which of very many tools are looked at | [`preselection`] |

mod chosen;
pub mod estimate;
pub mod fit;
mod opening;
pub mod preselection;
mod reason;
pub mod rest;
pub mod search;
pub mod times;

use crate::plunge::survey::Survey;
use crate::setup::{AllowanceSetup, SectionKind, SectionSetup, Setup, Tool};
pub use chosen::ChosenSection;
use estimate::Estimator;
use fit::Rules;
pub use opening::choose_opening;
use reason::Reasons;
use rest::rest_sections;
use search::cheapest;
use times::MoveTimes;

/// Chooses sections for `tools` in the channel of `survey`. Cutters with a diameter above `limit` (mm) are
/// ignored if there are others. Empty without tools. `times` tells how long moves take.
pub fn choose(
    tools: &[Tool],
    limit: Option<f64>,
    survey: &Survey,
    setup: &Setup,
    times: MoveTimes,
) -> Vec<ChosenSection> {
    let candidates = candidates(tools, limit);
    let estimator = Estimator::new(survey, setup, &candidates, times);
    let Some(found) = cheapest(&estimator, &candidates, |_| true) else { return Vec::new() };
    let reasons = Reasons { estimator: &estimator, candidates: &candidates, limit, found: &found };
    let sections = found.stretches.iter().enumerate().map(|(index, stretch)| ChosenSection {
        section: SectionSetup {
            tool: candidates[stretch.tool].number,
            from: survey.stations[stretch.from].s,
            to: survey.stations[stretch.to].s,
            cut_direction: None,
            kind: SectionKind::Rows,
        },
        reason: reasons.tell_section(index),
        places: estimator.places(candidates[stretch.tool], stretch.from, stretch.to),
        misfits: estimator.stretch(candidates[stretch.tool], stretch.from, stretch.to).misfits,
    });
    sections.collect()
}

/// Chooses rest-milling sections after `sections` with cutters from `tools`.
pub fn choose_rest(
    sections: &[SectionSetup],
    tools: &[Tool],
    survey: &Survey,
    stock: &AllowanceSetup,
) -> Vec<ChosenSection> {
    rest_sections(sections, &candidates(tools, None), survey, &Rules::new(stock))
}

/// The tools to choose from: large to small, for equal diameters the shorter first, without duplicates, none
/// above the limit unless all are.
fn candidates(tools: &[Tool], limit: Option<f64>) -> Vec<&Tool> {
    let mut order: Vec<&Tool> = tools.iter().collect();
    order.sort_by(|a, b| {
        b.diameter
            .total_cmp(&a.diameter)
            .then(a.overhang.total_cmp(&b.overhang))
            .then(a.number.cmp(&b.number))
    });
    order.dedup_by(|a, b| Tool { number: b.number, ..a.with_given_rates() } == b.with_given_rates());
    if let (Some(limit), Some(smallest)) = (limit, order.last().map(|tool| tool.diameter)) {
        order.retain(|tool| tool.diameter <= limit.max(smallest));
    }
    order
}

#[cfg(test)]
mod tests;
