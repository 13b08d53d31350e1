//! A plane for the parameters of a face: flat, or polar for a face that goes round a closed surface.
//!
//! In polar coordinates a band round a cylinder is a ring, a cap of a sphere a disc: there is no seam to cut
//! along, a hole may be anywhere, and a pole is the origin.

use std::f64::consts::TAU;

use super::surface::{Pole, Surface};
use crate::geometry::Point;

/// Range of the logarithm of the ratio of the radii of a ring: not so thin that chords of its circles cross,
/// not so wide that numbers lose their digits.
const RING: (f64, f64) = (1.5, 12.0);
/// The same of a surface that is straight along the radius: as with [`FLATTENED`], triangles between notches
/// of its borders would span far more of the curve than a chord of these in a wider ring.
const STRAIGHT_RING: f64 = 0.1;
/// Largest extent along the straight lines of a surface that is curved across them, as a share of that
/// across. There are no points between the borders: in true lengths the triangles between borders that are
/// not at right angles to the lines would run askew to them, over the curve.
const FLATTENED: f64 = 0.01;
/// Cells of the grid of a face that are longer than this many times their width are made square.
const LONG: f64 = 4.0;
/// Parameters within this share of a period are equal.
const EQUAL: f64 = 1e-6;

/// A border of a face in its parameters.
#[derive(Clone, Debug)]
pub struct Ring {
    /// Parameters, and the number of the point.
    pub places: Vec<([f64; 2], u32)>,
    /// Turns about the periods of both parameters.
    pub winding: [i32; 2],
}

impl Ring {
    /// Twice the area inside in the plane of the parameters, where it goes round no period; positive where
    /// the inside is to its left.
    pub fn signed_area(&self) -> f64 {
        let next = self.places.iter().cycle().skip(1);
        self.places.iter().zip(next).map(|((a, _), (b, _))| a[0] * b[1] - a[1] * b[0]).sum()
    }
}

/// The parameters of the points of a closed line, continued over periods; `None` where they do not close.
pub fn unwrapped(surface: &Surface, ring: &[u32], points: &[Point], poles: &[Pole]) -> Option<Ring> {
    let periods = surface.periods();
    let pole_at = |p: &Point| poles.iter().find(|pole| (pole.point - p).norm() < super::surface::ON_AXIS);
    let mut ring = ring.to_vec();
    // Begins where the parameters are not at a seam, where their inversion is ambiguous.
    let seams = |i: u32| {
        let p = &points[i as usize];
        let q = surface.nearest(p, None);
        let near = |k: usize| {
            periods[k].is_some_and(|w| {
                let start = surface.closed_range().map_or(-0.5 * w, |range| range[k].0);
                let share = ((q[k] - start) / w).rem_euclid(1.0);
                !(EQUAL..=1.0 - EQUAL).contains(&share)
            })
        };
        (pole_at(p).is_some(), near(0), near(1))
    };
    if periods != [None; 2] || !poles.is_empty() {
        let free = ring.iter().position(|i| seams(*i) == (false, false, false));
        // A border may run along a seam, as the inlet circle of a hub that begins parallel to the axis.
        let along = || ring.iter().position(|&i| matches!(seams(i), (false, a, b) if !(a && b)));
        let start = free.or_else(along)?;
        ring.rotate_left(start);
    }
    let mut places: Vec<([f64; 2], u32)> = Vec::with_capacity(ring.len() + 1);
    let mut last: Option<[f64; 2]> = None;
    // Places at a pole whose loose parameter is that of the point behind it.
    let mut waiting: Vec<(usize, usize)> = Vec::new();
    for &i in ring.iter().chain(ring.first()) {
        let p = &points[i as usize];
        if let (Some(pole), Some(before)) = (pole_at(p), last) {
            let mut q = [pole.value; 2];
            q[pole.loose] = before[pole.loose];
            let across = 1 - pole.loose;
            if let Some(w) = periods[across] {
                q[across] += w * ((before[across] - q[across]) / w).round();
            }
            places.push((q, i));
            waiting.push((places.len(), pole.loose));
            places.push((q, i));
            continue;
        }
        let mut q = surface.nearest(p, last);
        if let Some(before) = last {
            for k in 0..2 {
                if let Some(w) = periods[k] {
                    q[k] += w * ((before[k] - q[k]) / w).round();
                }
            }
        }
        for (at, loose) in waiting.drain(..) {
            places[at].0[loose] = q[loose];
        }
        places.push((q, i));
        last = Some(q);
    }
    let (first, end) = (places.first()?.0, places.pop()?.0);
    let winding = std::array::from_fn(|k| periods[k].map_or(0, |w| ((end[k] - first[k]) / w).round() as i32));
    places.iter().all(|(q, _)| q.iter().all(|x| x.is_finite())).then_some(Ring { places, winding })
}

