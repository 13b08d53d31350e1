//! The nodes of a mesh file for display: name, size, shape and guessed role.

use std::collections::HashMap;

use super::axis::Axis;
use super::roles::{NamedMesh, roles_from_names};
use super::{Role, TriangleMesh};
use crate::geometry::{Point, Vector};

/// Area-weighted mean of the circumferential component of the normals below which a node is a surface of
/// revolution.
const TURNED: f64 = 0.1;
/// Relative difference of two areas within which nodes have the same shape. Blades of a CAD model, meshed one
/// by one, differ by some thousandths, and by a third in their numbers of triangles.
const SAME_AREA: f64 = 0.01;

/// Share of the area of the only blade from which on one other node may be its splitter.
const SPLITTER_AREA: f64 = 0.2;
/// By how much a splitter may reach beyond the blade along the axis, as a share of the blade's length there.
const BEYOND_BLADE: f64 = 0.02;

/// A node of a mesh file with all of its meshes and instances. Coordinates are in the file's unit and frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshNode {
    /// Its number in the file.
    pub node: usize,
    /// Its name.
    pub name: String,
    /// Its key in [`super::MeshOptions::roles`]: its name, or `#` and its number where the name is not
    /// unique.
    pub key: String,
    /// Number of triangles.
    pub triangles: usize,
    /// Minimum corner of its bounding box.
    pub low: Point,
    /// Maximum corner of its bounding box.
    pub high: Point,
    /// The role derived from its names.
    pub named_role: Option<Role>,
    area: f64,
    /// Area-weighted circumferential component of its normals about the file's x, y and z.
    circumferential: [f64; 3],
}

impl MeshNode {
    fn new(mesh: &NamedMesh, named_role: Option<Role>, numbered: bool) -> Self {
        Self {
            node: mesh.node,
            name: mesh.name.clone(),
            key: if numbered { format!("#{}", mesh.node) } else { mesh.name.clone() },
            triangles: 0,
            low: Point::from([f64::INFINITY; 3]),
            high: Point::from([f64::NEG_INFINITY; 3]),
            named_role,
            area: 0.0,
            circumferential: [0.0; 3],
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
            for (sum, axis) in self.circumferential.iter_mut().zip([Vector::x(), Vector::y(), Vector::z()]) {
                let arm = axis.cross(&centre);
                *sum += normal.dot(&arm).abs() / arm.norm().max(1e-300);
            }
        }
    }

    /// Whether both have the same shape, compared by area.
    pub fn is_like(&self, other: &Self) -> bool {
        (self.area - other.area).abs() <= SAME_AREA * self.area
    }

    /// The axis of the file about which it comes closest to a surface of revolution.
    pub fn revolution_axis(&self) -> Axis {
        axis_of_min(self.circumferential)
    }

    /// Whether it may be the splitter beside the only `blade`: not much smaller, and no longer along `axis`.
    fn may_be_splitter_of(&self, blade: &Self, axis: Axis) -> bool {
        let k = axis as usize;
        let beyond = BEYOND_BLADE * (blade.high[k] - blade.low[k]);
        let is_beside = self.low[k] >= blade.low[k] - beyond && self.high[k] <= blade.high[k] + beyond;
        is_beside && self.area >= SPLITTER_AREA * blade.area
    }

    fn is_turned(&self) -> bool {
        self.circumferential.iter().copied().fold(f64::INFINITY, f64::min) < TURNED * self.area
    }
}

fn axis_of_min(circumferential: [f64; 3]) -> Axis {
    let least = Axis::ALL.into_iter().zip(circumferential).min_by(|a, b| a.1.total_cmp(&b.1));
    least.map_or(Axis::Y, |(axis, _)| axis)
}

/// The axis of the file about which all of `nodes` together come closest to a surface of revolution.
pub fn revolution_axis_of(nodes: &[MeshNode]) -> Axis {
    axis_of_min(std::array::from_fn(|i| nodes.iter().map(|node| node.circumferential[i]).sum()))
}

