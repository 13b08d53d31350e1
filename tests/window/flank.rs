//! Flank milling in the window.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::figures::format_duration;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::app::model::planned::Side;
use vanecut::app::model::release;
use vanecut::app::model::solid::SolidSource;
use vanecut::app::model::units::DisplayUnits;
use vanecut::app::model::verdict;
use vanecut::app::tasks::engine::Engine;
use vanecut::drawing::flank::{FlankColours, wall_deviations, wall_scale_end};
use vanecut::flank::choice::selectable;
use vanecut::flank::region::Region;
use vanecut::flank::{UncutLength, UncutReason};
use vanecut::io::nc::Dialect;
use vanecut::io::tool_library::flank_cutters;
use vanecut::job::flank::{FlankOutcome, FlankRequest};
use vanecut::monitor::Monitor;
use vanecut::plunge::Condition;
use vanecut::setup::FlankStrategy;
use vanecut::toolpath::Travel;
use vanecut::verify::FlankVerdict;

use crate::channels::show_channels;
use crate::fake;
use crate::harness::{
    HANG, Window, choose_in_file_menu, choose_in_list, click_enabled, labels, pixels_in, settle,
    snapshot_view, with_sample, words,
};

/// Sets the depth of the layers in the panel of flank milling, mm.
pub fn set_depth(window: &mut Window, depth: f64) {
    let field = window.get_by_role_and_label(Role::Slider, "Layer depth");
    field.set_value_accesskit(depth);
    window.run_steps(4);
    settle(window);
}

/// Plans flank milling in layers of `depth`, mm.
pub fn plan_flank(window: &mut Window, depth: f64) {
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    set_depth(window, depth);
    window.key_press(egui::Key::F6);
    window.run_steps(2);
    settle(window);
}

/// In the list of operations and in the headline.
#[test]
fn stretches_that_are_skipped_are_named_in_every_verdict() {
    let (engine, _) = fake::engine();
    let flank = move |outcome: &mut FlankOutcome| {
        let (why, overhang) = (UncutReason::new("no axis is free there"), None);
        let left = UncutLength { layer: 0, region: Region::INLET, length: 12.0, why, overhang };
        let why = UncutReason::new("too short");
        let short = UncutLength { length: 0.5, why, ..left.clone() };
        outcome.plan.uncut = vec![short, left.clone(), UncutLength { layer: 1, ..left }];
    };
    let mut window = with_sample(fake::with_changed_flank(engine, flank));
    plan_flank(&mut window, 10.0);
    window.get_by_label("Flank: 3 stretches skipped");
    // The reasons, the longest first: under the pointer, and in the panel.
    let at = window.get_by_label("3 stretches skipped").rect().center();
    window.hover_at(at);
    window.run_steps(20);
    let tip = labels(&window, "Stretches of passes");
    assert_eq!(tip, ["Stretches of passes that are not cut:\nno axis is free there: 2\ntoo short: 1"]);
    window.hover_at(egui::pos2(5.0, 5.0));
    window.set_size(egui::vec2(1280.0, 900.0));
    window.run_steps(8);
    let row = |reason: &str| window.get_by_label(reason).rect();
    let (first, second) = (row("No axis is free there"), row("Too short"));
    assert!(first.top() < second.top(), "{first} {second}");
    for (length, row) in [("2 stretches, 24.0 mm", first), ("1 stretch, 0.5 mm", second)] {
        let below = window.get_by_label(length).rect();
        assert!((0.0..10.0).contains(&(below.top() - row.bottom())), "{length}: {below} {row}");
    }
}

