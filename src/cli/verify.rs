//! `vanecut verify`.

mod flank;

use std::path::Path;

use serde_json::{Map, Value, json};

use super::args::VerifyArgs;
use super::plan::FIELD_CELLS;
use super::{Failure, open, report, say};
use crate::formats::apt::read_apt_bytes;
use crate::job::{PolicyResult, Summary};
use crate::part::{Blank, Channel, Impeller, Setup};
use crate::plunge::sections::check_part;
use crate::residual::{FloorGrid, FloorSource, cutters_of, residual_field, stretches_of};
use crate::verify::{Fault, Verdict, is_flank, verify, verify_flank};

/// Faults printed one by one before the rest is only counted.
const MAX_SHOWN: usize = 20;

/// Checks, prints what was found; exit 1 when there is a fault.
pub fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let started = std::time::Instant::now();
    let (_, part) = open::part(&args.part, &args.mesh)?;
    if args.program == Path::new("-") && args.setup.as_deref() == Some(Path::new("-")) {
        return Err(Failure::Input(
            "standard input cannot be setup and program; give one as a file".to_owned(),
        ));
    }
    let opened = open::setup(args.setup.as_deref(), &args.part, &part)?;
    check_part(&opened.setup, &part).map_err(|fault| opened.failure(&fault))?;
    let setup = &opened.setup;
    let (name, bytes) = open::named_bytes(&args.program)?;
    let program = read_apt_bytes(&name, &bytes)?;
    let channel = Channel::of(&part);
    let unjudged = |fault: Fault| Failure::at(&name, fault.line, &fault.what);
    let (mut map, mut text, faults) = if is_flank(&program) {
        let verdict = verify_flank(&part, &channel, setup, &program).map_err(unjudged)?;
        (flank::object(&part, &verdict), flank::text(&verdict), verdict.faults)
    } else {
        let verdict = verify(&part, &channel, setup, &program).map_err(unjudged)?;
        plunges(&part, &channel, setup, verdict)
    };
    if args.json {
        map.insert("elapsed".into(), report::number(started.elapsed().as_secs_f64()));
        let listed = faults.iter().map(|f| json!({"line": f.line, "what": f.what})).collect();
        map.insert("faults".into(), Value::Array(listed));
        say(&format!("{}\n", Value::Object(map)))?;
    } else {
        for warning in &program.warnings {
            text += &format!("{name}:{}: {}\n", warning.line, warning.what);
        }
        for fault in faults.iter().take(MAX_SHOWN) {
            text += &format!("{name}:{}: {}\n", fault.line, fault.what);
        }
        if faults.len() > MAX_SHOWN {
            text += &format!("… and {} faults more\n", faults.len() - MAX_SHOWN);
        }
        say(&text)?;
    }
    match faults.len() {
        0 => Ok(()),
        1 => Err(Failure::Work(format!("{name}: one fault found; correct the program"))),
        n => Err(Failure::Work(format!("{name}: {n} faults found; correct the program"))),
    }
}

/// Object, text and faults of a plunge program.
fn plunges(
    part: &Impeller,
    channel: &Channel,
    setup: &Setup,
    verdict: Verdict,
) -> (Map<String, Value>, String, Vec<Fault>) {
    let blank = Blank::of(part, setup.stock.inlet_extension);
    let source = FloorSource {
        part,
        channel,
        blank: &blank,
        stock: &setup.stock,
        cutters: &stretches_of(&verdict.plan),
    };
    let grid = FloorGrid::new(&source, FIELD_CELLS);
    let field = residual_field(&grid, &cutters_of(&verdict.plan));
    let summary = Summary::of(&verdict.plan, &grid, &field);
    let result = PolicyResult { plan: verdict.plan, field, summary };
    let mut map = report::plan_object(part, verdict.channels, &result, &grid, &[]);
    map.insert("kind".into(), json!("plunge"));
    for key in [
        "max_overcut",
        "max_undercut",
        "uncovered_share",
        "uncovered_fillet_share",
        "uncovered_no_axis_share",
        "uncovered_gap_share",
    ] {
        map.insert(key.into(), Value::Null);
    }
    let mut text = report::named_table([("program", &result)].into_iter(), &grid);
    let s = &result.summary;
    text += &format!(
        "least clearance: hub {:.4} mm, blades {:.4} mm, retracts {:.3} mm\n",
        s.min_hub_clearance, s.min_blade_clearance, s.min_retract_clearance
    );
    (map, text, verdict.faults)
}
