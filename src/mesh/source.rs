//! What a file says of its meshes.

use super::normals::ExactNormals;
use super::options::LengthUnit;
use crate::geometry::{Point, Vector};

/// What a file says of its meshes.
#[derive(Clone, Debug)]
pub struct MeshSource {
    /// Unit of its coordinates.
    pub unit: LengthUnit,
    /// Axis of the surfaces of revolution, exact: a point, in the file's unit, and the direction.
    pub axis: Option<(Point, Vector)>,
    /// What the user should know of it.
    pub notes: Vec<String>,
    /// Normals of its surfaces at corners of its meshes.
    pub normals: ExactNormals,
    /// Whether its bodies are solids without gaps.
    pub whole: bool,
}

impl MeshSource {
    /// Meshes of which only the unit is known.
    pub fn from_unit(unit: LengthUnit) -> Self {
        Self { unit, axis: None, notes: Vec::new(), normals: ExactNormals::default(), whole: false }
    }

    /// Whether they are tessellated from a CAD model, which knows its surfaces.
    pub fn is_cad(&self) -> bool {
        !self.normals.is_empty() || self.axis.is_some()
    }
}
