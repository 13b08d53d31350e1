//! The node graph: every mesh with its node transform applied and with its names.

use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3};
use std::collections::HashMap;
use std::sync::Arc;

use super::accessor;
use super::container::{Container, EXPORT_AGAIN};
use super::document::GltfNode;
use crate::error::ErrorCode;
use crate::geometry::Point;
use crate::io::InputError;
use crate::io::source::{MAX_TRIANGLES, quote_for_message};
use crate::mesh::{NamedMesh, TriangleMesh};
use crate::part::Rotation;

/// Maximum number of mesh instances.
const MAX_INSTANCES: usize = 10_000;
/// Maximum number of corners of all instances together.
const MAX_CORNERS: usize = 24_000_000;

/// Corners and triangles of a primitive, in the frame of its mesh.
struct PrimitiveMesh {
    material: Option<usize>,
    corners: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// A node on the stack of the depth-first traversal.
struct PendingNode {
    node: usize,
    parent: Matrix4<f64>,
    /// Index of the parent among the visited nodes.
    above: Option<usize>,
}

/// State of the traversal of a scene.
struct Walk<'c, 'a> {
    container: &'c mut Container<'a>,
    pieces: HashMap<usize, Arc<Vec<PrimitiveMesh>>>,
    found: Vec<NamedMesh>,
    rotation: Option<Rotation>,
    corners: usize,
    triangles: usize,
}

/// The meshes of a file.
pub struct SceneMeshes {
    /// Meshes with their node transforms applied, in the file's unit and frame.
    pub meshes: Vec<NamedMesh>,
    /// The sense of rotation, if the file gives it.
    pub rotation: Option<Rotation>,
}

/// Collects all meshes of the default scene, or of the first scene, or of all nodes, by an iterative
/// depth-first traversal.
///
/// # Errors
/// When the node graph is not a forest, refers to what does not exist, or exceeds the limits.
pub fn read_scene(container: &mut Container<'_>) -> Result<SceneMeshes, InputError> {
    let roots = roots(container)?;
    let mut walk = Walk {
        container,
        pieces: HashMap::new(),
        found: Vec::new(),
        rotation: None,
        corners: 0,
        triangles: 0,
    };
    let mut seen = vec![false; walk.container.document.nodes.len()];
    let mut visited: Vec<(usize, Option<usize>)> = Vec::new();
    let mut waiting: Vec<PendingNode> = roots
        .into_iter()
        .rev()
        .map(|node| PendingNode { node, parent: Matrix4::identity(), above: None })
        .collect();
    while let Some(PendingNode { node, parent, above }) = waiting.pop() {
        let Some(described) = walk.container.document.nodes.get(node) else {
            return Err(walk.container.missing(format!("node {node}")));
        };
        if std::mem::replace(&mut seen[node], true) {
            let what = format!("node {node} is in the node graph twice or below itself");
            return Err(walk.container.fault(what, EXPORT_AGAIN).with_code(ErrorCode::GltfReference));
        }
        let here = parent * own_transform(described);
        if here.iter().any(|x| !x.is_finite()) {
            let what = format!("the transform of node {node} is not finite");
            return Err(walk.container.fault(what, EXPORT_AGAIN).with_code(ErrorCode::MeshValues));
        }
        if let Some(rotation) = described.extras.rotation {
            let mirrored = here.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
            walk.rotation = Some(if mirrored { rotation.reversed() } else { rotation });
        }
        let place = visited.len();
        visited.push((node, above));
        let children = described.children.clone();
        if let Some(mesh) = described.mesh {
            walk.add_mesh(node, mesh, &here, &visited)?;
        }
        waiting.extend(children.into_iter().rev().map(|node| PendingNode {
            node,
            parent: here,
            above: Some(place),
        }));
    }
    Ok(SceneMeshes { meshes: walk.found, rotation: walk.rotation })
}

fn roots(container: &Container<'_>) -> Result<Vec<usize>, InputError> {
    let document = &container.document;
    let scene = document.scene.unwrap_or(0);
    match document.scenes.get(scene) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if document.scene.is_some() => Err(container.missing(format!("scene {scene}"))),
        None => {
            let mut is_child = vec![false; document.nodes.len()];
            for child in document.nodes.iter().flat_map(|n| &n.children) {
                if let Some(is_child) = is_child.get_mut(*child) {
                    *is_child = true;
                }
            }
            Ok((0..is_child.len()).filter(|&node| !is_child[node]).collect())
        }
    }
}

/// Transform of a node relative to its parent.
fn own_transform(node: &GltfNode) -> Matrix4<f64> {
    match &node.matrix {
        Some(columns) => Matrix4::from_column_slice(columns),
        None => transform(
            node.translation.unwrap_or_default(),
            node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
            node.scale.unwrap_or([1.0; 3]),
        ),
    }
}

