//! Segmentation of a wheel given as a single mesh: surfaces of revolution that touch the blades are hub and
//! cover, the rest is blades.

use std::collections::HashMap;

use super::boss::{BossOfHub, cut_off_boss, end_of_foot};
use super::meridional_points::{meridional_points, straight_points};
use super::normals::ExactNormals;
use super::profile::{Course, FittedProfile, MOSTLY, mean_point, meridional_normal, towards};
use super::round::{SECTORS, TURNED, is_round, radii, sectors_met};
use super::surface::MeshSurface;
use super::tip_border::begins_in_hub;
use super::trim::trimmed;
use super::weld::NONE;
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve};
use crate::part::PartError;

/// Smallest share of the area of a face of revolution that is turned.
const TURNED_FACE: f64 = 0.95;
/// Distance from the hub's curve within which a corner is on the hub: mm, and share of the rim radius.
const ON_HUB: (f64, f64) = (0.02, 2e-4);
/// Smallest weight (area × border length) of the lighter one of hub and cover, as a share of the heavier one.
const COVER: f64 = 0.05;
/// Distance of places beside a face that tell its outer side, as a share of the rim radius: chords of
/// triangles are nearer to it.
const ASIDE: f64 = 0.02;
/// Patches of one face have the same extent in the meridional plane within this many times the tolerance.
const ALIKE: f64 = 4.0;
/// How far before and past the ends of the hub's curve a face of a blade may go on below it, as a share of
/// the length of the curve along the course.
const END_SLACK: f64 = 0.05;
/// Share of the largest blade's area below which a piece is discarded as a fragment.
const SCRAP: f64 = 0.05;

/// Share of its largest radius from which on a piece is looked at to tell a blade from a wheel.
const OUTER: f64 = 0.8;

/// What a face of revolution may look like.
#[derive(Clone, Copy)]
enum FaceShape {
    /// Smooth all along.
    Smooth,
    /// In straight pieces, with obtuse corners between them.
    Cornered,
}

impl FaceShape {
    /// Smallest cosine of the angle between neighbouring triangles of one face.
    fn min_cosine(self) -> f64 {
        match self {
            Self::Smooth => 0.9,
            Self::Cornered => 0.6,
        }
    }
}

/// The surfaces of a segmented wheel.
pub struct Segments {
    /// The hub, or its flow side.
    pub hub: MeshSurface,
    /// How far blades go on before the beginning of the hub, straight, in the rounded corner at the foot of a
    /// boss, mm.
    pub hub_ahead_mm: f64,
    /// The shroud where it is a separate piece, or the cover.
    pub shroud: Option<MeshSurface>,
    /// Single blades.
    pub blades: Vec<MeshSurface>,
}

/// Whether a piece has points all around the axis at more than a `share` of its largest radius, as a wheel of
/// one piece has near its rim and a blade has not.
fn goes_around(piece: &MeshSurface, share: f64) -> bool {
    2 * sectors_met(piece, share) > SECTORS
}

/// Classifies disconnected pieces: surfaces of revolution are hub and shroud, all others blades. `None` where
/// there are no separate blades.
///
/// # Errors
/// Returns the number of bodies of revolution if there are more than two.
fn segment_disconnected(wheel: &MeshSurface) -> Result<Option<Segments>, usize> {
    let (mut round, mut blades) = (Vec::new(), Vec::new());
    for surface in wheel.clone().into_pieces() {
        if is_round(&surface) { round.push(surface) } else { blades.push(surface) }
    }
    // One piece beside the hub is a blade where it does not go around the axis, else a wheel of one piece.
    if blades.len() < 2 && blades.first().is_none_or(|blade| goes_around(blade, OUTER)) {
        return Ok(None);
    }
    if round.len() > 2 {
        return Err(round.len());
    }
    // The hub is nearest to the axis.
    round.sort_by(|a, b| radii(a).0.total_cmp(&radii(b).0));
    let mut round = round.into_iter();
    let Some(hub) = round.next() else { return Ok(None) };
    Ok(Some(Segments { hub, hub_ahead_mm: 0.0, shroud: round.next(), blades }))
}

