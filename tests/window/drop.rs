//! Files dropped on the window.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::io::flank_file::write_flank;
use vanecut::io::part_file::read_part;
use vanecut::io::plan_file::write_plan;
use vanecut::plunge::PlungePlan;
use vanecut::setup::AxisPolicy;

use crate::fake;
use crate::flank::plan_flank;
use crate::harness::{Window, settle, window, with_sample};

/// A file as the desktop passes it to the window.
#[derive(Debug)]
struct OnDisk(PathBuf);

impl egui::DroppedFile for OnDisk {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// Drops files on a window, and waits until all tasks are done.
pub fn drop_on(window: &mut Window, paths: &[&Path]) {
    let files = paths.iter().map(|path| Arc::new(OnDisk(path.to_path_buf())) as egui::DroppedFileHandle);
    window.input_mut().dropped_files = files.collect();
    window.step();
    // The harness keeps its input from frame to frame.
    window.input_mut().dropped_files.clear();
    settle(window);
}

fn part_name(window: &Window) -> Option<String> {
    window.state().state().document.part.as_ref().map(|part| part.impeller.name.clone())
}

/// Writes a file `name` into `folder`; returns its path.
fn file_in(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("writes");
    path
}

fn step(window: &Window) -> Option<f64> {
    window.state().state().document.edited.setup.plunge.step
}

#[test]
fn part_setup_and_project_open_where_they_are_dropped() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| file_in(folder.path(), name, text);
    let part = file("wheel.toml", include_str!("../../assets/parts/pump6.toml"));
    let setup = file("fine.toml", "[plunge]\nstep = 6.5\n");
    let machine = file("machine.toml", "[machine]\nmax_axis_tilt = 80\n");
    let (engine, _) = fake::engine();
    let mut first = window(engine.clone());
    drop_on(&mut first, &[&part]);
    assert_eq!(part_name(&first).as_deref(), Some("pump6"));
    assert!(first.state().state().results.planned.is_some(), "planned at once");
    drop_on(&mut first, &[&setup]);
    assert_eq!(step(&first), Some(6.5), "the setup");
    assert_eq!(part_name(&first).as_deref(), Some("pump6"), "the part stays");
    let project = folder.path().join("p.vanecut");
    let ctx = first.ctx.clone();
    first.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(&mut first);
    drop_on(&mut first, &[&machine]);
    let tilt = first.state().state().document.edited.setup.machine.max_axis_tilt_rad.to_degrees();
    assert!((tilt - 80.0).abs() < 1e-9, "a setup that knows nothing but the machine: {tilt}");

    let mut second = window(engine.clone());
    drop_on(&mut second, &[&project]);
    assert_eq!((part_name(&second).as_deref(), step(&second)), (Some("pump6"), Some(6.5)), "the project");

    let part = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cc_autoblade/cc_autoblade.geomTurbo");
    let mut third = window(engine);
    drop_on(&mut third, &[&setup, &part]);
    assert_eq!(
        (part_name(&third).as_deref(), step(&third)),
        (Some("cc_autoblade"), Some(6.5)),
        "both at once"
    );
}

#[test]
fn a_dropped_part_asks_before_unsaved_work_is_lost_and_a_strange_file_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = folder.path().join("wheel.toml");
    std::fs::write(&part, include_str!("../../assets/parts/pump6.toml")).expect("writes");
    let strange = folder.path().join("letter.txt");
    std::fs::write(&strange, "Dear machinist").expect("writes");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    drop_on(&mut window, &[&strange]);
    let problems = window.state().state().problems.clone();
    assert!(problems.iter().any(|p| p.message.contains("letter.txt")), "{problems:?}");
    assert_eq!(part_name(&window).as_deref(), Some("impeller532"), "what was open stays");

    window.get_by_role_and_label(egui::accesskit::Role::SpinButton, "Step").set_value_accesskit(5.0);
    window.run_steps(2);
    settle(&mut window);
    drop_on(&mut window, &[&part]);
    window.get_by_label("Save the changes of impeller532?");
    assert_eq!(part_name(&window).as_deref(), Some("impeller532"), "not before the answer");
    window.get_by_label("Don't save").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(part_name(&window).as_deref(), Some("pump6"));
}

