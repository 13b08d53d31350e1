//! What fields do with numbers that they do not take: they keep their value, and say why.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::io::setup_file::read_setup;
use vanecut::io::tool_library::plunge_cutters;
use vanecut::setup::cutting_data::cutting_speed_at;
use vanecut::setup::{MissingRates, Setup, Tool};

use crate::fake;
use crate::harness::{Window, choose_in_file_menu, click_enabled, press, settle, type_into, with_sample};

/// A window with the form of the first tool of the setup.
fn with_tool_form() -> Window {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 2600.0));
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Edit tools and sections").click();
    window.run_steps(3);
    settle(&mut window);
    open_tool_form(&mut window, "T1  Ø30");
    window
}

/// Opens the form of the tool of the setup with this heading.
fn open_tool_form(window: &mut Window, heading: &str) {
    let header = window.get_all_by_label_contains(heading).next().expect("a header").rect();
    press(window, header.center());
    window.run_steps(10);
}

/// Chooses the material of the blank.
fn choose_material(window: &mut Window, material: &str) {
    window.get_by_role_and_label(Role::ComboBox, "Material").click();
    window.run_steps(2);
    window.get_by_label(material).click();
    window.run_steps(3);
    settle(window);
}

fn tool(window: &Window) -> Tool {
    window.state().state().document.edited.setup.tools[0].clone()
}

/// Whether some text begins with `text`.
fn says(window: &Window, text: &str) -> bool {
    window.query_all_by(|node| node.value().is_some_and(|value| value.starts_with(text))).next().is_some()
}

/// A slow frame brings several keys at once.
#[test]
fn what_is_typed_behind_the_tab_key_goes_to_the_next_field_alone() {
    let mut window = with_tool_form();
    let field = window.get_by_role_and_label(Role::SpinButton, "Corner radius").rect().center();
    press(&mut window, field);
    window.run_steps(3);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.run_steps(2);
    let key = |key| egui::Event::Key {
        key,
        pressed: true,
        modifiers: egui::Modifiers::NONE,
        repeat: false,
        physical_key: None,
    };
    let text = |text: &str| egui::Event::Text(text.to_owned());
    let keys = [text("1"), key(egui::Key::Tab), text("150"), key(egui::Key::Enter)];
    window.input_mut().events.extend(keys);
    window.run_steps(8);
    settle(&mut window);
    let tool = tool(&window);
    assert_eq!((tool.corner_radius, tool.overhang), (1.0, 150.0));
}

/// Drags the field of this name by some points to the right.
fn drag(window: &mut Window, field: &str, points: f32) {
    let at = window.get_by_role_and_label(Role::SpinButton, field).rect().center();
    window.hover_at(at);
    window.run_steps(2);
    window.drag_at(at);
    window.run_steps(2);
    window.hover_at(at + egui::vec2(points, 0.0));
    window.run_steps(2);
    window.drop_at(at + egui::vec2(points, 0.0));
    window.run_steps(4);
    settle(window);
}

#[test]
fn dragging_an_automatic_value_begins_where_it_stands() {
    let mut window = with_tool_form();
    for field in ["Feed rate", "Spindle speed"] {
        type_into(&mut window, (field, 0), "auto");
    }
    let derived = tool(&window);
    assert_eq!(derived.assembly.missing_rates, MissingRates::ALL);
    for field in ["Feed rate", "Spindle speed"] {
        drag(&mut window, field, 10.0);
    }
    let dragged = tool(&window);
    assert_eq!(dragged.assembly.missing_rates, MissingRates::default(), "they are given");
    // By 1 a point, to round numbers.
    for (was, is) in [(derived.plunge_feed, dragged.plunge_feed), (derived.spindle, dragged.spindle)] {
        assert!((was + 5.0..=was + 15.0).contains(&is), "from {was} to {is}");
    }
    // Down to the end and beyond it is automatic again.
    drag(&mut window, "Feed rate", -2000.0);
    assert!(tool(&window).assembly.missing_rates.plunge_feed);
}

