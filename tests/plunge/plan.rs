//! The stages of the planner, compared with brute force on real parts.

use vanecut::cutting::contact::{BlankTop, Columns, PlungeColumn, core_contact};
use vanecut::cutting::drop_cutter::DepthSurface;
use vanecut::geometry::{Meridional, Vector, frame_about, wrap_angle};
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::job::resolve;
use vanecut::monitor::Monitor;
use vanecut::part::{Blank, Impeller, Workpiece};
use vanecut::plunge::lane::Lane;
use vanecut::plunge::row::RowMaker;
use vanecut::plunge::{DropReason, Planner, PlungePlan, SectionCache};
use vanecut::setup::{AxisPolicy, CutDirection, Machine, SectionKind, SectionSetup, Setup, Tool};
use vanecut::toolpath::ClProgram;
use vanecut::verify::{FaultKind, verify};

use super::samples::{SAMPLES, sample, sample_plans};

/// The defaults with the tools and sections for `part`.
fn resolved(part: &Impeller) -> Setup {
    let setup = Setup::default();
    resolve(&setup, &setup.allowances.workpiece_of(part.clone())).expect("fits").setup
}

fn planned(part: &Impeller, setup: &Setup, policy: AxisPolicy) -> (Setup, PlungePlan) {
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let setup = resolve(setup, &workpiece).expect("the setup fits").setup;
    let plan = Planner::new(&workpiece, &setup).plan(policy, &Monitor::default()).expect("a plan");
    (setup, plan)
}

/// The plan of a sample by `policy` with the defaults, with its setup.
fn sample_plan(name: &str, policy: AxisPolicy) -> (&'static Setup, &'static PlungePlan) {
    let outcome = sample_plans(name);
    let result = outcome.policies().into_iter().find(|result| result.plan.policy == policy);
    (&outcome.setup, &result.expect("all policies are planned").plan)
}

/// The maker of a row at `lambda`, cut from outlet to inlet.
fn row_maker<'a>(
    part: &'a Impeller,
    lane: &'a Lane<'a>,
    hub: &'a DepthSurface<'a>,
    tool: &'a Tool,
    lambda: f64,
    monitor: &'a Monitor,
) -> RowMaker<'a> {
    RowMaker { part, lane, hub, tool, lambda, direction_sign: 1.0, step_limit: 7.8, monitor }
}

/// Rows of `conventional`: evenly spaced in s, both ends of each axis at the same s, their angles about Z
/// evenly divided between the axes along the walls. The ends are put together here from hub, shroud and
/// angles.
#[test]
fn isoparametric_axes_end_at_one_s() {
    let workpiece = Setup::default().allowances.workpiece_of(sample("impeller532"));
    let Workpiece { part, channel, .. } = &workpiece;
    let setup = resolve(&Setup::default(), &workpiece).expect("fits").setup;
    let (tool, allowance) = (&setup.tools[0], setup.allowances.hub_allowance);
    let hub = DepthSurface::new(part.hub.curve(), allowance + tool.corner_radius);
    let lane = Lane::new(&workpiece, &channel.full, tool, &setup.allowances);
    let monitor = Monitor::default();
    let maker = |lambda| row_maker(part, &lane, &hub, tool, lambda, &monitor);
    // Beyond the rim both ends move on by the same distance.
    let on_shroud =
        |s: f64| if s <= 1.0 { s } else { 1.0 + (s - 1.0) * part.hub.length() / part.shroud.length() };
    for s in [0.7, 0.85, 1.0, 1.03] {
        let (p, n) = (part.hub.point(s), part.hub.normal(s));
        let m = Meridional { r: p.r + allowance * n.r, z: p.z + allowance * n.z };
        let w = part.shroud.point(on_shroud(s));
        let walls = [0.0, 1.0].map(|lambda| lane.isoparametric(lambda, s).expect("an axis along the wall"));
        let between = |[low, high]: [f64; 2], lambda: f64| low + lambda * wrap_angle(high - low);
        for lambda in [0.0, 0.3, 0.5, 1.0] {
            let station = maker(lambda).isoparametric(s).expect("a station");
            let (foot, head) = match lambda {
                0.0 | 1.0 => (m.at_angle(station.ends.theta_hub), w.at_angle(station.ends.theta_shroud)),
                _ => (
                    m.at_angle(between(walls.map(|ends| ends.theta_hub), lambda)),
                    w.at_angle(between(walls.map(|ends| ends.theta_shroud), lambda)),
                ),
            };
            let off = (station.axis - (head - foot).normalize()).norm();
            assert!(off < 1e-9, "axis off by {off} rad at λ = {lambda}, s = {s}");
            let beside = station.axis.cross(&(station.tip - foot)).norm();
            assert!(
                beside < 1e-9 * foot.coords.norm(),
                "tip {beside} mm beside the axis at λ = {lambda}, s = {s}"
            );
        }
    }
    let row = maker(0.5).conventional(1.0, 0.7).expect("stations");
    let count = (row.len() - 1) as f64;
    for (k, station) in row.iter().enumerate() {
        assert!((station.ends.s_hub - (1.0 - 0.3 * k as f64 / count)).abs() < 1e-9, "station {k}");
        assert!((station.ends.s_shroud - station.ends.s_hub).abs() < 1e-9, "station {k}");
    }
}