fn transform(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Matrix4<f64> {
    let [x, y, z, w] = rotation;
    let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-12).unwrap_or_default();
    Matrix4::new_translation(&Vector3::from(translation))
        * turn.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&Vector3::from(scale))
}

impl Walk<'_, '_> {
    /// Adds the mesh of a node, once or for each of its instances.
    fn add_mesh(
        &mut self,
        node: usize,
        mesh: usize,
        here: &Matrix4<f64>,
        visited: &[(usize, Option<usize>)],
    ) -> Result<(), InputError> {
        let pieces = self.pieces_of(mesh)?;
        let instances = self.instance_transforms(node)?;
        let count = instances.as_ref().map_or(1, Vec::len);
        let corners: usize = pieces.iter().map(|p| p.corners.len()).sum();
        let triangles: usize = pieces.iter().map(|p| p.triangles.len()).sum();
        self.corners = self.corners.saturating_add(corners.saturating_mul(count));
        self.triangles = self.triangles.saturating_add(triangles.saturating_mul(count));
        let meshes = self.found.len().saturating_add(pieces.len().saturating_mul(count));
        if self.corners > MAX_CORNERS || self.triangles > MAX_TRIANGLES || meshes > MAX_INSTANCES {
            let what = format!(
                "holds {meshes} meshes or more with {} triangles; \
                 the limits are {MAX_INSTANCES} and {MAX_TRIANGLES}",
                self.triangles
            );
            return Err(self.container.too_large(what.replace(';', ",")));
        }
        let (name, names) = self.names(node, mesh, visited);
        for (k, own) in instances.unwrap_or_else(|| vec![Matrix4::identity()]).iter().enumerate() {
            let place = here * own;
            for piece in pieces.iter() {
                let mut names = names.clone();
                let material = piece.material.and_then(|m| self.container.document.materials.get(m));
                names.extend(material.and_then(|m| m.name.clone()));
                // Order of names: the node's own, the material's, the mesh's, then those of the nodes above.
                names.rotate_right(usize::from(material.is_some_and(|m| m.name.is_some())));
                self.found.push(NamedMesh {
                    name: name.clone(),
                    other_names: names,
                    node,
                    instance: k,
                    mesh: placed(piece, &place, self.container)?,
                });
            }
        }
        Ok(())
    }

    /// Name of a node (or else of its mesh), and its other names: of its mesh and of the nodes above.
    fn names(&self, node: usize, mesh: usize, visited: &[(usize, Option<usize>)]) -> (String, Vec<String>) {
        let document = &self.container.document;
        let named =
            |node: usize| document.nodes.get(node).and_then(|n| n.name.clone()).filter(|n| !n.is_empty());
        let of_mesh = document.meshes.get(mesh).and_then(|m| m.name.clone()).filter(|n| !n.is_empty());
        let name = named(node).or(of_mesh.clone()).unwrap_or_else(|| format!("node {node}"));
        let mut names: Vec<String> = of_mesh.into_iter().filter(|n| *n != name).collect();
        let mut above = visited.last().and_then(|(_, above)| *above);
        // Names far up the graph do not identify a single mesh.
        for _ in 0..8 {
            let Some((node, next)) = above.and_then(|a| visited.get(a)) else { break };
            names.extend(named(*node));
            above = *next;
        }
        (name, names)
    }

