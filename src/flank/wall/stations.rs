//! Spacing of the stations along a wall.

use super::fit::OffsetSide;
use super::milling::WallMilling;
use crate::geometry::{Point, Vector, evenly};

/// Maximum turn of the axis between stations, rad.
pub(super) const MAX_STATION_TURN: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Samples along a wall for the spacing of stations.
const SPACING_SAMPLES: usize = 160;
/// Maximum number of stations of a wall.
const MAX_STATIONS: usize = 2000;

/// u of the stations, as far apart as the maximum step, the chord error and the turn of the axis allow;
/// `None` if their number is not finite.
pub(super) fn station_parameters(face: &OffsetSide, milling: &WallMilling) -> Option<Vec<f64>> {
    let side = face.side;
    let ends = side.u_range();
    let beyond = |u: f64| {
        let speed = [0.0, 1.0].map(|v| side.derivatives(u, v).1.norm());
        milling.lead_in_out / speed[0].min(speed[1]).max(1e-9)
    };
    let (from, to) = (ends.0 - beyond(ends.0), ends.1 + beyond(ends.1));
    let u = evenly(from, to, SPACING_SAMPLES + 1);
    let du = (to - from) / SPACING_SAMPLES as f64;
    let offsets = |v: f64| -> Vec<(Point, Vector)> {
        u.iter()
            .map(|&u| {
                let (p, n, _) = face.frame(u, v);
                (p + n * face.reach, n)
            })
            .collect()
    };
    // Stations per unit of u.
    let mut density = vec![0.0f64; u.len()];
    let edges = [0.0, 0.5, 1.0].map(offsets);
    let axis = |i: usize| edges[2][i].0 - edges[0][i].0;
    for i in 1..u.len() {
        let by_turn = axis(i - 1).angle(&axis(i)) / (MAX_STATION_TURN * du);
        density[i] = density[i].max(by_turn);
    }
    for line in &edges {
        for i in 0..u.len() {
            let k = i.clamp(1, SPACING_SAMPLES - 1);
            let (before, (here, normal), after) = (line[k - 1].0, line[k], line[k + 1].0);
            let speed = (after - before).norm() / (2.0 * du);
            let bend = ((after - here) - (here - before)).dot(&normal).abs() / (du * du);
            let by_bend = (bend / (8.0 * milling.chord_error.max(1e-6))).sqrt();
            density[i] = density[i].max(speed / milling.step.max(1e-3)).max(by_bend);
        }
    }
    let mut number = vec![0.0f64; u.len()];
    for i in 1..u.len() {
        // A narrow bend counts on both sides of it.
        let around = i.saturating_sub(2)..(i + 2).min(u.len());
        number[i] = number[i - 1] + du * density[around].iter().copied().fold(0.0, f64::max);
    }
    let total = number[SPACING_SAMPLES];
    if !total.is_finite() || total <= 0.0 {
        return None;
    }
    let count = (total.ceil() as usize).clamp(2, MAX_STATIONS);
    let mut at = 0;
    let place = |k: usize| {
        let wanted = total * k as f64 / count as f64;
        while at + 2 < u.len() && number[at + 1] < wanted {
            at += 1;
        }
        u[at] + du * (wanted - number[at]) / (number[at + 1] - number[at]).max(1e-12)
    };
    Some((0..=count).map(place).collect())
}
