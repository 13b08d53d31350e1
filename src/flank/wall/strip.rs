//! The strip of a wall that the cutter forms on one layer: from where its flank begins up to where that of
//! the layer above begins.

use rayon::prelude::*;

use super::fit::{AxisLine, FitHeights, FittedAxis, OffsetSide};
use super::milling::WallMilling;
use super::stations::MAX_STATION_TURN;
use super::swept::{MARGIN, MapColumn, correct_overcuts};
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::evenly;

/// Share of the height of a wall above which no strip begins: it would be too narrow to define a direction.
pub(super) const MAX_UNFORMED: f64 = 0.9;
/// Maximum angle of an axis along the feed to the plain offset, rad.
pub(super) const MAX_LEAD_ANGLE: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Heights of a fit, on a ruled wall and on another one; an evaluation uses about twice as many.
const RULED_HEIGHTS: usize = 11;
const BOWED_HEIGHTS: usize = 25;
/// Heights of a fit in the strip of a layer.
const STRIP_HEIGHTS: usize = 7;
/// Largest shifts of the axes of a strip from those of the whole wall that are tried, as shares of the height
/// of the wall, and the least of them, mm.
const STRIP_SHIFTS: [f64; 4] = [0.0, 0.05, 0.15, 0.5];
const MIN_STRIP_SHIFT: f64 = 0.5;
/// Deviation of a strip below which no further shift is tried, mm.
const SMALL_DEVIATION: f64 = 0.0025;
/// Axes further off those of the whole wall are taken where the mean deviation falls to this share.
const WORTH_A_SHIFT: f64 = 0.95;
/// Turn between neighbouring axes that the wall cannot cause, rad: a jump between two local optima.
const JUMP: f64 = 2.0 * MAX_STATION_TURN;
/// Minimum number of heights of an evaluation.
const MIN_EVALUATED: f64 = 5.0;
/// On a ruled wall every n-th row of a map above a strip is evaluated; on a bowed wall all are, as a lower
/// layer may cut much of what is left there.
const ROWS_ABOVE: usize = 4;

/// The strip, by stations of the wall.
#[derive(Clone, Debug)]
pub(super) struct WallStrip {
    /// v at which the flank begins; infinite where the tool misses the layer.
    pub(super) low: Vec<f64>,
    /// v at which the next strip begins, at most 1.
    top: Vec<f64>,
    /// The fitted axes.
    pub(super) fitted: Vec<FittedAxis>,
    /// Whether they are inclined to the axes of the whole wall: where these leave more than little.
    pub(super) inclined: bool,
    /// Heights of a fit in the strip, and above it as if it were the whole height.
    heights: [usize; 2],
    /// Heights of an evaluation over the whole height.
    judged: usize,
    /// Every n-th row of a map above the strip is evaluated.
    rows_above: usize,
}

impl WallStrip {
    /// The whole height: what the flank forms if the tool is on the allowance of the hub. Not fitted yet.
    pub(super) fn whole(face: &OffsetSide, places: &[f64], milling: &WallMilling) -> Self {
        let uncut = milling.hub_allowance + milling.tool.corner_radius;
        let height = |&u: &f64| (face.side.point(u, 1.0) - face.side.point(u, 0.0)).norm();
        let heights = if face.side.is_ruled() { RULED_HEIGHTS } else { BOWED_HEIGHTS };
        Self {
            low: places.iter().map(|u| (uncut / height(u).max(1e-9)).min(MAX_UNFORMED)).collect(),
            top: vec![1.0; places.len()],
            fitted: Vec::new(),
            inclined: false,
            heights: [heights, 0],
            judged: 2 * heights - 1,
            rows_above: if face.side.is_ruled() { ROWS_ABOVE } else { 1 },
        }
    }

