//! A shop library of many tools, as makers have them.

use std::fmt::Write;

use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;

use crate::fake;
use crate::harness::{Window, click_enabled, settle, with_sample};

/// The text of a library of `count` tools, with holders as libraries of makers have them.
fn library_of(count: usize) -> String {
    let mut text = String::new();
    for number in 1..=count {
        let diameter = 6.0 + 0.01 * (number % 2000) as f64;
        write!(
            text,
            "[[tool]]\nnumber = {number}\nname = \"tool {number} of the maker\"\ndiameter = {diameter}\n\
             insert_width = 2.0\noverhang = 90.0\nplunge_feed = 300.0\nspindle = 1200.0\n\
             holder = [[30.0, 42.0, 25.0], [50.0, 50.0, 35.0]]\n\n"
        )
        .expect("a string takes text");
    }
    text
}

/// A window in which the library of `count` tools is open.
fn with_library(folder: &std::path::Path, count: usize) -> Window {
    let path = folder.join(format!("shop{count}.toml"));
    std::fs::write(&path, library_of(count)).expect("writes");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::OpenLibrary, path);
    settle(&mut window);
    window.run_steps(4);
    window.get_by_label(&format!("{count} of {count} tools"));
    window
}

#[test]
fn a_library_of_many_tools_is_edited_and_taken_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = with_library(folder.path(), 20_000);
    window.get_by_label("T1 Ø6.01 L90 tool 1 of the maker").click();
    window.run_steps(3);
    click_enabled(&window, "Copy");
    window.run_steps(2);
    window.get_by_label("20001 of 20001 tools");
    // The recovery copy is written in the background.
    window.state_mut().set_home(folder.path().join("home"));
    window.step();
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(3);
    settle(&mut window);
    window.get_by_label("20000 of 20000 tools");
}

#[test]
fn a_tool_that_the_search_hides_is_neither_shown_nor_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = with_library(folder.path(), 12);
    window.get_by_label("T3 Ø6.03 L90 tool 3 of the maker").click();
    window.run_steps(3);
    window.get_by_label("Tool T3: tool 3 of the maker");
    window.get_by_label("Take into setup");
    window.get_by_role_and_label(egui::accesskit::Role::TextInput, "Search").focus();
    window.run_steps(2);
    window.event(egui::Event::Text("of the maker t3 ".to_owned()));
    window.run_steps(3);
    window.get_by_label("1 of 12 tools");
    window.get_by_label("Tool T3: tool 3 of the maker");
    window.event(egui::Event::Text("nothing".to_owned()));
    window.run_steps(3);
    window.get_by_label("0 of 12 tools");
    assert!(window.query_by_label_contains("Tool T3").is_none(), "it is not among those shown");
    assert!(window.query_by_label("Take into setup").is_none());
}
