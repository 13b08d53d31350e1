//! Cancel is obeyed at once. Alone in its file: other tests beside it would take the cores it is timed on.

use std::sync::Arc;
use std::time::{Duration, Instant};

use vanecut::formats::part_file::read_part_bytes;
use vanecut::job::PlanRequest;
use vanecut::monitor::Monitor;
use vanecut::part::{AxisPolicy, Impeller, Setup};

#[test]
#[ignore = "a timing: run it alone on a quiet machine, `cargo test --test cancel -- --ignored`"]
fn the_planner_obeys_cancel_within_50_ms() {
    let text = include_str!("../assets/parts/impeller532.toml");
    let description = read_part_bytes("impeller532.toml", text.as_bytes(), "toml").expect("readable");
    let part = Arc::new(Impeller::build(&description).expect("an impeller"));
    let mut setup = Setup::default();
    setup.plunge.step = Some(1.0);
    let request = PlanRequest { part, setup, policy: AxisPolicy::Monotone, compare: false, field_cells: 512 };
    let cancel_after = |wait: u64| {
        let monitor = Monitor::default();
        std::thread::scope(|scope| {
            let work = scope.spawn(|| vanecut::job::run(&request, &monitor).is_ok());
            std::thread::sleep(Duration::from_millis(wait));
            let start = Instant::now();
            monitor.cancel();
            let was_done = work.join().expect("no panic");
            if was_done { Duration::ZERO } else { start.elapsed() }
        })
    };
    // At several moments, so that every stage of the work is met; the quickest of three attempts is
    // the planner's own time, without what else the machine does.
    let moments = [5, 20, 60, 120, 250, 500];
    let slowest = moments.map(|wait| [wait; 3].map(cancel_after).into_iter().min());
    let slowest = slowest.into_iter().flatten().max().expect("attempts were made");
    assert!(slowest < Duration::from_millis(50), "the planner took {slowest:?} to stop");
}
