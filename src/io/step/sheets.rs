//! Sheets that meet: surface models come as one sheet for each face, with borders of its own. Sheets at one
//! place are meshed together, with edges that are alike as one, and fall into the bodies that they make up.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::Hash;

use super::assembly::PlacedBody;
use super::body::{BodyFace, MeshedBody, open_edges};
use crate::geometry::bits_of;
use crate::mesh::TriangleMesh;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::roles::{Role, role_from_name};

/// The role that names say, the most specific first.
fn role(body: &PlacedBody) -> Option<Role> {
    std::iter::once(&body.name).chain(&body.parents).find_map(|name| role_from_name(name))
}

/// Groups sheets at one place whose names do not give them different roles; `is_sheet` tells them from
/// solids, which stay alone.
pub fn grouped(bodies: Vec<PlacedBody>, is_sheet: impl Fn(&PlacedBody) -> bool) -> Vec<Vec<PlacedBody>> {
    let mut groups: Vec<(Option<Option<Role>>, Vec<PlacedBody>)> = Vec::new();
    for body in bodies {
        let own = is_sheet(&body).then(|| role(&body));
        let joins = |(role, group): &&mut (Option<Option<Role>>, Vec<PlacedBody>)| {
            own.is_some() && *role == own && group[0].is_beside(&body)
        };
        match groups.iter_mut().find(joins) {
            Some((_, group)) => group.push(body),
            None => groups.push((own, vec![body])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// Edges of the triangles between two different faces: the faces, and whether both run along it in one
/// direction.
fn meetings(mesh: &TriangleMesh, face_of: &[u32]) -> Vec<([usize; 2], bool)> {
    let mut uses: HashMap<(u32, u32), Vec<(u32, bool)>> = HashMap::new();
    for (t, face) in mesh.triangles.iter().zip(face_of) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            uses.entry((a.min(b), a.max(b))).or_default().push((*face, a < b));
        }
    }
    let mut met: Vec<([usize; 2], bool)> = uses
        .into_values()
        .filter_map(|uses| match uses[..] {
            [(a, forward), (b, onwards)] if a != b => {
                Some(([a.min(b) as usize, a.max(b) as usize], forward == onwards))
            }
            _ => None,
        })
        .collect();
    met.sort_unstable();
    met
}

/// Faces that have to be turned over so that neighbours have their material on the same side: by the longer
/// part of their common borders.
fn turned_over(count: usize, met: &[([usize; 2], bool)]) -> Vec<bool> {
    let mut against: BTreeMap<[usize; 2], i64> = BTreeMap::new();
    for (faces, same) in met {
        *against.entry(*faces).or_default() += if *same { 1 } else { -1 };
    }
    let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); count];
    for ([a, b], sum) in against {
        beside[a].push((b, sum > 0));
        beside[b].push((a, sum > 0));
    }
    let mut turned: Vec<Option<bool>> = vec![None; count];
    for start in 0..count {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        let mut waiting = vec![(start, false)];
        while let Some((face, own)) = waiting.pop() {
            for &(next, contrary) in &beside[face] {
                if turned[next].is_none() {
                    turned[next] = Some(own ^ contrary);
                    waiting.push((next, own ^ contrary));
                }
            }
        }
    }
    turned.into_iter().map(|turned| turned == Some(true)).collect()
}

/// Six times the volume that closed triangles enclose, mm³.
fn sixfold_volume(mesh: &TriangleMesh) -> f64 {
    let corner = |i: u32| mesh.points[i as usize].coords;
    mesh.triangles.iter().map(|t| t.map(corner)).map(|[a, b, c]| a.dot(&b.cross(&c))).sum()
}

