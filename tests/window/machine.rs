//! The plan on a machine: axes beside the timeline, in the table and in the plot.

use std::path::Path;

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::figures::format_clock;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::machine::ProgramOnMachine;
use vanecut::app::model::panels::DockPanel;
use vanecut::drawing::machine::{PosedMachine, head_mesh};
use vanecut::geometry::{Vector, rotate_vector_z};
use vanecut::io::machine_file::read_machine;
use vanecut::job::PlanOutcome;
use vanecut::machine::{MachineClock, MachineTime};
use vanecut::toolpath::{ClProgram, Travel};
use vanecut::tradeoff::PlanClock;

use crate::fake;
use crate::flank::plan_flank;
use crate::harness::{
    Window, labels, pixels_in, press, settle, snapshot_view, turn_wheel, with_sample, words,
};

/// A window with a planned sample on a machine.
pub fn with_machine(name: &str) -> Window {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 1000.0));
    window.run_steps(3);
    choose(&mut window, name);
    window
}

pub fn choose(window: &mut Window, name: &str) {
    window.get_by_role_and_label(Role::ComboBox, "Machine").click();
    window.run_steps(2);
    window.get_by_label(name).click();
    window.run_steps(3);
    settle(window);
}

fn on_machine(window: &Window) -> &ProgramOnMachine {
    let plan = window.state().state().results.on_machine.as_ref().expect("known");
    plan.as_ref().expect("the machine is read")
}

/// Text of the line of the axes; a label and its text have the same.
pub fn line_of_axes(window: &Window) -> Option<String> {
    let mut lines = window.query_all_by(|node| node.value().is_some_and(|text| text.starts_with("X ")));
    lines.next()?.accesskit_node().value()
}

/// The line of the axes, as pairs of a letter and a number.
pub fn axes(window: &Window) -> Vec<(char, f64)> {
    let text = line_of_axes(window).expect("a line").replace('−', "-");
    let words: Vec<&str> = text.split_whitespace().filter(|word| !matches!(*word, "mm" | "in")).collect();
    let pair = |pair: &[&str]| Some((pair[0].chars().next()?, pair[1].trim_end_matches('°').parse().ok()?));
    words.chunks_exact(2).map_while(pair).collect()
}

/// Each tool of the 17 channels is changed once.
#[test]
fn times_are_those_on_the_machine_where_it_is_known() {
    let time = MachineTime { total_s: 1500.0, tool_changes_s: 60.0 };
    let window = with_sample(fake::engine_on_machine(time));
    let shown = labels(&window, "25 min per channel");
    assert!(shown.iter().all(|text| text == "25 min per channel, 6.8 h wheel"), "{shown:?}");
    assert!(!shown.is_empty(), "{:?}", labels(&window, ""));
    let roughing = window.query_all_by_label_contains("25 min, wheel 6.8 h").count();
    assert!(roughing > 0, "the list of operations says the same");
}

/// A plan that the machine cannot run has no time beside one that it runs.
#[test]
fn plans_that_the_machine_refuses_are_named_instead_of_timed() {
    let time = MachineTime { total_s: 1500.0, tool_changes_s: 60.0 };
    let window = with_sample(fake::engine_that_refuses_others(time));
    assert!(!labels(&window, "not on this machine").is_empty(), "{:?}", labels(&window, ""));
    assert!(!labels(&window, "25 min per channel").is_empty());
}

