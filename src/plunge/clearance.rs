//! How near a cutter comes to the finished part: measured, not derived from how it was placed.

use crate::geometry::{CutterSolid, Meridional, frame_about, search};
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
        let at = |rho: f64, phi: f64, up: f64| {
            let p = Meridional::of(&(centre + (e1 * phi.cos() + e2 * phi.sin()) * rho + cutter.axis * up));
            // From far up the nearest place on the hub may be anywhere along it.
            let (t, d) = if up > reach { curve.project(p) } else { curve.project_near(p, start, reach) };
            // Beyond its ends the hub has an edge, not a surface.
            if t <= 0.0 || t >= curve.length() { d.abs() } else { d }
        };
        const AROUND: usize = 36;
        let step = std::f64::consts::TAU / AROUND as f64;
        let mut rim = [0.0; AROUND];
        for (i, d) in rim.iter_mut().enumerate() {
            *d = at(flat, step * i as f64, 0.0);
        }
        let lowest = rim.iter().copied().fold(f64::INFINITY, f64::min);
        let mut least = lowest;
        for i in 0..AROUND {
            let (before, after) = (rim[(i + AROUND - 1) % AROUND], rim[(i + 1) % AROUND]);
            if rim[i] > before || rim[i] > after || rim[i] > lowest + 0.2 {
                continue;
            }
            let middle = step * i as f64;
            let (_, d) = search::minimum(|phi| at(flat, phi, 0.0), middle - step, middle + step, 1e-6);
            least = least.min(d);
        }
        // Inside the disc, where the hub bulges; refined by halving steps from the best sample.
        let mut inner = (f64::INFINITY, 0.0, 0.0);
        for ring in 0..3 {
            for i in 0..9 {
                let (rho, phi) = (flat * f64::from(ring) / 3.0, step * 4.0 * f64::from(i));
                let d = at(rho, phi, 0.0);
                if d < inner.0 {
                    inner = (d, rho, phi);
                }
            }
        }
        if inner.0 < least + 0.1 {
            let (mut dr, mut dp) = (flat / 6.0, 2.0 * step);
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
                least = least.min(at(flat, step * 4.0 * f64::from(i), up * cutter.radius));
            }
        }
        least - cutter.corner_radius
    }
}