#[test]
fn a_rate_that_is_given_as_it_is_derived_leaves_the_plan_current() {
    let mut window = with_tool_form();
    for field in ["Feed rate", "Spindle speed"] {
        type_into(&mut window, (field, 0), "auto");
    }
    window.get_by_label("Auto-update").click_accesskit();
    window.run_steps(3);
    let derived = tool(&window);
    assert!(!window.state().state().out_of_date());
    for (field, value) in [("Feed rate", derived.plunge_feed), ("Spindle speed", derived.spindle)] {
        type_into(&mut window, (field, 0), &value.to_string());
    }
    assert_eq!(tool(&window), derived.with_given_rates());
    assert!(!window.state().state().out_of_date(), "nothing that the plan depends on is another");
    window.get_by_label_contains("T1 Ø30: ");
    type_into(&mut window, ("Feed rate", 0), &(derived.plunge_feed + 1.0).to_string());
    assert!(window.state().state().out_of_date());
    type_into(&mut window, ("Feed rate", 0), "auto");
    assert!(!window.state().state().out_of_date(), "as before");
}

#[test]
fn an_impossible_size_of_a_tool_is_refused_at_its_field_with_the_cure() {
    let mut window = with_tool_form();
    assert_eq!((tool(&window).diameter, tool(&window).insert_width), (30.0, 10.0));
    type_into(&mut window, ("Insert width", 0), "20");
    assert_eq!(tool(&window).insert_width, 10.0, "it keeps its value");
    let refusal = "20 is too much: at most 15 mm, the radius. For more, make the diameter larger first";
    assert!(says(&window, refusal));
    type_into(&mut window, ("Insert width", 0), "12");
    assert_eq!(tool(&window).insert_width, 12.0);
    assert!(!says(&window, "20 is too much"), "what was refused is over");
    type_into(&mut window, ("Insert width", 0), "8 ft");
    assert_eq!(tool(&window).insert_width, 12.0);
    assert!(says(&window, "“8 ft” is not a length"));
    type_into(&mut window, ("Corner radius", 0), "16");
    assert_eq!(tool(&window).corner_radius, 0.0);
    assert!(says(&window, "16 is too much: at most 15 mm, the radius"));
    type_into(&mut window, ("Flute length", 0), "130");
    assert_eq!(tool(&window).assembly.flute_length, None);
    assert!(says(&window, "130 is too much: at most 120 mm, the stick-out"));
    // What changes with another field is said.
    type_into(&mut window, ("Diameter", 0), "20");
    assert_eq!((tool(&window).diameter, tool(&window).insert_width), (20.0, 10.0));
    assert!(says(&window, "12 made 10 with the diameter"));
    assert!(!says(&window, "“8 ft”"));
    // An edit that is undone says nothing any more.
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(4);
    settle(&mut window);
    assert_eq!(tool(&window).insert_width, 12.0);
    assert!(!says(&window, "12 made 10"));
}

#[test]
fn a_shank_that_is_too_long_is_refused_and_flutes_stay_automatic() {
    let mut window = with_tool_form();
    for _ in 0..2 {
        window.get_by_role_and_label(Role::Button, "Add shank").click();
        window.run_steps(3);
    }
    settle(&mut window);
    let shank = |window: &Window| tool(window).assembly.shank.iter().map(|row| row[1]).collect::<Vec<_>>();
    assert_eq!(
        (tool(&window).overhang, shank(&window)),
        (120.0, vec![60.0, 30.0]),
        "each has half of the rest"
    );
    assert_eq!(tool(&window).assembly.flute_length, None);
    // Of the two fields of a piece the second one is its length.
    type_into(&mut window, ("Shank 2", 1), "80");
    let refusal = "length: 80 is too much: at most 59.9 mm, as the flutes need some of the stick-out";
    assert!(says(&window, refusal));
    type_into(&mut window, ("Stick-out", 0), "12");
    assert!(says(&window, "12 is too little: at least 90.1 mm"));
    assert_eq!((tool(&window).overhang, shank(&window)), (120.0, vec![60.0, 30.0]), "as before");
    assert_eq!(tool(&window).assembly.flute_length, None, "it follows the shank");
    // With a length of their own the shank may be longer: that is remarked on.
    type_into(&mut window, ("Flute length", 0), "20");
    type_into(&mut window, ("Shank 2", 1), "80");
    assert_eq!(shank(&window), [60.0, 80.0]);
    assert!(says(&window, "flutes of 20 mm and shank of 140 mm are longer than the stick-out of 120 mm"));
}

