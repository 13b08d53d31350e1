//! More plunges where a section's rows left the most: between positions, between rows, and under walls that lean
//! over the channel.
//!
//! From a pool of axes, finer than the rows and free to lean from the wall's axis to upright, the one that takes
//! most is added, again and again. Each is free of contact after the rows alone, so that they may be cut in any order.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::candidate::CandidateMaker;
use super::floor::Floor;
use crate::monitor::Cancelled;
use crate::part::{Blank, Tool};
use crate::plunge::contact::{Column, ContactSearch};
use crate::plunge::row::{RowMaker, Station};

/// Feed tilts tried: from, apart, degrees, and how many.
const TILT_FROM_DEG: f64 = -9.0;
const TILT_STEP_DEG: f64 = 3.0;
const TILTS: usize = 10;
/// Least gain of a plunge, as the thickness of a layer under the whole of its bottom, in cutter radii.
const LEAST_GAIN_RADII: f64 = 0.004;
/// Most a plunge may stop short, in cutter radii.
const MOST_LIFT_RADII: f64 = 0.3;
/// Lift kept above what the search saw, mm.
const LIFT_MARGIN: f64 = 0.01;

/// A plunge that might be added.
#[derive(Clone, Copy, Debug)]
struct Extra {
    /// What it takes, mm³, when it was last looked at.
    gain: f64,
    /// Place in the pool: of two that gain the same, the first.
    index: usize,
    /// Index of its row.
    row: usize,
    station: Station,
    lift: f64,
    /// Whether blades and contact were looked at.
    checked: bool,
}

impl PartialEq for Extra {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Extra {}

impl PartialOrd for Extra {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Extra {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then(other.index.cmp(&self.index))
    }
}

/// What is needed to look for more plunges on a stretch.
pub struct ExtraSearch<'a> {
    /// Rows of the pool, by λ.
    pub rows: Vec<CandidateMaker<'a>>,
    /// Places along each.
    pub places: Vec<f64>,
    pub tool: &'a Tool,
    pub blank: &'a Blank,
}

impl ExtraSearch<'_> {
    /// Up to `most` stations by rows of the pool, each row in cutting order. `floor` is as the plunges of `columns`
    /// left it, and afterwards as all do.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn stations(
        &self,
        floor: &mut Floor,
        columns: &[Column],
        most: usize,
    ) -> Result<Vec<Vec<Station>>, Cancelled> {
        let mut found: Vec<Vec<(f64, Station)>> = vec![Vec::new(); self.rows.len()];
        let Some(first) = self.rows.first() else { return Ok(Vec::new()) };
        let (part, monitor, inward) = (first.maker.part, first.maker.monitor, first.maker.inward);
        let radius = self.tool.radius();
        let least = LEAST_GAIN_RADII * radius * std::f64::consts::PI * radius * radius;
        let mut heap = BinaryHeap::from(self.pool(floor, least));
        let mut search = ContactSearch::default();
        let mut count = 0;
        while let Some(mut extra) = heap.pop() {
            monitor.check()?;
            if extra.gain < least || count >= most {
                break;
            }
            let row = &self.rows[extra.row];
            let column = |extra: &Extra| row.column(&extra.station).lifted(extra.lift);
            let gain = floor.gain(part, &column(&extra).cutter);
            if gain < 0.999 * extra.gain {
                // What was added since has taken part of it.
                extra.gain = gain;
                heap.push(extra);
                continue;
            }
            if !extra.checked {
                let Some(station) = row.maker.exact(&extra.station).filter(|s| row.allowed(s)) else {
                    continue;
                };
                extra.station = station;
                let depth = search.depth(&column(&extra), columns.iter(), self.blank, f64::INFINITY);
                if depth > MOST_LIFT_RADII * radius {
                    continue;
                }
                extra.lift = if depth > 0.0 { depth + LIFT_MARGIN } else { 0.0 };
                extra.checked = true;
                extra.gain = floor.gain(part, &column(&extra).cutter);
                heap.push(extra);
                continue;
            }
            floor.cut(part, &column(&extra));
            found[extra.row].push((-extra.station.ends.s_hub * inward, extra.station));
            count += 1;
        }
        let in_order = |mut row: Vec<(f64, Station)>| {
            row.sort_by(|a, b| a.0.total_cmp(&b.0));
            row.into_iter().map(|(_, station)| station).collect()
        };
        Ok(found.into_iter().map(in_order).collect())
    }

    /// All that gains more than `least`, blades and contact not looked at.
    fn pool(&self, floor: &Floor, least: f64) -> Vec<Extra> {
        let feet: Vec<(usize, f64)> =
            (0..self.rows.len()).flat_map(|row| self.places.iter().map(move |&s| (row, s))).collect();
        let mut pool: Vec<Extra> = feet
            .par_iter()
            .flat_map_iter(|&(row, s)| {
                let candidates = &self.rows[row];
                let maker: &RowMaker = candidates.maker;
                let gain = |station: &Station| floor.gain(maker.part, &maker.cutter(station));
                let tilts = (0..TILTS).map(|j| (TILT_FROM_DEG + TILT_STEP_DEG * j as f64).to_radians());
                let worth = !maker.monitor.is_cancelled()
                    && maker.lane.isoparametric(maker.lambda, s).is_some_and(|ends| {
                        let (tip, axis) = maker.lane.line(&ends);
                        floor.at_most(maker.part, &maker.tool.placed(tip, axis)) > least
                    });
                let fan = if worth { candidates.fan(s, tilts) } else { Vec::new() };
                let extra = move |station: Station| Extra {
                    gain: gain(&station),
                    index: 0,
                    row,
                    station,
                    lift: 0.0,
                    checked: false,
                };
                fan.into_iter().map(extra).filter(move |extra| extra.gain > least)
            })
            .collect();
        for (index, extra) in pool.iter_mut().enumerate() {
            extra.index = index;
        }
        pool
    }
}
