//! The timeline while it plays.

use std::collections::BTreeSet;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::cutter_colours::{CutterClass, CutterLegend};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::state::ShownPlan;
use vanecut::io::apt::read_apt;
use vanecut::job::PlanOutcome;
use vanecut::toolpath::{ClProgram, Travel};

use crate::fake;
use crate::harness::{
    Window, labels, press, settle, snapshot_view, snapshot_view_without_path, with_sample, words,
};

/// A window with many plunges in small steps.
fn with_many() -> Window {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1400.0, 700.0));
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(1.0);
    window.run_steps(3);
    settle(&mut window);
    window
}

fn choose_speed(window: &mut Window, entry: &str) {
    window.get_by_role_and_label(Role::Button, "Play speed").click();
    window.run_steps(2);
    window.get_by_label(entry).click();
    window.run_steps(2);
}

#[test]
fn the_table_shows_the_position_that_is_being_cut() {
    let mut window = with_many();
    choose_speed(&mut window, "4×");
    window.key_press(egui::Key::Space);
    window.step();
    let mut seen = 0;
    for _ in 0..14 {
        window.step();
        let Some(cut) = window.state().state().look.cut_count.filter(|&cut| cut > 0) else { continue };
        window.get_by_role_and_label(Role::Row, &format!("Position {cut}"));
        seen += 1;
    }
    let cut = window.state().state().look.cut_count.expect("playing");
    assert!(seen > 8 && cut > 100, "fast: {cut} positions in {seen} pictures");
}

#[test]
fn going_to_the_end_while_it_plays_stays_there() {
    let mut window = with_many();
    choose_speed(&mut window, "4×");
    window.key_press(egui::Key::Space);
    window.run_steps(4);
    assert!(window.state().state().look.playing.is_some(), "it plays");
    window.get_by_role_and_label(Role::Button, "Go to end").click();
    window.run_steps(6);
    let count = window.state().state().position_count();
    window.get_by_label(&format!("all {count}"));
    assert!(window.state().state().look.playing.is_none(), "nothing is left to play");
}

#[test]
fn playing_can_loop_and_has_a_clock() {
    let mut window = with_many();
    let count = window.state().state().position_count();
    let (now, whole) = window.state().state().clock().expect("a clock");
    assert!(now == whole && whole > 60.0, "at the end: {now} of {whole} s");
    window.get_by_role_and_label(Role::Button, "Play speed").click();
    window.run_steps(2);
    window.get_by_label("Loop").click();
    window.run_steps(2);
    window.key_press(egui::Key::Escape);
    choose_speed(&mut window, "64×");
    window.key_press(egui::Key::Space);
    window.run_steps(2);
    let cuts: Vec<usize> = (0..12)
        .map(|_| {
            window.step();
            window.state().state().look.cut_count.unwrap_or(count)
        })
        .collect();
    assert!(window.state().state().look.playing.is_some(), "it goes on");
    assert!(cuts.windows(2).any(|pair| pair[1] < pair[0]), "from the start again: {cuts:?}");
    window.get_by_label_contains(" of 0:");
    window.key_press(egui::Key::Space);
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Go to start").click();
    window.run_steps(2);
    assert_eq!(window.state().state().clock().map(|(now, _)| now), Some(0.0));
}

#[test]
fn a_click_on_a_class_of_the_legend_hides_its_cutters() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 700.0));
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    let tip = window.state().state().shown().expect("planned").plan().positions[8].clone();
    let inside = tip.tip + tip.axis * 3.0;
    let pick = |window: &mut Window| {
        let rect = window.get_by_label("3D view").rect();
        let camera = window.state().camera().expect("a camera");
        let point = glam::vec3(inside.x as f32, inside.y as f32, inside.z as f32);
        let pixel = camera.project(point, glam::vec2(rect.width(), rect.height())).expect("in front");
        window.state_mut().look_mut().selected = None;
        press(window, rect.min + egui::vec2(pixel.x, pixel.y));
        window.run_steps(3);
        window.state().state().look.selected
    };
    assert!(pick(&mut window).is_some(), "a cutter is there");
    window.get_by_role_and_label(Role::Button, "blocked, 3 %");
    window.get_by_role_and_label(Role::Button, "OK, 97 %").click();
    window.run_steps(4);
    settle(&mut window);
    assert_eq!(pick(&mut window), None, "hidden");
    snapshot_view(&mut window, "class_hidden");
    window.get_by_role_and_label(Role::Button, "OK, 97 %").click();
    window.run_steps(4);
    assert!(pick(&mut window).is_some(), "shown again");
}

