//! Reconstruction of a part from named meshes.

use super::TriangleMesh;
use super::axis::{Axis, PartFromFile, find_axis, turned_axis};
use super::bodies::{Body, SortedBodies, WheelBodies, sort_bodies};
use super::holes::fill_holes;
use super::nodes::width_of_wheel_in;
use super::normals::ExactNormals;
use super::nose::{joined_to, outline_ahead};
use super::options::{LengthUnit, MeshOptions, size_fault};
use super::part_notes::{ring_note, sense_from_wrap, sides_note};
use super::profile::FittedProfile;
use super::roles::{NamedMesh, Role, given_roles, listed, roles_from_names};
use super::round::radii;
use super::rows::{BladeRows, separate_blades};
use super::rulings::Rulings;
use super::sections::ChannelCoordinates;
use super::segment::{Segments, segment_wheel};
use super::shroud_ends::{extend_ahead, gone_on};
use super::sides::{SideCurve, SpanSection};
use super::span_sections::span_sections;
use super::surface::MeshSurface;
use super::tip_border::{covered_share, fit_tip_border, past_share, tip_extent};
use super::tip_faces::fit_tip_faces;
use super::tips::fit_tip_curve;
use super::walls::{Blades, Walls, check_deviation, fit_walls};
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve, Point, Vector};
use crate::part::{BladeDescription, CurveDescription, Impeller, PartDescription, PartError};

/// Number of points of a side of a section.
const SECTION_POINTS: usize = 180;
/// Largest distance of the fitted straight lines from a side that is treated as ruled, mm.
const STRAIGHT: f64 = 0.012;
/// Largest distance of a corner from the curve of hub or shroud: mm, and share of the diameter.
const TOLERANCE: (f64, f64) = (0.05, 1e-4);
/// Largest distance of a blade tip from the line of the tips, as a share of the diameter: tips are often not
/// turned in a model.
const TIP_TOLERANCE: f64 = 2e-3;
/// Share of the tips along the channel that the curve through their edges has to go along.
const MOST_OF_TIPS: f64 = 0.8;
/// How far that curve may go on past the tips, as a share of them.
const PAST_TIPS: f64 = 0.015;

/// What a file says of its meshes.
#[derive(Clone, Debug)]
pub struct MeshSource {
    /// Unit of its coordinates.
    pub unit: LengthUnit,
    /// Axis of the surfaces of revolution, exact: a point, in the file's unit, and the direction.
    pub axis: Option<(Point, Vector)>,
    /// What the user should know of it.
    pub notes: Vec<String>,
    /// Normals of its surfaces at corners of its meshes.
    pub normals: ExactNormals,
    /// Whether its bodies are solids without gaps.
    pub whole: bool,
}

