//! Sections chosen by themselves: which cutters work, and where each takes over from the one before.
//!
//! Among all choices of one to four cutters, large to small from the outlet inwards, the one that is estimated to take
//! the least time. No floor is left out: the sections follow each other from the rim to the leading edge, and
//! where no cutter keeps the rules of [`fit`] the choice that breaks them at the fewest stations is taken.
//!
//! | question | file |
//! |---|---|
//! | when a cutter fits | [`fit`] |
//! | how long a cutter takes | [`estimate`] |
//! | which choice is the cheapest | [`search`] |
//! | why this one, in words | `reason` |
//! | what they leave beside leaning walls | [`rest`] |

pub mod estimate;
pub mod fit;
mod reason;
pub mod rest;
pub mod search;

use crate::part::setup::{SectionSetup, Stock};
use crate::part::{Setup, Tool};
use crate::plunge::survey::Survey;
use estimate::Estimator;
use fit::Rules;
use reason::Reasons;
use rest::rest_of;
use search::cheapest;

/// A section that was chosen, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// The section; its feed is left open.
    pub section: SectionSetup,
    /// One line.
    pub reason: String,
}

/// Chooses sections for `tools` in the channel that was surveyed. With `limit`, cutters of a greater diameter, mm, are
/// left aside as long as there are others. Empty without tools.
pub fn choose(tools: &[Tool], limit: Option<f64>, survey: &Survey, setup: &Setup) -> Vec<Chosen> {
    let estimator = Estimator { survey, plunge: &setup.plunge, rules: Rules::new(&setup.stock) };
    let candidates = candidates(tools, limit);
    let Some(found) = cheapest(&estimator, &candidates, |_| true) else { return Vec::new() };
    let reasons = Reasons { estimator: &estimator, candidates: &candidates, limit, found: &found };
    let sections = found.stretches.iter().enumerate().map(|(index, stretch)| Chosen {
        section: SectionSetup {
            tool: candidates[stretch.tool].number,
            from: survey.stations[stretch.from].s,
            to: survey.stations[stretch.to].s,
            feed: None,
            rest: false,
        },
        reason: reasons.of(index),
    });
    sections.collect()
}

/// Chooses from `tools` the sections that cut the rest of `sections`.
pub fn choose_rest(sections: &[SectionSetup], tools: &[Tool], survey: &Survey, stock: &Stock) -> Vec<Chosen> {
    rest_of(sections, &candidates(tools, None), survey, &Rules::new(stock))
}

/// The tools to choose from: large to small, of one size the shorter first, none twice, none above the limit unless
/// all are.
fn candidates(tools: &[Tool], limit: Option<f64>) -> Vec<&Tool> {
    let mut order: Vec<&Tool> = tools.iter().collect();
    order.sort_by(|a, b| {
        b.diameter
            .total_cmp(&a.diameter)
            .then(a.overhang.total_cmp(&b.overhang))
            .then(a.number.cmp(&b.number))
    });
    order.dedup_by(|a, b| Tool { number: b.number, ..a.clone() } == **b);
    if let (Some(limit), Some(smallest)) = (limit, order.last().map(|tool| tool.diameter)) {
        order.retain(|tool| tool.diameter <= limit.max(smallest));
    }
    order
}

#[cfg(test)]
mod tests;
