//! Builds a glTF 2.0 document: one buffer with its views and accessors, and the lists that refer to them.

use serde_json::{Map, Value, json};

use crate::io::gltf::container::{BINARY_CHUNK, JSON_CHUNK};

/// Magic bytes of a `.glb`, and the version of the container.
const MAGIC: (&[u8; 4], u32) = (b"glTF", 2);

const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const UNSIGNED_SHORT: u32 = 5_123;
const UNSIGNED_INT: u32 = 5_125;
const FLOAT: u32 = 5_126;

/// Purpose of an accessor of floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccessorUse {
    /// Positions of corners, with the bounds that the format requires.
    Positions,
    /// Other attributes of corners.
    Corners,
    /// Attributes of instances.
    Instances,
}

/// The document under construction.
#[derive(Debug, Default)]
pub struct GltfBuilder {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    extensions: Vec<&'static str>,
}

impl GltfBuilder {
    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: Option<u32>) -> usize {
        let start = self.binary.len();
        self.binary.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": self.binary.len() - start });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        // Every element must be aligned to the size of its components.
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds an accessor of vectors of `N` floats; returns its index.
    pub fn floats<const N: usize>(&mut self, rows: &[[f32; N]], what: AccessorUse) -> usize {
        let target = (what != AccessorUse::Instances).then_some(ARRAY_BUFFER);
        let view = self.view(rows.iter().flatten().flat_map(|x| x.to_le_bytes()), target);
        let mut accessor = json!({
            "bufferView": view, "componentType": FLOAT, "count": rows.len(), "type": format!("VEC{N}"),
        });
        if what == AccessorUse::Positions {
            let mut bounds = [[f32::INFINITY; N], [f32::NEG_INFINITY; N]];
            for row in rows {
                for k in 0..N {
                    bounds[0][k] = bounds[0][k].min(row[k]);
                    bounds[1][k] = bounds[1][k].max(row[k]);
                }
            }
            for (key, bound) in ["min", "max"].into_iter().zip(bounds) {
                accessor[key] = bound.iter().map(|&x| json!(f64::from(x))).collect();
            }
        }
        self.accessor(accessor)
    }

    /// Adds an accessor of linear colours, components 0…1; returns its index.
    pub fn colours(&mut self, colours: &[[f32; 3]]) -> usize {
        let part = |x: f32| (x.clamp(0.0, 1.0) * 65_535.0).round() as u16;
        let four = colours.iter().flat_map(|&[r, g, b]| [part(r), part(g), part(b), u16::MAX]);
        let view = self.view(four.flat_map(u16::to_le_bytes), Some(ARRAY_BUFFER));
        self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_SHORT, "normalized": true,
            "count": colours.len(), "type": "VEC4",
        }))
    }

    /// Adds an accessor of indices of `corners` corners; returns its index.
    pub fn indices(&mut self, indices: &[u32], corners: usize) -> usize {
        // The largest value of an index type is reserved for primitive restart.
        let short = corners < usize::from(u16::MAX);
        let target = Some(ELEMENT_ARRAY_BUFFER);
        let view = if short {
            self.view(indices.iter().flat_map(|&i| (i as u16).to_le_bytes()), target)
        } else {
            self.view(indices.iter().flat_map(|i| i.to_le_bytes()), target)
        };
        let kind = if short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        self.accessor(json!({
            "bufferView": view, "componentType": kind, "count": indices.len(), "type": "SCALAR",
        }))
    }

    /// Adds a material; returns its index.
    pub fn material(&mut self, material: Value) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a mesh; returns its index.
    pub fn mesh(&mut self, name: &str, primitives: Vec<Value>) -> usize {
        self.meshes.push(json!({ "name": name, "primitives": primitives }));
        self.meshes.len() - 1
    }

    /// Adds a node; returns its index.
    pub fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Lists an extension as used, not as required.
    pub fn uses(&mut self, extension: &'static str) {
        if !self.extensions.contains(&extension) {
            self.extensions.push(extension);
        }
    }

    /// The document with the node `root` as its only scene; `uri` names the buffer if it is a separate file.
    fn document(&self, root: usize, uri: Option<&str>) -> Value {
        let mut buffer = json!({ "byteLength": self.binary.len() });
        if let Some(uri) = uri {
            buffer["uri"] = json!(uri);
        }
        let mut document = Map::new();
        let generator = concat!("vanecut ", env!("CARGO_PKG_VERSION"));
        document.insert("asset".into(), json!({ "version": "2.0", "generator": generator }));
        document.insert("scene".into(), json!(0));
        document.insert("scenes".into(), json!([{ "nodes": [root] }]));
        document.insert("nodes".into(), json!(self.nodes));
        for (key, list) in [
            ("meshes", &self.meshes),
            ("materials", &self.materials),
            ("accessors", &self.accessors),
            ("bufferViews", &self.views),
        ] {
            document.insert(key.into(), json!(list));
        }
        document.insert("buffers".into(), json!([buffer]));
        if !self.extensions.is_empty() {
            document.insert("extensionsUsed".into(), json!(self.extensions));
        }
        Value::Object(document)
    }

    /// The bytes of a `.glb`.
    pub fn glb(&self, root: usize) -> Vec<u8> {
        let mut json = self.document(root, None).to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = Vec::with_capacity(12 + 8 + json.len() + 8 + self.binary.len());
        glb.extend_from_slice(MAGIC.0);
        glb.extend_from_slice(&MAGIC.1.to_le_bytes());
        glb.extend_from_slice(&((28 + json.len() + self.binary.len()) as u32).to_le_bytes());
        for (kind, chunk) in [(JSON_CHUNK, &json), (BINARY_CHUNK, &self.binary)] {
            glb.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
            glb.extend_from_slice(&kind.to_le_bytes());
            glb.extend_from_slice(chunk);
        }
        glb
    }

    /// The text of a `.gltf`, and the bytes of the buffer file that its JSON names `uri`.
    pub fn gltf(&self, root: usize, uri: &str) -> (String, Vec<u8>) {
        let mut text = serde_json::to_string_pretty(&self.document(root, Some(uri))).unwrap_or_default();
        text.push('\n');
        (text, self.binary.clone())
    }
}
