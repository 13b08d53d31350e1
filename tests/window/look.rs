//! The window at two scalings and in both themes, idle, and as a picture file.

use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;

use crate::fake;
use crate::harness::{click_enabled, sample_in, scaled, settle, snapshot_view, with_sample};

#[test]
fn both_themes_on_an_ordinary_screen() {
    both_themes_at(1.0);
}

#[test]
fn both_themes_on_a_dense_screen() {
    both_themes_at(1.5);
}

fn both_themes_at(scale: f32) {
    let (engine, _) = fake::engine();
    let mut window = sample_in(scaled(engine, scale));
    window.key_press(egui::Key::Num4);
    for (theme, name) in [(egui::Theme::Dark, "dark"), (egui::Theme::Light, "light")] {
        window.ctx.set_theme(theme);
        window.run_steps(6);
        assert_eq!(
            window.ctx.content_rect().size(),
            egui::vec2(900.0, 600.0),
            "the same room for everything"
        );
        snapshot_view(&mut window, &format!("{name}_at_{}", scale * 100.0));
    }
}

#[test]
fn at_rest_nothing_is_drawn() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.run_steps(20);
    assert!(window.run_ok().is_some_and(|steps| steps <= 2), "it comes to rest");
    assert!(!window.ctx.has_requested_repaint(), "and asks for nothing more");
}

#[test]
fn pictures_have_the_size_and_the_background_that_were_asked_for() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let folder = tempfile::tempdir().expect("a folder");
    window.key_press_modifiers(egui::Modifiers::COMMAND | egui::Modifiers::SHIFT, egui::Key::E);
    window.run_steps(3);
    window.get_by_label("Current view size").click();
    window.run_steps(2);
    window.get_by_label("Transparent background").click();
    window.get_by_label("Include legend").click();
    window.run_steps(2);
    click_enabled(&window, "Cancel");
    window.run_steps(2);
    let settings = window.state_mut().export_settings_mut();
    assert!(settings.size.is_some() && settings.transparent && settings.legend, "{settings:?}");
    settings.size = Some([640, 400]);
    let save = |window: &mut crate::harness::Window, name: &str| {
        let path = folder.path().join(name);
        let ctx = window.ctx.clone();
        window.state_mut().file_chosen(&ctx, Purpose::SavePicture, path.clone());
        settle(window);
        let bytes = std::fs::read(path).expect("a picture");
        let side = |at: usize| u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        ((side(16), side(20)), bytes.len())
    };
    let (size, transparent) = save(&mut window, "a.png");
    assert_eq!(size, (640, 400));
    let settings = window.state_mut().export_settings_mut();
    (settings.size, settings.transparent) = (Some([1280, 800]), false);
    let (size, opaque) = save(&mut window, "b.png");
    assert_eq!(size, (1280, 800));
    assert_ne!(transparent, opaque);
}
