//! NC programs leave the window as `vanecut post` writes them.

use std::path::Path;

use egui::accesskit::{Role, Toggled};
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::app::model::part_source::PartSource;
use vanecut::app::tasks::engine::Engine;
use vanecut::flank::{FlankMove, MoveKind};
use vanecut::io::apt::write_apt;
use vanecut::io::flank_file::{read_flank_bytes, stored_program, write_flank};
use vanecut::io::machine_file::read_machine;
use vanecut::io::nc::read_post;
use vanecut::io::part_file::read_part;
use vanecut::job::flank::FlankOutcome;
use vanecut::job::post::{PostRequest, post_program};
use vanecut::machine::{BlankSize, ChannelCalls, OutputKind};
use vanecut::monitor::Monitor;
use vanecut::setup::ChannelSequence;
use vanecut::toolpath::ClProgram;

use crate::dialogs::{name_file, press_enter};
use crate::fake;
use crate::flank::{plan_flank, set_depth, with_plan};
use crate::harness::{
    Window, choose_in_file_menu, choose_in_list, click_enabled, labels, press, settle, snapshot_ui,
    with_sample,
};
use crate::machine::{open_narrow_machine, with_machine};

/// Opens the question where the program is to run.
pub fn ask(window: &mut Window) {
    window.state_mut().use_own_file_dialogs();
    choose_in_file_menu(window, "Export NC program…");
}

/// Saves under `path`, and confirms what speaks against the program.
pub fn save(window: &mut Window, path: &Path) {
    window.get_by_label("Save as…").click();
    window.run_steps(3);
    settle(window);
    name_file(window, path);
    press_enter(window);
    if let Some(button) = window.query_by_label("Export anyway") {
        button.click();
        window.run_steps(3);
        settle(window);
    }
}

/// The setup sheet of the selected operation, written as `sheet.html` into `folder`.
fn sheet(window: &mut Window, folder: &Path) -> String {
    choose_in_file_menu(window, "Export setup sheet…");
    settle(window);
    let path = folder.join("sheet.html");
    name_file(window, &path);
    press_enter(window);
    if let Some(button) = window.query_by_label("Export anyway") {
        button.click();
        window.run_steps(3);
        settle(window);
    }
    std::fs::read_to_string(path).expect("a page")
}

/// The program as the command line posts it.
fn posted(window: &Window, program: &ClProgram, machine: &str, control: &str, output: OutputKind) -> String {
    let state = window.state().state();
    let outcome = &state.shown().expect("planned").planned.outcome;
    let part = &outcome.workpiece.part;
    let request = PostRequest {
        machine: read_machine(Path::new(machine)).expect("a machine"),
        post: read_post(control).expect("a post"),
        output,
        inlet_up: part.out_of_inlet().z > 0.0,
        blank: Some(BlankSize::from_part(part, &outcome.setup.allowances)),
        calls: None,
    };
    post_program(program, &request, &Monitor::default()).expect("runs").written.text
}

