//! Help in the window.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

use crate::fake;
use crate::harness::window;

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
    window.get_by_role_and_label(Role::TextInput, "Search the glossary").focus();
    window.run_steps(1);
    window.event(egui::Event::Text("rest milling".to_owned()));
    window.run_steps(3);
    window.get_by_label_contains("rest milling: ");
    assert!(window.query_by_label_contains("trailing edge").is_none(), "only what was searched");
    window.get_by_label("Close").click();
    window.run_steps(3);

    window.get_by_label("Help").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "About Vanecut").click();
    window.run_steps(3);
    window.get_by_label(&format!("Vanecut {}", env!("CARGO_PKG_VERSION")));
}
