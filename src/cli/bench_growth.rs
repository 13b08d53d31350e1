//! Growth of planning time with the number of positions. Wheels of growing hub area with channels of constant
//! depth are planned with the same cutters and steps, so that the number of positions grows with the area
//! while the number of neighbours of each position stays constant.

use std::time::Instant;

use super::Failure;
use super::bench_measure::{build, slope};
use super::bench_wheel::scaled_wheel;
use super::stdout::print_stdout;
use crate::error::{ErrorCode, UserError};
use crate::io::apt::{read_apt_bytes, write_apt};
use crate::io::plan_file::write_plan;
use crate::job::{FIELD_CELLS, Summary};
use crate::monitor::Monitor;
use crate::part::{Impeller, PartDescription};
use crate::plunge::MAX_POSITIONS;
use crate::plunge::Planner;
use crate::setup::{AxisPolicy, Setup};
use crate::stock::{FloorGrid, FloorSource, field_cutters, residual_field, stretches_of};
use crate::toolpath::ClProgram;
use crate::verify::verify;

/// Minimum number of positions for a meaningful comparison with the original wheel.
const MIN_POSITIONS: usize = 2000;
/// Largest ratio of position counts between consecutive wheels.
const MAX_POSITION_RATIO: f64 = 4.0;

/// Checks that growth can be measured up to `positions`.
///
/// # Errors
/// [`Failure::input`] when `positions` is out of range.
pub fn check_positions(positions: usize) -> Result<(), Failure> {
    if (MIN_POSITIONS..=MAX_POSITIONS).contains(&positions) {
        return Ok(());
    }
    let what = format!("--positions {positions} is out of range");
    Err(Failure::input(ErrorCode::Arguments, what, format!("give {MIN_POSITIONS} to {MAX_POSITIONS}")))
}

/// Measured steps of a plan.
const MEASURED_STEPS: [&str; 4] = ["planned", "evaluated", "written", "verified"];

/// Plans wheels like `part` of growing hub area with the sections of `setup`, until a plan has about
/// `max_positions`. Prints the times, and the exponents with which they grow with the number of positions.
///
/// # Errors
/// [`Failure::work`] when planning or verification fails.
pub fn run(part: &Impeller, setup: &Setup, max_positions: usize) -> Result<(), Failure> {
    print_stdout("minimal plan of one channel of wheels of growing hub area, seconds:\n")?;
    let mut all = vec![measure(&scaled_wheel(part, 1.0), setup)?];
    let steps =
        ((max_positions as f64 / all[0].0 as f64).ln() / MAX_POSITION_RATIO.ln()).ceil().max(2.0) as u32;
    // The number of positions grows about with the square of the size; the exponent is re-estimated from the
    // last two.
    let (mut size, mut power) = (1.0, 2.0);
    for left in (1..=steps).rev() {
        let before = all[all.len() - 1].0 as f64;
        let wider = (max_positions as f64 / before).powf(1.0 / power / f64::from(left));
        size *= wider;
        let next = measure(&scaled_wheel(part, size), setup)?;
        power = ((next.0 as f64 / before).ln() / wider.ln()).clamp(1.0, 3.0);
        all.push(next);
    }
    print_stdout("  time grows with positions to the power of")?;
    for (i, what) in MEASURED_STEPS.iter().enumerate() {
        let points: Vec<(f64, f64)> =
            all.iter().map(|(positions, seconds)| ((*positions as f64).ln(), seconds[i].ln())).collect();
        let last = slope(&points[points.len() - 2..]);
        let before = if i == 0 { ":" } else { "," };
        print_stdout(&format!("{before} {what} {:.2} (between the last two {last:.2})", slope(&points)))?;
    }
    print_stdout("\n")
}

/// Number of positions of a plan, and the time of each step of [`MEASURED_STEPS`], s.
fn measure(wheel: &PartDescription, setup: &Setup) -> Result<(usize, [f64; 4]), Failure> {
    let failed = |error: UserError| Failure::of_work(error).at("the growing wheel");
    let part = build(wheel)?;
    let workpiece = setup.allowances.workpiece_of(part);
    let mut seconds = [0.0; 4];
    let mut clock = Instant::now();
    let mut lap = |i: usize| {
        seconds[i] = clock.elapsed().as_secs_f64();
        clock = Instant::now();
    };
    let planner = Planner::new(&workpiece, setup);
    let plan =
        planner.plan(AxisPolicy::Minimal, &Monitor::default()).map_err(|error| failed(error.into()))?;
    lap(0);
    let cutters = stretches_of(&plan.sections);
    let source = FloorSource::of_setup(&workpiece, setup, &cutters);
    let grid = FloorGrid::new(&source, FIELD_CELLS);
    let summary = Summary::from_plan(&plan, &grid, &residual_field(&grid, &field_cutters(&plan)));
    lap(1);
    let json = write_plan(wheel, setup, &plan, 1);
    let apt = write_apt(&ClProgram::of_plan(&workpiece.part.name, &plan));
    std::hint::black_box(json.len());
    drop(json);
    lap(2);
    let program = read_apt_bytes("plunge.apt", apt.as_bytes())?;
    let verdict =
        verify(&workpiece, setup, &program, &Monitor::default()).map_err(|error| failed(error.into()))?;
    lap(3);
    let [planned, judged, written, verified] = seconds;
    print_stdout(&format!(
        "  D {:<6.0} {:>7} positions   planned {planned:>7.2}   evaluated {judged:>6.2}   \
         written {written:>5.2}   verified {verified:>6.2}   {:>4} of 1000 uncut, {} faults{}\n",
        2.0 * workpiece.part.rim_radius(),
        summary.positions,
        (1000.0 * summary.uncut_share).round(),
        verdict.faults.len(),
        memory().map(|mb| format!("   peak {mb} MB")).unwrap_or_default(),
    ))?;
    Ok((summary.positions, seconds))
}

/// Peak memory of the process, MB, if the system reports it.
#[expect(clippy::disallowed_methods, reason = "a file of the system, of a few lines")]
fn memory() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()? / 1024)
}