impl MeshSource {
    /// Meshes of which only the unit is known.
    pub fn from_unit(unit: LengthUnit) -> Self {
        Self { unit, axis: None, notes: Vec::new(), normals: ExactNormals::default(), whole: false }
    }
}

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
    let is_cad = !source.normals.is_empty() || source.axis.is_some();
    if !is_cad || given.iter().zip(&named).all(|(given, named)| given.is_some() || named.is_none()) {
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

/// The fault of meshes whose wheel has no plausible size in units of `unit_mm`.
fn fault_of_size(meshes: &[NamedMesh], roles: &RoleSources, unit_mm: f64) -> Option<PartError> {
    let points = || meshes.iter().flat_map(|m| &m.mesh.points);
    let first = *points().next()?;
    let (low, high) = points().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    // Bodies beside the wheel do not count, such as a splinter far from it.
    size_fault((high - low).amax(), unit_mm)
        .and_then(|_| size_fault(width_of_wheel_in(meshes, &roles.given), unit_mm))
}

/// Where the roles of meshes come from, one by one.
struct RoleSources {
    /// What the user says.
    given: Vec<Option<Role>>,
    /// What names say.
    named: Vec<Option<Role>>,
}

fn describe_roles(
    name: &str,
    meshes: Vec<NamedMesh>,
    roles: &RoleSources,
    source: MeshSource,
    options: &MeshOptions,
) -> Result<PartDescription, PartError> {
    let MeshSource { unit, axis, mut notes, normals, whole } = source;
    let is_cad = !normals.is_empty() || axis.is_some();
    let scale = options.unit.unwrap_or(unit).mm();
    let size_fault = fault_of_size(&meshes, roles, scale);
    let sorted = sort_by_role(meshes, roles, is_cad)?;
    if let Some(fault) = size_fault {
        return Err(fault);
    }
    let SortedMeshes { mut hub, mut shroud, blades: mut blade_meshes, one, mut bodies } = sorted;
    for mesh in std::iter::once(&mut hub).chain(&mut shroud).chain(blade_meshes.iter_mut().map(|(_, m)| m)) {
        mesh.points.iter_mut().for_each(|p| *p *= scale);
    }
    bodies.iter_mut().flat_map(|body| &mut body.mesh.points).for_each(|p| *p *= scale);
    let hub = MeshSurface::from_mesh(&hub);
    let body = |NamedBody { name, role, given, mesh }: NamedBody| Body {
        name,
        role,
        given,
        surface: MeshSurface::from_mesh(&mesh),
    };
    let bodies: Vec<Body> =
        if is_cad && bodies.len() > 1 { bodies.into_iter().map(body).collect() } else { Vec::new() };
    let frame = match (options.axis, axis) {
        (Some(axis), _) => PartFromFile::Along(axis),
        (None, Some((through, along))) => PartFromFile::about(&(through * scale), &along),
        (None, None) => axis_of_bodies(&bodies).or_else(|| find_axis(&hub)).ok_or_else(|| {
            PartError::new(
                ErrorCode::NoRotationAxis,
                0,
                "the hub has no axis of rotation",
                "give it with --rotation-axis x, y or z",
            )
        })?,
    };
    let about_z = |surface: MeshSurface| match frame {
        PartFromFile::Along(Axis::Z) => surface,
        _ => surface.transformed(|p| frame.apply(p)),
    };
    let scaled = |p: &Point| Point::from(p.coords * scale);
    let mut normals = match frame {
        PartFromFile::Along(Axis::Z) => normals,
        _ => normals.transformed(|p| frame.apply(&scaled(p))),
    };
    let mut hub = about_z(hub);
    let mut shroud = shroud.map(|mesh| about_z(MeshSurface::from_mesh(&mesh)));
    let mut blade_surfaces: Vec<(Role, MeshSurface)> =
        blade_meshes.into_iter().map(|(role, mesh)| (role, about_z(MeshSurface::from_mesh(&mesh)))).collect();
    // Roles that were proposed from shapes and confirmed make the part that shapes make alone.
    if roles.given.iter().any(Option::is_some) {
        hub = hub.in_order_of_use();
        shroud = shroud.map(MeshSurface::in_order_of_use);
    }
    let radius = |surface: &MeshSurface| radii(surface).1;
    let mut size = radius(&hub);
    // The body whose flow side the hub is.
    let mut body_of_hub: Option<MeshSurface> = None;
    let mut hub_ahead_mm = 0.0;
    if let Some(OneMesh { name, missing }) = one {
        let bodies =
            bodies.into_iter().map(|b| Body { surface: about_z(b.surface), ..b }).collect::<Vec<Body>>();
        let whole = |hub: &MeshSurface, name: &str| match &missing {
            Some(missing) => Err(missing.clone()),
            None => segment_wheel(hub, &normals, name),
        };
        let mut wheel = |Segments { hub, hub_ahead_mm: ahead, shroud, blades }: Segments| {
            hub_ahead_mm = ahead;
            let blades = blades.into_iter().map(|blade| (Role::Blade, blade)).collect();
            WheelBodies { hub, shroud, blades }
        };
        let is_wheel = |body: &Body| segment_wheel(&body.surface, &normals, &body.name).is_ok();
        let found = match sort_bodies(bodies, is_wheel, &mut notes) {
            SortedBodies::Separate(found) => {
                let parts = std::iter::once(&found.hub).chain(&found.shroud);
                size =
                    parts.chain(found.blades.iter().map(|(_, blade)| blade)).map(radius).fold(0.0, f64::max);
                found
            }
            SortedBodies::InOne(body, note) => match segment_wheel(&body.surface, &normals, &body.name) {
                Ok(segments) => {
                    size = radius(&body.surface);
                    notes.push(note);
                    body_of_hub = Some(body.surface);
                    wheel(segments)
                }
                Err(alone) => wheel(whole(&hub, &name).map_err(|_| alone)?),
            },
            SortedBodies::Unknown => {
                let found = wheel(whole(&hub, &name)?);
                body_of_hub = Some(std::mem::take(&mut hub));
                found
            }
        };
        hub = found.hub;
        shroud = shroud.or(found.shroud);
        blade_surfaces = found.blades;
    }
    let tolerance = TOLERANCE.0.max(2.0 * size * TOLERANCE.1);
    let tip_tolerance = tolerance.max(2.0 * size * TIP_TOLERANCE);

    let BladeRows { count, main, splitters, note } =
        BladeRows::from_blades(separate_blades(blade_surfaces), options.blades)?;
    notes.extend(note);
    let blades =
        Blades { main: fill_holes(main), splitters: splitters.into_iter().map(fill_holes).collect() };
    let Walls { blades, corners, course, hub: mut hub_curve, hub_ahead_mm: ahead, shroud: fitted_shroud } =
        fit_walls(blades, &hub, shroud.as_ref(), &mut normals, (size, tolerance), &mut notes)?;
    let hub_of_body = hub_curve.points.clone();
    hub_ahead_mm = hub_ahead_mm.max(ahead);
    if hub_ahead_mm > 0.0 {
        hub_curve.points = gone_on(&hub_curve.points, hub_ahead_mm);
    }
    let Blades { main, splitters } = blades;
    let through = |profile: &FittedProfile| MeridionalCurve::through(&profile.points);
    // With whether the tips turn into leading and trailing edge past its ends.
    let (shroud_curve, past_tips) = match fitted_shroud {
        Some(mut shroud) => {
            let mut past = goes_past(&main, &through(&shroud), tolerance);
            if !past && let Some(ahead) = extend_ahead(&mut shroud, &hub_curve.points, &main) {
                notes.push(format!(
                    "the blades begin {ahead:.2} mm ahead of the shroud, which goes on along their tips"
                ));
                past = goes_past(&main, &through(&shroud), tolerance);
            }
            (shroud, past)
        }
        None => {
            let by_edges = || {
                let hub = MeridionalCurve::through(&hub_curve.points);
                Some((fit_tip_curve(std::slice::from_ref(&main), &hub, &course)?, false))
            };
            let by_border = || Some((fit_tip_border(&main, &hub_curve.points, &course)?, true));
            // Edges of tips that are not turned make a curve along part of them only, and those of leading
            // edges may lead it on past them.
            let along_tips = || {
                let extent = tip_extent(&main, &hub_curve.points, &course);
                by_edges().filter(|(tips, _)| {
                    extent.is_none_or(|extent| {
                        let is_within = past_share(&tips.points, extent, &course) < PAST_TIPS;
                        is_within && covered_share(&tips.points, extent, &course) > MOST_OF_TIPS
                    })
                })
            };
            let by_faces = || {
                let tips = fit_tip_faces(&main, &hub_curve.points, &course)?;
                (tips.max_deviation_mm < tolerance).then_some((tips, false))
            };
            // Meshes show their tips by sharp edges; models from CAD, which know their faces, often have
            // none.
            let tips = match is_cad {
                false => along_tips().or_else(by_border).or_else(by_edges),
                true => by_faces().or_else(by_border).or_else(by_edges),
            };
            let (tips, past_tips) = tips.ok_or_else(|| {
                PartError::new(
                    ErrorCode::NoShroud,
                    0,
                    "no shroud curve can be fitted to the blade tips",
                    "give one with --role NODE=shroud",
                )
            })?;
            let off = tips.max_deviation_mm;
            if off > tolerance {
                notes.push(format!(
                    "the blade tips are up to {off:.2} mm off the surface of revolution through them"
                ));
            }
            (check_deviation(tips, "line of the blade tips", tip_tolerance)?, past_tips)
        }
    };
    let band = ChannelCoordinates::new(&through(&hub_curve), &through(&shroud_curve), &corners, past_tips);
    let main_corners = main.points.clone();
    let main = span_sections(&main, &band, "main blade", (&normals, whole), &mut notes)?;
    let splitters = splitters
        .iter()
        .map(|s| span_sections(s, &band, "splitter", (&normals, whole), &mut notes))
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
        shroud: CurveDescription::Points(shroud_curve.points),
        blade_count: count,
        main: blade_description(&main, leading_first),
        splitters: splitters.iter().map(|s| blade_description(s, leading_first)).collect(),
        notes,
        roles_by_shape: false,
        hub_line: 0,
        shroud_line: 0,
        count_line: 0,
    };
    found.notes.extend(sides_note(&found, &main_corners));
    Ok(found)
}

