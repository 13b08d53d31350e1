//! Reconstruction of a part from named meshes.

use super::holes::fill_holes;
use super::nose::{joined_to, outline_ahead};
use super::options::{LengthUnit, MeshOptions};
use super::part_notes::{ring_note, sense_from_wrap, sides_note, splitter_note};
use super::profile::FittedProfile;
use super::roles::{NamedMesh, given_roles, roles_from_names};
use super::rows::{BladeRows, separate_blades};
use super::rulings::Rulings;
use super::sections::ChannelCoordinates;
use super::shroud_curve::ShroudSearch;
use super::shroud_ends::gone_on;
use super::sides::{SideCurve, SpanSection};
use super::source::MeshSource;
use super::span_sections::span_sections;
use super::walls::{Blades, Walls, fit_walls};
use super::wheel_about_z::{RoleSources, WheelAboutZ};
use crate::geometry::{MeridionalCurve, Point};
use crate::part::{BladeDescription, CurveDescription, Impeller, PartDescription, PartError};

/// Number of points of a side of a section.
const SECTION_POINTS: usize = 180;
/// Largest distance of the fitted straight lines from a side that is treated as ruled, mm.
const STRAIGHT: f64 = 0.012;
/// Largest distance of a corner from the curve of hub or shroud: mm, and share of the diameter.
const TOLERANCE: (f64, f64) = (0.05, 1e-4);

/// Reconstructs the part, named `name`, from its meshes, which are in the file's frame and in `unit`.
///
/// # Errors
/// As [`describe_source`].
pub fn describe(
    name: &str,
    meshes: Vec<NamedMesh>,
    unit: LengthUnit,
    options: &MeshOptions,
) -> Result<PartDescription, PartError> {
    describe_source(name, meshes, MeshSource::from_unit(unit), options)
}

/// Reconstructs the part, named `name`, from its meshes, with what their file says of them.
///
/// # Errors
/// Fails when hub or blades are missing or incomplete, when hub or shroud is not a surface of revolution, or
/// when unit, axis or number of blades cannot be derived; the help text names the option that helps.
pub fn describe_source(
    name: &str,
    meshes: Vec<NamedMesh>,
    source: MeshSource,
    options: &MeshOptions,
) -> Result<PartDescription, PartError> {
    let given = given_roles(&meshes, &options.roles)?;
    let named = roles_from_names(&meshes);
    // Only the bodies of CAD models decide roles by themselves. Nodes of other files get theirs by name, or
    // the user is asked.
    if !source.is_cad() || given.iter().zip(&named).all(|(given, named)| given.is_some() || named.is_none()) {
        return describe_roles(name, meshes, &RoleSources { given, named }, source, options);
    }
    let roles = RoleSources { given, named };
    let by_name = describe_roles(name, meshes.clone(), &roles, source.clone(), options);
    // Some roles make a description, but no wheel.
    let (error, by_name) = match by_name {
        Ok(part) => match Impeller::build(&part) {
            Ok(_) => return Ok(part),
            Err(error) => (error, Some(part)),
        },
        Err(error) => (error, None),
    };
    // Names that make no wheel are worth less than none.
    let roles = RoleSources { named: vec![None; meshes.len()], ..roles };
    let by_shape = describe_roles(name, meshes, &roles, source, options).ok();
    let by_shape = by_shape.filter(|part| Impeller::build(part).is_ok());
    match (by_shape, by_name) {
        (Some(mut part), _) => {
            part.notes.push(format!(
                "the roles that the names of the bodies say make no wheel ({}); their shapes decided",
                error.message
            ));
            part.roles_by_shape = true;
            Ok(part)
        }
        (None, Some(part)) => Ok(part),
        (None, None) => Err(error),
    }
}

