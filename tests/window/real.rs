//! The window with the real planner.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::state::Tone;
use vanecut::plunge::inspect::{CutPlane, section_view_in};
use vanecut::setup::AxisPolicy;

use crate::fake::shared_engine;
use crate::harness::{Window, settle, with_sample};

#[test]
fn the_count_of_interferential_positions_falls_to_none() {
    let mut window = with_sample(shared_engine());
    let step = window.get_by_role_and_label(Role::SpinButton, "Step");
    step.set_value_accesskit(7.0);
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Calculate roughing").click();
    window.step();
    settle(&mut window);
    let state = window.state().state();
    // A wider step may need other tools; the notice then says so.
    let fault = state.notice.as_ref().filter(|notice| notice.tone == Tone::Fault);
    assert_eq!(fault, None, "nothing went wrong");
    let planned = state.results.planned.as_ref().expect("planned");
    assert_eq!(planned.outcome.setup.plunge.step, Some(7.0), "planned with the step of the field");
    let [before, after] = [&planned.outcome.before.summary, &planned.outcome.after.summary];
    assert!(before.interfering > 0, "the conventional plan interferes");
    assert_eq!(after.interfering, 0, "the one by our policy does not");
    let verdict = format!("Interfering plunges {} to 0", before.interfering);
    window.get_by_label(&verdict);
}

#[test]
fn the_timeline_jumps_to_tools_and_sections_and_the_cut_explains_the_worst_contact() {
    let mut window = with_sample(shared_engine());
    let tool = |window: &Window| {
        let state = window.state().state();
        let section = state.selected().expect("selected").section;
        state.shown().expect("planned").plan().sections[section].tool.number
    };
    window.key_press(egui::Key::T);
    window.run_steps(2);
    assert_eq!(window.state().state().look.cut_count, Some(1), "the first tool");
    let first = tool(&window);
    window.key_press(egui::Key::T);
    window.run_steps(2);
    let (second, cut) = (tool(&window), window.state().state().look.cut_count.expect("a place"));
    assert!(second != first && cut > 1, "{first}, then {second} at {cut}");
    window.key_press(egui::Key::ArrowLeft);
    window.run_steps(2);
    assert_eq!(tool(&window), first, "the plunge before is of the tool before");
    window.key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::T);
    window.run_steps(2);
    assert_eq!(window.state().state().look.cut_count, Some(1));
    window.key_press(egui::Key::C);
    window.run_steps(2);
    assert!(window.state().state().look.cut_count.is_some_and(|at| at > 1 && at <= cut), "a section");

    let state = window.state().state();
    let planned = state.results.planned.as_ref().expect("planned");
    let (plan, workpiece) = (&planned.outcome.before.plan, &planned.outcome.workpiece);
    let depth = |k: &usize| plan.positions[*k].evaluation.contact.depth;
    let worst = (0..plan.positions.len()).max_by(|a, b| depth(a).total_cmp(&depth(b))).expect("a position");
    let view = |plane| {
        section_view_in(plane, &workpiece.part, &workpiece.blank, 0.5, plan, worst).expect("a position")
    };
    let through = view(CutPlane::Contact);
    let exact = depth(&worst);
    assert!(through.deepest_beside().abs() < 1e-9, "in the plane");
    assert!(
        (through.contact_in_plane() - exact).abs() < 0.02 * exact,
        "{} of {exact}",
        through.contact_in_plane()
    );
    let along = view(CutPlane::Row);
    let shown = along.contact_in_plane();
    assert!(
        shown > 0.9 * exact || along.deepest_beside().abs() > 0.3,
        "or it lies beside: {shown} of {exact}"
    );
}

/// What the line below the section says of the deepest contact is what is drawn.
#[test]
fn a_section_that_has_the_deepest_contact_shows_it() {
    let window = with_sample(shared_engine());
    let planned = window.state().state().results.planned.clone().expect("planned");
    let (plan, workpiece) = (&planned.outcome.before.plan, &planned.outcome.workpiece);
    let mut shown = 0;
    for (k, position) in plan.positions.iter().enumerate().step_by(5) {
        let contact = &position.evaluation.contact;
        for plane in [CutPlane::Row, CutPlane::Across, CutPlane::Contact, CutPlane::Meridian] {
            let view = section_view_in(plane, &workpiece.part, &workpiece.blank, 0.5, plan, k);
            let view = view.expect("a position");
            let (drawn, in_plane) = (view.contact_depth(), view.contact_in_plane());
            if !contact.interferes() {
                assert!(drawn == 0.0 && in_plane == 0.0, "position {k}: {drawn}, {in_plane}");
            } else if let Some(deepest) = view.deepest.filter(|_| view.shows_deepest()) {
                let depth = deepest.depth;
                assert!(in_plane >= depth, "position {k}, {plane:?}: {in_plane} of {depth}");
                shown += 1;
            }
        }
    }
    assert!(shown > 40, "{shown}");
}

#[test]
fn conventional_as_the_policy_repairs_nothing() {
    let mut window = with_sample(shared_engine());
    window.get_by_role_and_label(Role::ComboBox, "Axis strategy").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Isoparametric").click();
    window.run_steps(2);
    assert_eq!(
        window.state().state().document.edited.setup.plunge.axis,
        AxisPolicy::Conventional,
        "the list edits the setup"
    );
    window.key_press(egui::Key::F5);
    window.step();
    settle(&mut window);
    let planned = window.state().state().results.planned.clone().expect("planned");
    let [before, after] = [&planned.outcome.before, &planned.outcome.after].map(|r| r.summary.interfering);
    assert_eq!(before, after, "both sides are the conventional plan");
}
