//! Plans that were edited by hand: plunges left out, lifted, moved, locked, and cut in another order.

use std::f64::consts::PI;
use std::sync::{LazyLock, Mutex};

use vanecut::geometry::Vector;
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::setup_file::{read_setup_bytes, write_setup};
use vanecut::job::{JobError, Listener, PlanJob, PlanOutcome, PlanRequest, PlanStage};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::plunge::{Breach, Planner, PlungeMark, PlungePlan, Position, UnappliedReason};
use vanecut::setup::edits::add_edit;
use vanecut::setup::{PlungeChange, PlungeEdit, PlungeMove, PlungePose, Setup};
use vanecut::toolpath::ClProgram;
use vanecut::verify::verify;

use super::samples::sample;

/// Rough settings, so that the plan is small.
const SETUP: &str = "[[tool]]\nnumber = 1\ndiameter = 20\ninsert_width = 6\noverhang = 90\n\
                     [plunge]\naxis = \"staircase\"\nrest = false\n\
                     [[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.55\n";

static PART: LazyLock<std::sync::Arc<Impeller>> = LazyLock::new(|| sample("pump6").into());
/// One job for all, so that edits are planned as in the window.
static JOB: LazyLock<PlanJob> = LazyLock::new(PlanJob::default);
/// The plan without edits.
static FOUND: LazyLock<PlanOutcome> = LazyLock::new(|| planned(&setup(SETUP), &[]).expect("a plan"));

fn setup(text: &str) -> Setup {
    read_setup_bytes("s.toml", text.as_bytes()).expect("a setup")
}

fn planned(setup: &Setup, edits: &[PlungeEdit]) -> Result<PlanOutcome, JobError> {
    let mut setup = setup.clone();
    setup.plunge.edits = edits.to_vec();
    JOB.run(&request(setup), &Monitor::default())
}

fn request(setup: Setup) -> PlanRequest {
    let policy = setup.plunge.axis;
    PlanRequest { part: PART.clone(), setup, policy, compare: false, field_cells: 96 }
}

fn pose(position: &Position) -> PlungePose {
    PlungePose { tip: position.tip, axis: position.axis }
}

/// The edit of plunge `k` of the plan without edits.
fn edit(k: usize, change: PlungeChange) -> PlungeEdit {
    PlungeEdit { plunge: pose(&FOUND.after.plan.positions[k]), whole_row: false, change }
}

/// The plan with these edits.
fn edited(edits: &[PlungeEdit]) -> PlanOutcome {
    planned(&setup(SETUP), edits).expect("a plan")
}

/// Number of the first plunge of row `row` of the plan without edits, and of its plunges.
fn row(row: usize) -> (usize, usize) {
    let of_row = |position: &&Position| position.row == row;
    let positions = &FOUND.after.plan.positions;
    let first = positions.iter().position(|position| of_row(&position)).expect("a row");
    (first, positions.iter().filter(of_row).count())
}

/// The goal leaves some plunges of `minimal` out: retracts and links are those of what is left.
#[test]
fn a_lock_of_what_the_plan_has_changes_nothing() {
    let setup = setup(&SETUP.replace("staircase", "minimal").replace("0.55", "0.8"));
    let found = planned(&setup, &[]).expect("a plan");
    assert!(
        found
            .whole
            .as_ref()
            .is_some_and(|whole| { whole.positions.len() > found.after.plan.positions.len() })
    );
    let change = PlungeChange::Lock { tool: 1, lift: 0.0 };
    let plunge = pose(&found.after.plan.positions[5]);
    let locked = planned(&setup, &[PlungeEdit { plunge, whole_row: false, change }]).expect("a plan");
    assert_eq!(locked.edits.mark(5), PlungeMark::Locked(0));
    for (a, b) in found.after.plan.positions.iter().zip(&locked.after.plan.positions) {
        assert_eq!((a.tip, a.axis, a.evaluation.retract), (b.tip, b.axis, b.evaluation.retract));
    }
    assert_eq!(found.after.summary.time_estimate, locked.after.summary.time_estimate);
}

