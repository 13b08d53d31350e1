//! Clearance of the positions along a wall from the blades: from others by axes closer to that of the whole
//! wall, from the wall's own blade by a shift off it.

use rayon::prelude::*;

use super::fit::{AxisLine, FittedAxis};
use super::rays::{AxisRay, RaySweep};
use super::stations::MAX_STATION_TURN;
use super::strip::WallStrip;
use super::swept::MapColumn;
use super::{MIN_WALL_TOLERANCE, SAME_SIDE, WallFit, obstacles};
use crate::geometry::{CutterSolid, Point};

/// Shares of the way from the axis of the whole wall to that of the strip that are tried where another blade
/// is in the way of the latter.
const SHARES: [f64; 4] = [0.75, 0.5, 0.25, 0.0];
/// Greatest shift off the own blade, as a share of the reach; a position that lacks more is blocked.
const MAX_OWN_SHIFT: f64 = 0.1;
/// Maximum number of shifts off the own blade.
const OWN_SHIFTS: usize = 6;
/// Where between two stations the clearance is measured, and the overcut there that is left beyond the
/// tolerance, mm.
const BETWEEN: [f64; 3] = [0.25, 0.5, 0.75];
const BETWEEN_TOLERANCE: f64 = 2e-5;
/// Distance kept from the limit of the own blade, mm.
const OWN_MARGIN: f64 = 1e-4;
/// Added to the distance from which on a ray counts no more, mm: more than rounding takes from it.
const LIMIT_MARGIN: f64 = 1e-9;

impl WallFit<'_> {
    /// Moves the axes of the strip of `layer` towards those of the whole wall `beside` them where another
    /// blade is in their way, and their neighbours so far that no axis jumps.
    pub(super) fn give_way(&self, layer: usize, beside: &[FittedAxis]) -> WallStrip {
        let strip = &self.strips[layer];
        if !strip.inclined {
            return strip.clone();
        }
        let between = |k: usize, share: f64| strip.fitted[k].towards(&beside[k], 1.0 - share);
        let is_free = |k: usize, share: f64| {
            let line =
                strip.moved_off_at(&self.face, &self.places, k, &between(k, share), MIN_WALL_TOLERANCE);
            !self.other_blade_is_near(layer, &line)
        };
        let differs = |k: usize| strip.fitted[k].distance(&beside[k]) > SAME_SIDE;
        let share = |k: usize| match strip.low[k].is_finite() && differs(k) && !is_free(k, 1.0) {
            true => SHARES.into_iter().find(|&share| is_free(k, share)).unwrap_or(1.0),
            false => 1.0,
        };
        let mut shares: Vec<f64> = (0..self.places.len()).into_par_iter().map(share).collect();
        // The largest change of the share between neighbours at which the axes turn by no more than they may.
        let step = |k: usize| {
            let turn = strip.fitted[k].line().axis().angle(&beside[k].line().axis());
            (MAX_STATION_TURN / turn.max(MAX_STATION_TURN)).max(1e-3)
        };
        for k in 1..shares.len() {
            shares[k] = shares[k].min(shares[k - 1] + step(k));
        }
        for k in (1..shares.len()).rev() {
            shares[k - 1] = shares[k - 1].min(shares[k] + step(k - 1));
        }
        let mut moved = strip.clone();
        moved.fitted = (0..self.places.len()).map(|k| between(k, shares[k])).collect();
        moved.find_lows(&self.face, &self.places, self.milling, &self.layers[layer]);
        moved
    }

    /// The cutter with the axis of `line` on a layer; `None` where it misses it.
    fn cutter(&self, layer: usize, line: &AxisLine) -> Option<CutterSolid> {
        let (tool, axis) = (self.milling.tool, line.axis());
        self.layers[layer].tip(tool, &line.low, &axis).map(|tip| tool.placed(tip, axis))
    }

    fn other_blade_is_near(&self, layer: usize, line: &AxisLine) -> bool {
        let wanted = self.milling.blade_allowance - MIN_WALL_TOLERANCE;
        let Some(cutter) = self.cutter(layer, line) else { return false };
        obstacles(self.finished, self.own_side, (&cutter, self.milling.tool.overhang), wanted)
            .next()
            .is_some()
    }

    /// Shifts the axes of a layer off the own blade where the cutter, at a station or on the way to the next,
    /// comes nearer to it than the allowance less `tolerance` (mm), as the round end of an inclined one does
    /// below the strip. Returns whether any was shifted.
    pub(super) fn clear_own_blade(&self, layer: usize, lines: &mut [AxisLine], tolerance: f64) -> bool {
        let own = self.own_side.filter(|_| self.strips[layer].inclined);
        let Some(probe) = own.map(|side| &self.finished.blades()[side]) else { return false };
        let wanted = self.milling.blade_allowance - tolerance;
        let lacking = |line: &AxisLine, wanted: f64| {
            let near = self.cutter(layer, line).and_then(|cutter| probe.nearest_below(&cutter, wanted));
            near.map_or(0.0, |near| wanted - near.distance)
        };
        let mut shifted = vec![0.0; lines.len()];
        // Lacking at the stations and on the way to the next; measured anew where an axis was shifted.
        let mut ends = vec![0.0; lines.len()];
        let mut between = vec![0.0; lines.len().saturating_sub(1)];
        let mut is_new = vec![true; lines.len()];
        for _ in 0..OWN_SHIFTS {
            let here = &*lines;
            ends.par_iter_mut().enumerate().filter(|(k, _)| is_new[*k]).for_each(|(k, lacks)| {
                *lacks = lacking(&here[k], wanted);
            });
            let moved = |(k, _): &(usize, &mut f64)| is_new[*k] || is_new[*k + 1];
            between.par_iter_mut().enumerate().filter(moved).for_each(|(k, lacks)| {
                let at =
                    |share: f64| lacking(&here[k].towards(&here[k + 1], share), wanted - BETWEEN_TOLERANCE);
                *lacks = BETWEEN.into_iter().map(at).fold(0.0, f64::max);
            });
            is_new.fill(false);
            for (k, line) in lines.iter_mut().enumerate() {
                let around = [k.checked_sub(1), Some(k)].into_iter().flatten().filter_map(|k| between.get(k));
                let out = around.fold(ends[k], |out, &lacking| f64::max(out, lacking));
                if out > 0.0 && shifted[k] + out <= MAX_OWN_SHIFT * self.face.reach {
                    line.shift(&self.face, self.places[k], out + OWN_MARGIN);
                    shifted[k] += out + OWN_MARGIN;
                    is_new[k] = true;
                }
            }
            if !is_new.contains(&true) {
                break;
            }
        }
        shifted.iter().any(|&by| by > 0.0)
    }
}

