//! One-sided envelope of a wall ([assessment paper], section II, fig. 5): the ruled surface that a plunging
//! cutter can follow without cutting the blade, and the stock it leaves on the blade.

use super::blade::Blade;
use super::side::BladeSide;
use crate::geometry::envelope::envelope_above;
use crate::geometry::{Point, Vector};

/// Envelope lines of a wall, one per blade curve hub → tip.
///
/// Each curve S(u, ·) is projected into the plane through its hub point that contains its chord, hub →
/// tip, and the wall's normal at mid span. There it is enveloped on the side of the channel; the gap is
/// measured along that normal.
#[derive(Clone, Debug)]
pub struct WallEnvelope {
    /// u of the curves, LE 0 to TE 1.
    pub u: Vec<f64>,
    /// v at which each curve's gap is listed, hub 0 to tip 1.
    pub v: Vec<f64>,
    /// Per curve the ends of its line, beside the hub and beside the tip of the blade.
    pub lines: Vec<[Point; 2]>,
    /// Stock the line leaves on the blade, mm, at `u[i]`, `v[j]` under index `i · v.len() + j`; never
    /// negative.
    pub gaps: Vec<f64>,
}

/// Which wall of a blade.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BladeWall {
    /// The suction side.
    Suction,
    /// The pressure side.
    Pressure,
}

/// Intervals per curve: a bow of 10 mm is approximated to 3 µm.
const SPAN_STEPS: usize = 64;

impl WallEnvelope {
    /// Envelope of one wall of `blade` over `curves` + 1 curves, evenly spaced in u.
    pub fn from_blade(blade: &Blade, wall: BladeWall, curves: usize) -> Self {
        let (side, back) = match wall {
            BladeWall::Suction => (&blade.suction, &blade.pressure),
            BladeWall::Pressure => (&blade.pressure, &blade.suction),
        };
        // ∂S/∂u × ∂S/∂v points to one side all over the wall; mid blade shows whether that is the
        // outside.
        let outwards = side.point(0.5, 0.5) - back.point(0.5, 0.5);
        let (_, pu, pv) = side.derivatives(0.5, 0.5);
        let sign = if pu.cross(&pv).dot(&outwards) < 0.0 { -1.0 } else { 1.0 };
        let u: Vec<f64> = (0..=curves).map(|i| i as f64 / curves.max(1) as f64).collect();
        let v: Vec<f64> = (0..=SPAN_STEPS).map(|j| j as f64 / SPAN_STEPS as f64).collect();
        let mut lines = Vec::with_capacity(u.len());
        let mut gaps = Vec::with_capacity(u.len() * v.len());
        let mut curve = Vec::with_capacity(v.len());
        for &u in &u {
            lines.push(envelope_line(side, sign, u, &v, &mut curve, &mut gaps));
        }
        Self { u, v, lines, gaps }
    }

    /// Greatest gap, mm.
    pub fn max_gap(&self) -> f64 {
        self.gaps.iter().copied().fold(0.0, f64::max)
    }
}

/// Ends of the line over the curve at `u`; appends its gaps. `curve` is a buffer.
fn envelope_line(
    side: &BladeSide,
    sign: f64,
    u: f64,
    v: &[f64],
    curve: &mut Vec<[f64; 2]>,
    gaps: &mut Vec<f64>,
) -> [Point; 2] {
    let (foot, tip) = (side.point(u, 0.0), side.point(u, 1.0));
    let chord = (tip - foot).try_normalize(1e-12).unwrap_or_else(Vector::z);
    let (_, pu, pv) = side.derivatives(u, 0.5);
    let normal = pu.cross(&pv) * sign;
    // Where the wall has no normal, the chord itself is the line.
    let normal = (normal - chord * normal.dot(&chord)).try_normalize(1e-12).unwrap_or_else(Vector::zeros);
    curve.clear();
    curve.extend(v.iter().map(|&v| {
        let d = side.point(u, v) - foot;
        [d.dot(&chord), d.dot(&normal)]
    }));
    let Some(line) = envelope_above(curve) else {
        gaps.extend(v.iter().map(|_| 0.0));
        return [foot, tip];
    };
    gaps.extend(curve.iter().map(|p| (line.y_at(p[0]) - p[1]).max(0.0)));
    [foot + normal * line.y_at(0.0), tip + normal * line.y_at((tip - foot).norm())]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A blade of 60 × 30 mm, 2 mm thick, its sections at `v` moved across by `bow`.
    fn bowed(sections: usize, bow: impl Fn(f64) -> f64) -> Blade {
        let u: Vec<f64> = (0..=10).map(|i| f64::from(i) / 10.0).collect();
        let stations: Vec<f64> = (0..sections).map(|k| k as f64 / (sections - 1) as f64).collect();
        let side = |y: f64| {
            let section = |v: &f64| -> Vec<Point> {
                u.iter().map(|u| Point::new(40.0 + 30.0 * v, y + bow(*v), 60.0 * u)).collect()
            };
            let sections: Vec<Vec<Point>> = stations.iter().map(section).collect();
            BladeSide::loft(&u, &stations, &sections)
        };
        Blade { suction: side(1.0), pressure: side(-1.0) }
    }

    #[test]
    fn ruled_walls_have_no_gap() {
        let blade = bowed(2, |v| 3.0 * v);
        for wall in [BladeWall::Suction, BladeWall::Pressure] {
            let gap = WallEnvelope::from_blade(&blade, wall, 8).max_gap();
            assert!(gap < 1e-12, "{wall:?}: {gap}");
        }
    }

    #[test]
    fn a_bowed_wall_keeps_to_its_side_of_the_lines() {
        // Hollow on one side, bulging on the other: on both the gap is the bow.
        let blade = bowed(33, |v| 0.8 * (std::f64::consts::PI * v).sin());
        for (wall, away, face) in [(BladeWall::Suction, 1.0, 1.0), (BladeWall::Pressure, -1.0, -1.0)] {
            let envelope = WallEnvelope::from_blade(&blade, wall, 8);
            assert!((envelope.max_gap() - 0.8).abs() < 1e-5, "{wall:?}: {}", envelope.max_gap());
            for [foot, tip] in &envelope.lines {
                for v in [0.0, 0.2, 0.5, 0.9, 1.0] {
                    let line = foot.y + v * (tip.y - foot.y);
                    let wall_y = face + 0.8 * (std::f64::consts::PI * v).sin();
                    assert!(away * (line - wall_y) > -1e-5, "{wall:?}: line at {line}, wall at {wall_y}");
                }
            }
            let middle = envelope.v.len() / 2;
            let at_middle = envelope.gaps[middle];
            let expected = if wall == BladeWall::Suction { 0.0 } else { 0.8 };
            assert!((at_middle - expected).abs() < 1e-5, "{wall:?}: {at_middle} mm at mid span");
        }
    }
}