/// The part of `meshes` with roles from these sources.
fn describe_roles(
    name: &str,
    meshes: Vec<NamedMesh>,
    roles: &RoleSources,
    source: MeshSource,
    options: &MeshOptions,
) -> Result<PartDescription, PartError> {
    let (is_cad, is_whole) = (source.is_cad(), source.whole);
    let wheel = WheelAboutZ::from_meshes(meshes, roles, source, options)?;
    let WheelAboutZ { hub, shroud, blades, mut normals, size, body_of_hub, hub_ahead_mm, mut notes } = wheel;
    let tolerance = TOLERANCE.0.max(2.0 * size * TOLERANCE.1);
    let BladeRows { count, main, splitters, note } =
        BladeRows::from_blades(separate_blades(blades), options.blades)?;
    notes.extend(note);
    let blades =
        Blades { main: fill_holes(main), splitters: splitters.into_iter().map(fill_holes).collect() };
    let Walls { blades, corners, course, hub: mut hub_curve, hub_ahead_mm: ahead, shroud: fitted_shroud } =
        fit_walls(blades, &hub, shroud.as_ref(), &mut normals, (size, tolerance), &mut notes)?;
    let hub_of_body = hub_curve.points.clone();
    let hub_ahead_mm = hub_ahead_mm.max(ahead);
    if hub_ahead_mm > 0.0 {
        hub_curve.points = gone_on(&hub_curve.points, hub_ahead_mm);
    }
    let Blades { main, splitters } = blades;
    let search =
        ShroudSearch { blade: &main, hub: &hub_curve.points, course: &course, size, tolerance, is_cad };
    let shroud = search.curve(fitted_shroud, &mut notes)?;
    let through = |profile: &FittedProfile| MeridionalCurve::through(&profile.points);
    let band = ChannelCoordinates::new(
        &through(&hub_curve),
        &through(&shroud.profile),
        &corners,
        shroud.goes_past_tips,
    );
    let main_corners = main.points.clone();
    let main = span_sections(&main, &band, "main blade", (&normals, is_whole), &mut notes)?;
    let splitters = splitters
        .iter()
        .map(|s| span_sections(s, &band, "splitter", (&normals, is_whole), &mut notes))
        .collect::<Result<Vec<_>, PartError>>()?;
    let (rotation, note) = match options.rotation {
        Some(rotation) => (rotation, None),
        None => sense_from_wrap(&main, course.inlet_up()),
    };
    notes.extend(note);
    notes.extend(ring_note(&main, &through(&hub_curve)));
    let body = body_of_hub.as_ref().unwrap_or(&hub);
    let ahead = outline_ahead(body, &hub_of_body, course.inlet_up(), tolerance);
    let hub_points = if ahead.is_empty() { hub_of_body } else { joined_to(&ahead, &hub_of_body) };
    let leading_first = rotation.sign_about_z(course.inlet_up()) < 0.0;
    let mut found = PartDescription {
        name: name.to_owned(),
        hub: CurveDescription::Points(hub_points),
        shroud: CurveDescription::Points(shroud.profile.points),
        blade_count: count,
        main: blade_description(&main, leading_first),
        splitters: splitters.iter().map(|s| blade_description(s, leading_first)).collect(),
        notes,
        roles_by_shape: false,
        hub_line: 0,
        shroud_line: 0,
        count_line: 0,
    };
    // What cannot be built says so itself.
    if let Ok(part) = Impeller::build(&found) {
        found.notes.extend(splitter_note(&part));
        found.notes.extend(sides_note(&part, &main_corners));
    }
    Ok(found)
}

/// The blade of `sections`. Its pressure side, which leads, is the one at smaller angles if `leading_first`.
/// A blade with two ruled sides is described by its lowest and its highest section only.
fn blade_description(sections: &[SpanSection], leading_first: bool) -> BladeDescription {
    let (suction, pressure) = if leading_first { (1, 0) } else { (0, 1) };
    let at = |k: usize| k as f64 / (SECTION_POINTS - 1) as f64;
    let side = |which: usize| -> Vec<Vec<Point>> {
        sections.iter().map(|s| (0..SECTION_POINTS).map(|k| s.sides[which].point(at(k))).collect()).collect()
    };
    let lines = |which: usize| {
        let side: Vec<&SideCurve> = sections.iter().map(|s| &s.sides[which]).collect();
        Rulings::from_sections(&side).filter(|r| r.max_distance_mm < STRAIGHT)
    };
    if let (Some(a), Some(b)) = (lines(suction), lines(pressure)) {
        let ends = |r: &Rulings, end: usize| (0..SECTION_POINTS).map(|k| r.ends(at(k))[end]).collect();
        return BladeDescription::Sections {
            suction: vec![ends(&a, 0), ends(&a, 1)],
            pressure: vec![ends(&b, 0), ends(&b, 1)],
            line: 0,
        };
    }
    let (suction, mut pressure) = (side(suction), side(pressure));
    for (a, b) in suction.iter().zip(&mut pressure) {
        b[0] = a[0];
    }
    BladeDescription::Sections { suction, pressure, line: 0 }
}