/// Presses and releases the button at a point between two frames, as a click falls on a busy machine.
fn click_between_frames(window: &mut Window, at: egui::Pos2) {
    let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
    window.hover_at(at);
    window.run_steps(1);
    for pressed in [true, false] {
        window.input_mut().events.push(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
    }
    window.run_steps(3);
}

#[test]
fn a_list_opens_above_the_dialog_however_often_that_was_open() {
    let mut window = with_machine("bc-trunnion");
    for (round, machine) in ["bc-head", "ac-trunnion", "bc-trunnion"].into_iter().enumerate() {
        ask(&mut window);
        let list = window.get_by_role_and_label(Role::ComboBox, "NC machine").rect().center();
        click_between_frames(&mut window, list);
        let entry = window.get_by_role_and_label(Role::Button, machine).rect().center();
        press(&mut window, entry);
        window.run_steps(3);
        let shown = window.get_by_role_and_label(Role::ComboBox, "NC machine").value();
        assert_eq!(shown.as_deref(), Some(machine), "round {round}");
        click_enabled(&window, "Cancel");
        window.run_steps(3);
    }
}

#[test]
fn a_machine_that_nobody_has_chosen_is_called_an_example() {
    let mut window = with_sample(fake::engine().0);
    ask(&mut window);
    let example =
        "ac-trunnion is an example, as the setup names no machine: choose the one that runs the program";
    window.get_by_label(example);
    let places = |window: &Window| {
        let of = |role, name| window.get_by_role_and_label(role, name).rect().top();
        (of(Role::ComboBox, "NC machine"), of(Role::Button, "Save as…"))
    };
    let (machine, save_as) = places(&window);
    choose_in_list(&mut window, "NC machine", "bc-head");
    assert!(window.query_by_label_contains("is an example").is_none(), "it was chosen");
    let moved = places(&window);
    assert_eq!(moved.0, machine, "a field stays where it is");
    assert!(moved.1 < save_as, "while the text below gets shorter");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    ask(&mut window);
    assert!(window.query_by_label_contains("is an example").is_none(), "it stays chosen");
}

#[test]
fn a_plan_is_exported_for_the_machine_of_the_setup() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_machine("bc-trunnion");
    ask(&mut window);
    window.get_by_label("Export NC program");
    snapshot_ui(&mut window, "nc_program");
    choose_in_list(&mut window, "Control", "siemens");
    choose_in_list(&mut window, "Output", "Rotary angles");
    window.get_by_role_and_label(Role::SpinButton, "Channels").set_value_accesskit(2.0);
    window.run_steps(2);
    save(&mut window, &folder.path().join("wheel"));
    let path = folder.path().join("wheel.mpf");
    let text = std::fs::read_to_string(&path).expect("written, with the ending of the control");
    let state = window.state().state();
    let shown = state.shown().expect("planned");
    let outcome = &shown.planned.outcome;
    let result = shown.planned.result(shown.policy);
    let program = outcome.program_for_channels(result, 2, &Monitor::default()).expect("not cancelled");
    let wanted = posted(&window, &program, "bc-trunnion", "siemens", OutputKind::TcpAngles);
    assert_eq!(text, wanted, "what the command line writes");
    let notice = &state.notice.as_ref().expect("a message").text;
    let is_comment = |line: &&str| line.starts_with(['(', ';', '*', '%']);
    let blocks = text.lines().filter(|line| !is_comment(line)).count();
    assert!(blocks < text.lines().count(), "the program has comments");
    let counted = format!(": {blocks} blocks without comments for bc-trunnion");
    assert!(notice.contains(&counted), "{notice}");
    let page = sheet(&mut window, folder.path());
    let (_, after) = page
        .split_once(
            "<code>wheel.mpf</code> (NC code for bc-trunnion, control siemens, part turned over by half a turn \
             about its X, ",
        )
        .expect("the program is named");
    let (minutes, after) = after.split_once(" min), for all 2 channels").expect("with its time");
    assert!(minutes.parse::<f64>().expect("a number") > 0.0 && !after.is_empty(), "{minutes}");
    assert!(page.contains("NC programs take the time that stands beside their names."), "{page}");
    // A check reads it for the same machine and control.
    window.state_mut().open_path(path);
    settle(&mut window);
    let checked = window.state().state().results.checked.clone().expect("it is read");
    assert_eq!(checked.request.machine, "bc-trunnion");
    assert_eq!(checked.request.control.as_deref(), Some("siemens"));
    window.get_by_role_and_label(Role::ComboBox, "NC control");
}

#[test]
fn what_speaks_against_a_plan_is_said_before_its_nc_program() {
    let folder = tempfile::tempdir().unwrap();
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().look_mut().side = vanecut::app::model::planned::Side::Before;
    ask(&mut window);
    window.get_by_label("Save as…").click();
    window.run_steps(3);
    settle(&mut window);
    let path = folder.path().join("before.h");
    name_file(&mut window, &path);
    press_enter(&mut window);
    window.get_by_label_contains("The core meets stock in");
    assert!(!path.exists(), "not before the answer");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    settle(&mut window);
    assert!(!path.exists());
}

#[test]
fn a_program_that_the_machine_cannot_run_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_machine("ac-trunnion");
    open_narrow_machine(&mut window, folder.path());
    ask(&mut window);
    window.get_by_role_and_label(Role::ComboBox, "NC machine");
    let path = folder.path().join("p.h");
    save(&mut window, &path);
    window.get_by_label_contains("the NC program is not written: narrow.toml: move ");
    assert!(!path.exists());
    assert!(window.state().state().document.can_undo(), "the machine was chosen");
    assert!(window.query_by_label("Undo the edit").is_none(), "no edit is to blame");
}

/// Takes the words from a post file, in the open dialog.
fn take_post(window: &mut Window, file: &Path) {
    window.get_by_label("Post file…").click();
    window.run_steps(3);
    settle(window);
    window.get_by_label("Open post");
    name_file(window, file);
    press_enter(window);
    window.get_by_label("Save as…");
}

