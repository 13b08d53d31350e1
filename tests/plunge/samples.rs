//! The sample wheels, and their plans with the defaults: planned once for all tests.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use vanecut::io::part_file::read_part;
use vanecut::job::{PlanJob, PlanOutcome, PlanRequest, run};
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
    run(&comparison(part.clone().into(), setup), &Monitor::default()).expect("a plan")
}

fn comparison(part: Arc<Impeller>, setup: &Setup) -> PlanRequest {
    PlanRequest { part, setup: setup.clone(), policy: AxisPolicy::Minimal, compare: true, field_cells: 512 }
}

/// A sample, and the job of its plans: what was found for one serves the others.
pub fn sample_job(name: &str) -> &'static (PlanJob, Arc<Impeller>) {
    static JOBS: [OnceLock<(PlanJob, Arc<Impeller>)>; 3] = [const { OnceLock::new() }; 3];
    JOBS[index(name)].get_or_init(|| (PlanJob::default(), sample(name).into()))
}

/// A sample's plans by all policies with the defaults.
pub fn sample_plans(name: &str) -> &'static PlanOutcome {
    static PLANS: [OnceLock<PlanOutcome>; 3] = [const { OnceLock::new() }; 3];
    PLANS[index(name)].get_or_init(|| {
        let (job, part) = sample_job(name);
        job.run(&comparison(Arc::clone(part), &Setup::default()), &Monitor::default()).expect("a plan")
    })
}

fn index(name: &str) -> usize {
    SAMPLES.iter().position(|&sample| sample == name).expect("a sample")
}
