//! The sectional view through a position, compared with the plan it shows.

use vanecut::geometry::{Meridional, Point};
use vanecut::job::resolve;
use vanecut::monitor::Monitor;
use vanecut::part::Workpiece;
use vanecut::plunge::inspect::{row_of, section_view, step_before};
use vanecut::plunge::{Planner, PlungePlan};
use vanecut::setup::{AxisPolicy, Setup};

use super::samples::sample;

struct Case {
    workpiece: Workpiece,
    setup: Setup,
    plan: PlungePlan,
}

fn case(name: &str, policy: AxisPolicy) -> Case {
    let workpiece = Setup::default().allowances.workpiece_of(sample(name));
    let setup = resolve(&Setup::default(), &workpiece).expect("fits").setup;
    let plan = Planner::new(&workpiece, &setup).plan(policy, &Monitor::default()).expect("plans");
    Case { workpiece, setup, plan }
}

#[test]
fn lines_lie_where_they_say() {
    let Case { workpiece, setup, plan } = case("impeller532", AxisPolicy::Conventional);
    let Workpiece { part, blank, .. } = &workpiece;
    for k in (0..plan.positions.len()).step_by(23) {
        let view = section_view(part, blank, setup.allowances.hub_allowance, &plan, k).expect("exists");
        let space = |[x, y]: [f64; 2]| -> Point { view.tip + view.feed * x + view.axis * y };
        assert!(view.axis.dot(&view.feed).abs() < 1e-9, "a right angle");
        // At the rim, part of the view is beyond the hub.
        assert!(view.hub.len() > 60, "position {k}: the hub is under the cutter");
        for &place in &view.hub {
            let (_, off) = part.hub.curve().project(Meridional::from_point(&space(place)));
            assert!(off.abs() < 2e-3, "position {k}: {place:?} is {off} mm off the hub");
        }
        for (i, (before, after)) in view.before.iter().zip(&view.after).enumerate() {
            assert!(before[1] >= view.hub[i][1] - 1e-6, "stock stands on the hub");
            assert!(after[1] <= before[1] + 1e-9, "a cut only takes away");
            if before[0].abs() < 0.95 * view.tool.radius() {
                assert!(
                    after[1] <= view.bottom(after[0]) + 1e-9,
                    "nothing is left above the bottom: {after:?}"
                );
            }
        }
        // The bottom touches the allowance and never cuts into it.
        for &[x, y] in view.allowance.iter().filter(|p| p[0].abs() < view.tool.radius()) {
            assert!(
                y < view.bottom(x) + 0.01,
                "position {k}: allowance at {x} is {} mm in the cutter",
                y - view.bottom(x)
            );
        }
    }
}

#[test]
fn the_contact_that_is_drawn_is_the_contact_that_counts() {
    for name in ["impeller532", "pump6"] {
        let Case { workpiece, plan, .. } = case(name, AxisPolicy::Conventional);
        let Workpiece { part, blank, .. } = &workpiece;
        let (mut faulty, mut sound) = (0, 0);
        for (k, position) in plan.positions.iter().enumerate().step_by(7) {
            let view = section_view(part, blank, 0.5, &plan, k).expect("exists");
            let (seen, exact) = (view.contact_depth(), position.evaluation.contact.depth);
            if position.evaluation.contact.interferes() {
                faulty += 1;
                // The view samples the disc differently and leaves out its rim: hardly deeper, and similar
                // where the contact is deep.
                assert!(seen <= 1.005 * exact + 0.02, "{name} {k}: {seen} drawn, {exact} counted");
                assert!(exact < 0.4 || seen > 0.5 * exact, "{name} {k}: {seen} drawn, {exact} counted");
            } else {
                sound += 1;
                assert!(seen < 0.03, "{name} {k}: {seen} mm drawn of a sound position");
            }
        }
        assert!(faulty > 5 && sound > 3, "{name}: {faulty} faulty and {sound} sound ones looked at");
    }
}

#[test]
fn rows_and_steps_follow_the_plan() {
    let Case { plan, .. } = case("impeller532", AxisPolicy::Conventional);
    let row = row_of(&plan, 10);
    assert!(row.contains(&10) && row.len() > 5, "{row:?}");
    let key = |k: usize| (plan.positions[k].section, plan.positions[k].row);
    assert!(row.clone().all(|k| key(k) == key(10)) && key(row.end) != key(10), "{row:?}");
    assert_eq!(step_before(&plan, row.start), 0.0, "nothing before the first");
    let limit = plan.sections[0].tool.insert_width;
    let steps: Vec<f64> = row.skip(1).map(|k| step_before(&plan, k)).collect();
    assert!(steps.iter().all(|s| (0.2..=limit + 0.5).contains(s)), "{steps:?} under {limit}");
    assert!(row_of(&plan, 10_000).is_empty());
}
