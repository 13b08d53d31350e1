//! Broken, hostile and unusual glTF files give a one-line error each, or the intended mesh.

use std::path::Path;
use std::sync::LazyLock;

use proptest::collection::vec;
use proptest::prelude::*;
use serde_json::{Value, json};
use vanecut::error::ErrorCode;
use vanecut::io::gltf::{GltfScene, read_bytes, read_meshes, read_meshes_bytes};
use vanecut::io::{InputError, read_part};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::mesh::{MeshOptions, NamedMesh};
use vanecut::part::Impeller;

/// Two triangles in one mesh on one node, with the buffer in a separate file.
fn square() -> (Value, Vec<u8>) {
    let mut bytes: Vec<u8> = Vec::new();
    for x in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_le_bytes());
    }
    for i in [0u16, 1, 2, 0, 2, 3] {
        bytes.extend(i.to_le_bytes());
    }
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "hub", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
        ],
        "buffers": [{ "byteLength": 60 }],
    });
    (document, bytes)
}

fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    for word in [2, length as u32, json.len() as u32, 0x4E4F_534A] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(json);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(0x004E_4942_u32.to_le_bytes());
    bytes.extend(binary);
    bytes
}

fn edited(edit: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Result<Vec<NamedMesh>, InputError> {
    let (mut document, mut binary) = square();
    edit(&mut document, &mut binary);
    read_meshes_bytes("a.glb", &glb(&document, &binary))
}

fn is_clear(error: &InputError) {
    let text = error.to_string();
    assert!(text.starts_with("a.gl") && !text.contains('\n') && text.len() < 400, "{text}");
    assert!(!error.message.is_empty() && !error.help.is_empty(), "{text}");
}

type Edit = fn(&mut Value, &mut Vec<u8>);

#[test]
fn broken_files_are_refused_in_one_line() {
    let broken: [(&str, ErrorCode, &str, Edit); 31] = [
        ("no asset", ErrorCode::MeshFile, "asset", |d, _| drop(d.as_object_mut().unwrap().remove("asset"))),
        ("old version", ErrorCode::GltfVersion, "1.0", |d, _| d["asset"]["version"] = json!("1.0")),
        ("cycle", ErrorCode::GltfReference, "node 0", |d, _| d["nodes"][0]["children"] = json!([0])),
        ("two parents", ErrorCode::GltfReference, "node 0", |d, _| d["scenes"][0]["nodes"] = json!([0, 0])),
        ("no such node", ErrorCode::GltfReference, "node 7", |d, _| d["scenes"][0]["nodes"] = json!([7])),
        ("no such scene", ErrorCode::GltfReference, "scene 3", |d, _| d["scene"] = json!(3)),
        ("no such mesh", ErrorCode::GltfReference, "mesh 9", |d, _| d["nodes"][0]["mesh"] = json!(9)),
        ("no such accessor", ErrorCode::GltfReference, "accessor 5", |d, _| {
            d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(5);
        }),
        ("no such view", ErrorCode::GltfReference, "buffer view 8", |d, _| {
            d["accessors"][0]["bufferView"] = json!(8);
        }),
        ("no such buffer", ErrorCode::GltfReference, "buffer 4", |d, _| {
            d["bufferViews"][0]["buffer"] = json!(4);
        }),
        ("no data", ErrorCode::GltfAccessor, "accessor 0", |d, _| {
            drop(d["accessors"][0].as_object_mut().unwrap().remove("bufferView"));
        }),
        ("view too long", ErrorCode::FileCutOff, "buffer 0", |d, _| {
            d["bufferViews"][0]["byteLength"] = json!(4000);
        }),
        ("view overflows", ErrorCode::FileCutOff, "buffer 0", |d, _| {
            d["bufferViews"][0]["byteOffset"] = json!(u64::MAX);
        }),
        ("accessor too long", ErrorCode::FileCutOff, "4000", |d, _| d["accessors"][0]["count"] = json!(4000)),
        ("absurd count", ErrorCode::FileTooLarge, "18446744073709551615", |d, _| {
            d["accessors"][0]["count"] = json!(u64::MAX);
        }),
        ("offset overflows", ErrorCode::FileCutOff, "18446744073709551615", |d, _| {
            d["accessors"][0]["byteOffset"] = json!(u64::MAX);
        }),
        ("stride too short", ErrorCode::FileCutOff, "accessor 0", |d, _| {
            d["bufferViews"][0]["byteStride"] = json!(4);
        }),
        ("negative count", ErrorCode::MeshFile, "-1", |d, _| d["accessors"][0]["count"] = json!(-1)),
        ("wrong type", ErrorCode::GltfAccessor, "VEC2", |d, _| d["accessors"][0]["type"] = json!("VEC2")),
        ("unknown component", ErrorCode::GltfAccessor, "5126", |d, _| {
            d["accessors"][1]["componentType"] = json!(5126);
        }),
        ("index out of range", ErrorCode::MeshValues, "200", |_, b| b[48] = 200),
        ("NaN", ErrorCode::MeshValues, "element 0", |_, b| b[..4].copy_from_slice(&f32::NAN.to_le_bytes())),
        ("infinite scale", ErrorCode::MeshValues, "node 0", |d, _| {
            d["nodes"][0]["matrix"] = json!([1e308, 0, 0, 0, 0, 1e308, 0, 0, 0, 0, 1, 0, 1e308, 0, 0, 1]);
            d["nodes"].as_array_mut().unwrap().push(json!({ "scale": [1e308, 1, 1], "children": [0] }));
            d["scenes"][0]["nodes"] = json!([1]);
        }),
        ("buffer too short", ErrorCode::FileCutOff, "buffer 0", |d, _| {
            d["buffers"][0] = json!({ "byteLength": 6000, "uri": "data:;base64,AAAA" });
        }),
        ("absurd buffer", ErrorCode::FileTooLarge, "", |d, _| {
            d["buffers"][0] = json!({ "byteLength": u64::MAX, "uri": "data:;base64,AAAA" });
        }),
        ("missing buffer", ErrorCode::MeshBuffer, "buffer 0", |d, _| {
            d["buffers"][0]["uri"] = json!("there.bin");
        }),
        ("bad data URI", ErrorCode::MeshFile, "buffer 0", |d, _| {
            d["buffers"][0]["uri"] = json!("data:;base64,***");
        }),
        ("Draco", ErrorCode::MeshCompressed, "Draco", |d, _| {
            d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        }),
        ("meshopt", ErrorCode::MeshCompressed, "meshopt", |d, _| {
            d["bufferViews"][0]["extensions"] = json!({ "EXT_meshopt_compression": { "buffer": 0 } });
        }),
        ("unknown extension", ErrorCode::GltfExtension, "ACME_x", |d, _| {
            d["extensionsRequired"] = json!(["ACME_x"]);
        }),
        ("too many instances", ErrorCode::FileTooLarge, "node 0", |d, _| {
            d["accessors"].as_array_mut().unwrap().push(json!(
                { "bufferView": 0, "componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3" }
            ));
            d["nodes"][0]["extensions"] =
                json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 2 } } });
        }),
    ];
    assert!(edited(|_, _| {}).is_ok());
    for (what, code, element, edit) in broken {
        let error = edited(edit).map(|m| m.len()).expect_err(what);
        is_clear(&error);
        assert_eq!(error.code, code, "{what}: {error}");
        assert!(error.message.contains(element), "{what}: names the element: {error}");
    }
}

