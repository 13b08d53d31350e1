//! Parts, plans and stock as the meshes, lines and instances that [`crate::gpu`] draws.
//!
//! | module | of what |
//! |---|---|
//! | [`part`] | an impeller |
//! | [`walls`] | walls of blades with values |
//! | [`floor`] | the floor of a channel with its stock or with contact depths |
//! | [`cutters`] | the plunges of a plan |
//! | [`flank`] | passes, moves and walls of a flank plan |
//! | [`machine`] | a machine as simple solids |
//! | [`solid`] | the stock as a solid |

pub mod cutters;
pub mod flank;
pub mod floor;
pub mod machine;
pub mod part;
pub mod solid;
pub mod walls;

use std::sync::Arc;

use crate::gpu::{Gpu, Scene};
use crate::part::Impeller;
use crate::plunge::PlungePlan;
use crate::stock::FloorGrid;

/// A scene of `part`, without a plan.
pub fn scene_of_part(gpu: &Gpu, part: &Impeller) -> Scene {
    Scene::new(gpu, Arc::new(part::part_mesh(part)))
}

/// Shows a plan in a scene of its part: its cutters, the stock on the floor, `heights` (mm) per cell of
/// `grid`, and the contact of its cores.
pub fn show_plan(scene: &mut Scene, gpu: &Gpu, plan: &PlungePlan, grid: &FloorGrid, heights: &[f32]) {
    scene.set_cutters(cutters::cutter_set(plan));
    scene.set_floor(gpu, floor::floor_meshes(grid, heights));
    scene.set_contact(gpu, Some(&floor::contact_mesh(grid, plan)));
}
