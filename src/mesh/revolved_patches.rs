//! Hub and cover of a wheel given as one mesh: the large patches of triangles about the axis with the longest
//! common borders with other faces.

use std::collections::HashMap;

use super::meridional_points::{meridional_points, straight_points};
use super::normals::ExactNormals;
use super::profile::{Course, mean_point, meridional_normal, towards};
use super::revolved_face::{FaceShape, RevolvedFace, curve_of};
use super::round::{TURNED, radii};
use super::surface::MeshSurface;
use super::weld::NONE;
use crate::geometry::{Meridional, MeridionalCurve};

/// Smallest share of the area of a face of revolution that is turned.
const TURNED_FACE: f64 = 0.95;
/// Distance from the hub's curve within which a corner is on the hub: mm, and share of the rim radius.
const ON_HUB: (f64, f64) = (0.02, 2e-4);
/// Smallest weight (area × border length) of the lighter one of hub and cover, as a share of the heavier one.
const COVER: f64 = 0.05;
/// Distance of places beside a face that tell its outer side, as a share of the rim radius: chords of
/// triangles are nearer to it.
pub(super) const ASIDE: f64 = 0.02;
/// Patches of one face have the same extent in the meridional plane within this many times the tolerance.
const ALIKE: f64 = 4.0;
/// Mean height of the middle of the blades over the planes of a face's triangles, as a share of their
/// distance from it, below which the face is turned away from the blades.
const BENDS: f64 = 0.35;
/// Sine of the angle by which a face turns away over an edge of the body.
const CORNER: f64 = 0.3;

/// Sums over a patch that tell whether it carries blades.
#[derive(Clone, Copy, Debug)]
struct PatchSums {
    /// Area, mm².
    area: f64,
    /// Length of its borders with triangles that are not turned, mm.
    border: f64,
    /// Heights of the middle of the blades over the planes of its triangles, by their area, mm³.
    facing: f64,
    /// Distances from the middle of the blades, by the area, mm³.
    reach: f64,
    /// Sines of the angles by which what meets it rises over it, by the length of the border, mm.
    in_front: f64,
    /// Least and largest r, least and largest z, mm.
    extent: [f64; 4],
}

impl PatchSums {
    const NONE: Self = Self {
        area: 0.0,
        border: 0.0,
        facing: 0.0,
        reach: 0.0,
        in_front: 0.0,
        extent: [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY],
    };

    /// What distinguishes hub and cover from other faces, mm³.
    fn weight(&self) -> f64 {
        self.area * self.border
    }

    /// Whether the side to which the normals point, or for `sign` -1 the other one, is that of the blades.
    /// Rims and backs of a solid face away from the middle of its blades. Of a cover that bends about the
    /// blades their middle tells nothing, but what meets it: blades are in front of it.
    fn faces_blades(&self, sign: f64) -> bool {
        let bends = sign * self.facing > -BENDS * self.reach;
        sign * self.facing > 0.0 || (bends && sign * self.in_front > 0.0)
    }

    fn is_alike(&self, other: &Self, tolerance: f64) -> bool {
        self.extent.iter().zip(&other.extent).all(|(a, b)| (a - b).abs() < ALIKE * tolerance)
    }
}

/// The triangles of a wheel, and those of them that are turned about its axis in patches of neighbours
/// without a corner between them.
pub(super) struct RevolvedPatches<'a> {
    pub wheel: &'a MeshSurface,
    pub exact: &'a ExactNormals,
    shape: FaceShape,
    /// Of each triangle, whether it may belong to a surface of revolution.
    pub turned: Vec<bool>,
    /// Patch of each triangle.
    patch_of: Vec<u32>,
    /// Corners of the wheel in the meridional plane.
    pub corners: Vec<Meridional>,
    /// Of these, those of triangles that are not turned: blades, and what else stands.
    standing: Vec<Meridional>,
    pub course: Course,
    /// Middle of what stands.
    middle: Meridional,
    /// 1 where the normals of a solid point outwards, -1 where inwards; `None` without a solid.
    outward: Option<f64>,
    /// Radius of the rim, mm.
    pub size: f64,
    /// Distance from a face within which a corner is on it, mm.
    pub tolerance: f64,
    /// By patch.
    sums: Vec<PatchSums>,
}

impl<'a> RevolvedPatches<'a> {
    /// The patches of a wheel about Z, whose faces of revolution have one `shape`.
    pub fn new(wheel: &'a MeshSurface, exact: &'a ExactNormals, shape: FaceShape) -> Self {
        let turned = turned_triangles(wheel, exact);
        let (patch_of, count) = wheel.groups(|a, b| {
            turned[a] && turned[b] && wheel.normals[a].dot(&wheel.normals[b]) > shape.min_cosine()
        });
        let corners: Vec<Meridional> = wheel.points.iter().map(Meridional::from_point).collect();
        let standing = points_of(corners_of(wheel, |t| !turned[t]), &corners);
        let course = Course::from_blades(&standing, wheel, |t| turned[t]);
        let (middle, size) = (mean_point(&standing), radii(wheel).1);
        let tolerance = ON_HUB.0.max(ON_HUB.1 * size);
        let (outward, sums) = (wheel.outward(), vec![PatchSums::NONE; count]);
        let mut patches = Self {
            wheel,
            exact,
            shape,
            turned,
            patch_of,
            corners,
            standing,
            course,
            middle,
            outward,
            size,
            tolerance,
            sums,
        };
        for t in (0..wheel.triangles.len()).filter(|&t| patches.turned[t]) {
            let added = patches.added_by(t, patches.sums[patches.patch_of[t] as usize]);
            patches.sums[patches.patch_of[t] as usize] = added;
        }
        patches
    }

