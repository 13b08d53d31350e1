//! Complete flank plans, written and checked by `verify`, which is independent of the planner.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use vanecut::error::ErrorCode;
use vanecut::flank::{FlankMove, MoveKind};
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::flank_file::{ShownWall, is_flank, read_flank_bytes, write_flank};
use vanecut::io::read_part;
use vanecut::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use vanecut::monitor::Monitor;
use vanecut::part::{BlankShape, Impeller};
use vanecut::setup::cutting_data::{CuttingData, cutting_speed_at};
use vanecut::setup::{FlankStrategy, Setup};
use vanecut::stock::solid::{SolidBlank, SolidProgram, SolidStock, ToolPart};
use vanecut::toolpath::ClProgram;
use vanecut::verify::verify_flank;

fn request(name: &str, change: impl FnOnce(&mut Setup)) -> FlankRequest {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    let part = Impeller::build(&read_part(&path).expect("readable")).expect("an impeller");
    let mut setup = Setup::default();
    // Fewer passes than by default.
    setup.flank.scallop_height = 0.6;
    change(&mut setup);
    FlankRequest { part: Arc::new(part), setup }
}

fn planned(request: &FlankRequest) -> FlankOutcome {
    FlankJob::default().run(request, &Monitor::default()).expect("a plan")
}

/// The balanced strategy with a feed rate of its own for each engagement.
static BALANCED: LazyLock<FlankOutcome> = LazyLock::new(|| {
    planned(&request("impeller9x9.toml", |setup| {
        setup.flank.strategy = FlankStrategy::Balanced;
        setup.flank.layer_depth = 6.0;
        setup.flank.scallop_height = 0.25;
        setup.flank.feed_mm_per_min = Some(1000.0);
        setup.flank.slot_feed_mm_per_min = Some(500.0);
        setup.flank.wall_feed_mm_per_min = Some(700.0);
        setup.flank.ramp_feed_mm_per_min = Some(200.0);
    }))
});

/// The strategy by regions, on a wheel without splitters, with some shape of blank.
fn by_regions(blank: BlankShape) -> FlankOutcome {
    planned(&request("pump6.toml", |setup| {
        setup.flank.strategy = FlankStrategy::Regions;
        setup.flank.layer_depth = 10.0;
        setup.allowances.blank = blank;
    }))
}

static BY_REGIONS: LazyLock<FlankOutcome> = LazyLock::new(|| by_regions(BlankShape::Edges));
/// Of a cylinder, which plunges open.
static OPENED: LazyLock<FlankOutcome> = LazyLock::new(|| by_regions(BlankShape::Turned));

#[test]
fn verify_finds_no_fault_in_the_programs() {
    let isoparametric = planned(&request("impeller9x9.toml", |setup| {
        setup.flank.strategy = FlankStrategy::Isoparametric;
        setup.flank.layer_depth = 12.0;
    }));
    for outcome in [&*BALANCED, &isoparametric, &*BY_REGIONS] {
        let (name, scheme) = (&outcome.workpiece.part.name, outcome.setup.flank.strategy);
        let plan = &outcome.plan;
        let text = write_apt(&ClProgram::of_flank(&outcome.workpiece.part.name, &plan.tool, &plan.moves));
        let program = read_apt_bytes("flank.apt", text.as_bytes()).expect("it reads its own program");
        let verdict =
            verify_flank(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()).expect("judged");
        assert!(verdict.faults.is_empty(), "{name} {scheme:?}: {:?}", verdict.faults.first());
        if scheme == FlankStrategy::Balanced {
            // Only the ball's fillet beside the walls remains, no gap between passes or beside a nose.
            assert!(verdict.uncovered.gap < 0.005, "{name}: {:?}", verdict.uncovered);
            assert!(verdict.max_undercut < 0.03, "{name}: {} mm left on a wall", verdict.max_undercut);
        }
        let lost: f64 = plan.uncut.iter().map(|l| l.length).sum();
        let whole = plan.layout.totals[scheme as usize].length;
        assert!(lost < 0.03 * whole, "{name} {scheme:?}: {lost} of {whole} mm are left out");
    }
}

