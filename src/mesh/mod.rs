//! Triangle meshes of impellers: tessellation of a part, and reconstruction of a part from meshes.

pub mod axis;
mod bodies;
pub mod describe;
mod edges;
mod fillets;
mod fit;
mod holes;
mod meridional_area;
mod meridional_points;
mod nearest;
pub mod nodes;
mod normals;
pub mod options;
mod profile;
pub mod roles;
mod round;
mod rows;
mod rulings;
mod sections;
mod segment;
mod sides;
pub mod solid;
mod span_sections;
mod surface;
pub mod tessellate;
mod tip_border;
mod tip_faces;
mod tips;
mod triangles;
mod trim;
pub(crate) mod weld;

pub use describe::describe;
pub use normals::ExactNormals;
pub use options::{LengthUnit, MeshOptions};
pub use roles::{NamedMesh, Role};
pub use triangles::{TriangleMesh, grid_triangles};
