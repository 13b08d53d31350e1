//! Any bytes as a glTF part: `cargo +nightly fuzz run gltf`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vanecut::formats::gltf::read_bytes;
use vanecut::mesh::MeshOptions;
use vanecut::part::Impeller;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(description) = read_bytes("a.glb", bytes, &MeshOptions::default()) {
        let _ = Impeller::build(&description);
    }
});
