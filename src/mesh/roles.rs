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

/// Beginnings of words that name a role, without accents.
const BEGINNINGS: [(Role, &[&str]); 4] = [
    (Role::Splitter, &["splitter", "split", "zwischenschaufel", "halbschaufel"]),
    (
        Role::Shroud,
        &["shroud", "casing", "cover", "deckscheibe", "deckband", "carenage", "controdisco", "cubierta"],
    ),
    (
        Role::Hub,
        &[
            "hub",
            "disc",
            "disk",
            "nabe",
            "backplate",
            "tragscheibe",
            "radscheibe",
            "moyeu",
            "disque",
            "mozzo",
            "cubo",
        ],
    ),
    (Role::Blade, &["blade", "vane", "airfoil", "aerofoil", "schaufel", "aubage", "alabe"]),
];
/// Endings of compound words that name a blade, such as `mainblade`, or the hub, such as `Radnabe`.
const BLADE_ENDINGS: [&str; 6] = ["blade", "blades", "vane", "vanes", "schaufel", "schaufeln"];
const HUB_ENDINGS: [&str; 2] = ["nabe", "tragscheibe"];
/// Names of a blade that are words of other things, too: they count where a name has no other word.
const BLADE_ALONE: [&str; 14] = [
    "pale", "pales", "pala", "palas", "aube", "aubes", "ailette", "ailettes", "paletta", "palette", "paleta",
    "paletas", "flugel", "fluegel",
];
/// Words that name a wheel: its hub, where other bodies are its blades.
const WHEEL: [&str; 15] = [
    "impeller",
    "wheel",
    "rotor",
    "runner",
    "laufrad",
    "rad",
    "verdichterrad",
    "pumpenrad",
    "roue",
    "rouet",
    "turbine",
    "girante",
    "ruota",
    "rodete",
    "impulsor",
];
/// Words that name shafts and standard parts: a `cover screw` has the role of a cover only where no other
/// body has it.
const HARDWARE: [&str; 38] = [
    "shaft",
    "nut",
    "washer",
    "screw",
    "bolt",
    "bearing",
    "key",
    "spring",
    "seal",
    "pin",
    "stud",
    "gasket",
    "din",
    "welle",
    "mutter",
    "schraube",
    "lager",
    "passfeder",
    "feder",
    "dichtung",
    "stift",
    "bolzen",
    "arbre",
    "ecrou",
    "rondelle",
    "vis",
    "boulon",
    "roulement",
    "clavette",
    "albero",
    "dado",
    "rondella",
    "vite",
    "cuscinetto",
    "eje",
    "tuerca",
    "arandela",
    "tornillo",
];

/// The role derived from a name, ignoring case, accents and numbers.
pub fn role_from_name(name: &str) -> Option<Role> {
    let words = words(name);
    let begins = |start: &str| {
        words.iter().any(|w| w.strip_prefix(start).is_some_and(|rest| !rest.starts_with("cut")))
    };
    let of = |role: Role| {
        let (_, starts) = BEGINNINGS.iter().find(|(r, _)| *r == role)?;
        starts.iter().any(|start| begins(start)).then_some(role)
    };
    let ends = |endings: &[&str]| words.iter().any(|w| endings.iter().any(|end| w.ends_with(end)));
    let alone = || matches!(&words[..], [word] if BLADE_ALONE.contains(&word.as_str()));
    of(Role::Splitter)
        .or_else(|| of(Role::Shroud))
        .or_else(|| ends(&["deckscheibe"]).then_some(Role::Shroud))
        .or_else(|| of(Role::Hub))
        .or_else(|| of(Role::Blade))
        .or_else(|| ends(&BLADE_ENDINGS).then_some(Role::Blade))
        .or_else(|| ends(&HUB_ENDINGS).then_some(Role::Hub))
        .or_else(|| alone().then_some(Role::Blade))
        .or_else(|| words.iter().any(|w| w == "main").then_some(Role::Blade))
}