/// As in roughing, where the floor that is not machined is.
#[test]
fn what_is_left_of_floor_and_walls_is_named_in_every_verdict() {
    type Change = fn(&mut FlankVerdict);
    let cases: [(Change, &str, &str); 2] = [
        (
            |verdict| verdict.uncovered.gap = 0.25,
            "25.0 % of the floor in gaps",
            "25.0 % of the floor keeps more",
        ),
        (
            |verdict| verdict.unmilled_wall_share = 0.3,
            "30.0 % of the walls not milled",
            "30.0 % of the walls is not milled",
        ),
    ];
    for (change, headline, concern) in cases {
        let (engine, _) = fake::engine();
        let flank = move |outcome: &mut FlankOutcome| change(outcome.verdict.as_mut().expect("verified"));
        let mut window = with_sample(fake::with_changed_flank(engine, flank));
        plan_flank(&mut window, 10.0);
        window.get_by_label(&format!("Flank: {headline}"));
        let outcome = window.state().state().results.flank.clone().expect("planned");
        let (condition, _) = verdict::of_flank(window.state().state(), &outcome);
        assert_eq!(condition, Condition::Blocked);
        let concerns = release::concerns(window.state().state(), Purpose::ExportFlank { channels: 1 }, 1);
        assert!(concerns.iter().any(|text| text.starts_with(concern)), "{concerns:?}");
    }
}

/// As of plunges: before the program leaves the window it is asked about.
#[test]
fn a_tool_that_turns_much_too_fast_is_named_before_the_program_is_exported() {
    let (engine, _) = fake::engine();
    let flank = |outcome: &mut FlankOutcome| outcome.setup.allowances.material = Some("titanium".to_owned());
    let mut window = with_sample(fake::with_changed_flank(engine, flank));
    plan_flank(&mut window, 10.0);
    let nc = Purpose::ExportNc { operation: Operation::Flank, dialect: Dialect::Fanuc };
    for purpose in [Purpose::ExportFlank { channels: 1 }, nc] {
        let concerns = release::concerns(window.state().state(), purpose, 1);
        let note = "Much faster than the 40 m/min for titanium: T";
        assert!(concerns.iter().any(|text| text.starts_with(note)), "{concerns:?}");
    }
}

/// The headline names the walls as it does the floor, and its tooltip each of them.
#[test]
fn walls_that_are_not_milled_are_in_the_headline() {
    let (engine, _) = fake::engine();
    let flank = move |outcome: &mut FlankOutcome| {
        let verdict = outcome.verdict.as_mut().expect("verified");
        (verdict.unmilled_wall_share, verdict.layer.uncut_share) = (0.27, 0.01);
        assert_eq!(verdict.unmilled_walls.len(), verdict.walls.len(), "a share for each wall");
        verdict.unmilled_walls = vec![0.5, 0.125];
    };
    let mut window = with_sample(fake::with_changed_flank(engine, flank));
    plan_flank(&mut window, 10.0);
    window.get_by_label("1.0 % floor");
    window.get_by_label("27.0 % walls").hover();
    window.run_steps(20);
    let tip = labels(&window, "Share of the walls that is not milled");
    let lines = ["Share of the walls that is not milled", "suction side: 50.0 %", "pressure side: 12.5 %"];
    assert_eq!(tip, [lines.join("\n")]);
    let outcome = window.state().state().results.flank.clone().expect("planned");
    assert_eq!(verdict::of_flank(window.state().state(), &outcome).0, Condition::Blocked);
}

/// A setup whose tools have flat ends takes none of them by itself; its tools are those of the plunges.
#[test]
fn tools_of_the_plunges_are_not_taken_for_passes() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(fake::with_few_passes(engine));
    window.set_size(egui::vec2(1280.0, 1900.0));
    window.run_steps(3);
    window.get_by_label("Edit tools and sections").click();
    window.run_steps(3);
    settle(&mut window);
    let tools = window.state().state().document.edited.setup.tools.clone();
    assert!(!tools.is_empty() && tools.iter().all(|tool| tool.corner_radius < 0.5 * tool.radius()));
    plan_flank(&mut window, 10.0);
    let outcome = window.state().state().results.flank.clone().expect("planned");
    assert_eq!(outcome.plan.tool.corner_radius, outcome.plan.tool.radius(), "a ball end");
    assert!(!window.state().state().flank_is_stale());
    window.get_by_label_contains("from the tool library: no ball end of the setup fits");
    // Others of the library can be chosen beside those of the setup.
    let tools = window.state().state().document.edited.setup.tools.clone();
    let thinner = flank_cutters().iter().filter(|tool| tool.diameter < outcome.plan.tool.diameter);
    let other = thinner.max_by(|a, b| a.diameter.total_cmp(&b.diameter)).expect("a thinner one");
    window.get_by_role_and_label(Role::ComboBox, "Tool").click();
    window.run_steps(2);
    for tool in tools.iter().chain([other]) {
        window.get_by_role_and_label(Role::Button, &format!("T{} Ø{}", tool.number, tool.diameter));
    }
    let entry = format!("T{} Ø{}", other.number, other.diameter);
    window.get_by_role_and_label(Role::Button, &entry).click_accesskit();
    window.run_steps(3);
    settle(&mut window);
    let outcome = window.state().state().results.flank.clone().expect("planned");
    assert_eq!(&outcome.plan.tool, other);
    assert!(!window.state().state().flank_is_stale());
    assert_eq!(window.state().state().document.edited.setup.tools, tools, "the plunges keep theirs");
}