#[test]
fn a_post_of_ones_own_gives_the_words() {
    let folder = tempfile::tempdir().unwrap();
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let post = folder.path().join("shop.toml");
    let words = "extends = \"linuxcnc\"\n[blocks]\nstart = [\"(words of the shop)\"]\n";
    std::fs::write(&post, words).unwrap();
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, "extends = \"no-such-control\"\n").unwrap();
    ask(&mut window);
    take_post(&mut window, &bad);
    window.get_by_label_contains("unknown control");
    assert!(window.state().state().problems.is_empty(), "the dialog itself says what is wrong");
    take_post(&mut window, &post);
    assert!(window.query_by_label_contains("unknown control").is_none(), "this one is good");
    let path = folder.path().join("p.ngc");
    save(&mut window, &path);
    let text = std::fs::read_to_string(&path).expect("written");
    assert!(text.contains("(words of the shop)"), "{}", &text[..text.len().min(400)]);
}

#[test]
fn another_machine_keeps_the_post_file_and_the_subprogram() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_machine("ac-trunnion");
    let shop = "extends = \"fanuc\"\n[blocks]\nsub_start = [\"(of the shop)\"]\nsub_end = [\"M99\"]\n";
    let post = folder.path().join("shop.toml");
    std::fs::write(&post, shop).unwrap();
    let plain = folder.path().join("plain.toml");
    std::fs::write(&plain, "dialect = \"fanuc\"\n[on]\njoints = [\"G0 {angles}\"]\n").unwrap();
    ask(&mut window);
    take_post(&mut window, &post);
    window.get_by_label("Subprogram").click();
    window.run_steps(2);
    let control = |window: &Window| window.get_by_role_and_label(Role::ComboBox, "Control").value();
    let is_subprogram = |window: &Window| {
        window.get_by_role_and_label(Role::CheckBox, "Subprogram").accesskit_node().toggled()
    };
    choose_in_list(&mut window, "NC machine", "bc-trunnion");
    assert_eq!(control(&window).as_deref(), Some("shop.toml"));
    assert_eq!(is_subprogram(&window), Some(Toggled::True));
    // Neither is it lost between two questions.
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    crate::machine::choose(&mut window, "b-head-c-table");
    ask(&mut window);
    let machine = window.get_by_role_and_label(Role::ComboBox, "NC machine").value();
    assert_eq!(machine.as_deref(), Some("b-head-c-table"), "that of the setup");
    assert_eq!(control(&window).as_deref(), Some("shop.toml"));
    assert_eq!(is_subprogram(&window), Some(Toggled::True));
    // What a control does not take is said.
    take_post(&mut window, &plain);
    assert_eq!(is_subprogram(&window), Some(Toggled::False));
    window.get_by_label_contains("plain.toml does not say how a subprogram begins and ends");
    window.get_by_label_contains("plain.toml does not take Rotary angles: the output is All axes");
    // A post that is gone leaves the place to the control of the machine.
    std::fs::remove_file(&plain).unwrap();
    choose_in_list(&mut window, "NC machine", "bc-trunnion");
    window.get_by_label_contains("plain.toml: cannot be read");
    let own = read_machine(Path::new("bc-trunnion")).unwrap().control;
    assert_eq!(control(&window), Some(own));
}

#[test]
fn another_part_asks_for_a_main_program_again() {
    let mut window = with_machine("ac-trunnion");
    let is_subprogram = |window: &Window| {
        window.get_by_role_and_label(Role::CheckBox, "Subprogram").accesskit_node().toggled()
    };
    ask(&mut window);
    window.get_by_label("Subprogram").click();
    window.run_steps(2);
    assert_eq!(is_subprogram(&window), Some(Toggled::True));
    click_enabled(&window, "Cancel");
    window.run_steps(3);
    window.state_mut().open_part(PartSource::Sample("impeller9x9".to_owned()));
    settle(&mut window);
    ask(&mut window);
    assert_eq!(is_subprogram(&window), Some(Toggled::False));
}

