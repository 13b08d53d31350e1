//! Modules depend only on modules further in, and the core does not depend on the window or the graphics
//! device.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules in order, each with the other modules it may depend on.
const ROOMS: [(&str, &[&str]); 15] = [
    ("monitor", &[]),
    ("palette", &[]),
    ("geometry", &[]),
    ("part", &["geometry"]),
    ("mesh", &["geometry", "part", "monitor"]),
    ("assess", &["geometry", "part"]),
    ("plunge", &["geometry", "part", "monitor"]),
    ("flank", &["geometry", "part", "plunge", "monitor"]),
    ("residual", &["geometry", "part", "mesh", "plunge", "monitor"]),
    ("formats", &["palette", "geometry", "part", "mesh", "plunge", "flank", "residual"]),
    ("verify", &["geometry", "part", "mesh", "plunge", "flank", "residual", "formats", "monitor"]),
    ("job", &["geometry", "part", "mesh", "plunge", "flank", "residual", "formats", "verify", "monitor"]),
    (
        "gpu",
        &[
            "palette", "geometry", "part", "mesh", "plunge", "flank", "residual", "formats", "verify", "job",
            "monitor",
        ],
    ),
    (
        "app",
        &[
            "palette", "geometry", "part", "mesh", "plunge", "flank", "residual", "formats", "verify", "job",
            "monitor", "gpu",
        ],
    ),
    (
        "cli",
        &[
            "palette", "geometry", "part", "mesh", "assess", "plunge", "flank", "residual", "formats",
            "verify", "job", "monitor", "gpu", "app",
        ],
    ),
];
/// Modules of the core.
const CORE: [&str; 12] = [
    "monitor", "palette", "geometry", "part", "mesh", "assess", "plunge", "flank", "residual", "formats",
    "verify", "job",
];
/// Crates that the core must not use.
const OUTSIDE: [&str; 9] = ["egui", "eframe", "wgpu", "winit", "glam", "rfd", "bytemuck", "pollster", "naga"];

fn sources(room: &str) -> Vec<PathBuf> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = vec![src.join(format!("{room}.rs"))];
    found.retain(|file| file.exists());
    let mut folders = vec![src.join(room)];
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
    assert!(!found.is_empty(), "no sources of {room}");
    found
}

/// Lines of a file without their comments, numbered from 1.
fn code(path: &Path) -> Vec<(usize, String)> {
    let text = fs::read_to_string(path).unwrap();
    let bare = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
    text.lines().map(bare).enumerate().map(|(i, line)| (i + 1, line)).collect()
}

/// Modules that a line refers to by `crate::module` or `crate::{module, …}`.
fn rooms_named(line: &str) -> Vec<String> {
    let mut named = Vec::new();
    for (at, _) in line.match_indices("crate::") {
        let rest = &line[at + "crate::".len()..];
        let list = rest.strip_prefix('{').and_then(|rest| rest.split('}').next()).unwrap_or(rest);
        let count = if rest.starts_with('{') { usize::MAX } else { 1 };
        for item in list.split(',').take(count) {
            let name = item.trim().split(|c: char| !(c.is_alphanumeric() || c == '_')).next();
            named.extend(name.map(str::to_owned));
        }
    }
    named
}

#[test]
fn rooms_look_inwards_only() {
    let mut faults = Vec::new();
    for (room, allowed) in ROOMS {
        for path in sources(room) {
            for (number, line) in code(&path) {
                for other in rooms_named(&line) {
                    let is_room = ROOMS.iter().any(|(name, _)| *name == other);
                    if is_room && other != room && !allowed.contains(&other.as_str()) {
                        faults.push(format!("{}:{number}: {room} depends on {other}", path.display()));
                    }
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_core_knows_no_screen() {
    let mut faults = Vec::new();
    for room in CORE {
        for path in sources(room) {
            for (number, line) in code(&path) {
                let words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                for word in words.filter(|word| OUTSIDE.contains(word)) {
                    faults.push(format!("{}:{number}: {room} uses {word}", path.display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn every_room_is_listed() {
    let lib = code(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    for (_, line) in lib {
        if let Some(room) = line.trim().strip_prefix("pub mod ").and_then(|rest| rest.strip_suffix(';')) {
            assert!(ROOMS.iter().any(|(name, _)| *name == room), "{room} is not in the order");
        }
    }
}