/// The clock at the timeline is that of the machine, and that of flank plans begins with the plunges that
/// open the stock.
#[test]
fn the_clock_is_that_of_the_machine() {
    let mut window = with_machine("ac-trunnion");
    let of_machine = |window: &Window| {
        let (now, whole) = window.state().state().clock().expect("a clock");
        assert_eq!(Some(&whole), on_machine(window).clock.last());
        assert!(now <= whole);
        whole
    };
    let whole = of_machine(&window);
    plan_flank(&mut window, 10.0);
    let flank = window.state().state().results.flank.clone().expect("planned");
    let of_flank = of_machine(&window);
    // So are the times in the table of passes.
    let first = window.state().state().results.passes.passes[0].end;
    let time = format_clock(on_machine(&window).clock[first - 1]);
    assert!(!labels(&window, &time).is_empty(), "{time} in {:?}", labels(&window, "0:"));
    let time = flank.machine_time.expect("the machine runs it").total_s;
    // The way out after the last cut comes to it.
    assert!(of_flank <= time + 1e-6 && of_flank > 0.98 * time, "{of_flank} s of {time} s");
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    settle(&mut window);
    choose(&mut window, "None");
    let (_, estimate) = window.state().state().clock().expect("a clock");
    assert!(estimate < whole, "{estimate} s without accelerations, {whole} s on the machine");
}

#[test]
fn without_a_machine_no_axes_are_shown() {
    let (engine, _) = fake::engine();
    let window = with_sample(engine);
    assert!(window.state().state().results.on_machine.is_none());
    assert_eq!(words(&window, "calculating…"), None);
    assert_eq!(line_of_axes(&window), None);
}

#[test]
fn the_axes_beside_the_timeline_hold_the_tool_where_the_position_says() {
    let mut window = with_machine("ac-trunnion");
    assert_eq!(window.state().state().document.edited.setup.machine.file.as_deref(), Some("ac-trunnion"));
    let tilt = window.state().state().document.edited.setup.machine.max_axis_tilt_rad.to_degrees();
    assert!((tilt - 120.0).abs() < 0.01, "the planner keeps to the tilt that the machine reaches: {tilt}");
    window.get_by_role_and_label(Role::Button, "Go to start").click();
    window.run_steps(2);
    let start = axes(&window);
    for _ in 0..5 {
        window.key_press(egui::Key::ArrowRight);
        window.run_steps(2);
    }
    let now = axes(&window);
    let letters: Vec<char> = now.iter().map(|(letter, _)| *letter).collect();
    assert_eq!(letters, ['X', 'Y', 'Z', 'A', 'C']);
    assert_ne!(start, now, "the axes move with the timeline");
    let state = window.state().state();
    assert_eq!(state.look.cut_count, Some(5));
    let plan = state.shown().expect("planned").plan();
    let stray = held_by_trunnion(&window, &now).angle(&plan.positions[4].axis).to_degrees();
    assert!(stray < 1e-3, "{now:?} holds the tool {stray}° off");
    let machine = on_machine(&window);
    let tip = machine.placed.point_in_part(&machine.ends[4].expect("a position").pose.tip);
    assert!((tip - plan.positions[4].tip).norm() < 1e-9);
    // The sectional view follows in the background.
    settle(&mut window);
    snapshot_view(&mut window, "machine_axes");
}

/// Axis of the tool in the frame of the part at the `axes` of the AC trunnion, by its closed form: C turns
/// about Z, A about X.
pub fn held_by_trunnion(window: &Window, axes: &[(char, f64)]) -> Vector {
    let (a, c) = (axes[3].1.to_radians(), axes[4].1.to_radians());
    let held = rotate_vector_z(&Vector::new(0.0, -a.sin(), a.cos()), c);
    on_machine(window).placed.vector_in_part(&held)
}

