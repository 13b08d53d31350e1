//! Reconstruction of a part from named meshes.

use super::TriangleMesh;
use super::axis::{Axis, Frame, found};
use super::edges::jump;
use super::fillets::between_fillets;
use super::holes::{filled, largest};
use super::options::{MeshOptions, Unit, check_size};
use super::profile::{Course, Profile, flow_side, middle};
use super::roles::{NamedMesh, Role, assign, listed};
use super::rows::{Rows, blades};
use super::rulings::Rulings;
use super::sections::{Band, Cutter};
use super::segment::segmented;
use super::sides::{Section, SideCurve};
use super::surface::Surface;
use super::tips::tip_curve;
use crate::geometry::{Meridional, MeridionalCurve, Point};
use crate::part::{BladeDescription, CurveDescription, PartDescription, PartError, Rotation};

/// Number of span sections of a blade.
const SECTIONS: usize = 13;
/// Number of points of a side of a section.
const SECTION_POINTS: usize = 180;
/// Distance of the outermost sections from hub and shroud as a share of the height, because slices there
/// would run along the blade's border.
const INSET: f64 = 0.01;
/// Largest distance of the fitted straight lines from a side that is treated as ruled, mm.
const STRAIGHT: f64 = 0.012;
/// Smallest height of a blade between its fillets, as a share of the channel's height.
const LEAST_HEIGHT: f64 = 0.2;
/// Holes up to this size are ignored, mm: the sections are interpolated across them.
const LEAST_HOLE: f64 = 0.05;
/// Help text for missing triangles.
const CLOSE: &str = "close the mesh, or export the surface again with all of its faces";
/// Smallest wrap of a blade from which the sense of rotation is derived without a note, rad.
const CLEAR_WRAP: f64 = 0.1;
/// Smallest share of the area of hub or shroud, without fillets, that has to be on its curve.
pub(super) const MOSTLY: f64 = 0.5;
/// Largest distance of a corner from the curve of hub or shroud: mm, and share of the diameter.
const TOLERANCE: (f64, f64) = (0.05, 1e-4);

/// Reconstructs the part, named `name`, from its meshes, which are in the file's frame and in `unit`.
///
/// # Errors
/// Fails when hub or blades are missing or incomplete, when hub or shroud is not a surface of revolution, or
/// when unit, axis or number of blades cannot be derived; the help text names the option that helps.
pub fn describe(
    name: &str,
    meshes: Vec<NamedMesh>,
    unit: Unit,
    options: &MeshOptions,
) -> Result<PartDescription, PartError> {
    let roles = assign(&meshes, &options.roles)?;
    let sorted = sorted(meshes, &roles)?;
    let scale = options.unit.unwrap_or(unit).mm();
    let Sorted { mut hub, mut shroud, blades: mut blade_meshes, one } = sorted;
    let all = || std::iter::once(&hub).chain(&shroud).chain(blade_meshes.iter().map(|(_, m)| m));
    check_size(all(), unit, options.unit)?;
    for mesh in std::iter::once(&mut hub).chain(&mut shroud).chain(blade_meshes.iter_mut().map(|(_, m)| m)) {
        mesh.points.iter_mut().for_each(|p| *p *= scale);
    }
    let hub = Surface::of(&hub);
    let frame = match options.axis {
        Some(axis) => Frame::Along(axis),
        None => found(&hub).ok_or_else(|| {
            PartError::new(0, "the hub has no axis of rotation", "give it with --rotation-axis x, y or z")
        })?,
    };
    let upright = |surface: Surface| match frame {
        Frame::Along(Axis::Z) => surface,
        _ => surface.moved(|p| frame.apply(p)),
    };
    let mut hub = upright(hub);
    let mut shroud = shroud.map(|mesh| upright(Surface::of(&mesh)));
    let mut blade_surfaces: Vec<(Role, Surface)> =
        blade_meshes.into_iter().map(|(role, mesh)| (role, upright(Surface::of(&mesh)))).collect();
    let size = hub.points.iter().map(|p| Meridional::of(p).r).fold(0.0, f64::max);
    if let Some(name) = one {
        let segments = segmented(&hub, &name)?;
        hub = segments.hub;
        shroud = shroud.or(segments.shroud);
        blade_surfaces = segments.blades.into_iter().map(|blade| (Role::Blade, blade)).collect();
    }
    let tolerance = TOLERANCE.0.max(2.0 * size * TOLERANCE.1);

    let Rows { count, main, splitters } = Rows::of(blades(blade_surfaces), options.blades)?;
    let main = filled(main);
    let splitters: Vec<Surface> = splitters.into_iter().map(filled).collect();
    let corners: Vec<Meridional> = main.points.iter().map(Meridional::of).collect();
    let course = Course::of(&corners);
    let hub_curve = turned(&hub, &course, &corners, "hub", tolerance)?;
    let shroud_curve = match shroud {
        Some(shroud) => turned(&shroud, &course, &corners, "shroud", tolerance)?,
        None => {
            let hub = MeridionalCurve::through(&hub_curve.points);
            let tips = tip_curve(std::slice::from_ref(&main), &hub, &course);
            let tips = tips.ok_or_else(|| {
                PartError::new(
                    0,
                    "no shroud curve can be fitted to the blade tips",
                    "give one with --role NODE=shroud",
                )
            })?;
            judged(tips, "line of the blade tips", tolerance)?
        }
    };
    let curve = |profile: &Profile| MeridionalCurve::through(&profile.points);
    let band = Band::new(&curve(&hub_curve), &curve(&shroud_curve), &corners);
    let mut notes = Vec::new();
    let main = sections(&main, &band, "main blade", &mut notes)?;
    let splitters = splitters
        .iter()
        .map(|s| sections(s, &band, "splitter", &mut notes))
        .collect::<Result<Vec<_>, PartError>>()?;
    let (rotation, note) = match options.rotation {
        Some(rotation) => (rotation, None),
        None => sense(&main, course.inlet_up()),
    };
    notes.extend(note);
    let leading_first = rotation.sign_about_z(course.inlet_up()) < 0.0;
    Ok(PartDescription {
        name: name.to_owned(),
        hub: CurveDescription::Points(hub_curve.points),
        shroud: CurveDescription::Points(shroud_curve.points),
        blade_count: count,
        main: blade(&main, leading_first),
        splitters: splitters.iter().map(|s| blade(s, leading_first)).collect(),
        notes,
        hub_line: 0,
        shroud_line: 0,
        count_line: 0,
    })
}

