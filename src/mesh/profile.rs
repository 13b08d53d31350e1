//! Meridional curves of hub and shroud from their meshes: the side that faces the flow, and the curve fitted
//! through its corners.

use std::collections::{HashSet, VecDeque};

use super::fit::SmoothFunction;
use super::meridional_points::meridional_points;
use super::nearest::MeridionalGrid;
use super::normals::ExactNormals;
use super::surface::{MeshSurface, SHARP};
use super::weld::NONE;
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve, norm2};
use crate::part::PartError;

/// Smallest share of the area of hub or shroud, without fillets, that has to be on its curve.
pub const MOSTLY: f64 = 0.5;
/// Smallest number of votes of a piece of the flow side, as a share of the largest number.
const VOTES: f64 = 0.2;
/// Smallest area of a piece of the flow side, as a share of that of the largest.
const PIECE: f64 = 0.005;
/// Distance of places on long edges of a hub or shroud, as a share of its largest radius, and their largest
/// number.
const NEAR_PLACES: f64 = 0.01;
const MAX_PLACES: usize = 400;
/// Number of blade corners that vote for the piece nearest to them.
const VOTERS: usize = 1000;
/// Largest number of cubic pieces of a curve.
const MAX_SPANS: usize = 240;
/// Largest number of rounds that remove the feet of fillets, the distance along the course within which a
/// lower point tells a foot, as a share of the curve, and how much lower, as a share of the tolerance.
const MAX_FOOT_ROUNDS: usize = 12;
const NEARBY: f64 = 0.01;
const FOOT: f64 = 0.02;
/// Axial way of blades, as a share of their radial one, below which they hardly come to the inlet, and the
/// share of the radius of their outlet from which on a disc is looked at.
const FLAT: f64 = 0.4;
const OUTER_DISC: f64 = 0.8;
/// Angles between a course and the radial direction that are tried, degrees: the first unless the walls turn
/// back on it.
const COURSES_DEG: [f64; 7] = [45.0, 30.0, 60.0, 20.0, 70.0, 10.0, 80.0];
/// Share of the area of a wall that turns back on its course with which another one is looked for, and share
/// of it that is left on a better one.
const TURNS_BACK: f64 = 0.05;
const BETTER: f64 = 0.2;
/// Smallest component across the course of the normal of a triangle that runs along it: a curve may turn
/// slightly beyond the axial or radial direction.
const ALONG: f64 = 0.2;
/// Points of a line nearer to each other than this share of its extent are one.
const CLOSE: f64 = 5e-4;
/// Circumferential component of the normal from which on a triangle is not part of a surface of revolution.
const MIN_CIRCUMFERENTIAL: f64 = 0.35;

/// The flow side of a hub or shroud.
pub struct FlowSide {
    /// Its corners, and points between those of long edges, mm.
    pub points: Vec<Meridional>,
    /// Indices of its triangles.
    pub triangles: Vec<usize>,
}

/// Which pieces of a surface are its flow side.
#[derive(Clone, Copy)]
pub struct PieceRule {
    /// Smallest number of votes of a piece, as a share of the largest number.
    pub share: f64,
    /// Smallest cosine of the angle between neighbouring triangles of a piece.
    pub min_cosine: f64,
    /// Whether it is only that of these pieces which goes along the blades furthest.
    pub is_alone: bool,
}

impl PieceRule {
    /// All smooth pieces beside the blades.
    pub const SEVERAL: Self = Self { share: VOTES, min_cosine: SHARP, is_alone: false };
    /// The smooth piece beside the blades.
    pub const ONE: Self = Self { share: 1.0, min_cosine: SHARP, is_alone: false };
}

/// A meridional curve and its largest deviation from the corners it was fitted to.
#[derive(Clone, Debug)]
pub struct FittedProfile {
    /// Points of the curve, inlet → outlet, mm.
    pub points: Vec<Meridional>,
    /// Largest distance of a corner from the curve, mm.
    pub max_deviation_mm: f64,
    /// The corner with the largest distance.
    pub worst_corner: Meridional,
}

