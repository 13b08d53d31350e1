//! Plunges edited by hand, with the real planner.

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::{Operation, Tab};
use vanecut::app::model::part_source::PartSource;
use vanecut::app::model::planned::Side;
use vanecut::app::tasks::engine::Engine;
use vanecut::io::project_file::read_project;
use vanecut::job::{Listener, PlanRequest};
use vanecut::monitor::Monitor;
use vanecut::plunge::{Breach, Condition, PlungeMark, Position};

use crate::fake;
use crate::harness::{Window, settle, snapshot_view, window, with_sample, words};

/// A setup with a small plan.
const SETUP: &str = "[[tool]]\nnumber = 1\ndiameter = 20\ninsert_width = 6\noverhang = 90\n\
                     [plunge]\naxis = \"staircase\"\nrest = false\n\
                     [[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.55\n";

/// The real planner; what is planned before the setup with its tool is opened is the fake one's.
fn engine() -> Engine {
    let (real, (fake, _)) = (fake::shared_engine(), fake::engine());
    let (plan, plan_first) = (real.plan, fake.plan);
    let planned = move |request: &PlanRequest, monitor: &Monitor, listener: Listener| {
        let plan = if request.setup.tools.is_empty() { &plan_first } else { &plan };
        plan(request, monitor, listener)
    };
    Engine { plan: Arc::new(planned), ..Engine::default() }
}

/// A window with the small plan.
fn planned(folder: &std::path::Path) -> Window {
    let path = folder.join("setup.toml");
    std::fs::write(&path, SETUP).expect("writes");
    let mut window = window(engine());
    window.set_size(egui::vec2(1280.0, 800.0));
    window.state_mut().open_part(PartSource::Sample("pump6".to_owned()));
    settle(&mut window);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::OpenSetup, path);
    settle(&mut window);
    window
}

fn positions(window: &Window) -> Vec<Position> {
    window.state().state().shown().expect("planned").plan().positions.clone()
}

fn count_edits(window: &Window) -> usize {
    window.state().state().document.edited.setup.plunge.edits.len()
}

/// Selects a position in the table, and shows what can be done with it by hand.
fn select(window: &mut Window, number: usize) {
    window.get_by_role_and_label(Role::Row, &format!("Position {number}")).click();
    window.run_steps(3);
    window.key_press(egui::Key::E);
    window.run_steps(3);
}

/// From there on, Tab and the arrows lead through the tab.
#[test]
fn the_key_for_edits_gives_the_keys_to_their_tab() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    select(&mut window, 3);
    assert!(window.get_by_role_and_label(Role::RadioButton, "Plunge").accesskit_node().is_focused());
}

/// Clicks a button of the tab and waits for the plan that follows.
fn click(window: &mut Window, button: &str) {
    window.get_by_role_and_label(Role::Button, button).click();
    window.run_steps(3);
    settle(window);
}

fn set(window: &mut Window, field: &str, value: f64) {
    window.get_by_role_and_label(Role::SpinButton, field).set_value_accesskit(value);
    window.run_steps(3);
}

#[test]
fn a_plunge_that_is_lifted_off_the_hub_has_none_in_its_sectional_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    select(&mut window, 3);
    set(&mut window, "Lift by", 95.0);
    click(&mut window, "Lift");
    click(&mut window, "Sectional view");
    window.get_by_label_contains("the hub is not in this cut");
    assert!(window.query_by_label_contains("max residual").is_none(), "it would be 0");
}

#[test]
fn a_plunge_is_lifted_deleted_and_brought_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    let found = positions(&window);
    select(&mut window, 3);
    set(&mut window, "Lift by", 1.5);
    click(&mut window, "Lift");
    let lifted = &positions(&window)[2];
    assert!((lifted.lift - found[2].lift - 1.5).abs() < 1e-9, "{} mm", lifted.lift);
    assert_eq!(window.state().state().plunge_mark(2), PlungeMark::Edited);
    window.get_by_label("edited");
    window.get_by_label("1 edit");
    assert!(!window.state().state().out_of_date(), "the plan follows");

    window.key_press(egui::Key::Delete);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(positions(&window).len(), found.len() - 1);
    assert_eq!(positions(&window)[2].tip, found[3].tip, "the next one is selected in its place");
    assert_eq!(window.state().state().look.selected, Some(2));

    for left in [1, 0] {
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
        window.run_steps(3);
        settle(&mut window);
        assert_eq!(count_edits(&window), left, "each edit is undone by itself");
    }
    assert_eq!(positions(&window), found);
    assert_eq!(window.state().state().look.selected, Some(2), "undo brings the selection back");

    // With another setup it no longer fits.
    click(&mut window, "Lift");
    set(&mut window, "Step", 3.1);
    settle(&mut window);
    window.get_by_label("1 edit by hand not applied");
    window.get_by_label("Roughing: 1 edit by hand not applied");
    // Whoever has the sheet alone knows it too.
    let (ctx, sheet) = (window.ctx.clone(), folder.path().join("sheet.html"));
    let purpose = Purpose::ExportSheet { operation: Operation::Roughing };
    window.state_mut().file_chosen(&ctx, purpose, sheet.clone());
    window.run_steps(3);
    click(&mut window, "Export anyway");
    let page = std::fs::read_to_string(&sheet).expect("a page");
    assert!(page.contains("<li>Not applied: lift of the plunge at ("), "{page}");
}