/// Chooses in the menu of layers what the colours of cutters show.
fn colour_by(window: &mut Window, entry: &str) {
    window.get_by_role_and_label(Role::Button, "Layers").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::RadioButton, entry).click();
    window.run_steps(2);
    window.key_press(egui::Key::Escape);
    window.run_steps(4);
    settle(window);
}

#[test]
fn every_tool_and_section_has_a_colour_of_its_own() {
    let mut window = with_sample(fake::engine_of_sections(9));
    window.set_size(egui::vec2(1200.0, 700.0));
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    for (entry, first, last) in [("Tool", "T1 Ø30, ", "T9 Ø30, "), ("Section", "Section 1, ", "Section 9, ")]
    {
        colour_by(&mut window, entry);
        for name in [first, last] {
            window.get_by_label_contains(name);
        }
        let state = window.state().state();
        let shown = state.shown().expect("planned");
        let colours_by = state.look.layers.cutter_colours;
        let legend = colours_by.legend(&[shown], state.look.units);
        let Some(CutterLegend::Classes(classes)) = legend else { panic!("classes: {legend:?}") };
        let colours: BTreeSet<[u8; 3]> =
            classes.iter().map(|class| class.colour.map(|x| (255.0 * x) as u8)).collect();
        assert_eq!((classes.len(), colours.len()), (9, 9), "{classes:?}");
        let of_cutters = colours_by.of_plan(&shown, &colours_by.key(&[shown]));
        let drawn: BTreeSet<[u8; 3]> =
            of_cutters.expect("colours").into_iter().map(|c| c.map(|x| (255.0 * x) as u8)).collect();
        assert_eq!(drawn, colours, "the legend explains what is drawn");
    }
    snapshot_view(&mut window, "many_sections");
    // The last class is beyond the edge of the strip: scrolled into view, a click hides it.
    window.get_by_label_contains("Section 9, ").click_accesskit();
    window.run_steps(4);
    let hidden = &window.state().state().look.hidden_classes;
    assert_eq!(hidden[..], [CutterClass::Section(8)]);
}

#[test]
fn cutters_are_coloured_by_tool_lead_angle_or_time_with_a_legend() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1200.0, 700.0));
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    colour_by(&mut window, "Tool");
    window.get_by_label("T1 Ø30, 100 %");
    colour_by(&mut window, "Section");
    window.get_by_label("Section 1, 100 %");
    colour_by(&mut window, "Feed rate");
    window.get_by_label("300 mm/min");
    colour_by(&mut window, "Lead angle");
    let plan = window.state().state().shown().expect("planned").plan();
    let last = plan.positions[plan.positions.len() - 1].alpha_rad.to_degrees();
    window.get_by_label("2.0°");
    window.get_by_label(&format!("{last:.1}°"));
    snapshot_view(&mut window, "cutters_by_lead_angle");
    colour_by(&mut window, "Time");
    window.get_by_label("0 min");
    colour_by(&mut window, "State");
    assert!(window.query_by_label("0 min").is_none(), "states have no scale");
}

#[test]
fn the_clock_counts_every_move_of_a_plunge() {
    let (engine, _) = fake::engine();
    let lifted = move |outcome: &mut PlanOutcome| {
        for position in &mut outcome.after.plan.positions {
            position.evaluation.motion.lead_out = position.axis * 3.0;
        }
    };
    let window = with_sample(fake::with_changed_plans(engine, lifted));
    let state = window.state().state();
    let program = ClProgram::of_plan("", state.shown().expect("planned").plan());
    assert_eq!(program.moves.len(), 4 * state.position_count());
    assert_eq!(state.clock().map(|(_, whole)| whole), Travel::clock(&program).last().copied());
}

