//! Results of a study in the window.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::app::model::panels::DockPanel;
use vanecut::app::model::part_source::PartSource;
use vanecut::io::part_file::read_part;
use vanecut::io::part_hash::PartHash;
use vanecut::io::write_setup;
use vanecut::setup::Setup;
use vanecut::study::{RESULT_VERSION, RunResult, RunStatus, merge::merge};

use crate::fake;
use crate::harness::{
    Window, click_enabled, press, sample_in, scaled, settle, snapshot_view, window, with_sample,
};

/// A run: its name, its step, and time in min and 95th percentile of the stock where it has a plan.
type StudyRun = (&'static str, f64, Option<(f64, f64)>);

const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/parts/impeller532.toml");

const RUNS: [StudyRun; 4] = [
    ("00000000000000a1", 10.0, Some((20.0, 2.0))),
    ("00000000000000a2", 8.0, Some((30.0, 1.0))),
    ("00000000000000a3", 6.0, Some((40.0, 1.5))),
    ("00000000000000a4", 4.0, None),
];

/// Hash of the sample part.
fn hash_of_sample() -> String {
    PartHash::from_part(&read_part(Path::new(SAMPLE)).expect("reads")).sha256
}

/// Writes the results of a study of the sample part; returns its folder.
pub fn study(folder: &Path) -> PathBuf {
    let folder = folder.join("study");
    std::fs::create_dir_all(folder.join("runs")).expect("a folder");
    for (id, step, figures) in RUNS {
        let mut setup = Setup::default();
        setup.plunge.step = Some(step);
        let mut known: BTreeMap<String, Option<f64>> = BTreeMap::new();
        if let Some((minutes, stock)) = figures {
            known.insert("time_estimate".to_owned(), Some(60.0 * minutes));
            known.insert("residual_p95".to_owned(), Some(stock));
        }
        let step = format!("{{\"plunge.step\": {step:?}}}");
        let result = RunResult {
            vanecut_study_run: RESULT_VERSION,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            id: id.to_owned(),
            part: "parts/impeller532.toml".to_owned(),
            part_hash: hash_of_sample(),
            varied: serde_json::from_str(&step).expect("a value"),
            setup: write_setup(&setup),
            status: if figures.is_some() { RunStatus::Done } else { RunStatus::Error },
            error: figures.is_none().then(|| "the step is too small".to_owned()),
            policy: Some("minimal".to_owned()),
            tools: vec![30.0],
            figures: known,
            elapsed: 1.0,
        };
        result.write(&folder).expect("writes");
    }
    let ids: Vec<String> = RUNS.iter().map(|(id, ..)| format!("\"{id}\"")).collect();
    let list = format!(
        "{{\"vanecut_study\": {RESULT_VERSION}, \"keys\": [\"plunge.step\"], \"runs\": [{}]}}",
        ids.join(", ")
    );
    std::fs::write(folder.join("study.json"), list).expect("writes");
    folder
}

/// Numbers of the runs as the table lists them.
fn listed(window: &Window) -> Vec<String> {
    let mut rows: Vec<(f32, String)> = window
        .query_all_by(|node| {
            node.role() == Role::Row && node.label().is_some_and(|name| name.starts_with("Run "))
        })
        .filter_map(|node| Some((node.rect().top(), node.accesskit_node().label()?)))
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().map(|(_, name)| name).collect()
}

/// Whether some label begins with `text`.
fn says(window: &Window, text: &str) -> bool {
    window.query_all_by(|node| node.value().is_some_and(|value| value.starts_with(text))).next().is_some()
}

fn open(window: &mut Window, path: PathBuf) {
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::OpenStudy, path);
    settle(window);
}

/// Opens a run of the table as a plan.
fn open_run(window: &mut Window, number: usize) {
    window.get_by_role_and_label(Role::Row, &format!("Run {number}")).click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Open as plan").click();
    window.run_steps(3);
    settle(window);
}