#[test]
fn a_refusal_is_over_with_another_operation_and_with_an_undone_step() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    let refusal = "“3 ft” is not a length";
    type_into(&mut window, ("Hub allowance", 0), "3 ft");
    assert!(says(&window, refusal));
    for operation in ["Flank", "Roughing"] {
        window.query_all_by_label_contains(operation).next().expect("a line").click();
        window.run_steps(3);
        settle(&mut window);
    }
    assert!(!says(&window, refusal), "another operation was looked at");
    type_into(&mut window, ("Blade allowance", 0), "0.7");
    type_into(&mut window, ("Hub allowance", 0), "3 ft");
    assert!(says(&window, refusal));
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    window.run_steps(4);
    settle(&mut window);
    assert_eq!(window.state().state().document.edited.setup.allowances.blade_allowance, 0.5);
    assert!(!says(&window, refusal), "a step was undone");
}

#[test]
fn the_number_of_a_tool_changes_with_its_sections_and_none_is_given_twice() {
    let mut window = with_tool_form();
    window.get_by_role_and_label(Role::Button, "Add tool").click();
    window.run_steps(3);
    let numbers = |window: &Window| {
        let setup = &window.state().state().document.edited.setup;
        let sections = setup.plunge.sections.iter().map(|section| section.tool);
        setup.tools.iter().map(|tool| tool.number).chain(sections).collect::<Vec<_>>()
    };
    let before = numbers(&window);
    type_into(&mut window, ("Number", 0), "2");
    assert_eq!(numbers(&window), before);
    assert!(says(&window, "T2 is another tool of the setup"));
    type_into(&mut window, ("Number", 0), "17");
    let after: Vec<u32> = before.into_iter().map(|number| if number == 1 { 17 } else { number }).collect();
    assert_eq!(numbers(&window), after);
    assert!(after.iter().filter(|&&number| number == 17).count() > 1, "its sections too: {after:?}");
    assert!(!says(&window, "T2 is another"));
}

#[test]
fn speeds_that_nobody_entered_follow_the_material_and_others_are_named() {
    let mut window = with_tool_form();
    choose_material(&mut window, "titanium");
    assert_eq!((tool(&window).spindle, tool(&window).plunge_feed), (424.0, 424.0 * 2.0 * 0.08));
    assert!(!says(&window, "Much faster"));
    type_into(&mut window, ("Spindle speed", 0), "1200");
    assert!(says(&window, "Much faster than the 40 m/min for titanium: T1 113 m/min"));
    choose_material(&mut window, "nickel");
    assert_eq!(tool(&window).spindle, 1200.0, "it was entered");
    let note = "Much faster than the 30 m/min for nickel: T1 113 m/min";
    assert!(says(&window, note));
    let ctx = window.ctx.clone();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.apt");
    window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels: 1 }, path.clone());
    window.run_steps(3);
    assert_eq!(window.query_all_by_label_contains(note).count(), 2, "it is asked about, too");
    assert!(!path.exists());
}

/// Enlarging a tool that was chosen for steel does not count as entering its speed.
#[test]
fn speeds_of_a_chosen_tool_follow_the_material_after_an_edit_of_its_diameter() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.toml");
    let own = plunge_cutters().iter().find(|tool| tool.diameter == 25.0).expect("a tool");
    let (spindle, feed) = (own.spindle, own.plunge_feed);
    let sections = "[[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.0\n";
    let text = format!("[[tool]]\ndiameter = 25\nspindle = {spindle}\nplunge_feed = {feed}\n{sections}");
    std::fs::write(&path, text).expect("writes");
    let mut window = with_sample(fake::engine().0);
    window.set_size(egui::vec2(1100.0, 2600.0));
    window.state_mut().open_path(path);
    settle(&mut window);
    open_tool_form(&mut window, "T1  Ø25");
    type_into(&mut window, ("Diameter", 0), "26");
    type_into(&mut window, ("Stick-out", 0), "110");
    let scaled = |rate: f64| (rate * 25.0 / 26.0).round();
    assert_eq!((tool(&window).spindle, tool(&window).plunge_feed), (scaled(spindle), scaled(feed)));
    choose_material(&mut window, "titanium");
    let speed = cutting_speed_at(tool(&window).spindle, 26.0);
    assert!((speed - 40.0).abs() < 1.0, "{speed} m/min");
    assert!(!says(&window, "Much faster"));
}

