//! What stays where it is, what a new part starts with, and what can be read.

use egui::accesskit::Role;
use egui::{Color32, Theme};
use egui_kittest::kittest::Queryable;
use vanecut::app::model::figures::format_clock;
use vanecut::app::model::look::Operation;
use vanecut::app::model::panels::DockPanel;
use vanecut::app::model::part_source::PartSource;
use vanecut::app::tasks::engine::Engine;
use vanecut::app::views::theme::{self, Condition};
use vanecut::job::{PlanOutcome, PolicyResult};
use vanecut::plunge::{AddedPlunges, DropReason, Dropped, StopReason};

use crate::fake;
use crate::harness::{Window, sample_in, scaled, settle, snapshot_view, turn_wheel, window, with_sample};

fn view(window: &Window) -> egui::Rect {
    window.get_by_label("3D view").rect()
}

fn set_hub_allowance(window: &mut Window, value: f64) {
    window.get_by_role_and_label(Role::SpinButton, "Hub allowance").set_value_accesskit(value);
    window.run_steps(3);
    settle(window);
}

#[test]
fn a_problem_moves_neither_picture_nor_fields_and_replaces_the_one_before() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let (picture, step) = (view(&window), window.get_by_role_and_label(Role::SpinButton, "Step").rect());
    for allowance in [12.0, 16.0, 17.0, 18.0] {
        set_hub_allowance(&mut window, allowance);
        assert_eq!(view(&window), picture, "the picture stays");
        assert_eq!(window.get_by_role_and_label(Role::SpinButton, "Step").rect(), step, "so do the fields");
    }
    assert_eq!(window.state().state().problems.len(), 1, "{:?}", window.state().state().problems);
    window.get_by_label("\"Hub allowance\" is 18, too much");
    window.get_by_label("Fix: make \"Hub allowance\" smaller");
    window.get_by_label("1 problem: see the message");
    window.get_by_label("Dismiss").click();
    window.run_steps(3);
    assert!(window.state().state().problems.is_empty() && window.state().state().notice.is_none());
}

#[test]
fn the_first_plan_does_not_move_the_picture() {
    let (engine, slow) = fake::engine();
    let mut window = window(engine);
    slow.store(true, std::sync::atomic::Ordering::SeqCst);
    window.state_mut().open_part(PartSource::Sample("impeller532".to_owned()));
    while window.state().state().document.part.is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
        window.step();
    }
    window.run_steps(6);
    assert!(window.state().is_busy(), "planning");
    let planning = view(&window);
    slow.store(false, std::sync::atomic::Ordering::SeqCst);
    settle(&mut window);
    let planned = view(&window);
    assert_eq!((planned.left(), planned.right()), (planning.left(), planning.right()));
    let box_of = |label: &str| window.get_by_role_and_label(Role::SpinButton, label).rect().x_range();
    for label in ["Stepover", "Max tilt", "Hub allowance", "Inlet overhang"] {
        assert_eq!(box_of(label), box_of("Step"), "{label} is in the column of the others");
    }
}

#[test]
fn a_new_part_starts_with_its_own_scroll_places_and_open_headings() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let count = window.state().state().position_count();
    window.state_mut().look_mut().select(Some(count - 1));
    window.run_steps(6);
    window.state_mut().look_mut().select(None);
    let top = |window: &Window| window.get_by_label("Calculate roughing").rect().top();
    let at_start = top(&window);
    window.get_by_label("Plunge").click();
    window.run_steps(3);
    let scroll = |window: &mut Window, delta: f32| {
        window.hover_at(egui::pos2(60.0, 300.0));
        turn_wheel(window, delta, 6);
    };
    scroll(&mut window, -400.0);
    assert!(window.query_by_role_and_label(Role::Row, "Position 1").is_none(), "scrolled down");
    assert!(window.query_by_role_and_label(Role::SpinButton, "Step").is_none(), "closed");
    assert!(top(&window) < at_start - 40.0, "scrolled down");

    window.state_mut().open_part(PartSource::Sample("pump6".to_owned()));
    window.run_steps(2);
    settle(&mut window);
    window.get_by_role_and_label(Role::Row, "Position 1");
    window.get_by_role_and_label(Role::SpinButton, "Step");
    assert_eq!(top(&window), at_start, "at the top");
}

