//! Hub and shroud as a file gives them, put right where it clearly has something else: curves that run from
//! outlet to inlet, and the profile of the hub's whole body, with bore, rim and back, of which the run
//! between corners that is nearest to the shroud is the side towards the blades.

use std::f64::consts::FRAC_PI_4;

use super::description::{BladeDescription, CurveDescription};
use crate::geometry::{Meridional, MeridionalCurve};

/// Share of the distance between the ends of a section by which its radius has to rise for it to tell the
/// direction of a curve.
const CLEAR_RISE: f64 = 0.1;
/// Share of a curve's length by which blades have to run against it for it to run from outlet to inlet.
const CLEARLY_BACK: f64 = 0.05;

/// Turn at a point from which on it is a corner of the profile, rad.
const CORNER: f64 = FRAC_PI_4;
/// Share of the largest radius within which a point is at the rim.
const AT_RIM: f64 = 1e-6;
/// Share of the largest radius by which the side towards the blades rises at least.
const MIN_RISE: f64 = 0.1;
/// The side towards the blades is nearer to the shroud than this share of the distance of any other.
const NEARER: f64 = 0.7;
/// Number of points of the shroud from which distances are measured.
const LOOKS: usize = 40;

/// Whether `curve`, a hub or shroud, clearly runs from outlet to inlet: against the blade. Sections tell by
/// the one nearest to the curve; a blade of camber lines runs along the whole curve, which has to lead
/// outwards.
pub(super) fn runs_backwards(curve: &MeridionalCurve, blade: &BladeDescription) -> bool {
    let BladeDescription::Sections { suction, pressure, .. } = blade else {
        let (start, end) = (curve.point(0.0), curve.point(curve.length()));
        return start.r - end.r > CLEAR_RISE * curve.length();
    };
    let ends = suction.iter().chain(pressure).filter_map(|section| {
        let (first, last) =
            (Meridional::from_point(section.first()?), Meridional::from_point(section.last()?));
        let (inner, outer) = if first.r < last.r { (first, last) } else { (last, first) };
        (outer.r - inner.r > CLEAR_RISE * inner.distance(outer)).then(|| {
            let ((t, off), (u, beside)) = (curve.project(inner), curve.project(outer));
            (off.abs() + beside.abs(), t - u)
        })
    });
    let nearest = ends.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.is_some_and(|(_, back)| back > CLEARLY_BACK * curve.length())
}

/// The curve in the other direction.
pub(super) fn reversed(curve: &CurveDescription) -> CurveDescription {
    match curve {
        CurveDescription::Points(points) => CurveDescription::Points(points.iter().rev().copied().collect()),
        CurveDescription::BSpline { control, degree, knots } => {
            let ends = knots.first().zip(knots.last()).map_or(0.0, |(a, b)| a + b);
            CurveDescription::BSpline {
                control: control.iter().rev().copied().collect(),
                degree: *degree,
                knots: knots.iter().rev().map(|k| ends - k).collect(),
            }
        }
    }
}

/// What a hub's points are.
pub(super) enum HubProfile {
    /// A curve along the channel.
    Channel,
    /// A profile of the body; these points of it are the side towards the blades.
    Body(Vec<Meridional>),
    /// A profile of the body of which it is not certain which run is meant; its largest radius, mm.
    Unclear(f64),
}

