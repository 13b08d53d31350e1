//! Several channels: their order where they are exported, and how the views and the timeline show them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use egui::accesskit::{Role, Toggled};
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::figures::format_clock;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::planned::Side;
use vanecut::io::apt::read_apt;
use vanecut::monitor::Monitor;
use vanecut::plunge::Position;
use vanecut::setup::{ChannelOrder, ChannelSequence, ChannelSetup};
use vanecut::toolpath::{Motion, Move, Travel};

use crate::dialogs::{name_file, press_enter};
use crate::fake;
use crate::harness::{
    Window, choose_in_file_menu, choose_in_list, labels, pixels_in, press, settle, snapshot_ui,
    snapshot_view, with_sample, words,
};
use crate::machine::with_machine;

/// Opens the question how many channels a program is for.
fn ask(window: &mut Window) {
    window.state_mut().use_own_file_dialogs();
    choose_in_file_menu(window, "Export CL of several channels…");
}

fn choose(window: &mut Window, list: &str, entry: &str) {
    choose_in_list(window, list, entry);
    settle(window);
}

/// Shows so many channels, by the menu of layers.
pub fn show_channels(window: &mut Window, count: f64) {
    window.get_by_role_and_label(Role::Button, "Layers").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Channels shown").set_value_accesskit(count);
    window.run_steps(2);
    window.key_press(egui::Key::Escape);
    window.run_steps(4);
    settle(window);
}

fn positions(window: &Window) -> Vec<Position> {
    window.state().state().shown().expect("planned").plan().positions.clone()
}

const OPPOSITE: ChannelSetup =
    ChannelSetup { order: ChannelOrder::ChannelByChannel, sequence: ChannelSequence::Opposite };

#[test]
fn the_order_is_chosen_beside_the_number_of_channels_and_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, project) = (folder.path().join("three.apt"), folder.path().join("a.vanecut"));
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    ask(&mut window);
    snapshot_ui(&mut window, "channels_dialog");
    window.get_by_role_and_label(Role::SpinButton, "Channels").set_value_accesskit(3.0);
    choose(&mut window, "Channel order", "Channel by channel");
    choose(&mut window, "Channel sequence", "Opposite");
    assert_eq!(window.state().state().document.edited.setup.channels, OPPOSITE);
    assert!(!window.state().state().out_of_date(), "the plan follows while the dialog is open");
    window.get_by_label("Save as…").click();
    window.run_steps(3);
    settle(&mut window);
    name_file(&mut window, &path);
    press_enter(&mut window);
    // Channels 1, 9 and 13 of 17, one after the other.
    let program = read_apt(&path).expect("a CL file");
    let count = positions(&window).len();
    let pitch = window.state().state().document.part.as_ref().expect("open").impeller.pitch();
    let is_cut = |step: &&Move| matches!(step.motion, Motion::Feed(_));
    let bottoms: Vec<_> = program.moves.iter().filter(is_cut).map(|step| step.tip).collect();
    assert_eq!(bottoms.len(), 3 * count);
    let first = bottoms[0];
    for (place, channel) in [(0, 0.0), (1, 8.0), (2, 12.0)] {
        let turned = vanecut::geometry::rotate_z(&first, channel * pitch);
        let off = (bottoms[place * count] - turned).norm();
        assert!(off < 1e-4, "channel {channel}: {off} mm");
    }
    // The project has it, and it is undone like any edit.
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(&mut window);
    let text = std::fs::read_to_string(&project).expect("written");
    assert!(text.contains("channel_by_channel"), "{text}");
    for _ in 0..2 {
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
        window.run_steps(2);
        settle(&mut window);
    }
    assert_eq!(window.state().state().document.edited.setup.channels, ChannelSetup::default());
}

#[test]
fn enter_confirms_the_question_unless_a_field_takes_it() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    ask(&mut window);
    let field = window.get_by_role_and_label(Role::SpinButton, "Channels").rect().center();
    press(&mut window, field);
    window.run_steps(2);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text("99".into()));
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    window.get_by_label_contains("99 is too much: at most 17");
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    assert!(window.query_by_label("Channel order").is_none(), "confirmed");
    window.get_by_label_contains("Export CL of several channels (APT)");
}

