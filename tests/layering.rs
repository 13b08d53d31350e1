//! The order of the modules of the library: each uses only those above it, and no two files use each other.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

#[path = "layering/cycles.rs"]
mod cycles;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The modules, innermost first, as in the table of `src/lib.rs`.
const MODULES: [&str; 24] = [
    "error", "monitor", "palette", "geometry", "part", "setup", "mesh", "toolpath", "machine", "cutting",
    "assess", "plunge", "flank", "stock", "tradeoff", "verify", "io", "job", "study", "gpu", "drawing",
    "report", "app", "cli",
];
/// Modules of the core are those before this one.
const FIRST_OUTSIDE: &str = "gpu";
/// Crates that the core must not use.
const OUTSIDE: [&str; 11] =
    ["egui", "eframe", "wgpu", "winit", "glam", "rfd", "bytemuck", "pollster", "naga", "clap", "ctrlc"];

/// What `gpu` uses: it draws meshes, lines and instances, and its kernel is the twin of the heightfield in
/// `stock`. `drawing` turns parts, setups and plans into these.
const USED_BY_GPU: [&str; 6] = ["error", "palette", "geometry", "mesh", "stock", "gpu"];

/// The Rust files below a folder.
fn sources_below(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    found
}

/// The source files of a module of the library.
fn sources(module: &str) -> Vec<PathBuf> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = vec![src.join(format!("{module}.rs"))];
    found.retain(|file| file.exists());
    found.extend(sources_below(&src.join(module)));
    assert!(!found.is_empty(), "no sources of {module}");
    found
}

/// The text of a file without its line comments; lines keep their numbers.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("readable");
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Modules named by `crate::module` or, also over several lines, `crate::{module, …}`; each with its line.
fn modules_named(code: &str) -> Vec<(usize, String)> {
    let mut named = Vec::new();
    for (at, found) in code.match_indices("crate::") {
        let line = 1 + code[..at].matches('\n').count();
        let rest = &code[at + found.len()..];
        let Some(list) = rest.strip_prefix('{') else {
            named.extend(identifier(rest).map(|name| (line, name)));
            continue;
        };
        // The first identifier of each item on the outermost level of the list.
        let (mut depth, mut begins) = (0, true);
        for (i, character) in list.char_indices() {
            match character {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => begins = true,
                c if begins && !c.is_whitespace() => {
                    named.extend(identifier(&list[i..]).map(|name| (line, name)));
                    begins = false;
                }
                _ => {}
            }
        }
    }
    named
}

/// The identifier that `text` begins with.
fn identifier(text: &str) -> Option<String> {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    (end > 0).then(|| text[..end].to_owned())
}

