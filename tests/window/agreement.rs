//! One figure has one text wherever it stands, and what is counted differently says so.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::checked::{CheckRequest, FigureValue};
use vanecut::app::model::figures::{format_duration, format_percent};
use vanecut::app::tasks::engine::Engine;
use vanecut::io::apt::write_apt;
use vanecut::job::{FIELD_CELLS, PlanOutcome};
use vanecut::machine::MachineTime;
use vanecut::monitor::Monitor;
use vanecut::plunge::Breach;
use vanecut::toolpath::ClProgram;
use vanecut::verify::report_plunges;

use crate::fake;
use crate::harness::{Window, labels, settle, with_sample};
use crate::program::{check, nc_program, take_tools, write};

/// The time of a wheel with its tool changes: 31.3 h, and 31.2 h if each channel counts without them.
#[test]
fn the_time_of_a_wheel_is_the_same_in_verdict_operations_and_variants() {
    let time = MachineTime { total_s: 7200.0, tool_changes_s: 600.0 };
    let mut window = with_sample(fake::engine_on_machine(time));
    window.set_size(egui::vec2(1100.0, 1180.0));
    window.run_steps(2);
    window.get_by_label("Save as variant").click();
    window.run_steps(4);
    settle(&mut window);
    let times = labels(&window, "2.0 h per channel");
    assert!(
        !times.is_empty() && times.iter().all(|text| text == "2.0 h per channel, 31.3 h wheel"),
        "{times:?}"
    );
    assert!(window.query_all_by_label_contains("2.0 h, wheel 31.3 h").count() > 0);
    assert_eq!(labels(&window, "31."), ["31.3 h", "31.3 h"], "of the current setup and the variant");
}

/// The fake planner, of whose plan after a plunge is out of the reach of the machine.
fn engine_with_breach() -> Engine {
    let (engine, _) = fake::engine();
    let beyond = move |outcome: &mut PlanOutcome| {
        outcome.after.plan.positions[3].evaluation.breach = Some(Breach::Tilt);
    };
    fake::with_changed_plans(engine, beyond)
}

#[test]
fn the_headline_says_how_many_interfere_by_the_contact_of_their_core() {
    let window = with_sample(engine_with_breach());
    window.get_by_label("Interfering plunges 5 to 1 (core contact 5 to 0)");
}

#[test]
fn the_head_of_a_plunge_says_what_is_wrong_with_it() {
    let mut window = with_sample(engine_with_breach());
    window.set_size(egui::vec2(1100.0, 900.0));
    window.state_mut().look_mut().select(Some(3));
    window.run_steps(6);
    let count = window.state().state().position_count();
    window.get_by_label(&format!("Position 4 of {count}: interfering"));
    window.get_by_label("axis beyond the reach of the machine");
}

/// The panel of the selected position stands on the lower edge.
#[test]
fn the_first_edit_by_hand_moves_no_button() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1000.0));
    window.state_mut().look_mut().select(Some(3));
    window.run_steps(6);
    window.get_by_label("By hand").click();
    window.run_steps(6);
    settle(&mut window);
    let lock = |window: &Window, name: &str| window.get_by_role_and_label(Role::Button, name).rect();
    let before = lock(&window, "Lock");
    window.get_by_role_and_label(Role::Button, "Lock").click();
    window.run_steps(8);
    settle(&mut window);
    window.run_steps(8);
    assert_eq!(window.state().state().document.edited.setup.plunge.edits.len(), 1);
    let after = window.get_by_role_and_label(Role::Button, "Delete").rect();
    assert!((after.top() - before.top()).abs() < 1.0, "{before} became {after}");
}

/// Opens a setup with a machine that takes an hour to change a tool; returns its file.
fn open_slow_machine(window: &mut Window, folder: &Path) -> PathBuf {
    let text = include_str!("../../assets/machines/ac-trunnion.toml");
    let machine = write(folder, "slow.toml", &text.replace("change_time = 12.0", "change_time = 3600.0"));
    let setup = write(folder, "setup.toml", "[machine]\nfile = \"slow.toml\"\n");
    window.state_mut().open_path(setup);
    settle(window);
    machine
}

/// The headline of a checked program says what its clock says, which is that of a machine.
fn assert_agreement(window: &Window) {
    let state = window.state().state();
    let whole = state.machine_clock().expect("on a machine").last().copied().expect("moves");
    assert!(whole > 3600.0, "{whole} s with a change of the tool");
    let time = format_duration(whole);
    assert_eq!(labels(window, &time), [time.as_str()], "{:?}", labels(window, ""));
}

#[test]
fn the_time_of_a_checked_program_is_that_of_its_clock() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = with_sample(fake::engine().0);
    window.set_size(egui::vec2(1280.0, 900.0));
    // Of APT it is that on the machine of the setup, of NC code on that which it was posted for.
    let machine = open_slow_machine(&mut window, folder.path());
    let plan = &window.state().state().shown().expect("planned").plan().clone();
    let apt = write(folder.path(), "plan.apt", &write_apt(&ClProgram::of_plan("impeller532", plan)));
    check(&mut window, &apt);
    assert_agreement(&window);
    take_tools(&mut window, folder.path());
    window.state_mut().look_mut().check_machine = Some(machine.display().to_string());
    let nc = write(folder.path(), "plan.h", &nc_program(&window));
    check(&mut window, &nc);
    assert_agreement(&window);
}

/// The floor is measured as finely as by `vanecut verify`.
#[test]
fn the_figures_of_a_checked_program_are_those_of_verify() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = with_sample(fake::engine().0);
    take_tools(&mut window, folder.path());
    let plan = &window.state().state().shown().expect("planned").plan().clone();
    let program = ClProgram::of_plan("impeller532", plan);
    check(&mut window, &write(folder.path(), "plan.apt", &write_apt(&program)));
    let checked = window.state().state().results.checked.clone().expect("checked");
    let CheckRequest { part, setup, .. } = &checked.request;
    let workpiece = setup.allowances.workpiece_of(Arc::clone(part));
    let report = report_plunges(&workpiece, setup, &checked.program, FIELD_CELLS, &Monitor::default());
    let summary = report.expect("judged").summary;
    let residual = FigureValue::Residual(summary.residual_mean, summary.residual_p95);
    let uncut = FigureValue::Text(format_percent(summary.uncut_share));
    for (name, wanted) in [("Residual", residual), ("Not machined", uncut)] {
        let found = checked.figures.iter().find(|(figure, ..)| *figure == name);
        assert_eq!(found.map(|(_, value, _)| value), Some(&wanted), "{name}");
    }
}
