//! STEP files (ISO 10303-21): solids and shells of AP203, AP214 and AP242 as triangles, and parts from them.
//!
//! | file | contents |
//! |---|---|
//! | `exchange` | the exchange structure: instances by number |
//! | `model` | typed access to instances, units |
//! | `nurbs`, `curve`, `surface` | geometry: evaluation and inversion |
//! | `shape` | geometry from instances |
//! | `assembly` | bodies with their placements, names and colours |
//! | `edges`, `chart`, `face`, `body` | tessellation: shared edges, parameter charts, constrained Delaunay |
//! | `sheets` | sheets that meet, as one body |
//! | `read` | bodies as named meshes, and as a part |
//! | `advice` | help where no part can be made from the bodies |
//! | `write` | parts as solids |

mod advice;
mod assembly;
mod body;
mod chart;
mod curve;
mod edges;
mod exchange;
mod face;
mod model;
mod nurbs;
mod read;
mod shape;
mod sheets;
mod surface;
#[cfg(test)]
mod tests;
mod write;

pub use body::{MeshedBody, SurfaceKind};
pub use read::{StepScene, read, read_bytes, read_meshes, read_scene, read_scene_bytes};
pub use write::write_part;
