//! Checking of programs from anywhere.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::checked::CheckRequest;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::app::tasks::engine::Engine;
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::machine_file::{built_in_names, read_machine};
use vanecut::io::nc::read_post;
use vanecut::io::setup_file::write_setup;
use vanecut::job::post::{PostRequest, post_program};
use vanecut::machine::BlankSize;
use vanecut::monitor::Monitor;
use vanecut::toolpath::ClProgram;
use vanecut::verify::{Fault, FaultKind, verify};

use crate::drop::drop_on;
use crate::fake;
use crate::harness::{
    HANG, Window, choose_in_list, click_enabled, labels, pixels_in, settle, snapshot_view, with_sample,
};
use crate::machine::{axes, choose, held_by_trunnion, with_machine};

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

pub fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("writes");
    path
}

pub fn check(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::CheckProgram, path.to_owned());
    window.run_steps(2);
    settle(window);
}

/// A window with a sample and a checked program, `deep.apt` in `folder`, with faults; and its text.
fn with_checked_program(folder: &Path) -> (Window, String) {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let text = program(&window);
    let path = write(folder, "deep.apt", &text);
    window.set_size(egui::vec2(1200.0, 760.0));
    window.run_steps(3);
    check(&mut window, &path);
    (window, text)
}

#[test]
fn faults_of_a_program_are_a_list_that_leads_to_their_places() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, text) = with_checked_program(folder.path());
    let state = window.state().state();
    assert_eq!(state.look.operation, Operation::Program, "it is shown");
    let checked = state.results.checked.clone().expect("checked");
    // The same faults as those of the core.
    let setup = &state.document.edited.setup;
    let part = &state.document.part.as_ref().expect("open").impeller;
    let program = read_apt_bytes("deep.apt", text.as_bytes()).expect("a program");
    let workpiece = setup.allowances.workpiece_of(Arc::clone(part));
    let verdict = verify(&workpiece, setup, &program, &Monitor::default()).expect("judged");
    let faults: Vec<_> = checked.findings.iter().map(|finding| finding.fault.clone()).collect();
    assert_eq!(faults, verdict.faults);
    window.get_by_label(&format!("Faults {}", faults.len()));
    window.get_by_label(&format!("all {}", program.moves.len()));

    // A click leads to the place.
    let is_it = |fault: &&Fault| fault.line == ITS_LINE && fault.kind == FaultKind::HubAllowance;
    let fault = faults.iter().find(is_it).expect("the plunge that goes too deep");
    let k = faults.iter().position(|other| other == fault).expect("it is one of them");
    let label = format!("Line {ITS_LINE}: {}", fault.message);
    window.get_by_role_and_label(Role::Button, &label).click();
    window.run_steps(8);
    settle(&mut window);
    assert_eq!(window.state().state().look.finding, Some(k));
    window.get_by_label(&format!("{} of {}", 3 * TOO_DEEP + 2, program.moves.len()));
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
    // The timeline says "Program: listing…" until the text of the plan is there.
    let operation = format!("Program: {} faults", faults.len());
    window.get_by_label(&operation).click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Close program").click();
    window.run_steps(3);
    assert!(window.state().state().results.checked.is_none());
    assert!(window.query_by_label(&operation).is_none());
}

/// The ground of the row of fault `k`, its most frequent colour, without the pointer on it.
fn ground_of_row(window: &mut Window, k: usize) -> [u8; 4] {
    window.hover_at(egui::pos2(2.0, 2.0));
    window.run_steps(3);
    let label = fault_label(window, k);
    let rect = window.get_by_role_and_label(Role::Button, &label).rect();
    let mut counts = HashMap::<[u8; 4], usize>::new();
    for pixel in pixels_in(window, rect) {
        *counts.entry(pixel).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count).expect("pixels").0
}

/// Label of the row of fault `k`.
fn fault_label(window: &Window, k: usize) -> String {
    let checked = window.state().state().results.checked.clone().expect("checked");
    let fault = &checked.findings[k].fault;
    format!("Line {}: {}", fault.line, fault.message)
}

