//! Roles of meshes (hub, shroud, blade, …), given by the user or derived from names.

use std::str::FromStr;

use super::TriangleMesh;
use crate::error::{ErrorCode, UserError};
use crate::part::PartError;

/// The part of an impeller that a mesh belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Body of the wheel; only its flow side is used.
    Hub,
    /// Inside of the casing, or the cover.
    Shroud,
    /// Main blades, one or more; splitters among them are recognised by their length.
    Blade,
    /// Splitter blades.
    Splitter,
    /// Not part of the impeller.
    #[serde(rename = "ignore")]
    Ignored,
}

impl Role {
    /// All roles, in the order of a menu.
    pub const ALL: [Self; 5] = [Self::Hub, Self::Shroud, Self::Blade, Self::Splitter, Self::Ignored];

    /// Its name in options and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hub => "hub",
            Self::Shroud => "shroud",
            Self::Blade => "blade",
            Self::Splitter => "splitter",
            Self::Ignored => "ignore",
        }
    }
}

impl FromStr for Role {
    type Err = UserError;

    fn from_str(text: &str) -> Result<Self, UserError> {
        let text = text.to_lowercase();
        let known = Self::ALL.into_iter().find(|role| role.name() == text);
        known.or((text == "main").then_some(Self::Blade)).ok_or_else(|| {
            let what = format!("`{text}` is not a role");
            UserError::new(ErrorCode::UnknownName, what, "give hub, shroud, blade, splitter or ignore")
        })
    }
}

/// One instance of a mesh of a file, in the file's frame.
#[derive(Clone, Debug)]
pub struct NamedMesh {
    /// Name of its node.
    pub name: String,
    /// Further names, the most specific first: material, mesh, parent nodes.
    pub other_names: Vec<String>,
    /// Number of its node in the file: meshes of one node belong together.
    pub node: usize,
    /// Number of the node's instance.
    pub instance: usize,
    /// The triangles.
    pub mesh: TriangleMesh,
}

/// Beginnings of words that name a role.
const BEGINNINGS: [(Role, &[&str]); 4] = [
    (Role::Splitter, &["splitter", "split"]),
    (Role::Shroud, &["shroud", "casing", "cover", "deckscheibe"]),
    (Role::Hub, &["hub", "disc", "disk", "nabe", "backplate", "tragscheibe", "moyeu"]),
    (Role::Blade, &["blade", "vane", "airfoil", "aerofoil", "schaufel"]),
];
/// Endings of compound words that name a blade, such as `mainblade`.
const BLADE_ENDINGS: [&str; 6] = ["blade", "blades", "vane", "vanes", "schaufel", "schaufeln"];

/// The role derived from a name, ignoring case and numbers.
pub fn role_from_name(name: &str) -> Option<Role> {
    let words = words(name);
    let begins = |start: &str| {
        words.iter().any(|w| w.strip_prefix(start).is_some_and(|rest| !rest.starts_with("cut")))
    };
    let of = |role: Role| {
        let (_, starts) = BEGINNINGS.iter().find(|(r, _)| *r == role)?;
        starts.iter().any(|start| begins(start)).then_some(role)
    };
    let compound = || words.iter().any(|w| BLADE_ENDINGS.iter().any(|end| w.ends_with(end)));
    of(Role::Splitter)
        .or_else(|| of(Role::Shroud))
        .or_else(|| of(Role::Hub))
        .or_else(|| of(Role::Blade))
        .or_else(|| compound().then_some(Role::Blade))
        .or_else(|| words.iter().any(|w| w == "main").then_some(Role::Blade))
}

/// Words of a name in lower case: runs of letters, also split before capitals (`MainBlade` is two words).
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut lower_before = false;
    for c in name.chars() {
        let starts = !c.is_alphabetic() || (c.is_uppercase() && lower_before);
        if starts && !words[words.len() - 1].is_empty() {
            words.push(String::new());
        }
        if c.is_alphabetic() {
            let last = words.len() - 1;
            words[last].extend(c.to_lowercase());
        }
        lower_before = c.is_lowercase();
    }
    words.retain(|w| !w.is_empty());
    words
}

