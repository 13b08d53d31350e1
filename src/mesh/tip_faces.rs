//! The shroud of an open wheel by the tip faces of its blades, where the file knows faces: of the faces of a
//! blade whose normals hardly turn about the axis, leading and trailing edge begin at the hub and stand
//! across the channel, and the faces of the tip do neither. Their corners reach up to both edges, which the
//! border of the blade in the meridional plane does not tell from a tip that merges smoothly with them.

use std::collections::BTreeMap;

use super::profile::{Course, FittedProfile, meridional_normal};
use super::surface::MeshSurface;
use super::tip_border::tip_extent;
use super::weld::NONE;
use crate::geometry::{Meridional, MeridionalCurve};

/// Smallest height over the hub of a tip face, as a share of that of the blade.
const OFF_HUB: f64 = 0.1;
/// Largest mean circumferential component of the normals of a tip face; those of sides have more.
const MERIDIONAL: f64 = 0.5;
/// Smallest cosine between the mean normals of a tip face and of the hub below it.
const ALONG: f64 = 0.34;
/// Largest part of the tip's border without tip faces at either end, as a share of it.
const MISSING: f64 = 0.05;
/// Cosine between tip and hub below which a tip has turned into leading or trailing edge: the curve ends
/// there.
const TURNED_AWAY: f64 = 0.42;
/// Part of the curve at either end, as a share of it, over which it turns so, and cosine of its turn over
/// this part above which it goes on along the channel.
const NEAR_END: f64 = 0.15;
const GOES_ON: f64 = 0.85;
/// Fewest corners that a curve is fitted through.
const FEWEST: usize = 8;

/// Sums over the triangles of a face, weighted by area, and its smallest height over the hub.
struct FaceSums {
    area: f64,
    circumferential: f64,
    /// Components of the normal of either sign along the hub's normal, at right angles to it, and their
    /// product: a mean direction whatever the signs.
    squares: [f64; 3],
    min_height: f64,
}

/// The meridional curve through the tip faces of `blade` over the hub; `None` where the file does not tell
/// them, or they do not make up the tip.
pub fn fit_tip_faces(blade: &MeshSurface, hub: &[Meridional], course: &Course) -> Option<FittedProfile> {
    let corners: Vec<Meridional> = blade.points.iter().map(Meridional::from_point).collect();
    let curve = MeridionalCurve::through(hub).with_outer_side_towards_most(&corners);
    let places: Vec<(f64, f64)> = corners.iter().map(|p| curve.project(*p)).collect();
    let height = places.iter().map(|p| p.1).fold(0.0, f64::max);
    let mut faces: BTreeMap<u32, FaceSums> = BTreeMap::new();
    for (t, triangle) in blade.triangles.iter().enumerate() {
        let face = blade.faces[t];
        if face == NONE {
            continue;
        }
        let none =
            || FaceSums { area: 0.0, circumferential: 0.0, squares: [0.0; 3], min_height: f64::INFINITY };
        let sums = faces.entry(face).or_insert_with(none);
        let (area, (normal, across)) = (blade.area(t), meridional_normal(blade, t));
        let below = curve.at(places[triangle[0] as usize].0).normal;
        let (up, beside) = (normal.r * below.r + normal.z * below.z, normal.z * below.r - normal.r * below.z);
        sums.area += area;
        sums.circumferential += area * across.abs();
        for (sum, product) in sums.squares.iter_mut().zip([up * up, beside * beside, up * beside]) {
            *sum += area * product;
        }
        let lowest = triangle.iter().map(|i| places[*i as usize].1).fold(f64::INFINITY, f64::min);
        sums.min_height = sums.min_height.min(lowest);
    }
    let is_tip = |sums: &FaceSums| {
        let [uu, bb, ub] = sums.squares;
        let lean = 0.5 * (2.0 * ub).atan2(uu - bb);
        sums.min_height > OFF_HUB * height
            && sums.circumferential < MERIDIONAL * sums.area
            && lean.cos() > ALONG
    };
    let mut on_tip = vec![false; corners.len()];
    for (t, triangle) in blade.triangles.iter().enumerate() {
        if faces.get(&blade.faces[t]).is_some_and(is_tip) {
            triangle.iter().for_each(|i| on_tip[*i as usize] = true);
        }
    }
    let tips: Vec<Meridional> =
        corners.iter().zip(&on_tip).filter(|(_, on_tip)| **on_tip).map(|(p, _)| *p).collect();
    if tips.len() < FEWEST {
        return None;
    }
    if let Some((low, high)) = tip_extent(blade, hub, course) {
        let (from, to) = course.extent_of(&tips);
        let slack = MISSING * (high - low);
        if from > low + slack || to < high - slack {
            return None;
        }
    }
    let mut fit = course.fit_curve(&tips)?;
    let fitted = MeridionalCurve::through(&fit.points);
    let inner = NEAR_END * fitted.length();
    let runs_along = |p: &Meridional| {
        let t = fitted.project(*p).0;
        let (tangent, along) = (fitted.at(t).tangent, curve.at(curve.project(*p).0).tangent);
        // Below a straight tip, too, the nearest place of the hub may be on a part that runs across.
        let before = fitted.at(t.clamp(inner, fitted.length() - inner)).tangent;
        tangent.r * along.r + tangent.z * along.z > TURNED_AWAY
            || tangent.r * before.r + tangent.z * before.z > GOES_ON
    };
    let first = fit.points.iter().position(runs_along)?;
    let last = fit.points.iter().rposition(runs_along)?;
    fit.points = fit.points[first..=last].to_vec();
    (fit.points.len() >= FEWEST).then_some(fit)
}