#[test]
fn the_selected_fault_is_marked_and_in_view_wherever_the_pointer_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1200.0, 620.0));
    // Every plunge goes too deep: more faults than the list shows at once.
    let plan = window.state().state().shown().expect("planned").plan();
    let mut text = "PARTNO/impeller532\nLOADTL/1\nCUTTER/30\nPPRINT/INSERT WIDTH 1 10\n".to_owned();
    for position in plan.positions.iter().take(12) {
        let (axis, up) = (position.axis, position.evaluation.retract);
        for (words, p) in [("RAPID", up), ("FEDRAT/300,MMPM", position.tip - axis * 3.0), ("RAPID", up)] {
            let [i, j, k] = [axis.x, axis.y, axis.z];
            text += &format!("{words}\nGOTO/{:.6},{:.6},{:.6},{i:.6},{j:.6},{k:.6}\n", p.x, p.y, p.z);
        }
    }
    let path = write(folder.path(), "deep.apt", &(text + "FINI\n"));
    check(&mut window, &path);
    let count = window.state().state().results.checked.as_ref().expect("checked").findings.len();
    assert!(count >= 12, "{count}");
    let label = fault_label(&window, 1);
    window.get_by_role_and_label(Role::Button, &label).click();
    window.run_steps(4);
    settle(&mut window);
    let (plain, marked) = (ground_of_row(&mut window, 0), ground_of_row(&mut window, 1));
    assert_ne!(plain, marked);

    // The keys mark it, too, and the list goes along, to its end and back.
    for (keys, modifiers) in [(count - 2, egui::Modifiers::NONE), (count - 1, egui::Modifiers::SHIFT)] {
        for _ in 0..keys {
            window.key_press_modifiers(modifiers, egui::Key::N);
            window.run_steps(2);
        }
        window.run_steps(6);
        settle(&mut window);
        let k = window.state().state().look.finding.expect("selected");
        assert!(k == 0 || k == count - 1, "{k} of {count}");
        assert_eq!(ground_of_row(&mut window, k), marked, "fault {k} of {count}");
        let label = fault_label(&window, k);
        let row = window.get_by_role_and_label(Role::Button, &label).rect();
        let below = window.get_by_label_contains("Tip ").rect();
        let above = window.get_by_label("Faults").rect();
        assert!(
            row.top() >= above.bottom() && row.bottom() <= below.top() + 1.0,
            "{row:?} in {above:?} to {below:?}"
        );
    }
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
fn an_unfinished_program_is_named_as_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, text) = with_checked_program(folder.path());
    assert!(window.query_by_label_contains("marked as unfinished").is_none());
    let text = text.replace("PARTNO/impeller532", "PARTNO/impeller532 UNFINISHED");
    let path = write(folder.path(), "unfinished.apt", &text);
    check(&mut window, &path);
    window.get_by_label_contains("marked as unfinished");
}

#[test]
fn a_program_that_is_cut_off_is_named_as_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, text) = with_checked_program(folder.path());
    assert!(window.query_by_label_contains("cut off").is_none());
    let whole = "PARTNO/x\nLOADTL/64\nCUTTER/30\nRAPID\nGOTO/0,0,900,0,0,1\nFINI\n";
    assert!(text.trim_end().ends_with("FINI"));
    let path = write(folder.path(), "whole.apt", whole);
    check(&mut window, &path);
    assert!(window.query_by_label_contains("cut off").is_none());
    let cut = text.trim_end().trim_end_matches("FINI");
    let path = write(folder.path(), "cut.apt", cut);
    check(&mut window, &path);
    window.get_by_label_contains("FINI is missing");
    if window.state().state().results.checked.as_ref().expect("checked").findings.is_empty() {
        window.get_by_label("No faults, but the program seems cut off");
    }
    assert!(!window.state().state().results.checked.as_ref().expect("checked").is_complete);
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

#[test]
fn a_check_that_could_not_be_repeated_is_out_of_date() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, text) = with_checked_program(folder.path());
    let path = folder.path().join("deep.apt");
    let again = |window: &mut Window| {
        window.key_press(egui::Key::F7);
        window.run_steps(2);
        settle(window);
        window.query_by_label("Out of date:").is_some()
    };
    assert!(window.query_by_label("Out of date:").is_none());
    std::fs::remove_file(&path).expect("removes");
    assert!(again(&mut window), "the verdict is that of a file that is gone");
    window.get_by_label("Program: out of date");
    write(folder.path(), "deep.apt", &text);
    assert!(!again(&mut window), "checked again");
}

/// Moves the timeline to after `cut` moves.
fn scrub(window: &mut Window, cut: usize) {
    window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(cut as f64);
    window.run_steps(3);
}

