//! Triangle meshes of impellers: from a part to triangles, and from triangles to a part.

pub mod solid;
pub mod tessellate;

use crate::geometry::Point;

/// Triangles over shared points, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// The corners.
    pub points: Vec<Point>,
    /// Three indices into `points` each, counter-clockwise seen from outside the material.
    pub triangles: Vec<[u32; 3]>,
}
