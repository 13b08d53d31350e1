//! Benchmark of the 3D view: frame rate while it is still and while it is dragged.

use std::f32::consts::TAU;

use glam::UVec2;

use super::Failure;
use super::bench::{median, print_row};
use crate::gpu::part_mesh::PartMesh;
use crate::gpu::{Camera, Gpu, Renderer, Scene, SceneOptions, View, draft_size};
use crate::job::PlanOutcome;

/// Pictures per measurement.
const PICTURES: u32 = 12;

/// Rotates the wheel with its whole plan in a view of 1280 × 800 pixels and prints the medians.
///
/// # Errors
/// [`Failure::Work`] when standard output cannot be written.
pub fn run(gpu: &Gpu, outcome: &PlanOutcome) -> Result<(), Failure> {
    let size = UVec2::new(1280, 800);
    let mut scene = Scene::new(gpu, &outcome.part).with_draft(gpu, &PartMesh::draft(&outcome.part));
    let plan = &outcome.after.plan;
    scene.set_plan(Some(plan));
    scene.set_floor(gpu, Some((&outcome.grid, &outcome.after.field.heights)), Some(plan));
    let mut renderer = Renderer::new(gpu);
    for (what, draft) in [("still", false), ("dragged", true)] {
        for view in [View::Iso, View::Channel] {
            let mut camera = Camera::standard(view, scene.framing(), size.x as f32 / size.y as f32);
            let size = if draft { draft_size(gpu, size) } else { size };
            let options = SceneOptions { draft, range_mm: (0.0, 4.0), ..SceneOptions::default() };
            let seconds = median(|| {
                for _ in 0..PICTURES {
                    camera.yaw_rad += TAU / 180.0;
                    renderer.render(gpu, &scene, &camera, &options, size, if draft { 1 } else { 4 });
                    // Wait for each picture, as on the screen.
                    let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
                }
            }) / f64::from(PICTURES);
            let of = if view == View::Iso { "wheel" } else { "channel" };
            let positions = plan.positions.len();
            let rate = 1.0 / seconds;
            print_row(
                &format!("view {what}, {of}, {positions} cutters, 1280 × 800: {rate:.0} per second"),
                seconds,
            )?;
        }
    }
    Ok(())
}