/// How far an axis tilts limits passes, too, and times are those on the machine.
#[test]
fn a_flank_plan_is_out_of_date_on_another_machine() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(fake::with_few_passes(engine));
    plan_flank(&mut window, 10.0);
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(4);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.0);
    window.run_steps(3);
    settle(&mut window);
    assert!(!window.state().state().flank_is_stale(), "no plunges open the channel for it");
    window.get_by_role_and_label(Role::SpinButton, "Max machine tilt").set_value_accesskit(60.0);
    window.run_steps(3);
    settle(&mut window);
    window.get_by_label("Flank: out of date").click();
    window.run_steps(6);
    settle(&mut window);
    assert!(!window.state().state().flank_is_stale(), "it is calculated when it is selected");
}

/// Positions that are planned along a wall, but that the program does not have, leave nothing on it.
#[test]
fn the_scale_of_the_walls_is_that_of_what_the_program_leaves() {
    let (engine, _) = fake::engine();
    let flank = move |outcome: &mut FlankOutcome| {
        for wall in Arc::make_mut(&mut outcome.plan.walls) {
            wall.axes.max_overcut = 2.5;
            wall.axes.map.deviation.fill(-2.5);
        }
    };
    let mut window = with_sample(fake::with_changed_flank(engine, flank));
    plan_flank(&mut window, 8.0);
    window.get_by_label("walls").click_accesskit();
    window.run_steps(4);
    let outcome = window.state().state().results.flank.clone().expect("planned");
    let verdict = outcome.verdict.as_ref().expect("verified");
    let most = wall_scale_end(verdict.max_overcut.max(verdict.max_undercut) as f32);
    assert!(most < 0.02, "small deviations fill the scale, too: {most}");
    window.get_by_label(&DisplayUnits::Metric.deviation((-most).into()));
    assert_eq!(window.state().state().shown_deviation(), Some(most));
    let (mesh, largest) = wall_deviations(&outcome.workpiece.part, &outcome.shown_walls());
    assert!(largest <= most + 1e-6, "the colours, too: {largest} of {most}");
    let grey = mesh.vertices.iter().any(|vertex| vertex.uncut > 0.5);
    assert_eq!(grey, verdict.unmilled_wall_share > 0.0, "and grey where it does not mill");
}

/// As the scale of the stock on the hub.
#[test]
fn the_scale_of_the_walls_is_edited_and_stays_until_it_is_fitted() {
    let mut window = with_plan();
    window.get_by_label("walls").click_accesskit();
    window.run_steps(4);
    let shown = |window: &Window| window.state().state().shown_deviation().expect("walls");
    let fitting = shown(&window);
    assert!(window.query_by_label("Fit scale").is_none());
    let view = window.get_by_label("3D view").rect();
    let before = pixels_in(&mut window, view);
    window.get_by_role_and_label(Role::SpinButton, "Scale maximum").set_value_accesskit(2.0);
    window.run_steps(4);
    assert_eq!(shown(&window), 2.0);
    window.get_by_label(&DisplayUnits::Metric.deviation(-2.0));
    assert!(pixels_in(&mut window, view) != before, "the walls have other colours");
    set_depth(&mut window, 8.0);
    assert_eq!(shown(&window), 2.0, "another plan keeps it");
    window.get_by_label("Fit scale").click();
    window.run_steps(4);
    let state = window.state().state();
    assert_eq!(state.shown_deviation(), state.fitting_deviation());
    assert!(shown(&window) < 2.0 && fitting < 2.0);
}

