//! Triangles of a body, with the face of each, and whether it is closed.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::atomic::AtomicUsize;

use super::assembly::PlacedBody;
use super::edges::{EdgePoints, StepFineness};
use super::face::mesh_face;
use super::model::{EntityArguments, EntityFault, EntityResult, Model};
use super::shape::ShapeReader;
use super::surface::Surface;
use crate::geometry::{Point, Vector, bits_of};
use crate::mesh::TriangleMesh;

/// How often a body is meshed again, each time this many times finer, where borders of its faces cross.
const RETRIES: i32 = 2;
const FINER: f64 = 0.25;

/// Kind of the surface of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// A plane.
    Plane,
    /// A cylinder or cone.
    Cone,
    /// A sphere.
    Sphere,
    /// A torus.
    Torus,
    /// Another surface of revolution.
    Revolution,
    /// A surface of extrusion.
    Extrusion,
    /// A B-spline, or a surface offset from another.
    Free,
}

/// A face of a meshed body.
#[derive(Clone, Debug)]
pub struct BodyFace {
    /// Its instance in the file.
    pub id: u32,
    /// Kind of its surface.
    pub kind: SurfaceKind,
    /// Axis of its surface of revolution: a point (mm) and the unit direction, in the file's frame.
    pub axis: Option<(Point, Vector)>,
}

/// A body as triangles, in the file's frame.
#[derive(Clone, Debug)]
pub struct MeshedBody {
    /// Its instance in the file.
    pub id: u32,
    /// Its name.
    pub name: String,
    /// Names of the components it is in, the innermost first.
    pub parents: Vec<String>,
    /// Its triangles, mm.
    pub mesh: TriangleMesh,
    /// The face of each triangle, an index into `faces`.
    pub face_of: Vec<u32>,
    /// Its faces.
    pub faces: Vec<BodyFace>,
    /// Points of its triangles on free-form faces with the unit normals of these, of either sign.
    pub normals: Vec<(Point, Vector)>,
    /// Whether the file says that it is a solid.
    pub solid: bool,
    /// Number of edges that do not have a triangle on both sides.
    pub open_edges: usize,
    /// Faces that are not whole: instance, and why.
    pub faults: Vec<(u32, &'static str)>,
}

impl MeshedBody {
    /// Its triangles with corners of their own for each face, from which the reconstruction of a part takes
    /// where faces meet.
    pub fn by_face(&self) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        let mut number: HashMap<(u32, u32), u32> = HashMap::new();
        for (t, face) in self.mesh.triangles.iter().zip(&self.face_of) {
            let corners = t.map(|i| {
                *number.entry((*face, i)).or_insert_with(|| {
                    mesh.points.push(self.mesh.points[i as usize]);
                    (mesh.points.len() - 1) as u32
                })
            });
            mesh.triangles.push(corners);
        }
        mesh
    }
}

/// Whether a body is a sheet, or several.
pub fn is_sheet(model: &Model<'_>, body: &PlacedBody) -> bool {
    let sheets = ["SHELL_BASED_SURFACE_MODEL", "FACE_BASED_SURFACE_MODEL"];
    model.exchange.get(body.id).is_some_and(|i| sheets.iter().any(|name| i.record(name).is_some()))
}

/// Meshes a solid, or sheets at one place as one body; also returns the number of faces of each.
///
/// # Errors
/// When the group is empty, or an instance it needs is missing or not understood.
pub fn mesh_group(
    model: &Model<'_>,
    group: &[PlacedBody],
    fineness: StepFineness,
    budget: &AtomicUsize,
) -> EntityResult<(MeshedBody, Vec<usize>)> {
    let body = group.first().ok_or_else(|| EntityFault::new(0, "has no bodies"))?;
    let reader = ShapeReader { model, units: body.units, budget };
    let (mut faces, mut counts, mut solid) = (Vec::new(), Vec::new(), true);
    for body in group {
        let (own, is_solid) = faces_of(model, body.id)?;
        counts.push(own.len());
        faces.extend(own);
        solid &= is_solid;
    }
    let join_mm = if solid { 0.0 } else { fineness.join_mm };
    let mut best: Option<MeshedBody> = None;
    for attempt in 0..=RETRIES {
        let finer = FINER.powi(attempt);
        let (chord_mm, turn_rad) = (fineness.chord_mm * finer, fineness.turn_rad * finer.sqrt());
        let fineness = StepFineness { chord_mm, turn_rad, join_mm };
        let meshed = mesh_once(reader, body, &faces, solid, fineness)?;
        let worse = |m: &MeshedBody| (m.faults.len(), if solid { m.open_edges } else { 0 });
        let crossing = meshed.faults.iter().any(|(_, why)| why.contains("cross"));
        if best.as_ref().is_none_or(|b| worse(&meshed) < worse(b)) {
            best = Some(meshed);
        }
        if !crossing {
            break;
        }
    }
    best.map(|best| (best, counts)).ok_or_else(|| EntityFault::new(body.id, "has no faces"))
}

