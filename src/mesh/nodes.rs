//! The nodes of a mesh file as a user tells them apart: name, size, shape, and the role that is guessed.

use std::collections::HashMap;

use super::axis::Axis;
use super::roles::{NamedMesh, guessed};
use super::{Role, TriangleMesh};
use crate::geometry::{Point, Vector};

/// Share of the circumference in the normals of a node that counts as turned, as mean over the area.
const TURNED: f64 = 0.1;
/// Difference of two areas, as share, within which nodes are of one shape.
const SAME_AREA: f64 = 1e-3;

/// A node of a mesh file, all of its meshes and places together. Lengths in the file's unit and frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshNode {
    /// Its number in the file.
    pub node: usize,
    /// Its name.
    pub name: String,
    /// What [`super::MeshOptions::roles`] calls it: its name, or `#` and its number where others go by that name too.
    pub key: String,
    /// Number of triangles.
    pub triangles: usize,
    /// Least corner of the box about it.
    pub low: Point,
    /// Greatest corner.
    pub high: Point,
    /// The role that its names tell.
    pub told: Option<Role>,
    area: f64,
    /// How far it is from turned about x, y and z of the file.
    unturned: [f64; 3],
}

impl MeshNode {
    fn new(mesh: &NamedMesh, numbered: bool) -> Self {
        Self {
            node: mesh.node,
            name: mesh.name.clone(),
            key: if numbered { format!("#{}", mesh.node) } else { mesh.name.clone() },
            triangles: 0,
            low: Point::from([f64::INFINITY; 3]),
            high: Point::from([f64::NEG_INFINITY; 3]),
            told: guessed(mesh),
            area: 0.0,
            unturned: [0.0; 3],
        }
    }

    fn add(&mut self, mesh: &TriangleMesh) {
        self.triangles += mesh.triangles.len();
        for p in &mesh.points {
            self.low = self.low.inf(p);
            self.high = self.high.sup(p);
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.points[i as usize]);
            let (normal, centre) = (0.5 * (b - a).cross(&(c - a)), (a.coords + b.coords + c.coords) / 3.0);
            self.area += normal.norm();
            for (sum, axis) in self.unturned.iter_mut().zip([Vector::x(), Vector::y(), Vector::z()]) {
                let arm = axis.cross(&centre);
                *sum += normal.dot(&arm).abs() / arm.norm().max(1e-300);
            }
        }
    }

    /// Whether both look the same but for their place.
    pub fn is_like(&self, other: &Self) -> bool {
        self.triangles == other.triangles && (self.area - other.area).abs() <= SAME_AREA * self.area
    }

    /// The axis of the file that it is most nearly turned about.
    pub fn turned_about(&self) -> Axis {
        let least = Axis::ALL.into_iter().zip(self.unturned).min_by(|a, b| a.1.total_cmp(&b.1));
        least.map_or(Axis::Y, |(axis, _)| axis)
    }

    fn is_turned(&self) -> bool {
        self.unturned.iter().copied().fold(f64::INFINITY, f64::min) < TURNED * self.area
    }
}

/// The nodes of a file in their order.
pub fn nodes(meshes: &[NamedMesh]) -> Vec<MeshNode> {
    // The one node that goes by a name; none where several do.
    let mut owners: HashMap<String, Option<usize>> = HashMap::new();
    for mesh in meshes {
        for name in std::iter::once(&mesh.name).chain(&mesh.other_names) {
            let owner = owners.entry(name.to_lowercase()).or_insert(Some(mesh.node));
            *owner = owner.filter(|node| *node == mesh.node);
        }
    }
    let own = |mesh: &NamedMesh| owners.get(&mesh.name.to_lowercase()).is_some_and(Option::is_some);
    let mut nodes: Vec<MeshNode> = Vec::new();
    for mesh in meshes {
        let at = nodes.iter().rposition(|n| n.node == mesh.node).unwrap_or_else(|| {
            nodes.push(MeshNode::new(mesh, !own(mesh) || mesh.name.starts_with('#')));
            nodes.len() - 1
        });
        nodes[at].add(&mesh.mesh);
    }
    nodes.retain(|n| n.triangles > 0);
    nodes
}

/// Roles to begin with: those that names tell; where they tell of no hub or no blade, the largest turned node is taken
/// for the hub, and what is there most often without being turned for the blades.
pub fn guess(nodes: &[MeshNode]) -> Vec<Option<Role>> {
    let mut roles: Vec<Option<Role>> = nodes.iter().map(|n| n.told).collect();
    let open = |roles: &[Option<Role>], k: usize| roles[k].is_none();
    if !roles.contains(&Some(Role::Hub)) {
        let turned = (0..nodes.len()).filter(|&k| open(&roles, k) && nodes[k].is_turned());
        if let Some(hub) = turned.max_by(|&a, &b| nodes[a].area.total_cmp(&nodes[b].area)) {
            roles[hub] = Some(Role::Hub);
        }
    }
    if !roles.contains(&Some(Role::Blade)) {
        let rest: Vec<usize> =
            (0..nodes.len()).filter(|&k| open(&roles, k) && !nodes[k].is_turned()).collect();
        // Rows of blades that are alike; of rows with as many blades each, the larger ones are the main blades.
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for k in rest {
            match rows.iter_mut().find(|row| nodes[k].is_like(&nodes[row[0]])) {
                Some(row) => row.push(k),
                None => rows.push(vec![k]),
            }
        }
        let weight = |row: &[usize]| row.len() as f64 * nodes[row[0]].area;
        rows.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
        let count = rows.first().map_or(0, Vec::len);
        for (row, role) in rows.iter().zip([Role::Blade, Role::Splitter]) {
            if role == Role::Blade || (count > 1 && row.len() == count) {
                row.iter().for_each(|&k| roles[k] = Some(role));
            }
        }
    }
    roles
}