    /// The instance transforms of `EXT_mesh_gpu_instancing` relative to the node; `None` without it.
    fn instance_transforms(&mut self, node: usize) -> Result<Option<Vec<Matrix4<f64>>>, InputError> {
        let extensions = self.container.document.nodes.get(node).and_then(|n| n.extensions.as_ref());
        let Some(instancing) = extensions.and_then(|e| e.instancing.as_ref()) else { return Ok(None) };
        let a = &instancing.attributes;
        let (translation, rotation, scale) = (a.translation, a.rotation, a.scale);
        for accessor in [translation, rotation, scale].into_iter().flatten() {
            let count = self.container.document.accessors.get(accessor).map_or(0, |a| a.count);
            if count > MAX_INSTANCES {
                let what = format!("node {node} has {count} instances, more than {MAX_INSTANCES}");
                return Err(self.container.too_large(what));
            }
        }
        let what = |which: &str| format!("the {which} of the instances of node {node}");
        let mut vectors = |a: Option<usize>, which: &str| {
            a.map(|a| accessor::vectors(self.container, a, &what(which))).transpose()
        };
        let (translations, scales) = (vectors(translation, "translations")?, vectors(scale, "scales")?);
        let rotations =
            rotation.map(|a| accessor::quaternions(self.container, a, &what("rotations"))).transpose()?;
        let lengths = [
            translations.as_ref().map(Vec::len),
            scales.as_ref().map(Vec::len),
            rotations.as_ref().map(Vec::len),
        ];
        let count = lengths.iter().flatten().min().copied().unwrap_or(0);
        if lengths.iter().flatten().any(|&l| l != count) {
            let what = format!("the instances of node {node} have different counts of their attributes");
            return Err(self.container.fault(what, EXPORT_AGAIN).with_code(ErrorCode::GltfAccessor));
        }
        let places = (0..count).map(|i| {
            transform(
                translations.as_ref().map_or([0.0; 3], |t| t[i]),
                rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r[i]),
                scales.as_ref().map_or([1.0; 3], |s| s[i]),
            )
        });
        Ok(Some(places.collect()))
    }

    /// The primitives of a mesh; each mesh is read once.
    fn pieces_of(&mut self, mesh: usize) -> Result<Arc<Vec<PrimitiveMesh>>, InputError> {
        if let Some(pieces) = self.pieces.get(&mesh) {
            return Ok(pieces.clone());
        }
        let Some(described) = self.container.document.meshes.get(mesh) else {
            return Err(self.container.missing(format!("mesh {mesh}")));
        };
        let called = described.name.as_deref().map_or_else(|| format!("mesh {mesh}"), quote_for_message);
        let primitives: Vec<_> = described
            .primitives
            .iter()
            .map(|p| {
                let draco = p.extensions.as_ref().is_some_and(|e| e.draco.is_some());
                (p.attributes.position, p.indices, p.material, p.mode.unwrap_or(4), draco)
            })
            .collect();
        let mut pieces = Vec::new();
        for (position, indices, material, mode, draco) in primitives {
            // Points and lines are not surfaces.
            let (Some(position), 4..=6) = (position, mode) else { continue };
            let has_data = |a: usize| {
                self.container
                    .document
                    .accessors
                    .get(a)
                    .is_none_or(|a| a.buffer_view.is_some() || a.sparse.is_some())
            };
            if draco && !(has_data(position) && indices.is_none_or(has_data)) {
                return Err(self.container.compressed("Draco"));
            }
            let corners =
                accessor::positions(self.container, position, &format!("the positions of {called}"))?;
            let order = match indices {
                Some(accessor) => Some(accessor::indices(
                    self.container,
                    accessor,
                    corners.len(),
                    &format!("the indices of {called}"),
                )?),
                None => None,
            };
            let triangles = triangles(mode, order.as_deref(), corners.len());
            let held: usize = self.pieces.values().flat_map(|p| p.iter()).map(|p| p.corners.len()).sum();
            if held + corners.len() > MAX_CORNERS || triangles.len() > MAX_TRIANGLES {
                return Err(self.container.too_large("has too many triangles"));
            }
            pieces.push(PrimitiveMesh { material, corners, triangles });
        }
        let pieces = Arc::new(pieces);
        self.pieces.insert(mesh, pieces.clone());
        Ok(pieces)
    }
}

/// Triangles of a list (4), strip (5) or fan (6), without those that repeat a corner.
fn triangles(mode: u32, order: Option<&[u32]>, corners: usize) -> Vec<[u32; 3]> {
    let count = order.map_or(corners, <[u32]>::len);
    let at = |i: usize| order.map_or(i as u32, |order| order[i]);
    let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    match mode {
        4 => (0..count / 3).map(|i| [at(3 * i), at(3 * i + 1), at(3 * i + 2)]).filter(whole).collect(),
        5 => (0..count.saturating_sub(2))
            // Every other triangle of a strip has the opposite winding.
            .map(|i| if i % 2 == 0 { [at(i), at(i + 1), at(i + 2)] } else { [at(i + 1), at(i), at(i + 2)] })
            .filter(whole)
            .collect(),
        _ => (1..count.saturating_sub(1)).map(|i| [at(0), at(i), at(i + 1)]).filter(whole).collect(),
    }
}

fn placed(
    piece: &PrimitiveMesh,
    place: &Matrix4<f64>,
    container: &Container<'_>,
) -> Result<TriangleMesh, InputError> {
    let points: Vec<Point> =
        piece.corners.iter().map(|c| place.transform_point(&Point::new(c[0], c[1], c[2]))).collect();
    if points.iter().any(|p| p.iter().any(|x| !x.is_finite())) {
        let error = container.fault("a node's transform gives non-finite coordinates", EXPORT_AGAIN);
        return Err(error.with_code(ErrorCode::MeshValues));
    }
    let mirrored = place.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
    let mut triangles = piece.triangles.clone();
    if mirrored {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(TriangleMesh { points, triangles })
}