/// The nodes of a file in the order of the file, without empty ones.
pub fn nodes(meshes: &[NamedMesh]) -> Vec<MeshNode> {
    // The node that has a name; `None` where several nodes have it.
    let mut owners: HashMap<String, Option<usize>> = HashMap::new();
    for mesh in meshes {
        for name in std::iter::once(&mesh.name).chain(&mesh.other_names) {
            let owner = owners.entry(name.to_lowercase()).or_insert(Some(mesh.node));
            *owner = owner.filter(|node| *node == mesh.node);
        }
    }
    let own = |mesh: &NamedMesh| owners.get(&mesh.name.to_lowercase()).is_some_and(Option::is_some);
    let mut nodes: Vec<MeshNode> = Vec::new();
    for (mesh, role) in meshes.iter().zip(roles_from_names(meshes)) {
        let at = nodes.iter().rposition(|n| n.node == mesh.node).unwrap_or_else(|| {
            nodes.push(MeshNode::new(mesh, role, !own(mesh) || mesh.name.starts_with('#')));
            nodes.len() - 1
        });
        nodes[at].add(&mesh.mesh);
    }
    nodes.retain(|n| n.triangles > 0);
    nodes
}

/// Largest extent along an axis of those nodes that have a role in the wheel, or of all where none has one.
pub fn wheel_width(nodes: &[MeshNode], roles: &[Option<Role>]) -> f64 {
    let of_wheel = |role: &Option<Role>| role.is_some_and(|role| role != Role::Ignored);
    let any = roles.iter().any(of_wheel);
    let counted = nodes.iter().zip(roles).filter(|(_, role)| !any || of_wheel(role));
    let extent = counted.map(|(node, _)| (node.low, node.high));
    let extent = extent.reduce(|(low, high), (from, to)| (low.inf(&from), high.sup(&to)));
    extent.map_or(0.0, |(low, high)| (high - low).amax())
}

/// Width of the wheel in `meshes`, as [`wheel_width`], with the roles that are `given` and those that
/// [`guess_roles`] finds.
pub fn width_of_wheel_in(meshes: &[NamedMesh], given: &[Option<Role>]) -> f64 {
    let said: HashMap<usize, Role> =
        meshes.iter().zip(given).filter_map(|(mesh, role)| Some((mesh.node, (*role)?))).collect();
    let nodes = nodes(meshes);
    let mut roles = guess_roles(&nodes);
    for (node, role) in nodes.iter().zip(&mut roles) {
        *role = said.get(&node.node).copied().or(*role);
    }
    wheel_width(&nodes, &roles)
}

/// Initial roles: those derived from names. Without a named hub, the largest surface of revolution becomes
/// the hub; without a named blade, the group of equal nodes with the largest total area becomes the blades,
/// and a second one of as many nodes the splitters.
/// One node alone is hub and blades.
pub fn guess_roles(nodes: &[MeshNode]) -> Vec<Option<Role>> {
    let mut roles: Vec<Option<Role>> = nodes.iter().map(|n| n.named_role).collect();
    if nodes.len() < 2 {
        return roles;
    }
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
        // Groups of equal nodes are rows of blades. The second group is the splitters if it has as many
        // nodes; beside the only blade of a file anything else may lie.
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for k in rest {
            match rows.iter_mut().find(|row| nodes[k].is_like(&nodes[row[0]])) {
                Some(row) => row.push(k),
                None => rows.push(vec![k]),
            }
        }
        let weight = |row: &[usize]| row.len() as f64 * nodes[row[0]].area;
        rows.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
        let hub = roles.iter().position(|role| *role == Some(Role::Hub));
        let axis = hub.map_or_else(|| revolution_axis_of(nodes), |hub| nodes[hub].revolution_axis());
        let (blades, splitters): (&[usize], &[usize]) = match rows.as_slice() {
            [blades, splitters, ..] if blades.len() > 1 && splitters.len() == blades.len() => {
                (blades, splitters)
            }
            [blade, other]
                if blade.len() + other.len() == 2
                    && nodes[other[0]].may_be_splitter_of(&nodes[blade[0]], axis) =>
            {
                (blade, other)
            }
            [blades, ..] => (blades, &[]),
            [] => (&[], &[]),
        };
        blades.iter().for_each(|&k| roles[k] = Some(Role::Blade));
        splitters.iter().for_each(|&k| roles[k] = Some(Role::Splitter));
    }
    roles
}
