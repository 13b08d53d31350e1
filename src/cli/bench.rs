//! `vanecut bench`: throughput of the kernels on this machine, as a table.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;

use super::args::BenchArgs;
use super::bench_measure::{build, describe, median, print_row};
use super::stdout::print_stdout;
use super::{Failure, bench_flank, bench_growth, bench_stock};
use crate::cutting::drop_cutter::DepthSurface;
#[cfg(feature = "gpu")]
use crate::gpu::{Gpu, ResidualKernel};
use crate::io::gltf::GltfScene;
use crate::io::part_file::read_part_bytes;
use crate::job::{FIELD_CELLS, Listener, PlanJob, PlanOutcome, PlanRequest, PlanStage, run as run_job};
use crate::mesh::tessellate::{Fineness, Tessellation};
use crate::monitor::Monitor;
use crate::part::Impeller;
use crate::plunge::Planner;
use crate::setup::{AxisPolicy, SectionKind, Setup, Tool};
#[cfg(feature = "gpu")]
use crate::stock::FieldCutter;
use crate::stock::{FloorGrid, FloorSource, field_cutters, residual_field, stretches_of};

/// Sharp cutters of 30, 16 and 8 mm, as in the wheel's published plan. Fixed tools make the measurement
/// independent of the tool library.
fn three_tools() -> Vec<Tool> {
    [30.0, 16.0, 8.0]
        .into_iter()
        .zip(1..)
        .map(|(diameter, number)| Tool {
            number,
            diameter,
            corner_radius: 0.0,
            insert_width: 0.325 * diameter,
            overhang: 120.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: Default::default(),
        })
        .collect()
}

/// Plans the measured part by the policy `minimal`.
fn plan_minimal(outcome: &PlanOutcome) {
    let planner = Planner::new(&outcome.workpiece, &outcome.setup);
    let plan = planner.plan(AxisPolicy::Minimal, &Monitor::default());
    std::hint::black_box(plan.is_ok());
}

/// Measures how long the window waits for a minimal plan and its fields after one slider moved, which depends
/// on what becomes stale, and for the preview shown meanwhile.
fn bench_sliders(outcome: &PlanOutcome) -> Result<(), Failure> {
    let job = PlanJob::default();
    let mut request = PlanRequest {
        part: outcome.workpiece.part.clone(),
        setup: outcome.setup.clone(),
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: FIELD_CELLS,
    };
    let mut moved = |what: &str, slider: &dyn Fn(&mut Setup, f64)| {
        let mut turn = 0.0;
        let firsts = Mutex::new(Vec::new());
        let seconds = median(|| {
            turn += 1.0;
            slider(&mut request.setup, turn);
            let started = Instant::now();
            let listen = |stage: PlanStage| {
                if let PlanStage::Preview(_) = stage {
                    firsts
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .push(started.elapsed().as_secs_f64());
                }
            };
            let _ = job.run_with_listener(&request, &Monitor::default(), Listener::new(&listen));
        });
        print_row(&format!("  replanned, {what} changed"), seconds)?;
        let mut firsts = firsts.into_inner().unwrap_or_else(PoisonError::into_inner);
        firsts.sort_by(f64::total_cmp);
        match firsts.get(firsts.len() / 2) {
            Some(&first) => print_row("    preview from the last axes (warm start)", first),
            None => Ok(()),
        }
    };
    moved("safety distance", &|setup, turn| setup.allowances.safety_distance = 2.0 + 0.1 * turn)?;
    moved("inlet end of the last section", &|setup, turn| {
        if let Some(section) =
            setup.plunge.sections.iter_mut().rfind(|section| section.kind == SectionKind::Rows)
        {
            section.to = section.to.max(1e-3) + 1e-3 * turn;
        }
    })?;
    moved("hub allowance", &|setup, turn| setup.allowances.hub_allowance = 0.5 + 0.01 * turn)
}