/// The direction in which a channel runs from its inlet, near the axis, to its outlet: at 45° between the
/// axial and the radial direction, unless hub or shroud turn back on that. Every meridional curve of a radial
/// wheel runs within ± 90° of it and is therefore a function of the distance along it.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    along: Meridional,
    across: Meridional,
}

impl Course {
    /// The course of a wheel from the corners of its blades, and its hub: those triangles of `wheel` for
    /// which `is_hub` holds.
    ///
    /// Blades come closer to the axis on the side of the inlet. Where they hardly do, as plane blades on a
    /// disc, the inlet is on the side of the disc on which they stand.
    pub fn from_blades(blades: &[Meridional], wheel: &MeshSurface, is_hub: impl Fn(usize) -> bool) -> Self {
        let mut by_radius: Vec<Meridional> = blades.to_vec();
        by_radius.sort_by(|a, b| a.r.total_cmp(&b.r));
        let few = (by_radius.len() / 10).max(1).min(by_radius.len());
        let mean =
            |points: &[Meridional]| points.iter().map(|p| p.z).sum::<f64>() / points.len().max(1) as f64;
        let (inner, outer) = (&by_radius[..few], &by_radius[by_radius.len() - few..]);
        let mut rise = mean(outer) - mean(inner);
        let (innermost, disc) = (by_radius.first().map_or(0.0, |p| p.r), outer.last().map_or(0.0, |p| p.r));
        if rise.abs() < FLAT * (disc - innermost) {
            let (mut sum, mut area) = (0.0, 0.0);
            for t in (0..wheel.triangles.len()).filter(|&t| is_hub(t)) {
                for corner in wheel.triangles[t] {
                    let p = Meridional::from_point(&wheel.points[corner as usize]);
                    if p.r > OUTER_DISC * disc {
                        (sum, area) = (sum + wheel.area(t) * p.z, area + wheel.area(t));
                    }
                }
            }
            if area > 0.0 {
                let beside = by_radius.iter().filter(|p| p.r > OUTER_DISC * disc);
                let (low, high) =
                    beside.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.z), b.max(p.z)));
                rise = sum / area - 0.5 * (low + high);
            }
        }
        Self::at_angle(COURSES_DEG[0], rise)
    }

    /// The course at an angle to the radial direction, degrees, that runs as `rise` does along the axis.
    fn at_angle(degrees: f64, rise: f64) -> Self {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let along = Meridional { r: cos, z: sin.copysign(rise) };
        Self { along, across: Meridional { r: -along.z, z: along.r } }
    }

    /// This course, or the one on which the `walls` beside the `blades` do not turn back: where hub and
    /// shroud meet, one of them may run away from the other at the inlet, across the channel.
    pub fn along_walls(self, walls: &[&MeshSurface], blades: &[Meridional]) -> Self {
        let sides: Vec<(&MeshSurface, Vec<usize>)> =
            walls.iter().map(|wall| (*wall, beside_blades(wall, &self, blades, PieceRule::ONE))).collect();
        let back = |course: &Self| {
            sides.iter().map(|(wall, side)| course.share_back(wall, side)).fold(0.0, f64::max)
        };
        let own = back(&self);
        if own < TURNS_BACK {
            return self;
        }
        let others = COURSES_DEG[1..].iter().map(|degrees| Self::at_angle(*degrees, self.along.z));
        let rated = others.map(|course| (back(&course), course));
        let best = rated.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(back, _)| *back < BETTER * own);
        best.map_or(self, |(_, course)| course)
    }

    /// Share of the area of `triangles` that does not run along the course, but across it or back.
    fn share_back(&self, surface: &MeshSurface, triangles: &[usize]) -> f64 {
        let (mut all, mut along) = (0.0, [0.0; 2]);
        for &t in triangles {
            let (area, across) = (surface.area(t), self.normal_across(surface, t));
            all += area;
            if across.abs() > ALONG {
                along[usize::from(across > 0.0)] += area;
            }
        }
        1.0 - f64::max(along[0], along[1]) / f64::max(all, 1e-300)
    }

    /// Component across the course of the normal of triangle `t`.
    fn normal_across(&self, surface: &MeshSurface, t: usize) -> f64 {
        let (n, _) = meridional_normal(surface, t);
        n.r * self.across.r + n.z * self.across.z
    }

    /// Whether the inlet faces +Z.
    pub fn inlet_up(&self) -> bool {
        self.along.z <= 0.0
    }

    /// Coordinates of a point along the course and at right angles to it, mm.
    pub fn coordinates_of(&self, p: Meridional) -> (f64, f64) {
        (p.r * self.along.r + p.z * self.along.z, p.r * self.across.r + p.z * self.across.z)
    }

    /// The smallest and the largest distance of points along the course, mm.
    pub fn extent_of<'p>(&self, points: impl IntoIterator<Item = &'p Meridional>) -> (f64, f64) {
        let along = points.into_iter().map(|p| self.coordinates_of(*p).0);
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), x| (from.min(x), to.max(x)))
    }

    fn point(&self, x: f64, y: f64) -> Meridional {
        Meridional { r: x * self.along.r + y * self.across.r, z: x * self.along.z + y * self.across.z }
    }

    /// The curve along the side of `points` that faces away from `above`: through those within `tolerance`,
    /// mm, of their lower envelope, which those of fillets are above.
    pub fn fit_bottom(
        &self,
        points: &[Meridional],
        above: Meridional,
        tolerance: f64,
    ) -> Option<FittedProfile> {
        let sign = self.side_of(above, points);
        let turned_up = |(x, y): (f64, f64)| (x, sign * y);
        let pairs: Vec<(f64, f64)> = self.pairs(points).into_iter().map(turned_up).collect();
        let below = SmoothFunction::fit_below(&pairs, MAX_SPANS)?;
        let over = |(x, y): (f64, f64)| (y - below.at(x)) / norm2(1.0, below.slope(x));
        let on = points.iter().zip(&pairs).filter(|(_, pair)| over(**pair) < 0.5 * tolerance);
        let kept: Vec<Meridional> = on.map(|(p, _)| *p).collect();
        let profile = self
            .fit_curve(&kept)
            .filter(|profile| kept.len() >= 8 && profile.max_deviation_mm < tolerance)?;
        Some(self.without_feet(kept, profile, sign, tolerance))
    }

    /// The curve through all `points` but those at the feet of fillets on the side of `above`, which are
    /// within `tolerance`, mm, of it.
    pub fn fit_without_feet(
        &self,
        points: &[Meridional],
        above: Meridional,
        tolerance: f64,
    ) -> Option<FittedProfile> {
        let profile = self.fit_curve(points)?;
        let waves = FOOT * tolerance..tolerance;
        if !waves.contains(&profile.max_deviation_mm) {
            return Some(profile);
        }
        let sign = self.side_of(above, points);
        Some(self.without_feet(points.to_vec(), profile, sign, tolerance))
    }

    /// +1 or −1: the direction across the course from the middle of `points` to `above`.
    fn side_of(&self, above: Meridional, points: &[Meridional]) -> f64 {
        (self.coordinates_of(above).1 - self.coordinates_of(mean_point(points)).1).signum()
    }

    /// The curve through those of `points` that have none below them nearby: the lowest rows of corners of a
    /// fillet are within the tolerance of `profile`, but a curve that follows them waves.
    fn without_feet(
        &self,
        mut points: Vec<Meridional>,
        mut profile: FittedProfile,
        sign: f64,
        tolerance: f64,
    ) -> FittedProfile {
        points.sort_by(|a, b| self.coordinates_of(*a).0.total_cmp(&self.coordinates_of(*b).0));
        for _ in 0..MAX_FOOT_ROUNDS {
            let Some(curve) = SmoothFunction::fit(&self.pairs(&profile.points), MAX_SPANS) else { break };
            let over: Vec<(f64, f64)> =
                self.pairs(&points).into_iter().map(|(x, y)| (x, sign * (y - curve.at(x)))).collect();
            let (first, last) = (over[0].0, over[over.len() - 1].0);
            // The lowest point within reach of each: the front of a queue of candidates that rise.
            let (mut rising, mut entered) = (VecDeque::<usize>::new(), 0);
            let mut foot = vec![false; over.len()];
            for (i, (x, height)) in over.iter().enumerate() {
                // As far to one side as to the other, so that the ends of the curve stay.
                let reach = (NEARBY * (last - first)).min(x - first).min(last - x);
                while entered < over.len() && over[entered].0 <= x + reach {
                    while rising.back().is_some_and(|last| over[*last].1 >= over[entered].1) {
                        rising.pop_back();
                    }
                    rising.push_back(entered);
                    entered += 1;
                }
                while rising.front().is_some_and(|first| over[*first].0 < x - reach) {
                    rising.pop_front();
                }
                foot[i] = rising.front().is_some_and(|low| height - over[*low].1 > FOOT * tolerance);
            }
            let kept: Vec<Meridional> =
                points.iter().zip(&foot).filter(|(_, foot)| !**foot).map(|(p, _)| *p).collect();
            if kept.len() == points.len() || kept.len() < 8 {
                break;
            }
            match self.fit_curve(&kept).filter(|better| better.max_deviation_mm < tolerance) {
                Some(better) => (points, profile) = (kept, better),
                None => break,
            }
        }
        profile
    }

    fn pairs(&self, points: &[Meridional]) -> Vec<(f64, f64)> {
        points.iter().map(|p| self.coordinates_of(*p)).collect()
    }

    /// The polyline through all `points`, which keeps corners; of points nearer to each other than 1/2000 of
    /// their extent one is kept. It has no deviation of its own: whether it fits is judged by the share of
    /// the face on it.
    pub fn line_through(&self, points: &[Meridional]) -> Option<FittedProfile> {
        let mut line = points.to_vec();
        line.sort_by(|a, b| self.coordinates_of(*a).0.total_cmp(&self.coordinates_of(*b).0));
        let (first, last) = (*line.first()?, *line.last()?);
        let least = CLOSE * first.distance(last);
        line.dedup_by(|b, a| a.distance(*b) < least);
        (line.len() > 1).then_some(FittedProfile { points: line, max_deviation_mm: 0.0, worst_corner: first })
    }

    /// The least-squares curve through all `points`.
    pub fn fit_curve(&self, points: &[Meridional]) -> Option<FittedProfile> {
        let pairs = self.pairs(points);
        let function = SmoothFunction::fit(&pairs, MAX_SPANS)?;
        let mut profile =
            FittedProfile { points: Vec::new(), max_deviation_mm: 0.0, worst_corner: Meridional::default() };
        for (&(x, y), p) in pairs.iter().zip(points) {
            let slope = function.slope(x);
            let off = (y - function.at(x)).abs() / norm2(1.0, slope);
            if off > profile.max_deviation_mm {
                (profile.max_deviation_mm, profile.worst_corner) = (off, *p);
            }
        }
        let ends = function.ends();
        let middles = ends.windows(2).flat_map(|span| [span[0], 0.5 * (span[0] + span[1])]);
        profile.points = middles
            .chain(ends.last().copied())
            .map(|x| {
                let p = self.point(x, function.at(x));
                Meridional { r: p.r.max(0.0), z: p.z }
            })
            .collect();
        Some(profile)
    }
}