/// The plane of a face.
#[derive(Clone, Debug)]
pub struct Chart {
    kind: Kind,
    /// Whether it reverses the orientation of the parameters.
    pub reversed: bool,
    /// Ranges of both parameters.
    pub ranges: [(f64, f64); 2],
    /// The pole inside the face.
    pub pole: Option<Pole>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Parameters times scales, which make them lengths.
    Flat([f64; 2]),
    /// Angle from parameter `round` of a period; the logarithm of the radius from the other: factor and
    /// value at 1.
    Ring { round: usize, period: f64, factor: f64, middle: f64 },
    /// As a ring, with the radius as distance from a pole, times a factor.
    Disc { round: usize, period: f64, factor: f64, pole: f64 },
}

fn range_of<'r>(places: impl Iterator<Item = &'r ([f64; 2], u32)>, k: usize) -> (f64, f64) {
    places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (q, _)| (low.min(q[k]), high.max(q[k])))
}

impl Chart {
    /// The chart of a face with `rings` as borders, which are moved by periods to where they belong; the face
    /// is to their left on the surface where `same`, else to their right.
    ///
    /// # Errors
    /// Why the borders do not bound a face.
    pub fn new(
        surface: &Surface,
        rings: &mut [Ring],
        same: bool,
        poles: &[Pole],
    ) -> Result<Self, &'static str> {
        let round = (0..2).find(|k| rings.iter().any(|r| r.winding[*k] != 0));
        match round {
            None => Ok(Self::flat(surface, rings)),
            Some(round) => Self::polar(surface, rings, round, same, poles),
        }
    }

    fn flat(surface: &Surface, rings: &mut [Ring]) -> Self {
        let periods = surface.periods();
        for k in 0..2 {
            let extent = |r: &Ring| {
                let (low, high) = range_of(r.places.iter(), k);
                high - low
            };
            let Some(period) = periods[k] else { continue };
            let Some(outer) = rings.iter().max_by(|a, b| extent(a).total_cmp(&extent(b))) else { continue };
            let (low, high) = range_of(outer.places.iter(), k);
            for ring in rings.iter_mut() {
                let own = range_of(ring.places.iter(), k);
                let shift = period * ((0.5 * (low + high) - 0.5 * (own.0 + own.1)) / period).round();
                ring.places.iter_mut().for_each(|(q, _)| q[k] += shift);
            }
        }
        let ranges = [0, 1].map(|k| range_of(rings.iter().flat_map(|r| &r.places), k));
        let mut scales = [0, 1].map(|k| length_of(surface, ranges, k).max(1e-9));
        let extent = |k: usize, scale: f64| scale * (ranges[k].1 - ranges[k].0);
        if let Some(k) = (0..2).find(|&k| surface.is_straight(k) && !surface.is_straight(1 - k)) {
            let flat = FLATTENED * extent(1 - k, scales[1 - k]) / extent(k, 1.0).max(1e-12);
            scales[k] = scales[k].min(flat.max(1e-9));
        }
        Self { kind: Kind::Flat(scales), reversed: false, ranges, pole: None }
    }

    fn polar(
        surface: &Surface,
        rings: &mut [Ring],
        round: usize,
        same: bool,
        poles: &[Pole],
    ) -> Result<Self, &'static str> {
        let across = 1 - round;
        let period = surface.periods()[round].ok_or("its borders go round a surface that is open")?;
        if rings.iter().any(|r| r.winding[across] != 0 || r.winding[round].abs() > 1) {
            return Err("a border goes round it in both directions");
        }
        // Whether the face is at greater values across than a ring that goes round.
        let above = |r: &Ring| ((r.winding[round] > 0) == same) == (round == 0);
        if let Some(turn) = surface.periods()[across] {
            // Round a tube: the other borders are within one turn from the first, on its face's side.
            let base =
                rings.iter().find(|r| r.winding[round] != 0).map(|r| (r.places[0].0[across], above(r)));
            let (base, up) = base.ok_or("it has no borders")?;
            let mut first = true;
            for ring in rings.iter_mut() {
                if first && ring.winding[round] != 0 {
                    first = false;
                    continue;
                }
                let own = ring.places[0].0[across];
                let away = (own - base) / turn;
                let shift = turn * if up { -away.floor() } else { -away.ceil() };
                ring.places.iter_mut().for_each(|(q, _)| q[across] += shift);
            }
        }
        let (mut low, mut high) = range_of(rings.iter().flat_map(|r| &r.places), across);
        let going = || rings.iter().filter(|r| r.winding[round] != 0);
        let rising = going().filter(|r| above(r)).count() as i64;
        let falling = going().count() as i64 - rising;
        let pole = match rising - falling {
            0 => None,
            1 | -1 => {
                let up = rising > falling;
                let turn = surface.periods()[across];
                // The next one round a tube that meets the axis.
                let beside_borders = |pole: &Pole| {
                    let value = match turn {
                        Some(turn) if up => pole.value + turn * ((high - pole.value) / turn - EQUAL).ceil(),
                        Some(turn) => pole.value + turn * ((low - pole.value) / turn + EQUAL).floor(),
                        None => pole.value,
                    };
                    Pole { value, ..*pole }
                };
                let slack = EQUAL * turn.unwrap_or(0.0);
                let beyond = |pole: &Pole| if up { pole.value - high } else { low - pole.value };
                let ends = poles.iter().filter(|p| p.loose == round).map(beside_borders);
                let nearest =
                    ends.filter(|pole| beyond(pole) >= -slack).min_by(|a, b| beyond(a).total_cmp(&beyond(b)));
                Some(nearest.ok_or("it has no border at one end")?)
            }
            _ => return Err("its borders do not bound it"),
        };
        let angle = range_of(going().flat_map(|r| &r.places), round);
        let turned = (angle.0, angle.0 + period);
        let kind = if let Some(pole) = pole {
            low = low.min(pole.value);
            high = high.max(pole.value);
            Kind::Disc { round, period, factor: 1.0 / (high - low).max(1e-12), pole: pole.value }
        } else {
            let mut ranges = [(low, high); 2];
            ranges[round] = turned;
            let radius = length_of(surface, ranges, round) * period / TAU;
            let conformal = length_of(surface, ranges, across) / radius.max(1e-9);
            let extent = (high - low).max(1e-12);
            let width = match surface.is_straight(across) {
                true => STRAIGHT_RING,
                false => (conformal * extent).clamp(RING.0, RING.1),
            };
            let factor = width / extent;
            Kind::Ring { round, period, factor, middle: 0.5 * (low + high) }
        };
        let mut ranges = [(low, high); 2];
        ranges[round] = turned;
        // (radius, angle) is right-handed.
        let outwards = pole.is_none_or(|pole| pole.value <= low);
        Ok(Self { kind, reversed: (round == 0) == outwards, ranges, pole })
    }

    /// The same chart where a face has this number of `cells` along both parameters. Of one that is curved
    /// along one of them much more than along the other, such as a narrow round edge, the cells are long: in
    /// true lengths triangles would run from border to border over the curve, past the points between.
    pub fn with_cells(mut self, cells: [usize; 2]) -> Self {
        if let Kind::Flat(scales) = &mut self.kind {
            let length: [f64; 2] = std::array::from_fn(|k| {
                scales[k] * (self.ranges[k].1 - self.ranges[k].0) / cells[k].max(1) as f64
            });
            let longer = usize::from(length[1] > length[0]);
            if length[longer] > LONG * length[1 - longer] && length[1 - longer] > 0.0 {
                scales[longer] *= length[1 - longer] / length[longer];
            }
        }
        self
    }

    /// The place of parameters in the plane.
    pub fn place(&self, q: [f64; 2]) -> [f64; 2] {
        let around = |round: usize, period: f64, radius: f64| {
            let (sin, cos) = (TAU * q[round] / period).sin_cos();
            [radius * cos, radius * sin]
        };
        match self.kind {
            Kind::Flat(scales) => [q[0] * scales[0], q[1] * scales[1]],
            Kind::Ring { round, period, factor, middle } => {
                around(round, period, (factor * (q[1 - round] - middle)).exp())
            }
            Kind::Disc { round, period, factor, pole } => {
                around(round, period, factor * (q[1 - round] - pole).abs())
            }
        }
    }

    /// The parameter that goes round, if one does.
    pub fn round(&self) -> Option<usize> {
        match self.kind {
            Kind::Flat(_) => None,
            Kind::Ring { round, .. } | Kind::Disc { round, .. } => Some(round),
        }
    }
}

/// Greatest length of parameter `k` on the surface per unit of it.
fn length_of(surface: &Surface, ranges: [(f64, f64); 2], k: usize) -> f64 {
    let mut most = 0.0_f64;
    for i in 0..5 {
        for j in 0..5 {
            let at = |r: (f64, f64), n: usize| r.0 + (r.1 - r.0) * (0.1 + 0.2 * n as f64);
            let q = [at(ranges[0], i), at(ranges[1], j)];
            let h = 1e-4 * (ranges[k].1 - ranges[k].0).max(1e-12);
            let mut next = q;
            next[k] += h;
            most = most.max((surface.at(next) - surface.at(q)).norm() / h);
        }
    }
    if most.is_finite() { most } else { 1.0 }
}