#[test]
fn the_axes_of_a_flank_plan_stand_beside_its_timeline() {
    let mut window = with_machine("ac-trunnion");
    plan_flank(&mut window, 10.0);
    let moves = window.state().state().results.flank.clone().expect("planned").plan.moves.clone();
    assert_eq!(on_machine(&window).fault, None);
    let mut seen = std::collections::BTreeSet::new();
    for cut in [1, 40, moves.len() / 2, moves.len()] {
        window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit(cut as f64);
        window.run_steps(3);
        let now = axes(&window);
        assert_eq!(now.iter().map(|(letter, _)| *letter).collect::<String>(), "XYZAC");
        let stray = held_by_trunnion(&window, &now).angle(&moves[cut - 1].axis).to_degrees();
        assert!(stray < 1e-3, "{now:?} holds the tool {stray}° off move {cut}");
        let (placed, at) = (on_machine(&window).placed, on_machine(&window).at(Some(cut)).expect("runs"));
        assert!((placed.point_in_part(&at.pose.tip) - moves[cut - 1].tip).norm() < 1e-9);
        seen.insert(format!("{now:?}"));
    }
    assert_eq!(seen.len(), 4, "the axes move with the timeline");
    let rect = window.get_by_label("Rotary axes over the program").rect();
    press(&mut window, rect.lerp_inside(egui::vec2(0.5, 0.6)));
    window.run_steps(3);
    let cut = window.state().state().look.flank.cut.expect("on the timeline");
    assert!(cut.abs_diff(moves.len() / 2) <= moves.len() / 100, "{cut} of {}", moves.len());
    // The plunge plan has axes of its own.
    let of_flank = on_machine(&window).ends.len();
    window.get_by_label_contains("Roughing: ").click();
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(on_machine(&window).ends.len(), window.state().state().position_count());
    assert_ne!(on_machine(&window).ends.len(), of_flank);
}

/// Opens a setup with a machine file of its own, `narrow.toml`, with hardly any tilt.
pub fn open_narrow_machine(window: &mut Window, folder: &Path) {
    let text = include_str!("../../assets/machines/ac-trunnion.toml").replace("[-120, 120]", "[-5, 5]");
    std::fs::write(folder.join("narrow.toml"), text).unwrap();
    let setup = folder.join("setup.toml");
    std::fs::write(&setup, "[machine]\nfile = \"narrow.toml\"\nmax_axis_tilt = 90\n").unwrap();
    window.state_mut().open_path(setup);
    settle(window);
}

#[test]
fn a_machine_that_cannot_run_the_plan_says_why() {
    let mut window = with_machine("ac-trunnion");
    assert_eq!(on_machine(&window).fault, None);
    let folder = tempfile::tempdir().unwrap();
    open_narrow_machine(&mut window, folder.path());
    let faults = labels(&window, "AC trunnion: A would have to be");
    assert_eq!(faults.len(), 1, "below the timeline: {:?}", labels(&window, "AC"));
    window.get_by_label_contains("Rotary axes over the program: AC trunnion: A would have to be");
    assert!(on_machine(&window).ends.is_empty());
    // Its post is not asked for an APT file.
    let (ctx, path) = (window.ctx.clone(), folder.path().join("p.apt"));
    window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels: 1 }, path.clone());
    window.run_steps(3);
    window.get_by_label_contains("• AC trunnion cannot run it: ");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    settle(&mut window);
    assert!(!path.exists());
    choose(&mut window, "None");
    assert!(window.state().state().results.on_machine.is_none());
    assert_eq!(words(&window, "A would have to be"), None);
}

#[test]
fn colours_by_time_have_the_clock_of_the_machine() {
    let (engine, _) = fake::engine();
    let timed = |outcome: &mut PlanOutcome| {
        let machine = read_machine("ac-trunnion".as_ref()).expect("known");
        let clock = MachineClock::new(machine, &outcome.workpiece, &outcome.setup.allowances);
        outcome.clock = PlanClock::new(Some(clock)).into();
    };
    let mut window = with_sample(fake::with_changed_plans(engine, timed));
    window.set_size(egui::vec2(1280.0, 1000.0));
    window.run_steps(3);
    choose(&mut window, "ac-trunnion");
    let state = window.state().state();
    let (shown, (_, whole)) = (state.shown().expect("planned"), state.clock().expect("known"));
    let last = shown.planned.time_after(shown.policy, state.position_count()).expect("known");
    assert!((last - whole).abs() < 1e-6, "{last} s, and {whole} s on the timeline");
    let program = ClProgram::of_plan("", shown.plan());
    assert!(last > 1.01 * Travel::from_program(&program).time, "with accelerations: {last} s");
}

