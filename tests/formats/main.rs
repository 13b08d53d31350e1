//! Files: reading, writing, and errors of invalid files.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod any_bytes;
mod bosses;
mod cad;
mod cad_as_mesh;
mod gltf;
mod gltf_faults;
mod mesh_parts;
mod order;
mod parts;
mod round_trips;
mod sheets;
mod tessellation;
mod versions;
