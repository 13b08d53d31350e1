//! Tools that the program chooses.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::app::model::panels::DockPanel;
use vanecut::app::model::state::Tone;
use vanecut::io::shop_tools::{LibraryFormat, read_library};
use vanecut::job::PlanOutcome;
use vanecut::setup::FlankStrategy;

use crate::dialogs::press_enter;
use crate::fake;
use crate::harness::{Window, click_enabled, labels, press, settle, type_into, with_sample};

fn set_step(window: &mut Window, step: f64) {
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(step);
    window.run_steps(3);
    settle(window);
}

#[test]
fn a_tool_without_plunges_says_why() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    window.get_by_label("T2 Ø16: no plunges, nothing left that is thick enough for another cutter");
    let count = window.state().state().position_count();
    window.get_by_label(&format!("T1 Ø30: {count} plunges"));
}

/// Its line and its row of the table say so under the pointer.
#[test]
fn why_a_section_has_its_tool_is_said_in_the_table_too() {
    let (engine, _) = fake::engine();
    let why = "the largest that passes the eye";
    let reasons = move |outcome: &mut PlanOutcome| outcome.reasons = vec![Some(why.to_owned()), None];
    let mut window = with_sample(fake::with_changed_plans(engine, reasons));
    window.set_size(egui::vec2(1100.0, 2600.0));
    window.run_steps(3);
    let count = window.state().state().position_count();
    for label in ["T1 Ø30".to_owned(), format!("T1 Ø30: {count} plunges")] {
        let at = window.get_by_label(&label).rect().center();
        window.hover_at(at);
        window.run_steps(20);
        window.get_by_label(why);
        window.hover_at(egui::pos2(5.0, 5.0));
        window.run_steps(8);
        assert!(window.query_by_label(why).is_none());
    }
}

/// Also one that no section names.
#[test]
fn a_tool_without_a_section_says_so() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    window.get_by_label("Edit tools and sections").click_accesskit();
    window.run_steps(3);
    window.get_by_label("Add tool").click_accesskit();
    window.run_steps(3);
    settle(&mut window);
    let added = window.state().state().document.edited.setup.tools.last().expect("tools").clone();
    window.get_by_label(&format!(
        "T{} Ø{}: no plunges, not named in any section",
        added.number, added.diameter
    ));
}

#[test]
fn the_plunges_of_the_tools_are_those_of_the_strategy_that_is_shown() {
    let (engine, _) = fake::engine();
    let plan = move |outcome: &mut PlanOutcome| {
        outcome.before.plan.positions.truncate(20);
    };
    let mut window = with_sample(fake::with_changed_plans(engine, plan));
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    let after = window.state().state().position_count();
    window.key_press(egui::Key::B);
    window.run_steps(3);
    let before = window.state().state().position_count();
    assert_ne!(before, after);
    window.get_by_label(&format!("T1 Ø30: {before} plunges"));
}

#[test]
fn automatic_calculation_has_a_tick_in_the_menu() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Plan").click();
    window.run_steps(2);
    assert!(window.state().state().auto_update);
    // The other one is below the button of the calculation.
    let switches = || window.get_all_by_role_and_label(Role::CheckBox, "Auto-update");
    assert_eq!(switches().count(), 2, "one is in the menu");
    let in_menu = switches().min_by(|a, b| a.rect().top().total_cmp(&b.rect().top()));
    in_menu.expect("two of them").click();
    window.run_steps(3);
    assert!(!window.state().state().auto_update);
    assert_eq!(window.query_all_by_role_and_label(Role::CheckBox, "Auto-update").count(), 1, "it closes");
}