#[test]
fn the_line_of_the_exported_program_stands_below_the_timeline() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 760.0));
    window.run_steps(3);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("plunge.apt");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels: 1 }, path.clone());
    settle(&mut window);
    let text = std::fs::read_to_string(&path).expect("exported");
    let lines: Vec<&str> = text.lines().collect();
    let moves = read_apt(&path).expect("a program").moves;

    window.get_by_role_and_label(Role::Button, "Go to start").click();
    window.run_steps(2);
    window.get_by_label(&format!("Line 1: {}", lines[0]));
    for _ in 0..5 {
        window.key_press(egui::Key::ArrowRight);
        window.run_steps(2);
    }
    // Rapid, cut, rapid: the cut of the fifth plunge.
    let line = moves[3 * 4 + 1].line;
    let shown = labels(&window, &format!("Line {line}: ")).pop().expect("its line");
    let statement = shown.trim_start_matches(&format!("Line {line}: "));
    let begin = lines[line - 1].trim_end_matches('$');
    assert!(begin.starts_with("GOTO/") && statement.starts_with(begin), "{statement} and {begin}");
    assert_eq!(statement.split(',').count(), 6, "with what the next line continues: {statement}");
    // The stock under the timeline is computed in the background.
    settle(&mut window);
    snapshot_view_without_path(&mut window, "program_line");
    // The other plan has another program.
    window.key_press(egui::Key::B);
    window.run_steps(2);
    settle(&mut window);
    assert_ne!(labels(&window, "Line "), [shown]);
}

#[test]
fn the_place_under_the_pointer_says_how_it_is_cut() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 760.0));
    window.run_steps(3);
    let count = window.state().state().position_count();
    let rect = window.get_by_label("Timeline").rect();
    window.hover_at(rect.center());
    window.run_steps(8);
    let half = labels(&window, "Position ").pop().expect("a tooltip");
    let number: usize = half.trim_start_matches("Position ").parse().expect("a number");
    assert!(number.abs_diff(count / 2) <= 1, "{number} of {count}");
    window.get_by_label_contains("300 mm/min, 1200 rev/min");
    window.get_by_label_contains("Cut after 0:");
    // The same of a row.
    window.get_by_label("Position 3").hover();
    window.run_steps(8);
    window.get_by_label_contains("300 mm/min, 1200 rev/min");
    window.get_by_label_contains("Cut after 0:");
    // And among the figures of a selected position.
    window.get_by_label("Position 3").click();
    window.run_steps(3);
    // The sectional view takes its height when it arrives.
    settle(&mut window);
    window.get_by_label("Figures").click();
    window.run_steps(3);
    for name in ["Feed rate, speed", "Cut after", "Program line"] {
        window.get_by_label(name);
    }
}

/// A tool that only one of the plans has is in the legend of both, and one colour means one tool.
#[test]
fn the_legend_of_both_views_is_of_both_plans() {
    let engine = fake::engine_of_sections(3);
    let without_first = move |outcome: &mut PlanOutcome| {
        outcome.after.plan.positions.retain(|position| position.section > 0);
    };
    let mut window = with_sample(fake::with_changed_plans(engine, without_first));
    window.set_size(egui::vec2(1300.0, 700.0));
    window.run_steps(4);
    colour_by(&mut window, "Tool");
    assert!(window.query_by_label_contains("T1 Ø30, ").is_none(), "the plan after does not use it");
    for view in ["Both", "Wipe"] {
        window.get_by_label(view).click();
        window.run_steps(4);
        settle(&mut window);
        let text = words(&window, "T1 Ø30, ").expect("in the legend of the plan before");
        assert!(text.ends_with("/0 %"), "{text}");
        let state = window.state().state();
        let (by, in_view) = (state.look.layers.cutter_colours, state.plans_in_view());
        let key = by.key(&in_view);
        let colour_of_t2 = |shown: &ShownPlan| {
            let k = shown.plan().positions.iter().position(|p| p.section == 1).expect("a plunge of T2");
            by.of_plan(shown, &key).expect("colours")[k]
        };
        assert_eq!(colour_of_t2(&in_view[0]), colour_of_t2(&in_view[1]), "{view}");
    }
}
