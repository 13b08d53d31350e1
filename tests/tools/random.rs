//! Random assemblies on the samples: no program brings a shank or holder near, by points of the wheel.

use std::path::Path;
use std::sync::Arc;

use vanecut::flank::choice::choose_tool;
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::part_file::{read_part, read_part_with};
use vanecut::io::read_setup_bytes;
use vanecut::io::tool_library::flank_cutters;
use vanecut::job::flank::{FlankJob, FlankRequest};
use vanecut::job::{PlanRequest, resolve, run};
use vanecut::mesh::{LengthUnit, MeshOptions};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::{AxisPolicy, FlankStrategy, Setup};
use vanecut::toolpath::ClProgram;
use vanecut::verify::verify;

use super::sampled_tool::{Dice, WheelPoints, collisions, with_random_assembly, with_wild_assembly};

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/parts/{name}.toml"));
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

/// Plans a sample with random assemblies by all policies, and looks at each program.
fn check_policies(name: &str, seed: u64) {
    let part = sample(name);
    let mut dice = Dice::new(seed);
    let mut setup = Setup::for_part(&part);
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let chosen = resolve(&setup, &workpiece).expect("tools").setup;
    setup.tools = chosen.tools.iter().map(|tool| with_random_assembly(tool, &mut dice)).collect();
    let points = WheelPoints::from_workpiece(&workpiece);
    let request =
        PlanRequest { part: part.into(), setup, policy: AxisPolicy::Minimal, compare: true, field_cells: 64 };
    let outcome = run(&request, &Monitor::default()).expect("a plan");
    for result in outcome.policies() {
        let plan = &result.plan;
        let program = ClProgram::of_plan(name, plan);
        let found = collisions(&workpiece, &points, &outcome.setup, &program);
        let policy = plan.policy;
        assert!(found.is_empty(), "{name}, {policy:?}: {found:#?}\n{:?}", outcome.setup.tools);
        assert!(!plan.positions.is_empty(), "{name}, {policy:?} cuts nothing");
    }
}

#[test]
fn every_policy_keeps_random_assemblies_clear() {
    check_policies("pump6", 8);
}

#[test]
#[ignore = "a whole plan, 9 s; scripts/nightly runs it"]
fn a_shank_that_is_thinner_above_is_clear_on_the_way_out() {
    let part = Arc::new(sample("impeller9x9"));
    let text = "[[tool]]\nnumber = 21\ndiameter = 12.7\ninsert_width = 6.0\noverhang = 70.0\n\
                shank = [[12, 5], [11, 45]]\n";
    let setup = read_setup_bytes("s.toml", text.as_bytes()).expect("a setup");
    let policy = AxisPolicy::Minimal;
    let outcome =
        run(&PlanRequest { part, setup, policy, compare: false, field_cells: 64 }, &Monitor::default());
    let outcome = outcome.expect("a plan");
    let text = write_apt(&ClProgram::of_plan("9x9", &outcome.after.plan));
    let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("its own program");
    let verdict = verify(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()).expect("judged");
    let found: Vec<_> = verdict.faults.iter().filter(|fault| fault.kind.is_of_assembly()).collect();
    assert!(found.is_empty() && verdict.cuts.len() > 300, "{} cuts, {found:?}", verdict.cuts.len());
}

#[test]
#[ignore = "as the test before it, on another sample; scripts/nightly runs it"]
fn every_policy_keeps_random_assemblies_of_another_sample_clear() {
    check_policies("impeller532", 3);
}

#[test]
fn a_flank_strategy_keeps_random_assemblies_clear() {
    flank_assemblies_stay_clear(&[FlankStrategy::Regions]);
}

#[test]
#[ignore = "as the test before it, by the other strategies; scripts/nightly runs it"]
fn other_flank_strategies_keep_random_assemblies_clear() {
    // The balanced one is tried on made wheels (tests/wheels).
    flank_assemblies_stay_clear(&[FlankStrategy::Isoparametric, FlankStrategy::Layers]);
}