#[test]
fn runs_are_sorted_plotted_and_opened_as_plans() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = study(folder.path()).join("study.json");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 900.0));
    open(&mut window, path);
    window.get_by_label("4 runs, 1 without a plan");
    assert_eq!(listed(&window), ["Run 1", "Run 2", "Run 3", "Run 4"]);
    window.get_by_label("Sort runs by plunge.step, mm").click();
    window.run_steps(3);
    assert_eq!(listed(&window), ["Run 4", "Run 3", "Run 2", "Run 1"], "4 is less than 10");
    window.get_by_label("Sort runs by Stock 95 %, mm").click();
    window.run_steps(3);
    assert_eq!(listed(&window), ["Run 2", "Run 3", "Run 1", "Run 4"]);
    snapshot_view(&mut window, "study");
    // What the plot shows of the runs is found once, not at each frame.
    let passes = window.state().study_passes();
    window.run_steps(5);
    assert_eq!(window.state().study_passes(), passes);
    assert!(passes > 0);

    // The slowest run with a plan is at the right.
    let plot = window.get_by_label("Stock 95 % over Time").rect();
    let selected = |window: &Window| {
        let steps = ["10", "8", "6", "4"];
        steps.into_iter().find(|step| says(window, &format!("plunge.step = {step}")))
    };
    assert_eq!(selected(&window), None);
    let right = plot.right() - 14.0;
    let mut y = plot.top();
    while selected(&window).is_none() && y < plot.bottom() {
        let width = right - plot.left() - 48.0;
        press(&mut window, egui::pos2(right - 0.06 / 1.12 * width, y));
        window.run_steps(2);
        y += 8.0;
    }
    assert_eq!(selected(&window), Some("6"));
    window.get_by_role_and_label(Role::Row, "Run 4").click();
    window.run_steps(3);
    let button = window.get_by_role_and_label(Role::Button, "Open as plan");
    assert!(button.accesskit_node().is_disabled(), "it has no plan");
    window.get_by_label("the step is too small");
    window.state_mut().look_mut().operation = Operation::Flank;
    open_run(&mut window, 2);
    let state = window.state().state();
    assert_eq!(state.look.operation, Operation::Roughing, "what was asked for is shown");
    assert_eq!(state.document.edited.setup.plunge.step, Some(8.0));
    assert!(!state.out_of_date() && state.results.planned.is_some(), "it is calculated");
}

/// The part of a run is known by its content, not by its name.
#[test]
fn a_run_is_planned_with_the_part_that_it_had() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = study(folder.path()).join("study.json");
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.set_size(egui::vec2(1280.0, 900.0));
    // A part of the same name that is another one.
    let elsewhere = folder.path().join("elsewhere");
    std::fs::create_dir_all(&elsewhere).expect("a folder");
    let text = std::fs::read_to_string(SAMPLE).expect("reads");
    let other = text.replacen("name = \"", "name = \"other ", 1);
    assert_ne!(other, text);
    let same_name = elsewhere.join("impeller532.toml");
    std::fs::write(&same_name, &other).expect("writes");
    window.state_mut().open_part(PartSource::File(same_name));
    settle(&mut window);
    open(&mut window, path);
    open_run(&mut window, 2);
    let step = |window: &Window| window.state().state().document.edited.setup.plunge.step;
    assert_ne!(step(&window), Some(8.0), "not with that part");
    window.get_by_label_contains("is not found, and the open one is another");

    // With its part beside the study, changed since.
    let parts = folder.path().join("parts");
    std::fs::create_dir_all(&parts).expect("a folder");
    std::fs::write(parts.join("impeller532.toml"), &other).expect("writes");
    let warned = |window: &Window| {
        window.query_by_label_contains("the part changed after the study was run").is_some()
    };
    assert!(!warned(&window));
    open_run(&mut window, 2);
    assert_eq!(step(&window), Some(8.0));
    assert!(warned(&window));
}

#[test]
fn a_run_is_found_beside_its_table_among_many_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let study = study(folder.path());
    let table = folder.path().join("results.csv");
    let merged = merge(&study).expect("merges");
    std::fs::write(&table, merged.text).expect("writes");
    for k in 0..400 {
        std::fs::write(folder.path().join(format!("{k:03}.apt")), "").expect("writes");
    }
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    open(&mut window, table);
    open_run(&mut window, 2);
    assert_eq!(step(&window), Some(8.0));
}

/// Leaves the project with an edit, a step of 3 mm.
fn edit_step(window: &mut Window) {
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(3.0);
    window.run_steps(3);
    settle(window);
}

fn step(window: &Window) -> Option<f64> {
    window.state().state().document.edited.setup.plunge.step
}