/// Mean of points.
pub fn mean_point(points: &[Meridional]) -> Meridional {
    let sum = points.iter().fold(Meridional::default(), |s, p| Meridional { r: s.r + p.r, z: s.z + p.z });
    let count = points.len().max(1) as f64;
    Meridional { r: sum.r / count, z: sum.z / count }
}

impl FittedProfile {
    /// Share of the area of `triangles` that is within `tolerance`, mm, of the curve.
    pub fn area_share_on_curve(&self, surface: &MeshSurface, triangles: &[usize], tolerance: f64) -> f64 {
        let curve = MeridionalCurve::through(&self.points);
        let on = |i: u32| {
            let corner = Meridional::from_point(&surface.points[i as usize]);
            curve.project(corner).1.abs() < tolerance
        };
        let (mut on_curve, mut all) = (0.0, 0.0);
        for &t in triangles {
            let area = surface.area(t);
            all += area;
            if surface.triangles[t].iter().all(|i| on(*i)) {
                on_curve += area;
            }
        }
        on_curve / f64::max(all, 1e-300)
    }
}

/// A triangle's normal in the meridional plane, and its circumferential component.
pub fn meridional_normal(surface: &MeshSurface, t: usize) -> (Meridional, f64) {
    let (c, n) = (surface.centre(t), surface.normals[t]);
    let r = norm2(c.x, c.y).max(1e-9);
    let across = (n.y * c.x - n.x * c.y) / r;
    (Meridional { r: (n.x * c.x + n.y * c.y) / r, z: n.z }, across)
}