/// Faces of a body with whether each is reversed, and whether the body is a solid.
fn faces_of(model: &Model<'_>, id: u32) -> EntityResult<(Vec<(u32, bool)>, bool)> {
    let instance = model.instance(id, id)?;
    let of = |name: &str| instance.record(name).map(|v| EntityArguments::new(id, v));
    let mut shells: Vec<u32> = Vec::new();
    let mut solid = true;
    // The complex form of a solid has its attributes in separate records.
    if let Some(a) =
        of("MANIFOLD_SOLID_BREP").or_else(|| of("FACETED_BREP")).or_else(|| of("BREP_WITH_VOIDS"))
    {
        let shell = (0..2).find_map(|k| a.optional(k));
        shells.push(shell.ok_or_else(|| EntityFault::new(id, "has no outer shell"))?);
    }
    if let Some(a) = of("BREP_WITH_VOIDS") {
        let voids = (0..3).filter_map(|k| a.references(k).ok()).next();
        shells.extend(voids.unwrap_or_default());
    }
    if let Some(a) = of("SHELL_BASED_SURFACE_MODEL").or_else(|| of("FACE_BASED_SURFACE_MODEL")) {
        solid = false;
        shells.extend(a.references(1)?);
    }
    let mut faces = Vec::new();
    for shell in shells {
        let mut id_of_shell = shell;
        let mut reversed = false;
        let s = model.instance(id, shell)?;
        let mut record = None;
        if let Some(values) = s.record("ORIENTED_CLOSED_SHELL") {
            let o = EntityArguments::new(shell, values);
            reversed = !o.is_true(3)?;
            id_of_shell = o.reference(2)?;
        } else {
            record = s
                .record("CLOSED_SHELL")
                .or_else(|| s.record("OPEN_SHELL"))
                .or_else(|| s.record("CONNECTED_FACE_SET"));
        }
        let a = match record {
            Some(values) => EntityArguments::new(shell, values),
            None => {
                model.expect(shell, id_of_shell, &["CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET"])?
            }
        };
        for face in a.references(1)? {
            let oriented = model.instance(id_of_shell, face)?.record("ORIENTED_FACE");
            match oriented.map(|v| EntityArguments::new(face, v)) {
                Some(o) => faces.push((o.reference(2)?, reversed ^ !o.is_true(3)?)),
                None => faces.push((face, reversed)),
            }
        }
    }
    if faces.is_empty() { Err(EntityFault::new(id, "has no faces")) } else { Ok((faces, solid)) }
}

/// Edges of faces that are curved in both directions.
fn curved_edges(model: &Model<'_>, faces: &[(u32, bool)]) -> HashSet<u32> {
    const STRAIGHT: [&str; 4] =
        ["PLANE", "CYLINDRICAL_SURFACE", "CONICAL_SURFACE", "SURFACE_OF_LINEAR_EXTRUSION"];
    let get = |id: u32, keywords: &[&str]| model.expect(id, id, keywords).ok();
    let mut curved = HashSet::new();
    for (face, _) in faces {
        let Some(a) = get(*face, &["ADVANCED_FACE", "FACE_SURFACE"]) else { continue };
        let surface = a.optional(2).and_then(|id| model.exchange.get(id));
        if surface.is_none_or(|s| STRAIGHT.iter().any(|kind| s.record(kind).is_some())) {
            continue;
        }
        for bound in a.references(1).unwrap_or_default() {
            let edges = get(bound, &["FACE_OUTER_BOUND", "FACE_BOUND"])
                .and_then(|b| get(b.optional(1)?, &["EDGE_LOOP"]))
                .and_then(|l| l.references(1).ok());
            let oriented = edges.unwrap_or_default().into_iter();
            curved.extend(oriented.filter_map(|o| get(o, &["ORIENTED_EDGE"])?.optional(3)));
        }
    }
    curved
}