/// The bodies that the `sheets` make up of which `meshed` has all faces: `counts` of them each, in order.
pub fn apart(mut meshed: MeshedBody, sheets: &[PlacedBody], counts: &[usize]) -> Vec<MeshedBody> {
    let met = meetings(&meshed.mesh, &meshed.face_of);
    let turned = turned_over(meshed.faces.len(), &met);
    for (t, face) in meshed.mesh.triangles.iter_mut().zip(&meshed.face_of) {
        if turned[*face as usize] {
            t.swap(1, 2);
        }
    }
    let sheet_of: Vec<usize> =
        counts.iter().enumerate().flat_map(|(k, count)| std::iter::repeat_n(k, *count)).collect();
    let mut sets = DisjointSets::new(sheets.len());
    for ([a, b], _) in met {
        let (a, b) = (sets.root(sheet_of[a] as u32), sets.root(sheet_of[b] as u32));
        // The first sheet of a body stands for it.
        sets.join(a.min(b), a.max(b));
    }
    // The bodies in the order of their first sheets, and what each has.
    let mut bodies: BTreeMap<u32, Members> = BTreeMap::new();
    let roots: Vec<u32> = (0..sheets.len() as u32).map(|k| sets.root(k)).collect();
    for (k, root) in roots.iter().enumerate() {
        bodies.entry(*root).or_default().sheets.push(k);
    }
    for (k, sheet) in sheet_of.iter().enumerate() {
        bodies.entry(roots[*sheet]).or_default().faces.push(k);
    }
    for (k, face) in meshed.face_of.iter().enumerate() {
        bodies.entry(roots[sheet_of[*face as usize]]).or_default().triangles.push(k);
    }
    let normals_at = by_key(meshed.normals.iter().map(|(p, _)| bits_of(p)));
    let faults_of = by_key(meshed.faults.iter().map(|(id, _)| *id));
    let body = |members: Members| component(&meshed, sheets, &members, &normals_at, &faults_of);
    bodies.into_values().map(body).collect()
}

/// Numbers of what has each key, in order.
type Numbers<K> = HashMap<K, Vec<usize>>;

fn by_key<K: Eq + Hash>(keys: impl Iterator<Item = K>) -> Numbers<K> {
    let mut numbers: Numbers<K> = HashMap::new();
    keys.enumerate().for_each(|(k, key)| numbers.entry(key).or_default().push(k));
    numbers
}

/// The numbers that `keys` have, in order and once each.
fn of_keys<K: Eq + Hash>(numbers: &Numbers<K>, keys: impl Iterator<Item = K>) -> Vec<usize> {
    let mut found: Vec<usize> = keys.filter_map(|key| numbers.get(&key)).flatten().copied().collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// What a body has of what was meshed together, by number.
#[derive(Default)]
struct Members {
    sheets: Vec<usize>,
    faces: Vec<usize>,
    triangles: Vec<usize>,
}

/// The body of some of the sheets.
fn component(
    meshed: &MeshedBody,
    sheets: &[PlacedBody],
    members: &Members,
    normals_at: &Numbers<[u64; 3]>,
    faults_of: &Numbers<u32>,
) -> MeshedBody {
    let number: HashMap<usize, u32> = members.faces.iter().copied().zip(0..).collect();
    let faces: Vec<BodyFace> = members.faces.iter().map(|k| meshed.faces[*k].clone()).collect();
    let mut mesh = meshed.mesh.some(&members.triangles);
    let face_of = members.triangles.iter().map(|t| number[&(meshed.face_of[*t] as usize)]).collect();
    let normals = of_keys(normals_at, mesh.points.iter().map(bits_of));
    let open = open_edges(&mesh);
    let closed = open == 0 && !mesh.triangles.is_empty();
    if closed && sixfold_volume(&mesh) < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let first = &sheets[members.sheets[0]];
    // Names of the others tell them, too.
    let of = |k: &usize| std::iter::once(&sheets[*k].name).chain(&sheets[*k].parents);
    let others = members.sheets.iter().flat_map(of);
    let mut known: HashSet<&String> = HashSet::from([&first.name]);
    let names = first.parents.iter().chain(others);
    let parents = names.filter(|name| !name.is_empty() && known.insert(name)).cloned().collect();
    let faults = of_keys(faults_of, faces.iter().map(|face| face.id));
    MeshedBody {
        id: first.id,
        name: first.name.clone(),
        parents,
        mesh,
        face_of,
        faces,
        normals: normals.into_iter().map(|k| meshed.normals[k]).collect(),
        solid: closed,
        open_edges: open,
        faults: faults.into_iter().map(|k| meshed.faults[k]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn neighbours_are_turned_until_they_agree() {
        // A strip of four triangles, each a face of its own, of which the second and the third are reversed.
        let points = (0..6).map(|k| Point::new(f64::from(k / 2), f64::from(k % 2), 0.0)).collect();
        let triangles = vec![[0, 2, 1], [1, 3, 2], [2, 3, 4], [3, 4, 5]];
        let met = meetings(&TriangleMesh { points, triangles }, &[0, 1, 2, 3]);
        assert_eq!(met.len(), 3);
        assert_eq!(turned_over(4, &met), [false, true, true, false]);
    }
}
