//! Every shader parses and validates; no device is needed.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

use std::path::Path;

#[test]
fn every_shader_is_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut seen = 0;
    for entry in std::fs::read_dir(&folder).expect("shaders/ is there") {
        let path = entry.expect("shaders/ can be listed").path();
        if path.extension().is_none_or(|extension| extension != "wgsl") {
            continue;
        }
        seen += 1;
        let name = path.file_name().expect("a file has a name").to_string_lossy().into_owned();
        let source = std::fs::read_to_string(&path).expect("shaders are text");
        let module = naga::front::wgsl::parse_str(&source)
            .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string_with_path(&source, &name)));
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string_with_path(&source, &name)));
    }
    assert!(seen > 0, "no shader in shaders/");
}
