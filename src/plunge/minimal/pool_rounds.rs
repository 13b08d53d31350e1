//! What the searches for added plunges share: the feet of their pool, and how a round of it is cut.

use rayon::prelude::*;

use super::ExtraSearch;
use super::rows::cut_split;
use super::visit_order::{PlungePlace, short_path};
use crate::monitor::Monitor;
use crate::plunge::context::PlanContext;
use crate::plunge::cut::SectionCut;
use crate::plunge::error::PlanError;
use crate::plunge::row::Station;
use crate::plunge::section_layout::PassageStretch;
use crate::setup::Tool;

/// Maximum number of feet along a row of the pool.
const MAX_FEET: f64 = 4000.0;

/// Feet of a pool, as row and s: on each of `rows` rows from one end to the other, `step` apart in s at most,
/// those that are wanted.
pub(super) fn feet_along(
    rows: usize,
    (start, end): (f64, f64),
    step: f64,
    is_wanted: impl Fn(usize, f64) -> bool + Sync,
) -> Vec<(usize, f64)> {
    let count = ((end - start).abs() / step).ceil().clamp(1.0, MAX_FEET) as usize;
    let s_at = |i: usize| start + (end - start) * i as f64 / count as f64;
    (0..rows)
        .into_par_iter()
        .flat_map_iter(|row| (0..=count).map(move |i| (row, s_at(i))))
        .filter(|&(row, s)| is_wanted(row, s))
        .collect()
}

/// A pool that is cut in rounds: its rows, by λ of the stretch, and how many plunges may still be added.
pub(super) struct PoolRounds<'p, 's> {
    pub context: &'p PlanContext<'p>,
    pub stretch: &'p PassageStretch<'p>,
    pub tool: &'p Tool,
    pub lambdas: &'p [f64],
    pub search: ExtraSearch<'s>,
    pub budget: usize,
}

impl PoolRounds<'_, '_> {
    /// Adds to `cut` what is worth at least `times` the minimum gain. Found plunges are cut even after a
    /// stop. Returns how many were added.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn cut(&mut self, times: f64, cut: &mut SectionCut, monitor: &Monitor) -> Result<usize, PlanError> {
        let rows = self.search.stations(&cut.columns, self.budget, times)?;
        self.budget -= rows.iter().map(Vec::len).sum::<usize>();
        let before = cut.rows.len();
        let closing = &monitor.ignoring_stop();
        for (lambda, stations) in in_visit_order(rows, cut) {
            let lambda = self.stretch.lambda_in_channel(self.lambdas[lambda]);
            cut_split(self.context, stations, lambda, self.tool, cut, closing)?;
        }
        Ok(cut.drop_hindered_rows(before))
    }
}

/// The found plunges, by λ, in an order with short links after those of `cut`, in runs of the same λ (as
/// index): all of them are free of contact after the plunges before this round, so any order will do.
fn in_visit_order(rows: Vec<Vec<Station>>, cut: &SectionCut) -> Vec<(usize, Vec<Station>)> {
    let found: Vec<(usize, Station)> = rows
        .into_iter()
        .enumerate()
        .flat_map(|(lambda, stations)| stations.into_iter().map(move |station| (lambda, station)))
        .collect();
    let places: Vec<PlungePlace> = found.iter().map(|(_, station)| (station.tip, station.axis)).collect();
    let last = cut.columns.as_slice().last().map(|column| (column.cutter.tip, column.cutter.axis));
    let mut runs: Vec<(usize, Vec<Station>)> = Vec::new();
    for index in short_path(last.as_ref(), &places) {
        let (lambda, station) = found[index];
        match runs.last_mut() {
            Some((run, stations)) if *run == lambda => stations.push(station),
            _ => runs.push((lambda, vec![station])),
        }
    }
    runs
}
