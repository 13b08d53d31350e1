//! What all benchmarks share: the parts they measure, times as medians, and rows of the table.

use std::sync::Arc;
use std::time::Instant;

use super::Failure;
use super::stdout::print_stdout;
use crate::io::part_file::read_part_bytes;
use crate::part::{Impeller, PartDescription};

/// Runs per measurement, of which the median is reported.
const RUNS: usize = 5;

/// Builds a sample part that is included in the program.
///
/// # Errors
/// [`Failure`] when the sample is not a valid part, which is a bug.
pub(super) fn build_sample(name: &str, text: &[u8]) -> Result<Arc<Impeller>, Failure> {
    build(&describe(name, text)?)
}

/// Reads a sample part that is included in the program.
///
/// # Errors
/// [`Failure`] when the sample is not a valid part file, which is a bug.
pub(super) fn describe(name: &str, text: &[u8]) -> Result<PartDescription, Failure> {
    Ok(read_part_bytes(name, text, "toml")?)
}

/// Builds a part derived from a sample.
///
/// # Errors
/// [`Failure::work`] when it is not a valid impeller.
pub(super) fn build(description: &PartDescription) -> Result<Arc<Impeller>, Failure> {
    let part = Impeller::build(description).map_err(|e| Failure::of_work(e).at("the sample part"))?;
    Ok(Arc::new(part))
}

/// Median wall-clock time of `work`, s, after one warm-up run.
pub(super) fn median(mut work: impl FnMut()) -> f64 {
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

/// Prints one row of the table.
///
/// # Errors
/// [`Failure::work`] when standard output cannot be written.
pub(super) fn print_row(what: &str, seconds: f64) -> Result<(), Failure> {
    print_stdout(&format!("{what:<62} {:>7.1} ms\n", 1e3 * seconds))
}

/// Slope of the least-squares line through points (x, y).
pub(super) fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / count, m.1 + p.1 / count));
    let (over, under) = points.iter().fold((0.0, 0.0), |sums, p| {
        let x = p.0 - mean.0;
        (sums.0 + x * (p.1 - mean.1), sums.1 + x * x)
    });
    over / under
}
