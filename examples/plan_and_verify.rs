//! Plans the plunges of a wheel, writes the program and judges it as any other program:
//! `cargo run --release --example plan_and_verify -- PART.toml PROGRAM.apt`.

use std::error::Error;
use std::path::Path;

use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::part_file::read_part;
use vanecut::io::write::write_atomically;
use vanecut::job::{PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::{AxisPolicy, Setup};
use vanecut::toolpath::ClProgram;
use vanecut::verify::report_plunges;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(part), Some(output)) = (arguments.next(), arguments.next()) else {
        return Err("usage: plan_and_verify PART.toml PROGRAM.apt".into());
    };
    let part = Impeller::build(&read_part(Path::new(&part))?)?;

    // The defaults scale with the wheel; without tools in the setup the built-in library is used.
    let request = PlanRequest {
        part: part.clone().into(),
        setup: Setup::for_part(&part),
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 256,
    };
    let outcome = run(&request, &Monitor::default())?;
    let (before, after) = (&outcome.before.summary, &outcome.after.summary);
    println!(
        "{}: {} of {} plunges interfere conventionally",
        part.name, before.interfering, before.positions
    );
    println!(
        "minimal: {} plunges, {} interfere, {:.2} mm of stock on average",
        after.positions, after.interfering, after.residual_mean
    );

    let text = write_apt(&ClProgram::of_plan(&part.name, &outcome.after.plan));
    write_atomically(Path::new(&output), text.as_bytes())?;
    let program = read_apt_bytes(&output, text.as_bytes())?;
    let report = report_plunges(&outcome.workpiece, &outcome.setup, &program, 256, &Monitor::default())
        .map_err(|error| format!("{output}: {error}"))?;
    println!("{output}: {} faults", report.verdict.faults.len());
    Ok(())
}