#[test]
fn a_deleted_plunge_is_gone_and_what_stays_is_measured_again() {
    let found = &FOUND.after;
    // In the middle of the first row: the core of the next one needs its cut.
    let (first, count) = row(0);
    let k = first + count / 2;
    let outcome = edited(&[edit(k, PlungeChange::Delete)]);
    let plan = &outcome.after.plan;
    assert_eq!(plan.positions.len(), found.plan.positions.len() - 1);
    assert!(!plan.positions.iter().any(|p| pose(p).is(&pose(&found.plan.positions[k]))));
    assert!(
        plan.positions[k].evaluation.contact.depth > found.plan.positions[k + 1].evaluation.contact.depth,
        "the next plunge meets what the deleted one would have cut"
    );
    assert!(outcome.after.summary.time_estimate < found.summary.time_estimate);
    assert!(outcome.edits.unapplied.is_empty());
}

#[test]
fn a_row_goes_as_a_whole() {
    let (first, count) = row(1);
    let rows = FOUND.after.plan.sections[0].rows;
    let delete = PlungeEdit { whole_row: true, ..edit(first + 1, PlungeChange::Delete) };
    let plan = edited(&[delete]).after.plan;
    assert_eq!(plan.positions.len(), FOUND.after.plan.positions.len() - count);
    assert_eq!(plan.sections[0].rows, rows - 1);
    assert_eq!(plan.positions.last().expect("some").row, rows - 2, "rows are counted anew");
}

#[test]
fn a_lifted_plunge_stops_short_by_so_much() {
    let outcome = edited(&[edit(3, PlungeChange::Lift(1.5))]);
    let (before, after) = (&FOUND.after.plan.positions[3], &outcome.after.plan.positions[3]);
    assert!((after.tip - before.tip - before.axis * 1.5).norm() < 1e-9);
    assert!((after.lift - before.lift - 1.5).abs() < 1e-9);
    assert!(after.hub_clearance > before.hub_clearance + 0.5);
    assert!((after.alpha_rad - before.alpha_rad).abs() < 1e-3, "its axis is the same");
    assert!((after.s - before.s).abs() < 0.02 && (after.lambda - before.lambda).abs() < 0.1);
    assert_eq!(outcome.edits.mark(3), PlungeMark::Edited);
    assert_eq!(outcome.edits.mark(4), PlungeMark::Planned);
    assert!(outcome.after.summary.residual_mean > FOUND.after.summary.residual_mean);
}

