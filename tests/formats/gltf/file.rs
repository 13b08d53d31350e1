//! An independent glTF reader for tests, by the rules of the format.

use serde_json::Value;

/// JSON document and buffer of a file.
pub struct GltfFile {
    pub json: Value,
    pub binary: Vec<u8>,
}

/// A transform from the column-major matrix of the format.
pub struct Matrix(pub [f64; 16]);

impl Matrix {
    pub fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        let m = &self.0;
        std::array::from_fn(|i| m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i])
    }
}

fn number(value: &Value) -> usize {
    value.as_u64().expect("a whole number") as usize
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

impl GltfFile {
    pub fn of_glb(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        assert_eq!(&bytes[..4], b"glTF");
        assert_eq!((word(4), word(8)), (2, bytes.len()), "version and length");
        let json_length = word(12);
        assert_eq!(&bytes[16..20], b"JSON");
        let json = serde_json::from_slice(&bytes[20..20 + json_length]).expect("JSON");
        let start = 20 + json_length;
        assert_eq!(start % 4, 0);
        assert_eq!(&bytes[start + 4..start + 8], b"BIN\0");
        assert_eq!(word(start), bytes.len() - start - 8);
        Self { json, binary: bytes[start + 8..].to_vec() }
    }

    /// Checks what readers rely on: ranges, alignment, bounds, and valid indices.
    pub fn check(&self) {
        assert_eq!(self.json["asset"]["version"], "2.0");
        assert_eq!(number(&self.json["buffers"][0]["byteLength"]), self.binary.len());
        for view in list(&self.json["bufferViews"]) {
            assert!(number(&view["byteOffset"]) + number(&view["byteLength"]) <= self.binary.len());
            assert_eq!(number(&view["byteOffset"]) % 4, 0);
        }
        for mesh in list(&self.json["meshes"]) {
            for primitive in list(&mesh["primitives"]) {
                let attributes = primitive["attributes"].as_object().expect("attributes");
                let positions = self.vectors::<3>(&attributes["POSITION"]);
                assert!(!positions.is_empty());
                for (name, accessor) in attributes {
                    let accessor = &self.json["accessors"][number(accessor)];
                    assert_eq!(number(&accessor["count"]), positions.len(), "{name}");
                    let view = &self.json["bufferViews"][number(&accessor["bufferView"])];
                    assert_eq!(view["target"], 34_962, "{name}");
                }
                let accessor = &self.json["accessors"][number(&attributes["POSITION"])];
                for k in 0..3 {
                    let of = |fold: fn(f32, f32) -> f32| positions.iter().map(|p| p[k]).reduce(fold);
                    let bound = |key: &str| accessor[key][k].as_f64().map(|x| x as f32);
                    assert_eq!((bound("min"), bound("max")), (of(f32::min), of(f32::max)));
                }
                if let Some(normals) = attributes.get("NORMAL") {
                    for n in self.vectors::<3>(normals) {
                        let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
                        assert!((length - 1.0).abs() < 1e-4, "a normal of length {length}");
                    }
                }
                if !primitive["indices"].is_null() {
                    let indices = self.indices(&primitive["indices"]);
                    assert!(indices.iter().all(|&i| (i as usize) < positions.len()));
                }
                let materials = list(&self.json["materials"]).len();
                assert!(number(&primitive["material"]) < materials);
            }
        }
        let (nodes, meshes) = (list(&self.json["nodes"]), list(&self.json["meshes"]).len());
        for node in nodes {
            assert!(node["mesh"].is_null() || number(&node["mesh"]) < meshes);
            assert!(list(&node["children"]).iter().all(|child| number(child) < nodes.len()));
        }
    }

    fn bytes(&self, accessor: &Value) -> (&Value, &[u8]) {
        let accessor = &self.json["accessors"][number(accessor)];
        let view = &self.json["bufferViews"][number(&accessor["bufferView"])];
        let start = number(&view["byteOffset"]);
        (accessor, &self.binary[start..start + number(&view["byteLength"])])
    }

    /// The vectors of a float accessor.
    pub fn vectors<const N: usize>(&self, accessor: &Value) -> Vec<[f32; N]> {
        let (accessor, bytes) = self.bytes(accessor);
        assert_eq!(accessor["componentType"], 5_126);
        assert_eq!(accessor["type"], format!("VEC{N}"));
        assert_eq!(bytes.len(), 4 * N * number(&accessor["count"]));
        let floats: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        floats.chunks_exact(N).map(|row| std::array::from_fn(|k| row[k])).collect()
    }

    /// Colours of an accessor of four normalised shorts.
    pub fn colours(&self, accessor: &Value) -> Vec<[f32; 3]> {
        let (accessor, bytes) = self.bytes(accessor);
        assert_eq!((&accessor["componentType"], &accessor["normalized"]), (&5_123.into(), &true.into()));
        let part = |b: &[u8]| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65_535.0;
        bytes.chunks_exact(8).map(|b| [part(&b[0..2]), part(&b[2..4]), part(&b[4..6])]).collect()
    }

    /// Indices of an accessor of shorts or ints.
    pub fn indices(&self, accessor: &Value) -> Vec<u32> {
        let (accessor, bytes) = self.bytes(accessor);
        let count = number(&accessor["count"]);
        match number(&accessor["componentType"]) {
            5_123 => bytes
                .chunks_exact(2)
                .take(count)
                .map(|b| u32::from(u16::from_le_bytes([b[0], b[1]])))
                .collect(),
            5_125 => bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
            other => panic!("indices of component type {other}"),
        }
    }

    pub fn root(&self) -> &Value {
        let scene = &self.json["scenes"][number(&self.json["scene"])];
        assert_eq!(list(&scene["nodes"]).len(), 1, "one root");
        &self.json["nodes"][number(&scene["nodes"][0])]
    }

    pub fn root_matrix(&self) -> Matrix {
        let matrix = list(&self.root()["matrix"]);
        Matrix(std::array::from_fn(|k| matrix[k].as_f64().expect("a number")))
    }

    pub fn children_of_root(&self) -> impl Iterator<Item = &Value> {
        list(&self.root()["children"]).iter().map(|child| &self.json["nodes"][number(child)])
    }

    pub fn name(&self, item: &Value) -> String {
        item["name"].as_str().expect("a name").to_owned()
    }

    /// The node with this name.
    pub fn node(&self, name: &str) -> &Value {
        let found = list(&self.json["nodes"]).iter().find(|node| node["name"] == name);
        found.unwrap_or_else(|| panic!("no node {name}"))
    }

    /// Corners and triangles of a node's mesh, all primitives together.
    pub fn local(&self, node: &str) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mesh = &self.json["meshes"][number(&self.node(node)["mesh"])];
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for primitive in list(&mesh["primitives"]) {
            let first = points.len() as u32;
            points.extend(self.vectors::<3>(&primitive["attributes"]["POSITION"]));
            let indices = self.indices(&primitive["indices"]);
            triangles.extend(indices.chunks_exact(3).map(|t| [first + t[0], first + t[1], first + t[2]]));
        }
        (points, triangles)
    }

    /// The same in scene coordinates, m; only for nodes directly below the root.
    pub fn placed(&self, node: &str) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let (points, triangles) = self.local(node);
        let part = |key: &str, rest: &[f64]| -> Vec<f64> {
            let own = list(&self.node(node)[key]);
            if own.is_empty() {
                rest.to_vec()
            } else {
                own.iter().map(|x| x.as_f64().expect("a number")).collect()
            }
        };
        let (q, t) = (part("rotation", &[0.0, 0.0, 0.0, 1.0]), part("translation", &[0.0; 3]));
        let root = self.root_matrix();
        let place = |p: [f64; 3]| {
            // p + 2 q × (q × p + w p)
            let cross = |a: [f64; 3], b: [f64; 3]| {
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
            };
            let axis = [q[0], q[1], q[2]];
            let inner = cross(axis, p);
            let outer = cross(axis, std::array::from_fn(|i| inner[i] + q[3] * p[i]));
            root.apply(std::array::from_fn(|i| p[i] + 2.0 * outer[i] + t[i]))
        };
        (points.into_iter().map(|p| place(p.map(f64::from))).collect(), triangles)
    }
}