    /// The strips of all layers, for tools that rest on their surfaces with the axes of this strip. Not
    /// fitted yet.
    pub(super) fn by_layer(
        &self,
        face: &OffsetSide,
        places: &[f64],
        milling: &WallMilling,
        layers: &[DepthSurface],
    ) -> Vec<Self> {
        // Indexed by stations, then layers.
        let lows = |(&u, fitted): (&f64, &FittedAxis)| -> Vec<f64> {
            lows_on(face, u, &fitted.line(), milling, layers)
        };
        let lows: Vec<Vec<f64>> = places.par_iter().zip(&self.fitted).map(lows).collect();
        let of_layer = |k: usize| {
            let top = |lows: &Vec<f64>| {
                let next = lows[k + 1..].iter().copied().fold(f64::INFINITY, f64::min);
                if next < MAX_UNFORMED { next } else { 1.0 }
            };
            Self {
                low: lows.iter().map(|lows| lows[k].max(0.0)).collect(),
                top: lows.iter().map(top).collect(),
                fitted: Vec::new(),
                inclined: false,
                heights: [STRIP_HEIGHTS, self.heights[0]],
                judged: self.judged,
                rows_above: self.rows_above,
            }
        };
        (0..layers.len()).map(of_layer).collect()
    }

    /// Heights of an evaluation over the whole height.
    pub(super) fn evaluated_heights(&self) -> usize {
        self.judged
    }

    /// v at which the strip begins and ends, at a station.
    fn ends(&self, station: usize) -> [f64; 2] {
        let low = self.low[station].min(MAX_UNFORMED);
        [low, self.top[station].max(low)]
    }

    fn heights(&self, station: usize) -> FitHeights {
        let [low, top] = self.ends(station);
        let [formed, above] = self.heights;
        FitHeights::new([low, top], formed, (above as f64 * (1.0 - top)).ceil() as usize)
    }

    /// Axes fitted to the strip, started from those `beside` it.
    pub(super) fn fit_axes(
        &self,
        face: &OffsetSide,
        places: &[f64],
        beside: Option<&[FittedAxis]>,
        max_tilt: f64,
    ) -> Vec<FittedAxis> {
        let fitted =
            |(k, &u): (usize, &f64)| face.fit(u, &self.heights(k), beside.map(|beside| &beside[k]), max_tilt);
        places.par_iter().enumerate().map(fitted).collect()
    }

