//! Panels are moved, popped out and docked again, by the menu and by drag, and the layout is kept.

use std::path::Path;

use egui::accesskit::Role;
use egui::{Pos2, Rect, Vec2};
use egui_kittest::kittest::Queryable;
use vanecut::app::model::panels::DockPanel;

use crate::fake;
use crate::harness::{Window, sample_in, scaled, settle, snapshot_view, window, with_sample};

/// Opens menu after menu, and clicks what the last one is named.
fn choose(window: &mut Window, path: &[&str]) {
    for name in path {
        window.get_by_role_and_label(Role::Button, name).click();
        window.run_steps(3);
    }
    window.run_steps(2);
}

/// Chooses in the menu of a panel, in `View`, `Panels`.
fn arrange(window: &mut Window, panel: &str, change: &str) {
    choose(window, &["View", "Panels", "Arrange", panel, change]);
}

/// Shows or hides a panel by the menu.
fn toggle(window: &mut Window, panel: &str) {
    choose(window, &["View", "Panels"]);
    window.get_by_role_and_label(Role::CheckBox, panel).click();
    window.run_steps(5);
}

fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    window.hover_at(from);
    window.run_steps(2);
    window.drag_at(from);
    window.run_steps(2);
    // On the way the panel is taken along, and the tree shows where it would go.
    window.hover_at(from.lerp(to, 0.5));
    window.run_steps(2);
    window.hover_at(to);
    window.run_steps(2);
    window.drop_at(to);
    window.run_steps(5);
}

fn grip(window: &Window, panel: &str) -> Pos2 {
    window.get_by_label(&format!("Move panel: {panel}")).rect().center()
}

fn picture(window: &Window) -> Rect {
    window.get_by_label("3D view").rect()
}

/// The head of a column of the table: its rows reach beyond the panel.
fn row(window: &Window) -> Rect {
    window.get_by_label("Sort by contact").rect()
}

fn field(window: &Window) -> Rect {
    window.get_by_role_and_label(Role::SpinButton, "Step").rect()
}

fn timeline(window: &Window) -> Rect {
    window.get_by_role_and_label(Role::Slider, "Timeline").rect()
}

/// Where the main panels are.
fn places(window: &Window) -> [Rect; 4] {
    [field(window), picture(window), row(window), timeline(window)]
}

fn floats(window: &Window, panel: DockPanel) -> bool {
    window.state().state().look.panels.floats(panel)
}

/// A wide window with a planned sample, whose files are in `home`.
fn with_home(home: &Path) -> Window {
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.set_size(Vec2::new(1100.0, 700.0));
    window.state_mut().set_home(home.to_owned());
    sample_in(window)
}

#[test]
fn a_panel_is_hidden_and_shown_by_the_menu() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let before = picture(&window);
    toggle(&mut window, "Table");
    assert!(window.query_by_role_and_label(Role::Row, "Position 1").is_none(), "hidden");
    assert!(picture(&window).right() > before.right() + 200.0, "the picture takes its place");
    toggle(&mut window, "Setup");
    assert!(window.query_by_role_and_label(Role::SpinButton, "Step").is_none(), "hidden");
    assert!(picture(&window).left() < before.left() - 200.0, "the picture takes its place");
    toggle(&mut window, "Table");
    toggle(&mut window, "Setup");
    assert_eq!(picture(&window), before);
    row(&window);
    field(&window);
}

#[test]
fn a_panel_pops_out_by_the_menu_and_returns_to_its_place() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Plunge").click();
    window.run_steps(3);
    window.get_by_label("Plunge").click();
    window.run_steps(3);
    let before = places(&window);
    for (title, panel) in
        [("Table", DockPanel::Table), ("Setup", DockPanel::Setup), ("Timeline", DockPanel::Timeline)]
    {
        arrange(&mut window, title, "Pop out");
        assert!(floats(&window, panel), "{title}");
        assert_ne!(picture(&window), before[1], "{title} left its place");
        // What it shows can be used.
        row(&window);
        field(&window);
        timeline(&window);
        arrange(&mut window, title, "Dock");
        assert!(!floats(&window, panel), "{title}");
        assert_eq!(places(&window), before, "{title} is where it was");
    }
    // The button of its window docks it, too.
    arrange(&mut window, "Table", "Pop out");
    window.get_by_label("Position 3").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.selected, Some(2), "a row is clicked in the window");
    window.get_by_label("Close window").click();
    window.run_steps(4);
    assert!(!floats(&window, DockPanel::Table));
    assert_eq!(row(&window).left(), before[2].left());
}