#[test]
fn all_channels_are_shown_and_the_timeline_runs_through_them() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 760.0));
    window.run_steps(3);
    settle(&mut window);
    let count = positions(&window).len();
    let (_, one) = window.state().state().clock().expect("a clock");
    let rect = window.get_by_label("3D view").rect();
    let plain = pixels_in(&mut window, rect);
    show_channels(&mut window, 17.0);
    assert_eq!(window.state().state().timeline_len(), 17 * count);
    window.get_by_label(&format!("all {}", 17 * count));
    let (now, whole) = window.state().state().clock().expect("a clock");
    // With the links between channels of the program that is written.
    let shown = window.state().state().shown().expect("planned");
    let (outcome, result) = (&shown.planned.outcome, shown.planned.result(shown.policy));
    let program = outcome.program_for_channels(result, 17, &Monitor::default()).expect("not cancelled");
    let written = Travel::from_program(&program).time;
    assert!(now == whole && whole > one && (whole / written - 1.0).abs() < 1e-9, "{whole} s, not {written}");
    let all = pixels_in(&mut window, rect);
    let changed = all.iter().zip(&plain).filter(|(a, b)| a != b).count();
    assert!(changed * 20 > all.len(), "{changed} pixels of {} show other channels", all.len());
    snapshot_view(&mut window, "channels_shown");

    // Tool by tool: after the first tool of channel 1 comes that of channel 2.
    let first_tool = positions(&window).iter().take_while(|p| p.section == 0).count();
    window.state_mut().look_mut().playing = None;
    set_timeline(&mut window, first_tool + 3);
    let look = &window.state().state().look;
    assert_eq!(look.cut_count, Some(first_tool), "of channel 1");
    // The table marks the same plunge, and the sectional view shows it.
    assert_eq!((look.selected, look.selected_channel), (Some(2), 1), "the tool is in channel 2");
    let row = window.get_by_role_and_label(Role::Row, "Position 3");
    assert_eq!(row.accesskit_node().toggled(), Some(Toggled::True));
    window.get_by_label_contains(&format!("Position 3 of {count}, channel 2: "));
    window.get_by_label("Sectional view through position 3");
    let progress: BTreeMap<usize, (usize, bool)> = window
        .state()
        .state()
        .channel_progress()
        .into_iter()
        .map(|at| (at.channel, (at.up_to, at.is_current)))
        .collect();
    assert_eq!(progress[&0], (first_tool, false));
    assert_eq!(progress[&1], (3, true));
    assert!((2..17).all(|channel| progress[&channel] == (0, false)), "{progress:?}");
    snapshot_view(&mut window, "channels_timeline");

    // The line is that of the program of these channels.
    let line = words(&window, "Line ").expect("listed");
    let shown = window.state().state().shown().expect("planned");
    let outcome = &shown.planned.outcome;
    let plan = outcome.plan_of_channels(shown.planned.result(shown.policy), 17, &Monitor::default());
    let tip = plan.expect("not cancelled").positions[first_tool + 2].tip;
    assert!(line.contains(&format!("GOTO/{:.6},{:.6}", tip.x, tip.y)), "{line} is not at {tip}");

    // A position that is selected is one of channel 1, and the timeline goes there.
    window.state_mut().look_mut().select(Some(4));
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(window.state().state().timeline_cut(), Some(5));
    show_channels(&mut window, 1.0);
    let state = window.state().state();
    assert_eq!((state.timeline_len(), state.timeline_cut()), (count, Some(5)));
}

#[test]
fn a_project_keeps_the_shown_channels_and_their_timeline() {
    let folder = tempfile::tempdir().expect("a folder");
    let project = folder.path().join("a.vanecut");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine.clone());
    show_channels(&mut window, 5.0);
    let count = positions(&window).len();
    let cut = count + 3;
    set_timeline(&mut window, cut);
    let look = |window: &Window| {
        let look = &window.state().state().look;
        (look.shown_channels, look.channels_cut, look.selected, look.selected_channel)
    };
    let before = look(&window);
    assert_eq!((before.0, before.1), (5, Some(cut)));
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, project.clone());
    settle(&mut window);
    let mut second = crate::harness::window(engine);
    second.state_mut().open_path(project);
    settle(&mut second);
    assert_eq!(look(&second), before);
    assert_eq!(second.state().state().timeline_cut(), Some(cut));
    second.get_by_label(&format!("{cut} of {}", 5 * count));
    assert!(!second.state().state().document.is_unsaved());
}

/// Sets the timeline as its slider does.
fn set_timeline(window: &mut Window, cut: usize) {
    window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(cut as f64);
    window.run_steps(3);
    settle(window);
}