#[test]
fn a_moved_plunge_ends_on_the_allowance_where_it_was_moved_to() {
    // Conventional plunges are not lifted.
    let setup = setup(&SETUP.replace("staircase", "conventional"));
    let found = planned(&setup, &[]).expect("a plan");
    let allowance = found.setup.allowances.hub_allowance;
    let positions = &found.after.plan.positions;
    let first = positions.iter().position(|position| position.row == 1).expect("a second row");
    let k = first + 8;
    let before = &positions[k];
    assert_eq!(before.row, 1);
    let moved = |by: PlungeMove| {
        let edit = PlungeEdit { plunge: pose(before), whole_row: false, change: PlungeChange::Move(by) };
        planned(&setup, &[edit]).expect("a plan").after.plan.positions[k].clone()
    };
    let along = moved(PlungeMove { along: 3.0, ..PlungeMove::default() });
    assert!((along.axis - before.axis).norm() < 1e-9, "it is not turned");
    let (shift, inwards) = ((along.contact_point - before.contact_point).norm(), before.s - along.s);
    assert!((1.5..4.5).contains(&shift) && inwards > 0.0, "{shift} mm, {inwards} of s towards the inlet");
    // λ of a moved plunge is the share of the channel, that of a row the share between the rows at its walls.
    let lambda = moved(PlungeMove { lead_rad: 1e-9, ..PlungeMove::default() }).lambda;
    assert!((along.lambda - lambda).abs() < 0.02, "along the channel: λ {} after {lambda}", along.lambda);
    let across = moved(PlungeMove { across: 1.0, ..PlungeMove::default() });
    assert!(across.lambda > lambda, "{} after {lambda}", across.lambda);
    for position in [&along, &across] {
        let stands = position.hub_clearance;
        assert!((allowance - 1e-6..allowance + 0.05).contains(&stands), "{stands} mm above the hub");
    }
    let turn = 2f64.to_radians();
    let led = moved(PlungeMove { lead_rad: turn, ..PlungeMove::default() });
    assert!((led.axis.angle(&before.axis) - turn).abs() < 1e-3);
    assert!((led.alpha_rad - before.alpha_rad - turn).abs() < 0.005, "towards the inlet");
    let tilted = moved(PlungeMove { tilt_rad: turn, ..PlungeMove::default() });
    assert!((tilted.axis.angle(&before.axis) - turn).abs() < 1e-3);
    let turned_plane: Vector = led.axis - before.axis;
    let other: Vector = tilted.axis - before.axis;
    assert!((turned_plane.angle(&other) - 0.5 * PI).abs() < 0.1, "across the channel");
}

#[test]
fn a_plunge_cuts_before_another_and_a_row_last() {
    let found = &FOUND.after.plan;
    let later = edit(5, PlungeChange::Reorder(Some(pose(&found.positions[2]))));
    let plan = edited(&[later]).after.plan;
    let order: Vec<usize> = plan.positions[..7]
        .iter()
        .map(|p| found.positions.iter().position(|q| pose(q).is(&pose(p))).expect("the same plunges"))
        .collect();
    assert_eq!(order, [0, 1, 5, 2, 3, 4, 6]);
    let (_, count) = row(0);
    let last = PlungeEdit { whole_row: true, ..edit(0, PlungeChange::Reorder(None)) };
    let plan = edited(&[last]).after.plan;
    assert!(pose(&plan.positions[0]).is(&pose(&found.positions[count])), "the second row is first");
    let end = plan.positions.len();
    assert!(pose(&plan.positions[end - count]).is(&pose(&found.positions[0])));
    assert_eq!(plan.positions[end - 1].row, plan.sections[0].rows - 1);
}

#[test]
fn a_locked_plunge_survives_another_setup_and_other_edits_wait_for_theirs() {
    let lifted = edit(3, PlungeChange::Lift(0.8));
    let at = lifted.plunge.lifted(0.8);
    let lock = PlungeChange::Lock { tool: 1, lift: FOUND.after.plan.positions[3].lift + 0.8 };
    let edits =
        [lifted, PlungeEdit { plunge: at, whole_row: false, change: lock }, edit(6, PlungeChange::Delete)];
    let outcome = edited(&edits);
    assert_eq!(outcome.edits.mark(3), PlungeMark::Locked(1));
    assert!(outcome.edits.unapplied.is_empty());
    let mut other = setup(SETUP);
    other.plunge.step = Some(3.1);
    let found = planned(&other, &[]).expect("a plan").after.plan;
    assert!(!found.positions.iter().any(|p| pose(p).is(&at)), "the planner does not find it");
    let outcome = planned(&other, &edits).expect("a plan");
    let plan = &outcome.after.plan;
    let k = plan.positions.iter().position(|p| pose(p).is(&at)).expect("it is kept");
    assert_eq!(outcome.edits.mark(k), PlungeMark::Locked(1));
    assert_eq!(plan.positions.len(), found.positions.len(), "in place of the plunge that was there");
    assert_eq!(plan.positions[k].row, plan.positions[k + 1].row);
    let [first, second] = outcome.edits.unapplied[..] else { panic!("two are for plunges of another plan") };
    assert_eq!((first.index, second.index), (0, 2));
    let near = second.nearest.expect("another plunge");
    let distance = (plan.positions[near.index].tip - edits[2].plunge.tip).norm();
    assert!(distance > 0.0 && (distance - near.distance).abs() < 1e-12, "{distance} mm");
    let nearer = plan.positions.iter().any(|p| (p.tip - edits[2].plunge.tip).norm() < distance);
    assert!(!nearer, "no other is nearer");
    let reason = second.reason(|mm| format!("{mm:.1} mm"));
    assert!(reason.starts_with("the plan has no plunge there: the nearest is position "), "{reason}");
    assert!(reason.ends_with(&format!(", {distance:.1} mm off")), "{reason}");
    let back = edited(&edits);
    assert!(back.edits.unapplied.is_empty(), "they fit again");
}