/// The role derived from the names of each mesh: that of the first name that has one. The mesh of a node that
/// is alone in its file is the whole wheel: its name or that of the file, such as `bladed disc`, gives no
/// role, unless its pieces have different ones.
pub fn roles_from_names(meshes: &[NamedMesh]) -> Vec<Option<Role>> {
    // The own name comes first: the root node often has the name of the part, which may contain that of a
    // role.
    let of = |mesh: &NamedMesh| {
        std::iter::once(&mesh.name).chain(&mesh.other_names).find_map(|name| role_from_name(name))
    };
    let roles: Vec<Option<Role>> = meshes.iter().map(of).collect();
    let full = || meshes.iter().zip(&roles).filter(|(mesh, _)| !mesh.mesh.triangles.is_empty());
    let first = full().next().map(|(mesh, role)| (mesh.node, mesh.instance, *role));
    let alone = full().all(|(mesh, role)| first == Some((mesh.node, mesh.instance, *role)));
    if alone { vec![None; meshes.len()] } else { roles }
}

/// Roles of all meshes: as `given` by node name (ignoring case) or by `#` and the node's number, else as
/// derived from names.
///
/// # Errors
/// Fails when a given name does not belong to any mesh.
pub fn assign_roles(meshes: &[NamedMesh], given: &[(String, Role)]) -> Result<Vec<Option<Role>>, PartError> {
    let is = |mesh: &NamedMesh, name: &str| {
        if let Some(number) = name.strip_prefix('#').and_then(|number| number.parse::<usize>().ok()) {
            return mesh.node == number;
        }
        let name = name.to_lowercase();
        std::iter::once(&mesh.name).chain(&mesh.other_names).any(|n| n.to_lowercase() == name)
    };
    for (name, _) in given {
        if !meshes.iter().any(|m| is(m, name)) {
            return Err(PartError::new(
                ErrorCode::UnknownName,
                0,
                format!("no mesh is called `{name}`"),
                format!("name one of {}", listed(meshes)),
            ));
        }
    }
    let by_name = roles_from_names(meshes);
    let said = |mesh: &NamedMesh| given.iter().rev().find(|(name, _)| is(mesh, name)).map(|(_, role)| *role);
    Ok(meshes.iter().zip(by_name).map(|(mesh, role)| said(mesh).or(role)).collect())
}

/// The names of the first eight meshes, for a message.
pub fn listed(meshes: &[NamedMesh]) -> String {
    let mut names: Vec<String> = Vec::new();
    for mesh in meshes {
        let name: String = mesh.name.chars().take(40).collect();
        if !names.contains(&name) {
            names.push(name);
        }
        if names.len() > 8 {
            names[8] = "…".to_owned();
            break;
        }
    }
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_roles_in_any_case_and_with_numbers() {
        for (name, role) in [
            ("HUB", Role::Hub),
            ("hub_surface.001", Role::Hub),
            ("ImpellerShroud", Role::Shroud),
            ("Main Blade 12", Role::Blade),
            ("mainblade3", Role::Blade),
            ("MAIN", Role::Blade),
            ("SplitterBlade_2", Role::Splitter),
            ("splitter", Role::Splitter),
            ("Vane7", Role::Blade),
            ("Laufschaufel", Role::Blade),
        ] {
            assert_eq!(role_from_name(name), Some(role), "{name}");
        }
        for name in ["Body 1", "Mesh.003", "vanecut", "", "42", "shaft"] {
            assert_eq!(role_from_name(name), None, "{name}");
        }
    }

    #[test]
    fn a_mesh_alone_has_no_role_by_its_name_but_may_be_given_one() {
        let mesh = |name: &str, triangles: Vec<[u32; 3]>| NamedMesh {
            name: name.to_owned(),
            other_names: vec!["blades".to_owned()],
            node: 0,
            instance: 0,
            mesh: TriangleMesh { points: vec![crate::geometry::Point::origin(); 3], triangles },
        };
        let full = |name: &str| mesh(name, vec![[0, 1, 2]]);
        for name in ["hub", "bladed disc", "Impeller with cover", "impeller_splitter", "shroudless"] {
            assert_eq!(roles_from_names(&[full(name)]), [None], "{name}");
            assert_eq!(roles_from_names(&[mesh("blade", Vec::new()), full(name)]), [None; 2], "{name}");
            let given = [(name.to_owned(), Role::Hub)];
            assert_eq!(assign_roles(&[full(name)], &given), Ok(vec![Some(Role::Hub)]), "{name}");
        }
        assert_eq!(roles_from_names(&[full("hub"), full("vane 2")]), [Some(Role::Hub), Some(Role::Blade)]);
    }
}
