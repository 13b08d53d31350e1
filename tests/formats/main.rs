//! Files: reading, writing, and errors of invalid files.

mod any_bytes;
mod gltf;
mod gltf_faults;
mod mesh_parts;
mod parts;
mod round_trips;
mod tessellation;