#[test]
fn until_the_plan_follows_an_edit_the_next_one_waits_but_lifts_add_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    let found = positions(&window);
    window.get_by_label("Auto-update").click();
    window.run_steps(3);
    select(&mut window, 3);
    set(&mut window, "Move along", 1.0);
    const BUTTONS: [&str; 5] = ["Move", "Delete", "Lock", "Earlier", "Later"];
    let places =
        |window: &Window| BUTTONS.map(|button| window.get_by_role_and_label(Role::Button, button).rect());
    let before = places(&window);
    for _ in 0..2 {
        click(&mut window, "Lift");
    }
    let is_disabled = |window: &Window, button: &str| {
        window.get_by_role_and_label(Role::Button, button).accesskit_node().is_disabled()
    };
    for button in BUTTONS {
        assert!(is_disabled(&window, button), "{button}");
    }
    assert_eq!(places(&window), before, "a second click meets what the first one met");
    window.key_press(egui::Key::Delete);
    window.run_steps(3);
    assert_eq!(count_edits(&window), 1, "the second lift adds to the first, nothing else is taken");
    let said = |window: &Window| window.query_all_by_label_contains("calculate it first").count();
    assert_eq!(said(&window), 2, "in the tab, and in the status bar for the key");
    click(&mut window, "Calculate roughing");
    let lifted = &positions(&window)[2];
    assert!((lifted.lift - found[2].lift - 1.0).abs() < 1e-9, "{} mm", lifted.lift);
    assert!(!is_disabled(&window, "Move"));

    // An edit finds its plunge by where it is, and another setup may place others.
    set(&mut window, "Step", 3.1);
    for button in BUTTONS.into_iter().chain(["Lift"]) {
        assert!(is_disabled(&window, button), "{button}");
    }
    window.key_press(egui::Key::Delete);
    window.run_steps(3);
    assert_eq!(count_edits(&window), 1, "it would not be applied");
    assert_eq!(said(&window), 2);
}

#[test]
fn a_row_is_deleted_and_cut_in_another_order_from_the_context_menu_and_the_tab() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    let found = positions(&window);
    let first_row = found.iter().filter(|position| position.row == 0).count();
    window.get_by_role_and_label(Role::Row, "Position 2").click_secondary();
    window.run_steps(3);
    window.get_by_label_contains("Change by hand").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Delete row Shift+Delete").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(positions(&window).len(), found.len() - first_row);

    select(&mut window, 1);
    click(&mut window, "Later");
    let now = positions(&window);
    assert_eq!((now[0].tip, now[1].tip), (found[first_row + 1].tip, found[first_row].tip));
    assert_eq!(window.state().state().look.selected, Some(1), "the selection goes with it");
    window.get_by_label("Whole row").click();
    window.run_steps(2);
    let earlier = window.get_by_role_and_label(Role::Button, "Earlier");
    assert!(earlier.accesskit_node().is_disabled(), "it is the first row");
    click(&mut window, "Later");
    assert!(window.state().state().look.selected.is_some_and(|k| k > 1), "the whole row is cut later");
    click(&mut window, "Remove all");
    assert_eq!(positions(&window), found);
}

