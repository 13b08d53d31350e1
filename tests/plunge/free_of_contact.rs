//! Plans that must be free of contact: `minimal` and `staircase`, on the samples and on random wheels,
//! checked by `verify` from the written program.

use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::part_file::read_part_bytes;
use vanecut::job::{PlanOutcome, PlanRequest, PolicyResult, Summary, run};
use vanecut::monitor::Monitor;
use vanecut::part::{Channel, Impeller};
use vanecut::setup::{AxisPolicy, SectionKind, SectionSetup, Setup, Tool};
use vanecut::toolpath::ClProgram;
use vanecut::verify::{FaultKind, verify};

use super::disc::cutter;
use super::samples::{SAMPLES, compared, sample, sample_plans};

fn result(outcome: &PlanOutcome, policy: AxisPolicy) -> &PolicyResult {
    outcome.policies().into_iter().find(|r| r.plan.policy == policy).expect("all policies were planned")
}

/// Faults that `verify` finds in the written program of a plan.
fn faults(part: &Impeller, setup: &Setup, result: &PolicyResult) -> Vec<String> {
    let text = write_apt(&ClProgram::of_plan(&part.name, &result.plan));
    let program = read_apt_bytes("plunge.apt", text.as_bytes()).expect("readable");
    let verdict = verify(&setup.allowances.workpiece_of(part.clone()), setup, &program, &Monitor::default())
        .expect("can be judged");
    verdict.faults.into_iter().map(|fault| format!("line {}: {fault}", fault.line)).collect()
}

/// Checks the invariants of plans that are free of contact.
fn check(name: &str, part: &Impeller, outcome: &PlanOutcome) {
    for policy in [AxisPolicy::Minimal, AxisPolicy::Staircase] {
        let result = result(outcome, policy);
        assert!(!result.plan.positions.is_empty(), "{name} {policy:?}: cuts something");
        assert_eq!(result.summary.interfering, 0, "{name} {policy:?}: the core is free");
        let faults = faults(part, &outcome.setup, result);
        assert!(faults.is_empty(), "{name} {policy:?}: {faults:#?}");
    }
    let minimal = &result(outcome, AxisPolicy::Minimal).summary;
    let limit = outcome.setup.plunge.max_axis_change_rad;
    assert!(
        minimal.max_axis_change_rad <= limit + 1e-9,
        "{name}: axes turn by {}",
        minimal.max_axis_change_rad
    );
}

/// Residual stock of `minimal` above the allowance as a share of that of `monotone`, for sections where
/// `monotone` is free of contact: section, mean and 95th percentile.
fn shares_of_monotone(outcome: &PlanOutcome) -> Vec<(usize, f64, f64)> {
    let allowance = outcome.setup.allowances.hub_allowance;
    let share = |ours: f64, theirs: f64| (ours - allowance) / (theirs - allowance);
    let of_section = |index: usize| {
        let [monotone, minimal] = [AxisPolicy::Monotone, AxisPolicy::Minimal].map(|policy| {
            let result = result(outcome, policy);
            Summary::of_section(&result.plan, &outcome.grid, &result.field, index)
        });
        (monotone.interfering == 0).then(|| {
            let mean = share(minimal.residual_mean, monotone.residual_mean);
            (index, mean, share(minimal.residual_p95, monotone.residual_p95))
        })
    };
    (0..outcome.setup.plunge.sections.len()).filter_map(of_section).collect()
}

#[test]
fn samples_are_freed_and_less_is_left() {
    for name in SAMPLES {
        let outcome = sample_plans(name);
        check(name, &outcome.workpiece.part, outcome);
        let [monotone, staircase, minimal] =
            [AxisPolicy::Monotone, AxisPolicy::Staircase, AxisPolicy::Minimal]
                .map(|p| &result(outcome, p).summary);
        assert!(outcome.before.summary.interfering > 100, "{name}: what shops do today interferes");
        for (index, mean, p95) in shares_of_monotone(outcome) {
            for (what, limit, share) in [("mean", 0.4, mean), ("95 %", 0.5, p95)] {
                // The field is accurate to a hundredth.
                assert!(
                    share < limit + 0.01,
                    "{name}, section {index}: {what} {share} of what monotone leaves"
                );
            }
        }
        assert!(
            minimal.residual_mean < 0.5 * staircase.residual_mean,
            "{name}: far less than stopping short"
        );
        assert!(
            minimal.uncut_share <= monotone.uncut_share + 1e-3,
            "{name}: nothing is bought by leaving floor uncut"
        );
    }
}