/// How far a point is over the plane of a triangle, in the meridional plane, mm: positive on the side of its
/// normal.
pub fn towards(surface: &MeshSurface, t: usize, p: Meridional) -> f64 {
    let (n, _) = meridional_normal(surface, t);
    let centre = Meridional::from_point(&surface.centre(t));
    n.r * (p.r - centre.r) + n.z * (p.z - centre.z)
}

/// The flow side of a hub or shroud: the smooth pieces nearest to the blades, found by votes of blade
/// corners that the `rule` takes.
///
/// # Errors
/// Fails when no surface of revolution is beside the blades.
pub fn find_flow_side(
    surface: &MeshSurface,
    course: &Course,
    blades: &[Meridional],
    (exact, rule): (&ExactNormals, PieceRule),
    name: &str,
) -> Result<FlowSide, PartError> {
    let mut triangles = beside_blades(surface, course, blades, rule);
    triangles.retain(|&t| follows(course, surface, t));
    let points = meridional_points(surface, &triangles, exact, |p| course.coordinates_of(p).0);
    if points.len() < 8 {
        return Err(PartError::new(
            ErrorCode::NotRevolved,
            0,
            format!("the {name} has no surface of revolution beside the blades"),
            format!("check which mesh is the {name}, and the axis of rotation (--rotation-axis)"),
        ));
    }
    Ok(FlowSide { points, triangles })
}