#[test]
fn tools_that_are_chosen_anew_are_named_and_the_colour_scale_stays() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    let scale = window.state().state().range();
    set_step(&mut window, 6.0);
    assert!(window.query_by_label_contains("chosen anew:").is_none(), "the same tools");
    set_step(&mut window, 30.0);
    let said = window.query_all_by_label_contains("Tools chosen anew: Ø20");
    assert!(said.count() > 0, "in the panel, too");
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert!(
        notice.tone == Tone::Done && notice.text.contains("in place of Ø30 (1.00 to 0.50)"),
        "{notice:?}"
    );
    let state = window.state().state();
    assert_eq!(state.range(), scale, "one colour means one height in both plans");
    assert_ne!(state.fitting_range(), scale, "although another would fit");
    let fitting = state.fitting_range();
    window.get_by_label("Fit scale").click();
    window.run_steps(3);
    assert_eq!(window.state().state().range(), fitting, "until it is asked for");
    assert!(window.query_by_label("Fit scale").is_none());
    set_step(&mut window, 29.0);
    assert!(window.query_by_label_contains("chosen anew:").is_none(), "nothing changed this time");
}

/// A library with a holder, as Fusion writes it.
const FUSION: &str = r#"{"data": [
    {"type": "flat end mill", "unit": "millimeters", "description": "roughing cutter",
     "geometry": {"DC": 16, "LB": 90, "LCF": 20, "NOF": 4, "RE": 0, "SFDM": 16, "shoulder-length": 30},
     "post-process": {"number": 12},
     "holder": {"unit": "millimeters", "gaugeLength": 60, "segments": [
        {"height": 25, "lower-diameter": 30, "upper-diameter": 42},
        {"height": 35, "lower-diameter": 50, "upper-diameter": 50}]}},
    {"type": "ball end mill", "unit": "millimeters", "description": "ball",
     "geometry": {"DC": 6, "LB": 50, "LCF": 12, "NOF": 2, "RE": 3, "SFDM": 6},
     "post-process": {"number": 13}}
], "version": 36}"#;

/// Clicks the label and waits.
fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    window.run_steps(3);
    settle(window);
}

fn name_file(window: &mut Window, name: &std::path::Path) {
    window.get_by_role_and_label(Role::TextInput, "File").focus();
    window.run_steps(1);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text(name.display().to_string()));
    window.run_steps(2);
    settle(window);
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
    settle(window);
}

/// A window with a sample, the shop library open and file dialogs of its own.
fn with_shop_library() -> Window {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1700.0));
    window.state_mut().use_own_file_dialogs();
    window.run_steps(3);
    click(&mut window, "Shop library…");
    window.set_size(egui::vec2(1100.0, 800.0));
    window.run_steps(3);
    window
}

#[test]
fn a_library_is_opened_searched_taken_into_the_setup_and_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let [shop, saved] = ["shop.json", "saved.toml"].map(|name| folder.path().join(name));
    std::fs::write(&shop, FUSION).expect("writes");
    let mut window = with_shop_library();
    window.get_by_label("The program's own tools");
    click(&mut window, "Open library…");
    name_file(&mut window, &shop);
    window.get_by_label("2 of 2 tools");
    // Search leaves the cutter with the holder.
    window.get_by_role_and_label(Role::TextInput, "Search").focus();
    window.run_steps(1);
    window.event(egui::Event::Text("roughing".to_owned()));
    window.run_steps(3);
    window.get_by_label("1 of 2 tools");
    click(&mut window, "T12 Ø16 L90 roughing cutter");
    window.get_by_label("Drawing of T12");
    let field = |window: &Window| window.get_by_role_and_label(Role::SpinButton, "Diameter").rect();
    let before = field(&window);
    click(&mut window, "Take into setup");
    click(&mut window, "Use only this tool");
    assert_eq!(field(&window), before, "what is under the pointer stays there");
    let tools = window.state().state().document.edited.setup.tools.clone();
    assert_eq!(tools.len(), 1);
    assert_eq!(tools[0].assembly.holder, [[30.0, 42.0, 25.0], [50.0, 50.0, 35.0]]);
    window.get_by_label("In the setup as T12, its only tool");
    // Once more, it is there already.
    click(&mut window, "Take into setup");
    window.get_by_label("In the setup as T12, its only tool");
    // It is saved as our own.
    click(&mut window, "Save library…");
    name_file(&mut window, &saved);
    let library = read_library(&saved, LibraryFormat::Toml).expect("reads");
    assert_eq!(library.tools.len(), 2);
    assert_eq!(library.tools[0].tool.assembly.holder.len(), 2, "with its holder");
    // A file that is not a tool library is never overwritten, even after `Replace`.
    let setup = std::fs::read_to_string(&saved).expect("reads") + "[plunge]\nstep = 2.0\n";
    for (name, text) in [("setup.toml", &*setup), ("plan.json", "{\"vanecut_plan\": 2, \"part\": \"wheel\"}")]
    {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writes");
        let ctx = window.ctx.clone();
        window.state_mut().file_chosen(&ctx, Purpose::SaveLibrary, path.clone());
        window.run_steps(3);
        settle(&mut window);
        let problems = &window.state().state().problems;
        assert!(problems.iter().any(|problem| problem.message.contains(name)), "{problems:?}");
        assert_eq!(std::fs::read_to_string(&path).expect("reads"), text, "{name}");
    }
}

