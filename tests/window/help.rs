//! Help in the window.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::panels::DockPanel;

use crate::fake;
use crate::harness::{sample_in, snapshot_ui, window};

#[test]
fn shortcuts_glossary_and_version_can_be_read_in_the_window() {
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.key_press(egui::Key::F1);
    window.run_steps(3);
    window.get_by_label("Calculate roughing");
    window.get_by_label("F5");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Calculate roughing").is_none(), "Esc closes it");

    window.get_by_label("Help").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Glossary").click();
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::Button, "Tour").is_none(), "the menu is closed");
    // Its search takes what is typed.
    window.event(egui::Event::Text("rest milling".to_owned()));
    window.run_steps(3);
    window.get_by_label_contains("rest milling: ");
    assert!(window.query_by_label_contains("trailing edge").is_none(), "only what was searched");
    window.event(egui::Event::Text("zzz".to_owned()));
    window.run_steps(3);
    window.get_by_label("No entry has these words");
    window.get_by_label("Close").click();
    window.run_steps(3);

    window.get_by_label("Help").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "About Vanecut").click();
    window.run_steps(3);
    window.get_by_label(&format!("Vanecut {}", env!("CARGO_PKG_VERSION")));
}

#[test]
fn the_tour_is_offered_once_and_shows_the_parts_of_the_window() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let start = || {
        let (engine, _) = fake::engine();
        let mut window = window(engine);
        window.set_size(egui::vec2(1280.0, 800.0));
        window.state_mut().set_home(home.clone());
        window.state_mut().offer_tour();
        window.run_steps(2);
        assert!(window.query_by_label("1 of 5").is_none(), "not before there is something to show");
        sample_in(window)
    };
    let mut first = start();
    first.run_steps(2);
    first.get_by_label("1 of 5");
    snapshot_ui(&mut first, "tour");
    for (button, page) in [("Next", 2), ("Next", 3), ("Back", 2), ("Next", 3), ("Next", 4), ("Next", 5)] {
        first.get_by_role_and_label(Role::Button, button).click();
        // A card of another height takes its place.
        first.run_steps(5);
        let number = first.get_by_label(&format!("{page} of 5")).rect();
        // Panels have the names of their tabs and menus.
        let panel = [(3, DockPanel::Picture), (4, DockPanel::Table)].into_iter().find(|(of, _)| *of == page);
        if let Some((_, panel)) = panel {
            let mut titles = first.query_all_by_label(panel.title()).map(|title| title.rect());
            let above = titles.find(|title| title.left() == number.left() && title.bottom() < number.top());
            assert!(above.is_some(), "{}", panel.title());
        }
    }
    first.get_by_role_and_label(Role::Button, "Done").click();
    first.run_steps(2);
    assert!(first.query_by_label_contains(" of 5").is_none(), "it ends");
    drop(first);

    let mut again = start();
    again.run_steps(3);
    assert!(again.query_by_label("1 of 5").is_none(), "it is known");
    again.get_by_label("Help").click();
    again.run_steps(2);
    again.get_by_role_and_label(Role::Button, "Tour").click();
    again.run_steps(3);
    again.get_by_label("1 of 5");
    again.get_by_role_and_label(Role::Button, "Skip tour").click();
    again.run_steps(2);
    assert!(again.query_by_label("1 of 5").is_none());
    again.get_by_label("Help").click();
    again.run_steps(2);
    again.get_by_role_and_label(Role::Button, "Tour").click();
    again.run_steps(3);
    again.get_by_label("1 of 5");
    again.key_press(egui::Key::F5);
    again.run_steps(2);
    again.key_press(egui::Key::Escape);
    again.run_steps(3);
    assert!(again.query_by_label("1 of 5").is_none(), "Escape ends the tour");
    assert!(again.query_by_label_contains("Calculation cancelled").is_none(), "and nothing else");
}
