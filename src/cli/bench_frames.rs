//! Benchmark of the 3D view: frame rate while it is still and while it is dragged.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::UVec2;

use super::Failure;
use super::bench_measure::{median, print_row};
use crate::drawing::part::draft_part_mesh;
use crate::drawing::solid::solid_mesh;
use crate::drawing::{scene_of_part, show_plan};
use crate::gpu::mesh::Paint;
use crate::gpu::{
    Camera, CutterFilter, Gpu, Renderer, ResidualKernel, SceneOptions, StockFloor, StockState, View,
    draft_size,
};
use crate::job::PlanOutcome;
use crate::monitor::Monitor;
use crate::stock::solid::{COARSE_RAYS, FINE_RAYS, SolidBlank, SolidProgram, SolidStock, StockSurface};
use crate::stock::{FieldProgram, FloorLevels, field_cutters};
use crate::toolpath::ClProgram;

/// Pictures per measurement.
const PICTURES: u32 = 12;

/// Rotates the wheel with its whole plan in a view of 1280 × 800 pixels and prints the medians.
///
/// # Errors
/// [`Failure::work`] when standard output cannot be written.
pub fn run(gpu: &Gpu, outcome: &PlanOutcome) -> Result<(), Failure> {
    let size = UVec2::new(1280, 800);
    let mut scene = scene_of_part(gpu, &outcome.workpiece.part)
        .with_draft(gpu, &draft_part_mesh(&outcome.workpiece.part));
    let plan = &outcome.after.plan;
    show_plan(&mut scene, gpu, plan, &outcome.grid, &outcome.after.field.heights);
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
    preview(gpu, outcome)?;
    solid(gpu, outcome)
}

/// Draws the stock as a solid after the whole plan while it is dragged, on rays as in the window; prints the
/// medians.
fn solid(gpu: &Gpu, outcome: &PlanOutcome) -> Result<(), Failure> {
    let size = draft_size(gpu, UVec2::new(1280, 800));
    let part = &outcome.workpiece.part;
    let mut scene = scene_of_part(gpu, part);
    let mut renderer = Renderer::new(gpu);
    let program = ClProgram::of_plan(&part.name, &outcome.after.plan);
    let program =
        SolidProgram::new(&program, &outcome.setup).map_err(|fault| Failure::of_work(fault.error))?;
    let blank = SolidBlank::from_part(part, &outcome.workpiece.blank);
    let mut camera = Camera::standard(View::Iso, scene.framing(), size.x as f32 / size.y as f32);
    let options = SceneOptions { draft: true, show_solid: true, ..SceneOptions::default() };
    for rays in [COARSE_RAYS, FINE_RAYS] {
        let spacing = blank.default_spacing() * 800.0 / rays;
        let mut stock = SolidStock::new(&blank, spacing).map_err(Failure::of_work)?;
        stock.make_moves(&program.tools, &program.moves, &Monitor::default()).map_err(Failure::of_work)?;
        let surface = StockSurface::from_stock(&stock);
        let mesh = solid_mesh(&surface, spacing, None, |_| Paint::UNCUT, &Monitor::default())
            .map_err(Failure::of_work)?;
        let triangles = mesh.triangles();
        scene.set_solid(gpu, Some(Arc::new(mesh)));
        let seconds = median(|| {
            for _ in 0..PICTURES {
                camera.yaw_rad += TAU / 180.0;
                renderer.render(gpu, &scene, &camera, &options, size, 1);
                let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
            }
        }) / f64::from(PICTURES);
        print_row(
            &format!("solid stock dragged, {triangles} triangles: {:.0} per second", 1.0 / seconds),
            seconds,
        )?;
    }
    Ok(())
}

/// Computes the stock on the floor after different numbers of plunges with the kernel and draws it from its
/// buffer, as the window does while the timeline plays; prints the medians at every resolution.
fn preview(gpu: &Gpu, outcome: &PlanOutcome) -> Result<(), Failure> {
    let size = draft_size(gpu, UVec2::new(1280, 800));
    let mut scene = scene_of_part(gpu, &outcome.workpiece.part)
        .with_draft(gpu, &draft_part_mesh(&outcome.workpiece.part));
    let mut renderer = Renderer::new(gpu);
    let mut floor = StockFloor::new(Arc::new(ResidualKernel::new(gpu)?));
    let levels = Arc::new(FloorLevels::new(&outcome.grid));
    let program = Arc::new(FieldProgram::new(&levels, field_cutters(&outcome.after.plan)));
    let camera = Camera::standard(View::Channel, scene.framing(), size.x as f32 / size.y as f32);
    let options = SceneOptions {
        draft: true,
        show_cutters: CutterFilter::Hidden,
        range_mm: (0.0, 4.0),
        ..SceneOptions::default()
    };
    for (level, shape) in levels.levels().iter().enumerate() {
        for draws in [false, true] {
            let mut failed = None;
            let seconds = median(|| {
                for k in 0..PICTURES as usize {
                    let count = program.cutters.len().saturating_sub(k);
                    let state = StockState { program: Arc::clone(&program), count };
                    match floor.show(gpu, level, &state, None) {
                        Ok(stock) => scene.set_stock(stock),
                        Err(error) => failed = Some(error),
                    }
                    if draws {
                        renderer.render(gpu, &scene, &camera, &options, size, 1);
                    }
                    let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
                }
            }) / f64::from(PICTURES);
            if let Some(error) = failed {
                return Err(error.into());
            }
            let what = if draws { "computed and drawn" } else { "computed" };
            let (rows, columns) = (shape.grid.rows, shape.grid.columns);
            let meetings = program.meetings(level) as f64 / 1e6;
            print_row(&format!("  stock {rows} × {columns} {what}, {meetings:.1} M meetings"), seconds)?;
        }
    }
    Ok(())
}