/// Whether a name has one of these words, or a compound that ends with it in German.
fn has_word(name: &str, known: &[&str]) -> bool {
    let is = |w: &String| known.iter().any(|k| w == k || (k.len() > 4 && w.ends_with(k)));
    words(name).iter().any(is)
}

/// The letter without its accent.
fn plain(c: char) -> char {
    match c {
        'á' | 'à' | 'â' | 'ä' | 'ã' | 'å' => 'a',
        'é' | 'è' | 'ê' | 'ë' => 'e',
        'í' | 'ì' | 'î' | 'ï' => 'i',
        'ó' | 'ò' | 'ô' | 'ö' | 'õ' => 'o',
        'ú' | 'ù' | 'û' | 'ü' => 'u',
        'ç' => 'c',
        'ñ' => 'n',
        _ => c,
    }
}

/// Words of a name in lower case, without accents: runs of letters, also split before capitals (`MainBlade`
/// is two words).
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut lower_before = false;
    // Accents may also be characters of their own, after the letter.
    for c in name.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)) {
        let starts = !c.is_alphabetic() || (c.is_uppercase() && lower_before);
        if starts && !words[words.len() - 1].is_empty() {
            words.push(String::new());
        }
        if c.is_alphabetic() {
            let last = words.len() - 1;
            words[last].extend(c.to_lowercase().map(plain));
        }
        lower_before = c.is_lowercase();
    }
    words.retain(|w| !w.is_empty());
    words
}

/// The role derived from the names of each mesh: that of the first name that has one. The mesh of a node that
/// is alone in its file is the whole wheel: its name or that of the file, such as `bladed disc`, gives no
/// role, unless its pieces have different ones. Where blades are named and no hub is, it is the one mesh with
/// the name of a wheel. Standard parts have no role that another mesh has.
pub fn roles_from_names(meshes: &[NamedMesh]) -> Vec<Option<Role>> {
    // The own name comes first: the root node often has the name of the part, which may contain that of a
    // role.
    let of = |mesh: &NamedMesh| {
        std::iter::once(&mesh.name).chain(&mesh.other_names).find_map(|name| role_from_name(name))
    };
    let mut roles: Vec<Option<Role>> = meshes.iter().map(of).collect();
    let full = || meshes.iter().zip(&roles).filter(|(mesh, _)| !mesh.mesh.triangles.is_empty());
    let first = full().next().map(|(mesh, role)| (mesh.node, mesh.instance, *role));
    let alone = full().all(|(mesh, role)| first == Some((mesh.node, mesh.instance, *role)));
    if alone {
        return vec![None; meshes.len()];
    }
    let is_hardware: Vec<bool> = meshes.iter().map(|mesh| has_word(&mesh.name, &HARDWARE)).collect();
    let row = |role: Role| if role == Role::Splitter { Role::Blade } else { role };
    let own: Vec<Role> =
        roles.iter().zip(&is_hardware).filter(|(_, h)| !**h).filter_map(|(role, _)| role.map(row)).collect();
    for (role, _) in roles.iter_mut().zip(&is_hardware).filter(|(_, hardware)| **hardware) {
        *role = role.filter(|role| !own.contains(&row(*role)));
    }
    let has = |role: Role| roles.contains(&Some(role));
    if has(Role::Blade) && !has(Role::Hub) {
        let names = |mesh: &'_ NamedMesh| -> Vec<String> {
            std::iter::once(&mesh.name).chain(&mesh.other_names).cloned().collect()
        };
        let is_wheel = |k: &usize| {
            let mut said = names(&meshes[*k]);
            // Names that blades have, too, are those of the whole wheel.
            said.retain(|name| {
                let shares =
                    |(mesh, role): (&NamedMesh, &Option<Role>)| role.is_some() && names(mesh).contains(name);
                !meshes.iter().zip(&roles).any(shares)
            });
            roles[*k].is_none() && !is_hardware[*k] && said.iter().any(|name| has_word(name, &WHEEL))
        };
        let wheels: Vec<usize> = (0..meshes.len()).filter(is_wheel).collect();
        if let [wheel] = wheels[..] {
            roles[wheel] = Some(Role::Hub);
        }
    }
    roles
}

