//! Any bytes as a STEP file, as bodies and as a part.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vanecut::io::step::{read_bytes, read_scene_bytes};
use vanecut::mesh::MeshOptions;
use vanecut::part::Impeller;

fuzz_target!(|bytes: &[u8]| {
    if read_scene_bytes("a.step", bytes, Some(1.0)).is_err() {
        return;
    }
    if let Ok(description) = read_bytes("a.step", bytes, &MeshOptions::default()) {
        let _ = Impeller::build(&description);
    }
});
