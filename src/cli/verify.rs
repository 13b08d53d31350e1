//! `vanecut verify`.

use std::path::Path;

use serde_json::{Value, json};

use super::args::VerifyArgs;
use super::plan::FIELD_CELLS;
use super::{Failure, open, report};
use crate::formats::apt::{read_apt, read_apt_bytes};
use crate::job::{PolicyResult, Summary};
use crate::part::{Blank, Channel};
use crate::residual::{FloorGrid, cutters_of, residual_field};
use crate::verify::verify;

/// Faults printed one by one before the rest is only counted.
const MAX_SHOWN: usize = 20;

/// Checks, prints what was found; exit 1 when there is a fault.
pub fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let started = std::time::Instant::now();
    let (_, part) = open::part(&args.part)?;
    let setup = open::setup(args.setup.as_deref())?;
    if let Some(name) = setup.part.as_ref().filter(|name| **name != part.name) {
        return Err(Failure::Input(format!(
            "the setup is for part \"{name}\", not for \"{}\"; give the setup of this part",
            part.name
        )));
    }
    let program = if args.program == Path::new("-") {
        read_apt_bytes("standard input", &open::standard_input()?)?
    } else {
        read_apt(&args.program)?
    };
    let channel = Channel::of(&part);
    let verdict = verify(&part, &channel, &setup, &program).map_err(|fault| {
        Failure::Input(format!("{}:{}: {}", args.program.display(), fault.line, fault.what))
    })?;
    let blank = Blank::of(&part, setup.stock.inlet_extension);
    let grid = FloorGrid::new(&part, &channel, &blank, setup.stock.blade_allowance, FIELD_CELLS);
    let field = residual_field(&grid, &cutters_of(&verdict.plan));
    let summary = Summary::of(&verdict.plan, &grid, &field);
    let result = PolicyResult { plan: verdict.plan, field, summary };
    if args.json {
        let head = report::Head {
            part: &part.name,
            blades: part.blade_count,
            splitters: part.splitters.len() * part.blade_count,
            channels: verdict.channels,
        };
        let mut map = report::plan_object(&head, &result, &grid);
        map.insert("elapsed".into(), report::number(started.elapsed().as_secs_f64()));
        let faults = verdict.faults.iter().map(|f| json!({"line": f.line, "what": f.what})).collect();
        map.insert("faults".into(), Value::Array(faults));
        println!("{}", Value::Object(map));
    } else {
        print!("{}", report::table(&[("program", &result)], &grid));
        let s = &result.summary;
        println!(
            "least clearance: hub {:.4} mm, blades {:.4} mm, retracts {:.3} mm",
            s.min_hub_clearance, s.min_blade_clearance, s.min_retract_clearance
        );
        for warning in &program.warnings {
            println!("{}:{}: {}", args.program.display(), warning.line, warning.what);
        }
        for fault in verdict.faults.iter().take(MAX_SHOWN) {
            println!("{}:{}: {}", args.program.display(), fault.line, fault.what);
        }
        if verdict.faults.len() > MAX_SHOWN {
            println!("… and {} faults more", verdict.faults.len() - MAX_SHOWN);
        }
    }
    match verdict.faults.len() {
        0 => Ok(()),
        n => Err(Failure::Work(format!("{}: {n} faults found", args.program.display()))),
    }
}
