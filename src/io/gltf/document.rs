//! The JSON of a glTF 2.0 file, limited to what meshes and their transforms need: names and meaning are
//! those of the glTF 2.0 specification. Everything else (appearance, textures, animations, cameras) is
//! skipped.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::part::Rotation;

/// Maximum number of elements of any list in the document.
pub const MAX_ITEMS: usize = 100_000;

/// The whole document.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct GltfDocument {
    pub asset: Asset,
    #[serde(default, deserialize_with = "limited")]
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    #[serde(default, deserialize_with = "limited")]
    pub scenes: Vec<SceneRoots>,
    #[serde(default, deserialize_with = "limited")]
    pub nodes: Vec<GltfNode>,
    #[serde(default, deserialize_with = "limited")]
    pub meshes: Vec<GltfMesh>,
    #[serde(default, deserialize_with = "limited")]
    pub materials: Vec<NamedItem>,
    #[serde(default, deserialize_with = "limited")]
    pub accessors: Vec<Accessor>,
    #[serde(default, deserialize_with = "limited")]
    pub buffer_views: Vec<BufferView>,
    #[serde(default, deserialize_with = "limited")]
    pub buffers: Vec<Buffer>,
}

#[derive(Debug, Deserialize)]
pub struct Asset {
    pub version: String,
}

#[derive(Debug, Deserialize)]
pub struct SceneRoots {
    #[serde(default, deserialize_with = "limited")]
    pub nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub struct NamedItem {
    pub name: Option<String>,
}

#[derive(Debug, Deserialize)]
pub struct GltfNode {
    pub name: Option<String>,
    pub mesh: Option<usize>,
    #[serde(default, deserialize_with = "limited")]
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub extensions: Option<NodeExtensions>,
    #[serde(default)]
    pub extras: Extras,
}

/// What Vanecut's own scenes store about a part; other contents are ignored.
#[derive(Debug, Default)]
pub struct Extras {
    /// Sense of rotation, seen from the inlet.
    pub rotation: Option<Rotation>,
}

impl<'de> Deserialize<'de> for Extras {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// Finds the string at a path of keys in nested objects; any other value gives `None`.
        struct Within(&'static [&'static str]);

        impl<'de> DeserializeSeed<'de> for Within {
            type Value = Option<String>;

            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
                deserializer.deserialize_any(self)
            }
        }

        impl<'de> Visitor<'de> for Within {
            type Value = Option<String>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("anything")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut found = None;
                while let Some(key) = map.next_key::<String>()? {
                    match self.0.split_first() {
                        Some((wanted, rest)) if *wanted == key => {
                            found = map.next_value_seed(Self(rest))?;
                        }
                        _ => drop(map.next_value::<IgnoredAny>()?),
                    }
                }
                Ok(found)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                while list.next_element::<IgnoredAny>()?.is_some() {}
                Ok(None)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
                Ok(self.0.is_empty().then(|| text.to_owned()))
            }

            fn visit_bool<E: Error>(self, _: bool) -> Result<Self::Value, E> {
                Ok(None)
            }

            fn visit_i64<E: Error>(self, _: i64) -> Result<Self::Value, E> {
                Ok(None)
            }

            fn visit_u64<E: Error>(self, _: u64) -> Result<Self::Value, E> {
                Ok(None)
            }

            fn visit_f64<E: Error>(self, _: f64) -> Result<Self::Value, E> {
                Ok(None)
            }

            fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
                Ok(None)
            }
        }

        let word = Within(&["vanecut", "rotation"]).deserialize(deserializer)?;
        Ok(Self { rotation: word.and_then(|word| word.parse().ok()) })
    }
}

#[derive(Debug, Deserialize)]
pub struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
}

#[derive(Debug, Deserialize)]
pub struct Instancing {
    pub attributes: InstanceAttributes,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub struct InstanceAttributes {
    pub translation: Option<usize>,
    pub rotation: Option<usize>,
    pub scale: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub struct GltfMesh {
    pub name: Option<String>,
    #[serde(default, deserialize_with = "limited")]
    pub primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    pub extensions: Option<PrimitiveExtensions>,
}

#[derive(Debug, Deserialize)]
pub struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub struct Sparse {
    pub count: usize,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    pub extensions: Option<ViewExtensions>,
}

#[derive(Debug, Deserialize)]
pub struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub meshopt: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
}

/// Deserializes a list of at most [`MAX_ITEMS`] elements, so that a short text of empty objects cannot
/// exhaust memory.
fn limited<'de, D, T>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct List<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for List<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a list")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
            let mut items = Vec::new();
            while let Some(item) = list.next_element()? {
                if items.len() == MAX_ITEMS {
                    return Err(A::Error::custom(format!("a list has more than {MAX_ITEMS} elements")));
                }
                items.push(item);
            }
            Ok(items)
        }
    }

    deserializer.deserialize_seq(List(PhantomData))
}