#[test]
fn controls_over_the_picture_do_not_cover_each_other_from_80_to_200_percent() {
    let sizes = [
        (0.8, [1600.0, 900.0]),
        (1.0, [800.0, 500.0]),
        (1.5, [853.0, 533.0]),
        (1.5, [1280.0, 720.0]),
        (2.0, [800.0, 500.0]),
    ];
    for (scale, size) in sizes {
        let (engine, _) = fake::engine();
        let mut window = sample_in(scaled(engine, scale));
        window.set_size(size.into());
        window.run_steps(4);
        let names = ["Before", "After", "Both", "Wipe", "Layers", "Wheel", "Channel"];
        let rects = names.map(|name| window.get_by_role_and_label(Role::Button, name).rect());
        for (k, a) in rects.iter().enumerate() {
            assert!(view(&window).contains_rect(*a), "{} is inside at {size:?}", names[k]);
            assert!(a.height() < 28.0, "{} is on one line at {size:?}", names[k]);
            for (other, b) in rects.iter().enumerate().skip(k + 1) {
                assert!(!a.intersects(*b), "{} covers {} at {size:?}", names[k], names[other]);
            }
        }
        let fits = |name: &str| {
            let rect = window.get_by_role_and_label(Role::SpinButton, name).rect();
            assert!(rect.top() >= view(&window).bottom() && rect.right() <= view(&window).right(), "{name}");
        };
        fits("Scale minimum");
        fits("Scale maximum");
        // What the cutters' colours mean, and the clock, in text or without.
        let inside = |text: &str| {
            let found = window.query_all_by_label_contains(text).next();
            let rect = found.unwrap_or_else(|| panic!("{text} at {size:?}")).rect();
            let across = view(&window).x_range();
            assert!(across.contains(rect.left()) && across.contains(rect.right()), "{text}: {rect}");
        };
        inside("OK, ");
        let (now, _) = window.state().state().clock().expect("a time");
        inside(&format_clock(now));
    }
}

#[test]
fn one_operation_is_shown_at_a_time() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.operation, Operation::Flank);
    assert!(window.query_by_label("Timeline").is_none(), "the plunge plan is hidden");
    assert!(window.query_by_label("Sort by contact").is_none());
    assert!(window.query_by_label("Scale maximum").is_none(), "and so are its colours");
    window.get_by_label("Calculate flank");
    window.get_by_role_and_label(Role::Slider, "Layer depth");
    assert!(window.query_by_role_and_label(Role::SpinButton, "Step").is_none(), "so are its fields");
    window.get_by_role_and_label(Role::RadioButton, "Roughing: 18 min, wheel 5.1 h").click();
    window.run_steps(3);
    window.get_by_label("Sort by contact");
    window.get_by_label("Scale maximum");
}

#[test]
fn the_floor_by_core_contact_has_its_legend() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let picture = view(&window);
    assert!(window.get_by_label("Scale maximum").rect().top() >= picture.bottom(), "beside the picture");
    window.state_mut().look_mut().layers.floor = vanecut::gpu::scene::FloorColours::Interference;
    window.run_steps(2);
    window.get_by_label("Core contact");
    window.get_by_label("Scale maximum");
}