/// A plunge that is locked where the planner does not place one leaves other stock than the planner's own:
/// without regard to that the next core would meet it.
#[test]
fn others_are_planned_around_a_locked_plunge() {
    let mut other = setup(SETUP);
    other.plunge.step = Some(4.7);
    let found = planned(&other, &[]).expect("a plan");
    let of_row = found.after.plan.positions.iter().filter(|position| position.row == 0).count();
    // In the middle of the first row, far above the floor.
    let (own, up) = (&found.after.plan.positions[of_row / 2], 12.0);
    let at = pose(own).lifted(up);
    let change = PlungeChange::Lock { tool: 1, lift: own.lift + up };
    let lock = PlungeEdit { plunge: at, whole_row: false, change };
    let interfering = |plan: &PlungePlan| {
        let others = plan.positions.iter().filter(|p| !pose(p).is(&at));
        others.filter(|p| p.evaluation.contact.interferes()).count()
    };
    assert_eq!(interfering(&found.after.plan), 0);
    let planner = Planner::new(&found.workpiece, &found.setup);
    let (put_in, report) =
        planner.edit_plunges(&found.after.plan, &[lock], &Monitor::default()).expect("not cancelled");
    assert!(
        report.adds_locked && interfering(&put_in) > 0,
        "the core of the next plunge meets what it leaves"
    );

    let outcome = planned(&other, &[lock]).expect("a plan");
    let plan = &outcome.after.plan;
    let k = plan.positions.iter().position(|p| pose(p).is(&at)).expect("it is kept");
    assert_eq!(outcome.edits.marks.iter().filter(|mark| mark.is_locked()).count(), 1);
    assert!(outcome.edits.mark(k).is_locked());
    assert_eq!(interfering(plan), 0, "the others stop short of what it leaves");
    let again = planned(&other, &[lock]).expect("a plan");
    assert_eq!(again.after.plan, *plan, "from the cache");
    let read = read_setup_bytes(
        "s.toml",
        write_setup(&Setup { plunge: again.setup.plunge.clone(), ..other.clone() }).as_bytes(),
    );
    let fresh = vanecut::job::run(&request(read.expect("a setup")), &Monitor::default()).expect("a plan");
    assert_eq!(fresh.after.plan.positions.len(), plan.positions.len());
    assert_eq!(fresh.after.summary.interfering, outcome.after.summary.interfering);
}

