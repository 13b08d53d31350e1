//! Writes glTF 2.0: parts and plans as scenes for any viewer.
//!
//! The unit of the file is the metre. Its root node rotates the part's axis Z to the file's Y (up); all
//! nodes below it are in the part frame. `extras.vanecut` of the root names that axis and has the figures of
//! the plan (mm, degrees).

mod builder;
mod cutter;
mod flank;
mod part;
mod plan;
mod stock;

pub use plan::{CutterNodes, PlanScene};

use serde_json::json;

use builder::GltfBuilder;
use part::{WallColours, part_nodes, root};

use crate::mesh::tessellate::Tessellation;
use crate::part::Impeller;

/// A scene, ready to be written.
#[derive(Debug)]
pub struct GltfScene {
    builder: GltfBuilder,
    root: usize,
}

impl GltfScene {
    /// Scene of a part alone.
    ///
    /// ```
    /// use vanecut::io::gltf::{GltfScene, read_bytes};
    /// use vanecut::mesh::{MeshOptions, tessellate::{Fineness, Tessellation}};
    /// # let part = vanecut::io::part_file::read_part("assets/parts/pump6.toml".as_ref())?;
    /// # let part = vanecut::part::Impeller::build(&part)?;
    /// let shape = Tessellation::new(&part, &Fineness::default());
    /// let bytes = GltfScene::of_part(&part, &shape).glb();
    /// assert_eq!(read_bytes("pump6.glb", &bytes, &MeshOptions::default())?.blade_count, 6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_part(part: &Impeller, shape: &Tessellation) -> Self {
        let mut builder = GltfBuilder::default();
        let nodes = part_nodes(&mut builder, part, shape, WallColours::Alike);
        let root = root(&mut builder, part, shape, &nodes, json!({}));
        Self { builder, root }
    }

    /// The bytes of a `.glb`.
    pub fn glb(&self) -> Vec<u8> {
        self.builder.glb(self.root)
    }

    /// The text of a `.gltf`, and the bytes of its buffer file, which is named `binary`.
    pub fn gltf(&self, binary: &str) -> (String, Vec<u8>) {
        self.builder.gltf(self.root, binary)
    }
}
