//! Checking of programs from anywhere.

use std::path::{Path, PathBuf};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::io::apt::read_apt_bytes;
use vanecut::monitor::Monitor;
use vanecut::verify::{Fault, FaultKind, verify};

use crate::drop::drop_on;
use crate::fake;
use crate::harness::{Window, settle, snapshot_view, with_sample};

/// The first plunges of the plan as a program; the fourth goes 3 mm too deep.
fn program(window: &Window) -> String {
    let mut text = "PARTNO/impeller532\nLOADTL/1\nCUTTER/30\nPPRINT/INSERT WIDTH 1 10\n".to_owned();
    let plan = window.state().state().shown().expect("planned").plan();
    for (k, position) in plan.positions.iter().enumerate().take(8) {
        let axis = position.axis;
        let tip = position.tip - axis * if k == TOO_DEEP { 3.0 } else { 0.0 };
        let up = position.evaluation.retract;
        for (words, p) in [("RAPID", up), ("FEDRAT/300,MMPM", tip), ("RAPID", up)] {
            text += &format!(
                "{words}\nGOTO/{:.6},{:.6},{:.6},{:.6},{:.6},{:.6}\n",
                p.x, p.y, p.z, axis.x, axis.y, axis.z
            );
        }
    }
    text + "FINI\n"
}

/// Index of the plunge that goes too deep, and the line of its cut: six lines each after a head of four.
const TOO_DEEP: usize = 3;
const ITS_LINE: usize = 4 + 6 * TOO_DEEP + 4;

fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("writes");
    path
}

fn check(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::CheckProgram, path.to_owned());
    window.run_steps(2);
    settle(window);
}

#[test]
fn faults_of_a_program_are_a_list_that_leads_to_their_places() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let text = program(&window);
    let path = write(folder.path(), "deep.apt", &text);
    window.set_size(egui::vec2(1200.0, 760.0));
    window.run_steps(3);
    check(&mut window, &path);
    let state = window.state().state();
    assert_eq!(state.look.operation, Operation::Program, "it is shown");
    let checked = state.results.checked.clone().expect("checked");
    // The same faults as those of the core.
    let setup = &state.document.edited.setup;
    let part = &state.document.part.as_ref().expect("open").impeller;
    let program = read_apt_bytes("deep.apt", text.as_bytes()).expect("a program");
    let workpiece = setup.allowances.workpiece_of(std::sync::Arc::clone(part));
    let verdict = verify(&workpiece, setup, &program, &Monitor::default()).expect("judged");
    let faults: Vec<_> = checked.findings.iter().map(|finding| finding.fault.clone()).collect();
    assert_eq!(faults, verdict.faults);
    window.get_by_label(&format!("Faults {}", faults.len()));
    assert!(window.query_by_label("Timeline").is_none(), "the plunge plan is hidden");

    // A click leads to the place.
    let is_it = |fault: &&Fault| fault.line == ITS_LINE && fault.kind == FaultKind::HubAllowance;
    let fault = faults.iter().find(is_it).expect("the plunge that goes too deep");
    let k = faults.iter().position(|other| other == fault).expect("it is one of them");
    let label = format!("Line {ITS_LINE}: {}", fault.message);
    window.get_by_role_and_label(Role::Button, &label).click();
    window.run_steps(8);
    settle(&mut window);
    assert_eq!(window.state().state().look.finding, Some(k));
    window.get_by_label(text.lines().nth(ITS_LINE - 1).expect("a line"));
    let camera = window.state().camera().expect("a camera");
    let plan = window.state().state().shown().expect("planned").plan();
    let tip = plan.positions[TOO_DEEP].tip;
    let away = camera.target - glam::vec3(tip.x as f32, tip.y as f32, tip.z as f32);
    assert!(away.length() < 30.0, "{away}");
    snapshot_view(&mut window, "checked_program");
    // So do the keys of faults.
    window.key_press(egui::Key::N);
    window.run_steps(4);
    assert_eq!(window.state().state().look.finding, Some((k + 1) % faults.len()));

    // The operation before comes back, and the list can be closed.
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    window.get_by_label("Sort by contact");
    window.get_by_label_contains("Program: ").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Close program").click();
    window.run_steps(3);
    assert!(window.state().state().results.checked.is_none());
    assert!(window.query_by_label_contains("Program: ").is_none());
}

#[test]
fn a_dropped_program_is_checked_and_again_when_the_setup_is_edited() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let text = program(&window);
    let path = write(folder.path(), "deep.apt", &text);
    drop_on(&mut window, &[&path]);
    let least = |window: &Window| {
        let checked = window.state().state().results.checked.clone().expect("checked");
        checked.request.setup.allowances.hub_allowance
    };
    let before = least(&window);
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(before + 1.0);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(least(&window), before + 1.0, "checked with the new allowance");
    assert!(!window.state().state().program_is_stale());
    // A file that changed is read again.
    std::fs::write(&path, "PARTNO/x\nLOADTL/64\nCUTTER/30\nRAPID\nGOTO/0,0,900,0,0,1\nFINI\n")
        .expect("writes");
    window.key_press(egui::Key::F7);
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label_contains("the program cuts nothing: it has no move under feed");
}

#[test]
fn a_program_that_cannot_be_read_is_a_problem_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), "bad.apt", "PARTNO/x\nLOADTL/1\nCUTTER/20\nGOTO/1,2\n");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    check(&mut window, &path);
    let problem = window.state().state().problems.last().cloned().expect("a problem");
    assert!(problem.message.contains("bad.apt:4"), "{problem:?}");
    window.get_by_label("Program: not checked");
}