#[test]
fn modules_use_only_those_above_them() {
    let rank = |module: &str| MODULES.iter().position(|name| *name == module);
    let mut faults = Vec::new();
    for (own, module) in MODULES.iter().enumerate() {
        for path in sources(module) {
            for (line, other) in modules_named(&code(&path)) {
                if rank(&other).is_some_and(|other| other > own) {
                    faults.push(format!("{}:{line}: {module} uses {other}", path.display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn gpu_knows_no_parts_and_no_plans() {
    let mut faults = Vec::new();
    for path in sources("gpu") {
        for (line, other) in modules_named(&code(&path)) {
            if MODULES.contains(&other.as_str()) && !USED_BY_GPU.contains(&other.as_str()) {
                faults.push(format!("{}:{line}: gpu uses {other}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// The parts of the window, innermost first, with the crates that they must not use: each uses only those
/// before it, and only the last may name the application itself.
const PARTS_OF_APP: [(&str, &[&str]); 3] = [
    ("app/model", &["egui", "eframe", "wgpu", "winit", "rfd"]),
    ("app/tasks", &["egui", "eframe", "winit", "rfd"]),
    ("app/views", &[]),
];

/// What a part of the window must not name, each with its line: parts behind it, the application, crates.
fn faults_of_app_part(own: usize, code: &str) -> Vec<(usize, String)> {
    let (_, crates) = PARTS_OF_APP[own];
    let behind = PARTS_OF_APP[own + 1..].iter().map(|(part, _)| part.trim_start_matches("app/"));
    // Views draw the application; what lies before them must not know it.
    let is_view = own + 1 == PARTS_OF_APP.len();
    let behind: Vec<&str> =
        behind.chain((!is_view).then_some("control")).chain((!is_view).then_some("App")).collect();
    let mut faults = Vec::new();
    // Paths from the crate or from the folder of the window.
    for start in ["crate::app::", "super::super::", "super::"] {
        for (at, found) in code.match_indices(start) {
            let rest = &code[at + found.len()..];
            let list = rest.strip_prefix('{').and_then(|list| list.split('}').next());
            let names: Vec<&str> = list.map_or_else(|| vec![rest], |list| list.split(',').collect());
            for name in names.into_iter().filter_map(|name| identifier(name.trim())) {
                if behind.contains(&name.as_str()) {
                    faults.push((1 + code[..at].matches('\n').count(), name));
                }
            }
        }
    }
    for (number, line) in code.lines().enumerate() {
        let words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        faults.extend(words.filter(|word| crates.contains(word)).map(|word| (number + 1, word.to_owned())));
    }
    faults
}

#[test]
fn the_model_of_the_window_knows_no_egui_and_tasks_no_views() {
    let mut faults = Vec::new();
    for (own, (part, _)) in PARTS_OF_APP.iter().enumerate() {
        for path in sources(part) {
            for (line, other) in faults_of_app_part(own, &code(&path)) {
                faults.push(format!("{}:{line}: {part} uses {other}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn what_a_part_of_the_window_must_not_name_is_seen() {
    let code = "use crate::app::views::theme;\nuse crate::app::{\n    model::state, tasks};\n\
        fn f(c: &egui::Context) {}";
    let names = |own| faults_of_app_part(own, code).into_iter().map(|(line, name)| format!("{line} {name}"));
    assert_eq!(names(0).collect::<Vec<_>>(), ["1 views", "2 tasks", "4 egui"]);
    assert_eq!(names(1).collect::<Vec<_>>(), ["1 views", "4 egui"]);
    assert_eq!(names(2).count(), 0);
    assert_eq!(faults_of_app_part(1, "use super::super::views::x;\nuse crate::app::App;").len(), 3);
}

#[test]
fn what_docks_is_named_a_panel() {
    // Every panel can be docked and popped out: its file tells what it shows, not where.
    let mut faults = Vec::new();
    for path in sources("app/views") {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let types =
            code(&path).lines().any(|line| line.starts_with("pub struct") && line.contains("Window {"));
        if stem.ends_with("_window") || types {
            faults.push(path.display().to_string());
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn lists_over_several_lines_are_seen() {
    let code = "use crate::{\n    part::{Blade, setup},\n    gpu,\n};\nlet a = crate::io::read();";
    let expected = [(1, "part"), (1, "gpu"), (5, "io")].map(|(line, name)| (line, name.to_owned()));
    assert_eq!(modules_named(code), expected);
}

#[test]
fn the_core_uses_no_screen_and_no_gpu() {
    let mut faults = Vec::new();
    for module in MODULES.iter().take_while(|module| **module != FIRST_OUTSIDE) {
        for path in sources(module) {
            for (number, line) in code(&path).lines().enumerate() {
                let words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                for word in words.filter(|word| OUTSIDE.contains(word)) {
                    faults.push(format!("{}:{}: {module} mentions {word}", path.display(), number + 1));
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// What each module uses, without what follows from others (transitive reduction): `user-uses-used`.
fn arrows() -> BTreeSet<String> {
    let uses: BTreeMap<&str, BTreeSet<String>> = MODULES
        .into_iter()
        .map(|module| {
            let named = sources(module).into_iter().flat_map(|path| modules_named(&code(&path)));
            let others = named.map(|(_, other)| other);
            (module, others.filter(|o| o != module && MODULES.contains(&o.as_str())).collect())
        })
        .collect();
    // Modules come in their order, so that what the used ones reach is known.
    let mut reached: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    let mut arrows = BTreeSet::new();
    for module in MODULES {
        let used = &uses[module];
        let below: BTreeSet<String> = used.iter().flat_map(|other| reached[other.as_str()].clone()).collect();
        arrows.extend(used.difference(&below).map(|other| format!("{module}-uses-{other}")));
        reached.insert(module, below.union(used).cloned().collect());
    }
    arrows
}

#[test]
fn the_picture_of_the_structure_is_up_to_date() {
    let picture = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/structure.svg"))
        .expect("readable");
    let ids = |element: &str| -> BTreeSet<String> {
        let start = format!("<{element} id=\"");
        let starts = picture.split(start.as_str()).skip(1);
        starts.filter_map(|rest| rest.split('"').next()).map(str::to_owned).collect()
    };
    let boxes: BTreeSet<String> = MODULES.into_iter().map(str::to_owned).collect();
    assert_eq!(ids("text"), boxes, "draw it again: scripts/structure");
    assert_eq!(ids("path"), arrows(), "draw it again: scripts/structure");
}

/// The modules in the rows of the first table of `text` that names any; its lines begin with `start`.
fn modules_in_table(text: &str, start: &str) -> Vec<String> {
    let cell = |line: &str| -> Option<String> {
        let name = line.strip_prefix(start)?.trim_start_matches('[').strip_prefix('`')?.split('`').next()?;
        MODULES.contains(&name).then(|| name.to_owned())
    };
    let rows = text.lines().skip_while(|line| cell(line).is_none());
    rows.map_while(cell).collect()
}

#[test]
fn the_tables_of_modules_are_in_the_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (file, start) in [("src/lib.rs", "//! | "), ("docs/ARCHITECTURE.md", "| ")] {
        let text = fs::read_to_string(root.join(file)).expect("readable");
        assert_eq!(modules_in_table(&text, start), MODULES, "{file}");
    }
}

/// Largest number of columns of a comment: rustfmt holds code to it, and leaves comments as they are.
const MAX_COLUMNS: usize = 110;

#[test]
fn comments_wrap() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["src", "tests", "examples", "benches"].map(|folder| sources_below(&root.join(folder)));
    let mut wide = Vec::new();
    for path in folders.into_iter().flatten() {
        let text = fs::read_to_string(&path).expect("readable");
        for (number, line) in text.lines().enumerate() {
            let comment = line.trim_start();
            // Rows of tables are one line each.
            let wraps = comment.starts_with("//") && !comment.starts_with("//! |");
            if wraps && line.chars().count() > MAX_COLUMNS {
                wide.push(format!("{}:{}", path.display(), number + 1));
            }
        }
    }
    assert!(wide.is_empty(), "longer than {MAX_COLUMNS} columns:\n{}", wide.join("\n"));
}

#[test]
fn every_module_is_in_the_order() {
    let library = code(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    for line in library.lines() {
        if let Some(module) = line.trim().strip_prefix("pub mod ").and_then(|rest| rest.strip_suffix(';')) {
            assert!(MODULES.contains(&module), "{module} has no place in the order");
        }
    }
}

/// Names of the types that code declares, each with its line.
fn declared_types(code: &str) -> Vec<(usize, String)> {
    let declared = |(number, line): (usize, &str)| {
        let item = line.trim_start();
        // What an implementation or a trait calls its own type is indented; an alias of a module is not.
        let kinds: &[&str] =
            if item.len() == line.len() { &["struct", "enum", "trait", "type"] } else { &["struct", "enum"] };
        let mut words = item.split_whitespace().skip_while(|word| word.starts_with("pub"));
        let is_declared = words.next().is_some_and(|kind| kinds.contains(&kind));
        let name = words.next().filter(|_| is_declared).and_then(identifier)?;
        Some((number + 1, name))
    };
    code.lines().enumerate().filter_map(declared).collect()
}

#[test]
fn names_of_types_are_unique() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for path in MODULES.iter().flat_map(|module| sources(module)) {
        for (line, name) in declared_types(&code(&path)) {
            places.entry(name).or_default().push(format!("{}:{line}", path.display()));
        }
    }
    assert!(places.len() > 100, "types are found");
    let twice: Vec<String> = places
        .into_iter()
        .filter(|(_, places)| places.len() > 1)
        .map(|(name, places)| format!("{name}: {}", places.join(", ")))
        .collect();
    assert!(twice.is_empty(), "\n{}", twice.join("\n"));
}

#[test]
fn declarations_of_types_are_seen() {
    let code = "pub struct Axis<T> {\n    kind: u32,\n}\npub(super) enum Side {\n}\ntype Rows = Vec<f64>;\n\
        impl Iterator for A {\n    type Item = f64;\n    fn f() {\n        struct Local(f64);\n    }\n}";
    let expected = [(1, "Axis"), (4, "Side"), (6, "Rows"), (10, "Local")];
    assert_eq!(declared_types(code), expected.map(|(line, name)| (line, name.to_owned())));
}
