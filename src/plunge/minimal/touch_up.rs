//! What `minimal` adds to the rows of a section: single plunges where they left the most.

use super::section::SCALE_RADII;
use super::{CandidateMaker, ExtraSearch, Floor};
use crate::monitor::Monitor;
use crate::plunge::contact::BlankTop;
use crate::plunge::cycle::{CutRow, PlanError, Planner, SectionCut};
use crate::plunge::ground::Ground;
use crate::plunge::plan::Stopped;
use crate::plunge::row::RowMaker;
use crate::plunge::sections::{MAX_POSITIONS, tool_of};

/// Rounds in which more plunges are looked for, each beside all those before, by what a plunge has to take, in least
/// gains: what takes most comes first, as it frees others.
const ROUNDS: [f64; 3] = [4.0, 2.0, 1.0];
/// How far apart they are tried along the channel, in step limits, and into how many parts they divide the way between
/// two rows at most.
const STEP_SHARE: f64 = 0.5;
/// See [`STEP_SHARE`].
const PARTS: usize = 4;
/// At most so many for each plunge of the rows.
const MOST_SHARE: usize = 2;
/// Plans of so many positions get no more: the rest of the limit is for what the setup asks for.
const MOST_POSITIONS: usize = MAX_POSITIONS / 2;
/// They are tried no nearer to each other than this, in cutter radii.
const NEAREST_RADII: f64 = 0.12;

impl Planner<'_> {
    /// Adds plunges where the rows of a section left the most, up to [`MOST_SHARE`] times as many as there are.
    pub(super) fn add_extras(
        &self,
        index: usize,
        grounds: &[Ground],
        cut: &mut SectionCut,
        monitor: &Monitor,
    ) -> Result<(), PlanError> {
        if monitor.is_stopped() {
            cut.added = Some((0, Stopped::Cancelled));
            return Ok(());
        }
        // Those that were found are cut.
        let closing = &monitor.closing();
        let stock = &self.setup.stock;
        let tool = tool_of(self.setup, self.setup.plunge.sections[index].tool)?;
        let top = BlankTop::new(&self.blank);
        let scale = SCALE_RADII * tool.radius();
        let allowances = (stock.hub_allowance, stock.blade_allowance);
        let planned: usize = cut.rows.iter().map(|row| row.len()).sum();
        let room = MOST_POSITIONS.saturating_sub(cut.columns.len());
        let most = room.min(MOST_SHARE * planned);
        let (mut added_in_all, mut stopped) = (0, Stopped::NothingWorthwhile);
        for ground in grounds.iter().take_while(|_| !monitor.is_stopped()) {
            let mut floor = Floor::new(self.part, &ground.stretch, tool, allowances, scale);
            for column in cut.columns.as_slice() {
                floor.cut(self.part, &column.cutter);
            }
            let rows = self.with_rows_beside_walls(&ground.lane, &ground.stretch, tool, &ground.rows);
            let nearest = NEAREST_RADII * tool.radius();
            let width = (0..=8)
                .filter_map(|i| ground.lane.width(ground.stretch.s_at(f64::from(i) / 8.0)))
                .fold(0.0, |widest: f64, (hub, _)| widest.max(hub));
            let lambdas = between_rows(&rows, nearest / width.max(1e-6));
            let maker =
                |&lambda: &f64| self.row_maker(ground, tool, (lambda, lambdas.len()), cut.feed, monitor);
            let makers: Vec<RowMaker> = lambdas.iter().map(maker).collect();
            let Some(first) = makers.first() else { continue };
            let (start, end) = self.row_ends(index, &ground.stretch, cut.feed.inward());
            let step = (STEP_SHARE * first.step_limit).max(nearest) / self.part.hub.length();
            let count = ((end - start).abs() / step).ceil().clamp(1.0, 4000.0) as usize;
            let places: Vec<f64> =
                (0..=count).map(|i| start + (end - start) * i as f64 / count as f64).collect();
            let candidates: Vec<CandidateMaker> =
                makers.iter().map(|maker| self.candidate_maker(maker, &top)).collect();
            let mut search = ExtraSearch::new(&candidates, &places, floor, &self.blank);
            let mut budget = most / grounds.len();
            for times in ROUNDS {
                let rows = search.stations(&cut.columns, budget, times)?;
                budget -= rows.iter().map(Vec::len).sum::<usize>();
                let before = cut.rows.len();
                for (stations, &lambda) in rows.into_iter().zip(&lambdas) {
                    self.cut_split(stations, ground.stretch.lambda_in_channel(lambda), tool, cut, closing)?;
                }
                // Nothing is missing where one of these has no place after all.
                let added: Vec<CutRow> = cut.rows.drain(before..).collect();
                let added = added.into_iter().map(CutRow::without_dropped).filter(|row| row.len() > 0);
                for row in added {
                    added_in_all += row.len();
                    cut.rows.push(row);
                }
            }
            if budget == 0 && planned > 0 {
                stopped = if room < MOST_SHARE * planned { Stopped::PlanFull } else { Stopped::ShareReached };
            }
        }
        if monitor.is_stopped() {
            stopped = Stopped::Cancelled;
        }
        cut.added = Some((added_in_all, stopped));
        Ok(())
    }
}

/// The λ of `rows` and of more between them, no nearer to each other than `nearest`.
fn between_rows(rows: &[f64], nearest: f64) -> Vec<f64> {
    let mut lambdas = rows.to_vec();
    for pair in rows.windows(2) {
        let parts = (((pair[1] - pair[0]) / nearest) as usize).clamp(1, PARTS);
        lambdas.extend((1..parts).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64));
    }
    lambdas.sort_by(f64::total_cmp);
    lambdas
}