/// A linear congruential generator of numbers from 0 to 1: gives the same wheels on every machine.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.roll()
    }
}

/// Position along a random wheel at which its blades are straight across the channel.
#[derive(Clone, Copy, PartialEq)]
enum Stacking {
    /// At the leading edge: hub and shroud wrap differently, so that blades are inclined by up to 80° at the
    /// rim.
    LeadingEdge,
    /// At the rim, apart from a rake, as in real wheels; splitters are on the main blades' camber surface.
    Rim,
}

/// A blade of a random wheel: s of the leading edge, and for hub and shroud θ there and the angles along the
/// blade, degrees.
struct Blade {
    kind: &'static str,
    leading_edge: f64,
    theta: [f64; 2],
    angles: [[f64; 2]; 2],
}

impl Blade {
    fn text(&self, thickness: f64) -> String {
        let span = |v: usize| {
            let share = v as f64;
            format!(
                "[[{}.span]]\nspan = {share:.1}\nleading_edge = {}\ntheta_leading_edge = {:.4}\n\
                 angle = [[0.0, {:.4}], [1.0, {:.4}]]\nthickness = [[0.0, {:.4}], [1.0, {:.4}]]\n",
                self.kind,
                self.leading_edge,
                self.theta[v],
                self.angles[v][0],
                self.angles[v][1],
                thickness * (1.6 - share),
                thickness * (1.2 - 0.4 * share),
            )
        };
        span(0) + &span(1)
    }
}

/// A random wheel: radius 30 to 250 mm, 5 to 12 blades of either sense of rotation, some with splitters.
fn made_wheel(dice: &mut Dice, stacking: Stacking) -> Impeller {
    const LEADING_EDGE: f64 = 0.06;
    const SPLITTER_EDGE: f64 = 0.42;
    let rim = dice.between(30.0, 250.0);
    let (eye, tip) = (rim * dice.between(0.2, 0.32), rim * dice.between(0.5, 0.62));
    let depth = rim * dice.between(0.5, 0.75);
    let outlet = rim * dice.between(0.08, 0.16);
    let blades = 5 + (dice.roll() * 8.0) as usize;
    let turn = if dice.roll() < 0.5 { 1.0 } else { -1.0 };
    let (hub_le, shroud_le, te) =
        (dice.between(20.0, 35.0), dice.between(40.0, 55.0), dice.between(25.0, 45.0));
    let thickness = rim * 0.012;
    let has_splitters = dice.roll() < 0.4;
    let text = format!(
        "name = \"made\"\nblades = {blades}\n\
         [hub]\ncontrol = [[{eye:.4}, 0], [{eye:.4}, {:.4}], [{:.4}, {depth:.4}], [{rim:.4}, {depth:.4}]]\n\
         [shroud]\ncontrol = [[{tip:.4}, 0], [{tip:.4}, {:.4}], [{:.4}, {:.4}], [{rim:.4}, {:.4}]]\n",
        0.62 * depth,
        eye + 0.4 * (rim - eye),
        0.62 * (depth - outlet),
        tip + 0.35 * (rim - tip),
        depth - outlet,
        depth - outlet,
    );
    let build = |blades: &[Blade]| {
        let text = blades.iter().fold(text.clone(), |text, blade| text + &blade.text(thickness));
        let description = read_part_bytes("made.toml", text.as_bytes(), "toml").expect("readable");
        Impeller::build(&description).unwrap_or_else(|e| panic!("{e}\n{text}"))
    };
    // Angle of the first wall at hub and shroud, degrees.
    let wall = |part: &Impeller, s: f64| {
        let wall = &Channel::from_part(part).full.walls[0];
        [0.0, 1.0].map(|v| wall.at(part, s, v).expect("a wall").theta.to_degrees())
    };
    let mut main = Blade {
        kind: "main",
        leading_edge: LEADING_EDGE,
        theta: [0.0, 0.0],
        angles: [hub_le, shroud_le].map(|le| [turn * le, turn * te]),
    };
    let half_a_pitch = turn * 180.0 / blades as f64;
    let mut splitter = Blade {
        kind: "splitter",
        leading_edge: SPLITTER_EDGE,
        theta: [half_a_pitch; 2],
        angles: main.angles,
    };
    if stacking == Stacking::Rim {
        let rake = dice.between(-15.0, 30.0f64).to_radians();
        let [hub, shroud] = wall(&build(&[Blade { ..main }]), 0.99);
        main.theta[1] = turn * (rake.tan() * outlet / rim).to_degrees() - (shroud - hub);
        let part = build(&[Blade { ..main }]);
        let (nose, edge) = (wall(&part, SPLITTER_EDGE), wall(&part, LEADING_EDGE));
        let share = (SPLITTER_EDGE - LEADING_EDGE) / (1.0 - LEADING_EDGE);
        for v in 0..2 {
            splitter.theta[v] = main.theta[v] + nose[v] - edge[v] + half_a_pitch;
            splitter.angles[v][0] += (main.angles[v][1] - main.angles[v][0]) * share;
        }
    }
    if has_splitters { build(&[main, splitter]) } else { build(&[main]) }
}

