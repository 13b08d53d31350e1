//! Hub and cover of a wheel as meridional curves, and its blades cut off at them: blades of solids that were
//! not united go on into hub and cover, through the cover, and past the rim of both.

use super::meridional_points::straight_points;
use super::normals::ExactNormals;
use super::profile::{Course, FittedProfile, MOSTLY, find_flow_side, mean_point};
use super::surface::MeshSurface;
use super::trim::{BodyOutline, depth_behind, rim_line, trimmed_with_normals};
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve};
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
    /// The cover, where there is one.
    pub shroud: Option<FittedProfile>,
}

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
    let mut course = Course::from_blades(&corners, hub, |_| true);
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
            course = Course::from_blades(&corners, hub, |_| true);
            hub_curve = fit_revolved(hub, &course, (&corners, &*normals), "hub", tolerance)?;
        }
    }
    let shroud = shroud
        .map(|shroud| fit_revolved(shroud, &course, (&corners, &*normals), "shroud", tolerance))
        .transpose()?;
    let cover = shroud.as_ref().filter(|_| outlines[1].is_some());
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
    Ok(Walls { blades: Blades { main, splitters }, corners, course, hub: hub_curve, shroud })
}

fn fit_revolved(
    surface: &MeshSurface,
    course: &Course,
    (blades, exact): (&[Meridional], &ExactNormals),
    name: &str,
    tolerance: f64,
) -> Result<FittedProfile, PartError> {
    let side = find_flow_side(surface, course, blades, exact, name)?;
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
    if profile.max_deviation_mm > tolerance
        && let Some(straight) = fit(&straight_points(surface, &side.triangles))
        && straight.max_deviation_mm <= tolerance
    {
        return Ok(straight);
    }
    check_deviation(profile, name, tolerance)
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