/// A plan of the command line holds its part and setup.
#[test]
fn a_plan_opens_with_its_part_and_setup() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let first = with_sample(engine.clone());
    let planned = first.state().state().results.planned.clone().expect("planned");
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/parts/impeller532.toml");
    let description = read_part(Path::new(sample)).expect("a part");
    let mut setup = planned.outcome.setup.clone();
    setup.plunge.step = Some(7.25);
    let plan = folder.path().join("plan.json");
    std::fs::write(&plan, write_plan(&description, &setup, &planned.outcome.after.plan, 1)).expect("writes");

    let mut second = window(engine.clone());
    drop_on(&mut second, &[&plan]);
    assert_eq!(part_name(&second).as_deref(), Some("impeller532"), "{:?}", second.state().state().problems);
    let document = &second.state().state().document;
    assert_eq!((step(&second), &document.edited.setup.tools), (Some(7.25), &setup.tools));
    assert!(second.state().state().results.planned.is_some(), "calculated");
    assert_eq!(document.edited.setup.plunge.axis, AxisPolicy::Minimal);
    // A plan by another strategy than that of the setup opens as what it is.
    let by_rule = PlungePlan { policy: AxisPolicy::Monotone, ..planned.outcome.after.plan.clone() };
    let other = folder.path().join("monotone.json");
    let text = write_plan(&description, &setup, &by_rule, 1);
    // So does one of an older version, whose setup says nothing of it.
    let older = text.replace("axis = \\\"monotone\\\"", "axis = \\\"minimal\\\"");
    assert_ne!(older, text);
    for text in [text, older] {
        std::fs::write(&other, text).expect("writes");
        let mut window = window(engine.clone());
        drop_on(&mut window, &[&other]);
        assert_eq!(window.state().state().document.edited.setup.plunge.axis, AxisPolicy::Monotone);
        let result = window.state().state().results.planned.clone().expect("calculated");
        assert_eq!(result.outcome.after.plan.policy, AxisPolicy::Monotone);
    }
    // A project of it finds the part again.
    let project = folder.path().join("p.vanecut");
    let ctx = second.ctx.clone();
    second.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(&mut second);
    let mut third = window(engine);
    drop_on(&mut third, &[&project]);
    assert_eq!((part_name(&third).as_deref(), step(&third)), (Some("impeller532"), Some(7.25)));
    // A plan is not a program.
    third.state_mut().file_chosen(&ctx, Purpose::CheckProgram, plan);
    settle(&mut third);
    let said = &third.state().state().problems;
    assert!(said.iter().any(|p| p.message.contains("is a plan, not a program")), "{said:?}");
    // A JSON file that is not a plan is refused with its name.
    let strange = folder.path().join("strange.json");
    std::fs::write(&strange, "{\"a\": 1}").expect("writes");
    drop_on(&mut third, &[&strange]);
    let said = &third.state().state().problems;
    assert!(said.iter().any(|p| p.message.contains("strange.json")), "{said:?}");
}

#[test]
#[ignore = "a flank plan of its own; scripts/nightly runs it"]
fn a_flank_plan_opens_as_one_and_plunges_are_not_planned_with_its_tool() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let engine = fake::with_few_passes(engine);
    let mut first = with_sample(engine.clone());
    plan_flank(&mut first, 8.0);
    let outcome = first.state().state().results.flank.clone().expect("planned");
    let number = outcome.plan.tool.number;
    assert_eq!(outcome.setup.tools.len(), 1, "the chosen tool is filled in");
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/parts/impeller532.toml");
    let description = read_part(Path::new(sample)).expect("a part");
    let plan = folder.path().join("flank.json");
    std::fs::write(&plan, write_flank(&description, &outcome.setup, &outcome.plan, &[], 1)).expect("writes");

    let mut second = window(engine);
    drop_on(&mut second, &[&plan]);
    let state = second.state().state();
    let setup = &state.document.edited.setup;
    assert_eq!((setup.tools.len(), setup.flank.tool), (0, Some(number)));
    assert_eq!(state.look.operation, Operation::Flank);
    let again = state.results.flank.as_ref().expect("calculated");
    assert_eq!(again.plan.tool, outcome.plan.tool);
    assert!(state.results.planned.is_some(), "roughing as well");
}

