//! Any bytes as a glTF part, by the names of its nodes and with roles guessed by their shapes.
//!
//! With a stable toolchain: `RUSTC_BOOTSTRAP=1 cargo fuzz run gltf --sanitizer none`. Coarse scenes are good
//! to start from: `vanecut convert assets/parts/pump6.toml fuzz/corpus/gltf/pump6.glb --chord-error 3`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vanecut::io::gltf::{read_bytes, read_meshes_bytes};
use vanecut::mesh::nodes::{guess, nodes};
use vanecut::mesh::{MeshOptions, Unit};
use vanecut::part::Impeller;

fuzz_target!(|bytes: &[u8]| {
    let Ok(meshes) = read_meshes_bytes("a.glb", bytes) else { return };
    let nodes = nodes(&meshes);
    let roles = nodes.iter().zip(guess(&nodes)).filter_map(|(node, role)| Some((node.key.clone(), role?)));
    let guessed = MeshOptions { roles: roles.collect(), unit: Some(Unit::Metre), ..MeshOptions::default() };
    for options in [MeshOptions::default(), guessed] {
        if let Ok(description) = read_bytes("a.glb", bytes, &options) {
            let _ = Impeller::build(&description);
        }
    }
});