#[test]
fn the_picture_can_neither_be_hidden_nor_popped_out() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    choose(&mut window, &["View", "Panels"]);
    assert!(window.query_by_role_and_label(Role::CheckBox, "3D view").is_none());
    choose(&mut window, &["Arrange", "3D view"]);
    assert!(window.query_by_label("Pop out").is_none() && window.query_by_label("Hide").is_none());
    window.get_by_label("Move to the right").click();
    window.run_steps(5);
    assert!(picture(&window).left() > row(&window).right(), "but it can be moved: {:?}", places(&window));
}

#[test]
fn a_panel_is_moved_by_drag() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(Vec2::new(1100.0, 700.0));
    window.run_steps(4);
    assert!(field(&window).right() < picture(&window).left());
    // To the right half of the picture.
    let to = picture(&window).center() + Vec2::new(0.25 * picture(&window).width(), 0.0);
    let from = grip(&window, "Setup");
    drag(&mut window, from, to);
    assert!(field(&window).left() > picture(&window).right(), "it stands at the right of the picture");
    assert!(field(&window).right() < row(&window).left(), "and at the left of the table");
    assert!(picture(&window).left() < 10.0, "nothing is left at the left");
    // By the menu below all.
    arrange(&mut window, "Table", "Move to the bottom");
    assert!(row(&window).top() > timeline(&window).bottom());
    window.get_by_label("Position 2").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.selected, Some(1));
    choose(&mut window, &["View", "Panels", "Reset layout"]);
    window.run_steps(3);
    let [setup, picture, table, _] = places(&window);
    assert!(setup.right() < picture.left() && table.left() > picture.right(), "{setup} {picture} {table}");
}

#[test]
fn a_panel_dropped_outside_pops_out_and_its_window_is_docked_by_drag() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(Vec2::new(1100.0, 700.0));
    window.run_steps(4);
    let before = places(&window);
    let from = grip(&window, "Table");
    drag(&mut window, from, Pos2::new(500.0, 10.0));
    assert!(floats(&window, DockPanel::Table), "dropped on the menu bar");
    assert!(picture(&window).right() > before[1].right() + 200.0);
    // Dropped on its own window it stays there.
    let from = grip(&window, "Table");
    drag(&mut window, from, from + Vec2::new(20.0, 60.0));
    assert!(floats(&window, DockPanel::Table), "still a window");
    // Dropped at the right edge it is docked there.
    let to = picture(&window).right_center() - Vec2::new(4.0, 0.0);
    let from = grip(&window, "Table");
    drag(&mut window, from, to);
    assert!(!floats(&window, DockPanel::Table), "docked");
    assert!(row(&window).left() > picture(&window).right(), "{} {}", row(&window), picture(&window));
    // Dropped outside, the picture stays where it is.
    let shown = picture(&window);
    let from = grip(&window, "3D view");
    drag(&mut window, from, Pos2::new(500.0, 10.0));
    assert_eq!(picture(&window), shown);
}

#[test]
fn what_a_command_opens_can_be_docked_beside_a_tab() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(Vec2::new(1100.0, 700.0));
    window.run_steps(4);
    window.key_press(egui::Key::A);
    window.run_steps(3);
    settle(&mut window);
    assert!(floats(&window, DockPanel::Machinability), "a window at first");
    let shown = picture(&window);
    arrange(&mut window, "Machinability", "Dock");
    window.get_by_label("Largest cutter");
    assert!(window.query_by_role_and_label(Role::Row, "Position 1").is_none(), "the table is behind it");
    assert_eq!(picture(&window), shown, "the picture stays");
    snapshot_view(&mut window, "docked_tabs");
    window.get_by_role_and_label(Role::Button, "Table").click();
    window.run_steps(3);
    row(&window);
    assert!(window.query_by_label("Largest cutter").is_none());
    // The command brings it to the front, then closes it; the table is without tabs again.
    window.key_press(egui::Key::A);
    window.run_steps(3);
    // It is measured while it is in view.
    settle(&mut window);
    window.get_by_label("Largest cutter");
    window.key_press(egui::Key::A);
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::Button, "Table").is_none());
    window.key_press(egui::Key::A);
    window.run_steps(4);
    settle(&mut window);
    window.get_by_label("Largest cutter");
    // Escape closes windows, and no docked panel.
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    window.get_by_label("Largest cutter");
}

