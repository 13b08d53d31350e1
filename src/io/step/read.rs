//! Bodies of a STEP file as named meshes, and as a part.

use std::path::Path;
use std::sync::atomic::AtomicUsize;

use rayon::prelude::*;

use super::advice;
use super::assembly::{PlacedBody, placed_bodies};
use super::body::{MeshedBody, is_sheet, mesh_group};
use super::edges::StepFineness;
use super::exchange::parse;
use super::model::{EntityFault, Model};
use super::shape::MAX_WORK;
use super::sheets::{apart, grouped};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::io::source::{MAX_BYTES, name_of, read_bytes_up_to, stem_of};
use crate::mesh::describe::describe_source;
use crate::mesh::source::MeshSource;
use crate::mesh::{ExactNormals, LengthUnit, MeshOptions, NamedMesh};
use crate::part::{PartDescription, PartError, Rotation};

/// Chord error of the triangles of a part, as a share of its largest extent, and its limits, mm.
const CHORD: f64 = 1e-4;
const CHORD_LIMITS: (f64, f64) = (5e-4, 0.02);
/// Chord error of bodies that are only shown, as a multiple of that of a part.
const SHOWN: f64 = 8.0;
/// Chord error of the first, coarse mesh, which gives the extent, as a share of 1 m.
const COARSE_MM: f64 = 1.0;
/// Largest angle between neighbouring chords, rad.
const TURN: f64 = 0.12;
/// Beginning of a product's description that says the sense of rotation.
pub const ROTATION_NOTE: &str = "rotation seen from the inlet: ";
/// Axes within this angle, rad, and distance, mm, are one.
const ONE_AXIS: (f64, f64) = (1e-4, 1e-3);

/// The bodies of a file.
#[derive(Clone, Debug)]
pub struct StepScene {
    /// The bodies in the order of the assembly, in mm and in the file's frame.
    pub bodies: Vec<MeshedBody>,
    /// Chord error of their triangles, mm.
    pub chord_mm: f64,
    /// Sense of rotation of the wheel, where the description of a product says it.
    pub rotation: Option<Rotation>,
}

/// Reads a part from a `.step` or `.stp` file; the result is in mm, about Z.
///
/// # Errors
/// When the file cannot be read, is not valid, or its bodies do not describe a part.
pub fn read(path: &Path, options: &MeshOptions) -> Result<PartDescription, InputError> {
    read_bytes(&name_of(path), &read_bytes_up_to(path, MAX_BYTES)?, options)
}

/// As [`read`], from bytes; `name` is the file name used in messages.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(name: &str, bytes: &[u8], options: &MeshOptions) -> Result<PartDescription, InputError> {
    let scene = read_scene_bytes(name, bytes, None)?;
    let notes = scene.notes();
    // An incomplete body may be the reason why no part was found.
    let cause = notes.first().map_or_else(String::new, |note| format!(" ({note})"));
    let fault = |e: PartError| {
        let e = advice::for_solids(e, notes.is_empty());
        InputError::of_part(name, PartError { message: format!("{}{cause}", e.message), ..e })
    };
    let normals =
        ExactNormals::from_normals(scene.bodies.iter().flat_map(|body| body.normals.iter().copied()));
    let source = MeshSource {
        unit: LengthUnit::Millimetre,
        axis: scene.axis(),
        notes: notes.clone(),
        normals,
        whole: notes.is_empty() && scene.bodies.iter().all(|body| body.solid),
    };
    // The file gives its unit, and one that Vanecut wrote the sense of rotation.
    let rotation = options.rotation.or(scene.rotation);
    let options = MeshOptions { unit: None, rotation, ..options.clone() };
    describe_source(&stem_of(name), scene.into_meshes(), source, &options).map_err(fault)
}

/// Reads the bodies of a file as triangles within `chord_mm`, or else a ten-thousandth of the extent.
///
/// # Errors
/// When the file cannot be read or is not valid.
pub fn read_scene(path: &Path, chord_mm: Option<f64>) -> Result<StepScene, InputError> {
    read_scene_bytes(&name_of(path), &read_bytes_up_to(path, MAX_BYTES)?, chord_mm)
}

/// Reads the bodies of a file to be shown, and named: by coarser triangles than a part is read with.
///
/// # Errors
/// When the file cannot be read or is not valid.
pub fn read_meshes(path: &Path) -> Result<Vec<NamedMesh>, InputError> {
    let (name, bytes) = (name_of(path), read_bytes_up_to(path, MAX_BYTES)?);
    Ok(mesh_scene(&name, &bytes, |extent| SHOWN * chord_of_part(extent))?.into_meshes())
}

/// Chord error of the triangles of a part of this largest extent, mm.
fn chord_of_part(extent: f64) -> f64 {
    (CHORD * extent).clamp(CHORD_LIMITS.0, CHORD_LIMITS.1)
}

/// As [`read_scene`], from bytes; `name` is the file name used in messages.
///
/// # Errors
/// When the bytes are not a STEP file with solids or shells.
pub fn read_scene_bytes(name: &str, bytes: &[u8], chord_mm: Option<f64>) -> Result<StepScene, InputError> {
    mesh_scene(name, bytes, |extent| chord_mm.unwrap_or_else(|| chord_of_part(extent)))
}