/// Tells whether `points` run past the rim around a corner, and which of them lie along the channel below
/// `shroud`.
pub(super) fn hub_profile(points: &[Meridional], shroud: &MeridionalCurve) -> HubProfile {
    let rim = points.iter().map(|p| p.r).fold(0.0, f64::max);
    let mut points = points.to_vec();
    let closed = points.len() > 3 && points[0].distance(points[points.len() - 1]) < AT_RIM * rim;
    if closed {
        points.pop();
    }
    let n = points.len();
    let turns = |i: usize| {
        if !closed && (i == 0 || i + 1 == n) {
            return false;
        }
        let (a, b, c) = (points[(i + n - 1) % n], points[i], points[(i + 1) % n]);
        let (into, out) = ((b.r - a.r, b.z - a.z), (c.r - b.r, c.z - b.z));
        let turn = (into.0 * out.1 - into.1 * out.0).atan2(into.0 * out.0 + into.1 * out.1);
        turn.abs() > CORNER
    };
    let corners: Vec<usize> = (0..n).filter(|&i| turns(i)).collect();
    let at_rim = |p: &Meridional| p.r > rim * (1.0 - AT_RIM);
    if !corners.iter().any(|&i| at_rim(&points[i])) {
        return HubProfile::Channel;
    }
    // Runs from corner to corner; those of an open profile also begin and end at its ends.
    let mut bounds = corners;
    if closed {
        let around = bounds[0] + n;
        bounds.push(around);
    } else {
        bounds.insert(0, 0);
        bounds.push(n - 1);
    }
    bounds.dedup();
    let run = |pair: &[usize]| (pair[0]..=pair[1]).map(|i| points[i % n]).collect::<Vec<_>>();
    let rises = |run: &Vec<Meridional>| {
        let inner = run.iter().map(|p| p.r).fold(f64::INFINITY, f64::min);
        run.iter().any(at_rim) && rim - inner > MIN_RISE * rim
    };
    let away = |run: &[Meridional]| {
        let from = |k: usize| {
            let p = shroud.point(shroud.length() * k as f64 / LOOKS as f64);
            let distances = run.windows(2).map(|w| p.nearest_on_segment(w[0], w[1]).0);
            distances.fold(f64::INFINITY, f64::min)
        };
        (0..=LOOKS).map(from).sum::<f64>()
    };
    let runs = bounds.windows(2).map(run).filter(rises);
    let mut runs: Vec<(f64, Vec<Meridional>)> = runs.map(|run| (away(&run), run)).collect();
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let clear = match (runs.first(), runs.get(1)) {
        (Some(first), Some(second)) => first.0 < NEARER * second.0,
        (first, _) => first.is_some(),
    };
    if !clear {
        return HubProfile::Unclear(rim);
    }
    HubProfile::Body(runs.swap_remove(0).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(points: &[(f64, f64)]) -> Vec<Meridional> {
        points.iter().map(|&(r, z)| Meridional { r, z }).collect()
    }

    /// A quarter of an ellipse from the inlet to the rim.
    fn arc(inner: f64, height: f64, rim: f64) -> Vec<Meridional> {
        (0..=20)
            .map(|i| {
                let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(i) / 20.0).sin_cos();
                Meridional { r: rim - (rim - inner) * cos, z: height * (1.0 - sin) }
            })
            .collect()
    }

    #[test]
    fn the_side_towards_the_shroud_is_found_whichever_way_the_profile_runs() {
        let flow = arc(20.0, 60.0, 80.0);
        let shroud =
            arc(45.0, 60.0, 80.0).iter().map(|p| Meridional { r: p.r, z: p.z + 8.0 }).collect::<Vec<_>>();
        let shroud = MeridionalCurve::through(&shroud);
        let mut body = at(&[(10.0, 60.0)]);
        body.extend(&flow);
        body.extend(at(&[(80.0, -5.0), (40.0, -9.0), (10.0, -9.0)]));
        let mut ring = body.clone();
        ring.push(body[0]);
        let back: Vec<Meridional> = body.iter().rev().copied().collect();
        let mut from_the_middle = ring.clone();
        from_the_middle.pop();
        from_the_middle.rotate_left(9);
        from_the_middle.push(from_the_middle[0]);
        let count = flow.len();
        for profile in [body, ring, back, from_the_middle] {
            let HubProfile::Body(found) = hub_profile(&profile, &shroud) else { panic!("a body") };
            let (first, last) = (found[0].r.min(found[count - 1].r), found[0].r.max(found[count - 1].r));
            assert_eq!((found.len(), first, last), (count, 20.0, 80.0));
        }
        assert!(matches!(hub_profile(&flow, &shroud), HubProfile::Channel));
        // A profile of straight runs on both sides of the shroud.
        let plate = at(&[(10.0, 5.0), (80.0, 5.0), (80.0, -5.0), (10.0, -5.0)]);
        let middle = MeridionalCurve::through(&at(&[(20.0, 0.0), (50.0, 0.0), (80.0, 0.0)]));
        assert!(matches!(hub_profile(&plate, &middle), HubProfile::Unclear(rim) if rim == 80.0));
    }
}