#[test]
fn a_locked_plunge_stays_when_the_setup_changes_and_in_the_project_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    select(&mut window, 4);
    set(&mut window, "Move along", 1.0);
    set(&mut window, "Turn lead", 1.5);
    click(&mut window, "Move");
    let moved = positions(&window)[3].clone();
    click(&mut window, "Lock");
    assert!(window.state().state().plunge_mark(3).is_locked());
    window.get_by_label("locked");
    set(&mut window, "Step", 3.1);
    settle(&mut window);
    let now = positions(&window);
    let k = now.iter().position(|position| position.tip == moved.tip).expect("it is kept");
    assert!(window.state().state().plunge_mark(k).is_locked());
    assert!((now[k].axis - moved.axis).norm() < 1e-12);
    window.get_by_label("2 edits, 1 not applied");
    window.get_by_label("1 edit by hand not applied");
    assert!(now[k].evaluation.breach.is_some(), "by hand it is nearer than the planner may go");
    window.get_by_label("Roughing: 1 fault");
    let reason = words(&window, "Edit 1, Move: the plan has no plunge there: the nearest is position ");
    let reason = reason.expect("why it is not applied");
    assert!(reason.ends_with(" mm off"), "{reason}");
    snapshot_view(&mut window, "edited_by_hand");
    // The others are planned around it: the plan is made as by the command line.
    let outcome = &window.state().state().results.planned.as_ref().expect("planned").outcome;
    assert_eq!(outcome.kept_locked.len(), 1);
    assert_eq!(outcome.after.summary.interfering, 0);
    window.get_by_label_contains("Edit 1, Move: ").click();
    window.run_steps(3);
    let selected = window.state().state().look.selected.expect("the nearest plunge");
    assert!(reason.contains(&format!("position {},", selected + 1)), "{reason}: {selected}");

    let path = folder.path().join("p.vanecut");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, path.clone());
    settle(&mut window);
    let edited = window.state().state().document.edited.setup.plunge.edits.clone();
    assert_eq!(read_project(&path).expect("reads").setup.plunge.edits, edited);

    assert_eq!(selected, k, "it is the one that was moved and locked");
    click(&mut window, "Remove those");
    window.get_by_label("1 edit");
    click(&mut window, "Unlock");
    assert_eq!(count_edits(&window), 0);
    assert!(!positions(&window).iter().any(|position| position.tip == moved.tip));
}

#[test]
fn a_plunge_that_is_moved_into_a_blade_is_a_fault_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    let plan = |window: &Window| window.state().state().shown().expect("planned").plan().clone();
    assert_eq!(plan(&window).count_interfering(), 0, "planned plunges are sound");
    select(&mut window, 3);
    set(&mut window, "Move across", -6.0);
    click(&mut window, "Move");
    let (found, count) = (plan(&window).count_interfering(), plan(&window).positions.len());
    let of = &plan(&window).positions[2];
    assert_eq!(of.evaluation.breach, Some(Breach::Blade), "{} mm to a blade", of.blade_clearance);
    window.get_by_label(&format!("Position 3 of {count}: interfering"));
    window.state_mut().look_mut().tab = Tab::Facts;
    window.run_steps(3);
    window.get_by_label("Closer to a blade than its allowance");
    let before = window.state().state().last_whole_plan(Side::Before).expect("planned").plan();
    window.get_by_label(&format!("Interfering plunges {} to {found}", before.count_interfering()));
    let word = if found == 1 { "fault" } else { "faults" };
    window.get_by_label(&format!("Roughing: {found} {word}"));
    window.get_by_label_contains("interfering, ");
    // The key finds it from elsewhere.
    select(&mut window, 1);
    window.key_press(egui::Key::N);
    window.run_steps(3);
    let selected = window.state().state().look.selected.expect("a fault");
    assert_eq!(plan(&window).positions[selected].condition(), Condition::Interfering);
    assert!(selected <= 2, "{selected}: the first one");
}

#[test]
fn the_conventional_side_cannot_be_edited() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    window.get_by_label("Before").click();
    window.run_steps(3);
    select(&mut window, 2);
    window.get_by_label_contains("show the side \"After\"");
    window.key_press(egui::Key::Delete);
    window.run_steps(3);
    assert_eq!(count_edits(&window), 0);
}

/// The plunge of a plan whose tip is nearest.
fn nearest(plan: &[Position], to: &Position) -> usize {
    let distance = |k: &usize| (plan[*k].tip - to.tip).norm();
    (0..plan.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("positions")
}

#[test]
fn the_selection_stays_at_its_place_in_another_plan_and_comes_back_to_its_plunge() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = planned(folder.path());
    let selected = |window: &Window| window.state().state().look.selected.expect("a plunge is selected");
    let found = positions(&window);
    let last = found.len();
    window.state_mut().look_mut().select(Some(last - 1));
    window.run_steps(3);
    // A number is another place in a plan with fewer or more rows.
    set(&mut window, "Step", 3.1);
    settle(&mut window);
    let finer = positions(&window);
    assert_ne!(finer.len(), last);
    assert_eq!(selected(&window), nearest(&finer, &found[last - 1]));
    assert_ne!(selected(&window), last - 1);
    window.get_by_label(&format!("Position {}", selected(&window) + 1));

    window.key_press(egui::Key::B);
    window.run_steps(3);
    let before = positions(&window);
    assert_eq!(selected(&window), nearest(&before, &found[last - 1]));
    window.key_press(egui::Key::B);
    window.run_steps(3);
    assert_eq!(selected(&window), nearest(&finer, &found[last - 1]));

    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(positions(&window), found);
    assert_eq!(selected(&window), last - 1, "undo brings it back");
}