/// As in the [plunge paper], walks along the row's shroud curve in steps of 1e-5 of its length until α has
/// grown. The planner solves for the same point by root finding.
#[test]
fn monotone_finds_the_place_the_walk_finds() {
    let part = sample("impeller532");
    let workpiece = Setup::default().allowances.workpiece_of(part);
    let Workpiece { part, channel, .. } = &workpiece;
    let setup = resolve(&Setup::default(), &workpiece).expect("fits").setup;
    let tool = &setup.tools[0];
    let hub = DepthSurface::new(part.hub.curve(), 0.5 + tool.corner_radius);
    let lane = Lane::new(&workpiece, &channel.full, tool, &setup.allowances);
    for lambda in [0.0, 0.5, 1.0] {
        let monitor = Monitor::default();
        let maker = row_maker(part, &lane, &hub, tool, lambda, &monitor);
        let conventional = maker.conventional(1.0, 0.7).expect("stations");
        let row = maker
            .monotone(&conventional, Some(10f64.to_radians()), 1.0, &mut |_| true)
            .expect("nothing refuses it");
        for k in [1, 4, 8] {
            let (before, here) = (&row[k - 1], &row[k]);
            assert!(here.blocked.is_none() && here.alpha_rad > before.alpha_rad, "position {k} grows");
            let moved = here.s_shroud_conventional - here.ends.s_shroud;
            let mut steps = 0;
            loop {
                let amount = 1e-5 * f64::from(steps);
                let s_shroud = here.s_shroud_conventional - amount;
                let draft = maker.draft(here.ends.s_hub, s_shroud).expect("clear of the walls");
                let walked = maker.exact(&draft).expect("clear of its wall");
                if walked.alpha_rad > before.alpha_rad {
                    assert!(
                        (amount - moved).abs() <= 1.1e-5,
                        "row {lambda}, position {k}: solved {moved}, walked {amount}"
                    );
                    break;
                }
                steps += if amount + 2e-4 < moved { 10 } else { 1 };
                assert!(steps < 30_000, "the walk ends");
            }
        }
    }
}

/// Height of stock in a core, mm, by brute force over many points.
fn contact_by_points(column: &PlungeColumn, earlier: &[PlungeColumn], blank: &Blank) -> f64 {
    let (e1, e2) = frame_about(&column.cutter.axis);
    let mut highest = 0.0f64;
    for ring in 0..=16 {
        for turn in 0..120 {
            let (rho, phi) = (
                column.core_radius * f64::from(ring) / 16.0,
                std::f64::consts::TAU * f64::from(turn) / 120.0,
            );
            let foot = column.cutter.tip + (e1 * phi.cos() + e2 * phi.sin()) * rho;
            let mut h = 0.0025;
            while h < column.top.min(120.0) {
                let p = foot + column.cutter.axis * h;
                let stock = h > highest
                    && blank.depth(Meridional::from_point(&p)) > 0.0
                    && !earlier.iter().any(|e| e.cutter.distance(&p) < 0.0);
                if stock {
                    highest = highest.max(h);
                }
                h += if h < 4.0 { 0.05 } else { 0.6 };
            }
        }
    }
    highest
}

