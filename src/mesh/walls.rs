//! Hub and cover of a wheel as meridional curves, and its blades cut off at them: blades of solids that were
//! not united go on into hub and cover, through the cover, and past the rim of both.

use super::boss::{BossOfHub, cut_off_boss, end_of_foot};
use super::meridional_points::{corners_of, straight_points};
use super::normals::ExactNormals;
use super::profile::{Course, FittedProfile, MOSTLY, PieceRule, find_flow_side, mean_point};
use super::surface::MeshSurface;
use super::tip_border::begins_in_hub;
use super::trim::{BodyOutline, depth_behind, rim_line, trimmed, trimmed_with_normals};
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve, wrap_angle};
use crate::part::PartError;

/// Number of places of a blade over the rim radius: extruded blades have no corners between hub and cover.
const PLACES: f64 = 50.0;
/// Fewest places of a blade that tell a channel.
const FEWEST: usize = 8;
/// Blades that are deeper in hub or cover than this many times the tolerance reach into it.
const REACHES_IN: f64 = 4.0;

/// Corners of a blade that is cut off are on the wall where they are within this many times the tolerance of
/// it: the foot of a blade that stands on the hub and reaches into it elsewhere only.
const ON_WALL: f64 = 0.2;

/// Cosines of angles between neighbouring triangles above which they are one face, where a corner between two
/// faces is looked for.
const OBTUSE: [f64; 3] = [0.9, 0.95, 0.98];
/// Largest distance of the chords of a coarse mesh from the curve through its corners, as a share of the
/// length of the curve.
const CHORD: f64 = 0.01;

/// The blades of a wheel.
pub struct Blades {
    /// The main blade.
    pub main: MeshSurface,
    /// Its splitters.
    pub splitters: Vec<MeshSurface>,
}

/// The walls of a channel, and what is in it.
pub struct Walls {
    /// The blades within the channel.
    pub blades: Blades,
    /// Places of the main blade in the meridional plane.
    pub corners: Vec<Meridional>,
    /// The direction of the channel.
    pub course: Course,
    /// The hub.
    pub hub: FittedProfile,
    /// How far blades go on before the beginning of the hub, straight, in the rounded corner at the foot of a
    /// boss, mm.
    pub hub_ahead_mm: f64,
    /// The cover, where there is one.
    pub shroud: Option<FittedProfile>,
}

/// Length over which the directions of a disc and of the wall of a boss are taken, as a share of the disc's
/// curve, and smallest angle between them, rad.
const WALL: f64 = 0.02;
const CORNER: f64 = 0.9;

/// Fits the curves of hub and cover of a wheel of the rim radius `size`, mm, and cuts the blades off at them;
/// a line about each cut is added to `notes`, and the normals at it to `normals`.
///
/// # Errors
/// Fails when hub or cover are not surfaces of revolution within `tolerance`, mm.
pub fn fit_walls(
    Blades { mut main, mut splitters }: Blades,
    hub: &MeshSurface,
    shroud: Option<&MeshSurface>,
    normals: &mut ExactNormals,
    (size, tolerance): (f64, f64),
    notes: &mut Vec<String>,
) -> Result<Walls, PartError> {
    // Places within hub or cover say nothing about the channel.
    let outlines = [BodyOutline::from_body(hub), shroud.and_then(BodyOutline::from_body)];
    let buried = |p: &Meridional| outlines.iter().flatten().any(|outline| outline.contains(*p));
    let unless_few =
        |some: Vec<Meridional>, all: Vec<Meridional>| if some.len() < FEWEST { all } else { some };
    let all = match outlines {
        [None, None] => main.points.iter().map(Meridional::from_point).collect(),
        _ => main.places(size / PLACES),
    };
    let mut corners = unless_few(all.iter().filter(|p| !buried(p)).copied().collect(), all);
    let bodies: Vec<&MeshSurface> = std::iter::once(hub).chain(shroud).collect();
    let mut course = Course::from_blades(&corners, hub, |_| true).along_walls(&bodies, &corners);
    let mut hub_curve = fit_revolved(hub, &course, (&corners, &*normals), "hub", tolerance)?;
    let through = |profile: &FittedProfile| MeridionalCurve::through(&profile.points);
    if let Some(cover) = &outlines[1] {
        // Blades that run through the cover have places beyond it, from which its outside is seen, and those
        // that go on past the rim have some beside it.
        let line = through(&hub_curve);
        let beyond = |p: &Meridional| {
            let (t, _) = line.project(*p);
            t >= line.length() || cover.separates(line.point(t), *p)
        };
        let within: Vec<Meridional> = corners.iter().filter(|p| !beyond(p)).copied().collect();
        if within.len() < corners.len() && within.len() >= FEWEST {
            corners = within;
            course = Course::from_blades(&corners, hub, |_| true).along_walls(&bodies, &corners);
            hub_curve = fit_revolved(hub, &course, (&corners, &*normals), "hub", tolerance)?;
        }
    }
    let shroud = shroud
        .map(|shroud| fit_revolved(shroud, &course, (&corners, &*normals), "shroud", tolerance))
        .transpose()?;
    let cover = shroud.as_ref().filter(|_| outlines[1].is_some());
    let whole = Blades { main: main.clone(), splitters: splitters.clone() };
    let borders = [
        (outlines[0].is_some().then(|| through(&hub_curve)), "reach", "into the hub"),
        (cover.map(through), "reach", "into the cover"),
        (cover.and_then(|cover| rim_line(&hub_curve, cover)), "go on", "past the rim of hub and cover"),
    ];
    for (line, reach, place) in borders {
        let Some(line) = line.map(|line| line.with_outer_side_towards_most(&corners)) else { continue };
        let depth = depth_behind(&main, &line);
        if depth > REACHES_IN * tolerance {
            for blade in std::iter::once(&mut main).chain(&mut splitters) {
                let (cut, at_cut) = trimmed_with_normals(blade, &line, ON_WALL * tolerance, normals);
                normals.extend(at_cut);
                *blade = cut;
            }
            corners = main.points.iter().map(Meridional::from_point).collect();
            notes.push(format!("the blades {reach} {depth:.2} mm {place}; they are cut off there"));
        }
    }
    let mut walls = Walls {
        blades: Blades { main, splitters },
        corners,
        course,
        hub: hub_curve,
        hub_ahead_mm: 0.0,
        shroud,
    };
    if let Some(body) = &outlines[0] {
        cut_off_in_boss(&mut walls, &whole, (hub, body), (size, tolerance), notes);
    }
    Ok(walls)
}

