//! Plans of the samples as they were written to a mesh file and read back are those of the samples.

use std::path::Path;
use std::sync::LazyLock;

use vanecut::io::gltf::GltfScene;
use vanecut::io::{read_part, read_part_bytes};
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::mesh::tessellate::{Fineness, Tessellation};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::plunge::{PlungePlan, Position};
use vanecut::setup::{AxisPolicy, Setup};

use super::samples::{compared, sample, sample_plans};

/// The part written as `.glb` and read back.
fn through_glb(part: &Impeller) -> Impeller {
    let bytes = GltfScene::of_part(part, &Tessellation::new(part, &Fineness::default())).glb();
    Impeller::build(&read_part_bytes("back.glb", &bytes, "glb").expect("readable")).expect("an impeller")
}

/// A sample that was read back, planned by all policies.
const READ_BACK: &str = "impeller9x9";
static READ_BACK_PLANS: LazyLock<PlanOutcome> =
    LazyLock::new(|| compared(&through_glb(&sample(READ_BACK)), &Setup::default()));

/// The policies that lay row by row.
const BY_ROW: [AxisPolicy; 3] = [AxisPolicy::Conventional, AxisPolicy::Staircase, AxisPolicy::Monotone];

/// The plans by these policies of an outcome that holds all.
fn by_row(outcome: &PlanOutcome) -> Vec<&PlungePlan> {
    let policies = outcome.policies();
    let plan = |policy: AxisPolicy| {
        let result = policies.iter().find(|result| result.plan.policy == policy);
        &result.expect("all policies were planned").plan
    };
    BY_ROW.into_iter().map(plan).collect()
}

/// The conventional and the monotone plan of a part.
fn planned_by_row(part: &Impeller) -> [PlungePlan; 2] {
    let request = PlanRequest {
        part: part.clone().into(),
        setup: Setup::default(),
        policy: AxisPolicy::Monotone,
        compare: false,
        field_cells: 128,
    };
    // Every job makes the conventional plan, too.
    let outcome = run(&request, &Monitor::default()).expect("a plan");
    [outcome.before.plan, outcome.after.plan]
}

/// Largest distance of tips (mm) and largest angle between axes (degrees) of matching plunges (same row and
/// s), and the number of plunges that only one of the plans has.
fn differences(a: &PlungePlan, b: &PlungePlan) -> (f64, f64, usize) {
    let at =
        |p: &Position, q: &Position| (p.section, p.row) == (q.section, q.row) && (p.s - q.s).abs() < 5e-4;
    let (mut moved, mut turned, mut met) = (0.0_f64, 0.0_f64, 0);
    for p in &a.positions {
        if let Some(q) = b.positions.iter().find(|q| at(p, q)) {
            met += 1;
            moved = moved.max((p.tip - q.tip).norm());
            turned = turned.max(p.axis.angle(&q.axis).to_degrees());
        }
    }
    (moved, turned, a.positions.len() + b.positions.len() - 2 * met)
}

fn assert_same<'p>(
    name: &str,
    before: impl IntoIterator<Item = &'p PlungePlan>,
    after: impl IntoIterator<Item = &'p PlungePlan>,
) {
    let (before, after): (Vec<_>, Vec<_>) = (before.into_iter().collect(), after.into_iter().collect());
    assert!(before.len() >= 2 && before.len() == after.len(), "{name}");
    for (a, b) in before.into_iter().zip(after) {
        let (moved, turned, alone) = differences(a, b);
        println!("{name}, {:?}: {moved:.4} mm, {turned:.4}°, {alone} alone", a.policy);
        assert_eq!(a.policy, b.policy);
        assert_eq!(alone, 0, "{name}");
        assert!(moved < 0.05 && turned < 0.1, "{name}, {:?}: {moved} mm, {turned}°", a.policy);
    }
}

#[test]
#[ignore = "plans by all policies of two parts, 9 s; scripts/nightly runs it"]
fn plans_of_own_files_stay_the_same() {
    assert_same(READ_BACK, by_row(sample_plans(READ_BACK)), by_row(&READ_BACK_PLANS));
}

#[test]
#[ignore = "as the test before it, of three more parts; scripts/nightly runs it"]
fn plans_of_more_own_files_stay_the_same() {
    for name in ["impeller532", "pump6"] {
        let [conventional, _, monotone] = by_row(sample_plans(name))[..] else {
            unreachable!("three policies")
        };
        assert_same(name, [conventional, monotone], &planned_by_row(&through_glb(&sample(name))));
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cc_autoblade/cc_autoblade.geomTurbo");
    let compressor = Impeller::build(&read_part(&path).expect("readable")).expect("an impeller");
    let back = through_glb(&compressor);
    assert_same("compressor", &planned_by_row(&compressor), &planned_by_row(&back));
}

#[test]
#[ignore = "plans by all policies of two parts, 14 s; scripts/nightly runs it"]
fn minimal_plans_of_own_files_leave_as_much() {
    // The search may take another path after the smallest change; only its result is comparable.
    let [a, b] = [sample_plans(READ_BACK), &READ_BACK_PLANS].map(|outcome| &outcome.after.summary);
    let mean = (a.residual_mean - b.residual_mean).abs();
    let p95 = (a.residual_p95 - b.residual_p95).abs();
    println!("{} and {} positions, mean {mean:.4}, p95 {p95:.4} mm apart", a.positions, b.positions);
    assert!(100 * a.positions.abs_diff(b.positions) <= a.positions);
    assert!(mean < 0.005 && p95 < 0.03, "{mean}, {p95} mm");
    assert!((a.uncut_share - b.uncut_share).abs() < 1e-3);
    assert_eq!((a.interfering, b.interfering), (0, 0));
}