#[test]
fn the_table_warns_of_axis_limits_and_of_the_pole() {
    let mut window = with_machine("ac-trunnion");
    assert!(window.query_by_label("Sort by axis warnings").is_some(), "a column of its own");
    let count = window.state().state().position_count();
    let first = on_machine(&window).ends[0].expect("a position").pose.axis;
    let folder = tempfile::tempdir().unwrap();
    // A tilts as far as the position in the middle needs.
    let middle = on_machine(&window).machine.pole_angle(&on_machine(&window).ends[8].unwrap().pose.axis);
    let text = include_str!("../../assets/machines/ac-trunnion.toml");
    // C is where the tool of the first position is, with the part turned so that A reaches there.
    let pole = format!("dir = [0, {:?}, {:?}]", -first.x.hypot(first.y), -first.z);
    let clock = format!("clock = {:?}", 90.0 - first.y.atan2(first.x).to_degrees());
    let narrow = format!("[-{0:?}, {0:?}]", middle.to_degrees());
    let open = |window: &mut Window, text: &str| {
        std::fs::write(folder.path().join("own.toml"), text).unwrap();
        let setup = folder.path().join("setup.toml");
        std::fs::write(&setup, "[machine]\nfile = \"own.toml\"\nmax_axis_tilt = 90\n").unwrap();
        choose(window, "None");
        window.state_mut().open_path(setup);
        settle(window);
    };
    let only_warnings = |window: &mut Window| {
        window.get_by_role_and_label(Role::ComboBox, "Positions").click();
        window.run_steps(2);
        window.get_by_label("Axis warnings only").click();
        window.run_steps(3);
        window.state().state().rows()
    };
    open(&mut window, &text.replace("[-120, 120]", &narrow));
    let beyond = only_warnings(&mut window);
    assert!(beyond.len() > 3 && beyond.len() + 3 < count, "{} of {count} beyond", beyond.len());
    window.get_by_label("Sort by axis warnings").click();
    window.run_steps(3);
    let worst = window.state().state().rows()[0];
    let excess = |k: usize| on_machine(&window).demands[k].fault.as_ref().and_then(|fault| fault.excess());
    assert!(beyond.iter().all(|&k| excess(k) <= excess(worst)), "the worst one first");
    let cell = format!("A +{:.0}°", excess(worst).expect("beyond").to_degrees());
    window.get_all_by_label(&cell).next().expect("the excess in the row");
    snapshot_view(&mut window, "machine_limits");

    open(&mut window, &text.replace("dir = [0, 0, -1]", &pole).replace("clock = 0.0", &clock));
    let near = only_warnings(&mut window);
    assert!(near.contains(&0) && near.len() < count, "near the pole: {near:?}");
    window.get_all_by_label("P 0.0°").next().expect("at the pole");
}

#[test]
fn a_click_in_the_plot_of_the_rotary_axes_moves_the_timeline() {
    let mut window = with_machine("b-head-c-table");
    let count = window.state().state().position_count();
    let rect = window.get_by_label("Rotary axes over the program").rect();
    for (share, wanted) in [(0.5, count.div_ceil(2)), (0.999, count), (0.001, 1)] {
        press(&mut window, rect.lerp_inside(egui::vec2(share, 0.6)));
        window.run_steps(3);
        let cut = window.state().state().look.cut_count.expect("on the timeline");
        assert!(cut.abs_diff(wanted) <= 1, "{cut} of {count} at {share}");
        assert_eq!(window.state().state().look.selected, Some(cut - 1), "the table follows");
    }
    choose(&mut window, "None");
    assert!(window.query_by_label("Rotary axes over the program").is_none(), "no machine, no plot");
}