/// Relative luminance of a colour (WCAG 2).
fn luminance(colour: Color32) -> f64 {
    let linear = |x: u8| {
        let x = f64::from(x) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
}

fn contrast(a: Color32, b: Color32) -> f64 {
    let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
    a.max(b) / a.min(b)
}

#[test]
fn text_has_a_contrast_of_at_least_4_5_and_is_not_too_small() {
    let (engine, _) = fake::engine();
    let window = window(engine);
    for of in [Theme::Dark, Theme::Light] {
        let style = window.ctx.style_of(of);
        let visuals = &style.visuals;
        let over_view = visuals.panel_fill.lerp_to_gamma(theme::view_background(visuals), 0.12);
        let grounds = [
            ("panel", visuals.panel_fill),
            ("field", visuals.extreme_bg_color),
            ("stripe", visuals.panel_fill.blend(visuals.faint_bg_color)),
            ("overlay", over_view),
        ];
        let text = visuals.text_color();
        let mut inks = vec![
            ("text", text),
            ("weak", visuals.weak_text_color()),
            ("button", visuals.widgets.inactive.text_color()),
            ("link", visuals.hyperlink_color),
            ("accent", theme::accent(visuals)),
        ];
        for condition in [Condition::Sound, Condition::Blocked, Condition::Interfering] {
            inks.push((condition.label(), condition.text(visuals)));
        }
        for (ground, back) in grounds {
            for &(ink, colour) in &inks {
                let ratio = contrast(colour, back);
                assert!(ratio >= 4.5, "{of:?}: {ink} on {ground} has {ratio:.2}");
            }
            let disabled =
                back.lerp_to_gamma(visuals.widgets.inactive.text_color(), visuals.disabled_alpha());
            let ratio = contrast(disabled, back);
            assert!(ratio >= 4.5, "{of:?}: disabled on {ground} has {ratio:.2}");
        }
        let selection = visuals.panel_fill.blend(visuals.selection.bg_fill);
        let ratio = contrast(visuals.selection.stroke.color, selection);
        assert!(ratio >= 4.5, "{of:?}: selected text has {ratio:.2}");
        let button = visuals.widgets.inactive.weak_bg_fill;
        let ratio = contrast(visuals.widgets.inactive.text_color(), button);
        assert!(ratio >= 4.5, "{of:?}: buttons have {ratio:.2}");
        let ratio = contrast(visuals.weak_text_color(), button);
        assert!(ratio >= 4.5, "{of:?}: weak on a button has {ratio:.2}");
        if of == Theme::Light {
            // Fields and boxes without a mark have a border that is seen (WCAG 2.1, 1.4.11).
            let border = visuals.widgets.inactive.bg_stroke;
            let ratio = contrast(border.color, visuals.panel_fill);
            assert!(border.width > 0.0 && ratio >= 3.0, "borders of fields have {ratio:.2}");
        }
        for (name, font) in &style.text_styles {
            assert!(font.size >= 11.0, "{name:?} is {} points", font.size);
        }
    }
}

#[test]
fn the_verdict_breaks_between_figures_and_never_within_one() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    for width in (800..1300).step_by(50) {
        window.set_size(egui::vec2(width as f32, 667.0));
        window.run_steps(3);
        let verdict = |rect: &egui::Rect| rect.top() < 80.0;
        let all = |text: &str| -> Vec<egui::Rect> {
            window.query_all_by_label_contains(text).map(|node| node.rect()).filter(verdict).collect()
        };
        for (name, value) in [("Time", "per channel, "), ("Residual", " to "), ("Not machined", " %")] {
            let (names, values) = (all(name), all(value));
            let name = names[0];
            let beside = |value: &&egui::Rect| (value.center().y - name.center().y).abs() < 4.0;
            let value = values.iter().find(beside);
            assert!(value.is_some(), "{width}: {names:?} {values:?}");
            assert!(values.iter().all(|value| value.height() < 1.5 * name.height()), "{width}: in one line");
        }
    }
}

#[test]
fn no_line_of_the_verdict_begins_with_a_divider() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let mut wrapped = 0;
    for width in (800..1300).step_by(25) {
        window.set_size(egui::vec2(width as f32, 500.0));
        window.run_steps(3);
        let start = window.get_by_label("Interfering plunges 5 to 0").rect();
        let names = ["Residual", "Hub clearance", "blade", "Not machined", "Time"];
        let of =
            |name: &&str| window.query_all_by_label(name).map(|node| node.rect()).find(|at| at.top() < 80.0);
        let below = names.iter().filter_map(of).filter(|at| at.center().y > start.bottom());
        let left = below.map(|at| at.left()).fold(f32::INFINITY, f32::min);
        assert!(left == start.left() || left == f32::INFINITY, "{width}: {left}");
        wrapped += usize::from(left.is_finite());
    }
    assert!(wrapped > 3, "{wrapped} widths with a second line");
}

