//! The sample wheels, and their plans with the defaults: planned once for all tests.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use vanecut::io::part_file::read_part;
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::{AxisPolicy, Setup};

/// Names of the samples.
pub const SAMPLES: [&str; 3] = ["impeller532", "impeller9x9", "pump6"];

pub fn sample_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(format!("{name}.toml"))
}

pub fn sample(name: &str) -> Impeller {
    Impeller::build(&read_part(&sample_path(name)).expect("readable")).expect("an impeller")
}

/// Plans by all policies.
pub fn compared(part: &Impeller, setup: &Setup) -> PlanOutcome {
    let request = PlanRequest {
        part: part.clone().into(),
        setup: setup.clone(),
        policy: AxisPolicy::Minimal,
        compare: true,
        field_cells: 512,
    };
    run(&request, &Monitor::default()).expect("a plan")
}

/// A sample's plans by all policies with the defaults.
pub fn sample_plans(name: &str) -> &'static PlanOutcome {
    static PLANS: [LazyLock<PlanOutcome>; 3] = [
        LazyLock::new(|| compared(&sample(SAMPLES[0]), &Setup::default())),
        LazyLock::new(|| compared(&sample(SAMPLES[1]), &Setup::default())),
        LazyLock::new(|| compared(&sample(SAMPLES[2]), &Setup::default())),
    ];
    let index = SAMPLES.iter().position(|&sample| sample == name).expect("a sample");
    &PLANS[index]
}