#[test]
fn flank_curves_are_planned_shown_and_written() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    assert!(window.state().state().results.flank.is_none());
    plan_flank(&mut window, 8.0);
    let planned = window.state().state().results.flank.clone().expect("planned");
    assert_eq!(planned.plan.layout.strategy, FlankStrategy::Balanced);
    assert!(window.state().state().look.flank.shown, "what was asked for is shown");
    assert!(!window.state().state().flank_is_stale());
    // The figures of the command line, of the program and not of its positions.
    let verdict = planned.verdict.as_ref().expect("verified");
    let [gouge, left] = [verdict.max_overcut, verdict.max_undercut];
    let [gouge, left] = [-gouge, left].map(|mm| DisplayUnits::Metric.signed(mm, 4));
    window.get_by_label(&format!("{gouge} / {left} mm"));
    window.get_by_label("Floor above scallop");
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    window.get_by_label_contains(&format!(
        "{} of the accessible floor and {} of the walls is not machined",
        percent(verdict.layer.uncut_share.into()),
        percent(verdict.unmilled_wall_share)
    ));
    window.get_by_label(&percent(verdict.uncovered.share()));
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    snapshot_view(&mut window, "flank");

    // Shows the walls instead of the stock on the hub, then the hub again.
    window.state_mut().look_mut().layers.cutters = false;
    window.get_by_label("walls").click_accesskit();
    window.run_steps(4);
    let most = window.state().state().shown_deviation().expect("walls are shown");
    window.get_by_label("Residual on walls");
    let count = window.state().state().timeline_len();
    for (at, head) in [(count / 2, "Finished walls"), (count, "Residual on walls")] {
        window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(at as f64);
        window.run_steps(4);
        window.get_by_label(head);
    }
    window.get_by_label(&DisplayUnits::Metric.deviation((-most).into()));
    snapshot_view(&mut window, "flank_walls");
    // The value under the cursor has a sign: above or below the allowance.
    let view = window.get_by_label("3D view").rect();
    let (mut above, mut below) = (0, 0);
    // Points spread over the view in a pseudo-random order.
    for k in (1..576).map(|k| 217 * k % 576) {
        let share = egui::vec2((k % 24) as f32 / 24.0, (k / 24) as f32 / 24.0);
        window.hover_at(view.min + view.size() * share);
        window.step();
        let Some(text) = words(&window, " mm here") else { continue };
        let value: f32 = text.trim_end_matches(" mm here").replace('−', "-").parse().expect("a figure");
        assert!(value.abs() <= most + 1e-4, "{text} of {most}");
        above += usize::from(text.starts_with('+') && value > 0.0);
        below += usize::from(text.starts_with('−'));
        if above >= 3 && below >= 3 {
            break;
        }
    }
    window.event(egui::Event::PointerGone);
    window.run_steps(2);
    assert!(above > 0 && below > 0, "both signs are found: {above} above, {below} below");
    // The menu of layers colours the passes while they are shown, not the cutters of the plunges.
    window.get_by_role_and_label(Role::Button, "Layers").click();
    window.run_steps(2);
    assert!(window.query_by_label("Cutters by").is_none());
    window.get_by_role_and_label(Role::RadioButton, "Layer").click();
    window.run_steps(2);
    window.key_press(egui::Key::Escape);
    window.run_steps(4);
    window.get_by_label_contains("layer 1, at the hub");
    snapshot_view(&mut window, "flank_layers");

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flank.apt");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportFlank { channels: 1 }, path.clone());
    settle(&mut window);
    let program = vanecut::io::apt::read_apt(&path).expect("a CL file");
    assert_eq!(program.moves.len(), planned.plan.moves.len());
}

#[test]
fn an_edit_of_flank_milling_is_followed_and_until_then_marked_and_the_plunge_plan_stays() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    // Few layers.
    set_depth(&mut window, 10.0);
    window.get_by_label("Calculate flank").click_accesskit();
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    assert!(window.query_by_label("Out of date:").is_none());
    set_depth(&mut window, 8.0);
    window.get_by_label("Out of date:");
    window.get_by_label("Flank: out of date");
    window.get_by_label("Setup edited: recalculate flank (F6)");
    assert!(!window.state().state().out_of_date(), "the plunge plan does not depend on it");
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    settle(&mut window);
    assert!(window.query_by_label("Out of date:").is_none(), "followed");
    let planned = window.state().state().results.flank.clone().expect("planned");
    assert_eq!(planned.setup.flank.layer_depth, 8.0);
    window.get_by_label_contains("Flank calculated in");
}

