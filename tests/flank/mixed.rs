//! Programs that plunge and mill along curves: cores are held against the stock that both have left.

use std::sync::LazyLock;

use vanecut::geometry::frame_about;
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::setup::{AxisPolicy, SectionKind, SectionSetup, Setup, Tool};
use vanecut::toolpath::{ClProgram, Motion, Move};
use vanecut::verify::{FaultKind, verify_flank};

use super::parts::part_at;

/// Moves of a plunge: rapid, plunge, rapid back.
const PLUNGE: usize = 3;

/// A plan whose cores are free, with one cutter in the outer part of the channel.
static PLAN: LazyLock<PlanOutcome> = LazyLock::new(|| {
    let part = part_at("assets/parts/impeller9x9.toml").into();
    let tool = Tool {
        number: 1,
        diameter: 16.0,
        corner_radius: 0.0,
        insert_width: 5.0,
        overhang: 130.0,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: Default::default(),
    };
    let mut setup = Setup { tools: vec![tool], ..Setup::default() };
    setup.plunge.sections =
        vec![SectionSetup { tool: 1, from: 1.0, to: 0.7, cut_direction: None, kind: SectionKind::Rows }];
    let request = PlanRequest { part, setup, policy: AxisPolicy::Staircase, compare: false, field_cells: 32 };
    run(&request, &Monitor::default()).expect("it can be planned")
});

/// The plunge of a program with this number as a pass: down its axis with small steps to both sides.
fn as_pass(plunge: &[Move]) -> Vec<Move> {
    let (from, to) = (&plunge[0], &plunge[1]);
    let (aside, _) = frame_about(&to.axis);
    let step = |k: i32| {
        let side = if k == 12 { 0.0 } else { 0.05 * f64::from(k % 2) };
        let tip = from.tip + (to.tip - from.tip) * (f64::from(k) / 12.0) + aside * side;
        Move { tip, ..to.clone() }
    };
    [vec![from.clone()], (1..=12).map(step).collect(), vec![plunge[2].clone()]].concat()
}

/// Lines of the plunges whose core meets stock; lines are the numbers of the moves.
fn cores_in_stock(program: &mut ClProgram) -> Vec<usize> {
    for (line, step) in (1..).zip(&mut program.moves) {
        step.line = line;
    }
    assert!(program.mills_along_curves());
    let verdict =
        verify_flank(&PLAN.workpiece, &PLAN.setup, program, &Monitor::default()).expect("it can be checked");
    let cores = verdict.faults.iter().filter(|fault| fault.kind == FaultKind::CoreContact);
    cores.map(|fault| fault.line).collect()
}

#[test]
fn a_core_meets_what_neither_plunges_nor_passes_have_cut() {
    let whole = ClProgram::of_plan("a", &PLAN.after.plan);
    let plunges = whole.moves.len() / PLUNGE;
    assert!(plunges > 6 && whole.moves.len() == PLUNGE * plunges && whole.moves[1].motion != Motion::Rapid);
    let at = |k: usize| &whole.moves[PLUNGE * k..PLUNGE * (k + 1)];
    // A pass in the place of the third plunge frees the cores after it as the plunge did.
    let passed = |without_pass: bool, leads_out: bool| {
        let mut moves = [at(0), at(1)].concat();
        if !without_pass {
            moves.extend(as_pass(at(2)));
        }
        let next = moves.len() + 2;
        moves.extend_from_slice(&at(3)[..2]);
        if leads_out {
            let plunge = &at(3)[1];
            moves.push(Move {
                tip: plunge.tip + plunge.axis * 2.0 + frame_about(&plunge.axis).0,
                ..plunge.clone()
            });
        }
        moves.push(at(3)[2].clone());
        // The pass that makes it a program of both kinds comes late otherwise.
        moves.extend(as_pass(at(4)));
        (ClProgram { moves, ..whole.clone() }, next)
    };
    let (mut program, _) = passed(false, false);
    assert_eq!(cores_in_stock(&mut program), Vec::<usize>::new());
    for leads_out in [false, true] {
        let (mut program, next) = passed(true, leads_out);
        let what = format!("the fourth plunge follows the second, lead-out {leads_out}");
        assert_eq!(cores_in_stock(&mut program), [next], "{what}");
    }
}