    /// The sums of a patch and of its triangle `t`.
    fn added_by(&self, t: usize, mut sums: PatchSums) -> PatchSums {
        let Self { wheel, middle, .. } = self;
        let area = wheel.area(t);
        sums.area += area;
        sums.facing += area * towards(wheel, t, *middle);
        sums.reach += area * middle.distance(Meridional::from_point(&wheel.centre(t)));
        for (k, &n) in wheel.neighbours[t].iter().enumerate() {
            if n != NONE && !self.turned[n as usize] {
                let corners = wheel.triangles[t];
                let (a, b) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
                let length = (wheel.points[b] - wheel.points[a]).norm();
                sums.border += length;
                sums.in_front += self.rise(t, k) * length;
            }
        }
        let of = &mut sums.extent;
        for p in wheel.triangles[t].map(|i| self.corners[i as usize]) {
            *of = [of[0].min(p.r), of[1].max(p.r), of[2].min(p.z), of[3].max(p.z)];
        }
        sums
    }

    /// Sine of the angle by which the neighbour at side `k` of triangle `t` rises over it.
    fn rise(&self, t: usize, k: usize) -> f64 {
        let wheel = self.wheel;
        let way =
            wheel.centre(wheel.neighbours[t][k] as usize) - wheel.points[wheel.triangles[t][k] as usize];
        wheel.normals[t].dot(&way) / way.norm().max(1e-300)
    }

    /// Whether a triangle is of patch `number` and turned.
    pub fn is_of(&self, t: usize, number: usize) -> bool {
        self.turned[t] && self.patch_of[t] as usize == number
    }

    /// Patches that may carry blades, the heaviest first. Patches between blades that reach from edge to edge
    /// weigh together.
    fn carrying(&self) -> Vec<usize> {
        let Self { sums, outward, .. } = self;
        let may_carry =
            |f: &usize| sums[*f].weight() > 0.0 && outward.is_none_or(|sign| sums[*f].faces_blades(sign));
        let mut carrying: Vec<usize> = (0..sums.len()).filter(may_carry).collect();
        carrying.sort_by(|&a, &b| sums[b].weight().total_cmp(&sums[a].weight()));
        let together: Vec<f64> = carrying
            .iter()
            .map(|&f| {
                let joins = |g: usize| {
                    let is_front = outward.is_some_and(|sign| sign * sums[f].facing > 0.0);
                    g == f || (is_front && sums[f].is_alike(&sums[g], self.tolerance))
                };
                let patches = || carrying.iter().filter(|&&g| joins(g));
                patches().map(|&g| sums[g].area).sum::<f64>()
                    * patches().map(|&g| sums[g].border).sum::<f64>()
            })
            .collect();
        let heaviest = together.iter().copied().fold(0.0, f64::max);
        let kept = carrying.iter().zip(&together).filter(|(_, weight)| **weight > COVER * heaviest);
        kept.map(|(f, _)| *f).collect()
    }

    /// The face of a patch; `None` where it has no curve.
    fn face(&self, number: usize) -> Option<RevolvedFace> {
        let Self { wheel, course, outward, .. } = self;
        let own = |t: usize| self.is_of(t, number);
        let triangles: Vec<usize> = (0..wheel.triangles.len()).filter(|&t| own(t)).collect();
        let feet = self.feet_of(number);
        let of_shape = (*wheel, self.tolerance, self.shape);
        let fitted =
            |points: &[Meridional]| curve_of(course, (points, &triangles), &feet, self.middle, of_shape);
        let along = |p: Meridional| course.coordinates_of(p).0;
        // Long edges of fillets that join the face smoothly are not on its curve: then its corners tell it.
        let points = meridional_points(wheel, &triangles, self.exact, along);
        let own_corners = points_of(corners_of(wheel, own), &self.corners);
        let has_more = !self.exact.is_empty() && points.len() > own_corners.len();
        let profile = fitted(&points)
            .or_else(|| if has_more { fitted(&own_corners) } else { None })
            .or_else(|| fitted(&straight_points(wheel, &triangles)))?;
        // The face of a solid tells its outer side; what stands may do so on the back of the hub, too.
        let outside = |sign: f64| -> Vec<Meridional> {
            let aside = |&t: &usize| {
                let (at, (n, _)) = (Meridional::from_point(&wheel.centre(t)), meridional_normal(wheel, t));
                let way = sign * ASIDE * self.size;
                Meridional { r: at.r + way * n.r, z: at.z + way * n.z }
            };
            triangles.iter().map(aside).collect()
        };
        let beside = outward.map_or_else(|| self.standing.clone(), outside);
        let curve = MeridionalCurve::through(&profile.points).with_outer_side_towards_most(&beside);
        let inner = points.iter().map(|p| p.r).fold(f64::INFINITY, f64::min);
        RevolvedFace::new(number, profile.points, curve, (&self.corners, inner), course)
    }

