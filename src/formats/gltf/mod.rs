//! glTF 2.0 meshes (`.glb`, `.gltf`).

mod accessor;
mod container;
mod document;
mod read;
mod scene;

pub use read::{read, read_bytes, read_meshes, read_meshes_bytes};