#[test]
fn deep_graphs_and_long_lists_end() {
    let deep = 90_000;
    let mut nodes: Vec<Value> = (1..deep).map(|i| json!({ "children": [i] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    assert_eq!(edited(|d, _| d["nodes"] = json!(nodes)).unwrap().len(), 1);
    let many: Vec<Value> = vec![json!({}); 100_001];
    is_clear(&edited(|d, _| d["nodes"] = json!(many)).unwrap_err());
    let nested = "[".repeat(200_000);
    is_clear(&read_meshes_bytes("a.gltf", format!("{{\"asset\":{nested}").as_bytes()).unwrap_err());
    // Many nodes that refer to one mesh.
    let crowd: Vec<Value> = vec![json!({ "mesh": 0 }); 20_000];
    let error = edited(|d, _| {
        d["nodes"] = json!(crowd);
        d["scenes"][0]["nodes"] = json!((0..20_000).collect::<Vec<_>>());
    });
    is_clear(&error.unwrap_err());
}

#[test]
fn buffers_stay_in_the_folder_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    std::fs::create_dir(&inside).unwrap();
    let (mut document, binary) = square();
    std::fs::write(folder.path().join("secret.bin"), &binary).unwrap();
    std::fs::write(inside.join("good one.bin"), &binary).unwrap();
    let mut open = |uri: &str| {
        document["buffers"][0]["uri"] = json!(uri);
        let path = inside.join("a.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        read_meshes(&path)
    };
    assert_eq!(open("good%20one.bin").unwrap().len(), 1);
    assert_eq!(open("./good one.bin").unwrap().len(), 1);
    let absolute = folder.path().join("secret.bin").display().to_string();
    let links = if cfg!(unix) {
        #[cfg(unix)]
        std::os::unix::fs::symlink("../secret.bin", inside.join("link.bin")).unwrap();
        vec!["link.bin"]
    } else {
        Vec::new()
    };
    let refused =
        ["../secret.bin", "%2e%2e/secret.bin", "x/../../secret.bin", "file:secret.bin", "http://a/b.bin"];
    for uri in refused.into_iter().chain([absolute.as_str(), "..\\secret.bin", "", "."]).chain(links) {
        let error = open(uri).map(|m| m.len()).expect_err(uri);
        // The folder itself is in the folder, but no file.
        let expected = if uri == "." { ErrorCode::FileUnreadable } else { ErrorCode::MeshBuffer };
        assert_eq!(error.code, expected, "{uri}: {error}");
    }
    assert_eq!(open("missing.bin").unwrap_err().code, ErrorCode::FileUnreadable);
}

#[test]
fn unusual_meshes_are_read_as_meant() {
    let corners = |meshes: &[NamedMesh]| -> Vec<Vec<[f64; 3]>> {
        let of = |m: &NamedMesh, t: &[u32; 3]| t.map(|i| m.mesh.points[i as usize]);
        meshes
            .iter()
            .map(|m| m.mesh.triangles.iter().flat_map(|t| of(m, t)).map(|p| [p.x, p.y, p.z]).collect())
            .collect()
    };
    let plain = edited(|_, _| {}).unwrap();
    assert_eq!(plain[0].mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    // Strips reverse every other triangle, fans share their first corner, lists may omit indices.
    let strip = edited(|d, b| {
        d["meshes"][0]["primitives"][0]["mode"] = json!(5);
        d["accessors"][1]["count"] = json!(4);
        [0u8, 1, 3, 2].iter().enumerate().for_each(|(k, i)| b[48 + 2 * k] = *i);
    });
    assert_eq!(strip.unwrap()[0].mesh.triangles, [[0, 1, 3], [3, 1, 2]]);
    let fan = edited(|d, _| {
        d["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 }, "mode": 6 });
    });
    assert_eq!(fan.unwrap()[0].mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    let bare = edited(|d, _| d["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } }));
    assert_eq!(bare.unwrap()[0].mesh.triangles, [[0, 1, 2]]);
    for (code, size) in [(5121, 1), (5125, 4)] {
        let read = edited(|d, b| {
            b.truncate(48);
            b.extend([0u32, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()[..size].to_vec()));
            d["accessors"][1]["componentType"] = json!(code);
            d["bufferViews"][1]["byteLength"] = json!(6 * size);
            d["buffers"][0]["byteLength"] = json!(48 + 6 * size);
        });
        assert_eq!(corners(&read.unwrap()), corners(&plain));
    }
    // A mirrored transform reverses the triangles, so that they still face outwards.
    let mirrored = edited(|d, _| d["nodes"][0]["scale"] = json!([-1, 2, 1])).unwrap();
    assert_eq!(mirrored[0].mesh.triangles, [[0, 2, 1], [0, 3, 2]]);
    assert_eq!(mirrored[0].mesh.points[2].coords.as_slice(), [-1.0, 2.0, 0.0]);
    // Sparse values replace those of the buffer view.
    let sparse = edited(|d, b| {
        b.extend([2, 0, 0, 0]);
        b.extend([5.0f32, 6.0, 7.0].iter().flat_map(|x| x.to_le_bytes()));
        d["buffers"][0]["byteLength"] = json!(76);
        let views = d["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": 60, "byteLength": 1 }));
        views.push(json!({ "buffer": 0, "byteOffset": 64, "byteLength": 12 }));
        d["accessors"][0]["sparse"] = json!({
            "count": 1, "indices": { "bufferView": 2, "componentType": 5121 }, "values": { "bufferView": 3 },
        });
    });
    assert_eq!(sparse.unwrap()[0].mesh.points[2].coords.as_slice(), [5.0, 6.0, 7.0]);
    // Instances of a node that has a transform itself.
    let instanced = edited(|d, _| {
        d["nodes"] = json!([{ "mesh": 0, "name": "hub", "translation": [0, 0, 1], "extensions": {
            "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } }
        } }]);
    })
    .unwrap();
    assert_eq!(instanced.len(), 4);
    assert_eq!(instanced[2].mesh.points[0].coords.as_slice(), [1.0, 1.0, 1.0]);
}

/// A small wheel as a `.glb` file.
static WHEEL: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller9x9.toml");
    let part = Impeller::build(&read_part(&path).unwrap()).unwrap();
    let coarse = Fineness { chord_error: 0.5, max_triangles: 20_000 };
    GltfScene::of_part(&part, &Tessellation::new(&part, &coarse)).glb()
});

/// Reads a file and builds its part; a panic is the only failure.
fn read_and_build(bytes: &[u8]) {
    if let Ok(description) = read_bytes("a.glb", bytes, &MeshOptions::default()) {
        let _ = Impeller::build(&description);
    }
}

#[test]
fn the_wheel_is_valid() {
    let description = read_bytes("a.glb", &WHEEL, &MeshOptions::default()).unwrap();
    assert_eq!((description.blade_count, description.splitters.len()), (9, 1));
    Impeller::build(&description).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None, max_shrink_iters: 50, cases: 24, ..ProptestConfig::default()
    })]

    #[test]
    fn changed_bytes(
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), in_json in any::<bool>(),
    ) {
        let mut bytes = WHEEL.clone();
        let json = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        for (at, to) in changes {
            let at = if in_json { at.index(20 + json) } else { at.index(bytes.len()) };
            bytes[at] = to;
        }
        read_and_build(&bytes);
    }

    #[test]
    fn changed_numbers(
        at in any::<prop::sample::Index>(),
        to in prop_oneof![Just("0"), Just("99999999999"), Just("1e999"), Just("-1"), Just("7")],
    ) {
        // One number of the JSON is replaced.
        let json = u32::from_le_bytes([WHEEL[12], WHEEL[13], WHEEL[14], WHEEL[15]]) as usize;
        let text = std::str::from_utf8(&WHEEL[20..20 + json]).unwrap();
        let starts: Vec<usize> = text
            .char_indices()
            .filter(|(i, c)| {
                c.is_ascii_digit() && !text[..*i].ends_with(|c: char| c.is_ascii_digit() || c == '.')
            })
            .map(|(i, _)| i)
            .collect();
        let start = starts[at.index(starts.len())];
        let length = text[start..].find(|c: char| !c.is_ascii_digit()).unwrap_or(0);
        let changed = format!("{}{to}{}", &text[..start], &text[start + length..]);
        let binary = &WHEEL[20 + json + 8..];
        let document = serde_json::from_str::<Value>(&changed);
        if let Ok(document) = document {
            read_and_build(&glb(&document, binary));
        } else {
            read_and_build(changed.as_bytes());
        }
    }

    #[test]
    fn cut_off(at in any::<prop::sample::Index>()) {
        let bytes = &WHEEL[..at.index(WHEEL.len())];
        prop_assert!(read_bytes("a.glb", bytes, &MeshOptions::default()).is_err());
    }
}