/// Meshes by role.
struct Sorted {
    hub: TriangleMesh,
    shroud: Option<TriangleMesh>,
    /// One mesh for each node and instance.
    blades: Vec<(Role, TriangleMesh)>,
    /// Name of the mesh, stored as `hub`, that holds hub and blades and is still to be segmented.
    one: Option<String>,
}

fn sorted(meshes: Vec<NamedMesh>, roles: &[Option<Role>]) -> Result<Sorted, PartError> {
    let names = listed(&meshes);
    let missing = |what: &str| {
        let cure = format!("name it with --role NODE={what}; there are: {names}");
        PartError::new(0, format!("no mesh is called {what}"), cure)
    };
    if !meshes.iter().any(|m| !m.mesh.triangles.is_empty()) {
        return Err(PartError::new(0, "holds no triangles", "export the impeller's surfaces as meshes"));
    }
    let has = |role: Role| roles.contains(&Some(role));
    let one = !has(Role::Hub) && !has(Role::Blade) && roles.contains(&None);
    if !one && !has(Role::Hub) {
        return Err(missing("hub"));
    }
    if !one && !has(Role::Blade) {
        return Err(missing("blade"));
    }
    let mut sorted = Sorted { hub: TriangleMesh::default(), shroud: None, blades: Vec::new(), one: None };
    let mut places: Vec<(usize, usize, Role)> = Vec::new();
    for (mesh, role) in meshes.into_iter().zip(roles) {
        match role {
            Some(Role::Hub) => sorted.hub.append(&mesh.mesh),
            Some(Role::Shroud) => sorted.shroud.get_or_insert_default().append(&mesh.mesh),
            Some(role @ (Role::Blade | Role::Splitter)) => {
                let place = (mesh.node, mesh.instance, *role);
                match places.iter().position(|p| *p == place) {
                    Some(at) => sorted.blades[at].1.append(&mesh.mesh),
                    None => {
                        places.push(place);
                        sorted.blades.push((*role, mesh.mesh));
                    }
                }
            }
            None if one => {
                sorted.hub.append(&mesh.mesh);
                sorted.one.get_or_insert(mesh.name);
            }
            Some(Role::Ignored) | None => {}
        }
    }
    Ok(sorted)
}

fn turned(
    surface: &Surface,
    course: &Course,
    blades: &[Meridional],
    name: &str,
    tolerance: f64,
) -> Result<Profile, PartError> {
    let side = flow_side(surface, course, blades, name)?;
    let profile = course.curve(&side.corners).ok_or_else(|| {
        PartError::new(0, format!("the {name} has no extent"), format!("check which mesh is the {name}"))
    })?;
    if profile.residual > tolerance
        && let Some(bottom) = course.bottom(&side.corners, middle(blades), tolerance)
        && bottom.share_of(surface, &side.triangles, tolerance) > MOSTLY
    {
        return Ok(bottom);
    }
    judged(profile, name, tolerance)
}