/// A window with a flank plan of few layers.
pub fn with_plan() -> Window {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 800.0));
    plan_flank(&mut window, 10.0);
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    window
}

#[test]
fn the_tool_of_flank_milling_is_chosen_from_the_tools_there_are() {
    let mut window = with_plan();
    let planned =
        |window: &Window| window.state().state().results.flank.clone().expect("planned").plan.tool.clone();
    let automatic = planned(&window);
    // What was taken stands beside it.
    let taken = format!("T{} Ø{}", automatic.number, automatic.diameter);
    assert_eq!(labels(&window, &taken).len(), 1);
    let setup = window.state().state().document.edited.setup.clone();
    let thinner = selectable(&setup, flank_cutters()).filter(|t| t.diameter < automatic.diameter);
    let other = thinner.max_by(|a, b| a.diameter.total_cmp(&b.diameter)).expect("a thinner one");
    window.get_by_role_and_label(Role::ComboBox, "Tool").click();
    window.run_steps(2);
    // The list is long: this one may be below its end.
    let entry = format!("T{} Ø{}", other.number, other.diameter);
    window.get_by_role_and_label(Role::Button, &entry).click_accesskit();
    window.run_steps(3);
    settle(&mut window);
    let chosen = window.state().state().document.edited.setup.flank.tool;
    assert_eq!((chosen, planned(&window).number), (Some(other.number), other.number));
    assert!(labels(&window, &taken).is_empty());
    window.get_by_label("Reset tool").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(planned(&window).number, automatic.number);
}

#[test]
fn passes_of_the_flank_plan_are_a_table_and_moves_a_timeline() {
    let mut window = with_plan();
    let passes = window.state().state().results.passes.clone();
    let moves = window.state().state().results.flank.clone().expect("planned").plan.moves.clone();
    assert!(passes.passes.len() > 5 && passes.clock.len() == moves.len(), "{}", passes.passes.len());
    let times = window.state().state().results.flank.clone().expect("planned").plan.times;
    assert!((passes.time_after(moves.len()) - times.total()).abs() < 1e-6 * times.total(), "the same time");
    window.get_by_label(&format!("all {}", moves.len()));

    // The command line counts passes, of which one may be several cuts.
    let layout = window.state().state().results.flank.clone().expect("planned").plan.layout.clone();
    let count = layout.totals[layout.strategy as usize].passes;
    assert!(count < passes.passes.len(), "{count}");
    window.get_by_label(&format!("{} cuts of {count} passes", passes.passes.len()));

    // A row selects its pass and brings it into view.
    let before = window.state().camera().expect("a camera");
    window.get_by_label("Pass 3").click();
    window.run_steps(8);
    settle(&mut window);
    assert_eq!(window.state().state().look.flank.pass, Some(2));
    assert_ne!(window.state().camera().expect("a camera").target, before.target, "it is zoomed to");
    window.key_press(egui::Key::ArrowDown);
    window.run_steps(8);
    assert_eq!(window.state().state().look.flank.pass, Some(3), "the next row");

    // The timeline goes on from its end, move by move; the table follows.
    let end = passes.passes[3].end;
    window.key_press(egui::Key::ArrowRight);
    window.run_steps(2);
    assert_eq!(window.state().state().look.flank.cut, Some(end + 1));
    assert_eq!(window.state().state().look.cut_count, None, "the plunge plan has its own timeline");
    window.get_by_label(&format!("{} of {}", end + 1, moves.len()));
    let middle = &passes.passes[passes.passes.len() / 2];
    let cut = middle.end;
    window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(cut as f64);
    window.run_steps(3);
    settle(&mut window);
    let number = passes.passes.len() / 2 + 1;
    assert_eq!(window.state().state().look.flank.pass, Some(number - 1), "what is cut is selected");
    window.get_by_label(&format!("Pass {number}"));
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    snapshot_view(&mut window, "flank_timeline");

    // To the next layer, whose first move is cut then.
    window.key_press(egui::Key::C);
    window.run_steps(2);
    let cut = window.state().state().look.flank.cut.expect("in the plan");
    assert!(passes.layer_starts.contains(&(cut - 1)), "{cut}: {:?}", passes.layer_starts);
    // It plays, faster than plunges, and stops at the end.
    window.get_by_role_and_label(Role::Button, "Go to start").click();
    window.run_steps(2);
    window.key_press(egui::Key::Space);
    window.run_steps(4);
    let look = &window.state().state().look;
    assert!(look.playing.is_some() && look.flank.cut > Some(20), "{:?}", look.flank.cut);
    window.key_press(egui::Key::Space);
    window.get_by_role_and_label(Role::Button, "Go to end").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.flank.cut, None);
}

