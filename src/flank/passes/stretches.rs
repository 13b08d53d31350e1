//! Curves split by regions.

use crate::flank::chart::LayerChart;
use crate::flank::layer::LayerPoint;
use crate::flank::layer_walls::LayerWalls;
use crate::flank::region::{Region, WallName};
use crate::flank::strategies::{PassCurve, PassRole};

/// A piece of a curve within one region.
pub(super) struct CurvePiece {
    pub(super) role: PassRole,
    pub(super) region: Region,
    pub(super) points: Vec<LayerPoint>,
}

/// A curve split by regions. A curve along a splitter counts as inner upstream of its nose.
pub(super) fn split_by_region(chart: &LayerChart, curve: &PassCurve) -> Vec<CurvePiece> {
    let borders = chart.borders;
    let whole = |region: Region| CurvePiece { role: curve.role, region, points: curve.points.clone() };
    match curve.role {
        PassRole::Wall(wall @ WallName::Splitter(_)) => {
            // The curve round the nose of a splitter is kept whole; isoparametric curves continue upstream of
            // it and are split.
            let is_beside = |p: &LayerPoint| borders.nearest_region(*p).facing(wall).is_some();
            let ends_beside =
                curve.points.first().is_some_and(is_beside) && curve.points.last().is_some_and(is_beside);
            if ends_beside && reaches_nose(borders, wall, &curve.points) {
                return vec![whole(region_divided_by(borders, wall))];
            }
        }
        PassRole::Wall(wall) => return vec![whole(borders.region_at_outlet(wall))],
        PassRole::Inner => {}
    }
    let beginning = |region: Region, points: Vec<LayerPoint>| {
        let along = matches!(curve.role, PassRole::Wall(wall) if region.facing(wall).is_some());
        CurvePiece { role: if along { curve.role } else { PassRole::Inner }, region, points }
    };
    let mut stretches: Vec<CurvePiece> = Vec::new();
    let mut last: Option<LayerPoint> = None;
    for &p in &curve.points {
        let region = borders.nearest_region(p);
        match (stretches.last_mut(), last) {
            (Some(stretch), Some(q)) if stretch.region != region => {
                let nose = nose_between(borders, stretch.region, region);
                let at = nose.map_or(p, |x| q.lerp(p, ((x - q.x) / (p.x - q.x)).clamp(0.0, 1.0)));
                stretch.points.push(at);
                stretches.push(beginning(region, vec![at, p]));
            }
            (Some(stretch), _) => stretch.points.push(p),
            (None, _) => stretches.push(beginning(region, vec![p])),
        }
        last = Some(p);
    }
    stretches.retain(|stretch| stretch.points.len() >= 2 && chart.layer.length(&stretch.points) > 1e-6);
    stretches
}

/// Whether a curve along a splitter begins at its nose, not at that of another one further downstream.
fn reaches_nose(borders: &LayerWalls, wall: WallName, points: &[LayerPoint]) -> bool {
    let Some(foremost) = points.iter().min_by(|a, b| a.x.total_cmp(&b.x)) else { return false };
    let begins = |wall: WallName| borders.splitter(wall).map_or(f64::NEG_INFINITY, |s| s.nose.x);
    let facing = borders.nearest_region(*foremost).facing(wall);
    facing.is_none_or(|facing| begins(facing) <= begins(wall))
}

/// The region that a splitter stands in and divides.
fn region_divided_by(borders: &LayerWalls, wall: WallName) -> Region {
    let mut region = Region::INLET;
    while let Some(splitter) = borders.divider(region).filter(|splitter| splitter.name() != wall) {
        let between = splitter.name();
        region = if wall < between {
            Region { high: between, ..region }
        } else {
            Region { low: between, ..region }
        };
    }
    region
}

/// x of the last nose of the walls of two neighbouring regions, mm: there the one becomes the other.
fn nose_between(borders: &LayerWalls, a: Region, b: Region) -> Option<f64> {
    let splitters = [a.low, a.high, b.low, b.high].into_iter().filter_map(|wall| borders.splitter(wall));
    splitters.map(|splitter| splitter.nose.x).reduce(f64::max)
}

/// The pieces of a line between two x.
pub(super) fn pieces_between(line: &[LayerPoint], from: f64, to: f64) -> Vec<Vec<LayerPoint>> {
    let mut pieces: Vec<Vec<LayerPoint>> = Vec::new();
    let mut open = false;
    for w in line.windows(2) {
        let (a, b) = (w[0], w[1]);
        let span = b.x - a.x;
        let (mut low, mut high) = (0.0f64, 1.0f64);
        if span.abs() > 1e-12 {
            let (s, t) = ((from - a.x) / span, (to - a.x) / span);
            low = low.max(s.min(t));
            high = high.min(s.max(t));
        } else if !(from..=to).contains(&a.x) {
            high = -1.0;
        }
        if low >= high {
            open = false;
            continue;
        }
        if !open || low > 0.0 {
            pieces.push(vec![a.lerp(b, low)]);
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push(a.lerp(b, high));
        }
        open = high >= 1.0;
    }
    pieces
}