/// A rate that follows from others says so, and is not written as if it were given.
#[test]
fn rates_that_are_not_given_are_shown_as_such_and_stay_out_of_the_saved_setup() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, saved) = (folder.path().join("s.toml"), folder.path().join("saved.toml"));
    let sections = "[[plunge.section]]\ntool = 1\nfrom = 1.0\nto = 0.0\n";
    let text = format!("[stock]\nmaterial = \"titanium\"\n[[tool]]\ndiameter = 30.0\n{sections}");
    std::fs::write(&path, text).expect("writes");
    let mut window = with_sample(fake::engine().0);
    window.set_size(egui::vec2(1100.0, 2600.0));
    window.state_mut().open_path(path);
    settle(&mut window);
    open_tool_form(&mut window, "T1  Ø30");
    let shown = |window: &Window, label: &str| {
        window.get_by_role_and_label(Role::SpinButton, label).value().expect("a text")
    };
    assert_eq!(shown(&window, "Feed rate"), "auto 68 mm/min");
    assert_eq!(shown(&window, "Spindle speed"), "auto 424 rev/min");
    let save = |window: &mut Window| {
        let ctx = window.ctx.clone();
        window.state_mut().file_chosen(&ctx, Purpose::SaveSetup, saved.clone());
        settle(window);
        std::fs::read_to_string(&saved).expect("saved")
    };
    let text = save(&mut window);
    assert!(!text.contains("plunge_feed") && !text.contains("spindle"), "{text}");
    assert_eq!(
        read_setup(&saved, &Setup::default()).expect("opens").tools,
        [tool(&window)],
        "it plans the same"
    );
    // What they follow from leads to others.
    type_into(&mut window, ("Diameter", 0), "15");
    assert_eq!(shown(&window, "Spindle speed"), "auto 849 rev/min");
    // One that is entered is given, until it is cleared.
    type_into(&mut window, ("Spindle speed", 0), "600");
    assert_eq!((shown(&window, "Spindle speed"), tool(&window).spindle), ("600 rev/min".to_owned(), 600.0));
    let text = save(&mut window);
    assert!(text.contains("spindle = 600.0") && !text.contains("plunge_feed"), "{text}");
    type_into(&mut window, ("Spindle speed", 0), "auto");
    assert_eq!(shown(&window, "Spindle speed"), "auto 849 rev/min");
    assert!(!save(&mut window).contains("spindle"));
}

#[test]
fn lengths_of_holders_and_ends_of_sections_are_refused_too() {
    let mut window = with_tool_form();
    window.get_by_role_and_label(Role::Button, "Add holder").click();
    window.run_steps(3);
    let holder = tool(&window).assembly.holder[0];
    type_into(&mut window, ("Holder 1", 2), "2 m");
    assert_eq!(tool(&window).assembly.holder[0], holder);
    assert!(says(&window, "length: 2 m is too much: at most 1000 mm"));
    let section = |window: &Window| window.state().state().document.edited.setup.plunge.sections[0].clone();
    let before = section(&window);
    type_into(&mut window, ("Section 1", 1), "1");
    assert_eq!(section(&window), before);
    assert!(says(&window, "1 is too much: at most 0.98, before the start. For more, move the start first"));
    type_into(&mut window, ("Section 1", 0), "0.4");
    assert_eq!((section(&window).from, section(&window).to), (0.4, 0.38));
    assert!(says(&window, "its end was 0.500: 0.380 with the start"));
}

#[test]
fn every_field_of_the_setup_says_what_it_does_not_take() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let step = |window: &Window| window.state().state().document.edited.setup.plunge.step;
    type_into(&mut window, ("Step", 0), "0.1");
    assert_eq!(step(&window), None);
    assert!(says(&window, "0.1 is too little: at least 0.5 mm"));
    type_into(&mut window, ("Step", 0), "0");
    assert_eq!(step(&window), None, "automatic");
    assert!(!says(&window, "0.1 is too little"));
    type_into(&mut window, ("Max tilt", 0), "100 mm");
    assert!(says(&window, "“100 mm” is not an angle"));
    // The field shows what it holds.
    let shown = window.get_by_role_and_label(Role::SpinButton, "Max tilt").accesskit_node().value();
    assert_eq!(shown.as_deref(), Some("45°"));
}