#[test]
fn the_time_of_a_flank_program_of_several_channels_is_known_before_its_export() {
    let mut window = with_plan();
    window.state_mut().use_own_file_dialogs();
    choose_in_file_menu(&mut window, "Export CL of several channels…");
    let outcome = window.state().state().results.flank.clone().expect("planned");
    let (one, all) = (outcome.time_s(), outcome.wheel_time_s.expect("known"));
    for (channels, time) in [(1, one), (9, (one + all) / 2.0), (17, all)] {
        let field = window.get_by_role_and_label(Role::SpinButton, "Channels");
        field.set_value_accesskit(f64::from(channels));
        window.run_steps(2);
        window.get_by_label(&format!("Time {}, without tool changes", format_duration(time)));
    }
}

/// What is seen of the wheel is what its program mills.
#[test]
fn the_flank_plan_is_shown_in_several_channels_in_the_order_of_their_program() {
    let mut window = with_plan();
    let outcome = window.state().state().results.flank.clone().expect("planned");
    let (of_one, passes) = (outcome.plan.moves.len(), window.state().state().results.passes.passes.len());
    // To repeat the channels of a large wheel takes seconds, in which frames are drawn.
    window.state_mut().look_mut().shown_channels = 2;
    window.step();
    assert!(window.state().is_busy());
    assert_eq!(window.state().state().results.flank_run.as_ref().map(|run| run.count()), Some(1));
    show_channels(&mut window, 2.0);
    let run = window.state().state().results.flank_run.clone().expect("shown");
    let program = outcome.in_channels(2, &Monitor::default()).expect("not cancelled").program;
    assert_eq!(*run.program().0, program, "as it is exported");
    let steps = run.moves();
    assert!(steps.len() >= 2 * of_one, "passes, and links from channel to channel: {}", steps.len());
    window.get_by_label(&format!("all {}", steps.len()));
    let shown = window.state().state().results.passes.clone();
    assert_eq!(shown.passes.len(), 2 * passes, "the same passes in each");
    let layout = &outcome.plan.layout;
    let count = 2 * layout.totals[layout.strategy as usize].passes;
    window.get_by_label(&format!("{} cuts of {count} passes", shown.passes.len()));
    window.get_by_label("Ch.");
    let ends = window.query_all_by_label("Time").map(|head| head.rect().right());
    let (end, edge) = (ends.fold(0.0, f32::max), window.ctx.content_rect().right());
    assert!(end < edge - 4.0, "all columns are in view: {end} of {edge}");
    let whole = Travel::from_program(&program).time;
    assert!((shown.time_after(steps.len()) - whole).abs() < 1e-6 * whole, "the time of the program");
    window.key_press(egui::Key::Num3);
    window.run_steps(4);
    settle(&mut window);
    snapshot_view(&mut window, "flank_channels");
    window.state_mut().look_mut().flank.colours = FlankColours::Walls;
    window.run_steps(4);
    settle(&mut window);
    snapshot_view(&mut window, "flank_channels_walls");
    window.state_mut().look_mut().flank.colours = FlankColours::Layer;
    window.run_steps(4);
    settle(&mut window);

    // The timeline goes on in the next channel; table and line of the program follow.
    let pass = &shown.passes[passes + 2];
    assert_eq!(run.channel_of(pass.from), 1);
    let line = window.get_by_role_and_label(Role::Slider, "Timeline");
    line.set_value_accesskit(pass.end as f64);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(window.state().state().look.flank.pass, Some(passes + 2));
    let step = &program.moves[run.program().1[pass.end - 1]];
    let [x, y, z] = [step.tip.x, step.tip.y, step.tip.z];
    window.get_by_label_contains(&format!(": GOTO/{x:.6},{y:.6},{z:.6}"));
    let solid = window.state().state().solid_source(Side::After).expect("planned");
    let SolidSource::Plans(solid) = solid else { panic!("it is that of plans") };
    assert_eq!((solid.channels, solid.flank.map(|run| run.count())), (2, Some(2)), "the solid stock, too");

    // Another order is another program.
    choose_in_file_menu(&mut window, "Export NC program…");
    choose_in_list(&mut window, "Channel sequence", "Opposite");
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    settle(&mut window);
    let other = window.state().state().results.flank_run.clone().expect("shown");
    assert!(*other.program().0 != program && other.moves().len() >= steps.len());
    assert_eq!(window.state().state().look.flank.cut, None, "its timeline begins anew");
}