#[test]
fn the_shank_and_holder_of_a_tool_are_edited_beside_its_drawing() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1900.0));
    window.run_steps(3);
    click(&mut window, "Edit tools and sections");
    let headers: Vec<egui::Rect> =
        window.get_all_by_label_contains("T1  Ø30").map(|node| node.rect()).collect();
    press(&mut window, headers[0].center());
    window.run_steps(10);
    window.get_by_label("Drawing of T1");
    click(&mut window, "Add shank");
    click(&mut window, "Add holder");
    let tool = window.state().state().document.edited.setup.tools[0].clone();
    assert_eq!((tool.assembly.shank.len(), tool.assembly.holder.len()), (1, 1));
    assert_eq!(tool.assembly.shank[0][0], tool.diameter, "no thinner than the cutter until it is entered");
    window.get_by_role_and_label(Role::SpinButton, "Teeth").set_value_accesskit(3.0);
    window.run_steps(3);
    settle(&mut window);
    let teeth = |window: &Window| window.state().state().document.edited.setup.tools[0].assembly.teeth;
    assert_eq!(teeth(&window), Some(3));
    type_into(&mut window, ("Teeth", 0), "5.9");
    assert_eq!(teeth(&window), Some(3), "not a whole number");
    window.get_by_label_contains("“5.9” is not a whole number");
    // What the form leaves can be saved and opened.
    let setup = &window.state().state().document.edited.setup;
    let text = vanecut::io::write_setup(setup);
    assert_eq!(&vanecut::io::read_setup_bytes("s.toml", text.as_bytes()).expect("opens"), setup);
    // A shank that would reach into the holder is remarked on, and a shorter one not.
    let (overhang, shank) = (setup.tools[0].overhang, setup.tools[0].assembly.shank[0][1]);
    let remark = |window: &Window| labels(window, "flutes of ");
    assert!(remark(&window).is_empty(), "{:?}", remark(&window));
    let set_flutes = |window: &mut Window, length: f64| {
        let field = window.get_all_by_role_and_label(Role::SpinButton, "Flute length").next();
        field.expect("of the tool").set_value_accesskit(length);
        window.run_steps(3);
        settle(window);
    };
    set_flutes(&mut window, overhang - shank + 3.0);
    let said = remark(&window);
    assert!(said.len() == 1 && said[0].contains("longer than the stick-out of "), "{said:?}");
    set_flutes(&mut window, overhang - shank);
    assert!(remark(&window).is_empty(), "{:?}", remark(&window));
}

