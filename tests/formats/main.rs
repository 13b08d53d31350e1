//! Files: what is read from them, what is written, and what becomes of faulty ones.

mod any_bytes;
mod gltf;
mod gltf_faults;
mod mesh_parts;
mod parts;
mod round_trips;
mod tessellation;
