//! glTF 2.0, binary (`.glb`) and as text (`.gltf`).

pub mod write;

pub use write::{CutterNodes, GltfScene, PlanScene};
