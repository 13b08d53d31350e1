//! Curves split by regions.

use crate::flank::chart::{LayerChart, Region, WallName};
use crate::flank::layer::LayerPoint;
use crate::flank::strategies::{PassCurve, PassRole};

/// A piece of a curve within one region.
pub(super) struct CurvePiece {
    pub(super) role: PassRole,
    pub(super) region: Region,
    pub(super) points: Vec<LayerPoint>,
}

/// A curve split by regions. A curve along the splitter counts as inner upstream of its nose.
pub(super) fn split_by_region(chart: &LayerChart, curve: &PassCurve) -> Vec<CurvePiece> {
    if let PassRole::Wall(wall @ (WallName::Low | WallName::High)) = curve.role {
        let region = if wall == WallName::Low { Region::LowSide } else { Region::HighSide };
        return vec![CurvePiece { role: curve.role, region, points: curve.points.clone() }];
    }
    // The curve round the splitter's nose is kept whole; isoparametric curves continue upstream of it and are
    // split.
    let round = curve.role == PassRole::Wall(WallName::Splitter)
        && curve.points.first().is_some_and(|a| chart.nearest_region(*a) != Region::Inlet)
        && curve.points.last().is_some_and(|b| chart.nearest_region(*b) != Region::Inlet);
    if round {
        return vec![CurvePiece { role: curve.role, region: Region::Inlet, points: curve.points.clone() }];
    }
    let nose = chart.borders.splitter.as_ref().map(|splitter| splitter.nose.x);
    let beginning = |region: Region, points: Vec<LayerPoint>| {
        let role = if region == Region::Inlet { PassRole::Inner } else { curve.role };
        CurvePiece { role, region, points }
    };
    let mut stretches: Vec<CurvePiece> = Vec::new();
    let mut last: Option<LayerPoint> = None;
    for &p in &curve.points {
        let region = chart.nearest_region(p);
        match (stretches.last_mut(), last) {
            (Some(stretch), Some(q)) if stretch.region != region => {
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
