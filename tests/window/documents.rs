//! Documents of the window: machinability and setup sheet.

use std::path::Path;

use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::flank::region::Region;
use vanecut::flank::{UncutLength, UncutReason};
use vanecut::job::assess::AssessedPart;
use vanecut::job::flank::FlankOutcome;

use crate::dialogs::{name_file, press_enter};
use crate::fake;
use crate::flank::plan_flank;
use crate::harness::{Window, settle, snapshot_ui, with_sample};

/// Asserts that the page at `path` shows pictures, and that all of them are there.
fn assert_pictures(path: &Path, count: usize) {
    let page = std::fs::read_to_string(path).expect("a page");
    let names: Vec<&str> =
        page.split("<img src=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert_eq!(names.len(), count, "{names:?}");
    for name in names {
        let size = std::fs::metadata(path.with_file_name(name)).expect("a picture").len();
        assert!(size > 500, "{name} has {size} bytes");
    }
}

fn save(window: &mut Window, path: &Path) {
    window.run_steps(3);
    settle(window);
    name_file(window, path);
    press_enter(window);
}

#[test]
fn the_machinability_is_shown_and_saved_as_the_command_line_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1200.0, 900.0));
    window.state_mut().use_own_file_dialogs();
    window.run_steps(3);
    window.key_press(egui::Key::A);
    window.run_steps(3);
    settle(&mut window);
    let state = window.state().state();
    let part = state.document.part.as_ref().expect("open").impeller.clone();
    let measured = AssessedPart::from_part(part, &state.document.edited.setup);
    window.get_by_label(&format!("{:.2} mm", measured.assessment.largest_cutter()));
    window.get_by_label("Twist of the camber lines");
    assert!(!measured.sections().is_empty());
    snapshot_ui(&mut window, "machinability");

    window.get_by_label("Save machinability page…").click();
    let path = folder.path().join("wheel.html");
    save(&mut window, &path);
    assert_pictures(&path, 5);
    let page = std::fs::read_to_string(&path).expect("written");
    let figures = [measured.assessment.largest_cutter(), measured.assessment.depth()];
    assert!(figures.iter().all(|figure| page.contains(&format!("<td>{figure:.2}</td>"))), "{page}");
    for blade in &measured.assessment.blades {
        let twist = blade.twisting().to_degrees();
        assert!(page.contains(&blade.name) && page.contains(&format!("<td>{twist:.1}°</td>")), "{page}");
    }
    let map = measured.assessment.reach.as_ref().expect("measured");
    assert!(page.contains(&format!("<td>{:.1}</td>", 100.0 * map.share(|sides| sides.any))), "{page}");

    window.key_press(egui::Key::A);
    window.run_steps(3);
    assert!(window.query_by_label("Twist of the camber lines").is_none(), "the same key closes it");
}

#[test]
fn the_setup_sheet_is_that_of_the_shown_plan() {
    let folder = tempfile::tempdir().unwrap();
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    window.get_by_label("File").click();
    window.run_steps(2);
    window.get_by_label("Export setup sheet…").click();
    let path = folder.path().join("sheet.html");
    save(&mut window, &path);
    // The fake plan leaves floor uncut, which is asked about.
    if let Some(button) = window.query_by_label("Export anyway") {
        button.click();
        window.run_steps(3);
        settle(&mut window);
    }
    assert_pictures(&path, 4);
    let page = std::fs::read_to_string(&path).unwrap();
    let positions = window.state().state().position_count();
    assert!(page.contains("setup sheet") && page.contains("<h2>Sections</h2>"));
    assert!(page.contains(&format!("<td>{positions}</td>")), "the plunges of the shown plan");
    // As `verify` has it: what is unknown was not checked.
    assert!(page.contains("Shank and holder of tool 1 are unknown and were not checked."));
    assert!(!page.contains("a cylinder of twice"));
}

/// Window and sheet give the length of the passes that are left out with the same digits.
#[test]
fn the_sheet_of_a_flank_plan_gives_lengths_as_the_window_does() {
    let folder = tempfile::tempdir().unwrap();
    let (engine, _) = fake::engine();
    let flank = |outcome: &mut FlankOutcome| {
        let why = UncutReason::new("too short");
        let left = UncutLength { layer: 0, region: Region::INLET, length: 0.62, why, overhang: None };
        outcome.plan.uncut = vec![left];
    };
    let mut window = with_sample(fake::with_changed_flank(engine, flank));
    plan_flank(&mut window, 10.0);
    window.set_size(egui::vec2(1280.0, 900.0));
    window.run_steps(8);
    window.get_by_label("0.6 mm of passes are skipped:");
    let path = folder.path().join("sheet.html");
    let ctx = window.ctx.clone();
    let purpose = Purpose::ExportSheet { operation: Operation::Flank };
    window.state_mut().file_chosen(&ctx, purpose, path.clone());
    window.run_steps(3);
    window.get_by_label("Export anyway").click();
    window.run_steps(3);
    settle(&mut window);
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page.contains("0.6 mm of passes are left out; the longest stretch, on layer 1: too short."));
    assert!(page.contains("<td>0.6</td>") && page.contains("<td>0</td>"), "by layer");
}