#[test]
fn the_machine_is_a_layer_of_the_view() {
    let mut window = with_machine("ac-trunnion");
    assert!(!window.state().state().look.layers.machine, "off at first");
    window.get_by_role_and_label(Role::Button, "Layers").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::CheckBox, "Machine").click();
    window.run_steps(2);
    window.key_press(egui::Key::Escape);
    assert!(window.state().state().look.layers.machine);
    window.state_mut().look_mut().cut_count = Some(9);
    let view = window.get_by_label("3D view").rect();
    window.hover_at(view.center());
    for _ in 0..2 {
        turn_wheel(&mut window, -120.0, 6);
    }
    settle(&mut window);
    snapshot_view(&mut window, "machine_trunnion");
    choose(&mut window, "b-head-c-table");
    snapshot_view(&mut window, "machine_head");
}

/// A view along the tool is from within or behind the head.
#[test]
fn the_head_of_the_machine_does_not_hide_the_part() {
    for name in ["ac-trunnion", "b-head-c-table"] {
        let mut window = with_machine(name);
        window.key_press(egui::Key::Num4);
        window.run_steps(20);
        let view = window.get_by_label("3D view").rect();
        let middle = egui::Rect::from_center_size(view.center(), 0.6 * view.size());
        let camera = window.state().camera().expect("a camera");
        let hides = |window: &Window, cut: usize, camera| {
            on_machine(window).head_hides(Some(cut), camera, view.aspect_ratio())
        };
        let count = window.state().state().position_count();
        let cut = (1..=count).find(|&cut| hides(&window, cut, &camera)).expect("a hidden one");
        window.state_mut().look_mut().cut_count = Some(cut);
        window.run_steps(3);
        settle(&mut window);
        let share = covered_and_same(&mut window, middle);
        // The cutter and the table are drawn.
        assert!(share > 0.5, "{name}: {share} of what the head would cover is as without the machine");
        // From beside it is drawn.
        window.key_press(egui::Key::Num2);
        window.run_steps(20);
        let camera = window.state().camera().expect("a camera");
        assert!(!hides(&window, cut, &camera), "{name}: from beside");
        window.state_mut().look_mut().layers.machine = false;
        let share = covered_and_same(&mut window, middle);
        assert!(share < 0.1, "{name}: from beside {share} of what the head covers is as without it");
    }
}

/// Of the pixels of `middle` in which the head of the machine is seen where it is drawn, the share that is
/// the same with the layer of the machine, which is switched on, as without it.
fn covered_and_same(window: &mut Window, middle: egui::Rect) -> f64 {
    window.run_steps(3);
    settle(window);
    let without = pixels_in(window, middle);
    window.state_mut().look_mut().layers.machine = true;
    window.run_steps(3);
    settle(window);
    let with = pixels_in(window, middle);
    let (camera, view) = (window.state().camera().expect("a camera"), window.get_by_label("3D view").rect());
    let on_machine = on_machine(window);
    let at = on_machine.at(window.state().state().look.cut_count).expect("it runs");
    let head = head_mesh(&PosedMachine {
        machine: &on_machine.machine,
        placed: &on_machine.placed,
        blank: on_machine.blank,
        joints: at.joints,
        angles: at.pose.angles,
        tool: at.tool,
    });
    let size = glam::vec2(view.width(), view.height());
    let columns = middle.right() as usize - middle.left() as usize;
    // Every seventh pixel is enough.
    let seen = (0..without.len()).step_by(7).filter(|k| {
        let pixel = glam::vec2((k % columns) as f32, (k / columns) as f32);
        let corner = glam::vec2(middle.left() - view.left(), middle.top() - view.top());
        let ray = camera.ray(corner + pixel + 0.5, size);
        let hit = head.hit(&ray).map(|hit| ray.origin + ray.direction * hit.distance);
        // In front of the part: what is behind it is not seen anyway.
        hit.is_some_and(|point| (point - camera.target).dot(camera.basis().2) > 0.0)
    });
    let seen: Vec<usize> = seen.collect();
    assert!(seen.len() > 100, "the head is in the view: {}", seen.len());
    seen.iter().filter(|&&k| without[k] == with[k]).count() as f64 / seen.len() as f64
}

