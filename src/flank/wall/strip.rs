//! The strip of a wall that the cutter forms on one layer: from where its flank begins up to where that of
//! the layer above begins.

use rayon::prelude::*;

use super::fit::{AxisLine, FittedAxis, Heights, OffsetSide};
use super::stations::evenly;
use super::swept::{MapColumn, correct_overcuts};
use super::{MARGIN, MAX_UNFORMED, WallMilling};
use crate::cutting::drop_cutter::DepthSurface;

/// Heights of a fit, on a ruled wall and on another one; an evaluation uses about twice as many.
const RULED_HEIGHTS: usize = 11;
const BOWED_HEIGHTS: usize = 25;
/// Heights of a fit in the strip of a layer.
const STRIP_HEIGHTS: usize = 7;
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
            let line = fitted.line();
            let axis = line.axis();
            let rise = face.rise(&line, u);
            let low = |surface: &DepthSurface| {
                surface.tip(milling.tool, &line.low, &axis).map_or(f64::INFINITY, |tip| {
                    v_at(&rise, (tip - line.low).dot(&axis) + milling.tool.corner_radius)
                })
            };
            layers.iter().map(low).collect()
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

    fn heights(&self, station: usize) -> Heights {
        let [low, top] = self.ends(station);
        let [formed, above] = self.heights;
        Heights::new([low, top], formed, (above as f64 * (1.0 - top)).ceil() as usize)
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

    /// The axes moved along the wall's normals, so that neither they nor those half way between them cut more
    /// than `tolerance` mm below the allowance, as far as [`correct_overcuts`] converges.
    pub(super) fn moved_off(&self, face: &OffsetSide, places: &[f64], tolerance: f64) -> Vec<AxisLine> {
        let moved = |(k, &u): (usize, &f64)| face.moved_off(u, &self.fitted[k], &self.heights(k), tolerance);
        let mut lines: Vec<AxisLine> = places.par_iter().enumerate().map(moved).collect();
        let spare = |line: &AxisLine, column: &MapColumn| {
            let low = column.interpolate(&self.low).min(MAX_UNFORMED);
            let judged = (self.judged as f64 * (1.0 - low)).ceil().max(MIN_EVALUATED) as usize;
            face.min_deviation(line, &evenly(low, 1.0, judged), column.u) + tolerance - MARGIN
        };
        correct_overcuts(face, places, &mut lines, spare);
        lines
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
