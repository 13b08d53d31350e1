//! `vanecut plan`.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::args::PlanArgs;
use super::open::OpenSetup;
use super::watch::watched;
use super::{Failure, open, render, report, say};
use crate::formats::apt::{ClProgram, write_apt};
use crate::formats::plan_file::write_plan;
use crate::formats::setup_file::axis_policy;
use crate::formats::write::write_together;
use crate::geometry::{rotate_vector_z, rotate_z};
use crate::job::{self, JobError, PlanOutcome, PlanRequest};
use crate::part::{AxisPolicy, Impeller};

/// Cells of the residual field along s and λ.
pub const FIELD_CELLS: usize = 512;

/// Plans, writes the files, prints the figures.
pub fn run(args: &PlanArgs) -> Result<(), Failure> {
    let (description, part) = open::part(&args.part, &args.mesh)?;
    let setup = open::setup(args.setup.as_deref(), &args.part, &part)?;
    let policy = match &args.axis {
        None => setup.setup.plunge.axis,
        Some(name) => {
            axis_policy(name).map_err(|(what, cure)| Failure::Input(format!("--axis: {what}; {cure}")))?
        }
    };
    let channels = channel_count(&args.channels, &part)?;
    check_folder(&args.output)?;
    let outcome = outcome(part, &setup, policy, true)?;
    let after = &outcome.after;
    let text = write_plan(&description, &outcome.setup, &after.plan, channels);
    let program = repeated(&ClProgram::of_plan(&outcome.part.name, &after.plan), &outcome.part, channels);
    make_folder(&args.output)?;
    write_together(&[
        (args.output.join("plan.json"), text.as_bytes()),
        (args.output.join("plunge.apt"), write_apt(&program).as_bytes()),
    ])?;
    if args.report {
        render::write_report(&args.output, &outcome)?;
    }
    if args.json {
        say(&format!("{}\n", Value::Object(object(&outcome, channels))))?;
    } else {
        say(&tables(&outcome, channels, args))?;
    }
    judge(&outcome)
}

/// The shared job, with progress on a terminal.
pub fn outcome(
    part: Impeller,
    setup: &OpenSetup,
    policy: AxisPolicy,
    compare: bool,
) -> Result<PlanOutcome, Failure> {
    let request = PlanRequest {
        part: Arc::new(part),
        setup: setup.setup.clone(),
        policy,
        compare,
        field_cells: FIELD_CELLS,
    };
    watched(|monitor| job::run(&request, monitor)).map_err(|error| match error {
        JobError::Cancelled => Failure::Work("cancelled".to_owned()),
        JobError::Setup(fault) => setup.failure(&fault),
    })
}

fn channel_count(word: &str, part: &Impeller) -> Result<usize, Failure> {
    let all = part.blade_count;
    match word {
        "all" => Ok(all),
        _ => word.parse().ok().filter(|n| (1..=all).contains(n)).ok_or_else(|| {
            Failure::Input(format!("--channels {word}: not a number of channels; give 1 to {all}, or all"))
        }),
    }
}

/// The program of channel 1, repeated by rotation.
fn repeated(one: &ClProgram, part: &Impeller, channels: usize) -> ClProgram {
    let mut program = ClProgram { moves: Vec::new(), ..one.clone() };
    // Tool by tool, so that no tool is loaded twice.
    for tool in 0..one.tools.len() {
        for channel in 0..channels {
            let angle = part.pitch() * channel as f64;
            program.moves.extend(one.moves.iter().filter(|m| m.tool == Some(tool)).map(|m| {
                let mut turned = m.clone();
                turned.tip = rotate_z(&m.tip, angle);
                turned.axis = rotate_vector_z(&m.axis, angle);
                turned
            }));
        }
    }
    program
}

/// Tells before the work what [`make_folder`] could only tell after it.
pub fn check_folder(folder: &Path) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        let what = "is no folder; give one that can be written";
        return Err(Failure::at(&folder.display().to_string(), 0, what));
    }
    Ok(())
}

/// Makes the folder that output goes to.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| {
        Failure::Input(format!(
            "{}: the folder cannot be made ({e}); give one that can be written",
            folder.display()
        ))
    })
}

fn object(outcome: &PlanOutcome, channels: usize) -> serde_json::Map<String, Value> {
    let mut map =
        report::plan_object(&outcome.part, channels, &outcome.after, &outcome.grid, &outcome.reasons);
    map.insert("policy".into(), json!(outcome.after.plan.policy));
    map.insert("before".into(), report::compared(&outcome.before, &outcome.grid, &outcome.reasons));
    let mut policies = serde_json::Map::new();
    for result in outcome.policies() {
        policies.insert(
            result.plan.policy.name().to_owned(),
            report::compared(result, &outcome.grid, &outcome.reasons),
        );
    }
    map.insert("policies".into(), Value::Object(policies));
    map.insert("elapsed".into(), report::number(outcome.elapsed));
    map
}

fn tables(outcome: &PlanOutcome, channels: usize, args: &PlanArgs) -> String {
    let part = &outcome.part;
    let mut text = format!(
        "{}: {} blades{}, D {:.1}; {channels} of {} channels planned\n",
        part.name,
        part.blade_count,
        if part.splitters.is_empty() { "" } else { " and as many splitters" },
        2.0 * part.rim_radius(),
        part.blade_count
    );
    text += &report::table(&outcome.policies(), &outcome.grid);
    text += &format!("{} as written:\n", outcome.after.plan.policy.name());
    text += &report::reasons(&outcome.after.plan, &outcome.reasons);
    text += &report::added(&outcome.after.plan);
    text += &report::clearances(&outcome.after.plan, &outcome.after.summary);
    text += &report::held(&outcome.after.plan);
    text += &report::blocked(&outcome.after.plan);
    text += &format!(
        "wrote {} and {}\n",
        args.output.join("plan.json").display(),
        args.output.join("plunge.apt").display()
    );
    text
}

/// The work has failed when the plan breaks an allowance, did not come to rest, or was stopped.
fn judge(outcome: &PlanOutcome) -> Result<(), Failure> {
    if outcome.after.plan.is_unfinished() {
        let what = "stopped: the plan is unfinished, and what was written says so; plan again for all of it";
        return Err(Failure::Work(what.to_owned()));
    }
    let (stock, s) = (&outcome.setup.stock, &outcome.after.summary);
    let mut broken = Vec::new();
    if s.min_hub_clearance < stock.hub_allowance - 1e-3 {
        broken.push(format!("hub clearance {:.4} mm", s.min_hub_clearance));
    }
    if s.min_blade_clearance < stock.blade_allowance - 1e-3 {
        broken.push(format!("blade clearance {:.4} mm", s.min_blade_clearance));
    }
    if s.min_retract_clearance < stock.safety_distance - 1e-3 {
        broken.push(format!("retract clearance {:.3} mm", s.min_retract_clearance));
    }
    if !outcome.after.plan.settled {
        broken.push("the loop did not come to rest".to_owned());
    }
    if broken.is_empty() {
        Ok(())
    } else {
        Err(Failure::Work(format!(
            "the plan does not hold ({}); use smaller cutters or steps",
            broken.join(", ")
        )))
    }
}