#[test]
fn a_subprogram_says_how_often_it_is_called_and_how_the_offset_turns() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_machine("ac-trunnion");
    ask(&mut window);
    choose_in_list(&mut window, "Channel sequence", "Opposite");
    settle(&mut window);
    assert!(window.query_by_label_contains("to be called").is_none(), "it is a main program");
    window.get_by_label("Subprogram").click();
    window.run_steps(2);
    let count = window.state().state().document.part.as_ref().expect("open").impeller.blade_count;
    let calls = ChannelCalls::for_channels(1, count, ChannelSequence::Opposite);
    let words = calls.words().expect("known");
    assert!(words.starts_with(&format!("to be called {count} times")), "{words}");
    window.get_by_label(&format!("Subprogram {words}"));
    let path = folder.path().join("sub.h");
    save(&mut window, &path);
    let text = std::fs::read_to_string(&path).expect("written");
    for comment in calls.comments() {
        let comment = comment.to_uppercase();
        assert!(text.lines().take(12).any(|line| line.ends_with(&comment)), "{comment}: {}", &text[..900]);
    }
    let notice = window.state().state().notice.as_ref().expect("a message").text.clone();
    assert!(notice.ends_with(&words), "{notice}");
    let page = sheet(&mut window, folder.path());
    assert!(page.contains(&words), "the sheet goes to the machine, too");
    assert!(
        page.contains("channel by channel, opposite channels, about "),
        "each call ends its channel: {page}"
    );

    // A program of several channels is called once.
    ask(&mut window);
    window.get_by_role_and_label(Role::SpinButton, "Channels").set_value_accesskit(3.0);
    window.run_steps(2);
    window.get_by_label("Subprogram to be called once, for its 3 channels");
    let path = folder.path().join("three.h");
    save(&mut window, &path);
    let text = std::fs::read_to_string(&path).expect("written");
    assert!(text.contains("TO BE CALLED ONCE, FOR ITS 3 CHANNELS"), "{}", &text[..900]);
}

#[test]
fn the_flank_plan_is_exported_as_well() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_plan();
    ask(&mut window);
    choose_in_list(&mut window, "Operation", "Flank");
    let path = folder.path().join("flank.h");
    save(&mut window, &path);
    let text = std::fs::read_to_string(&path).expect("written");
    let outcome = window.state().state().results.flank.clone().expect("planned");
    // The same as from the file of the plan, whose coordinates are rounded.
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/parts/impeller532.toml");
    let file =
        write_flank(&read_part(Path::new(sample)).expect("a part"), &outcome.setup, &outcome.plan, &[], 1);
    let stored = read_flank_bytes("flank.json", file.as_bytes()).expect("reads");
    let program = stored.program(&Monitor::default()).expect("not cancelled").expect("it has its tool");
    let target = read_machine(Path::new("ac-trunnion")).unwrap();
    assert_eq!(text, posted(&window, &program, "ac-trunnion", &target.control, target.output));

    // The setup sheet of the selected operation names the program, and no other one.
    window.state_mut().look_mut().operation = Operation::Flank;
    let page = sheet(&mut window, folder.path());
    let control = format!(
        "<code>flank.h</code> (NC code for ac-trunnion, control {}, part turned over by half a turn about its X, ",
        target.control
    );
    assert!(page.contains(&control) && !page.contains(".apt"), "{page}");
    assert!(page.contains(" min), for one channel"), "its time stands beside it: {page}");
    assert!(page.contains(&format!("<b>T{}</b>", outcome.plan.tool.number)));
    let (_, layers) = page.split_once("<h2>Layers</h2>").expect("a table of layers");
    let rows = layers.split("</table>").next().expect("its end").matches("<tr><td>").count();
    assert_eq!(rows, outcome.plan.layout.layers.len(), "a row for each layer");
    for name in ["passes", "walls"] {
        let picture = folder.path().join(format!("sheet-{name}.png"));
        assert!(std::fs::metadata(&picture).expect("beside the page").len() > 5_000, "{name}");
    }
}

#[test]
fn without_a_plan_there_is_nothing_to_post() {
    let (engine, _) = fake::engine();
    let mut window = crate::harness::window(engine);
    window.run_steps(2);
    let ctx = window.ctx.clone();
    let purpose =
        Purpose::ExportNc { operation: Operation::Roughing, dialect: vanecut::io::nc::Dialect::Fanuc };
    let folder = tempfile::tempdir().unwrap();
    window.state_mut().file_chosen(&ctx, purpose, folder.path().join("p.nc"));
    settle(&mut window);
    assert!(!folder.path().join("p.nc").exists());
}