#[test]
fn the_layout_is_there_after_a_restart_until_it_is_reset() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let mut first = with_home(&home);
    let default = places(&first);
    arrange(&mut first, "Setup", "Move to the right");
    arrange(&mut first, "Table", "Pop out");
    toggle(&mut first, "Plots along the row");
    first.run_steps(4);
    let moved = places(&first);
    assert_ne!(moved, default);
    drop(first);

    let mut second = with_home(&home);
    second.run_steps(4);
    assert!(floats(&second, DockPanel::Table) && field(&second).left() > picture(&second).right());
    assert_eq!(field(&second), moved[0]);
    assert_eq!((picture(&second), timeline(&second)), (moved[1], moved[3]));
    assert!(second.query_by_label("Lead angle along the row").is_none(), "hidden");
    choose(&mut second, &["View", "Panels", "Reset layout"]);
    second.run_steps(4);
    assert_eq!(places(&second), default);
    second.get_by_label("Lead angle along the row");
    drop(second);
    assert_eq!(places(&with_home(&home)), default, "the reset is kept, too");
}

/// Their place would leave the 3D view too low.
#[test]
fn plots_without_room_are_shown_in_a_window() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1000.0, 520.0));
    window.run_steps(4);
    assert!(window.query_by_label("Lead angle along the row").is_none());
    toggle(&mut window, "Plots along the row");
    assert!(floats(&window, DockPanel::Plots));
    window.get_by_label("Lead angle along the row");
    toggle(&mut window, "Plots along the row");
    assert!(window.query_by_label("Lead angle along the row").is_none(), "hidden");
}

/// At the start there is no plan, and nothing to show in the tab; it is in front again when there is one.
#[test]
fn the_tab_in_front_is_there_after_a_restart() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let curve = "Hub stock over time of a channel";
    let mut first = with_home(&home);
    first.key_press(egui::Key::G);
    first.run_steps(3);
    arrange(&mut first, "Time against stock", "Dock");
    settle(&mut first);
    first.get_by_label(curve);
    drop(first);
    let mut second = with_home(&home);
    settle(&mut second);
    second.run_steps(4);
    second.get_by_label(curve);
    // A window that opens leaves the tabs as they are.
    second.key_press(egui::Key::A);
    second.run_steps(4);
    assert!(floats(&second, DockPanel::Machinability));
    second.get_by_label(curve);
}

#[test]
fn a_damaged_layout_is_replaced_by_the_default() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let mut window = with_home(&home);
    let default = places(&window);
    arrange(&mut window, "Setup", "Move to the bottom");
    window.run_steps(4);
    drop(window);
    let file = home.join("layout.json");
    let text = std::fs::read_to_string(&file).expect("a layout");
    for damaged in [&text[..text.len() / 3], "[1, 2", &text.replace("\"version\": 1", "\"version\": 99")] {
        std::fs::write(&file, damaged).expect("writes");
        assert_eq!(places(&with_home(&home)), default);
    }
    std::fs::write(&file, &text).expect("writes");
    assert_ne!(places(&with_home(&home)), default, "the whole one is read");
}

#[test]
fn panels_keep_their_size_in_a_larger_window() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(Vec2::new(1000.0, 700.0));
    window.run_steps(4);
    // The border between setup and picture.
    let at = Pos2::new(picture(&window).left() - 0.5, 300.0);
    drag(&mut window, at, at + Vec2::new(60.0, 0.0));
    let left = picture(&window).left();
    assert!((left - at.x - 60.0).abs() < 3.0, "dragged: {left} from {}", at.x);
    let table = row(&window).width();
    for width in [1600.0, 1000.0] {
        window.set_size(Vec2::new(width, 700.0));
        window.run_steps(4);
        assert_eq!(picture(&window).left(), left, "{width}");
        assert_eq!(row(&window).width(), table, "{width}");
    }
}

