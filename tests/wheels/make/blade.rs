//! Blades as span sections: thickness, nose and tail added to the camber lines.

use std::f64::consts::FRAC_PI_2;

use vanecut::geometry::Point;
use vanecut::part::BladeDescription;

use super::spec::{Edge, Tail};
use super::surface::{Camber, CamberSurface, Station};

/// Makes the blades of one wheel.
pub struct BladeMaker<'a> {
    pub surface: &'a CamberSurface<'a>,
    /// Sign of z: with −1 the inlet faces +z.
    pub up: f64,
}

const NOSE_POINTS: usize = 14;
const BODY_POINTS: usize = 40;
const TAIL_POINTS: usize = 14;

impl BladeMaker<'_> {
    /// The blade with leading edge `leading`, rotated by `ahead`, rad, from the main blade.
    pub fn blade(&self, leading: &Edge, ahead: f64) -> BladeDescription {
        let spec = self.surface.spec;
        let (from, to) = (-spec.overrun[0], 1.0 + spec.overrun[1]);
        let mut sides = [Vec::new(), Vec::new()];
        for k in 0..spec.sections {
            let eta = from + (to - from) * k as f64 / (spec.sections - 1) as f64;
            let section = Section::new(self, leading, eta);
            // Blades are backswept: the side at larger θ trails and is the suction side.
            for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                side.push(section.side(sign).into_iter().map(|p| self.place(eta, p, ahead)).collect());
            }
        }
        let [suction, pressure] = sides;
        BladeDescription::Sections { suction, pressure, line: 0 }
    }

    /// The point at s and θ, rad, on the stream surface `eta`.
    fn place(&self, eta: f64, (s, theta): (f64, f64), ahead: f64) -> Point {
        let place = self.surface.walls.at(s, eta);
        let theta = self.surface.spec.turn * theta + ahead;
        Point::new(place.r * theta.cos(), place.r * theta.sin(), self.up * place.z)
    }
}

/// A blade's profile on a stream surface.
struct Section<'a> {
    maker: &'a BladeMaker<'a>,
    camber: Camber,
    /// Arc lengths of both ends on the camber line, mm.
    ends: (f64, f64),
    /// Thickness at the nose, mm.
    thickness: f64,
    /// m′ of the trailing edge.
    rim: f64,
}

impl<'a> Section<'a> {
    fn new(maker: &'a BladeMaker<'a>, leading: &Edge, eta: f64) -> Self {
        let spec = maker.surface.spec;
        let camber = maker.surface.on(eta);
        let [hub, shroud] = spec.thickness;
        let (first, last) = (camber.at_s(leading.at(eta)), camber.at_s(spec.trailing.at(eta)));
        Self {
            maker,
            ends: (first.length, last.length),
            thickness: spec.rim * (hub + (shroud - hub) * eta.clamp(0.0, 1.0)),
            rim: last.m,
            camber,
        }
    }

    /// Half thickness without nose and tail, mm.
    fn half(&self, length: f64) -> f64 {
        let x = ((length - self.ends.0) / (self.ends.1 - self.ends.0)).clamp(0.0, 1.0);
        0.5 * self.thickness * (1.0 + (self.maker.surface.spec.taper - 1.0) * x)
    }

    /// (m′, θ) at `offset` mm beside the camber line.
    fn beside(&self, at: &Station, offset: f64) -> (f64, f64) {
        let (sin, cos) = at.beta.sin_cos();
        (at.m - sin * offset / at.r, at.theta + cos * offset / at.r)
    }

    /// (s, θ) of a side from leading to trailing edge; `sign` chooses the side of the camber line.
    fn side(&self, sign: f64) -> Vec<(f64, f64)> {
        let spec = self.maker.surface.spec;
        let (ratio, exponent) = spec.nose;
        let nose = (ratio * self.half(self.ends.0)).min(0.25 * (self.ends.1 - self.ends.0));
        let (tail, end) = match spec.tail {
            Tail::Round(ratio) => (ratio * self.half(self.ends.1), self.ends.1),
            Tail::Blunt => (0.0, self.ends.1),
            Tail::Turned => (0.0, self.turned_end(sign)),
        };
        let mut lengths = Vec::new();
        let rounded = |i: usize, points: usize| 1.0 - (FRAC_PI_2 * i as f64 / points as f64).cos();
        lengths.extend((0..NOSE_POINTS).map(|i| self.ends.0 + nose * rounded(i, NOSE_POINTS)));
        let body = (self.ends.0 + nose, end - tail);
        // Points are denser towards both ends, as in files of CAD systems.
        let smooth = |x: f64| 0.6 * x + 0.4 * x * x * (3.0 - 2.0 * x);
        lengths.extend(
            (0..=BODY_POINTS).map(|i| body.0 + (body.1 - body.0) * smooth(i as f64 / BODY_POINTS as f64)),
        );
        if tail > 0.0 {
            lengths.extend((1..=TAIL_POINTS).map(|i| end - tail * rounded(TAIL_POINTS - i, TAIL_POINTS)));
        }
        let offset = |length: f64| {
            let superellipse = |from_end: f64, size: f64, exponent: f64| {
                let x = if size > 0.0 { (1.0 - from_end / size).clamp(0.0, 1.0) } else { 0.0 };
                (1.0 - x.powf(exponent)).max(0.0).powf(1.0 / exponent)
            };
            let shape =
                superellipse(length - self.ends.0, nose, exponent) * superellipse(end - length, tail, 2.0);
            sign * self.half(length) * shape
        };
        let point = |length: f64| {
            let (m, theta) = self.beside(&self.camber.at_length(length), offset(length));
            (self.camber.at_m(m).s, theta)
        };
        lengths.into_iter().map(point).collect()
    }

    /// Arc length on the camber line at which the side reaches the m′ of the trailing edge, mm.
    fn turned_end(&self, sign: f64) -> f64 {
        let ahead =
            |length: f64| self.beside(&self.camber.at_length(length), sign * self.half(length)).0 - self.rim;
        let chord = self.ends.1 - self.ends.0;
        let (mut low, mut high) = (self.ends.1 - 0.3 * chord, self.ends.1 + 0.15 * chord);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if ahead(middle) < 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}