#[test]
fn the_line_of_the_flank_program_stands_below_its_timeline() {
    let mut window = with_plan();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flank.apt");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportFlank { channels: 1 }, path.clone());
    settle(&mut window);
    let program = vanecut::io::apt::read_apt(&path).expect("a CL file");
    let text = std::fs::read_to_string(&path).expect("exported");
    window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(40.0);
    window.run_steps(3);
    settle(&mut window);
    let line = program.moves[39].line;
    let begin = text.lines().nth(line - 1).expect("a line").trim_end_matches('$');
    window.get_by_label_contains(&format!("Line {line}: {begin}"));
    // The plunge plan has a program of its own.
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(labels(&window, "Line ").len(), 1, "another line");
    assert!(window.query_by_label_contains(&format!("Line {line}: {begin}")).is_none());
}

#[test]
fn the_solid_stock_follows_the_timeline_of_the_passes() {
    let mut window = with_plan();
    window.key_press(egui::Key::S);
    window.run_steps(3);
    settle(&mut window);
    let volume = |window: &Window| window.state().solid(Side::After).expect("a solid").volume;
    let finished = volume(&window);
    window.key_press(egui::Key::N);
    window.run_steps(2);
    window.get_by_label("The flank program has no faults");
    window.get_by_role_and_label(Role::Button, "Go to start").click();
    window.run_steps(3);
    settle(&mut window);
    let before = volume(&window);
    assert!(before > finished + 1.0, "{before} mm³ before the passes, {finished} after them");
}

#[test]
fn the_program_of_the_selected_operation_is_exported() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().use_own_file_dialogs();
    let titles = ["Export CL (APT)", "Export flank CL (APT)"];
    plan_flank(&mut window, 8.0);
    for (operation, title) in [("Flank: ", titles[1]), ("Roughing: ", titles[0])] {
        window.get_by_label_contains(operation).click();
        window.run_steps(3);
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::E);
        window.run_steps(3);
        settle(&mut window);
        window.get_by_label(title);
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
    }
}