#[test]
fn a_run_of_the_open_part_is_an_edit_that_can_be_undone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = study(folder.path()).join("study.json");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let project = folder.path().join("own.vanecut");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(&mut window);
    edit_step(&mut window);
    open(&mut window, path);
    open_run(&mut window, 2);
    assert!(window.query_by_label_contains("Save the changes of").is_none(), "nothing is lost");
    assert_eq!(step(&window), Some(8.0));
    let document = &window.state().state().document;
    assert_eq!(document.path.as_ref(), Some(&project), "it is the same project");
    assert!(document.is_unsaved(), "with a change");
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(step(&window), Some(3.0), "what was edited before is back");
}

#[test]
fn a_run_of_another_part_does_not_replace_unsaved_work_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = study(folder.path()).join("study.json");
    let parts = folder.path().join("parts");
    std::fs::create_dir_all(&parts).expect("a folder");
    std::fs::copy(SAMPLE, parts.join("impeller532.toml")).expect("copies");
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.state_mut().open_part(PartSource::Sample("pump6".to_owned()));
    settle(&mut window);
    edit_step(&mut window);
    open(&mut window, path);
    open_run(&mut window, 2);
    window.get_by_label("Save the changes of pump6?");
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(step(&window), Some(3.0), "nothing was opened");
    open_run(&mut window, 2);
    window.get_by_label("Don't save").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(step(&window), Some(8.0));
    let document = &window.state().state().document;
    assert_eq!(document.part.as_ref().map(|part| part.impeller.name.as_str()), Some("impeller532"));
}

#[test]
fn a_merged_table_leads_to_its_runs_and_a_damaged_one_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let merged = merge(&study(folder.path())).expect("merges");
    let table = folder.path().join("results.csv");
    std::fs::write(&table, &merged.text).expect("writes");
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    open(&mut window, table);
    open_run(&mut window, 1);
    let said = &window.state().state().problems;
    assert!(said.iter().any(|p| p.message.contains("parts/impeller532.toml, is not found")), "{said:?}");

    // The message stands over the table, which is as large as the window.
    let dismiss = window.get_by_role_and_label(Role::Button, "Dismiss").rect().center();
    press(&mut window, dismiss);
    window.run_steps(3);
    assert!(window.state().state().problems.is_empty(), "the message is in view");

    let damaged = folder.path().join("damaged.csv");
    std::fs::write(&damaged, "a,b\n1\n").expect("writes");
    open(&mut window, damaged);
    let said = &window.state().state().problems;
    assert!(said.iter().any(|p| p.message.contains("damaged.csv:2")), "{said:?}");
}

/// Every column can be read in the smallest window and beside the picture, at any scale.
#[test]
fn the_table_scrolls_with_its_head_and_the_numbers_of_the_runs_in_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = study(folder.path()).join("study.json");
    for (scale, size) in [(0.8, [1600.0, 900.0]), (1.0, [800.0, 500.0]), (2.0, [800.0, 500.0])] {
        for docked in [false, true] {
            let (engine, _) = fake::engine();
            let mut window = sample_in(scaled(engine, scale));
            window.set_size(size.into());
            open(&mut window, path.clone());
            if docked {
                window.state_mut().look_mut().panels.dock(DockPanel::Study);
            }
            window.run_steps(6);
            let head = |window: &Window, name: &str| {
                window.query_by_label(&format!("Sort runs by {name}")).map(|node| node.rect())
            };
            let first = head(&window, "number").expect("the numbers");
            let at = window.get_by_role_and_label(Role::Row, "Run 2").rect().center();
            window.hover_at(at);
            let names =
                ["plunge.step, mm", "Status", "Time, min", "Stock 95 %, mm", "Stock max, mm", "Faults"];
            for name in names {
                for _ in 0..40 {
                    let right = window.get_by_role_and_label(Role::Row, "Run 2").rect().right();
                    if head(&window, name).is_some_and(|rect| rect.right() <= right) {
                        break;
                    }
                    window.event(egui::Event::MouseWheel {
                        unit: egui::MouseWheelUnit::Point,
                        delta: egui::vec2(-40.0, 0.0),
                        phase: egui::TouchPhase::Move,
                        source: egui::MouseWheelSource::Wheel,
                        modifiers: egui::Modifiers::NONE,
                    });
                    window.run_steps(4);
                }
                let rect = head(&window, name);
                let row = window.get_by_role_and_label(Role::Row, "Run 2").rect();
                let whole =
                    rect.is_some_and(|rect| rect.right() <= row.right() && rect.left() >= first.right());
                assert!(whole, "{name} at {scale}, {size:?}, docked {docked}: {rect:?} {row}");
                assert_eq!(head(&window, "number"), Some(first), "it stays");
            }
        }
    }
}