/// Cuts blades off at the wall of a boss of the `hub` in which they begin; the hub then begins there, and
/// `whole` are the blades that are not yet cut off at it.
fn cut_off_in_boss(
    walls: &mut Walls,
    whole: &Blades,
    (hub, body): (&MeshSurface, &BodyOutline),
    (size, tolerance): (f64, f64),
    notes: &mut Vec<String>,
) {
    let Walls { blades, corners, course, hub: hub_curve, .. } = &*walls;
    let curve = MeridionalCurve::through(&hub_curve.points).with_outer_side_towards_most(corners);
    // Where its foot is rounded, the wall of the boss is part of the curve.
    let on_wall = begins_in_hub(&blades.main, &hub_curve.points, course);
    let foot = if on_wall { end_of_foot(&curve) } else { None };
    let begin = foot.map_or(0.0, |foot| course.coordinates_of(curve.point(foot)).0);
    let is_behind = |p: &&Meridional| foot.is_none() || course.coordinates_of(**p).0 > begin;
    let first = foot.map(|foot| curve.point(foot));
    let points: Vec<Meridional> =
        first.into_iter().chain(hub_curve.points.iter().filter(is_behind).copied()).collect();
    if points.len() < FEWEST {
        return;
    }
    let line = MeridionalCurve::through(&points).with_outer_side_towards_most(corners);
    let is_in_boss =
        |p: &Meridional| line.project_past_ends(*p).1 > REACHES_IN * tolerance && body.contains(*p);
    let from = if foot.is_some() { whole } else { blades };
    if !from.main.places(size / PLACES).iter().any(is_in_boss) {
        return;
    }
    let boss = BossOfHub {
        wheel: hub,
        hub: &points,
        rounded: foot.map(|_| &curve),
        above: mean_point(corners),
        inlet_up: course.inlet_up(),
        tolerance,
    };
    let cut = |blade: &MeshSurface| {
        let over = trimmed(blade, &line, ON_WALL * tolerance);
        let cut = cut_off_boss(&over, &boss, |_| true)?;
        let piece = cut.pieces.into_iter().max_by_key(|piece| piece.triangles.len())?;
        Some((piece, cut.ahead_mm))
    };
    let splitters = from.splitters.iter().map(|blade| cut(blade).map(|(piece, _)| piece)).collect();
    if let (Some((main, ahead_mm)), Some(splitters)) = (cut(&from.main), splitters) {
        walls.corners = main.points.iter().map(Meridional::from_point).collect();
        walls.blades = Blades { main, splitters };
        walls.hub.points = points;
        walls.hub_ahead_mm = ahead_mm;
        notes.push("the blades begin within the boss of the hub; they are cut off at its wall".to_owned());
    }
}

fn fit_revolved(
    surface: &MeshSurface,
    course: &Course,
    (blades, exact): (&[Meridional], &ExactNormals),
    name: &str,
    tolerance: f64,
) -> Result<FittedProfile, PartError> {
    let by = |rule: PieceRule| fit_side(surface, course, (blades, exact, rule), name, tolerance);
    let fits = |profile: &FittedProfile| profile.max_deviation_mm <= tolerance;
    let profile = by(PieceRule::SEVERAL)?;
    if let Ok(one) = by(PieceRule::ONE)
        && fits(&one)
        // The wall of a boss in which the blades begin is a piece of its own behind a corner; a large
        // tolerance lets one curve follow both, around the corner.
        && (profile.max_deviation_mm > tolerance || begins_with_wall(&profile, &one))
    {
        return Ok(one);
    }
    if profile.max_deviation_mm > tolerance {
        // The face ahead of the blades may meet that under them at an obtuse corner, which no smooth curve
        // follows.
        let rules = OBTUSE.map(|min_cosine| PieceRule { min_cosine, is_alone: true, ..PieceRule::SEVERAL });
        let behind_corner = rules.into_iter().filter_map(|rule| by(rule).ok()).find(fits);
        if let Some(profile) = behind_corner {
            return Ok(profile);
        }
    }
    check_deviation(profile, name, tolerance)
}

