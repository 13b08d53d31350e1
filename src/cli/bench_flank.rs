//! Benchmarks of the flank planner.

use std::sync::Arc;

use super::Failure;
use super::bench_measure::{build_sample, median, print_row, slope};
use super::stdout::print_stdout;
use crate::flank::LayoutInputs;
use crate::flank::choice::choose_tool;
use crate::io::tool_library::flank_cutters;
use crate::job::flank::{FlankJob, FlankRequest};
use crate::monitor::Monitor;
use crate::setup::Setup;

/// Layer depths for the growth measurement, mm: the smaller the depth, the more points the passes have.
const DEPTHS: [f64; 4] = [6.0, 3.0, 1.5, 0.75];

/// Measures on the sample wheel with splitters and prints the medians.
///
/// # Errors
/// [`Failure::work`] when planning fails.
pub fn run() -> Result<(), Failure> {
    let part = build_sample("impeller9x9.toml", include_bytes!("../../assets/parts/impeller9x9.toml"))?;
    let mut setup = Setup::default();
    let workpiece = setup.allowances.workpiece_of(part);
    let tool = choose_tool(&workpiece, &setup, flank_cutters()).map_err(Failure::of_work)?.tool;
    let monitor = Monitor::default();
    let schemes = |setup: &Setup| {
        let source = LayoutInputs { workpiece: &workpiece, setup, tool: &tool };
        source.plan(&monitor).map_err(Failure::of_work)
    };
    print_row(
        "flank passes of one channel with splitters: all 4 strategies",
        median(|| {
            let _ = schemes(&setup);
        }),
    )?;
    let mut points: Vec<(f64, f64)> = Vec::new();
    for depth in DEPTHS {
        setup.flank.layer_depth = depth;
        let count: usize =
            schemes(&setup)?.layers.iter().flat_map(|l| &l.pass_curves).map(|c| c.points.len()).sum();
        let seconds = median(|| {
            let _ = schemes(&setup);
        });
        print_row(&format!("  the same, {count} pass points"), seconds)?;
        points.push(((count as f64).ln(), seconds.ln()));
    }
    print_stdout(&format!(
        "{:<62} {:>10.2}\n",
        "  time grows with pass points to the power of",
        slope(&points)
    ))?;
    let request = FlankRequest { part: Arc::clone(&workpiece.part), setup: Setup::default() };
    print_row(
        "flank plan of one channel with splitters, with program",
        median(|| {
            let _ = FlankJob::default().run(&request, &monitor);
        }),
    )
}