#[test]
fn contact_agrees_with_many_points() {
    let part = sample("impeller532");
    let blank = Blank::from_part(&part, 0.0);
    let top = BlankTop::new(&blank);
    for policy in [AxisPolicy::Conventional, AxisPolicy::Monotone] {
        let (_, plan) = sample_plan("impeller532", policy);
        let columns: Columns = plan
            .positions
            .iter()
            .map(|p| {
                let tool = &plan.sections[p.section].tool;
                PlungeColumn::new(tool.placed(p.tip, p.axis), tool.core_radius(), &top)
            })
            .collect();
        for k in (3..plan.positions.len()).step_by(57) {
            let column = &columns.as_slice()[k];
            let exact = core_contact(column, columns.before(k), &blank);
            assert_eq!(
                exact, plan.positions[k].evaluation.contact,
                "the plan tells the truth of position {k}"
            );
            // Only neighbours can matter; brute force over all plunges would take minutes.
            let near: Vec<PlungeColumn> = columns.as_slice()[..k]
                .iter()
                .filter(|c| (c.cutter.tip - column.cutter.tip).norm() < 60.0)
                .copied()
                .collect();
            let seen = contact_by_points(column, &near, &blank);
            let tolerance = if seen < 4.0 { 0.08 } else { 0.7 };
            assert!(
                seen <= exact.depth + 1e-6 && exact.depth - seen < tolerance,
                "{policy:?} position {k}: exact {}, by points {seen}",
                exact.depth
            );
        }
    }
}

#[test]
fn plans_hold_their_allowances_on_all_samples() {
    for name in SAMPLES {
        for policy in [AxisPolicy::Conventional, AxisPolicy::Monotone] {
            let (setup, plan) = sample_plan(name, policy);
            assert!(plan.converged && !plan.positions.is_empty(), "{name} settles");
            for (k, p) in plan.positions.iter().enumerate() {
                let stock = &setup.allowances;
                assert!(p.hub_clearance >= stock.hub_allowance - 1e-3, "{name} {k}: hub {}", p.hub_clearance);
                assert!(
                    p.blade_clearance >= stock.blade_allowance - 1e-3,
                    "{name} {k}: blade {}",
                    p.blade_clearance
                );
                assert!(
                    p.evaluation.retract_clearance >= stock.safety_distance - 1e-3,
                    "{name} {k}: retract {}",
                    p.evaluation.retract_clearance
                );
            }
            let outlet =
                plan.positions.iter().filter(|p| p.section == 0 && p.evaluation.contact.interferes()).count();
            if policy == AxisPolicy::Conventional {
                assert!(outlet > 0, "{name}: the conventional plan interferes at the outlet");
            } else {
                assert_eq!(outlet, 0, "{name}: monotone repairs the outlet");
            }
        }
    }
}

#[test]
fn paper_a_s_wheel_is_repaired_in_all_three_sections() {
    let count = |plan: &PlungePlan, section: usize| {
        plan.positions.iter().filter(|p| p.section == section && p.evaluation.contact.interferes()).count()
    };
    let (setup, before) = sample_plan("impeller532", AxisPolicy::Conventional);
    let (_, after) = sample_plan("impeller532", AxisPolicy::Monotone);
    assert_eq!(
        setup.plunge.sections.iter().filter(|section| section.kind == SectionKind::Rows).count(),
        3,
        "three tools"
    );
    for section in 0..3 {
        assert!(count(before, section) > 0, "section {section} interferes before");
        assert_eq!(count(after, section), 0, "section {section} is free after");
    }
}

#[test]
fn rows_may_be_cut_outwards_and_corners_rounded() {
    let part = sample("impeller532");
    let mut setup = resolved(&part);
    for tool in &mut setup.tools {
        tool.corner_radius = 0.8;
    }
    let tool = setup.tools.last().expect("tools").number;
    setup.plunge.sections = vec![SectionSetup {
        tool,
        from: 0.4,
        to: 0.0,
        cut_direction: Some(CutDirection::InletToOutlet),
        kind: SectionKind::Rows,
    }];
    let (_, plan) = planned(&part, &setup, AxisPolicy::Monotone);
    let first_row: Vec<_> = plan.positions.iter().filter(|p| p.row == 0).collect();
    assert!(first_row.windows(2).all(|w| w[1].s > w[0].s), "rows run from inlet to outlet");
    assert!(first_row[0].s < 0.0, "the row starts outside the leading edge");
    for p in &plan.positions {
        assert!(p.hub_clearance >= 0.5 - 1e-3 && p.blade_clearance >= 0.5 - 1e-3, "clear: {p:?}");
    }
}

#[test]
fn the_same_input_gives_the_same_plan() {
    let part = sample("pump6");
    let (_, a) = planned(&part, &Setup::default(), AxisPolicy::Monotone);
    let (_, b) = planned(&part, &Setup::default(), AxisPolicy::Monotone);
    assert!(a == b, "planning is deterministic");
}