/// What is shown while that plan is made is not the one without the locked plunge.
#[test]
fn the_plan_around_a_locked_plunge_is_reported_as_it_is_made() {
    let own = &FOUND.after.plan.positions[4];
    let at = pose(own).lifted(0.35);
    let change = PlungeChange::Lock { tool: 1, lift: own.lift + 0.35 };
    let mut setup = setup(SETUP);
    setup.plunge.edits = vec![PlungeEdit { plunge: at, whole_row: false, change }];
    let policy = setup.plunge.axis;
    let stages: Mutex<Vec<(bool, bool)>> = Mutex::default();
    let listen = |stage: PlanStage| {
        let (is_checked, poses) = match &stage {
            PlanStage::Placed(plan) if plan.policy == policy => {
                (false, plan.positions.iter().map(|p| PlungePose { tip: p.tip, axis: p.axis }).collect())
            }
            PlanStage::Evaluated(plan) if plan.policy == policy => {
                (true, plan.positions.iter().map(pose).collect::<Vec<_>>())
            }
            _ => return,
        };
        let holds = poses.iter().any(|pose| pose.is(&at));
        stages.lock().expect("no panic").push((is_checked, holds));
    };
    let job = PlanJob::default();
    job.run_with_listener(&request(setup), &Monitor::default(), Listener::new(&listen)).expect("a plan");
    let stages = stages.into_inner().expect("no panic");
    assert_eq!(stages, [(false, false), (true, false), (false, true), (true, true)]);
}

#[test]
fn an_edit_that_cannot_be_applied_says_why() {
    let target = pose(&FOUND.after.plan.positions[2]);
    let here = |change| edit(5, change);
    let lost = target.lifted(0.5);
    let row = |k, change| PlungeEdit { whole_row: true, ..edit(k, change) };
    let first = pose(&FOUND.after.plan.positions[0]);
    let edits = [
        here(PlungeChange::Reorder(Some(lost))),
        row(1, PlungeChange::Reorder(Some(first))),
        PlungeEdit { plunge: lost, whole_row: false, change: PlungeChange::Lock { tool: 7, lift: 0.0 } },
        PlungeEdit { plunge: lost, whole_row: false, change: PlungeChange::Delete },
    ];
    let outcome = edited(&edits);
    let why: Vec<UnappliedReason> = outcome.edits.unapplied.iter().map(|edit| edit.why).collect();
    assert_eq!(
        why,
        [
            UnappliedReason::NoTarget,
            UnappliedReason::OwnRow,
            UnappliedReason::NoTool(7),
            UnappliedReason::NoPlunge
        ]
    );
    let near = outcome.edits.unapplied[3].nearest.expect("another plunge");
    assert_eq!(near.index, 2);
    assert!((near.distance - 0.5).abs() < 1e-9);
    assert!(outcome.edits.unapplied[2].reason(|mm| mm.to_string()).contains("tool 7"));
}

#[test]
fn what_is_far_from_every_plunge_is_locked_in_addition() {
    let far = edit(0, PlungeChange::Lock { tool: 1, lift: 0.0 }).plunge.lifted(40.0);
    let lock =
        |tool| PlungeEdit { plunge: far, whole_row: false, change: PlungeChange::Lock { tool, lift: 0.0 } };
    let outcome = edited(&[lock(1)]);
    assert_eq!(outcome.after.plan.positions.len(), FOUND.after.plan.positions.len() + 1);
    let outcome = edited(&[lock(7)]);
    assert_eq!(outcome.after.plan.positions.len(), FOUND.after.plan.positions.len());
    assert_eq!(outcome.edits.unapplied_indices(), [0], "no section has tool 7");
}

#[test]
fn edits_go_through_a_setup_file_and_a_fresh_planner() {
    let mut edits = Vec::new();
    add_edit(&mut edits, edit(3, PlungeChange::Lift(0.4)));
    let by = PlungeMove { along: 0.7, lead_rad: 0.02, ..PlungeMove::default() };
    add_edit(&mut edits, edit(5, PlungeChange::Move(by)));
    add_edit(&mut edits, edit(8, PlungeChange::Delete));
    let here = edited(&edits);
    let mut setup = setup(SETUP);
    setup.plunge.edits = edits;
    let read = read_setup_bytes("s.toml", write_setup(&setup).as_bytes()).expect("a setup");
    let fresh = vanecut::job::run(&request(read), &Monitor::default()).expect("a plan");
    assert_eq!(fresh.after.plan, here.after.plan);
    assert_eq!(fresh.before.plan, FOUND.before.plan, "the conventional plan has no edits");
}