impl WallFit<'_> {
    /// Whether the map of a strip takes the axes from the centre of the round end on, not as infinite lines:
    /// those of ball cutters that are inclined.
    pub(super) fn has_rays(&self, strip: &WallStrip) -> bool {
        strip.inclined && self.milling.tool.radius() - self.milling.tool.corner_radius < 1e-9
    }

    /// Lowers the deviation of a map, if any strip has rays, to what these strips leave, and then to what the
    /// round ends of all strips leave below them of what strips further down have left.
    pub(super) fn form_by_rays(
        &self,
        lines: &[Vec<AxisLine>],
        columns: &[MapColumn],
        rows: &[f64],
        deviation: &mut [f64],
    ) {
        let with_rays = |(layer, lines): (usize, &Vec<AxisLine>)| {
            let ray = |line: &AxisLine| {
                let cutter = self.cutter(layer, line)?;
                let from = (cutter.tip - line.low).dot(&cutter.axis) + cutter.corner_radius;
                Some(AxisRay { low: line.low, axis: cutter.axis, from })
            };
            (layer, lines.par_iter().map(ray).collect::<Vec<_>>())
        };
        if !self.strips.iter().any(|strip| self.has_rays(strip)) {
            return;
        }
        let point = |column: &MapColumn, v: &f64| self.face.side.point(column.u, *v);
        let points: Vec<Point> =
            columns.par_iter().flat_map_iter(|column| rows.iter().map(move |v| point(column, v))).collect();
        let all = lines.iter().enumerate().map(with_rays);
        let all: Vec<_> = all.map(|(layer, rays)| (layer, RaySweep::new(rays, &points))).collect();
        for below in [false, true] {
            // From above: a point is nearest to the axes of its own strip; those further down hardly matter
            // then.
            for (layer, rays) in all.iter().rev() {
                let strip = &self.strips[*layer];
                if !below && !self.has_rays(strip) {
                    continue;
                }
                let of_columns = deviation.par_chunks_mut(rows.len()).zip(points.par_chunks(rows.len()));
                of_columns.zip(columns).for_each(|((deviations, points), column)| {
                    for (row, (deviation, point)) in deviations.iter_mut().zip(points).enumerate() {
                        let formed = strip.is_evaluated(column, row, rows);
                        if below == formed || below && !deviation.is_finite() {
                            continue;
                        }
                        let limit = *deviation + self.face.reach + LIMIT_MARGIN;
                        let left = rays.distance_below(limit, column.station, point) - self.face.reach;
                        *deviation = deviation.min(left);
                    }
                });
            }
        }
    }
}