/// The fake planner, of whose plans much is to be said.
fn engine_with_remarks() -> Engine {
    let (engine, _) = fake::engine();
    let poor = move |outcome: &mut PlanOutcome| {
        let (why, stick_out) = (DropReason::Blades, None);
        let PolicyResult { plan, summary, .. } = &mut outcome.after;
        plan.dropped = vec![Dropped { section: 0, row: 0, s: 0.5, why, stick_out }; 56];
        let stopped = StopReason::Cancelled;
        plan.sections[1].added = Some(AddedPlunges { count: 0, stopped });
        (summary.blocked, summary.inaccessible_share) = (Some(112), 0.065);
    };
    fake::with_changed_plans(engine, poor)
}

/// Also where the plan is out of date and unfinished: the last figure is not cut off.
#[test]
fn all_of_the_verdict_is_in_view() {
    let mut window = with_sample(engine_with_remarks());
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(3.0);
    for width in (800..1800).step_by(50) {
        window.set_size(egui::vec2(width as f32, 667.0));
        window.run_steps(4);
        for name in ["Out of date:", "Unfinished:", "56 blocked", "56 skipped", "Inaccessible"] {
            window.get_by_label(name);
        }
        let (setup, names) = (window.get_by_label("impeller532").rect(), window.query_all_by_label("Time"));
        let time = names.map(|node| node.rect()).find(|at| at.top() < 80.0).expect("a time");
        assert!(time.bottom() < setup.top(), "{width}: {time} is above {setup}");
    }
}

#[test]
fn the_states_of_cutters_have_their_legend_wherever_there_is_room() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    // As a screen of 1600 points at 150 %.
    window.set_size(egui::vec2(1067.0, 667.0));
    window.run_steps(3);
    window.get_by_label_contains("OK, ");
    window.get_by_label("Residual on hub");
}

/// The details below the table leave it less than ten rows in the smallest window.
#[test]
fn the_selected_row_and_the_last_one_are_in_view_in_a_low_table() {
    for (scale, size) in [(1.0, [800.0, 500.0]), (1.5, [853.0, 533.0]), (2.0, [800.0, 500.0])] {
        let (engine, _) = fake::engine();
        let mut window = sample_in(scaled(engine, scale));
        window.set_size(size.into());
        window.run_steps(4);
        let last = window.state().state().position_count();
        // So late that the table must scroll farther than it could while it was higher.
        window.state_mut().look_mut().select(Some(29));
        window.run_steps(4);
        settle(&mut window);
        window.run_steps(30);
        let row = |window: &Window, number: usize| {
            let name = format!("Position {number}");
            window.query_by_role_and_label(Role::Row, &name).map(|node| node.rect())
        };
        let head = window.get_by_label("Sort by contact").rect();
        let details = window.get_by_label_contains("Position 30 of ").rect();
        let is_seen = |at: Option<egui::Rect>| {
            at.is_some_and(|at| at.top() >= head.bottom() - 4.0 && at.bottom() <= details.top() + 4.0)
        };
        let selected = row(&window, 30);
        assert!(is_seen(selected), "{scale} {size:?}: {selected:?} between {head} and {details}");
        window.hover_at(head.center_bottom() + egui::vec2(0.0, 30.0));
        for _ in 0..10 {
            turn_wheel(&mut window, -400.0, 4);
        }
        let end = row(&window, last);
        assert!(is_seen(end), "{scale} {size:?}: {end:?} between {head} and {details}");
    }
}

