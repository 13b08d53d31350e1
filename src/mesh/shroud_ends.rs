//! The beginning of a cover beside the blades: they may begin ahead of it, free in its eye. The shroud then
//! goes on along their tips, so that the sides have a border there.

use super::profile::FittedProfile;
use super::surface::MeshSurface;
use crate::geometry::{Meridional, MeridionalCurve, Point};

/// Number of points of a straight piece before the beginning of a curve.
const AHEAD: usize = 16;
/// Largest distance of a corner from the straight end of a shroud, as a share of the height of the channel,
/// with which it is a tip and not a foot.
const TIP: f64 = 0.25;
/// Share of the way to the foremost corner from which on a tip is foremost.
const FOREMOST: f64 = 0.9;
/// Lengths by which a shroud goes on, as shares of its length: by less the tips turn into leading edges.
const AHEAD_OF_IT: std::ops::Range<f64> = 0.02..0.5;
/// Smallest cosine of the angle at which it does.
const STRAIGHT: f64 = 0.7;

/// Lets the shroud go on ahead of its beginning, straight to the foremost tip of `blade`; `hub` is the curve
/// of the hub. Returns how far it is along the shroud, mm.
pub fn extend_ahead(shroud: &mut FittedProfile, hub: &[Meridional], blade: &MeshSurface) -> Option<f64> {
    let hub = MeridionalCurve::through(hub);
    let curve = MeridionalCurve::through(&shroud.points);
    // Distance ahead, height over the hub, and place.
    let ahead_of = |p: &Point| {
        let p = Meridional::from_point(p);
        let (t, off) = curve.project_past_ends(p);
        let over_hub = hub.project_past_ends(p).1.abs();
        (off.abs() < TIP * (off.abs() + over_hub)).then_some((-t, over_hub, p))
    };
    let tips: Vec<(f64, f64, Meridional)> = blade.points.iter().filter_map(ahead_of).collect();
    let ahead = tips.iter().map(|tip| tip.0).fold(0.0, f64::max);
    if !AHEAD_OF_IT.contains(&(ahead / curve.length())) {
        return None;
    }
    // A leading edge has corners below its tip.
    let foremost = tips.into_iter().filter(|tip| tip.0 > FOREMOST * ahead);
    let (_, _, tip) = foremost.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (begin, on) = (curve.point(0.0), curve.at(0.0).tangent);
    let forward = (begin.r - tip.r) * on.r + (begin.z - tip.z) * on.z;
    if forward < STRAIGHT * tip.distance(begin) {
        return None;
    }
    let before = (0..AHEAD).map(|k| tip.lerp(begin, k as f64 / AHEAD as f64));
    shroud.points = before.chain(shroud.points.iter().copied()).collect();
    Some(ahead)
}

/// The points of a curve with those of a straight piece of a length, mm, before its beginning.
pub fn gone_on(points: &[Meridional], length: f64) -> Vec<Meridional> {
    let curve = MeridionalCurve::through(points);
    let before = (0..AHEAD).map(|k| curve.point(length * (k as f64 / AHEAD as f64 - 1.0)));
    before.chain(points.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;

    #[test]
    fn a_shroud_goes_on_as_far_ahead_as_the_tips_do() {
        let line =
            |z: f64| (0..=8).map(|k| Meridional { r: 30.0 + 5.0 * f64::from(k), z }).collect::<Vec<_>>();
        let corner = |r: f64, z: f64| Point::new(r, 0.0, z);
        let blade = |from: f64| {
            let points = vec![corner(from, 1.0), corner(70.0, 1.0), corner(70.0, 10.0), corner(from, 10.5)];
            MeshSurface::from_mesh(&TriangleMesh { points, triangles: vec![[0, 1, 2], [0, 2, 3]] })
        };
        let shroud = || FittedProfile {
            points: line(10.0),
            max_deviation_mm: 0.0,
            worst_corner: Meridional::default(),
        };
        let mut longer = shroud();
        let ahead = extend_ahead(&mut longer, &line(0.0), &blade(25.0)).expect("5 mm ahead");
        assert!(
            (ahead - 5.0).abs() < 1e-6 && longer.points[0].distance(Meridional { r: 25.0, z: 10.5 }) < 1e-6
        );
        assert_eq!(extend_ahead(&mut shroud(), &line(0.0), &blade(29.8)), None);
    }
}