    /// Where blades stand on a patch. By way of a fillet a leading edge that is turned is part of it: its
    /// corners with the sides of the blade are no feet.
    fn feet_of(&self, number: usize) -> Vec<Meridional> {
        let meets = |t: usize, k: usize| {
            let n = self.wheel.neighbours[t][k];
            n != NONE && !self.turned[n as usize]
        };
        let rises = |t: usize, k: usize| self.outward.is_none_or(|sign| sign * self.rise(t, k) > -CORNER);
        let at_foot = |t: usize| (0..3).any(|k| meets(t, k) && rises(t, k));
        let at_blade = |t: usize| (0..3).any(|k| meets(t, k));
        let feet = corners_of(self.wheel, |t| self.is_of(t, number) && at_foot(t));
        let feet = match feet.is_empty() {
            true => corners_of(self.wheel, |t| self.is_of(t, number) && at_blade(t)),
            false => feet,
        };
        points_of(feet, &self.corners)
    }

    /// The hub and, where there is one, the cover.
    ///
    /// # Errors
    /// The reason, if no hub is found.
    pub fn hub_and_cover(&self) -> Result<(RevolvedFace, Option<RevolvedFace>), &'static str> {
        let carrying = self.carrying();
        if carrying.is_empty() {
            return Err("no surface of revolution about the axis touches blades");
        }
        // Blades that reach from edge to edge divide a face into patches, one for each channel: those on a
        // curve that was found before belong to it.
        let mut faces: Vec<(RevolvedFace, [f64; 2])> = Vec::new();
        for number in carrying {
            let own = corners_of(self.wheel, |t| self.is_of(t, number));
            let is_on = |face: &RevolvedFace| own.iter().all(|&i| face.heights[i].abs() < self.tolerance);
            let PatchSums { area, border, .. } = self.sums[number];
            match faces.iter_mut().find(|(face, _)| is_on(face)) {
                Some((_, all)) => *all = [all[0] + area, all[1] + border],
                None => faces.extend(self.face(number).map(|face| (face, [area, border]))),
            }
        }
        faces.sort_by(|(_, a), (_, b)| (b[0] * b[1]).total_cmp(&(a[0] * a[1])));
        let heaviest = faces.first().map_or(0.0, |(_, [area, border])| area * border);
        faces.retain(|(_, [area, border])| area * border > COVER * heaviest);
        faces.truncate(2);
        let mut faces: Vec<RevolvedFace> = faces.into_iter().map(|(face, _)| face).collect();
        // The hub is nearer to the axis.
        faces.sort_by(|a, b| a.inner.total_cmp(&b.inner));
        let mut faces = faces.into_iter();
        let hub =
            faces.next().ok_or("no surface of revolution runs from inlet to outlet between the blades")?;
        Ok((hub, faces.next()))
    }
}

/// Indices of the corners of the triangles of a wheel that are to be kept.
fn corners_of(wheel: &MeshSurface, keep: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut used = vec![false; wheel.points.len()];
    for t in (0..wheel.triangles.len()).filter(|&t| keep(t)) {
        wheel.triangles[t].iter().for_each(|i| used[*i as usize] = true);
    }
    (0..used.len()).filter(|&i| used[i]).collect()
}

/// Those of `corners` with these indices.
fn points_of(indices: Vec<usize>, corners: &[Meridional]) -> Vec<Meridional> {
    indices.into_iter().map(|i| corners[i]).collect()
}

/// Which triangles may belong to a surface of revolution. Faces of CAD are judged as a whole: where fillets
/// run along the channel some of their triangles are turned, too, and would join hub and blades.
fn turned_triangles(wheel: &MeshSurface, exact: &ExactNormals) -> Vec<bool> {
    let turned: Vec<bool> =
        (0..wheel.triangles.len()).map(|t| meridional_normal(wheel, t).1.abs() < TURNED).collect();
    if exact.is_empty() {
        return turned;
    }
    let mut areas: HashMap<u32, [f64; 2]> = HashMap::new();
    for (t, face) in wheel.faces.iter().enumerate() {
        let of = areas.entry(*face).or_default();
        of[usize::from(turned[t])] += wheel.area(t);
    }
    let is_turned =
        |face: &u32| *face == NONE || areas.get(face).is_none_or(|[not, is]| *is > TURNED_FACE * (not + is));
    turned.iter().zip(&wheel.faces).map(|(turned, face)| *turned && is_turned(face)).collect()
}