#[test]
fn numbers_of_channels_diameters_and_ends_of_the_scale_are_refused_with_the_cure() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1400.0, 900.0));
    window.run_steps(3);
    let range = window.state().state().range();
    type_into(&mut window, ("Scale maximum", 0), "0.01");
    assert_eq!(window.state().state().range(), range);
    let said = window.state().state().notice.clone().expect("a reason").text;
    let wanted = "Scale maximum: 0.01 is too little: at least 0.05 mm, above the lower end. For less, lower that first";
    assert_eq!(said, wanted);
    type_into(&mut window, ("Scale minimum", 0), "50");
    assert_eq!(window.state().state().range(), range);
    let said = window.state().state().notice.clone().expect("a reason").text;
    assert!(said.contains("below the upper end. For more, raise that first"), "{said}");

    window.key_press(egui::Key::Escape);
    for name in ["File", "Export CL of several channels…"] {
        window.get_by_label_contains(name).click();
        window.run_steps(4);
    }
    type_into(&mut window, ("Channels", 0), "18");
    assert!(says(&window, "18 is too much: at most 17, the channels of the wheel"));
    click_enabled(&window, "Cancel");
    window.run_steps(3);
}

#[test]
fn diameters_of_the_library_filter_are_refused_with_the_cure() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1700.0));
    window.run_steps(3);
    window.get_by_label("Shop library…").click();
    window.run_steps(4);
    settle(&mut window);
    let count = |window: &Window| {
        let is_it = |text: &str| text.contains(" of ") && text.ends_with(" tools");
        let mut nodes = window.query_all_by(|node| node.value().is_some_and(|value| is_it(&value)));
        nodes.next().expect("a number of tools").accesskit_node().value()
    };
    let all = count(&window);
    type_into(&mut window, ("Ø", 0), "2000");
    let reason = "2000 is too much: at most 1000, the greatest that is shown";
    assert!(says(&window, reason));
    assert_eq!(all, count(&window));
    let title = window.get_by_label("Shop library").rect().center();
    press(&mut window, title);
    window.run_steps(3);
    assert!(!says(&window, reason), "it covers nothing that is looked at next");
}

#[test]
fn a_number_of_channels_is_a_whole_one() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    choose_in_file_menu(&mut window, "Export CL of several channels…");
    let channels = |window: &Window| window.get_by_role_and_label(Role::SpinButton, "Channels").value();
    let before = channels(&window);
    for text in ["2.5", "abc"] {
        type_into(&mut window, ("Channels", 0), text);
        assert_eq!(channels(&window), before, "it keeps its value");
        assert!(says(&window, &format!("“{text}” is not a whole number: 3 or 12/2 are")), "{text}");
    }
    type_into(&mut window, ("Channels", 0), "6/2");
    assert_eq!(channels(&window).as_deref(), Some("3"));
    assert!(!says(&window, "“abc”"));
}

#[test]
fn a_refusal_moves_nothing_and_is_over_when_a_value_is_left_in_a_field() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    let below =
        |window: &Window| window.get_by_role_and_label(Role::SpinButton, "Stepover").rect().top().round();
    let (refusal, before) = ("“abc” is not a length", below(&window));
    for (field, text) in [("Step", "auto"), ("Step", "5"), ("Step", "auto"), ("Stepover", "4")] {
        type_into(&mut window, ("Step", 0), "abc");
        assert!(says(&window, refusal));
        assert_eq!(below(&window), before, "what is below it stays");
        type_into(&mut window, (field, 0), text);
        assert!(!says(&window, refusal), "{field}: {text}");
        assert_eq!(below(&window), before);
    }
}

/// A step that is longer than the tool takes changes nothing: the field says so.
#[test]
fn a_step_and_a_lead_out_that_the_tool_does_not_take_are_said_at_their_fields() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1600.0));
    window.run_steps(3);
    let count = |window: &Window| window.query_all_by_label_contains("T1 takes at most ").count();
    let set_lead_out = |window: &mut Window, mm: f64| {
        window.get_by_role_and_label(Role::SpinButton, "Lead-out").set_value_accesskit(mm);
        window.run_steps(3);
        settle(window);
    };
    assert_eq!(count(&window), 0);
    type_into(&mut window, ("Step", 0), "6");
    assert_eq!(count(&window), 0, "it is taken");
    type_into(&mut window, ("Step", 0), "90");
    window.get_by_label_contains("its insert width of ");
    // The planner of the test takes a tool D 20 for such a step.
    set_lead_out(&mut window, 19.0);
    window.get_by_label_contains("T1 takes at most 10 mm: its radius");
    type_into(&mut window, ("Step", 0), "auto");
    set_lead_out(&mut window, 3.0);
    assert_eq!(count(&window), 0);
}
