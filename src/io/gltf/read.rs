//! Reads a glTF file as a part.

use std::path::Path;

use super::container::{Container, MAX_MESH_BYTES};
use super::scene::{SceneMeshes, read_scene};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{MAX_COORDINATE, Source, name_of, read_bytes_up_to, stem_of};
use crate::mesh::{LengthUnit, MeshOptions, NamedMesh, describe};
use crate::part::{PartDescription, PartError};

/// Reads a part from a `.glb` or `.gltf` file and the buffers beside it; the result is in mm, about Z.
///
/// # Errors
/// When the file or its buffers cannot be read, or the meshes do not describe a part.
pub fn read(path: &Path, options: &MeshOptions) -> Result<PartDescription, InputError> {
    let name = name_of(path);
    part(&name, scene_of(path)?, options)
}

/// Reads a part from bytes, without buffers in other files; `name` is the file name used in messages.
///
/// # Errors
/// As [`read`], or when a buffer is in another file.
pub fn read_bytes(name: &str, bytes: &[u8], options: &MeshOptions) -> Result<PartDescription, InputError> {
    part(name, scene_of_bytes(name, bytes)?, options)
}

/// Reads the meshes of a file with their node transforms applied, in the file's unit (normally metres)
/// and frame.
///
/// # Errors
/// When the file or its buffers cannot be read or are not valid glTF 2.0.
pub fn read_meshes(path: &Path) -> Result<Vec<NamedMesh>, InputError> {
    Ok(scene_of(path)?.meshes)
}

/// As [`read_meshes`], from bytes; `name` is the file name used in messages.
///
/// # Errors
/// As [`read_meshes`], or when a buffer is in another file.
pub fn read_meshes_bytes(name: &str, bytes: &[u8]) -> Result<Vec<NamedMesh>, InputError> {
    Ok(scene_of_bytes(name, bytes)?.meshes)
}

fn scene_of(path: &Path) -> Result<SceneMeshes, InputError> {
    let name = name_of(path);
    let bytes = read_bytes_up_to(path, MAX_MESH_BYTES)?;
    let folder = match path.parent() {
        Some(folder) if folder.as_os_str().is_empty() => Path::new("."),
        Some(folder) => folder,
        None => Path::new("."),
    };
    read_scene(&mut Container::open(Source::new(&name, ErrorCode::MeshFile), bytes, Some(folder))?)
}

fn scene_of_bytes(name: &str, bytes: &[u8]) -> Result<SceneMeshes, InputError> {
    read_scene(&mut Container::open(Source::new(name, ErrorCode::MeshFile), bytes.to_vec(), None)?)
}

fn part(name: &str, scene: SceneMeshes, options: &MeshOptions) -> Result<PartDescription, InputError> {
    let SceneMeshes { meshes, rotation } = scene;
    let options = &MeshOptions { rotation: options.rotation.or(rotation), ..options.clone() };
    let fault = |e: PartError| InputError::of_part(name, e);
    let scale = options.unit.unwrap_or(LengthUnit::Metre).mm();
    // The limit is 1,000 times that of a part, so that a wrong unit is reported as such by `describe`.
    let beyond = |m: &NamedMesh| m.mesh.points.iter().any(|p| p.coords.amax() * scale > 1e3 * MAX_COORDINATE);
    if let Some(mesh) = meshes.iter().find(|m| beyond(m)) {
        let what = format!("the mesh `{}` has points beyond 1,000,000 m", mesh.name);
        return Err(InputError::new(
            ErrorCode::MeshUnit,
            name,
            0,
            what,
            "give the unit of its numbers with --unit, or repair it",
        ));
    }
    describe(&stem_of(name), meshes, LengthUnit::Metre, options).map_err(fault)
}