/// Plans `count` random wheels with random setups by all policies, and checks each.
fn made_plans(seed: u64, count: usize, stacking: Stacking, field_cells: usize) -> Vec<PlanOutcome> {
    let mut dice = Dice(seed);
    let mut outcomes = Vec::new();
    for wheel in 0..count {
        let part = made_wheel(&mut dice, stacking);
        let mut setup = Setup::default();
        setup.allowances.hub_allowance = dice.between(0.1, 0.8);
        setup.allowances.blade_allowance = dice.between(0.1, 0.8);
        setup.plunge.max_axis_change_rad = dice.between(3.0, 9.0).to_radians();
        let request = PlanRequest {
            part: part.clone().into(),
            setup,
            policy: AxisPolicy::Minimal,
            compare: true,
            field_cells,
        };
        // A wheel too narrow for any cutter is an error of `run`.
        let Ok(outcome) = run(&request, &Monitor::default()) else { continue };
        check(&format!("wheel {wheel}"), &part, &outcome);
        outcomes.push(outcome);
    }
    outcomes
}

#[test]
fn made_wheels_with_made_setups_are_freed() {
    let planned = made_plans(21, 1, Stacking::LeadingEdge, 64).len();
    assert_eq!(planned, 1, "the wheel cannot be planned");
}

#[test]
#[ignore = "as the test before it, with more wheels; scripts/nightly runs it"]
fn more_made_wheels_with_made_setups_are_freed() {
    let planned = made_plans(21, 5, Stacking::LeadingEdge, 64).len();
    assert!(planned >= 3, "only {planned} wheels could be planned");
}

#[test]
#[ignore = "six plans by all policies; scripts/nightly runs it"]
fn on_wheels_as_they_are_built_less_is_left_than_by_the_published_method() {
    let outcomes = made_plans(5, 6, Stacking::Rim, 256);
    let compared = |outcome: &PlanOutcome| {
        let shares = shares_of_monotone(outcome).into_iter();
        let is_main = |index: usize| outcome.setup.plunge.sections[index].kind != SectionKind::Rest;
        let shares = shares.filter(|share| is_main(share.0)).map(|(_, mean, p95)| (mean, p95));
        shares.collect::<Vec<(f64, f64)>>()
    };
    let shares: Vec<(f64, f64)> = outcomes.iter().flat_map(compared).collect();
    assert!(shares.len() >= 5, "only {} sections can be compared", shares.len());
    let mean = |of: fn(&(f64, f64)) -> f64| shares.iter().map(of).sum::<f64>() / shares.len() as f64;
    let (mean_share, p95_share) = (mean(|s| s.0), mean(|s| s.1));
    assert!(
        mean_share < 0.4 && p95_share < 0.5,
        "{mean_share}, {p95_share} of what monotone leaves: {shares:?}"
    );
    // Where monotone leaves little, or a wall is inclined, no cutter of the same size leaves much less.
    assert!(shares.iter().all(|s| s.0 < 0.7), "{shares:?}");
}

