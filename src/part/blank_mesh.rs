//! The mesh of a blank from a file.

use crate::geometry::Point;

/// A closed triangle mesh, mm, part frame.
#[derive(Clone, Debug, PartialEq)]
pub struct BlankMesh {
    /// Corners.
    pub points: Vec<Point>,
    /// Triangles by the indices of their corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}
