//! Hub, shroud and blades of a wheel, about Z and in mm: by the roles of its meshes, or by the shapes of its
//! bodies.

use super::TriangleMesh;
use super::axis::{Axis, PartFromFile, find_axis, turned_axis};
use super::bodies::{Body, SortedBodies, WheelBodies, sort_bodies};
use super::nodes::width_of_wheel_in;
use super::normals::ExactNormals;
use super::options::{MeshOptions, size_fault};
use super::roles::{NamedMesh, Role, listed};
use super::round::radii;
use super::segment::{Segments, segment_wheel};
use super::source::MeshSource;
use super::surface::MeshSurface;
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::part::PartError;

/// Where the roles of meshes come from, one by one.
pub(super) struct RoleSources {
    /// What the user says.
    pub given: Vec<Option<Role>>,
    /// What names say.
    pub named: Vec<Option<Role>>,
}

/// The surfaces of a wheel.
pub(super) struct WheelAboutZ {
    pub hub: MeshSurface,
    pub shroud: Option<MeshSurface>,
    pub blades: Vec<(Role, MeshSurface)>,
    /// Normals of the surfaces of a CAD model at corners of its meshes.
    pub normals: ExactNormals,
    /// Radius of the rim, mm.
    pub size: f64,
    /// The body whose flow side the hub is, where it is another one.
    pub body_of_hub: Option<MeshSurface>,
    /// As [`Segments::hub_ahead_mm`].
    pub hub_ahead_mm: f64,
    /// What the user should know of it.
    pub notes: Vec<String>,
}

impl WheelAboutZ {
    /// The wheel of `meshes`, one role of each source for each.
    ///
    /// # Errors
    /// When hub or blades are missing, when they cannot be distinguished, or without a plausible size
    /// or an axis.
    pub fn from_meshes(
        meshes: Vec<NamedMesh>,
        roles: &RoleSources,
        source: MeshSource,
        options: &MeshOptions,
    ) -> Result<Self, PartError> {
        let is_cad = source.is_cad();
        let MeshSource { unit, axis, mut notes, normals, .. } = source;
        let scale = options.unit.unwrap_or(unit).mm();
        let size_fault = fault_of_size(&meshes, roles, scale);
        let sorted = sort_by_role(meshes, roles, is_cad)?;
        if let Some(fault) = size_fault {
            return Err(fault);
        }
        let SortedMeshes { hub, shroud, blades, one, bodies, without_role } = sorted.scaled(scale);
        if !without_role.is_empty() {
            notes.push(format!(
                "left out, without a role: {}; where one belongs to the wheel give --role NODE=blade, splitter, hub \
                 or shroud",
                listed(&without_role)
            ));
        }
        let hub = MeshSurface::from_mesh(&hub);
        let bodies: Vec<Body> = if is_cad && bodies.len() > 1 {
            bodies.into_iter().map(NamedBody::into_body).collect()
        } else {
            Vec::new()
        };
        let axis = axis.map(|(through, along)| (through * scale, along));
        let frame = frame_of(options.axis, axis, &hub, &bodies)?;
        let about_z = |surface: MeshSurface| match frame {
            PartFromFile::Along(Axis::Z) => surface,
            _ => surface.transformed(|p| frame.apply(p)),
        };
        let scaled = |p: &Point| Point::from(p.coords * scale);
        let normals = match frame {
            PartFromFile::Along(Axis::Z) => normals,
            _ => normals.transformed(|p| frame.apply(&scaled(p))),
        };
        let mut hub = about_z(hub);
        let mut shroud = shroud.map(|mesh| about_z(MeshSurface::from_mesh(&mesh)));
        let blades =
            blades.into_iter().map(|(role, mesh)| (role, about_z(MeshSurface::from_mesh(&mesh)))).collect();
        // Roles that were proposed from shapes and confirmed make the part that shapes make alone.
        if roles.given.iter().any(Option::is_some) {
            hub = hub.in_order_of_use();
            shroud = shroud.map(MeshSurface::in_order_of_use);
        }
        let (size, body_of_hub, hub_ahead_mm) = (radius(&hub), None, 0.0);
        let mut wheel = Self { hub, shroud, blades, normals, size, body_of_hub, hub_ahead_mm, notes };
        if let Some(one) = one {
            let bodies = bodies.into_iter().map(|b| Body { surface: about_z(b.surface), ..b }).collect();
            wheel.take_by_shape(&one, bodies)?;
        }
        Ok(wheel)
    }