#[test]
fn a_cylinder_is_opened_before_the_passes_and_these_are_planned_as_without_it() {
    let (usual, outcome) = (&*BY_REGIONS, &*OPENED);
    assert_eq!(usual.plan.opening, None);
    assert_eq!(outcome.faults, []);
    let plan = &outcome.plan;
    let lost = |outcome: &FlankOutcome| outcome.plan.uncut.iter().map(|l| l.length).sum::<f64>();
    let whole = plan.layout.totals[FlankStrategy::Regions as usize].length;
    assert!(lost(outcome) < lost(usual) + 0.03 * whole, "{} of {whole} mm are left out", lost(outcome));
    // Ramps know nothing of what the plunges leave: they are no longer than those into a whole layer.
    let ramps = |kind| plan.moves.iter().filter(move |step| step.kind == kind).count();
    assert!(4 * ramps(MoveKind::Approach) < ramps(MoveKind::Cut), "{} moves", ramps(MoveKind::Approach));
    // The plunges reach over neighbouring channels, which are not cut by that.
    let [judged, judged_usual] = [outcome, usual].map(|one| one.verdict.as_ref().expect("judged"));
    assert_eq!(judged.channels, 1);
    let [share, usual_share] = [judged, judged_usual].map(|verdict| verdict.uncovered.share());
    assert!(share < usual_share + 0.03, "{share} of the floor is uncovered, {usual_share} without them");
    // The program begins with them, also when it is read from the plan's file.
    let opening = plan.opening.as_ref().expect("plunges above the shroud");
    let passes = ClProgram::of_flank(&outcome.workpiece.part.name, &plan.tool, &plan.moves);
    let program = passes.after_opening(Some(opening));
    assert_eq!(program.moves.len(), 3 * opening.plunges.len() + plan.moves.len());
    let description = read_part(&Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml"));
    let text = write_flank(&description.expect("readable"), &outcome.setup, plan, &[], 1);
    let read = read_flank_bytes("flank.json", text.as_bytes()).expect("its own file");
    let again = read.program(&Monitor::default()).expect("not cancelled").expect("with tools");
    assert_eq!(again.moves.len(), program.moves.len());
    let moved = again.moves.iter().zip(&program.moves).map(|(a, b)| (a.tip - b.tip).norm());
    assert!(moved.fold(0.0, f64::max) < 1e-5);
    let blank = SolidBlank::from_part(&outcome.workpiece.part, &outcome.workpiece.blank);
    let mut stock = SolidStock::new(&blank, 0.8).expect("small");
    let moves = SolidProgram::new(&again, &outcome.setup).expect("with tools");
    let met = stock.make_moves(&moves.tools, &moves.moves, &Monitor::default()).expect("runs");
    // Approaches go down along the axis of a ball, whose middle meets the steps that flat plunges leave above
    // the shroud.
    assert!(met.iter().all(|contact| contact.part == ToolPart::Core), "{met:?}");
}

/// The tools of the library are for steel: in another material they turn as its cutting data ask for.
#[test]
#[ignore = "a flank plan beside one that is shared; scripts/nightly runs it"]
fn tools_of_the_library_have_the_rates_of_the_material() {
    // No material is named.
    let steel = &*OPENED;
    // Tools are chosen for the channel, whatever the passes: few of them.
    let titanium = planned(&request("pump6.toml", |setup| {
        setup.flank.strategy = FlankStrategy::Regions;
        (setup.flank.layer_depth, setup.flank.scallop_height) = (16.0, 1.5);
        setup.allowances.blank = BlankShape::Turned;
        setup.allowances.material = Some("titanium".to_owned());
    }));
    let data = CuttingData::of_name("titanium").expect("known");
    let named = |outcome: &FlankOutcome, setup: &Setup| {
        setup.allowances.too_fast(outcome.plan.tools()).unwrap_or_default()
    };
    assert_eq!(named(&titanium, &titanium.setup), "");
    assert!(named(steel, &titanium.setup).starts_with("much faster than the 40 m/min for titanium: T"));
    let tools = |outcome: &FlankOutcome| outcome.plan.tools().cloned().collect::<Vec<_>>();
    let [steel, titanium] = [tools(steel), tools(&titanium)];
    assert_eq!((steel.len(), titanium.len()), (2, 2), "the ball, and what opens the cylinder");
    let steel_data = CuttingData::of_name("steel").expect("known");
    assert_eq!(
        steel_data.scaled_from_steel(&steel[0]),
        steel[0].clone().with_given_rates(),
        "steel, where no material is named"
    );
    for tool in &titanium {
        let speed = cutting_speed_at(tool.spindle, tool.diameter);
        assert!((speed - data.cutting_speed).abs() < 0.02 * data.cutting_speed, "T{} {speed}", tool.number);
    }
    assert_eq!(titanium[0], data.scaled_from_steel(&steel[0]));
}

#[test]
fn a_program_cuts_from_the_top_down_and_flies_only_above() {
    let moves = &BALANCED.plan.moves;
    let cuts: Vec<usize> = moves.iter().filter(|m| m.kind == MoveKind::Cut).map(|m| m.layer).collect();
    assert!(cuts.windows(2).all(|w| w[1] <= w[0]), "layers from the top down");
    assert_eq!(cuts.last(), Some(&0));
    assert_eq!(moves.first().map(|m| m.kind), Some(MoveKind::Rapid));
    assert_eq!(moves.last().map(|m| m.kind), Some(MoveKind::Rapid));
    // Between a rapid and a cut there is always an approach.
    for pair in moves.windows(2) {
        assert!(
            !(pair[0].kind == MoveKind::Rapid && pair[1].kind == MoveKind::Cut),
            "a cut begins with an approach"
        );
    }
}

/// `verify` finds rapids that meet stock, by its solid: the fast moves become rapids here. The lesser safety
/// distance lets them end near the stock.
#[test]
fn a_cutter_comes_down_fast_only_where_it_meets_no_stock() {
    let near = planned(&request("impeller9x9.toml", |setup| {
        setup.flank.layer_depth = 6.0;
        setup.flank.scallop_height = 0.25;
        setup.allowances.safety_distance = 0.2;
    }));
    for outcome in [&near, &*BY_REGIONS] {
        let (plan, name) = (&outcome.plan, &outcome.workpiece.part.name);
        let mut moves = plan.moves.clone();
        let (mut fast, mut all) = (0, 0);
        for step in moves.iter_mut().filter(|step| step.kind == MoveKind::Approach) {
            all += 1;
            if step.feed_mm_per_min == plan.feeds.approach_mm_per_min {
                step.kind = MoveKind::Rapid;
                fast += 1;
            }
        }
        assert!(fast > 20 && fast < all, "{fast} of {all}");
        let program = ClProgram::of_flank(name, &plan.tool, &moves);
        let program = read_apt_bytes("flank.apt", write_apt(&program).as_bytes()).expect("its own program");
        let verdict =
            verify_flank(&outcome.workpiece, &outcome.setup, &program, &Monitor::default()).expect("judged");
        assert!(verdict.faults.is_empty(), "{name}: {:?}", verdict.faults.first());
    }
}

/// Ramps to and fro into full stock take longer than the way to a place that is cut.
#[test]
fn passes_are_entered_from_what_is_cut() {
    let plan = &BALANCED.plan;
    let ramps = |from: MoveKind| {
        let is_ramp = |step: &FlankMove| step.kind == MoveKind::Approach && step.feed_mm_per_min == 200.0;
        let begin = |pair: &&[FlankMove]| is_ramp(&pair[1]) && !is_ramp(&pair[0]) && pair[0].kind == from;
        plan.moves.windows(2).filter(begin).count()
    };
    let descents = plan
        .moves
        .windows(2)
        .filter(|pair| pair[0].kind == MoveKind::Rapid && pair[1].kind == MoveKind::Approach);
    let (ramps, descents) = (ramps(MoveKind::Approach), descents.count());
    assert!(ramps > 0 && 10 * ramps < descents, "{ramps} ramps of {descents} descents");
}

#[test]
fn every_curve_has_one_feed_by_what_stands_beside_it() {
    let outcome = &*BALANCED;
    let moves = &outcome.plan.moves;
    let cuts = || moves.iter().filter(|m| m.kind == MoveKind::Cut);
    assert!(
        cuts().all(|m| !m.along_wall || m.feed_mm_per_min == 700.0 || m.feed_mm_per_min == 500.0),
        "walls are cut no faster than they may be"
    );
    assert!(cuts().all(|m| m.along_wall || m.feed_mm_per_min != 700.0), "only walls have their feed");
    let at = |feed: f64| cuts().filter(|m| m.feed_mm_per_min == feed).count();
    assert_eq!(at(1000.0) + at(500.0) + at(700.0), cuts().count(), "no other feeds");
    assert!(
        at(1000.0) > at(500.0),
        "most curves run beside one that is cut: {} and {}",
        at(1000.0),
        at(500.0)
    );
    // The first pass of a layer has stock on both sides.
    for layer in 0..outcome.plan.layout.layers.len() {
        let first = cuts().find(|m| m.layer == layer && !m.along_wall).map(|m| m.feed_mm_per_min);
        assert_eq!(first, Some(500.0), "layer {layer}");
    }
    assert!(
        moves.iter().any(|m| m.kind == MoveKind::Approach && m.feed_mm_per_min == 200.0),
        "it ramps somewhere"
    );
    // The program and its time use the same feed rates.
    let text = write_apt(&ClProgram::of_flank(&outcome.workpiece.part.name, &outcome.plan.tool, moves));
    for feed in ["FEDRAT/1000", "FEDRAT/500", "FEDRAT/700", "FEDRAT/200"] {
        assert!(text.contains(feed), "{feed}");
    }
    let time: f64 = moves
        .windows(2)
        .filter(|w| w[1].kind == MoveKind::Cut)
        .map(|w| 60.0 * (w[1].tip - w[0].tip).norm() / w[1].feed_mm_per_min)
        .sum();
    assert!((time - outcome.plan.times.cut_time).abs() < 1e-6 * time);
}

#[test]
fn a_flank_file_reads_back_and_damage_is_reported() {
    let outcome = &*BALANCED;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller9x9.toml");
    let (description, mut walls) = (read_part(&path).expect("readable"), outcome.shown_walls());
    let middle = walls[1].map.deviation.len() / 2;
    walls[1].map.deviation[middle] = f64::NAN;
    let text = write_flank(&description, &outcome.setup, &outcome.plan, &walls, 1);
    assert!(is_flank(text.as_bytes()));
    let stored = read_flank_bytes("f.json", text.as_bytes()).expect("it reads its own file");
    assert_eq!(stored.moves.len(), outcome.plan.moves.len());
    assert_eq!(stored.layers, outcome.plan.layout.layers.len());
    assert_eq!(stored.setup.flank, outcome.setup.flank);
    assert_eq!(stored.walls.len(), walls.len());
    let most = stored.walls.iter().map(|w| w.map.max_undercut()).fold(0.0, f64::max);
    assert!((most - outcome.max_undercut()).abs() < 1e-6, "the map holds the figure: {most}");
    let unmilled = |walls: &[ShownWall]| {
        let numbers = walls.iter().flat_map(|w| &w.map.deviation);
        numbers.filter(|d| d.is_nan()).count()
    };
    assert_eq!(unmilled(&stored.walls), unmilled(&walls));
    assert_eq!(unmilled(&walls), unmilled(&outcome.shown_walls()) + 1);
    for (a, b) in stored.moves.iter().zip(&outcome.plan.moves) {
        assert!((a.tip - b.tip).norm() < 1e-5 && a.axis.angle(&b.axis) < 1e-6 && a.kind == b.kind);
        assert!(
            (a.feed_mm_per_min - b.feed_mm_per_min).abs() < 1e-2,
            "{} {}",
            a.feed_mm_per_min,
            b.feed_mm_per_min
        );
    }
    // Files of older versions have one feed rate.
    let at = text.rfind(",\"feeds\":[").expect("feeds come last");
    let old = read_flank_bytes("f.json", format!("{}}}\n", &text[..at]).as_bytes()).expect("an older file");
    assert!(old.moves.iter().all(|m| m.kind == MoveKind::Rapid || m.feed_mm_per_min == old.feed_mm_per_min));
    let newer = text.replacen("\"vanecut_flank\":2", "\"vanecut_flank\":7", 1);
    assert_eq!(read_flank_bytes("f.json", newer.as_bytes()).unwrap_err().code, ErrorCode::NewerFile);
    assert!(read_flank_bytes("f.json", &text.as_bytes()[..text.len() / 2]).is_err());
}

#[test]
#[ignore = "four whole flank plans, 9 s; scripts/nightly runs it"]
fn only_stale_stages_are_planned_again_and_to_the_same_end() {
    let job = FlankJob::default();
    // Few passes.
    let mut request = request("impeller9x9.toml", |setup| {
        (setup.flank.layer_depth, setup.flank.scallop_height) = (20.0, 1.2);
    });
    let first = job.run(&request, &Monitor::default()).expect("a plan");
    request.setup.flank.feed_mm_per_min = Some(900.0);
    let second = job.run(&request, &Monitor::default()).expect("a plan");
    assert!(Arc::ptr_eq(&first.plan.layout, &second.plan.layout), "curves do not depend on the feed");
    assert!(Arc::ptr_eq(&first.plan.walls, &second.plan.walls));
    request.setup.flank.scallop_height = 1.8;
    let third = job.run(&request, &Monitor::default()).expect("a plan");
    assert!(!Arc::ptr_eq(&second.plan.layout, &third.plan.layout));
    assert!(Arc::ptr_eq(&second.plan.walls, &third.plan.walls), "walls do not depend on the error");
    let fresh = planned(&request);
    assert_eq!(fresh.plan.moves.len(), third.plan.moves.len());
    assert!(fresh.plan.moves.iter().zip(&third.plan.moves).all(|(a, b)| a.tip == b.tip && a.axis == b.axis));
}

#[test]
fn walls_no_higher_than_the_corner_of_the_cutter_are_not_called_unmilled() {
    let FlankOutcome { workpiece, setup, plan, .. } = &*BY_REGIONS;
    let mut program = ClProgram::of_flank(&workpiece.part.name, &plan.tool, &plan.moves);
    let judged = |program: &ClProgram| {
        verify_flank(workpiece, setup, program, &Monitor::default()).expect("a verdict")
    };
    // The walls that a few moves leave are enough.
    program.moves.truncate(200);
    assert!(judged(&program).unmilled_walls.iter().all(|share| share.is_finite()));
    for tool in &mut program.tools {
        (tool.diameter, tool.corner_radius) = (50.0, 25.0);
    }
    let verdict = judged(&program);
    assert_eq!(verdict.unmilled_wall_share, 0.0);
    assert!(verdict.unmilled_walls.iter().all(|share| share.is_nan()), "{:?}", verdict.unmilled_walls);
}