/// The triangles of the smooth pieces of a surface that are nearest to the blades, by votes of blade corners
/// that the `rule` takes.
fn beside_blades(
    surface: &MeshSurface,
    course: &Course,
    blades: &[Meridional],
    rule: PieceRule,
) -> Vec<usize> {
    // Fillets and other triangles that are not of revolution are ignored.
    let turned: Vec<bool> = (0..surface.triangles.len())
        .map(|t| meridional_normal(surface, t).1.abs() < MIN_CIRCUMFERENTIAL)
        .collect();
    let smooth = |a: usize, b: usize| {
        turned[a] && turned[b] && surface.normals[a].dot(&surface.normals[b]).abs() > rule.min_cosine
    };
    let (group, count) = surface.groups(smooth);
    let corners: Vec<Meridional> = surface.points.iter().map(Meridional::from_point).collect();
    // (corner, group, triangle), sorted; a corner at an edge belongs to several groups.
    let mut groups_of: Vec<(u32, u32, usize)> = Vec::with_capacity(3 * group.len());
    for (t, g) in group.iter().enumerate().filter(|(t, _)| turned[*t]) {
        groups_of.extend(surface.triangles[t].map(|i| (i, *g, t)));
    }
    // Discs and cones have corners at their ends only: places on their edges tell that they are near.
    let mut places = corners.clone();
    let spacing = NEAR_PLACES * corners.iter().map(|p| p.r).fold(0.0, f64::max);
    let mut seen: HashSet<(u32, i64, i64)> = HashSet::new();
    for (t, g) in group.iter().enumerate().filter(|(t, _)| turned[*t]) {
        for k in 0..3 {
            let [a, b] = [k, (k + 1) % 3].map(|k| corners[surface.triangles[t][k] as usize]);
            let count = ((a.distance(b) / spacing) as usize).min(MAX_PLACES);
            for p in (1..count).map(|m| a.lerp(b, m as f64 / count as f64)) {
                let cell = [p.r, p.z].map(|x| (2.0 * x / spacing).round() as i64);
                if seen.insert((*g, cell[0], cell[1])) {
                    groups_of.push((places.len() as u32, *g, t));
                    places.push(p);
                }
            }
        }
    }
    groups_of.sort_unstable();
    groups_of.dedup_by_key(|(corner, group, _)| (*corner, *group));
    let (outward, middle) = (surface.outward(), mean_point(blades));
    let mut areas = vec![0.0; count];
    for (t, g) in group.iter().enumerate() {
        areas[*g as usize] += surface.area(t);
    }
    // A splinter of a blade's foot may have the only corners near its tip, a wall of a bolt hole those far
    // and wide.
    let least = PIECE * areas.iter().copied().fold(0.0, f64::max);
    let mut votes = vec![0_usize; count];
    let near = MeridionalGrid::from_points(&places);
    let stride = blades.len().div_ceil(VOTERS).max(1);
    for p in blades.iter().step_by(stride) {
        let Some(corner) = near.nearest(*p) else { continue };
        let from = groups_of.partition_point(|(c, ..)| *c < corner);
        let at = places[corner as usize];
        // At an edge the face that the blade stands on, not the rim that it ends at.
        let facing = |t: usize| {
            let (n, _) = meridional_normal(surface, t);
            (n.r * (p.r - at.r) + n.z * (p.z - at.z)).abs()
        };
        let here = groups_of[from..].iter().take_while(|(c, ..)| *c == corner);
        let here = here.filter(|(_, g, _)| areas[*g as usize] >= least);
        let here =
            here.filter(|(.., t)| outward.is_none_or(|sign| sign * towards(surface, *t, middle) > 0.0));
        if let Some((_, g, _)) = here.max_by(|a, b| facing(a.2).total_cmp(&facing(b.2))) {
            votes[*g as usize] += 1;
        }
    }
    let most = votes.iter().copied().max().unwrap_or(0);
    let largest = (0..count).filter(|g| votes[*g] > 0).map(|g| areas[g]).fold(0.0, f64::max);
    let is_chosen =
        |g: usize| votes[g] as f64 >= rule.share * most.max(1) as f64 && areas[g] >= PIECE * largest;
    let mut chosen: Vec<bool> = (0..count).map(is_chosen).collect();
    if rule.is_alone {
        let (from, to) = course.extent_of(blades);
        let along = |g: usize| {
            let own = groups_of.iter().filter(|(_, of, _)| *of as usize == g);
            let (first, last) = course.extent_of(own.map(|(place, ..)| &places[*place as usize]));
            last.min(to) - first.max(from)
        };
        let longest = (0..count).filter(|g| chosen[*g]).max_by(|a, b| along(*a).total_cmp(&along(*b)));
        chosen.iter_mut().enumerate().for_each(|(g, is_chosen)| *is_chosen = Some(g) == longest);
    }
    let is_beside = |t: usize| group[t] != NONE && chosen[group[t] as usize] && turned[t];
    (0..group.len()).filter(|&t| is_beside(t)).collect()
}