/// Shares of a face's stretches past the blades that are tried for its curve: smoothly joined to hub or cover
/// may be the rounded edge of a collar and the plane beyond, which one curve does not follow.
const PAST_BLADES: [f64; 6] = [1.0, 0.5, 0.25, 0.12, 0.06, 0.03];
/// Mean height of the middle of the blades over the planes of a face's triangles, as a share of their
/// distance from it, below which the face is turned away from the blades.
const BENDS: f64 = 0.35;
/// Sine of the angle by which a face turns away over an edge of the body.
const CORNER: f64 = 0.3;
/// Share of the area of a face on its curve from which on no shorter curve is tried.
const NEARLY_ALL: f64 = 0.9;

/// The curve of a smooth face of revolution with the corners `points` and the triangles `own`, over the
/// blades and as far past them as one curve follows the face. The blades touch the face at `feet`.
fn curve_of(
    course: &Course,
    (points, own): (&[Meridional], &[usize]),
    feet: &[Meridional],
    middle: Meridional,
    (wheel, tolerance, shape): (&MeshSurface, f64, FaceShape),
) -> Option<FittedProfile> {
    let ((first, last), (from, to)) = (course.extent_of(points), course.extent_of(feet));
    let ranges: Vec<(f64, f64)> = PAST_BLADES
        .into_iter()
        .flat_map(|s| {
            [(s, 1.0), (1.0, s), (s, s)].map(|(a, b)| (from + (first - from) * a, to + (last - to) * b))
        })
        .skip(2)
        .collect();
    let within = |(from, to): (f64, f64)| -> (Vec<Meridional>, Vec<usize>) {
        let inside = |p: &Meridional| (from..=to).contains(&course.coordinates_of(*p).0);
        let corner = |i: u32| inside(&Meridional::from_point(&wheel.points[i as usize]));
        (
            points.iter().filter(|p| inside(p)).copied().collect(),
            own.iter().copied().filter(|t| wheel.triangles[*t].iter().all(|i| corner(*i))).collect(),
        )
    };
    let exact = ranges.iter().find_map(|range| {
        let (points, own) = within(*range);
        let line = match shape {
            FaceShape::Smooth => course.fit_curve(&points).filter(|p| p.max_deviation_mm < tolerance),
            FaceShape::Cornered => course.line_through(&points),
        };
        line.filter(|p| p.area_share_on_curve(wheel, &own, tolerance) > MOSTLY)
    });
    if exact.is_some() {
        return exact;
    }
    // A face with fillets continues smoothly up to the blades' noses: then the curve follows its bottom.
    let mut best: Option<(f64, FittedProfile)> = None;
    for range in ranges {
        let (points, own) = within(range);
        let Some(profile) = course.fit_bottom(&points, middle, tolerance) else { continue };
        let share = profile.area_share_on_curve(wheel, &own, tolerance);
        if best.as_ref().is_none_or(|(most, _)| share > *most) {
            best = Some((share, profile));
        }
        if share > NEARLY_ALL {
            break;
        }
    }
    best.filter(|(share, _)| *share > MOSTLY).map(|(_, profile)| profile)
}

/// Which of several pieces are blades: neither fragments, nor bodies of revolution.
fn blades_among(pieces: &[MeshSurface]) -> Vec<bool> {
    let area = |piece: &MeshSurface| (0..piece.triangles.len()).map(|t| piece.area(t)).sum::<f64>();
    let areas: Vec<f64> = pieces.iter().map(area).collect();
    let largest = areas.iter().copied().fold(0.0, f64::max);
    pieces.iter().zip(areas).map(|(piece, area)| area > SCRAP * largest && !is_round(piece)).collect()
}

/// Whether the blades among pieces are apart: a single one may be the only blade of the file, on one pitch of
/// the hub or on all of it; connected blades go around the axis.
fn are_apart(pieces: &[MeshSurface]) -> bool {
    let mut blades = pieces.iter().zip(blades_among(pieces)).filter(|(_, is_blade)| *is_blade);
    let first = blades.next();
    blades.next().is_some() || first.is_some_and(|(blade, _)| !goes_around(blade, 0.0))
}