/// Columns beside each other that do not fit scroll, instead of cutting their fields.
#[test]
fn four_columns_in_the_smallest_window_scroll_to_all_of_their_fields() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(800.0, 500.0));
    window.state_mut().look_mut().select(Some(2));
    window.state_mut().look_mut().panels.open(DockPanel::Machinability);
    window.state_mut().look_mut().panels.dock(DockPanel::Machinability);
    window.run_steps(6);
    for panel in ["Machinability", "Details"] {
        for name in ["View", "Panels", "Arrange", panel, "Move to the right"] {
            // A tab has the name of its panel, too: the menu is drawn before it.
            window.get_all_by_role_and_label(Role::Button, name).next().expect("a menu").click();
            window.run_steps(3);
        }
    }
    window.run_steps(6);
    settle(&mut window);
    let picture = view(&window);
    // The fields of the setup, the last column of the table, the tabs of the details.
    for (at, role, name) in [
        (egui::pos2(60.0, 300.0), Role::SpinButton, "Step"),
        (picture.right_center() + egui::vec2(60.0, 0.0), Role::Button, "Sort by residual stock"),
    ] {
        window.hover_at(at);
        for _ in 0..6 {
            window.event(egui::Event::MouseWheel {
                unit: egui::MouseWheelUnit::Point,
                delta: egui::vec2(-60.0, 0.0),
                phase: egui::TouchPhase::Move,
                source: egui::MouseWheelSource::Wheel,
                modifiers: egui::Modifiers::NONE,
            });
            window.run_steps(4);
        }
        let field = window.get_by_role_and_label(role, name).rect();
        let column = if name == "Step" { 0.0..=picture.left() } else { picture.right()..=800.0 };
        assert!(
            column.contains(&field.left()) && column.contains(&field.right()),
            "{name}: {field} {column:?}"
        );
    }
}

/// A notebook of 1280 × 800 pixels at 150 %.
#[test]
fn every_item_of_a_menu_can_be_reached_in_a_low_window() {
    let (engine, _) = fake::engine();
    let mut window = sample_in(scaled(engine, 1.5));
    window.set_size(egui::vec2(853.0, 533.0));
    window.run_steps(4);
    window.get_by_label("File").click();
    window.run_steps(4);
    let bottom = |window: &Window| window.get_by_label_contains("Quit").rect().bottom();
    assert!(bottom(&window) > 533.0, "the menu is longer than the window");
    window.hover_at(window.get_by_label_contains("Open setup").rect().center());
    window.run_steps(2);
    for _ in 0..20 {
        turn_wheel(&mut window, -60.0, 2);
    }
    window.run_steps(10);
    assert!(bottom(&window) < 533.0, "it scrolls to its end: {}", bottom(&window));
    window.key_press(egui::Key::Escape);
    window.run_steps(4);
    // Opened again, it begins at its top.
    let bar = window.get_by_label("File").rect().bottom();
    window.get_by_label("File").click();
    window.run_steps(4);
    let first = window.get_by_label_contains("Open project…").rect();
    assert!(first.top() > bar && bottom(&window) > 533.0, "{first}");
    window.key_press(egui::Key::Escape);
    window.run_steps(4);
    let timeline = window.get_by_role_and_label(Role::Slider, "Timeline").rect();
    assert!(timeline.width() > 80.0, "{timeline}");
    window.key_press(egui::Key::G);
    window.run_steps(6);
    let verdict = window.get_by_label("Not machined").rect();
    let panel = window.ctx.memory(|memory| {
        memory.area_rect(egui::Id::unique(("floating window", "Time against stock"))).expect("it is open")
    });
    assert!(panel.top() > verdict.bottom(), "{panel} hides the figures, which end at {verdict}");
}

/// On a small screen at 150 % the cube is drawn, `View` offers the text size, and the menu `File` shows that
/// it can be scrolled.
#[test]
fn a_small_screen_with_large_text_keeps_cube_and_menus() {
    let (engine, _) = fake::engine();
    let mut window = sample_in(scaled(engine, 1.5));
    window.set_size(egui::vec2(1360.0 / 1.5, 870.0 / 1.5));
    window.run_steps(4);
    settle(&mut window);
    assert!(window.query_all_by_label_contains("View from ").count() > 0, "the cube");
    window.get_by_label("View").click();
    window.run_steps(3);
    window.get_by_label("Text size").click();
    window.run_steps(3);
    window.get_by_label("100 %");
    window.get_by_label("Text size: larger").click();
    window.run_steps(3);
    assert!(window.ctx.zoom_factor() > 1.0);
    window.ctx.set_zoom_factor(1.0);
    window.key_press(egui::Key::Escape);
    window.run_steps(4);
    window.get_by_label("File").click();
    window.run_steps(4);
    let height = |label: &str| window.get_by_label_contains(label).rect().height();
    assert_eq!(height("Export NC program…"), height("Export CL (APT)…"), "no item breaks for the bar");
    snapshot_view(&mut window, "low_file_menu");
}
