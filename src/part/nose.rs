//! The hub upstream of the blank: the nose of the wheel.

use crate::geometry::{Meridional, MeridionalCurve};

/// Straight pieces by which the outline is approximated.
const PIECES: usize = 96;
/// Length of a nose below which there is none, mm.
const MIN_LENGTH: f64 = 1e-3;

/// The body of revolution under the hub curve upstream of the blank, closed by its front plane. A bore counts
/// as filled: an arbor or a screw is in it.
#[derive(Clone, Debug)]
pub(super) struct HubNose {
    /// The meridional outline from the axis at the front along the hub to where the blank begins.
    outline: Vec<Meridional>,
    /// Its least and greatest r and z, mm.
    r_max: f64,
    z_range: (f64, f64),
}

impl HubNose {
    /// The nose under `hub` up to its arc length `end` (mm); `None` where the hub begins there.
    pub(super) fn from_hub(hub: &MeridionalCurve, end: f64) -> Option<Self> {
        if end < MIN_LENGTH {
            return None;
        }
        let end = end.min(hub.length());
        let along = (0..=PIECES).map(|i| hub.point(end * i as f64 / PIECES as f64));
        let front = Meridional { r: 0.0, z: hub.point(0.0).z };
        let outline: Vec<Meridional> = std::iter::once(front).chain(along).collect();
        let r_max = outline.iter().map(|p| p.r).fold(0.0, f64::max);
        let z = outline.iter().map(|p| p.z);
        let z_range = z.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        Some(Self { outline, r_max, z_range })
    }

    /// Distance from `point` to the nose with its nearest point, if it is less than `limit` mm; negative
    /// inside.
    pub(super) fn nearer_than(&self, point: Meridional, limit: f64) -> Option<(f64, Meridional)> {
        if self.is_beyond(point, limit) {
            return None;
        }
        let feet = self.outline.windows(2).map(|pair| point.nearest_on_segment(pair[0], pair[1]));
        let nearest = feet.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let is_inside = self.contains(point);
        (is_inside || nearest.0 < limit).then_some(if is_inside { (-nearest.0, nearest.1) } else { nearest })
    }

    /// Largest radius and range of heights, mm.
    pub(super) fn extent(&self) -> (f64, (f64, f64)) {
        (self.r_max, self.z_range)
    }

    /// Whether `point` is `distance` mm or more from the box around the nose.
    pub(super) fn is_beyond(&self, point: Meridional, distance: f64) -> bool {
        let dz = (self.z_range.0 - point.z).max(point.z - self.z_range.1).max(0.0);
        let dr = (point.r - self.r_max).max(0.0);
        dr * dr + dz * dz >= distance * distance
    }

    /// Whether `point` is in the nose: the number of pieces outside of it in r is odd.
    fn contains(&self, point: Meridional) -> bool {
        let crosses = |pair: &&[Meridional]| {
            let (a, b) = (pair[0], pair[1]);
            (a.z > point.z) != (b.z > point.z) && point.r < a.r + (b.r - a.r) * (point.z - a.z) / (b.z - a.z)
        };
        self.outline.windows(2).filter(crosses).count() % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A nose of radius 30, 12 mm long, rounded towards the front at z = 82.
    fn nose() -> HubNose {
        let points = [[10.0, 82.0], [22.0, 80.0], [28.0, 76.0], [30.0, 70.0], [31.0, 60.0]];
        let points: Vec<Meridional> = points.iter().map(|p| Meridional { r: p[0], z: p[1] }).collect();
        let hub = MeridionalCurve::through(&points);
        HubNose::from_hub(&hub, hub.project(points[3]).0).expect("a nose")
    }

    #[test]
    fn distances_are_signed_and_limited() {
        let nose = nose();
        let at = |r: f64, z: f64| nose.nearer_than(Meridional { r, z }, 5.0).map(|(distance, _)| distance);
        assert!(at(5.0, 84.0).is_some_and(|d| (d - 2.0).abs() < 1e-9), "before the front plane");
        assert!(at(5.0, 81.0).is_some_and(|d| (d + 1.0).abs() < 1e-9), "behind it");
        assert!(at(29.0, 70.5).is_some_and(|d| (-1.0..-0.5).contains(&d)), "under the hub");
        assert!(at(33.0, 71.0).is_some_and(|d| (2.5..3.5).contains(&d)), "above it");
        assert!(at(36.0, 71.0).is_none() && at(5.0, 90.0).is_none(), "further away than asked");
    }
}