/// Roles that the user gives by node name (ignoring case) or by `#` and the node's number.
///
/// # Errors
/// Fails when a given name does not belong to any mesh.
pub fn given_roles(meshes: &[NamedMesh], given: &[(String, Role)]) -> Result<Vec<Option<Role>>, PartError> {
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
    let role = |mesh: &NamedMesh| given.iter().rev().find(|(name, _)| is(mesh, name)).map(|(_, role)| *role);
    Ok(meshes.iter().map(role).collect())
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
            ("Laufradnabe", Role::Hub),
            ("Pumpendeckscheibe", Role::Shroud),
            ("Moyeu", Role::Hub),
            ("Pale 3", Role::Blade),
            ("Mozzo", Role::Hub),
            ("PALA_2", Role::Blade),
            ("Cubo", Role::Hub),
            ("\u{c1}labe.4", Role::Blade),
            ("A\u{301}labe 4", Role::Blade),
            ("Flügel:1", Role::Blade),
            ("Impeller Blade 1", Role::Blade),
        ] {
            assert_eq!(role_from_name(name), Some(role), "{name}");
        }
        for name in
            ["Body 1", "Mesh.003", "vanecut", "", "42", "shaft", "pale grey", "Flügelmutter", "Laufrad"]
        {
            assert_eq!(role_from_name(name), None, "{name}");
        }
    }

    fn roles_of(names: &[(&str, &[&str])]) -> Vec<Option<Role>> {
        let mesh = |(node, (name, other)): (usize, &(&str, &[&str]))| NamedMesh {
            name: (*name).to_owned(),
            other_names: other.iter().map(|name| (*name).to_owned()).collect(),
            node,
            instance: 0,
            mesh: TriangleMesh {
                points: vec![crate::geometry::Point::origin(); 3],
                triangles: vec![[0, 1, 2]],
            },
        };
        roles_from_names(&names.iter().enumerate().map(mesh).collect::<Vec<_>>())
    }

    #[test]
    fn the_wheel_beside_named_blades_is_the_hub() {
        let (hub, blade) = (Some(Role::Hub), Some(Role::Blade));
        assert_eq!(roles_of(&[("Laufrad", &[]), ("Schaufel 1", &[]), ("Welle", &[])]), [hub, blade, None]);
        assert_eq!(roles_of(&[("", &["Impeller"]), ("Vane1", &[]), ("E1", &[])]), [hub, blade, None]);
        // The name of the assembly says nothing of its bodies, and without blades a wheel may be in one body.
        assert_eq!(roles_of(&[("A1", &["Impeller"]), ("Vane1", &["Impeller"])]), [None, blade]);
        assert_eq!(roles_of(&[("Wheel", &[]), ("Shaft", &[])]), [None, None]);
        assert_eq!(roles_of(&[("Hub", &[]), ("Vane1", &[]), ("Wheel", &[])]), [hub, blade, None]);
    }

    #[test]
    fn standard_parts_are_not_what_they_hold() {
        let (hub, blade) = (Some(Role::Hub), Some(Role::Blade));
        let names: [(&str, &[&str]); 5] = [
            ("Hub", &[]),
            ("Blade 1", &[]),
            ("hub nut", &[]),
            ("Split washer", &[]),
            ("Cover screw M4", &[]),
        ];
        // It is a cover where no other body is one.
        assert_eq!(roles_of(&names), [hub, blade, None, None, Some(Role::Shroud)]);
        assert_eq!(roles_of(&[("Hub shaft", &[]), ("Blade 1", &[])]), [hub, blade]);
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
            assert_eq!(given_roles(&[full(name)], &given), Ok(vec![Some(Role::Hub)]), "{name}");
        }
        assert_eq!(roles_from_names(&[full("hub"), full("vane 2")]), [Some(Role::Hub), Some(Role::Blade)]);
    }
}
