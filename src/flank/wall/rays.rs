//! Sweep of a tool axis, taken from the centre of the round end on, from station to station.

use super::bounds::{bend_of_distance, lower_bound_between};
use crate::geometry::{Point, Vector, search};

/// Travel from or to a missing ray, mm: more than any distance on a part.
const MISSING: f64 = 1e6;

/// A tool axis from the centre of the round end on.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisRay {
    /// Point of the axis near the hub, unit direction, and position of the centre along it from there, mm.
    pub(super) low: Point,
    pub(super) axis: Vector,
    pub(super) from: f64,
}

impl AxisRay {
    fn distance(&self, point: &Point) -> f64 {
        let d = point - self.low;
        (d - self.axis * d.dot(&self.axis).max(self.from)).norm()
    }

    /// The ray to which a controller interpolates between this one and `next`.
    fn towards(&self, next: &Self, share: f64) -> Self {
        Self {
            low: self.low + (next.low - self.low) * share,
            axis: (self.axis + (next.axis - self.axis) * share).normalize(),
            from: self.from + (next.from - self.from) * share,
        }
    }

    /// Distance of a point, mm, and its rate where the ray changes at the rate of `motion`.
    fn distance_and_rate(&self, point: &Point, motion: &RayMotion) -> (f64, f64) {
        let d = point - self.low;
        let foot = d.dot(&self.axis);
        let along = foot.max(self.from);
        let away = d - self.axis * along;
        let distance = away.norm();
        let mut nearing = motion.low + motion.turn(&self.axis) * along;
        if foot < self.from {
            nearing += self.axis * motion.from;
        }
        (distance, -away.dot(&nearing) / distance.max(1e-12))
    }
}

/// Change of a ray from a station to the next.
#[derive(Clone, Copy)]
struct RayMotion {
    low: Vector,
    /// Difference of the unit directions.
    axis: Vector,
    from: f64,
    /// Bound on the negative second derivative of the distance of a point of the wall by the share of the
    /// way, mm.
    bend: f64,
}

impl RayMotion {
    /// The motion from `ray` to `next`; points of the wall are at most `far` mm from the low point of either.
    fn new(ray: &AxisRay, next: &AxisRay, far: f64) -> Self {
        let (low, axis, from) = (next.low - ray.low, next.axis - ray.axis, next.from - ray.from);
        let bend = bend_of_distance(low.norm() + from.abs(), axis.norm(), far);
        Self { low, axis, from, bend }
    }

    /// Derivative of the unit direction where it is `axis`.
    fn turn(&self, axis: &Vector) -> Vector {
        self.axis - axis * axis.dot(&self.axis)
    }
}

/// The sweep of an axis from ray to ray.
pub(super) struct RaySweep {
    /// By station; `None` where the cutter misses the layer.
    rays: Vec<Option<AxisRay>>,
    /// By station, the way to the next one; `None` beside a missing ray.
    motions: Vec<Option<RayMotion>>,
    /// By station, the most by which the rays from the first on may have come nearer to a point of the wall,
    /// mm; beside a missing ray [`MISSING`].
    travel: Vec<f64>,
    /// The most by which a ray between two stations may be nearer to a point of the wall than these, mm.
    max_dip: f64,
}

impl RaySweep {
    /// The sweep of `rays` along a wall with these `points`.
    pub(super) fn new(rays: Vec<Option<AxisRay>>, points: &[Point]) -> Self {
        let centre = points.first().copied().unwrap_or_else(Point::origin);
        let radius = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let far = |ray: &AxisRay| ray.from.max((ray.low - centre).norm() + radius);
        let mut travel = vec![0.0; rays.len()];
        let mut motions = vec![None; rays.len()];
        let mut max_dip = 0.0f64;
        for k in 1..rays.len() {
            let step = match (&rays[k - 1], &rays[k]) {
                // The point of the next ray that is nearest to a point of the wall is at most that far along
                // it.
                (Some(a), Some(b)) => {
                    let motion = RayMotion::new(a, b, far(a).max(far(b)));
                    motions[k - 1] = Some(motion);
                    let step = motion.low.norm() + motion.axis.norm() * far(b) + motion.from.abs();
                    max_dip = max_dip.max(0.5 * step);
                    step
                }
                _ => MISSING,
            };
            travel[k] = travel[k - 1] + step;
        }
        Self { rays, motions, travel, max_dip }
    }