#[test]
fn a_library_of_thousands_is_searched_and_drawn_where_it_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    let shop = folder.path().join("maker.json");
    let tool = |k: usize| {
        format!(
            r#"{{"type": "flat end mill", "unit": "millimeters", "description": "no. {k}",
                "geometry": {{"DC": {}, "LB": 60, "LCF": 20, "RE": 0}}, "post-process": {{"number": {}}}}}"#,
            4 + k % 20,
            k + 1
        )
    };
    let tools: Vec<String> = (0..5_000).map(tool).collect();
    std::fs::write(&shop, format!(r#"{{"data": [{}]}}"#, tools.join(","))).expect("writes");
    let mut window = with_shop_library();
    click(&mut window, "Open library…");
    name_file(&mut window, &shop);
    window.get_by_label("5000 of 5000 tools");
    // Only the rows that show are drawn.
    let drawn = window.query_all_by_label_contains(" no. ").count();
    assert!((5..200).contains(&drawn), "{drawn} rows");
    window.get_by_role_and_label(Role::TextInput, "Search").focus();
    window.run_steps(1);
    window.event(egui::Event::Text("no. 4321".to_owned()));
    window.run_steps(3);
    window.get_by_label("2 of 5000 tools");
    click(&mut window, "T4322 Ø5 L60 no. 4321");
    click(&mut window, "Take into setup");
    click(&mut window, "Use only this tool");
    assert_eq!(window.state().state().document.edited.setup.tools[0].number, 4322);
}

/// Numbers of the tools of the setup.
fn numbers(window: &Window) -> Vec<u32> {
    window.state().state().document.edited.setup.tools.iter().map(|tool| tool.number).collect()
}

/// Taking one would otherwise mean, without a word, that no other tool is left.
#[test]
fn a_tool_joins_the_automatic_ones_or_replaces_them_as_asked() {
    let mut window = with_shop_library();
    let chosen: Vec<u32> = window.state().state().results.chosen_tools().iter().map(|t| t.number).collect();
    assert!(!chosen.is_empty() && numbers(&window).is_empty(), "the tools are automatic");
    select_tool_64(&mut window);
    let place = window.get_by_label("Copy").rect();
    click(&mut window, "Take into setup");
    assert!(numbers(&window).is_empty(), "it asks first");
    let entry = if chosen.len() == 1 { "Add to the chosen tool" } else { "Add to the chosen tools" };
    click(&mut window, entry);
    assert_eq!(numbers(&window), [&chosen[..], &[64]].concat());
    assert!(
        window.state().state().document.edited.setup.plunge.sections.is_empty(),
        "sections stay automatic"
    );
    assert_eq!(window.get_by_label("Copy").rect(), place, "nothing moves");
    window.get_by_label("In the setup as T64");
    key(&mut window, egui::Modifiers::COMMAND, egui::Key::Z);
    assert!(numbers(&window).is_empty(), "undo makes the tools automatic again");
    click(&mut window, "Take into setup");
    click(&mut window, "Use only this tool");
    assert_eq!(numbers(&window), [64]);
    window.get_by_label("In the setup as T64, its only tool");
    key(&mut window, egui::Modifiers::COMMAND, egui::Key::Z);
    assert!(numbers(&window).is_empty());
}

/// The selected tool of the library.
fn selected_tool(window: &Window) -> Option<String> {
    labels(window, "Tool T").into_iter().next()
}

#[test]
fn arrow_keys_move_the_choice_in_lists() {
    let mut window = with_shop_library();
    let first = window.query_all_by_label_contains(" L").find_map(|node| {
        let label = node.accesskit_node().label()?;
        label.starts_with('T').then_some(label)
    });
    click(&mut window, &first.expect("a tool"));
    let before = selected_tool(&window).expect("selected");
    // Further than the list shows.
    for _ in 0..60 {
        window.key_press(egui::Key::ArrowDown);
        window.run_steps(3);
    }
    let after = selected_tool(&window).expect("selected");
    assert_ne!(before, after);
    let focused = window.query_all_by(|node| node.is_focused()).next().expect("has the focus");
    let row = focused.accesskit_node().label().expect("a label");
    let number = after.trim_start_matches("Tool ").split(':').next().expect("a number").to_owned();
    assert!(row.starts_with(&format!("{number} ")), "{row} is not {after}");
    window.key_press(egui::Key::ArrowUp);
    window.run_steps(3);
    assert_ne!(selected_tool(&window).expect("selected"), after);

    // Operations, and a list that is closed.
    let operation = |window: &Window| window.state().state().look.operation;
    window.get_by_label_contains("Roughing: ").focus();
    window.run_steps(2);
    window.key_press(egui::Key::ArrowDown);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(operation(&window), Operation::Flank);
    window.key_press(egui::Key::ArrowUp);
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(operation(&window), Operation::Roughing);
    window.key_press(egui::Key::ArrowDown);
    window.run_steps(3);
    settle(&mut window);
    let strategy = |window: &Window| window.state().state().document.edited.setup.flank.strategy;
    assert_eq!(strategy(&window), FlankStrategy::Balanced);
    window.get_by_role_and_label(Role::ComboBox, "Strategy").focus();
    window.run_steps(2);
    window.key_press(egui::Key::ArrowUp);
    window.run_steps(3);
    assert_eq!(strategy(&window), FlankStrategy::Regions);
}

/// The name of the library with its mark.
const UNSAVED: &str = "The program's own tools • not saved";

fn key(window: &mut Window, modifiers: egui::Modifiers, key: egui::Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(3);
    settle(window);
}

/// Searches one of the program's own tools, and selects it.
fn select_tool_64(window: &mut Window) {
    window.get_by_role_and_label(Role::TextInput, "Search").focus();
    window.run_steps(1);
    window.event(egui::Event::Text("T64".to_owned()));
    window.run_steps(3);
    window.get_by_label_contains("T64 Ø").click();
    window.run_steps(3);
}

fn delete_tool_64(window: &mut Window) {
    select_tool_64(window);
    window.get_by_label("Delete").click();
    window.run_steps(3);
}

#[test]
fn edits_of_the_library_are_undone_and_asked_about_before_they_are_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let saved = folder.path().join("shop.toml");
    let mut window = with_shop_library();
    window.get_by_label("The program's own tools");
    delete_tool_64(&mut window);
    assert!(window.query_by_label_contains("T64 Ø").is_none());
    window.get_by_label(UNSAVED);
    key(&mut window, egui::Modifiers::COMMAND, egui::Key::Z);
    window.get_by_label("The program's own tools");
    window.get_by_label_contains("T64 Ø");
    key(&mut window, egui::Modifiers::COMMAND, egui::Key::Y);
    window.get_by_label(UNSAVED);
    // What the project had edited before stays.
    assert!(!window.state().state().document.is_unsaved());

    key(&mut window, egui::Modifiers::COMMAND, egui::Key::Q);
    window.get_by_label("Save the changes of the shop library?");
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    window.get_by_label(UNSAVED);
    key(&mut window, egui::Modifiers::COMMAND, egui::Key::Q);
    window.get_by_role_and_label(Role::Button, "Save").click();
    window.run_steps(3);
    settle(&mut window);
    name_file(&mut window, &saved);
    let tools = read_library(&saved, LibraryFormat::Toml).expect("reads").tools;
    assert!(tools.len() > 80 && tools.iter().all(|entry| entry.tool.number != 64), "without the deleted one");
    assert!(window.query_by_label("Save the changes of the shop library?").is_none(), "it goes on to quit");
    window.get_by_label("shop.toml");
}