fn judged(profile: Profile, name: &str, tolerance: f64) -> Result<Profile, PartError> {
    if profile.residual > tolerance {
        return Err(PartError::new(
            0,
            format!(
                "the {name} is not a surface of revolution: {:.2} mm off at z = {:.1}, r = {:.1} mm",
                profile.residual, profile.at.z, profile.at.r
            ),
            format!("check which mesh is the {name}, and the axis of rotation (--rotation-axis)"),
        ));
    }
    Ok(profile)
}

/// Span sections of a blade; adds a note about a jump that is either its shape or due to missing triangles.
fn sections(
    surface: &Surface,
    band: &Band,
    name: &str,
    notes: &mut Vec<String>,
) -> Result<Vec<Section>, PartError> {
    let cutter = Cutter::new(surface, band);
    if let Some(hole) = largest(surface, cutter.places()).filter(|hole| hole.size > LEAST_HOLE) {
        let at = Meridional::of(&hole.middle);
        return Err(PartError::new(
            0,
            format!(
                "the {name} has a hole of {:.1} mm across at z = {:.1}, r = {:.1} mm",
                hole.size, at.z, at.r
            ),
            CLOSE,
        ));
    }
    let (low, high) = cutter.reach(40);
    let (low, high) = (low.max(0.0) + INSET, high.min(1.0) - INSET);
    if !(LEAST_HEIGHT..=1.0).contains(&(high - low)) {
        return Err(PartError::new(
            0,
            format!("the {name} does not reach from hub to shroud"),
            "check the roles of the meshes (--role NODE=hub, shroud or blade)",
        ));
    }
    let (low, high) = between_fillets(low, high, |height| Section::of(&cutter.cut(height)));
    if high - low < LEAST_HEIGHT {
        return Err(PartError::new(
            0,
            format!("the fillets of the {name} leave {:.0} % of its height", 100.0 * (high - low)),
            "export the wheel without fillets",
        ));
    }
    let at = |k: usize| low + (high - low) * k as f64 / (SECTIONS - 1) as f64;
    let section = |height: f64| {
        Section::of(&cutter.cut(height)).ok_or_else(|| {
            PartError::new(
                0,
                format!(
                    "the {name} is not a closed blade: at {:.0} % of its height it does not have two sides",
                    100.0 * height
                ),
                "close its gaps, or exclude fragments with --role NODE=ignore",
            )
        })
    };
    let sections: Vec<Section> = (0..SECTIONS).map(|k| section(at(k))).collect::<Result<_, _>>()?;
    if let Some(jump) = jump(&sections) {
        let at = Meridional::of(&jump.at);
        let place = format!("at z = {:.1}, r = {:.1} mm", at.z, at.r);
        if jump.torn {
            return Err(PartError::new(
                0,
                format!("the {} of the {name} has a gap of {:.1} mm {place}", jump.edge, jump.by),
                CLOSE,
            ));
        }
        notes.push(format!(
            "the {} of the {name} jumps by {:.1} mm {place}: if that is not its shape, \
             triangles are missing there",
            jump.edge, jump.by
        ));
    }
    Ok(sections)
}

/// The sense of rotation derived from a blade's wrap, with a note where the wrap is small.
fn sense(sections: &[Section], inlet_up: bool) -> (Rotation, Option<String>) {
    let sides = || sections.iter().flat_map(|s| &s.sides);
    let wrap = sides().map(SideCurve::turn).sum::<f64>() / sides().count().max(1) as f64;
    let rotation = Rotation::about_z(-wrap, inlet_up);
    let note = (wrap.abs() < CLEAR_WRAP).then(|| {
        format!(
            "the blades wrap by only {:.1}°, so that the suction side is uncertain: assumed to turn \
             {rotation}, seen from the inlet; if that is wrong, give --rotation {}",
            wrap.abs().to_degrees(),
            rotation.reversed().name()
        )
    });
    (rotation, note)
}

/// The blade of `sections`. Its pressure side, which leads, is the one at smaller angles if `leading_first`.
/// A blade with two ruled sides is described by its lowest and its highest section only.
fn blade(sections: &[Section], leading_first: bool) -> BladeDescription {
    let (suction, pressure) = if leading_first { (1, 0) } else { (0, 1) };
    let at = |k: usize| k as f64 / (SECTION_POINTS - 1) as f64;
    let side = |which: usize| -> Vec<Vec<Point>> {
        sections.iter().map(|s| (0..SECTION_POINTS).map(|k| s.sides[which].point(at(k))).collect()).collect()
    };
    let lines = |which: usize| {
        let side: Vec<&SideCurve> = sections.iter().map(|s| &s.sides[which]).collect();
        Rulings::of(&side).filter(|r| r.off < STRAIGHT)
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
