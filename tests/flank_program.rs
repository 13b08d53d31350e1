//! Whole flank plans, written and judged by `verify`, which knows nothing of how they were planned.

use std::path::Path;
use std::sync::Arc;

use vanecut::flank::MoveKind;
use vanecut::formats::apt::{ClProgram, read_apt_bytes, write_apt};
use vanecut::formats::flank_file::{is_flank, read_flank_bytes, write_flank};
use vanecut::formats::read_part;
use vanecut::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use vanecut::monitor::Monitor;
use vanecut::part::{Channel, FlankScheme, Impeller, Setup};
use vanecut::verify::verify_flank;

fn request(name: &str, change: impl FnOnce(&mut Setup)) -> FlankRequest {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    let part = Impeller::build(&read_part(&path).expect("readable")).expect("an impeller");
    let mut setup = Setup::default();
    change(&mut setup);
    FlankRequest { part: Arc::new(part), setup }
}

fn planned(request: &FlankRequest) -> FlankOutcome {
    FlankJob::default().run(request, &Monitor::default()).expect("a plan")
}

#[test]
fn verify_finds_no_fault_in_the_programs() {
    for (name, scheme, depth) in [
        ("impeller9x9.toml", FlankScheme::Balanced, 3.0),
        ("impeller9x9.toml", FlankScheme::Isoparametric, 6.0),
        ("pump6.toml", FlankScheme::Regions, 5.0),
    ] {
        let outcome = planned(&request(name, |setup| {
            setup.flank.scheme = scheme;
            setup.flank.layer_depth = depth;
        }));
        let plan = &outcome.plan;
        let text = write_apt(&ClProgram::of_flank(&outcome.part.name, &plan.tool, plan.feed, &plan.moves));
        let program = read_apt_bytes("flank.apt", text.as_bytes()).expect("it reads its own program");
        let channel = Channel::of(&outcome.part);
        let verdict = verify_flank(&outcome.part, &channel, &outcome.setup, &program).expect("judged");
        assert!(verdict.faults.is_empty(), "{name} {scheme:?}: {:?}", verdict.faults.first());
        let lost: f64 = plan.left_out.iter().map(|l| l.length).sum();
        let whole = plan.curves.totals[scheme as usize].length;
        assert!(lost < 0.03 * whole, "{name} {scheme:?}: {lost} of {whole} mm are left out");
    }
}

#[test]
fn a_program_cuts_from_the_top_down_and_flies_only_above() {
    let outcome = planned(&request("impeller9x9.toml", |setup| setup.flank.layer_depth = 6.0));
    let moves = &outcome.plan.moves;
    let cuts: Vec<usize> = moves.iter().filter(|m| m.kind == MoveKind::Cut).map(|m| m.layer).collect();
    assert!(cuts.windows(2).all(|w| w[1] <= w[0]), "layers from the top down");
    assert_eq!(cuts.last(), Some(&0));
    assert_eq!(moves.first().map(|m| m.kind), Some(MoveKind::Rapid));
    assert_eq!(moves.last().map(|m| m.kind), Some(MoveKind::Rapid));
    // A feed move never follows a flight without the way down.
    for pair in moves.windows(2) {
        assert!(
            !(pair[0].kind == MoveKind::Rapid && pair[1].kind == MoveKind::Cut),
            "a cut begins with an approach"
        );
    }
}

#[test]
fn a_flank_file_reads_back_and_damage_is_told() {
    let request = request("impeller9x9.toml", |setup| setup.flank.layer_depth = 9.0);
    let outcome = planned(&request);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller9x9.toml");
    let text = write_flank(&read_part(&path).expect("readable"), &outcome.setup, &outcome.plan);
    assert!(is_flank(text.as_bytes()));
    let stored = read_flank_bytes("f.json", text.as_bytes()).expect("it reads its own file");
    assert_eq!(stored.moves.len(), outcome.plan.moves.len());
    assert_eq!(stored.layers, outcome.plan.curves.layers.len());
    assert_eq!(stored.setup.flank, outcome.setup.flank);
    assert_eq!(stored.walls.len(), outcome.plan.walls.len());
    let most = stored.walls.iter().map(|w| w.map.max_undercut()).fold(0.0, f64::max);
    assert!((most - outcome.plan.max_undercut()).abs() < 1e-6, "the map holds the figure: {most}");
    for (a, b) in stored.moves.iter().zip(&outcome.plan.moves) {
        assert!((a.tip - b.tip).norm() < 1e-5 && a.axis.angle(&b.axis) < 1e-6 && a.kind == b.kind);
    }
    let newer = text.replacen("\"vanecut_flank\":1", "\"vanecut_flank\":7", 1);
    assert!(read_flank_bytes("f.json", newer.as_bytes()).unwrap_err().to_string().contains("newer"));
    assert!(read_flank_bytes("f.json", &text.as_bytes()[..text.len() / 2]).is_err());
}

#[test]
fn only_stale_stages_are_planned_again_and_to_the_same_end() {
    let job = FlankJob::default();
    let mut request = request("impeller9x9.toml", |setup| setup.flank.layer_depth = 6.0);
    let first = job.run(&request, &Monitor::default()).expect("a plan");
    request.setup.flank.feed = Some(900.0);
    let second = job.run(&request, &Monitor::default()).expect("a plan");
    assert!(Arc::ptr_eq(&first.plan.curves, &second.plan.curves), "curves do not depend on the feed");
    assert!(Arc::ptr_eq(&first.plan.walls, &second.plan.walls));
    request.setup.flank.allowed_error = 0.1;
    let third = job.run(&request, &Monitor::default()).expect("a plan");
    assert!(!Arc::ptr_eq(&second.plan.curves, &third.plan.curves));
    assert!(Arc::ptr_eq(&second.plan.walls, &third.plan.walls), "walls do not depend on the error");
    let fresh = planned(&request);
    assert_eq!(fresh.plan.moves.len(), third.plan.moves.len());
    assert!(fresh.plan.moves.iter().zip(&third.plan.moves).all(|(a, b)| a.tip == b.tip && a.axis == b.axis));
}