    /// Takes hub and blades from the shapes of `bodies`, or else from the hub, which then holds all of them.
    fn take_by_shape(&mut self, one: &OneMesh, bodies: Vec<Body>) -> Result<(), PartError> {
        let segments_of = |body: &Body| segment_wheel(&body.surface, &self.normals, &body.name);
        let found = match sort_bodies(bodies, |body| segments_of(body).is_ok(), &mut self.notes) {
            SortedBodies::Separate(found) => {
                let parts = std::iter::once(&found.hub).chain(&found.shroud);
                let parts = parts.chain(found.blades.iter().map(|(_, blade)| blade));
                self.size = parts.map(radius).fold(0.0, f64::max);
                found
            }
            SortedBodies::InOne(body, note) => match segments_of(&body) {
                Ok(segments) => {
                    self.size = radius(&body.surface);
                    self.notes.push(note);
                    self.body_of_hub = Some(body.surface);
                    self.bodies_of(segments)
                }
                Err(alone) => {
                    let segments = self.segments_of_hub(one).map_err(|_| alone)?;
                    self.bodies_of(segments)
                }
            },
            SortedBodies::Unknown => {
                let segments = self.segments_of_hub(one)?;
                self.body_of_hub = Some(std::mem::take(&mut self.hub));
                self.bodies_of(segments)
            }
        };
        self.hub = found.hub;
        self.shroud = self.shroud.take().or(found.shroud);
        self.blades = found.blades;
        Ok(())
    }

    /// Segments the hub, which holds all of the wheel.
    fn segments_of_hub(&self, OneMesh { name, missing }: &OneMesh) -> Result<Segments, PartError> {
        match missing {
            Some(missing) => Err(missing.clone()),
            None => segment_wheel(&self.hub, &self.normals, name),
        }
    }

    fn bodies_of(&mut self, segments: Segments) -> WheelBodies {
        let Segments { hub, hub_ahead_mm, shroud, blades } = segments;
        self.hub_ahead_mm = hub_ahead_mm;
        let blades = blades.into_iter().map(|blade| (Role::Blade, blade)).collect();
        WheelBodies { hub, shroud, blades }
    }
}

fn radius(surface: &MeshSurface) -> f64 {
    radii(surface).1
}

/// The frame in which the wheel is about Z: by the `asked` axis, by the `exact` one of the file, in mm, or by
/// the shape of the bodies or of the hub.
fn frame_of(
    asked: Option<Axis>,
    exact: Option<(Point, Vector)>,
    hub: &MeshSurface,
    bodies: &[Body],
) -> Result<PartFromFile, PartError> {
    match (asked, exact) {
        (Some(axis), _) => Ok(PartFromFile::Along(axis)),
        (None, Some((through, along))) => Ok(PartFromFile::about(&through, &along)),
        (None, None) => axis_of_bodies(bodies).or_else(|| find_axis(hub)).ok_or_else(|| {
            PartError::new(
                ErrorCode::NoRotationAxis,
                0,
                "the hub has no axis of rotation",
                "give it with --rotation-axis x, y or z",
            )
        }),
    }
}

/// The axis of the largest of several bodies that is one of revolution.
fn axis_of_bodies(bodies: &[Body]) -> Option<PartFromFile> {
    let area = |b: &Body| (0..b.surface.triangles.len()).map(|t| b.surface.area(t)).sum::<f64>();
    let mut by_area: Vec<(f64, &Body)> = bodies.iter().map(|b| (area(b), b)).collect();
    by_area.sort_by(|a, b| b.0.total_cmp(&a.0));
    by_area.iter().take(4).find_map(|(_, body)| turned_axis(&body.surface))
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
    /// Those of which nobody says what they are, beside others with roles.
    without_role: Vec<NamedMesh>,
}

impl SortedMeshes {
    /// The same in mm, with `scale` mm for each unit.
    fn scaled(mut self, scale: f64) -> Self {
        let blades = self.blades.iter_mut().map(|(_, mesh)| mesh);
        let meshes = std::iter::once(&mut self.hub).chain(&mut self.shroud).chain(blades);
        let meshes = meshes.chain(self.bodies.iter_mut().map(|body| &mut body.mesh));
        meshes.flat_map(|mesh| &mut mesh.points).for_each(|p| *p *= scale);
        self
    }
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

impl NamedBody {
    fn into_body(self) -> Body {
        let Self { name, role, given, mesh } = self;
        Body { name, role, given, surface: MeshSurface::from_mesh(&mesh) }
    }
}

/// Sorts meshes by their roles: as the user says, or else as their names do.
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
        without_role: Vec::new(),
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
            None if mesh.mesh.triangles.is_empty() => {}
            None => sorted.without_role.push(mesh),
        }
    }
    Ok(sorted)
}