/// A face of revolution of a wheel: hub or cover.
struct RevolvedFace {
    /// Number of its group of triangles.
    number: usize,
    /// Points of its curve, inlet → outlet, mm.
    points: Vec<Meridional>,
    /// Its curve, with the outer side towards the blades.
    curve: MeridionalCurve,
    /// Extent of its curve along the course, mm.
    extent: (f64, f64),
    /// Of all corners of the wheel, whether the nearest place of the curve is one of its ends.
    at_end: Vec<bool>,
    /// Heights of all corners of the wheel over it, positive towards the blades, mm.
    heights: Vec<f64>,
    /// Smallest radius of its corners, mm.
    inner: f64,
}

impl RevolvedFace {
    /// A face with the points of its curve, which has its outer side towards the blades; with the corners of
    /// the wheel, and the smallest radius of its own.
    fn new(
        number: usize,
        points: Vec<Meridional>,
        curve: MeridionalCurve,
        (corners, inner): (&[Meridional], f64),
        course: &Course,
    ) -> Option<Self> {
        let ends = [points.first()?, points.last()?].map(|p| course.coordinates_of(*p).0);
        let feet_of: Vec<(f64, f64)> = corners.iter().map(|p| curve.project(*p)).collect();
        let inside = 1e-6 * curve.length()..=(1.0 - 1e-6) * curve.length();
        let at_end = feet_of.iter().map(|(t, _)| !inside.contains(t)).collect();
        let heights = feet_of.into_iter().map(|(_, height)| height).collect();
        Some(Self { number, points, curve, extent: (ends[0], ends[1]), at_end, heights, inner })
    }