#[test]
#[ignore = "judges flank programs of several channels, 14 s; scripts/nightly runs it"]
fn the_flank_plan_of_several_channels_is_exported_in_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_plan();
    ask(&mut window);
    choose_in_list(&mut window, "Operation", "Flank");
    window.get_by_role_and_label(Role::SpinButton, "Channels").set_value_accesskit(2.0);
    window.run_steps(2);
    choose_in_list(&mut window, "Channel sequence", "Opposite");
    for _ in 0..2 {
        window.get_by_label("Subprogram").click();
        window.run_steps(2);
        let calls = window.query_by_label("Subprogram to be called once, for its 2 channels");
        let is_chosen = window.get_by_label("Subprogram").accesskit_node().toggled() == Some(Toggled::True);
        assert_eq!(calls.is_some(), is_chosen, "as the program says itself");
    }
    let path = folder.path().join("two.h");
    save(&mut window, &path);
    let text = std::fs::read_to_string(&path).expect("written");
    let mut outcome = (*window.state().state().results.flank.clone().expect("planned")).clone();
    outcome.setup.channels.sequence = ChannelSequence::Opposite;
    let notice = &window.state().state().notice.as_ref().expect("a message").text;
    assert!(!notice.contains("fault"), "{notice}");
    let (workpiece, setup) = (&outcome.workpiece, &outcome.setup);
    let program = stored_program(workpiece, setup, &outcome.plan, 2, &Monitor::default()).expect("written");
    let target = read_machine(Path::new("ac-trunnion")).unwrap();
    assert_eq!(text, posted(&window, &program, "ac-trunnion", &target.control, target.output));

    let path = folder.path().join("two.apt");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportFlank { channels: 2 }, path.clone());
    settle(&mut window);
    // No retract of this plan needs another feed rate in another channel.
    let program = outcome.in_channels(2, &Monitor::default()).expect("not cancelled").program;
    assert_eq!(std::fs::read_to_string(&path).expect("written"), write_apt(&program));

    // The setup sheet is for as many channels.
    window.state_mut().look_mut().operation = Operation::Flank;
    let page = sheet(&mut window, folder.path());
    assert!(page.contains("<code>two.h</code>") && page.contains("<code>two.apt</code>"), "{page}");
    assert!(page.contains("all 2 channels of the program, tool by tool, opposite channels"), "{page}");

    // Another number of channels is another program.
    let path = folder.path().join("one.apt");
    window.state_mut().file_chosen(&ctx, Purpose::ExportFlank { channels: 1 }, path.clone());
    settle(&mut window);
    assert_eq!(std::fs::read_to_string(&path).expect("written"), write_apt(&outcome.program()));
}

/// The fake engine, whose flank plans have a pass that ends in the hub, which their verdict does not know of.
fn engine_that_gouges() -> Engine {
    let (engine, _) = fake::engine();
    let flank = move |outcome: &mut FlankOutcome| {
        let is_deepest = |step: &&mut FlankMove| step.kind == MoveKind::Cut && step.layer == 0;
        let step = outcome.plan.moves.iter_mut().rfind(is_deepest).expect("a pass at the hub");
        step.tip -= 3.0 * step.axis;
    };
    fake::with_changed_flank(engine, flank)
}

/// A program of several channels is judged as it is written: what speaks against it is not known before.
#[test]
fn faults_of_a_flank_program_of_several_channels_are_asked_about_and_judging_can_be_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_sample(engine_that_gouges());
    plan_flank(&mut window, 10.0);
    let ctx = window.ctx.clone();
    let export = |window: &mut Window, channels: usize| {
        let path = folder.path().join(format!("{channels}.apt"));
        window.state_mut().file_chosen(&ctx, Purpose::ExportFlank { channels }, path.clone());
        path
    };
    let cancelled = export(&mut window, 17);
    window.run_steps(2);
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label("Writing cancelled");
    assert!(!cancelled.exists());

    // The next one begins without it, also where the one before has not ended yet.
    let path = export(&mut window, 2);
    window.run_steps(1);
    assert!(window.query_by_label("Writing cancelled").is_none());
    window.key_press(egui::Key::Escape);
    window.run_steps(1);
    assert_eq!(export(&mut window, 2), path);
    settle(&mut window);
    assert!(window.query_by_label("Writing cancelled").is_none());
    window.get_by_label("Export this program?");
    assert!(!labels(&window, "• Line ").is_empty(), "what they are, by the lines of the program");
    assert!(!path.exists(), "not before the answer");
    assert!(window.state().keeps_judged_flank(), "it is not judged again");
    click_enabled(&window, "Export anyway");
    window.run_steps(2);
    settle(&mut window);
    assert!(path.exists());
    assert!(window.get_by_label_contains("Wrote ").value().is_some_and(|text| text.contains("fault")));

    // The next file is asked about anew, and a plan that is replaced is not kept.
    assert_eq!(export(&mut window, 2), path);
    settle(&mut window);
    window.get_by_label("Export this program?");
    click_enabled(&window, "Cancel");
    window.run_steps(2);
    set_depth(&mut window, 8.0);
    assert!(!window.state().keeps_judged_flank(), "the plan of the edited setup takes its place");
}