#[test]
fn f6_while_both_operations_are_calculated_begins_nothing_anew_and_the_selected_one_goes_ahead() {
    let (engine, slow) = fake::engine();
    let (engine, held) = fake::with_held_flank(engine);
    let calls = Arc::new(AtomicUsize::new(0));
    let (counted, inner) = (Arc::clone(&calls), Arc::clone(&engine.flank));
    let flank = move |request: &FlankRequest, monitor: &Monitor| {
        counted.fetch_add(1, Ordering::SeqCst);
        inner(request, monitor)
    };
    let mut window = with_sample(Engine { flank: Arc::new(flank), ..engine });
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    // Few layers.
    set_depth(&mut window, 10.0);
    slow.store(true, Ordering::SeqCst);
    window.key_press(egui::Key::F5);
    window.run_steps(3);
    for _ in 0..3 {
        window.key_press(egui::Key::F6);
        window.run_steps(3);
    }
    window.get_by_label("Roughing: waiting…");
    window.get_by_label("Flank: calculating…");
    assert!(!labels(&window, "Calculating flank milling…").is_empty());
    let running = window.state().running_task().map(|(name, _)| name);
    assert_eq!(running, Some("Calculating flank"), "of the selected operation");
    // The one that is selected goes ahead.
    window.get_by_label("Roughing: waiting…").click();
    window.run_steps(4);
    window.get_by_label("Roughing: calculating…");
    window.get_by_label("Flank: waiting…").click();
    window.run_steps(4);
    window.get_by_label("Roughing: waiting…");
    held.store(false, Ordering::SeqCst);
    let start = std::time::Instant::now();
    while window.state().state().results.flank.is_none() {
        assert!(start.elapsed() < HANG, "it does not wait for roughing");
        window.step();
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    window.run_steps(2);
    window.get_by_label("Roughing: calculating…");
    slow.store(false, Ordering::SeqCst);
    settle(&mut window);
    assert_eq!(calls.load(Ordering::SeqCst), 1, "the same is not begun again");
    assert!(window.state().state().results.flank.is_some());
}

#[test]
fn a_flank_plan_that_is_ready_does_not_leave_the_operation_that_is_worked_on() {
    let (engine, _) = fake::engine();
    let (engine, held) = fake::with_held_flank(engine);
    let mut window = with_sample(engine);
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    // Few layers.
    let field = window.get_by_role_and_label(Role::Slider, "Layer depth");
    field.set_value_accesskit(10.0);
    window.run_steps(4);
    window.key_press(egui::Key::F6);
    window.run_steps(3);
    window.get_by(|node| node.label().is_some_and(|label| label.starts_with("Roughing: "))).click();
    window.run_steps(4);
    held.store(false, Ordering::SeqCst);
    settle(&mut window);
    let state = window.state().state();
    assert!(state.results.flank.is_some());
    assert_eq!(state.look.operation, Operation::Roughing);
}

#[test]
fn the_table_of_passes_follows_a_dragged_timeline_and_names_no_splitter_where_there_is_none() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    plan_flank(&mut window, 10.0);
    let passes = Arc::clone(&window.state().state().results.passes);
    let last = passes.passes.len() - 1;
    // To the end and back, a frame each, as a quick drag does.
    for end in [passes.passes[last].end, passes.passes[last / 3].end, passes.passes[last / 2].end] {
        window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(end as f64);
        window.step();
    }
    window.run_steps(30);
    settle(&mut window);
    assert_eq!(window.state().state().look.flank.pass, Some(last / 2));
    window.get_by_label(&format!("Pass {}", last / 2 + 1));

    let wall = passes.passes.iter().position(|pass| pass.along_wall).expect("walls are milled");
    let other = passes.passes.iter().position(|pass| !pass.along_wall).expect("the floor is milled");
    for (k, named) in [(other, "the whole channel"), (wall, ", along the ")] {
        window
            .get_by_role_and_label(Role::Slider, "Timeline")
            .set_value_accesskit(passes.passes[k].end as f64);
        window.run_steps(8);
        window.get_by_label(&format!("Pass {}", k + 1)).hover();
        window.run_steps(30);
        window.get_by_label_contains(named);
        assert_eq!(words(&window, "splitter"), None);
    }
    window.get_by_label("region").click_accesskit();
    window.run_steps(4);
    assert_eq!(words(&window, "splitter"), None);
    // Each colour of the lines has an entry, while the program plays and at its end.
    for end in [passes.passes[last / 2].end, passes.passes[last].end] {
        window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(end as f64);
        window.run_steps(8);
        for region in ["channel", "suction", "pressure"] {
            assert!(window.query_all_by_label(region).next().is_some(), "{region}");
        }
    }
}

#[test]
fn machine_and_tools_are_set_with_flank_milling_selected() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Edit tools and sections").click_accesskit();
    // The whole form.
    window.set_size(egui::vec2(1300.0, 1500.0));
    window.run_steps(4);
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    choose_in_list(&mut window, "Machine", "bc-trunnion");
    let machine = window.get_by_role_and_label(Role::ComboBox, "Machine").value();
    assert_eq!(machine.as_deref(), Some("bc-trunnion"));
    let tools = |window: &Window| window.state().state().document.edited.setup.tools.len();
    let before = tools(&window);
    window.get_by_label("Add tool").click_accesskit();
    window.run_steps(4);
    assert_eq!(tools(&window), before + 1);
    // Sections and what they do are of roughing.
    assert_eq!(words(&window, "plunges"), None);
}