/// Whether the library has a tool of this number.
fn has_tool(window: &mut Window, number: u32) -> bool {
    window.get_by_role_and_label(Role::TextInput, "Search").focus();
    window.run_steps(1);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text(format!("T{number}")));
    window.run_steps(3);
    window.query_by_label_contains(&format!("T{number} Ø")).is_some()
}

#[test]
fn undo_takes_back_edits_of_library_and_project_in_their_order_and_none_that_is_not_seen() {
    let mut window = with_shop_library();
    let delete = |window: &mut Window, number: u32| {
        assert!(has_tool(window, number));
        window.get_by_label_contains(&format!("T{number} Ø")).click();
        window.run_steps(3);
        click(window, "Delete");
        window.run_steps(8);
    };
    delete(&mut window, 64);
    window.state_mut().look_mut().selected = None;
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(5.0);
    window.run_steps(8);
    settle(&mut window);
    delete(&mut window, 56);
    let now = |window: &mut Window| {
        let step = window.state().state().document.edited.setup.plunge.step;
        (has_tool(window, 64), step, has_tool(window, 56))
    };
    let states =
        [(true, None, true), (false, None, true), (false, Some(5.0), true), (false, Some(5.0), false)];
    assert_eq!(now(&mut window), states[3]);
    for state in states[..3].iter().rev() {
        key(&mut window, egui::Modifiers::COMMAND, egui::Key::Z);
        assert_eq!(now(&mut window), *state, "undo");
    }
    for state in &states[1..] {
        key(&mut window, egui::Modifiers::COMMAND, egui::Key::Y);
        assert_eq!(now(&mut window), *state, "redo");
    }
    // What was deleted last stays where it is not seen.
    window.state_mut().look_mut().panels.close(DockPanel::ToolLibrary);
    window.run_steps(3);
    for _ in 0..3 {
        key(&mut window, egui::Modifiers::COMMAND, egui::Key::Z);
    }
    window.state_mut().look_mut().panels.open(DockPanel::ToolLibrary);
    window.run_steps(4);
    assert_eq!(now(&mut window), (false, None, false));
}

