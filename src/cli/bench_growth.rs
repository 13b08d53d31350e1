//! How the work grows with the positions of a plan: a wheel with more and more hub under channels that stay as deep, planned
//! with the same cutters and steps, so that positions grow with its area while those around each of them stay as many.

use std::time::Instant;

use super::bench::build;
use super::bench_flank::slope;
use super::bench_wheel::spread;
use super::{Failure, say};
use crate::formats::apt::{ClProgram, read_apt_bytes, write_apt};
use crate::formats::plan_file::write_plan;
use crate::job::Summary;
use crate::monitor::Monitor;
use crate::part::{AxisPolicy, Channel, Impeller, PartDescription, Setup};
use crate::plunge::Planner;
use crate::plunge::sections::MAX_POSITIONS;
use crate::residual::{FloorGrid, FloorSource, cutters_of, residual_field, stretches_of};
use crate::verify::verify;

/// Least number of positions that says something beside the wheel as it is.
const LEAST: usize = 2000;
/// Positions grow by no more than this from wheel to wheel.
const RATIO: f64 = 4.0;
/// Cells of the residual field along s and λ.
const FIELD_CELLS: usize = 512;

/// Whether growth can be measured up to so many positions.
pub fn check(positions: usize) -> Result<(), Failure> {
    if (LEAST..=MAX_POSITIONS).contains(&positions) {
        return Ok(());
    }
    Err(Failure::Input(format!("--positions {positions} is out of range; give {LEAST} to {MAX_POSITIONS}")))
}

/// What is measured of a plan.
const WHAT: [&str; 4] = ["planned", "judged", "written", "verified"];

/// Plans wheels like `part` with more and more hub by the sections of `setup`, until a plan has about `most` positions.
/// Prints the times of each, and the power of the positions that they grow with.
pub fn run(part: &Impeller, setup: &Setup, most: usize) -> Result<(), Failure> {
    say("minimal plan of one channel of wheels with more and more hub, seconds:\n")?;
    let mut all = vec![measure(&spread(part, 1.0), setup)?];
    let steps = ((most as f64 / all[0].0 as f64).ln() / RATIO.ln()).ceil().max(2.0) as u32;
    // A larger wheel has more positions by about its area; by how much more the last two tell.
    let (mut size, mut power) = (1.0, 2.0);
    for left in (1..=steps).rev() {
        let before = all[all.len() - 1].0 as f64;
        let wider = (most as f64 / before).powf(1.0 / power / f64::from(left));
        size *= wider;
        let next = measure(&spread(part, size), setup)?;
        power = ((next.0 as f64 / before).ln() / wider.ln()).clamp(1.0, 3.0);
        all.push(next);
    }
    say("  time grows with positions to the power of")?;
    for (i, what) in WHAT.iter().enumerate() {
        let points: Vec<(f64, f64)> =
            all.iter().map(|(positions, seconds)| ((*positions as f64).ln(), seconds[i].ln())).collect();
        let last = slope(&points[points.len() - 2..]);
        let before = if i == 0 { ":" } else { "," };
        say(&format!("{before} {what} {:.2} (between the last two {last:.2})", slope(&points)))?;
    }
    say("\n")
}

/// Positions of a plan, and how long each of [`WHAT`] took, s.
fn measure(wheel: &PartDescription, setup: &Setup) -> Result<(usize, [f64; 4]), Failure> {
    let failed = |what: &dyn std::fmt::Display| Failure::Work(format!("the growing wheel: {what}"));
    let part = build(wheel)?;
    let channel = Channel::of(&part);
    let mut seconds = [0.0; 4];
    let mut clock = Instant::now();
    let mut lap = |i: usize| {
        seconds[i] = clock.elapsed().as_secs_f64();
        clock = Instant::now();
    };
    let planner = Planner::new(&part, &channel, setup);
    let plan = planner.plan(AxisPolicy::Minimal, &Monitor::default()).map_err(|error| failed(&error))?;
    lap(0);
    let (blank, stock) = (planner.blank(), &setup.stock);
    let cutters = stretches_of(&plan);
    let source = FloorSource { part: &part, channel: &channel, blank, stock, cutters: &cutters };
    let grid = FloorGrid::new(&source, FIELD_CELLS);
    let summary = Summary::of(&plan, &grid, &residual_field(&grid, &cutters_of(&plan)));
    lap(1);
    let json = write_plan(wheel, setup, &plan, 1);
    let apt = write_apt(&ClProgram::of_plan(&part.name, &plan));
    std::hint::black_box(json.len());
    drop(json);
    lap(2);
    let program = read_apt_bytes("plunge.apt", apt.as_bytes())?;
    let verdict = verify(&part, &channel, setup, &program).map_err(|fault| failed(&fault.what))?;
    lap(3);
    let [planned, judged, written, verified] = seconds;
    say(&format!(
        "  D {:<6.0} {:>7} positions   planned {planned:>7.2}   judged {judged:>6.2}   written {written:>5.2}   verified {verified:>6.2}   {:>4} of 1000 uncut, {} faults{}\n",
        2.0 * part.rim_radius(),
        summary.positions,
        (1000.0 * summary.uncut_share).round(),
        verdict.faults.len(),
        memory().map(|mb| format!("   {mb} MB at most")).unwrap_or_default(),
    ))?;
    Ok((summary.positions, seconds))
}

/// Most memory the program has had until now, MB, where the system tells.
fn memory() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()? / 1024)
}
