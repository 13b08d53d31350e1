//! The meshes of a part that the views draw, made when it is opened.

use std::sync::Arc;

use crate::drawing::part::{draft_part_mesh, part_mesh};
use crate::gpu::part_mesh::PartMesh;
use crate::part::Impeller;

/// Meshes of a part: fine for still pictures, coarse while the camera moves.
#[derive(Clone, Debug)]
pub struct PartMeshes {
    pub(in crate::app) fine: Arc<PartMesh>,
    pub(in crate::app) draft: Arc<PartMesh>,
}

impl PartMeshes {
    /// Tessellates a part.
    pub fn new(part: &Impeller) -> Self {
        Self { fine: Arc::new(part_mesh(part)), draft: Arc::new(draft_part_mesh(part)) }
    }
}