/// Whether a triangle runs along the course, as opposed to a rim or a bore.
fn follows(course: &Course, surface: &MeshSurface, t: usize) -> bool {
    course.normal_across(surface, t).abs() > ALONG
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::mesh::TriangleMesh;

    #[test]
    fn a_course_follows_a_wall_that_turns_back_on_it() {
        // Half of a wall of revolution through the points of a line, and places of blades over it.
        let wall = |line: &dyn Fn(f64) -> (f64, f64)| {
            let point = |i: u32, k: u32| {
                let ((r, z), angle) = (line(f64::from(i) / 20.0), 0.1 * f64::from(k));
                Point::new(r * angle.cos(), r * angle.sin(), z)
            };
            let points = (0..=20).flat_map(|i| (0..=30).map(move |k| point(i, k))).collect();
            let cell = |i: u32, k: u32| {
                let (a, b) = (31 * i + k, 31 * (i + 1) + k);
                [[a, b, b + 1], [a, b + 1, a + 1]]
            };
            let triangles = (0..20).flat_map(|i| (0..30).flat_map(move |k| cell(i, k))).collect();
            MeshSurface::from_mesh(&TriangleMesh { points, triangles })
        };
        let course_over = |line: &dyn Fn(f64) -> (f64, f64)| {
            let surface = wall(line);
            let places: Vec<Meridional> = (0..=40)
                .map(|i| line(f64::from(i) / 40.0))
                .flat_map(|(r, z)| [1.0, 5.0].map(|over| Meridional { r, z: z + over }))
                .collect();
            Course::from_blades(&places, &surface, |_| true).along_walls(&[&surface], &places)
        };
        // A quarter of a circle is along the usual course, whichever way it bends.
        let quarter = |x: f64| (60.0 - 40.0 * (1.5 * x).cos(), 40.0 * (1.5 * x).sin());
        assert!((course_over(&quarter).along.r - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-9);
        // A wall that first runs down, away from the outlet, is not.
        let drop = |x: f64| (60.0 + 60.0 * x, if x < 0.3 { -100.0 * x } else { -30.0 + 60.0 * (x - 0.3) });
        let course = course_over(&drop);
        let along = |x: f64| course.coordinates_of(Meridional { r: drop(x).0, z: drop(x).1 }).0;
        assert!((0..20).all(|i| along(0.05 * f64::from(i + 1)) > along(0.05 * f64::from(i))));
    }

    #[test]
    fn the_feet_of_fillets_do_not_make_a_curve_wave() {
        // A quarter of an ellipse, and here and there rows of corners up to 0.018 mm above it.
        let hub =
            |a: f64, h: f64| Meridional { r: 50.0 - (38.0 - h) * a.cos(), z: 36.0 - (32.0 - h) * a.sin() };
        let points: Vec<Meridional> = (0..=1200)
            .flat_map(|i| {
                let a = f64::from(i) / 1200.0 * std::f64::consts::FRAC_PI_2;
                let rows = [0.0, 0.004, 0.011, 0.018];
                let count = if i % 3 == 0 { 1 } else { 1 + (i / 100 % 4) as usize };
                // Only every third place has a corner on the hub itself.
                rows.into_iter().take(count).skip(usize::from(count > 1)).map(move |h| hub(a, h))
            })
            .collect();
        let course = Course::from_blades(&points, &MeshSurface::default(), |_| true);
        let above = Meridional { r: 30.0, z: 30.0 };
        let off = |profile: &FittedProfile| {
            let curve = MeridionalCurve::through(&profile.points);
            (0..=400)
                .map(|i| curve.project(hub(f64::from(i) / 400.0 * std::f64::consts::FRAC_PI_2, 0.0)).1.abs())
                .fold(0.0, f64::max)
        };
        let all = off(&course.fit_curve(&points).expect("a curve"));
        let without = off(&course.fit_without_feet(&points, above, 0.05).expect("a curve"));
        assert!(all > 0.004 && without < 0.001, "{all} and {without} mm");
    }
}