/// Measures on the largest sample part and prints the medians.
///
/// # Errors
/// [`Failure::input`] when `--positions` is out of range, [`Failure::work`] when planning or the device
/// fails.
pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    bench_growth::check_positions(args.positions)?;
    if args.stock {
        print_stdout(&format!("{:<62} {:>10}\n", "what", "median"))?;
        return bench_stock::run();
    }
    let wheel = describe("impeller532.toml", include_bytes!("../../assets/parts/impeller532.toml"))?;
    let part = build(&wheel)?;
    let request = PlanRequest {
        part: part.clone(),
        setup: Setup { tools: three_tools(), ..Setup::default() },
        policy: AxisPolicy::Monotone,
        compare: false,
        field_cells: FIELD_CELLS,
    };
    print_stdout(&format!("{:<62} {:>10}\n", "what", "median"))?;
    let plan_seconds = median(|| {
        let _ = run_job(&request, &Monitor::default());
    });
    let what = format!("plan of one channel: two policies, contact, both fields {FIELD_CELLS}²");
    print_row(&what, plan_seconds)?;
    let outcome = run_job(&request, &Monitor::default()).map_err(Failure::of_work)?;

    print_row("minimal plan of one channel", median(|| plan_minimal(&outcome)))?;
    bench_sliders(&outcome)?;
    bench_growth::run(&part, &outcome.setup, args.positions)?;

    bench_flank::run()?;
    bench_stock::run()?;
    bench_mesh_import(&part)?;

    let plan = &outcome.after.plan;
    let hub = DepthSurface::new(part.hub.curve(), 0.5);
    print_row(
        "10,000 drop-cutter depths",
        median(|| {
            (0..10_000usize).into_par_iter().for_each(|k| {
                let p = &plan.positions[k % plan.positions.len()];
                let radius = plan.sections[p.section].tool.radius();
                std::hint::black_box(hub.touch(&p.tip, &p.axis, radius));
            });
        }),
    )?;
    let stretches = stretches_of(&plan.sections);
    let source = FloorSource::of_setup(&outcome.workpiece, &outcome.setup, &stretches);
    let grid = FloorGrid::new(&source, 1024);
    let cutters: Vec<_> = field_cutters(plan).into_iter().cycle().take(1000).collect();
    print_row(
        "residual field 1024² × 1000 positions, CPU",
        median(|| {
            std::hint::black_box(residual_field(&grid, &cutters));
        }),
    )?;
    #[cfg(feature = "gpu")]
    bench_gpu(&grid, &cutters, &outcome)?;
    Ok(())
}

/// Measures the heightfield kernel and the 3D view on the graphics device, if there is one.
#[cfg(feature = "gpu")]
fn bench_gpu(grid: &FloorGrid, cutters: &[FieldCutter], outcome: &PlanOutcome) -> Result<(), Failure> {
    match Gpu::headless() {
        Err(error) => print_stdout(&format!("GPU: {error}\n"))?,
        Ok(gpu) => {
            let kernel = ResidualKernel::new(&gpu)?;
            let mut failed = None;
            let seconds = median(|| {
                if let Err(error) = kernel.run(&gpu, grid, cutters) {
                    failed = Some(error);
                }
            });
            if let Some(error) = failed {
                return Err(error.into());
            }
            print_row(&format!("residual field 1024² × 1000 positions, {}", gpu.info.name), seconds)?;
            super::bench_frames::run(&gpu, outcome)?;
        }
    }
    Ok(())
}

/// Measures opening a mesh of about a million triangles as a part.
fn bench_mesh_import(part: &Impeller) -> Result<(), Failure> {
    let shape = Tessellation::new(part, &Fineness { chord_error: 0.007, ..Fineness::default() });
    let triangles = shape.triangle_count() + (part.blade_count - 1) * shape.main.triangle_count();
    let bytes = GltfScene::of_part(part, &shape).glb();
    print_row(
        &format!("a mesh of {triangles} triangles opened"),
        median(|| {
            let read = read_part_bytes("wheel.glb", &bytes, "glb");
            std::hint::black_box(read.is_ok());
        }),
    )
}