#[test]
fn a_checked_program_has_a_timeline_with_its_line_its_tool_and_its_clock() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, text) = with_checked_program(folder.path());
    let moves = read_apt_bytes("deep.apt", text.as_bytes()).expect("a program").moves;
    scrub(&mut window, 5);
    let line = text.lines().nth(moves[4].line - 1).expect("a line");
    window.get_by_label(&format!("Line {}: {line}", moves[4].line));
    assert!(window.query_by_label_contains("X ").is_none(), "no machine, no axes");
    let (now, whole) = window.state().state().clock().expect("a clock");
    assert!(now > 0.0 && now < whole, "{now} of {whole} s");
    // The tool is drawn there.
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    snapshot_view(&mut window, "program_timeline");
    // Selecting a fault moves the timeline there; moving the timeline on deselects the fault.
    window.key_press(egui::Key::N);
    window.run_steps(4);
    let state = window.state().state();
    let first = state.selected_finding().and_then(|finding| finding.first_move).expect("at a move");
    assert_eq!(state.timeline_cut(), Some(first + 1));
    window.key_press(egui::Key::ArrowRight);
    window.run_steps(2);
    let state = window.state().state();
    assert_eq!((state.timeline_cut(), state.look.finding), (Some(first + 2), None));
}

#[test]
fn the_axes_of_an_apt_program_are_those_of_the_machine_of_the_setup() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = with_machine("ac-trunnion");
    let text = program(&window);
    let path = write(folder.path(), "deep.apt", &text);
    check(&mut window, &path);
    let moves = read_apt_bytes("deep.apt", text.as_bytes()).expect("a program").moves;
    for cut in [1, 8, moves.len()] {
        scrub(&mut window, cut);
        let now = axes(&window);
        let stray = held_by_trunnion(&window, &now).angle(&moves[cut - 1].axis).to_degrees();
        assert!(stray < 1e-3, "{now:?} holds the tool {stray}° off move {cut}");
    }
    // Without a machine there is nothing to show. The list of operations, one longer now, moves its field
    // down.
    window.set_size(egui::vec2(1280.0, 1300.0));
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    choose(&mut window, "None");
    settle(&mut window);
    window.get_by_label_contains("Program: ").click();
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().state().results.on_machine.is_none());
}

#[test]
fn the_axes_of_nc_code_are_those_that_it_commands() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 900.0));
    take_tools(&mut window, folder.path());
    let text = nc_program(&window);
    let nc = write(folder.path(), "plan.h", &text);
    check(&mut window, &nc);
    assert_eq!(window.state().state().document.edited.setup.machine.file, None, "the setup has no machine");
    let checked = window.state().state().results.checked.clone().expect("checked");
    let count = checked.program.moves.len();
    for cut in [1, count / 3, count / 2, count] {
        scrub(&mut window, cut);
        let line = checked.program.moves[cut - 1].line;
        // The words of the axes hold until others come; several moves may belong to a line.
        let last = |letter: char| {
            let words = text.lines().take(line).flat_map(str::split_whitespace);
            let values = words.filter_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
            values.last().expect("commanded")
        };
        let is_end = checked.program.moves.get(cut).is_none_or(|next| next.line != line);
        if is_end {
            let now = axes(&window);
            assert_eq!(now.iter().map(|(letter, _)| *letter).collect::<String>(), "XYZAC");
            for (letter, shown) in now.iter().skip(3) {
                assert!((shown - last(*letter)).abs() < 1e-3, "{letter}{shown} at line {line}");
            }
        }
        window.get_by_label_contains(&format!("Line {line}: "));
    }
}

/// The plan as NC code for the machine that is chosen, at first the trunnion.
pub fn nc_program(window: &Window) -> String {
    let state = window.state().state();
    let planned = state.results.planned.clone().expect("planned");
    let part = &planned.outcome.workpiece.part;
    let mut program = ClProgram::of_plan(&part.name, &planned.outcome.after.plan);
    for (number, step) in (1..).zip(&mut program.moves) {
        step.line = number;
    }
    let machine = read_machine(Path::new(state.check_machine())).expect("a machine");
    let request = PostRequest {
        post: read_post(&machine.control).expect("a control"),
        output: machine.output,
        machine,
        inlet_up: part.out_of_inlet().z > 0.0,
        blank: Some(BlankSize::from_part(part, &planned.outcome.setup.allowances)),
        calls: None,
    };
    post_program(&program, &request, &Monitor::default()).expect("it runs").written.text
}

/// Gives the document the tools of the plan: NC code only has their numbers.
pub fn take_tools(window: &mut Window, folder: &Path) {
    let setup = window.state().state().results.planned.as_ref().expect("planned").outcome.setup.clone();
    let path = write(folder, "setup.toml", &write_setup(&setup));
    window.state_mut().open_path(path);
    settle(window);
}

