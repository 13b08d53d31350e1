//! glTF 2.0 meshes, binary (`.glb`) and text (`.gltf`).

mod accessor;
mod container;
mod document;
mod read;
mod scene;
pub mod write;

pub use read::{read, read_bytes, read_meshes, read_meshes_bytes};
pub use write::{CutterNodes, GltfScene, PlanScene};