#[test]
fn the_axes_of_a_position_are_shown_under_the_pointer() {
    let mut window = with_machine("ac-trunnion");
    let values = |window: &Window, k: usize| {
        let machine = on_machine(window);
        let at = machine.at(Some(k + 1)).expect("it runs");
        let axes = machine.named(at).map(|(name, value, unit)| format!("{name} {value:.3}{unit}"));
        axes.join("  ").replace('-', "−")
    };
    let third = values(&window, 2);
    assert!(third.contains("A ") && third.contains("C "), "{third}");
    window.get_by_label("Position 3").hover();
    window.run_steps(8);
    window.get_by_label(&third);
    // In the 3D view.
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    let plan = window.state().state().shown().expect("planned").plan();
    let tip = &plan.positions[8];
    let inside = tip.tip + tip.axis * 3.0;
    let point = glam::vec3(inside.x as f32, inside.y as f32, inside.z as f32);
    let rect = window.get_by_label("3D view").rect();
    let camera = window.state().camera().expect("a camera");
    let pixel = camera.project(point, glam::vec2(rect.width(), rect.height())).expect("in front");
    window.hover_at(rect.min + egui::vec2(pixel.x, pixel.y));
    window.run_steps(8);
    let title = labels(&window, "Position ").pop().expect("a cutter is there");
    let number: usize = title.trim_start_matches("Position ").parse().expect("a number");
    window.get_by_label(&values(&window, number - 1));
    window.get_by_label_contains(" mm/min, ");
    window.get_by_label_contains("Cut after ");
}

/// In a narrow view, such as that of a screen of 1360 pixels at 150 %, no axis is cut off.
#[test]
fn the_line_of_the_axes_fits_into_a_narrow_view() {
    let mut window = with_machine("ac-trunnion");
    for width in [1280.0, 1100.0, 907.0] {
        window.set_size(egui::vec2(width, 600.0));
        window.run_steps(4);
        let names: String = axes(&window).iter().map(|(name, _)| *name).collect();
        assert_eq!(names, "XYZAC", "{width}");
        let text = line_of_axes(&window).expect("a line");
        let room = window.get_by_label("3D view").rect().width();
        let needed = 6.6 * text.chars().count() as f32;
        assert!(
            needed <= room,
            "window {width}: {text:?} needs {needed} points, but the view is only {room} wide"
        );
    }
}

/// The arrows go through a list that the mouse opened, and not through the table behind it.
#[test]
fn the_arrows_are_those_of_an_open_list() {
    let mut window = with_machine("ac-trunnion");
    window.key_press(egui::Key::ArrowDown);
    window.run_steps(3);
    let selected = |window: &Window| window.state().state().look.selected;
    assert_eq!(selected(&window), Some(0));
    let list = window.get_by_role_and_label(Role::ComboBox, "Machine").rect().center();
    press(&mut window, list);
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "bc-trunnion");
    for _ in 0..2 {
        window.key_press(egui::Key::ArrowDown);
        window.run_steps(2);
        assert_eq!(selected(&window), Some(0), "the list has the keys");
    }
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    window.key_press(egui::Key::ArrowDown);
    window.run_steps(3);
    assert_eq!(selected(&window), Some(1));
}

#[test]
fn a_table_that_is_popped_out_has_room_for_the_column_of_the_machine() {
    let mut window = with_machine("ac-trunnion");
    window.state_mut().look_mut().panels.pop_out(DockPanel::Table);
    window.run_steps(8);
    settle(&mut window);
    let right = window.get_by_label("Close window").rect().right();
    let list = window.get_by_role_and_label(Role::ComboBox, "Positions").rect();
    assert!(list.right() < right + 6.0, "{list} reaches beyond {right}");
}