#[test]
fn nc_code_is_checked_as_the_program_it_was_posted_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    take_tools(&mut window, folder.path());
    let faults = |window: &Window| -> Vec<(FaultKind, usize)> {
        let checked = window.state().state().results.checked.clone().expect("checked");
        checked.findings.iter().map(|finding| (finding.fault.kind, finding.fault.line)).collect()
    };
    let kinds = |faults: &[(FaultKind, usize)]| faults.iter().map(|(kind, _)| *kind).collect::<Vec<_>>();
    let planned = window.state().state().results.planned.clone().expect("planned");
    let program = ClProgram::of_plan("impeller532", &planned.outcome.after.plan);
    let apt = write(folder.path(), "plan.apt", &write_apt(&program));
    check(&mut window, &apt);
    let of_apt = kinds(&faults(&window));

    let text = nc_program(&window);
    let nc = write(folder.path(), "plan.h", &text);
    check(&mut window, &nc);
    assert_eq!(kinds(&faults(&window)), of_apt, "the same program");
    let checked = window.state().state().results.checked.clone().expect("checked");
    assert_eq!((checked.kind, checked.name().as_str()), ("Plunge program", "plan.h"));
    window.get_by_label("Plunge program");

    // A digit is wrong: the faults name its line, and the window shows it.
    let lines: Vec<&str> = text.lines().collect();
    let is_cut =
        |k: &usize| lines[*k].contains('Z') && lines[*k].contains('F') && !lines[*k].contains("FMAX");
    let cut = (lines.len() / 2..lines.len()).find(is_cut).expect("a move under feed");
    let deeper = deeper_by_8_mm(lines[cut]);
    let mut changed: Vec<&str> = lines.clone();
    changed[cut] = &deeper;
    let bad = write(folder.path(), "bad.h", &changed.join("\n"));
    check(&mut window, &bad);
    let found = faults(&window);
    let fault = (FaultKind::HubAllowance, cut + 1);
    assert!(found.contains(&fault), "{fault:?}: {found:?}");
    let checked = window.state().state().results.checked.clone().expect("checked");
    let faults = checked.findings.iter().map(|finding| &finding.fault);
    let message = faults.filter(|f| (f.kind, f.line) == fault).map(|f| &f.message).next().expect("it is one");
    let label = format!("Line {}: {message}", cut + 1);
    window.get_by_role_and_label(Role::Button, &label).click_accesskit();
    window.run_steps(6);
    window.get_by_label(deeper.trim());
    let finding = window.state().state().selected_finding().cloned().expect("selected");
    assert!(finding.place.is_some(), "with the tool at its place");
}

/// A line of NC code with its Z lower by 8 mm.
fn deeper_by_8_mm(line: &str) -> String {
    let start = line.find('Z').expect("a Z") + 1;
    let is_number = |c: char| c.is_ascii_digit() || "+-.".contains(c);
    let end = line[start..].find(|c| !is_number(c)).map_or(line.len(), |length| start + length);
    let z: f64 = line[start..end].parse().expect("a number");
    format!("{}{:+.3}{}", &line[..start], z - 8.0, &line[end..])
}

#[test]
fn nc_code_of_another_machine_is_a_problem_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    take_tools(&mut window, folder.path());
    let nc = write(folder.path(), "plan.h", &nc_program(&window));
    check(&mut window, &nc);
    window.get_by_label_contains("Program: ");
    // Other letters of axes, another control.
    window.get_by_role_and_label(Role::ComboBox, "NC machine").click();
    window.run_steps(2);
    let other = built_in_names().find(|name| name.starts_with("bc")).expect("a machine with B and C");
    window.get_by_label(other).click();
    window.run_steps(4);
    settle(&mut window);
    let problem = window.state().state().problems.last().cloned().expect("a problem");
    assert!(problem.message.contains("plan.h:"), "{problem:?}");
}

#[test]
fn a_program_that_was_not_read_is_checked_once_its_control_is_chosen() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    take_tools(&mut window, folder.path());
    let nc = write(folder.path(), "plan.h", &nc_program(&window));
    window.state_mut().look_mut().check_control = Some("fanuc".to_owned());
    check(&mut window, &nc);
    let problem = window.state().state().problems.last().cloned().expect("a problem");
    assert!(problem.help.contains("a program for heidenhain"), "{problem:?}");
    choose_in_list(&mut window, "NC control", "heidenhain");
    settle(&mut window);
    window.get_by_label_contains("Program: ");
    assert!(window.state().state().results.checked.is_some());
    assert!(window.state().state().problems.is_empty(), "{:?}", window.state().state().problems);
}