#[test]
fn a_plan_without_plunges_is_refused() {
    let delete = |k| PlungeEdit { whole_row: true, ..edit(k, PlungeChange::Delete) };
    let rows = FOUND.after.plan.sections[0].rows;
    let edits: Vec<PlungeEdit> = (0..rows).map(|r| delete(row(r).0)).collect();
    let Err(JobError::Setup(fault)) = planned(&setup(SETUP), &edits) else { panic!("a plan of nothing") };
    assert!(fault.message.contains("every plunge"), "{fault}");
}

/// No way up its axis frees a tool that points into the part: it is not moved up on and on, and the lack of
/// clearance is reported.
#[test]
fn a_plunge_that_cannot_retract_stays_near_the_part_and_is_reported() {
    let lock = PlungeEdit {
        plunge: PlungePose { tip: vanecut::geometry::Point::new(60.0, 0.0, -40.0), axis: Vector::z() },
        whole_row: false,
        change: PlungeChange::Lock { tool: 1, lift: 0.0 },
    };
    let outcome = edited(&[lock]);
    let (plan, summary) = (&outcome.after.plan, &outcome.after.summary);
    let farthest = plan.positions.iter().map(|p| p.evaluation.retract.coords.norm()).fold(0.0, f64::max);
    let (radius, _) = outcome.workpiece.blank.extent();
    assert!(farthest < 40.0 * radius, "{farthest} mm away");
    assert!(summary.min_retract_clearance < outcome.setup.allowances.safety_distance);
}

/// What the planner places keeps shank and holder clear; an edit may not: then the plan says what `verify`
/// finds.
#[test]
fn a_shank_that_an_edit_brings_too_near_is_a_fault_of_its_plunge() {
    let bare = planned(&setup(&SETUP.replace("overhang = 90", "overhang = 45")), &[]).expect("a plan");
    let with_shank = "overhang = 45\nflute_length = 16\nshank = [[20, 29]]\nholder = [[30, 30, 60]]";
    let setup = setup(&SETUP.replace("overhang = 90", with_shank));
    let found = planned(&setup, &[]).expect("a plan");
    let of_assembly = |outcome: &PlanOutcome| {
        let program = ClProgram::of_plan("wheel", &outcome.after.plan);
        let program = read_apt_bytes("p.apt", write_apt(&program).as_bytes()).expect("reads");
        let verdict = verify(&outcome.workpiece, &outcome.setup, &program, &Monitor::default());
        verdict.expect("judged").faults.iter().any(|fault| fault.kind.is_of_assembly())
    };
    let breach = |outcome: &PlanOutcome| {
        outcome.after.plan.positions.iter().find_map(|position| position.evaluation.breach)
    };
    assert_eq!((of_assembly(&found), breach(&found)), (false, None));
    // Plunges that the planner leaves out for the shank, and others, are locked where they are without one.
    let places = |outcome: &PlanOutcome| outcome.after.plan.positions.iter().map(pose).collect::<Vec<_>>();
    let (all, kept) = (places(&bare), places(&found));
    let left_out: Vec<&PlungePose> = all.iter().filter(|at| !kept.iter().any(|kept| kept.is(at))).collect();
    let (mut clear, mut near) = (0, 0);
    for &&plunge in left_out.iter().step_by(left_out.len() / 8) {
        let change = PlungeChange::Lock { tool: 1, lift: 0.0 };
        let outcome = planned(&setup, &[PlungeEdit { plunge, whole_row: false, change }]).expect("a plan");
        match breach(&outcome) {
            None => clear += 1,
            Some(Breach::Shank) => near += 1,
            Some(other) => panic!("{other:?}"),
        }
        assert_eq!(breach(&outcome).is_some(), of_assembly(&outcome), "{plunge:?}");
    }
    assert!(near > 1 && clear > 1, "{near} and {clear} edits");
}