/// A wheel with channels ten cutter diameters deep.
const DEEP: &str = r#"
name = "deep"
blades = 12
[hub]
control = [[74.1, 0], [74.1, 100.2], [138.7, 161.7], [235.6, 161.7]]
[shroud]
control = [[135.9, 0], [135.9, 80.2], [170.8, 129.4], [235.6, 129.4]]
[[main.span]]
span = 0.0
leading_edge = 0.06
theta_leading_edge = 0.0
angle = [[0.0, 27.5], [1.0, 38.8]]
thickness = [[0.0, 4.5], [1.0, 3.4]]
[[main.span]]
span = 1.0
leading_edge = 0.06
theta_leading_edge = 0.0
angle = [[0.0, 40.8], [1.0, 38.8]]
thickness = [[0.0, 1.7], [1.0, 2.3]]
[[splitter.span]]
span = 0.0
leading_edge = 0.42
theta_leading_edge = 15.0
angle = [[0.0, 27.5], [1.0, 38.8]]
thickness = [[0.0, 4.5], [1.0, 3.4]]
[[splitter.span]]
span = 1.0
leading_edge = 0.42
theta_leading_edge = 15.0
angle = [[0.0, 40.8], [1.0, 38.8]]
thickness = [[0.0, 1.7], [1.0, 2.3]]
"#;

/// The tilt angles of a slender cutter's row must be fine enough for each core to follow the previous one
/// over the whole depth.
#[test]
#[ignore = "plans of all policies with many plunges; scripts/nightly runs it"]
fn a_slender_cutter_gets_down_to_a_deep_hub() {
    let part = Impeller::build(&read_part_bytes("deep.toml", DEEP.as_bytes(), "toml").expect("readable"));
    let part = part.expect("an impeller");
    let cutter = Tool { overhang: 95.0, plunge_feed: 300.0, spindle: 3000.0, ..cutter(6.0, 2.7) };
    let radius = cutter.radius();
    let mut setup = Setup { tools: vec![cutter], ..Setup::default() };
    setup.plunge.rest = false;
    setup.plunge.max_axis_change_rad = 8.67f64.to_radians();
    setup.plunge.sections =
        vec![SectionSetup { tool: 1, from: 1.0, to: 0.9, cut_direction: None, kind: SectionKind::Rows }];
    let outcome = compared(&part, &setup);
    check("deep", &part, &outcome);
    let minimal = result(&outcome, AxisPolicy::Minimal);
    let highest = minimal.plan.positions.iter().map(|p| p.lift).fold(0.0, f64::max);
    assert!(highest < radius, "a plunge stops {highest} mm short");
    let excess = |policy: AxisPolicy| {
        let result = result(&outcome, policy);
        let section = Summary::of_section(&result.plan, &outcome.grid, &result.field, 0);
        section.residual_mean - outcome.setup.allowances.hub_allowance
    };
    let share = excess(AxisPolicy::Minimal) / excess(AxisPolicy::Monotone);
    assert!(share < 0.58, "{share} of what monotone leaves");
}

#[test]
fn links_of_a_ball_cutter_keep_the_whole_tool_out_of_the_blank() {
    let part = sample("impeller532");
    let cutter = Tool { corner_radius: 6.0, plunge_feed: 300.0, spindle: 3000.0, ..cutter(12.0, 5.0) };
    let mut setup = Setup { tools: vec![cutter], ..Setup::default() };
    setup.plunge.sections =
        vec![SectionSetup { tool: 1, from: 1.0, to: 0.5, cut_direction: None, kind: SectionKind::Rows }];
    let request = PlanRequest {
        part: part.clone().into(),
        setup: setup.clone(),
        policy: AxisPolicy::Monotone,
        compare: false,
        field_cells: 512,
    };
    let outcome = run(&request, &Monitor::default()).expect("a plan");
    let program = ClProgram::of_plan(&part.name, &outcome.after.plan);
    let verdict = verify(&setup.allowances.workpiece_of(part.clone()), &setup, &program, &Monitor::default())
        .expect("can be judged");
    let swings: Vec<_> = verdict.faults.iter().filter(|f| f.kind == FaultKind::ToolInBlank).collect();
    assert!(swings.is_empty(), "{swings:#?}");
}