    /// Fits axes to the strip, started from those of the whole wall `beside` it: the closest to these of
    /// which no others leave clearly less. Axes that jump from station to station are passed over.
    pub(super) fn fit_beside(&mut self, face: &OffsetSide, places: &[f64], beside: &[FittedAxis]) {
        let mut best: Option<(f64, Vec<FittedAxis>)> = None;
        let mut tried = 0;
        'tried: for max_tilt in [MAX_LEAD_ANGLE, 0.0] {
            let own = self.fit_axes(face, places, Some(beside), max_tilt);
            for shift in STRIP_SHIFTS {
                tried += 1;
                let limit = |axis: &FittedAxis| f64::max(MIN_STRIP_SHIFT, shift * axis.height());
                let axes = own.iter().zip(beside).map(|(own, beside)| own.within(beside, limit(own)));
                let axes: Vec<FittedAxis> = axes.collect();
                if !self.is_smooth(&axes) {
                    continue;
                }
                let [most, mean] = self.deviations(face, places, &axes);
                if best.as_ref().is_none_or(|(least, _)| mean < WORTH_A_SHIFT * least) {
                    best = Some((mean, axes));
                }
                if most <= SMALL_DEVIATION {
                    break 'tried;
                }
            }
        }
        self.inclined = tried > 1;
        let mut fitted = best.map_or_else(|| beside.to_vec(), |(_, axes)| axes);
        fitted.par_iter_mut().enumerate().for_each(|(k, axis)| {
            let own = face.max_deviation(places[k], axis, &self.heights(k));
            axis.level = if self.low[k].is_finite() { axis.level.min(own) } else { 0.0 };
        });
        self.fitted = fitted;
    }

    /// Finds anew where the flank begins, under the inclined axes.
    pub(super) fn find_lows(
        &mut self,
        face: &OffsetSide,
        places: &[f64],
        milling: &WallMilling,
        layer: &DepthSurface,
    ) {
        let low = |(k, &u): (usize, &f64)| {
            let found = lows_on(face, u, &self.fitted[k].line(), milling, std::slice::from_ref(layer));
            // Where the tool misses the layer under one of both axes, the strip stays as it was fitted.
            found.first().copied().filter(|low| low.is_finite()).map_or(self.low[k], |low| low.max(0.0))
        };
        self.low = places.par_iter().enumerate().map(low).collect();
    }

    /// Whether the axes turn little between neighbouring stations at which the tool meets the layer.
    pub(super) fn is_smooth(&self, axes: &[FittedAxis]) -> bool {
        let turn = |k: usize| axes[k].line().axis().angle(&axes[k + 1].line().axis());
        let met = |k: usize| self.low[k].is_finite() && self.low[k + 1].is_finite();
        (0..axes.len() - 1).all(|k| !met(k) || turn(k) <= JUMP)
    }

    /// Maximum and mean deviation of `axes` over the strip at the stations on the wall at which the tool
    /// meets the layer, mm.
    fn deviations(&self, face: &OffsetSide, places: &[f64], axes: &[FittedAxis]) -> [f64; 2] {
        let (from, to) = face.side.u_range();
        let counts = |k: &usize| self.low[*k].is_finite() && (from..=to).contains(&places[*k]);
        let stations: Vec<usize> = (0..places.len()).filter(counts).collect();
        let deviation = |&k: &usize| face.max_deviation(places[k], &axes[k], &self.heights(k));
        let all: Vec<f64> = stations.par_iter().map(deviation).collect();
        let mean = all.iter().sum::<f64>() / (all.len() as f64).max(1.0);
        [all.into_iter().fold(0.0, f64::max), mean]
    }

    /// The axes moved along the wall's normals, so that neither they nor those half way between them cut more
    /// than `tolerance` mm below the allowance, as far as [`correct_overcuts`] converges.
    pub(super) fn moved_off(&self, face: &OffsetSide, places: &[f64], tolerance: f64) -> Vec<AxisLine> {
        let moved = |k: usize| self.moved_off_at(face, places, k, &self.fitted[k], tolerance);
        let mut lines: Vec<AxisLine> = (0..places.len()).into_par_iter().map(moved).collect();
        let spare = |line: &AxisLine, column: &MapColumn| {
            let low = column.interpolate(&self.low).min(MAX_UNFORMED);
            let judged = (self.judged as f64 * (1.0 - low)).ceil().max(MIN_EVALUATED) as usize;
            face.min_deviation(line, &evenly(low, 1.0, judged), column.u) + tolerance - MARGIN
        };
        correct_overcuts(face, places, &mut lines, spare);
        lines
    }

    /// An axis at station `k`, moved along the wall's normals until it cuts `tolerance` mm below the
    /// allowance.
    pub(super) fn moved_off_at(
        &self,
        face: &OffsetSide,
        places: &[f64],
        k: usize,
        fitted: &FittedAxis,
        tolerance: f64,
    ) -> AxisLine {
        face.moved_off(places[k], fitted, &self.heights(k), tolerance)
    }

    /// Whether a point of the wall is in the strip.
    pub(super) fn holds(&self, column: &MapColumn, v: f64) -> bool {
        (column.interpolate(&self.low) - 1e-9..=column.interpolate(&self.top) + 1e-9).contains(&v)
    }

    /// Whether a map evaluates `row` of a column: all rows of the strip, and some above it.
    pub(super) fn is_evaluated(&self, column: &MapColumn, row: usize, rows: &[f64]) -> bool {
        let (low, top) = (column.interpolate(&self.low), column.interpolate(&self.top));
        rows[row] >= low - 1e-9
            && (rows[row] <= top || row.is_multiple_of(self.rows_above) || row + 1 == rows.len())
    }
}

/// v at `u` at which the flank begins on each layer for a tool with the axis of `line`; infinite where it
/// misses the layer.
fn lows_on(
    face: &OffsetSide,
    u: f64,
    line: &AxisLine,
    milling: &WallMilling,
    layers: &[DepthSurface],
) -> Vec<f64> {
    let axis = line.axis();
    let rise = face.rise(line, u);
    let low = |surface: &DepthSurface| {
        surface.tip(milling.tool, &line.low, &axis).map_or(f64::INFINITY, |tip| {
            v_at(&rise, (tip - line.low).dot(&axis) + milling.tool.corner_radius)
        })
    };
    layers.iter().map(low).collect()
}

/// v at which a wall has the height `height` along an axis, given its heights `rise` at evenly spaced v (all
/// mm); infinite above its tip.
fn v_at(rise: &[f64], height: f64) -> f64 {
    let pieces = rise.len() - 1;
    let piece = rise.windows(2).position(|ends| height <= ends[1]);
    piece.map_or(f64::INFINITY, |k| {
        let share = (height - rise[k]) / (rise[k + 1] - rise[k]).max(1e-9);
        (k as f64 + share) / pieces as f64
    })
}