/// Meshes by role.
struct SortedMeshes {
    hub: TriangleMesh,
    shroud: Option<TriangleMesh>,
    /// One mesh for each node and instance.
    blades: Vec<(Role, TriangleMesh)>,
    /// The mesh, stored as `hub`, that holds hub and blades and is still to be segmented.
    one: Option<OneMesh>,
    /// The bodies in `hub`, if they are to be segmented: one for each node and instance.
    bodies: Vec<NamedBody>,
}

/// Meshes of which not all roles are known.
struct OneMesh {
    /// Name of the first.
    name: String,
    /// The fault where they are to be bodies of which some have roles, and shapes do not tell the others.
    missing: Option<PartError>,
}

/// A body with what is known of its role.
struct NamedBody {
    name: String,
    role: Option<Role>,
    /// Whether the user says it.
    given: bool,
    mesh: TriangleMesh,
}

/// Whether the tips of a blade go on past an end of its shroud, straight within `tolerance`, mm.
fn goes_past(blade: &MeshSurface, shroud: &MeridionalCurve, tolerance: f64) -> bool {
    let inside = -tolerance..=shroud.length() + tolerance;
    let is_past = |p: &Point| {
        let (t, off) = shroud.project_past_ends(Meridional::from_point(p));
        off.abs() < tolerance && !inside.contains(&t)
    };
    blade.points.iter().any(is_past)
}