#[test]
fn a_cancelled_plan_says_so() {
    let workpiece = Setup::default().allowances.workpiece_of(sample("pump6"));
    let setup = resolve(&Setup::default(), &workpiece).expect("fits").setup;
    let monitor = Monitor::default();
    monitor.cancel();
    let result = Planner::new(&workpiece, &setup).plan(AxisPolicy::Monotone, &monitor);
    assert!(result.is_err_and(|e| e.to_string() == "cancelled"), "no plan after a cancel");
}

#[test]
#[ignore = "two plans of a sample, 8 s; scripts/nightly runs it"]
fn axes_stay_within_what_the_machine_reaches() {
    let part = sample("impeller532");
    let free = &sample_plans("impeller532").after.plan;
    let tilt = |axis: &Vector| axis.angle(&part.out_of_inlet());
    let steepest = free.positions.iter().map(|p| tilt(&p.axis)).fold(0.0, f64::max);
    let limit = steepest - 4f64.to_radians();
    let setup = Setup { machine: Machine { file: None, max_axis_tilt_rad: limit }, ..Setup::default() };
    let (setup, held) = planned(&part, &setup, AxisPolicy::Minimal);
    assert!(held.positions.iter().all(|p| tilt(&p.axis) <= limit + 1e-9), "none is tilted further");
    assert!(held.positions.len() * 2 > free.positions.len(), "and most of the floor is still cut");
    assert!(held.positions.iter().all(|p| !p.evaluation.contact.interferes()));
    let beyond = |plan: &PlungePlan, setup: &Setup| {
        let text = write_apt(&ClProgram::of_plan(&part.name, plan));
        let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("a program");
        let verdict =
            verify(&setup.allowances.workpiece_of(part.clone()), setup, &program, &Monitor::default())
                .expect("a verdict");
        verdict.faults.iter().filter(|fault| fault.kind == FaultKind::AxisTilt).count()
    };
    assert_eq!(beyond(&held, &setup), 0);
    assert!(beyond(free, &setup) > 0, "the plan that knows no machine is refused");
}

#[test]
fn what_is_left_out_for_the_machine_is_not_said_to_be_in_the_way_of_blades() {
    let machine = Machine { file: None, max_axis_tilt_rad: 20f64.to_radians() };
    let (_, plan) =
        planned(&sample("impeller9x9"), &Setup { machine, ..Setup::default() }, AxisPolicy::Minimal);
    let dropped = |why| plan.dropped.iter().filter(|drop| drop.why == why).count();
    let [machine, blades] = [DropReason::Machine, DropReason::Blades].map(dropped);
    assert!(machine > 100 && blades == 0, "{machine} for the machine, {blades} for blades");
}

#[test]
fn axes_that_were_found_are_carried_into_an_edited_setup_at_once() {
    let monitor = Monitor::default();
    for name in ["impeller9x9"] {
        let part = sample(name);
        let mut setup = resolved(&part);
        let mut known = SectionCache::default();
        let workpiece = setup.allowances.workpiece_of(part.clone());
        let nothing = Planner::new(&workpiece, &setup).warm_start(AxisPolicy::Minimal, &known, &monitor);
        assert_eq!(nothing, Ok(None), "no plan was there before");
        let found = Planner::new(&workpiece, &setup).plan_cached(AxisPolicy::Minimal, &mut known, &monitor);
        let found = found.expect("a plan");
        setup.allowances.hub_allowance += 0.2;
        setup.allowances.blade_allowance += 0.1;
        let planner = Planner::new(&workpiece, &setup);
        let carried =
            planner.warm_start(AxisPolicy::Minimal, &known, &monitor).expect("a plan").expect("known");
        // Beside walls, a larger allowance makes some plunges impossible.
        let kept = carried.positions.len() as f64 / found.positions.len() as f64;
        assert!(
            kept > 0.8 && carried.positions.len() <= found.positions.len(),
            "{name}: {kept} of them are there"
        );
        for position in &carried.positions {
            assert!(
                !position.evaluation.contact.interferes(),
                "{name}: {} of contact",
                position.evaluation.contact.depth
            );
            assert!(position.hub_clearance >= setup.allowances.hub_allowance - 1e-6, "{name}: hub");
            assert!(position.blade_clearance >= setup.allowances.blade_allowance - 1e-6, "{name}: blades");
            assert!(
                position.evaluation.retract_clearance >= setup.allowances.safety_distance - 1e-6,
                "{name}: retract"
            );
        }
        // A stopped plan does not replace the complete one: the warm start still uses that.
        let stopped = Monitor::default();
        stopped.cancel();
        assert!(planner.plan_cached(AxisPolicy::Minimal, &mut known, &stopped).is_err());
        assert_eq!(planner.warm_start(AxisPolicy::Minimal, &known, &monitor), Ok(Some(carried)), "{name}");
        // Axes of another cutter are not reused.
        setup.tools[0].diameter *= 0.9;
        let planner = Planner::new(&workpiece, &setup);
        assert_eq!(planner.warm_start(AxisPolicy::Minimal, &known, &monitor), Ok(None), "{name}");
    }
}