fn mesh_once(
    reader: ShapeReader<'_, '_>,
    body: &PlacedBody,
    faces: &[(u32, bool)],
    solid: bool,
    fineness: StepFineness,
) -> EntityResult<MeshedBody> {
    let mut edges = EdgePoints::new(reader, fineness, curved_edges(reader.model, faces));
    let mut meshed = MeshedBody {
        id: body.id,
        name: body.name.clone(),
        parents: body.parents.clone(),
        mesh: TriangleMesh::default(),
        face_of: Vec::new(),
        faces: Vec::new(),
        normals: Vec::new(),
        solid,
        open_edges: 0,
        faults: Vec::new(),
    };
    let origin = body.placement.apply(&Point::origin());
    let mut against_borders = Vec::new();
    for (id, reversed) in faces {
        let face = mesh_face(reader, &mut edges, *id, fineness)?;
        let number = meshed.faces.len() as u32;
        meshed.face_of.extend(std::iter::repeat_n(number, face.triangles.len()));
        if face.against_borders {
            against_borders.push(number);
        }
        let turned = |t: [u32; 3]| if *reversed { [t[0], t[2], t[1]] } else { t };
        meshed.mesh.triangles.extend(face.triangles.into_iter().map(turned));
        let direction = |d: Vector| body.placement.apply(&Point::from(d)) - origin;
        let axis = face.surface.axis().map(|(p, d)| (body.placement.apply(&p), direction(d)));
        let placed = |(number, normal): (u32, Vector)| {
            Some((body.placement.apply(edges.points.get(number as usize)?), direction(normal)))
        };
        meshed.normals.extend(face.normals.into_iter().filter_map(placed));
        meshed.faces.push(BodyFace { id: *id, kind: kind_of(&face.surface), axis });
        meshed.faults.extend(face.fault.map(|why| (*id, why)));
    }
    meshed.mesh.points = edges.points.iter().map(|p| body.placement.apply(p)).collect();
    meshed.mesh = meshed.mesh.compact();
    meshed.open_edges = open_edges(&meshed.mesh);
    meshed.turn_where_it_closes(&against_borders);
    Ok(meshed)
}

impl MeshedBody {
    /// Turns the triangles of `faces`, whose borders contradict their sense, over where this leaves fewer
    /// edges open: neighbours tell which of the two is right. Small patches between fillets come like this.
    /// Where faces are not whole, open edges tell nothing.
    fn turn_where_it_closes(&mut self, faces: &[u32]) {
        if faces.is_empty() || self.open_edges == 0 || !self.faults.is_empty() {
            return;
        }
        let turn = |mesh: &mut TriangleMesh| {
            for (t, face) in mesh.triangles.iter_mut().zip(&self.face_of) {
                if faces.contains(face) {
                    t.swap(1, 2);
                }
            }
        };
        turn(&mut self.mesh);
        let open = open_edges(&self.mesh);
        if open < self.open_edges {
            self.open_edges = open;
        } else {
            turn(&mut self.mesh);
        }
    }
}

fn kind_of(surface: &Surface) -> SurfaceKind {
    match surface {
        Surface::Plane(_) => SurfaceKind::Plane,
        Surface::Cone(..) => SurfaceKind::Cone,
        Surface::Sphere(..) => SurfaceKind::Sphere,
        Surface::Torus(..) => SurfaceKind::Torus,
        Surface::Revolved(_) => SurfaceKind::Revolution,
        Surface::Extruded(..) => SurfaceKind::Extrusion,
        Surface::Nurbs(_) | Surface::Offset(..) => SurfaceKind::Free,
    }
}

/// Number of edges that do not have as many triangles on one side as on the other; vertices at one place are
/// one.
pub fn open_edges(mesh: &TriangleMesh) -> usize {
    let mut at: HashMap<[u64; 3], u32> = HashMap::new();
    let same: Vec<u32> =
        mesh.points.iter().enumerate().map(|(i, p)| *at.entry(bits_of(p)).or_insert(i as u32)).collect();
    let mut balance: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for t in &mesh.triangles {
        let t = t.map(|i| same[i as usize]);
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    balance.values().filter(|b| **b != 0).count()
}