/// The solid is cut in all shown channels, as far as the timeline is.
#[test]
fn the_solid_is_cut_in_the_shown_channels() {
    let mut window = with_sample(fake::engine().0);
    show_channels(&mut window, 3.0);
    let count = positions(&window).len();
    // From the blank on, so that each plunge is cut once.
    set_timeline(&mut window, 0);
    window.key_press(egui::Key::S);
    window.run_steps(3);
    settle(&mut window);
    let volumes = [0, count, 3 * count].map(|cut| {
        set_timeline(&mut window, cut);
        window.state().solid(Side::After).expect("a solid").volume
    });
    let removed = [1, 2].map(|k| volumes[0] - volumes[k]);
    assert!(removed[0] > 0.0 && (removed[1] / removed[0] - 3.0).abs() < 0.05, "{removed:?} mm³");
}

#[test]
fn rapids_are_drawn_in_all_shown_channels() {
    let mut window = with_sample(fake::engine().0);
    window.set_size(egui::vec2(1280.0, 760.0));
    window.run_steps(3);
    settle(&mut window);
    let rect = window.get_by_label("3D view").rect();
    let drawn = |window: &mut Window| {
        let pixels = [false, true].map(|links| {
            window.state_mut().look_mut().layers.links = links;
            window.run_steps(3);
            pixels_in(window, rect)
        });
        pixels[0].iter().zip(&pixels[1]).filter(|(without, with)| without != with).count()
    };
    let of_one = drawn(&mut window);
    show_channels(&mut window, 17.0);
    let of_all = drawn(&mut window);
    // Those behind the wheel are hidden.
    assert!(of_one > 0 && of_all > 4 * of_one, "{of_one} pixels in one channel, {of_all} in all");
}

/// The axes of the machine are those of the program of all shown channels.
#[test]
fn the_machine_runs_the_shown_channels() {
    let mut window = with_machine("ac-trunnion");
    let count = positions(&window).len();
    show_channels(&mut window, 2.0);
    let state = window.state().state();
    let of_machine = &state.on_machine().expect("known").clock;
    assert_eq!(of_machine.len(), 2 * count);
    assert_eq!(state.clock().map(|(_, whole)| whole), of_machine.last().copied());
    // The table turns the second channel to where it had the first.
    let angle = |cut: usize| {
        let machine = state.on_machine().expect("known");
        machine.at(Some(cut)).expect("within its range").pose.angles[0]
    };
    let turn = (angle(count + 1) - angle(1)).rem_euclid(TAU);
    let pitch = TAU / 17.0;
    assert!((turn - pitch).abs().min((TAU - turn - pitch).abs()) < 1e-4, "{turn} rad");
    assert_eq!(state.on_machine().expect("known").demands.len(), count, "the table has those of channel 1");
}

/// Of a plunge in another channel, time and axes are those of the program of all of them.
#[test]
fn the_plunge_under_the_pointer_has_the_time_and_the_axes_of_its_channel() {
    let mut window = with_machine("ac-trunnion");
    show_channels(&mut window, 2.0);
    let rect = window.get_by_label("Timeline").rect();
    window.hover_at(egui::pos2(rect.left() + 0.75 * rect.width(), rect.center().y));
    window.run_steps(8);
    window.get_by_label("Channel 2");
    let title = labels(&window, "Position ").pop().expect("a tooltip");
    let number: usize = title.trim_start_matches("Position ").parse().expect("a number");
    let state = window.state().state();
    let step = state.step_of_position(number - 1, 1);
    let machine = state.on_machine().expect("known");
    let named = machine.named(machine.at(Some(step)).expect("it runs"));
    let axes = named.map(|(name, value, unit)| format!("{name} {value:.3}{unit}")).join("  ");
    window.get_by_label(&axes.replace('-', "−"));
    window.get_by_label(&format!("Cut after {}", format_clock(machine.clock[step - 1])));
    // Among its figures, too.
    set_timeline(&mut window, step);
    window.get_by_label("Figures").click();
    window.run_steps(3);
    let state = window.state().state();
    let time = format_clock(state.on_machine().expect("known").clock[step - 1]);
    assert!(!labels(&window, &time).is_empty(), "{time} in {:?}", labels(&window, ""));
}

#[test]
fn the_light_theme_shows_the_same_channels() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 760.0));
    window.get_by_label("View").click();
    window.run_steps(2);
    window.get_by_label("Switch light and dark").click();
    window.run_steps(4);
    show_channels(&mut window, 5.0);
    choose_opposite(&mut window);
    snapshot_view(&mut window, "channels_light");
}

fn choose_opposite(window: &mut Window) {
    ask(window);
    choose(window, "Channel sequence", "Opposite");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    settle(window);
    assert_eq!(window.state().state().document.edited.setup.channels.sequence, ChannelSequence::Opposite);
}