#[test]
fn a_part_dropped_with_a_setup_asks_too_and_nothing_opens_beneath_the_question() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| file_in(folder.path(), name, text);
    let part = file("wheel.toml", include_str!("../../assets/parts/pump6.toml"));
    let setup = file("fine.toml", "[plunge]\nstep = 6.5\n");
    let letter = file("letter.txt", "Dear machinist");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_role_and_label(egui::accesskit::Role::SpinButton, "Step").set_value_accesskit(5.0);
    window.run_steps(2);
    settle(&mut window);
    let question = "Save the changes of impeller532?";
    // What cannot be opened is refused without a question.
    drop_on(&mut window, &[&letter]);
    assert!(window.query_by_label(question).is_none());
    let said = window.state().state().problems.last().cloned().expect("a problem");
    assert!(said.message.contains("letter.txt") && said.help.contains(".vanecut"), "{said:?}");
    drop_on(&mut window, &[folder.path()]);
    let said = window.state().state().problems.last().cloned().expect("a problem");
    assert!(said.message.contains("this is a folder"), "{said:?}");
    drop_on(&mut window, &[&part, &setup]);
    window.get_by_label(question);
    assert_eq!((part_name(&window).as_deref(), step(&window)), (Some("impeller532"), Some(5.0)));
    // A second drop waits for the answer to the first.
    drop_on(&mut window, &[&setup]);
    assert_eq!(step(&window), Some(5.0));
    let said = window.state().state().problems.last().cloned().expect("a problem");
    assert!(said.message.contains("while a question was open"), "{said:?}");
    window.get_by_label("Don't save").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!((part_name(&window).as_deref(), step(&window)), (Some("pump6"), Some(6.5)));
    assert!(window.state().state().problems.is_empty(), "what was not opened is over");
    // Two parts are not one project.
    drop_on(&mut window, &[&part, &part]);
    let said = window.state().state().problems.last().cloned().expect("a problem");
    assert!(said.message.contains("cannot be opened together"), "{said:?}");
    drop_on(&mut window, &[&setup]);
    assert!(window.state().state().problems.is_empty(), "a setup that opens ends the message, too");
}

#[test]
fn a_file_over_the_window_is_seen() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    assert!(window.query_by_label("Drop to open").is_none());
    window.input_mut().hovered_files = vec![egui::HoveredFile::default()];
    window.run_steps(2);
    window.get_by_label("Drop to open");
    window.input_mut().hovered_files.clear();
    window.run_steps(2);
    assert!(window.query_by_label("Drop to open").is_none());
}

/// Bytes that this process has read from files.
#[cfg(target_os = "linux")]
fn bytes_read() -> u64 {
    let text = std::fs::read_to_string("/proc/self/io").expect("Linux counts them");
    let line = text.lines().find_map(|line| line.strip_prefix("rchar: "));
    line.and_then(|count| count.parse().ok()).expect("a count")
}

/// Plans of whole wheels are long.
#[cfg(target_os = "linux")]
#[test]
fn a_plan_is_read_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let planned = window.state().state().results.planned.clone().expect("planned");
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/parts/impeller532.toml");
    let description = read_part(Path::new(sample)).expect("a part");
    let plan = folder.path().join("plan.json");
    let outcome = &planned.outcome;
    let mut text = write_plan(&description, &outcome.setup, &outcome.after.plan, 1);
    // So long that what other tests read meanwhile does not matter.
    text.push_str(&" ".repeat(60 << 20));
    std::fs::write(&plan, &text).expect("writes");
    let before = bytes_read();
    drop_on(&mut window, &[&plan]);
    let read = bytes_read() - before;
    assert!(window.state().state().problems.is_empty(), "{:?}", window.state().state().problems);
    assert!(read < text.len() as u64 * 3 / 2, "{read} bytes of {}", text.len());
}
