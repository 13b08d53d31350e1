//! The nodes of a mesh file, or the bodies of one from CAD, for the dialog that assigns roles to them.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::open_task::OpenTask;
use crate::app::model::problem::Problem;
use crate::error::ErrorCode;
use crate::gpu::mesh::Mesh;
use crate::io::InputError;
use crate::io::part_file::{FileBodies, read_bodies};
use crate::mesh::nodes::{MeshNode, nodes};
use crate::mesh::options::FileUnit;
use crate::mesh::{MeshOptions, NamedMesh};

/// Width to which the whole file is scaled, mm: depth range and colours of the picture suit parts of that
/// size.
const WIDTH: f64 = 300.0;
/// Maximum number of triangles drawn; larger files are thinned by a stride.
const MAX_TRIANGLES: usize = 400_000;
/// A mesh file whose nodes need roles.
pub(in crate::app) struct UnassignedRoles {
    /// The file.
    pub path: PathBuf,
    /// Task that opens the part once they are assigned.
    pub task: OpenTask,
    /// The options given so far.
    pub said: MeshOptions,
    /// Its nodes; at least one.
    pub nodes: Vec<MeshNode>,
    /// Unit of their coordinates.
    pub unit: FileUnit,
    /// Mesh of each node, in the file's axes, centred and scaled.
    pub meshes: Vec<Mesh>,
    /// Why the part did not open with these options.
    pub fault: Option<Problem>,
}

impl UnassignedRoles {
    /// Reads the nodes of the mesh file at `path`. `said` are the options given so far, `fault` is why it did
    /// not open with them, `task` opens its part.
    ///
    /// # Errors
    /// [`InputError`] when the file cannot be read, or has no triangles.
    pub(in crate::app) fn read(
        path: &Path,
        said: &MeshOptions,
        task: OpenTask,
        fault: Option<&InputError>,
    ) -> Result<Self, InputError> {
        let FileBodies { meshes, unit } = read_bodies(path)?;
        let nodes = nodes(&meshes);
        if nodes.is_empty() {
            let file = path.display().to_string();
            return Err(InputError::new(
                ErrorCode::NoTriangles,
                &file,
                0,
                "holds no triangles",
                "export the impeller's surfaces as meshes",
            ));
        }
        Ok(Self {
            path: path.to_owned(),
            task,
            said: said.clone(),
            meshes: drawn_meshes(&meshes, &nodes),
            nodes,
            unit,
            // The dialog's title names the file.
            fault: fault.map(|fault| Problem::new(fault.message.clone(), fault.help.clone())),
        })
    }

    /// Leaves roles to shapes where names say some: reading the file decided so, and does again.
    pub(in crate::app) fn forget_named_roles(&mut self) {
        self.nodes.iter_mut().for_each(|node| node.named_role = None);
    }
}

/// The meshes of the nodes as they are drawn.
fn drawn_meshes(meshes: &[NamedMesh], nodes: &[MeshNode]) -> Vec<Mesh> {
    let low = nodes.iter().fold(nodes[0].low, |low, n| low.inf(&n.low));
    let high = nodes.iter().fold(nodes[0].high, |high, n| high.sup(&n.high));
    let (middle, scale) = (nalgebra::center(&low, &high), WIDTH / (high - low).amax().max(f64::MIN_POSITIVE));
    let triangles: usize = nodes.iter().map(|n| n.triangles).sum();
    let stride = triangles.div_ceil(MAX_TRIANGLES).max(1);
    let mut drawn = vec![Mesh::default(); nodes.len()];
    for mesh in meshes {
        if let Some(k) = nodes.iter().position(|n| n.node == mesh.node) {
            drawn[k].append(&Mesh::flat_shaded(&mesh.mesh, stride, |p| {
                let d = (p - middle) * scale;
                Vec3::new(d.x as f32, d.y as f32, d.z as f32)
            }));
        }
    }
    drawn
}