/// As long as the message about another program stands, that one is meant.
#[test]
fn the_shown_program_is_checked_again_after_one_that_was_not_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, _) = with_checked_program(folder.path());
    let bad = write(folder.path(), "bad.apt", "PARTNO BAD\nGOTO/1,2\nEND\nFINI\n");
    let problems = |window: &Window| window.state().state().problems.len();
    check(&mut window, &bad);
    assert_eq!(problems(&window), 1);
    window.get_by_label("Dismiss").click();
    window.run_steps(3);
    window.key_press(egui::Key::F7);
    window.run_steps(2);
    settle(&mut window);
    assert_eq!(problems(&window), 0, "{:?}", window.state().state().problems);
    let checked = window.state().state().results.checked.clone().expect("checked");
    assert_eq!(checked.request.path, folder.path().join("deep.apt"));
}

#[test]
fn nc_code_of_an_own_post_is_read_with_that_post() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    take_tools(&mut window, folder.path());
    let nc = write(folder.path(), "plan.h", &nc_program(&window));
    let post = include_str!("../../assets/posts/heidenhain.toml");
    let post = write(folder.path(), "own.toml", post);
    window.state_mut().look_mut().check_control = Some("fanuc".to_owned());
    check(&mut window, &nc);
    assert!(window.state().state().results.checked.is_none());
    window.get_by_role_and_label(Role::Button, "Post file…");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::OpenPostOfCheck, post);
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().state().results.checked.is_some(), "{:?}", window.state().state().problems);
}

#[test]
fn a_check_shows_its_progress_and_can_be_cancelled() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, endless) = fake::engine();
    let mut window = with_sample(engine);
    let path = write(folder.path(), "deep.apt", &program(&window));
    endless.store(true, Ordering::SeqCst);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::CheckProgram, path.clone());
    let start = Instant::now();
    // The check reports a progress that is not zero at some time.
    let shows_progress = |window: &Window| {
        let nodes = window.query_all_by(|node| {
            node.value().or_else(|| node.label()).is_some_and(|text| text.starts_with("Checking program "))
        });
        nodes.into_iter().any(|node| {
            let node = node.accesskit_node();
            let text = node.value().or_else(|| node.label()).unwrap_or_default();
            !text.ends_with(" 0 %")
        })
    };
    loop {
        window.step();
        if shows_progress(&window) {
            break;
        }
        assert!(start.elapsed() < HANG, "no progress");
    }
    assert!(labels(&window, "Checking").len() > 2, "verdict, list and status bar say it");
    click_enabled(&window, "Cancel");
    window.run_steps(2);
    assert!(!window.state().is_busy(), "the window does not wait");
    let state = window.state().state();
    assert_eq!(state.notice.as_ref().map(|notice| notice.text.as_str()), Some("Check cancelled"));
    assert!(state.results.checked.is_none());
    // The check itself has ended: the same thread takes the next one.
    endless.store(false, Ordering::SeqCst);
    check(&mut window, &path);
    assert!(window.state().state().results.checked.is_some());
}

#[test]
fn the_lines_of_a_program_have_a_legend() {
    let folder = tempfile::tempdir().expect("a folder");
    let (window, _) = with_checked_program(folder.path());
    for entry in ["T1 Ø30", "rapid", "fault"] {
        window.get_by_label(entry);
    }
}

#[test]
fn a_dropped_program_is_checked_even_if_the_one_before_is_out_of_date() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, text) = with_checked_program(folder.path());
    // The plunges are edited where the program is not shown: it is out of date, and not checked again.
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(1.5);
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().state().program_is_stale());
    let other = write(folder.path(), "other.apt", &text);
    drop_on(&mut window, &[&other]);
    let checked = window.state().state().results.checked.clone().expect("checked");
    assert_eq!(checked.request.path, other, "what was dropped, and not the one before");
    assert!(!window.state().state().program_is_stale());
}

#[test]
fn the_selected_plunge_is_not_drawn_where_plunges_are_not_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, _) = with_checked_program(folder.path());
    let view = |window: &mut Window, selected: Option<usize>| {
        window.state_mut().look_mut().selected = selected;
        window.run_steps(6);
        settle(window);
        let rect = window.get_by_label("3D view").rect();
        pixels_in(window, rect)
    };
    let (without, with) = (view(&mut window, None), view(&mut window, Some(0)));
    assert!(without == with, "the plunge of the other operation is in the view");
}