fn flank_assemblies_stay_clear(strategies: &[FlankStrategy]) {
    let part = sample("pump6");
    let setup = Setup::for_part(&part);
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let points = WheelPoints::from_workpiece(&workpiece);
    let ball = choose_tool(&workpiece, &setup, flank_cutters()).expect("a tool").tool;
    for (&strategy, seed) in strategies.iter().zip(20..) {
        let mut setup = setup.clone();
        setup.tools = vec![with_random_assembly(&ball, &mut Dice::new(seed))];
        setup.flank.tool = Some(ball.number);
        setup.flank.strategy = strategy;
        // A fraction of the passes of the defaults: each is checked move by move.
        (setup.flank.layer_depth, setup.flank.scallop_height) = (15.0, 2.5);
        let request = FlankRequest { part: part.clone().into(), setup };
        let outcome = FlankJob::default().run(&request, &Monitor::default()).expect("a plan");
        let plan = &outcome.plan;
        let program = ClProgram::of_flank("pump6", &plan.tool, &plan.moves);
        let program = program.after_opening(plan.opening.as_ref());
        let found = collisions(&workpiece, &points, &outcome.setup, &program);
        assert!(found.is_empty(), "{strategy:?}: {found:#?}\n{:?}", plan.tool);
        assert!(!plan.moves.is_empty(), "{strategy:?} cuts nothing");
    }
}

/// A wheel of others, in mm.
fn wheel(file: &str, blades: Option<usize>) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wheels").join(file);
    let options = MeshOptions { unit: Some(LengthUnit::Millimetre), blades, ..MeshOptions::default() };
    Impeller::build(&read_part_with(&path, &options).expect("readable")).expect("an impeller")
}

/// Plans a real wheel with any assembly: either what is in the way is named, or no part of the tool comes
/// near to anything.
fn check_wheel(file: &str, blades: Option<usize>) {
    let part = wheel(file, blades);
    let setup = Setup::for_part(&part);
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let points = WheelPoints::from_workpiece(&workpiece);
    let chosen = resolve(&setup, &workpiece).expect("tools").setup;
    let ball = choose_tool(&workpiece, &setup, flank_cutters()).expect("a tool").tool;
    let part = Arc::new(part);
    let mut planned = 0;
    for seed in 0..2 {
        let mut dice = Dice::new(seed);
        let tools: Vec<_> = chosen.tools.iter().map(|tool| with_wild_assembly(tool, &mut dice)).collect();
        let ball = if seed == 0 { ball.clone() } else { with_wild_assembly(&ball, &mut dice) };
        let place = format!("{file}, {seed}: {tools:?} {ball:?}");
        let mut plunge = Setup { tools, ..setup.clone() };
        plunge.plunge.rest = false;
        let (policy, compare) = (AxisPolicy::Minimal, true);
        let request = PlanRequest { part: part.clone(), setup: plunge, policy, compare, field_cells: 64 };
        match run(&request, &Monitor::default()) {
            Err(error) => is_about_the_tool(&error.to_string(), &place),
            Ok(outcome) => {
                for result in outcome.policies() {
                    let program = ClProgram::of_plan(file, &result.plan);
                    let found = collisions(&workpiece, &points, &outcome.setup, &program);
                    assert!(found.is_empty(), "{:?}: {found:#?}\n{place}", result.plan.policy);
                    planned += 1;
                }
            }
        }
        let mut setup = Setup { tools: vec![ball.clone()], ..setup.clone() };
        setup.flank.tool = Some(ball.number);
        match FlankJob::default().run(&FlankRequest { part: part.clone(), setup }, &Monitor::default()) {
            Err(error) => is_about_the_tool(&error.to_string(), &place),
            Ok(outcome) => {
                let plan = &outcome.plan;
                let program = ClProgram::of_flank(file, &plan.tool, &plan.moves);
                let found = collisions(&workpiece, &points, &outcome.setup, &program);
                assert!(found.is_empty(), "flank: {found:#?}\n{place}");
                planned += usize::from(!plan.moves.is_empty());
            }
        }
    }
    assert!(planned > 0, "no program of {file}");
}

#[test]
#[ignore = "plans of some minutes; scripts/nightly runs it"]
fn no_assembly_on_hecc_comes_near_to_anything() {
    check_wheel("hecc.toml", None);
}

#[test]
#[ignore = "plans of some minutes; scripts/nightly runs it"]
fn no_assembly_on_the_kj66_comes_near_to_anything() {
    check_wheel("kj66_sections.toml", None);
}

/// Blades beyond the channel were cut by 1.9 mm with the tool that is chosen.
#[test]
#[ignore = "plans of some minutes; scripts/nightly runs it"]
fn no_assembly_on_the_mesh_of_the_kj66_comes_near_to_anything() {
    check_wheel("kj66_cad.glb", None);
}

#[test]
#[ignore = "plans of some minutes; scripts/nightly runs it"]
fn no_assembly_on_a_wheel_of_12_mm_comes_near_to_anything() {
    check_wheel("paraturbo.glb", Some(9));
}

/// A refusal says what to change about the tool.
fn is_about_the_tool(message: &str, place: &str) {
    let says = ["overhang", "holder", "shank", "cutter"].iter().any(|word| message.contains(word));
    assert!(says, "{message}\n{place}");
}