    /// The face from the arc length `from` of its curve on.
    fn behind(&self, from: f64, corners: &[Meridional], course: &Course) -> Option<Self> {
        let curve = self.curve.piece(from, self.curve.length());
        let begin = course.coordinates_of(curve.point(0.0)).0;
        let rest = self.points.iter().filter(|p| course.coordinates_of(**p).0 > begin);
        let points = std::iter::once(curve.point(0.0)).chain(rest.copied()).collect();
        Self::new(self.number, points, curve, (corners, self.inner), course)
    }
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

/// Segments a wheel given as one mesh about Z into hub, blades and, where there is one, cover.
///
/// # Errors
/// Fails when no surface of revolution touches blades, when there are more than two disconnected bodies of
/// revolution, or when the blades are connected with each other.
pub fn segment_wheel(wheel: &MeshSurface, exact: &ExactNormals, name: &str) -> Result<Segments, PartError> {
    let by_smooth = segment_by(FaceShape::Smooth, wheel, exact, name);
    // A hub drawn in straight pieces may have corners under the blades.
    by_smooth.or_else(|error| segment_by(FaceShape::Cornered, wheel, exact, name).map_err(|_| error))
}

/// As [`segment_wheel`], with faces of revolution of one shape.
fn segment_by(
    shape: FaceShape,
    wheel: &MeshSurface,
    exact: &ExactNormals,
    name: &str,
) -> Result<Segments, PartError> {
    let unclear = |why: &str| {
        PartError::new(
            ErrorCode::MeshInOne,
            0,
            format!("hub and blades of the single mesh `{name}` cannot be separated: {why}"),
            "export hub and blades as separate bodies, or give them --role NODE=hub and NODE=blade; if the axis in \
             the file is not that of the wheel, give it with --rotation-axis",
        )
    };
    match segment_disconnected(wheel) {
        Ok(Some(segments)) => return Ok(segments),
        Ok(None) => {}
        Err(count) => return Err(unclear(&format!("it has {count} bodies of revolution"))),
    }
    let turned = turned_triangles(wheel, exact);
    let (group, count) = wheel.groups(|a, b| {
        turned[a] && turned[b] && wheel.normals[a].dot(&wheel.normals[b]) > shape.min_cosine()
    });
    // Hub and cover are the large faces of revolution with the longest common borders with other faces.
    let (mut areas, mut borders) = (vec![0.0; count], vec![0.0; count]);
    for t in (0..group.len()).filter(|&t| turned[t]) {
        areas[group[t] as usize] += wheel.area(t);
        for (k, &n) in wheel.neighbours[t].iter().enumerate() {
            if n != NONE && !turned[n as usize] {
                let corners = wheel.triangles[t];
                let (a, b) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
                borders[group[t] as usize] += (wheel.points[b] - wheel.points[a]).norm();
            }
        }
    }
    let corners: Vec<Meridional> = wheel.points.iter().map(Meridional::from_point).collect();
    let corners_of = |keep: &dyn Fn(usize) -> bool| -> Vec<usize> {
        let mut used = vec![false; corners.len()];
        for t in (0..group.len()).filter(|&t| keep(t)) {
            wheel.triangles[t].iter().for_each(|i| used[*i as usize] = true);
        }
        (0..corners.len()).filter(|&i| used[i]).collect()
    };
    let of = |keep: &dyn Fn(usize) -> bool| -> Vec<Meridional> {
        corners_of(keep).into_iter().map(|i| corners[i]).collect()
    };
    let standing = of(&|t| !turned[t]);
    let (course, middle) = (Course::from_blades(&standing, wheel, |t| turned[t]), mean_point(&standing));
    // Rims and backs of a solid face away from the middle of its blades. Of a cover that bends about the
    // blades their middle tells nothing, but what meets it: blades are in front of it.
    let rise = |t: usize, k: usize| {
        let way =
            wheel.centre(wheel.neighbours[t][k] as usize) - wheel.points[wheel.triangles[t][k] as usize];
        wheel.normals[t].dot(&way) / way.norm().max(1e-300)
    };
    let (mut facing, mut reach, mut in_front) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    for t in (0..group.len()).filter(|&t| turned[t]) {
        let f = group[t] as usize;
        facing[f] += wheel.area(t) * towards(wheel, t, middle);
        reach[f] += wheel.area(t) * middle.distance(Meridional::from_point(&wheel.centre(t)));
        for (k, &n) in wheel.neighbours[t].iter().enumerate() {
            if n != NONE && !turned[n as usize] {
                let corners = wheel.triangles[t];
                let (a, b) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
                in_front[f] += rise(t, k) * (wheel.points[b] - wheel.points[a]).norm();
            }
        }
    }
    let outward = wheel.outward();
    let weight = |f: usize| areas[f] * borders[f];
    let faces_blades = |f: usize, sign: f64| {
        let bends = sign * facing[f] > -BENDS * reach[f];
        sign * facing[f] > 0.0 || (bends && sign * in_front[f] > 0.0)
    };
    let may_carry = |f: usize| weight(f) > 0.0 && outward.is_none_or(|sign| faces_blades(f, sign));
    let size = radii(wheel).1;
    let tolerance = ON_HUB.0.max(ON_HUB.1 * size);
    let mut carrying: Vec<usize> = (0..count).filter(|&f| may_carry(f)).collect();
    carrying.sort_by(|&a, &b| weight(b).total_cmp(&weight(a)));
    // Patches between blades that reach from edge to edge weigh together.
    let mut box_of = vec![[f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY]; count];
    for t in (0..group.len()).filter(|&t| turned[t]) {
        let of = &mut box_of[group[t] as usize];
        for p in wheel.triangles[t].map(|i| corners[i as usize]) {
            *of = [of[0].min(p.r), of[1].max(p.r), of[2].min(p.z), of[3].max(p.z)];
        }
    }
    let alike = |a: usize, b: usize| (0..4).all(|k| (box_of[a][k] - box_of[b][k]).abs() < ALIKE * tolerance);
    let together: Vec<f64> = carrying
        .iter()
        .map(|&f| {
            let joins = |g: usize| g == f || (outward.is_some_and(|s| s * facing[f] > 0.0) && alike(f, g));
            let patches = || carrying.iter().filter(|&&g| joins(g));
            patches().map(|&g| areas[g]).sum::<f64>() * patches().map(|&g| borders[g]).sum::<f64>()
        })
        .collect();
    let heaviest = together.iter().copied().fold(0.0, f64::max);
    let kept = carrying.iter().zip(&together).filter(|(_, weight)| **weight > COVER * heaviest);
    let carrying: Vec<usize> = kept.map(|(f, _)| *f).collect();
    if carrying.is_empty() {
        return Err(unclear("no surface of revolution about the axis touches blades"));
    }
    let face = |number: usize| -> Option<RevolvedFace> {
        let own = |t: usize| turned[t] && group[t] as usize == number;
        let triangles: Vec<usize> = (0..group.len()).filter(|&t| own(t)).collect();
        let at_blade = |t: usize| wheel.neighbours[t].iter().any(|n| *n != NONE && !turned[*n as usize]);
        // By way of a fillet a leading edge that is turned is part of the face: its corners with the sides of
        // the blade are no feet.
        let at_foot = |t: usize| {
            let meets = |k: usize| {
                let n = wheel.neighbours[t][k];
                n != NONE && !turned[n as usize] && outward.is_none_or(|sign| sign * rise(t, k) > -CORNER)
            };
            (0..3).any(meets)
        };
        let mut feet = of(&|t| own(t) && at_foot(t));
        if feet.is_empty() {
            feet = of(&|t| own(t) && at_blade(t));
        }
        let fitted = |points: &[Meridional]| {
            curve_of(&course, (points, &triangles), &feet, middle, (wheel, tolerance, shape))
        };
        let along = |p: Meridional| course.coordinates_of(p).0;
        // Long edges of fillets that join the face smoothly are not on its curve: then its corners tell it.
        let (points, own_corners) = (meridional_points(wheel, &triangles, exact, along), of(&own));
        let has_more = !exact.is_empty() && points.len() > own_corners.len();
        let profile = fitted(&points)
            .or_else(|| if has_more { fitted(&own_corners) } else { None })
            .or_else(|| fitted(&straight_points(wheel, &triangles)))?;
        // The face of a solid tells its outer side; what stands may do so on the back of the hub, too.
        let outside = |sign: f64| -> Vec<Meridional> {
            let aside = |&t: &usize| {
                let (at, (n, _)) = (Meridional::from_point(&wheel.centre(t)), meridional_normal(wheel, t));
                let way = sign * ASIDE * size;
                Meridional { r: at.r + way * n.r, z: at.z + way * n.z }
            };
            triangles.iter().map(aside).collect()
        };
        let beside = outward.map_or_else(|| standing.clone(), outside);
        let curve = MeridionalCurve::through(&profile.points).with_outer_side_towards_most(&beside);
        let inner = points.iter().map(|p| p.r).fold(f64::INFINITY, f64::min);
        RevolvedFace::new(number, profile.points, curve, (&corners, inner), &course)
    };
    // Blades that reach from edge to edge divide a face into patches, one for each channel: those on a curve
    // that was found before belong to it.
    let mut faces: Vec<(RevolvedFace, [f64; 2])> = Vec::new();
    for number in carrying {
        let own = corners_of(&|t| turned[t] && group[t] as usize == number);
        let is_on = |face: &RevolvedFace| own.iter().all(|&i| face.heights[i].abs() < tolerance);
        let sums = [areas[number], borders[number]];
        match faces.iter_mut().find(|(face, _)| is_on(face)) {
            Some((_, all)) => *all = [all[0] + sums[0], all[1] + sums[1]],
            None => faces.extend(face(number).map(|face| (face, sums))),
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
    let Some(mut hub) = faces.next() else {
        return Err(unclear("no surface of revolution runs from inlet to outlet between the blades"));
    };
    let cover = faces.next();

    let any = |face: &RevolvedFace, t: usize, is: &dyn Fn(f64) -> bool| {
        wheel.triangles[t].iter().any(|i| is(face.heights[*i as usize]))
    };
    let below = |face: &RevolvedFace, t: usize| any(face, t, &|h| h < -tolerance);
    let stands = |face: &RevolvedFace, t: usize| !below(face, t) && any(face, t, &|h| h > tolerance);
    let lies = |face: &RevolvedFace, t: usize| !below(face, t) && !any(face, t, &|h| h > tolerance);
    // Where a face goes on past its curve it is not a blade, on whichever side of the curve's end it is.
    let past = |face: &RevolvedFace, t: usize| {
        let outside = |i: &u32| {
            let x = course.coordinates_of(corners[*i as usize]).0;
            // A leading edge that is turned may lean ahead of the curve, and stand over it.
            face.at_end[*i as usize] && (x < face.extent.0 || x > face.extent.1)
        };
        turned[t] && group[t] as usize == face.number && wheel.triangles[t].iter().any(outside)
    };
    let over = |face: &RevolvedFace, t: usize| stands(face, t) && !past(face, t);
    // Ahead of a cover blades may be higher than it goes on, in its eye.
    let is_in = |cover: &RevolvedFace, t: usize| {
        let corner = |i: &u32| cover.heights[*i as usize];
        let behind = |i: &u32| !cover.at_end[*i as usize] && corner(i) < -tolerance;
        let of_it = &wheel.triangles[t];
        !of_it.iter().any(behind) && of_it.iter().any(|i| corner(i) > tolerance) && !past(cover, t)
    };
    let in_cover = |t: usize| cover.as_ref().is_none_or(|cover| is_in(cover, t));
    let over_hub_of = |hub: &RevolvedFace, whole: Option<&RevolvedFace>| {
        // Of a face of a blade that goes on below the edge of the hub, as a trailing edge does in the rim.
        let goes_below = |t: usize| {
            let reach = END_SLACK * (hub.extent.1 - hub.extent.0);
            let within = |i: &u32| {
                let p = corners[*i as usize];
                let x = course.coordinates_of(p).0;
                // A rim at right angles to the hub may be wide.
                let is_at_end = || {
                    let t = hub.curve.project_past_ends(p).0;
                    t > -reach && t < hub.curve.length() + reach
                };
                (x > hub.extent.0 - reach && x < hub.extent.1 + reach) || is_at_end()
            };
            below(hub, t) && any(hub, t, &|h| h > tolerance) && wheel.triangles[t].iter().all(within)
        };
        let crossing: Vec<bool> = (0..wheel.triangles.len()).map(goes_below).collect();
        let is_wall = |t: usize| turned[t] && whole.is_some_and(|whole| lies(whole, t));
        let over_hub = wheel.subset(|t| (over(hub, t) || crossing[t]) && in_cover(t) && !is_wall(t));
        match crossing.contains(&true) {
            true => trimmed(&over_hub, &hub.curve, tolerance),
            false => over_hub,
        }
    };
    let mut over_hub = over_hub_of(&hub, None);
    let mut pieces = over_hub.clone().into_pieces();
    // Blades that begin in a boss with a rounded foot stand on a hub that goes on up to its top.
    let first_blade = pieces.iter().zip(blades_among(&pieces)).find(|(_, is)| *is).map(|(piece, _)| piece);
    let in_boss = first_blade.is_some_and(|blade| begins_in_hub(blade, &hub.points, &course));
    let foot = if in_boss { end_of_foot(&hub.curve) } else { None };
    let behind = foot.and_then(|foot| hub.behind(foot, &corners, &course));
    let rounded = behind.map(|behind| std::mem::replace(&mut hub, behind));
    if rounded.is_some() {
        over_hub = over_hub_of(&hub, rounded.as_ref());
    }
    let mut hub_ahead_mm = 0.0;
    if rounded.is_some() || !are_apart(&pieces) {
        let boss = BossOfHub {
            wheel,
            hub: &hub.points,
            rounded: rounded.as_ref().map(|face| &face.curve),
            above: hub.curve.offset_derivative(0.5 * hub.curve.length(), ASIDE * size).0,
            inlet_up: course.inlet_up(),
            tolerance,
        };
        match (cut_off_boss(&over_hub, &boss, are_apart), rounded) {
            (Some(cut), _) => (pieces, hub_ahead_mm) = (cut.pieces, cut.ahead_mm),
            (None, Some(whole)) if are_apart(&pieces) => hub = whole,
            _ => return Err(unclear("the blades on its hub are connected with each other")),
        }
    }
    let is_blade = blades_among(&pieces);
    let blades = pieces.into_iter().zip(is_blade).filter(|(_, is)| *is).map(|(blade, _)| blade).collect();
    // Of CAD, the lowest triangles of fillets are not of the face.
    let is_of = |face: &RevolvedFace, t: usize| lies(face, t) && (exact.is_empty() || turned[t]);
    let shroud = cover.map(|cover| wheel.subset(|t| is_of(&cover, t)));
    Ok(Segments { hub: wheel.subset(|t| is_of(&hub, t)), hub_ahead_mm, shroud, blades })
}
