//! `vanecut bench`: throughput of the kernels on this machine, as a table.

use std::time::Instant;

use rayon::prelude::*;

use super::{Failure, say};
use crate::formats::part_file::read_part_bytes;
use crate::gpu::{Gpu, ResidualKernel};
use crate::job::{PlanRequest, run as run_job};
use crate::monitor::Monitor;
use crate::part::{AxisPolicy, Blank, Channel, Impeller, Setup};
use crate::plunge::slotting::DepthSurface;
use crate::residual::{FloorGrid, cutters_of, residual_field};

/// Runs of each measurement; the median counts.
const RUNS: usize = 5;

/// Measures on the largest sample part and prints the medians.
pub fn run() -> Result<(), Failure> {
    let text = include_bytes!("../../assets/parts/impeller532.toml");
    let description = read_part_bytes("impeller532.toml", text, "toml")?;
    let part = std::sync::Arc::new(
        Impeller::build(&description).map_err(|e| Failure::Work(format!("the sample part: {e}")))?,
    );
    let channel = Channel::of(&part);
    let setup = Setup::default();
    let request = PlanRequest {
        part: part.clone(),
        setup,
        policy: AxisPolicy::Monotone,
        compare: false,
        field_cells: 512,
    };
    say(&format!("{:<58} {:>10}\n", "what", "median"))?;
    let plan_seconds = median(|| {
        let _ = run_job(&request, &Monitor::default());
    });
    line("plan of one channel: two policies, contact, both fields 512²", plan_seconds)?;
    let outcome = run_job(&request, &Monitor::default()).map_err(|e| Failure::Work(e.to_string()))?;

    let plan = &outcome.after.plan;
    let hub = DepthSurface::new(part.hub.curve(), 0.5);
    line(
        "10,000 slotting depths",
        median(|| {
            (0..10_000usize).into_par_iter().for_each(|k| {
                let p = &plan.positions[k % plan.positions.len()];
                let radius = plan.sections[p.section].tool.radius();
                std::hint::black_box(hub.touch(&p.tip, &p.axis, radius));
            });
        }),
    )?;
    let blank = Blank::of(&part, 0.0);
    let grid = FloorGrid::new(&part, &channel, &blank, 0.5, 1024);
    let cutters: Vec<_> = cutters_of(plan).into_iter().cycle().take(1000).collect();
    line(
        "residual field 1024² × 1000 positions, CPU",
        median(|| {
            std::hint::black_box(residual_field(&grid, &cutters));
        }),
    )?;
    match Gpu::headless() {
        Err(error) => say(&format!("GPU: {error}\n"))?,
        Ok(gpu) => {
            let kernel = ResidualKernel::new(&gpu)?;
            let mut failed = None;
            let seconds = median(|| {
                if let Err(error) = kernel.run(&gpu, &grid, &cutters) {
                    failed = Some(error);
                }
            });
            if let Some(error) = failed {
                return Err(error.into());
            }
            line(&format!("residual field 1024² × 1000 positions, {}", gpu.info.name), seconds)?;
        }
    }
    Ok(())
}

fn median(mut work: impl FnMut()) -> f64 {
    work();
    let mut seconds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[RUNS / 2]
}

fn line(what: &str, seconds: f64) -> Result<(), Failure> {
    say(&format!("{what:<58} {:>7.1} ms\n", 1e3 * seconds))
}