/// The next NC program may be for another machine, as after an export.
#[test]
fn a_checked_apt_program_is_not_out_of_date_with_another_machine_for_nc_code() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, _) = with_checked_program(folder.path());
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    let look = window.state_mut().look_mut();
    (look.check_machine, look.check_control) = (Some("bc-trunnion".to_owned()), Some("siemens".to_owned()));
    window.run_steps(3);
    settle(&mut window);
    assert!(!window.state().state().program_is_stale());
    assert!(window.query_by_label("Program: out of date").is_none());
}

/// How near shank and holder may come is judged, too.
#[test]
fn a_checked_program_is_out_of_date_with_other_clearances() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, _) = with_checked_program(folder.path());
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    assert!(!window.state().state().program_is_stale());
    let mut setup = window.state().state().document.edited.setup.clone();
    setup.clearances.holder += 1.0;
    let path = write(folder.path(), "setup.toml", &write_setup(&setup));
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::OpenSetup, path);
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().state().program_is_stale());
}

/// It was without faults against another setup.
#[test]
fn a_program_that_is_out_of_date_is_not_said_to_be_without_faults() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let inner = Arc::clone(&engine.check);
    let sound = move |request: &CheckRequest, monitor: &Monitor| {
        let mut checked = inner(request, monitor)?;
        checked.findings.clear();
        Ok(checked)
    };
    let mut window = with_sample(Engine { check: Arc::new(sound), ..engine });
    let path = write(folder.path(), "sound.apt", &program(&window));
    window.set_size(egui::vec2(1200.0, 760.0));
    window.run_steps(3);
    check(&mut window, &path);
    window.get_by_label("No faults");
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(1.5);
    window.run_steps(3);
    window.get_by_label("Program: out of date").click();
    window.run_steps(3);
    assert!(window.query_by_label("No faults").is_none());
    window.get_by_label("No faults, but out of date");
}

/// A post that writes the program again leaves the window with a check of what is no longer there.
#[test]
fn a_program_that_is_written_again_is_out_of_date() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, text) = with_checked_program(folder.path());
    let path = folder.path().join("deep.apt");
    let wait_for = |window: &mut Window, is_there: &dyn Fn(&Window) -> bool| {
        let start = Instant::now();
        while !is_there(window) {
            assert!(start.elapsed() < HANG, "it is not noticed");
            std::thread::sleep(std::time::Duration::from_millis(20));
            window.step();
        }
    };
    let is_stale = |window: &Window| window.state().state().program_is_stale();
    window.run_steps(20);
    assert!(!is_stale(&window), "as it was checked");
    std::fs::write(&path, text.replace("FEDRAT/300", "FEDRAT/1500")).expect("writes");
    wait_for(&mut window, &is_stale);
    window.run_steps(2);
    window.get_by_label("Program: out of date");
    window.get_by_label("The file was written again after this check: check it again");
    window.get_by_label("File written again: check again (F7)");
    assert!(window.query_by_label_contains("Setup edited").is_none(), "no setup was");
    click_enabled(&window, "Check again");
    window.run_steps(2);
    settle(&mut window);
    window.run_steps(20);
    assert!(!is_stale(&window), "the new text was checked");
    assert!(window.query_by_label_contains("The file was written again").is_none());
    std::fs::remove_file(&path).expect("removes");
    wait_for(&mut window, &is_stale);
    window.run_steps(2);
    window.get_by_label_contains("The file is no longer there");
    window.get_by_label("The file of the program is no longer there");
}

/// The export of another operation's plan would be taken for that of what is selected.
#[test]
fn what_is_selected_is_exported_or_why_not_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut window, _) = with_checked_program(folder.path());
    window.state_mut().use_own_file_dialogs();
    let mut refused = |operation: &str, words: &str| {
        window.get_by_label_contains(operation).click();
        window.run_steps(3);
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::E);
        window.run_steps(3);
        assert!(
            window.query_by_role_and_label(Role::TextInput, "File").is_none(),
            "{operation} is not written"
        );
        let notice = window.state().state().notice.clone().expect("it is said");
        assert!(notice.text.contains(words), "{notice:?}");
    };
    refused("Program: ", "A checked program is a file already");
    refused("Flank: ", "Flank has no plan to export yet");
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::E);
    window.run_steps(3);
    window.get_by_role_and_label(Role::TextInput, "File");
}