#[test]
fn edits_of_the_library_survive_a_crash() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let (engine, _) = fake::engine();
    let opened = || {
        let mut window = with_sample(engine.clone());
        window.state_mut().set_home(home.clone());
        window.set_size(egui::vec2(1100.0, 1700.0));
        window.run_steps(3);
        click(&mut window, "Shop library…");
        window.set_size(egui::vec2(1100.0, 800.0));
        window.run_steps(3);
        window
    };
    let mut first = opened();
    delete_tool_64(&mut first);
    // The harness clock advances by a quarter of a second per frame.
    first.run_steps(10);
    settle(&mut first);
    // Nothing of the first window gets to run any more.
    drop(first);
    let mut second = opened();
    second.get_by_label(UNSAVED);
    second.get_by_role_and_label(Role::TextInput, "Search").focus();
    second.run_steps(1);
    second.event(egui::Event::Text("T6".to_owned()));
    second.run_steps(3);
    assert!(second.query_by_label_contains("T64 Ø").is_none(), "what was edited is there");
    second.get_by_label_contains("T63 Ø");
    second.run_steps(10);
    settle(&mut second);
    second.run_steps(4);
    drop(second);
    let copies = std::fs::read_dir(home.join("recovery")).expect("a folder").count();
    assert_eq!(copies, 1, "the second session has taken it over");
}

/// Fusion keeps more of a tool than Vanecut knows.
#[test]
fn what_a_library_of_fusion_would_lose_is_asked_about_before_it_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let shop = folder.path().join("shop.json");
    std::fs::write(&shop, FUSION).expect("writes");
    let mut window = with_shop_library();
    click(&mut window, "Open library…");
    name_file(&mut window, &shop);
    click(&mut window, "T13 Ø6 R3 L50 ball");
    click(&mut window, "Copy");
    let write = |window: &mut Window| {
        click(window, "Save library…");
        name_file(window, &shop);
        press_enter(window);
        assert!(window.query_by_label("Replace").is_none(), "nothing in it is replaced");
    };
    // A plan that is out of date is none of the library's.
    window.get_by_label("Auto-update").click_accesskit();
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.5);
    window.run_steps(3);
    write(&mut window);
    window.get_by_label("Write into the Fusion library?");
    assert!(window.query_by_label("Recalculate").is_none(), "nothing to calculate for a library");
    window.get_by_label_contains("Tools that are new in it have no vendor, product and coolant");
    window.get_by_label_contains("stay in the file");
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(std::fs::read_to_string(&shop).expect("reads"), FUSION, "as it was");
    write(&mut window);
    click(&mut window, "Write into it");
    let text = std::fs::read_to_string(&shop).expect("reads");
    assert!(text.starts_with(FUSION.split("\n]").next().unwrap()), "its entries stay as they are: {text}");
    assert_eq!(read_library(&shop, LibraryFormat::FusionJson).expect("reads").tools.len(), 3);
    // The library is new: it leaves no file as it was.
    click(&mut window, "Save library…");
    name_file(&mut window, &folder.path().join("new.json"));
    press_enter(&mut window);
    window.get_by_label("Write a Fusion library?");
    window.get_by_label("A .toml library keeps all that is shown here.");
}