#[test]
fn only_stale_sections_are_planned_again_and_the_plan_is_the_same() {
    let part = sample("impeller532");
    let mut setup = resolved(&part);
    let sections = setup.plunge.sections.len();
    assert!(sections >= 2);
    let monitor = Monitor::default();
    let mut known = SectionCache::default();
    let mut held = |setup: &Setup| -> (usize, PlungePlan) {
        let holding = known.valid_prefix(setup).expect("tools");
        let workpiece = setup.allowances.workpiece_of(part.clone());
        let planner = Planner::new(&workpiece, setup);
        let plan = planner.plan_cached(AxisPolicy::Monotone, &mut known, &monitor).expect("a plan");
        assert_eq!(plan, planner.plan(AxisPolicy::Monotone, &monitor).expect("a plan"), "as from scratch");
        (holding, plan)
    };
    assert_eq!(held(&setup).0, 0);

    setup.allowances.safety_distance = 5.0;
    setup.tools[0].plunge_feed = 111.0;
    let (holding, higher) = held(&setup);
    assert_eq!(holding, sections, "nothing that cuts has changed");
    assert!(higher.positions.iter().all(|p| p.evaluation.retract_clearance >= 5.0 - 1e-6), "but links have");

    // The last section mills the rest of another one, and no longer along all of it: that one takes more
    // itself.
    let last = setup.plunge.sections[sections - 1].clone();
    let covered = setup.plunge.sections.iter().position(|section| section.to == last.to).expect("itself");
    assert!(last.kind == SectionKind::Rest && covered < sections - 1, "{:?}", setup.plunge.sections);
    setup.plunge.sections[sections - 1].to += 0.03;
    assert_eq!(held(&setup).0, covered, "an end moved");
    setup.plunge.sections[0].to += 0.05;
    setup.plunge.sections[1].from += 0.05;
    assert_eq!(held(&setup).0, 0, "a border moved");
    setup.allowances.hub_allowance = 0.7;
    assert_eq!(held(&setup).0, 0, "another allowance");
    setup.plunge.sections.pop();
    assert_eq!(held(&setup).0, sections - 1, "a section less");
}

/// Rows that begin within stock find no free core. What is cut behind them is not planned in vain, and where
/// it is wanted all the same, the plan is the one that was made at once.
#[test]
#[ignore = "three plans, 8 s; scripts/nightly runs it"]
fn a_plan_may_end_where_its_rows_starve() {
    let part = sample("impeller532");
    let mut setup = resolved(&part);
    let rows = |tool, from, to| {
        let cut_direction = Some(CutDirection::OutletToInlet);
        SectionSetup { tool, from, to, cut_direction, kind: SectionKind::Rows }
    };
    let tools = [0, 1, 2].map(|index| setup.tools[index].number);
    setup.plunge.sections =
        vec![rows(tools[0], 1.0, 0.9), rows(tools[1], 0.4, 0.3), rows(tools[2], 0.3, 0.2)];
    let (workpiece, monitor) = (setup.allowances.workpiece_of(part.clone()), Monitor::default());
    let planner = || Planner::new(&workpiece, &setup);
    let mut known = SectionCache::default();
    let ended = planner().ending_where_starved().plan_cached(AxisPolicy::Minimal, &mut known, &monitor);
    let ended = ended.expect("a plan");
    let unfinished: Vec<bool> = ended.sections.iter().map(|section| section.is_unfinished()).collect();
    assert_eq!(unfinished, [false, false, true], "{:?}", ended.sections);
    let count = |section| ended.positions.iter().filter(|p| p.section == section).count();
    assert!(count(0) > 20 && count(1) < 10 && count(2) == 0, "{} and {} plunges", count(0), count(1));
    let whole = planner().plan_cached(AxisPolicy::Minimal, &mut known, &monitor).expect("a plan");
    assert!(!whole.is_unfinished());
    assert_eq!(whole, planner().plan(AxisPolicy::Minimal, &monitor).expect("a plan"), "as from scratch");
    // Only a search of `minimal` finds no place; other policies place every row.
    let monotone = planner().ending_where_starved().plan(AxisPolicy::Monotone, &monitor).expect("a plan");
    assert!(!monotone.is_unfinished());
}