#[test]
fn popped_out_panels_stay_within_the_smallest_window_from_100_to_200_percent() {
    for scale in [1.0, 1.5, 2.0] {
        let (engine, _) = fake::engine();
        let mut window = sample_in(scaled(engine, scale));
        window.set_size(Vec2::new(800.0, 500.0));
        window.state_mut().look_mut().select(Some(2));
        window.run_steps(4);
        settle(&mut window);
        let screen = Rect::from_min_size(Pos2::ZERO, Vec2::new(800.0, 500.0));
        for panel in
            DockPanel::ALL.into_iter().filter(|panel| panel.can_leave() && !panel.is_window_at_first())
        {
            window.state_mut().look_mut().panels.pop_out(panel);
            window.run_steps(5);
            let closes: Vec<Rect> =
                window.query_all_by_label("Close window").map(|node| node.rect()).collect();
            // Without a machine there are no axes.
            assert_eq!(closes.len(), usize::from(panel != DockPanel::Axes), "{panel:?} at {scale}");
            assert!(closes.iter().all(|at| screen.contains_rect(*at)), "{panel:?} at {scale}: {closes:?}");
            window.state_mut().look_mut().panels.dock(panel);
            window.run_steps(3);
        }
    }
}

/// Names of what the Tab key goes through in `count` presses from the field "Step" on; empty for what has
/// none.
fn stops(window: &mut Window, count: usize) -> Vec<String> {
    use egui_kittest::kittest::NodeT;
    window.get_by_role_and_label(Role::SpinButton, "Step").focus();
    window.run_steps(3);
    let mut names = Vec::new();
    for _ in 0..count {
        window.key_press(egui::Key::Tab);
        window.run_steps(2);
        let focused = window.query_all_by(|node| node.is_focused()).next();
        names.push(focused.and_then(|node| node.accesskit_node().label()).unwrap_or_default());
    }
    names
}

#[test]
fn the_tab_key_goes_through_fields_and_neither_grips_nor_borders() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let names = stops(&mut window, 150);
    assert!(names.iter().any(|name| name == "Stepover") && names.iter().any(|name| name == "Timeline"));
    let is_handle =
        |name: &&String| name.is_empty() || name.starts_with("Move panel") || name.starts_with("Border");
    let handles: Vec<&String> = names.iter().filter(is_handle).collect();
    assert!(handles.is_empty(), "{handles:?} of {names:?}");
}

#[test]
fn a_double_click_on_a_border_brings_back_the_size_at_first() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(Vec2::new(1100.0, 700.0));
    // A frame is a quarter of a second here.
    window.ctx.options_mut(|options| options.input_options.max_double_click_delay = 3.0);
    window.run_steps(4);
    let before = places(&window);
    // The borders beside the picture.
    for by in [80.0, 0.0] {
        for side in [-1.0, 1.0] {
            let edge = |window: &Window| {
                let picture = picture(window);
                let x = if side < 0.0 { picture.left() - 0.5 } else { picture.right() + 0.5 };
                Pos2::new(x, 300.0)
            };
            let at = edge(&window);
            if by != 0.0 {
                drag(&mut window, at, at + Vec2::new(-side * by, 0.0));
                let moved = edge(&window);
                assert!((moved.x - at.x + side * by).abs() < 3.0, "dragged from {at} to {moved}");
            }
            let at = edge(&window);
            for _ in 0..2 {
                crate::harness::press(&mut window, at);
            }
            // A third click soon after would be another thing.
            window.run_steps(20);
            assert_eq!(places(&window), before, "{by} {side}");
        }
    }
}

#[test]
fn the_size_of_a_window_is_there_after_a_restart() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let mut first = with_home(&home);
    arrange(&mut first, "Table", "Pop out");
    first.run_steps(4);
    let place = |window: &Window| {
        let rect =
            window.ctx.memory(|memory| memory.area_rect(egui::Id::unique(("floating window", "Table"))));
        rect.expect("it floats")
    };
    let before = place(&first);
    // By its lower right corner it is made wider and lower.
    let corner = before.right_bottom();
    drag(&mut first, corner - Vec2::splat(2.0), corner + Vec2::new(40.0, -120.0));
    first.run_steps(6);
    let left = place(&first);
    assert!(left.width() > before.width() + 20.0 && left.height() < before.height() - 60.0, "{left}");
    drop(first);
    let mut second = with_home(&home);
    second.run_steps(6);
    assert!(floats(&second, DockPanel::Table));
    let again = place(&second);
    let differs = (again.min - left.min).length().max((again.max - left.max).length());
    assert!(differs < 3.0, "{left} became {again}");
}