    /// Distance of a point at station `from`, mm, where it is less than `limit`; else `limit` or more.
    /// Infinite if no station has a ray.
    pub(super) fn distance_below(&self, limit: f64, from: usize, point: &Point) -> f64 {
        let rays = &self.rays;
        let at = |k: usize| rays[k].as_ref().map_or(f64::INFINITY, |ray| ray.distance(point));
        // Inclined axes have several that are locally nearest. Those that cannot have come near enough yet
        // are passed over.
        let (mut near, mut distance) = (from, at(from));
        let mut enough = distance.min(limit + self.max_dip);
        let mut k = 0;
        while k < rays.len() {
            let here = at(k);
            if here < distance {
                (near, distance) = (k, here);
                enough = enough.min(here);
            }
            let reached = self.travel[k] + if here.is_finite() { here - enough } else { 0.0 };
            k += 1;
            while k < rays.len() && self.travel[k] < reached {
                k += 1;
            }
        }
        if distance.is_infinite() {
            return distance;
        }
        let around = |k: usize| [k.checked_sub(1), Some(k)].into_iter().flatten();
        let own = (from != near).then(|| around(from)).into_iter().flatten();
        for k in around(near).chain(own) {
            let Some(motion) = &self.motions[k] else { continue };
            let (Some(a), Some(b)) = (&rays[k], &rays[k + 1]) else { continue };
            let ends = [a, b].map(|ray| ray.distance_and_rate(point, motion));
            if lower_bound_between(ends, motion.bend) < distance.min(limit) {
                let least = search::minimum(|share| a.towards(b, share).distance(point), 0.0, 1.0, 1e-3).1;
                distance = distance.min(least);
            }
        }
        distance
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_ray() -> impl Strategy<Value = AxisRay> {
        let near = || -3.0..3.0_f64;
        ((near(), near(), near()), (-0.3..0.3_f64, -0.3..0.3_f64), 0.0..4.0_f64).prop_map(
            |(low, axis, from)| AxisRay {
                low: Point::new(low.0, low.1, low.2),
                axis: Vector::new(axis.0, axis.1, 1.0).normalize(),
                from,
            },
        )
    }

    fn any_point() -> impl Strategy<Value = Point> {
        (-6.0..6.0_f64, -6.0..6.0_f64, -2.0..20.0_f64).prop_map(|(x, y, z)| Point::new(x, y, z))
    }

    proptest! {
        /// The tangents at both ends, less what turning takes, bound the distance from below.
        #[test]
        fn no_ray_between_two_is_nearer_than_the_bound(a in any_ray(), b in any_ray(), point in any_point()) {
            let far = [a, b].map(|ray| (point - ray.low).norm().max(ray.from)).into_iter().fold(0.0, f64::max);
            let motion = RayMotion::new(&a, &b, far + (b.low - a.low).norm());
            let ends = [&a, &b].map(|ray| ray.distance_and_rate(&point, &motion));
            let bound = lower_bound_between(ends, motion.bend);
            let at = |k: i32| a.towards(&b, f64::from(k) / 200.0).distance(&point);
            let least = (0..=200).map(at).fold(f64::INFINITY, f64::min);
            prop_assert!(bound <= least + 1e-9, "{} of {}", bound, least);
        }

        /// The rates are those of the distance.
        #[test]
        fn rates_are_differences(a in any_ray(), b in any_ray(), point in any_point()) {
            let motion = RayMotion::new(&a, &b, 20.0);
            let step = 1e-6;
            let (here, rate) = a.distance_and_rate(&point, &motion);
            prop_assume!(here > 0.1 && ((point - a.low).dot(&a.axis) - a.from).abs() > 1e-3);
            let there = a.towards(&b, step).distance(&point);
            prop_assert!(((there - here) / step - rate).abs() < 1e-3, "{} of {}", (there - here) / step, rate);
        }

        /// A limit takes nothing from a distance below it.
        #[test]
        fn distances_below_a_limit_do_not_depend_on_it(
            rays in prop::collection::vec(prop::option::weighted(0.9, any_ray()), 2..40),
            point in any_point(),
            from in 0.0..1.0_f64,
            spare in -2.0..2.0_f64,
        ) {
            let from = (from * rays.len() as f64) as usize;
            let sweep = RaySweep::new(rays, &[point]);
            let whole = sweep.distance_below(f64::INFINITY, from, &point);
            let limit = whole + spare;
            let limited = sweep.distance_below(limit, from, &point);
            if spare > 0.0 {
                prop_assert_eq!(limited, whole);
            } else if limit.is_finite() {
                prop_assert!(limited >= limit);
            }
        }
    }
}