/// Whether `whole` runs down the wall of a boss to the beginning of `disc`, a part of it.
fn begins_with_wall(whole: &FittedProfile, disc: &FittedProfile) -> bool {
    let [whole, disc] = [whole, disc].map(|profile| MeridionalCurve::through(&profile.points));
    let corner = disc.point(0.0);
    let (foot, reach) = (whole.project(corner).0, WALL * disc.length());
    if foot < reach {
        return false;
    }
    let direction = |from: Meridional, to: Meridional| (to.z - from.z).atan2(to.r - from.r);
    let wall = direction(whole.point(foot - reach), corner);
    wrap_angle(direction(corner, disc.point(reach)) - wall).abs() > CORNER
}

/// The curve of the pieces of a surface that a rule takes.
fn fit_side(
    surface: &MeshSurface,
    course: &Course,
    (blades, exact, rule): (&[Meridional], &ExactNormals, PieceRule),
    name: &str,
    tolerance: f64,
) -> Result<FittedProfile, PartError> {
    let side = find_flow_side(surface, course, blades, (exact, rule), name)?;
    let above = mean_point(blades);
    let fit = |points: &[Meridional]| {
        let profile = course.fit_without_feet(points, above, tolerance)?;
        if profile.max_deviation_mm <= tolerance {
            return Some(profile);
        }
        let bottom = course.fit_bottom(points, above, tolerance);
        let on_bottom =
            |p: &FittedProfile| p.area_share_on_curve(surface, &side.triangles, tolerance) > MOSTLY;
        bottom.filter(on_bottom).or(Some(profile))
    };
    let profile = fit(&side.points).ok_or_else(|| {
        PartError::new(
            ErrorCode::MeshRoles,
            0,
            format!("the {name} has no extent"),
            format!("check which mesh is the {name}"),
        )
    })?;
    if profile.max_deviation_mm <= tolerance {
        return Ok(profile);
    }
    let straight = straight_points(surface, &side.triangles);
    if let Some(fitted) = fit(&straight).filter(|fitted| fitted.max_deviation_mm <= tolerance) {
        return Ok(fitted);
    }
    // The long edges of a coarse mesh are chords of a curved face: then its corners tell it.
    let is_near_chords = |fitted: &FittedProfile| {
        let curve = MeridionalCurve::through(&fitted.points);
        straight.iter().all(|p| curve.project(*p).1.abs() < CHORD * curve.length())
    };
    let by_corners = fit(&corners_of(surface, &side.triangles));
    let by_corners = by_corners.filter(|fitted| fitted.max_deviation_mm <= tolerance);
    Ok(by_corners.filter(is_near_chords).unwrap_or(profile))
}

/// Checks that a curve follows the corners it was fitted to.
///
/// # Errors
/// Fails where one is further than `tolerance`, mm, from it.
pub fn check_deviation(
    profile: FittedProfile,
    name: &str,
    tolerance: f64,
) -> Result<FittedProfile, PartError> {
    if profile.max_deviation_mm > tolerance {
        return Err(PartError::new(
            ErrorCode::NotRevolved,
            0,
            format!(
                "the {name} is not a surface of revolution: {:.2} mm off at z = {:.1}, r = {:.1} mm",
                profile.max_deviation_mm, profile.worst_corner.z, profile.worst_corner.r
            ),
            format!("check which mesh is the {name}, and the axis of rotation (--rotation-axis)"),
        ));
    }
    Ok(profile)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_down_the_wall_of_a_boss_begins_with_it_and_one_down_a_cone_does_not() {
        let line =
            |from: Meridional, to: Meridional| (0..=40).map(move |k| from.lerp(to, f64::from(k) / 40.0));
        let profile = |points: Vec<Meridional>| FittedProfile {
            points,
            max_deviation_mm: 0.0,
            worst_corner: Meridional::default(),
        };
        let at = |r: f64, z: f64| Meridional { r, z };
        let disc = profile(line(at(15.0, 4.0), at(60.0, 4.0)).collect());
        for (top, is_wall) in [(at(15.0, 16.0), true), (at(5.0, 8.0), false), (at(15.0, 4.1), false)] {
            let whole = line(top, at(15.0, 4.0)).chain(disc.points[1..].iter().copied());
            assert_eq!(begins_with_wall(&profile(whole.collect()), &disc), is_wall, "{top:?}");
        }
    }
}
