//! Does the runs of a shard, several at a time.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::evaluate::evaluate;
use super::result::{Manifest, RunResult, RunStatus};
use super::runs::RunList;
use super::shard::Shard;
use crate::error::ErrorCode;
use crate::io::{InputError, source};
use crate::monitor::Monitor;

/// How often a stop is looked for while runs are computed.
const POLL: Duration = Duration::from_millis(20);

/// How to do the runs of a shard.
#[derive(Clone, Copy, Debug)]
pub struct Execution<'a> {
    /// The study's folder.
    pub folder: &'a Path,
    /// Which runs.
    pub shard: Shard,
    /// Runs at a time. Results do not depend on it.
    pub jobs: usize,
    /// Threads of each run. Results do not depend on them.
    pub threads: usize,
}

/// What became of the runs of a shard.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Runs of the shard.
    pub runs: usize,
    /// Runs whose results were there before.
    pub kept: usize,
    /// Runs computed now.
    pub computed: usize,
    /// Plans with faults, or that did not converge, among both.
    pub faulty: usize,
    /// Runs without a plan, among both.
    pub failed: usize,
    /// Name and error of the first run without a plan, in the order of the study.
    pub first_failed: Option<(String, String)>,
    /// Whether it was stopped before all runs had results.
    pub stopped: bool,
}

impl Tally {
    fn count(&mut self, result: RunResult) {
        match result.status {
            RunStatus::Done => {}
            RunStatus::Faults | RunStatus::NotConverged => self.faulty += 1,
            RunStatus::Error => {
                self.failed += 1;
                if self.first_failed.is_none() {
                    self.first_failed = Some((result.id, result.error.unwrap_or_default()));
                }
            }
        }
    }
}

/// Does the runs of a shard that have no whole result yet, and writes each result when it is there. A stop or
/// cancel of `monitor` ends it; runs that are under way then leave nothing.
///
/// # Errors
/// When the folder or a file cannot be written, or threads cannot be started.
pub fn execute(list: &RunList, how: &Execution<'_>, monitor: &Monitor) -> Result<Tally, InputError> {
    let runs_folder = how.folder.join("runs");
    std::fs::create_dir_all(&runs_folder).map_err(|error| {
        let what = format!("the folder cannot be made ({error})");
        InputError::new(
            ErrorCode::FileNotWritten,
            &source::name_of(&runs_folder),
            0,
            what,
            "give one that can be written",
        )
    })?;
    Manifest::from_list(list).write(how.folder)?;
    let ours: Vec<usize> = (0..list.runs.len()).filter(|&place| how.shard.contains(place)).collect();
    let mut results: Vec<Option<RunResult>> = Vec::with_capacity(ours.len());
    for &place in &ours {
        let run = &list.runs[place];
        results.push(RunResult::existing(how.folder, run, &list.input(&run.choice)));
        if monitor.is_cancelled() {
            break;
        }
    }
    let kept = results.iter().flatten().count();
    results.resize(ours.len(), None);
    let pending: Vec<usize> = (0..ours.len()).filter(|&index| results[index].is_none()).collect();
    monitor.report(kept as f64 / ours.len().max(1) as f64);
    let workers = how.jobs.clamp(1, pending.len().max(1));
    let shared = Shared {
        list,
        how,
        monitor,
        ours: &ours,
        pending: &pending,
        next: AtomicUsize::new(0),
        ended: AtomicBool::new(false),
        monitors: (0..workers).map(|_| Mutex::new(Arc::default())).collect(),
        results: Mutex::new((results, None)),
    };
    start_workers(&shared)?;
    let (results, fault) = shared.results.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(fault) = fault {
        return Err(fault);
    }
    let present = results.iter().flatten().count();
    let mut tally = Tally {
        runs: ours.len(),
        kept,
        computed: present - kept,
        stopped: present < ours.len(),
        ..Tally::default()
    };
    results.into_iter().flatten().for_each(|result| tally.count(result));
    Ok(tally)
}

/// What the workers share.
struct Shared<'a> {
    list: &'a RunList,
    how: &'a Execution<'a>,
    monitor: &'a Monitor,
    /// Places of the shard's runs in the study.
    ours: &'a [usize],
    /// Those of them, by index, that are to be computed.
    pending: &'a [usize],
    next: AtomicUsize,
    /// Set when the study is stopped, or a result cannot be written.
    ended: AtomicBool,
    /// Monitor of the run that each worker computes: a run ends without ending the others.
    monitors: Vec<Mutex<Arc<Monitor>>>,
    /// The results by index, and the first failure to write one.
    results: Mutex<(Vec<Option<RunResult>>, Option<InputError>)>,
}

/// Runs the workers to their end, and passes a stop on to the runs that they compute.
fn start_workers(shared: &Shared<'_>) -> Result<(), InputError> {
    let refused = |error: &dyn std::fmt::Display| {
        InputError::new(
            ErrorCode::System,
            "",
            0,
            format!("threads cannot be started ({error})"),
            "give a smaller --jobs",
        )
    };
    let pools = (shared.monitors.iter())
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(shared.how.threads.max(1)).build())
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| refused(&error))?;
    std::thread::scope(|scope| {
        let mut threads = Vec::with_capacity(pools.len());
        let mut started = Ok(());
        for (pool, current) in pools.iter().zip(&shared.monitors) {
            let work = move || pool.install(|| work(shared, current));
            match std::thread::Builder::new().name("study".to_owned()).spawn_scoped(scope, work) {
                Ok(thread) => threads.push(thread),
                Err(error) => {
                    shared.ended.store(true, Ordering::Relaxed);
                    started = Err(refused(&error));
                    break;
                }
            }
        }
        while threads.iter().any(|thread| !thread.is_finished()) {
            if shared.monitor.is_cancelled() {
                shared.ended.store(true, Ordering::Relaxed);
            }
            if shared.ended.load(Ordering::Relaxed) {
                for current in &shared.monitors {
                    current.lock().unwrap_or_else(PoisonError::into_inner).cancel();
                }
            }
            std::thread::sleep(POLL);
        }
        started
    })
}

/// Takes runs and computes them until none is left.
fn work(shared: &Shared<'_>, current: &Mutex<Arc<Monitor>>) {
    while let Some(&index) = shared.pending.get(shared.next.fetch_add(1, Ordering::Relaxed)) {
        let monitor = Arc::new(Monitor::default());
        *current.lock().unwrap_or_else(PoisonError::into_inner) = Arc::clone(&monitor);
        if shared.ended.load(Ordering::Relaxed) || shared.monitor.is_cancelled() {
            return;
        }
        let run = &shared.list.runs[shared.ours[index]];
        let Ok(result) = evaluate(shared.list, run, shared.list.input(&run.choice), &monitor) else { return };
        let written = result.write(shared.how.folder);
        let mut results = shared.results.lock().unwrap_or_else(PoisonError::into_inner);
        match written {
            Ok(()) => results.0[index] = Some(result),
            Err(fault) => {
                results.1.get_or_insert(fault);
                shared.ended.store(true, Ordering::Relaxed);
                return;
            }
        }
        let present = results.0.iter().flatten().count();
        shared.monitor.report(present as f64 / shared.ours.len().max(1) as f64);
    }
}