/// The bodies of a file as triangles within the chord error, mm, that `chord_mm` gives for their extent.
fn mesh_scene(name: &str, bytes: &[u8], chord_mm: impl FnOnce(f64) -> f64) -> Result<StepScene, InputError> {
    let model = Model { exchange: parse(name, bytes)? };
    let bodies = placed_bodies(&model).map_err(|fault| fault.in_file(name))?;
    if bodies.is_empty() {
        let what = if model.exchange.iter().any(|i| i.keyword().starts_with("TESSELLATED")) {
            "holds triangles only, no solids or surfaces"
        } else {
            "holds no solids or surfaces"
        };
        return Err(InputError::new(
            ErrorCode::StepFile,
            name,
            0,
            what,
            "export the wheel's solids or surfaces",
        ));
    }
    let extent = extent(&model, &bodies);
    let chord_mm = chord_mm(extent);
    let fineness = StepFineness { chord_mm, turn_rad: TURN, join_mm: chord_of_part(extent) };
    let budget = AtomicUsize::new(MAX_WORK);
    let groups = grouped(bodies, |body| is_sheet(&model, body));
    let meshed = |group: &Vec<PlacedBody>| {
        let (body, counts) = mesh_group(&model, group, fineness, &budget)?;
        Ok(if body.solid { vec![body] } else { apart(body, group, &counts) })
    };
    let meshed: Result<Vec<Vec<MeshedBody>>, EntityFault> = groups.par_iter().map(meshed).collect();
    let bodies = meshed.map_err(|fault| fault.in_file(name))?.into_iter().flatten().collect();
    Ok(StepScene { bodies, chord_mm, rotation: rotation(&model) })
}

/// The sense of rotation in the description of a product, as `write_part` notes it.
fn rotation(model: &Model<'_>) -> Option<Rotation> {
    let said = |text: String| text.strip_prefix(ROTATION_NOTE)?.parse().ok();
    model.all("PRODUCT").find_map(|product| said(product.text(2)))
}

/// Largest extent of the vertices of all bodies, mm; [`COARSE_MM`] × 1,000 where there are none.
fn extent(model: &Model<'_>, bodies: &[PlacedBody]) -> f64 {
    let mm = bodies.first().map_or(1.0, |b| b.units.mm);
    let (mut low, mut high) = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
    for vertex in model.all("VERTEX_POINT") {
        if let Some(p) = vertex.optional(1).and_then(|id| model.point(vertex.id, id, mm).ok()) {
            (low, high) = (low.inf(&p), high.sup(&p));
        }
    }
    let across = (high - low).amax();
    if across.is_finite() && across > 0.0 { across } else { 1e3 * COARSE_MM }
}

impl StepScene {
    /// The axis that most area of surfaces of revolution is about, where that is more than of any other.
    pub fn axis(&self) -> Option<(Point, Vector)> {
        let mut axes: Vec<((Point, Vector), f64)> = Vec::new();
        for body in &self.bodies {
            let mut areas = vec![0.0; body.faces.len()];
            for (t, face) in body.mesh.triangles.iter().zip(&body.face_of) {
                let [a, b, c] = t.map(|i| body.mesh.points[i as usize]);
                areas[*face as usize] += 0.5 * (b - a).cross(&(c - a)).norm();
            }
            for (face, area) in body.faces.iter().zip(areas) {
                let Some((p, d)) = face.axis else { continue };
                let same = |((q, e), _): &&mut ((Point, Vector), f64)| {
                    d.cross(e).norm() < ONE_AXIS.0 && (p - *q).cross(e).norm() < ONE_AXIS.1
                };
                match axes.iter_mut().find(same) {
                    Some((_, sum)) => *sum += area,
                    None => axes.push(((p, d), area)),
                }
            }
        }
        axes.sort_by(|a, b| b.1.total_cmp(&a.1));
        let clear = axes.get(1).is_none_or(|second| axes[0].1 > 2.0 * second.1);
        axes.first().filter(|_| clear).map(|(axis, _)| *axis)
    }

    /// What is not whole, one line for each body.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for body in &self.bodies {
            let named = std::iter::once(&body.name).chain(&body.parents).find(|name| !name.is_empty());
            let name = match named {
                Some(name) => format!("body `{name}` (#{})", body.id),
                None => format!("body #{}", body.id),
            };
            if let Some((face, why)) = body.faults.first() {
                let more = match body.faults.len() {
                    1 => String::new(),
                    n => format!(" and {} more", n - 1),
                };
                notes.push(format!("{name} is not whole: face #{face}{more} could not be meshed: {why}"));
            } else if body.solid && body.open_edges > 0 {
                notes.push(format!("{name} is not closed: {} open edges", body.open_edges));
            }
        }
        notes
    }

    /// The bodies as meshes with the names of bodies and components.
    pub fn into_meshes(self) -> Vec<NamedMesh> {
        let named = |(node, body): (usize, MeshedBody)| NamedMesh {
            // Most systems name products, not their solids.
            name: match std::iter::once(&body.name).chain(&body.parents).find(|name| !name.is_empty()) {
                Some(name) => name.clone(),
                None => format!("#{node}"),
            },
            other_names: body.parents.clone(),
            node,
            instance: 0,
            mesh: body.by_face(),
        };
        self.bodies.into_iter().enumerate().map(named).collect()
    }
}
