//! How near a cutter comes to the finished part: measured, not derived from how it was placed.

use crate::geometry::{CutterSolid, Meridional, Point, Vector, frame_about, search};
use crate::part::{Impeller, SideProbe};

/// The finished surfaces around a channel, ready for many measurements.
#[derive(Debug)]
pub struct FinishedPart<'a> {
    part: &'a Impeller,
    blades: Vec<SideProbe>,
}

impl<'a> FinishedPart<'a> {
    /// The surfaces around channel 1 of `part`.
    pub fn new(part: &'a Impeller, sides: &[crate::part::BladeSide]) -> Self {
        Self { part, blades: sides.iter().map(|s| SideProbe::new(s, 0.0, 1.0)).collect() }
    }

    /// Least signed distance of the cutter (bottom and column) to any blade, mm.
    pub fn blade_clearance(&self, cutter: &CutterSolid) -> f64 {
        self.blades.iter().fold(f64::INFINITY, |least, blade| {
            blade.nearest_below(cutter, least).map_or(least, |near| near.distance.min(least))
        })
    }

    /// Whether the cutter (bottom and column) keeps `allowance` mm from every blade.
    pub fn clears(&self, cutter: &CutterSolid, allowance: f64) -> bool {
        let near = |blade: &SideProbe| blade.nearest_below(cutter, allowance);
        !self.blades.iter().any(|blade| near(blade).is_some_and(|n| n.distance < allowance))
    }

    /// Least signed distance of the cutter's bottom and flank to the hub, mm.
    pub fn hub_clearance(&self, cutter: &CutterSolid) -> f64 {
        let curve = self.part.hub.curve();
        let (e1, e2) = frame_about(&cutter.axis);
        let flat = cutter.radius - cutter.corner_radius;
        let centre = cutter.tip + cutter.axis * cutter.corner_radius;
        let (start, _) = curve.project(Meridional::of(&centre));
        let reach = 3.0 * cutter.radius + 0.05 * curve.length();
        let mut warm = start;
        // Signed distance of a point, and its gradient.
        let mut distance = |p: &Point| {
            let m = Meridional::of(p);
            let (t, d) = curve.project_near(m, warm.clamp(start - reach, start + reach), reach);
            warm = t;
            let foot = curve.at(t);
            // Beyond its ends the hub has an edge, not a surface.
            let (d, away) = if t <= 0.0 || t >= curve.length() {
                let length = d.abs().max(1e-12);
                let (r, z) = (m.r - foot.point.r, m.z - foot.point.z);
                (d.abs(), Meridional { r: r / length, z: z / length })
            } else {
                (d, foot.normal)
            };
            let turn = away.r / m.r.max(1e-12);
            (d, Vector::new(turn * p.x, turn * p.y, away.z))
        };
        const AROUND: usize = 18;
        let step = std::f64::consts::TAU / AROUND as f64;
        // Distance on the rim of the bottom and how it changes with the angle.
        let mut on_rim = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            let (d, gradient) = distance(&(centre + (e1 * cos + e2 * sin) * flat));
            (d, gradient.dot(&(e2 * cos - e1 * sin)) * flat)
        };
        let mut rim = [(0.0, 0.0); AROUND];
        for (i, sample) in rim.iter_mut().enumerate() {
            *sample = on_rim(step * i as f64);
        }
        let mut least = rim.iter().map(|sample| sample.0).fold(f64::INFINITY, f64::min);
        let lowest = least;
        for i in 0..AROUND {
            let (a, b) = (rim[i], rim[(i + 1) % AROUND]);
            if a.1 >= 0.0 || b.1 <= 0.0 || a.0.min(b.0) > lowest + 0.2 {
                continue;
            }
            let from = step * i as f64;
            let slope_at = |phi: f64| {
                let (d, slope) = on_rim(phi);
                least = least.min(d);
                slope
            };
            let guess = from + step * a.1 / (a.1 - b.1);
            search::root_from(slope_at, (from, a.1), (from + step, b.1), guess, 1e-5);
        }
        let mut at = |rho: f64, phi: f64, up: f64| {
            let (sin, cos) = phi.sin_cos();
            distance(&(centre + (e1 * cos + e2 * sin) * rho + cutter.axis * up)).0
        };
        // Inside the disc, where the hub bulges; refined by halving steps from the best sample.
        let mut inner = (at(0.0, 0.0, 0.0), 0.0, 0.0);
        for ring in 1..3 {
            for i in 0..9 {
                let (rho, phi) = (flat * f64::from(ring) / 3.0, step * 2.0 * f64::from(i));
                let d = at(rho, phi, 0.0);
                if d < inner.0 {
                    inner = (d, rho, phi);
                }
            }
        }
        if inner.0 < least + 0.1 {
            let (mut dr, mut dp) = (flat / 6.0, step);
            while dr > 1e-5 {
                let mut moved = false;
                for (r, p) in [
                    (inner.1 + dr, inner.2),
                    (inner.1 - dr, inner.2),
                    (inner.1, inner.2 + dp),
                    (inner.1, inner.2 - dp),
                ] {
                    let r = r.clamp(0.0, flat);
                    let d = at(r, p, 0.0);
                    if d < inner.0 {
                        inner = (d, r, p);
                        moved = true;
                    }
                }
                if !moved {
                    dr *= 0.5;
                    dp *= 0.5;
                }
            }
            least = least.min(inner.0);
        }
        // The flank of the column: the hub may curl up beside it.
        for up in [0.2, 1.0, 3.0] {
            for i in 0..9 {
                least = least.min(at(flat, step * 2.0 * f64::from(i), up * cutter.radius));
            }
        }
        least - cutter.corner_radius
    }
}