/// The axis of the largest of several bodies that is one of revolution.
fn axis_of_bodies(bodies: &[Body]) -> Option<PartFromFile> {
    let area = |b: &Body| (0..b.surface.triangles.len()).map(|t| b.surface.area(t)).sum::<f64>();
    let mut by_area: Vec<(f64, &Body)> = bodies.iter().map(|b| (area(b), b)).collect();
    by_area.sort_by(|a, b| b.0.total_cmp(&a.0));
    by_area.iter().take(4).find_map(|(_, body)| turned_axis(&body.surface))
}

fn sort_by_role(
    meshes: Vec<NamedMesh>,
    roles: &RoleSources,
    is_cad: bool,
) -> Result<SortedMeshes, PartError> {
    let names = listed(&meshes);
    let missing = |what: &str| {
        let help = format!("give one with --role NODE={what}; there are: {names}");
        PartError::new(ErrorCode::MeshRoles, 0, format!("no mesh has the role {what}"), help)
    };
    if !meshes.iter().any(|m| !m.mesh.triangles.is_empty()) {
        return Err(PartError::new(
            ErrorCode::NoTriangles,
            0,
            "holds no triangles",
            "export the impeller's surfaces as meshes",
        ));
    }
    let known: Vec<Option<Role>> =
        roles.given.iter().zip(&roles.named).map(|(given, named)| given.or(*named)).collect();
    let has = |role: Role| known.contains(&Some(role));
    let fault = [Role::Hub, Role::Blade].into_iter().find(|role| !has(*role)).map(|r| missing(r.name()));
    let unknown = known.contains(&None);
    let none_known = !has(Role::Hub) && !has(Role::Blade) && unknown;
    let by_shape = none_known || (is_cad && fault.is_some());
    let fault = if none_known { None } else { fault };
    if let (false, Some(fault)) = (by_shape, &fault) {
        return Err(fault.clone());
    }
    let mut sorted = SortedMeshes {
        hub: TriangleMesh::default(),
        shroud: None,
        blades: Vec::new(),
        one: None,
        bodies: Vec::new(),
    };
    let mut body_of: Vec<(usize, usize)> = Vec::new();
    let mut places: Vec<(usize, usize, Role)> = Vec::new();
    for ((mesh, role), given) in meshes.into_iter().zip(known).zip(&roles.given) {
        match role {
            Some(Role::Ignored) => {}
            _ if by_shape && (is_cad || role.is_none()) => {
                sorted.hub.append(&mesh.mesh);
                let place = (mesh.node, mesh.instance);
                match body_of.iter().position(|p| *p == place) {
                    Some(at) => sorted.bodies[at].mesh.append(&mesh.mesh),
                    None => {
                        body_of.push(place);
                        let (name, given) = (mesh.name.clone(), given.is_some());
                        sorted.bodies.push(NamedBody { name, role, given, mesh: mesh.mesh });
                    }
                }
                sorted.one.get_or_insert_with(|| OneMesh { name: mesh.name, missing: fault.clone() });
            }
            Some(Role::Hub) => sorted.hub.append(&mesh.mesh),
            Some(Role::Shroud) => sorted.shroud.get_or_insert_default().append(&mesh.mesh),
            Some(role @ (Role::Blade | Role::Splitter)) => {
                let place = (mesh.node, mesh.instance, role);
                match places.iter().position(|p| *p == place) {
                    Some(at) => sorted.blades[at].1.append(&mesh.mesh),
                    None => {
                        places.push(place);
                        sorted.blades.push((role, mesh.mesh));
                    }
                }
            }
            None => {}
        }
    }
    Ok(sorted)
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
