//! Nothing is lost and no bad program leaves the window unasked.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::checked::CheckRequest;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::app::model::planned::Side;
use vanecut::app::tasks::check::CheckError;
use vanecut::app::tasks::engine::Engine;
use vanecut::monitor::Monitor;

use crate::fake;
use crate::flank::plan_flank;
use crate::harness::{HANG, Window, click_enabled, settle, with_sample};

const ONE_CHANNEL: Purpose = Purpose::ExportCl { channels: 1 };

#[test]
fn a_plan_that_is_out_of_date_is_exported_only_when_confirmed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.apt");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(3.0);
    window.run_steps(3);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, path.clone());
    window.run_steps(2);
    window.get_by_label("Export this program?");
    window.get_by_label_contains("The setup was edited after this calculation");
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    // The setup sheet is not a program, and the question says so.
    let sheet = Purpose::ExportSheet { operation: Operation::Roughing };
    window.state_mut().file_chosen(&ctx, sheet, folder.path().join("p.html"));
    window.run_steps(2);
    window.get_by_label("Export the setup sheet of this plan?");
    window.get_by_label_contains("The setup was edited after this calculation");
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    settle(&mut window);
    assert!(!path.exists(), "nothing is written");

    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, path.clone());
    window.run_steps(2);
    window.get_by_label("Recalculate").click();
    window.run_steps(2);
    settle(&mut window);
    assert!(!window.state().state().out_of_date());
    assert!(path.exists(), "nothing speaks against it any more");
    let now = window.state().state().shown().expect("planned").planned.setup.plunge.step;
    assert_eq!(now, Some(3.0), "what is written is the new plan");

    // An edit while it is calculated ends the export.
    std::fs::remove_file(&path).expect("is removed");
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(4.0);
    window.run_steps(3);
    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, path.clone());
    window.run_steps(2);
    window.get_by_label("Recalculate").click();
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(5.0);
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().state().out_of_date() && !path.exists(), "it was for another setup");
}

/// Shanks and holders are judged in the program as it is written, which the plan does not tell.
#[test]
fn a_shank_in_the_way_is_asked_about_before_a_plunge_program_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.apt");
    let (engine, _) = fake::engine();
    let engine = fake::with_changed_plans(engine, |outcome| {
        for tool in &mut outcome.setup.tools {
            tool.assembly.shank = vec![[90.0, tool.overhang - 10.0]];
        }
    });
    let mut window = with_sample(engine);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, path.clone());
    window.run_steps(2);
    settle(&mut window);
    assert!(window.query_all_by_label_contains("the shank of tool 1 comes within").count() > 0);
    assert!(!path.exists(), "not before that is answered");
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    settle(&mut window);
    assert!(!path.exists());
    // Nor for several channels.
    window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels: 2 }, path.clone());
    window.run_steps(2);
    settle(&mut window);
    assert!(!path.exists());
    window.get_by_label("Export anyway").click();
    window.run_steps(2);
    settle(&mut window);
    assert!(path.exists(), "it is accepted");
}

/// The setup sheet goes to the machine with the program.
#[test]
fn a_shank_in_the_way_is_asked_about_before_a_setup_sheet_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.html");
    let (engine, _) = fake::engine();
    let engine = fake::with_changed_plans(engine, |outcome| {
        for tool in &mut outcome.setup.tools {
            tool.assembly.shank = vec![[90.0, tool.overhang - 10.0]];
        }
    });
    let mut window = with_sample(engine);
    let ctx = window.ctx.clone();
    let sheet = Purpose::ExportSheet { operation: Operation::Roughing };
    let ask = |window: &mut Window| {
        window.state_mut().file_chosen(&ctx, sheet, path.clone());
        window.run_steps(2);
        settle(window);
        window.get_by_label("Export the setup sheet of this plan?");
        assert!(window.query_all_by_label_contains("the shank of tool 1 comes within").count() > 0);
        assert!(!path.exists(), "not before that is answered");
    };
    ask(&mut window);
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    settle(&mut window);
    assert!(!path.exists());
    ask(&mut window);
    window.get_by_label("Export anyway").click();
    window.run_steps(2);
    settle(&mut window);
    assert!(path.exists(), "it is accepted");
}

/// Edits the step, of which no plan is ready while `slow` is set, and exports the plan before it to `path`.
fn export_while_edits_are_calculated(window: &mut Window, slow: &fake::Slow, path: &Path) {
    slow.store(true, Ordering::SeqCst);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(3.0);
    window.run_steps(3);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, path.to_owned());
    window.run_steps(2);
}

/// Clicks a button of a question that has changed, after the time for reading it.
fn answer_once_read(window: &mut Window, button: &str) {
    settle(window);
    window.run_steps(8);
    click_enabled(window, button);
    window.run_steps(2);
    settle(window);
}

/// A calculation that ends while the question is open replaces the plan that it is about: what is written is
/// what the question names, and no button takes the place of another.
#[test]
fn a_question_follows_the_plan_that_is_calculated_meanwhile() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.apt");
    let (engine, slow) = fake::engine();
    let engine = fake::with_changed_plans(engine, |outcome| {
        outcome.after.plan.converged = outcome.setup.plunge.step != Some(3.0);
    });
    let mut window = with_sample(engine);
    export_while_edits_are_calculated(&mut window, &slow, &path);
    window.get_by_label_contains("The setup was edited after this calculation");
    window.get_by_label("p.apt");
    let place = window.get_by_label("Export anyway").rect();

    slow.store(false, Ordering::SeqCst);
    wait_until(&mut window, |window| {
        window.query_by_label_contains("calculated anew while this was asked").is_some()
    });
    assert!(window.query_by_label_contains("The setup was edited").is_none(), "it is the plan of that setup");
    window.get_by_label_contains("stopped at its limit of iterations");
    let export = window.get_by_label("Export anyway");
    assert!(export.accesskit_node().is_disabled(), "not before the question is read again");
    assert!((export.rect().left() - place.left()).abs() < 1.0, "it stays where it was");
    assert!(window.get_by_label("Recalculate").accesskit_node().is_disabled());
    answer_once_read(&mut window, "Export anyway");
    assert!(path.exists());
}

/// Where nothing is left that speaks against the file, it is not exported "anyway".
#[test]
fn a_question_that_has_answered_itself_just_exports() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.apt");
    let (engine, slow) = fake::engine();
    let mut window = with_sample(engine);
    export_while_edits_are_calculated(&mut window, &slow, &path);
    window.get_by_label("Export anyway");
    slow.store(false, Ordering::SeqCst);
    wait_until(&mut window, |window| window.query_by_label_contains("Nothing speaks against it").is_some());
    assert!(window.query_by_label("Export anyway").is_none());
    answer_once_read(&mut window, "Export");
    assert!(path.exists());
}

#[test]
fn an_interfering_plan_is_named_as_such_before_it_is_exported() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("before.apt");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().look_mut().side = Side::Before;
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, path.clone());
    window.run_steps(2);
    window.get_by_label_contains("The core meets stock in");
    window.get_by_label_contains("The axis strategy is Isoparametric, not Min. stock as in the setup");
    assert!(window.query_by_label("Recalculate").is_none(), "that would give the same plan");
    window.get_by_label("Export anyway").click();
    window.run_steps(2);
    settle(&mut window);
    assert!(path.exists());
}

/// What becomes known without another plan is not said to come with one.
#[test]
fn a_question_that_changes_without_another_plan_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Auto-update").click();
    window.state_mut().look_mut().side = Side::Before;
    window.run_steps(2);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, folder.path().join("p.apt"));
    window.run_steps(2);
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(3.0);
    window.run_steps(3);
    window.get_by_label_contains("The setup was edited after this calculation");
    window.get_by_label("Something else became known while this was asked. Now:");
    assert!(window.query_by_label_contains("calculated anew").is_none());
}

/// The command line ends with exit code 1 then.
#[test]
fn a_plan_that_did_not_converge_is_asked_about() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.apt");
    let (engine, _) = fake::engine();
    let engine = fake::with_changed_plans(engine, |outcome| outcome.after.plan.converged = false);
    let mut window = with_sample(engine);
    assert!(window.get_all_by_label_contains("not converged").count() > 0);
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, ONE_CHANNEL, path.clone());
    window.run_steps(2);
    window.get_by_label_contains("before it converged");
    settle(&mut window);
    assert!(!path.exists(), "nothing is written");
}

/// The plan is that of one channel.
#[test]
fn what_is_counted_in_one_channel_is_said_to_be_in_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().look_mut().side = Side::Before;
    let ctx = window.ctx.clone();
    for (channels, words) in [(1, "plunges, up to"), (17, "plunges in each channel, up to")] {
        let path = folder.path().join("before.apt");
        window.state_mut().file_chosen(&ctx, Purpose::ExportCl { channels }, path);
        window.run_steps(2);
        window.get_by_label_contains(words);
        window.key_press(egui::Key::Escape);
        window.run_steps(2);
    }
}

/// Draws frames until it is so.
fn wait_until(window: &mut Window, is_so: impl Fn(&Window) -> bool) {
    let start = Instant::now();
    while !is_so(window) {
        assert!(start.elapsed() < HANG, "it does not come to it");
        window.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Only an export that has to be checked first waits for another such one, which is said; both go ahead of
/// the check of a program, which goes on afterwards.
#[test]
fn exports_go_ahead_of_checks_and_short_ones_of_those_that_are_checked_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let (steps, held) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(true)));
    let (counter, holds, inner) = (Arc::clone(&steps), Arc::clone(&held), Arc::clone(&engine.check));
    let check = move |request: &CheckRequest, monitor: &Monitor| {
        while holds.load(Ordering::SeqCst) {
            monitor.check().map_err(|_| CheckError::Cancelled)?;
            counter.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(Duration::from_millis(1));
        }
        inner(request, monitor)
    };
    let steps = || steps.load(Ordering::SeqCst);
    let mut window = with_sample(Engine { check: Arc::new(check), ..engine });
    plan_flank(&mut window, 10.0);
    let ctx = window.ctx.clone();
    let export = |window: &mut Window, purpose: Purpose, name: &str| {
        let path = folder.path().join(name);
        window.state_mut().file_chosen(&ctx, purpose, path.clone());
        window.run_steps(2);
        if window.query_by_label("Export anyway").is_some() {
            click_enabled(window, "Export anyway");
            window.run_steps(2);
        }
        path
    };
    let checked = export(&mut window, ONE_CHANNEL, "checked.apt");
    settle(&mut window);
    window.state_mut().open_path(checked);
    wait_until(&mut window, |_| steps() > 5);
    assert_eq!(window.state().running_task().map(|(name, _)| name), Some("Checking program"));

    let flank = |channels| Purpose::ExportFlank { channels };
    let whole = export(&mut window, flank(4), "whole.apt");
    let waiting = "The flank program waits for the export that is being checked";
    assert!(window.query_by_label(waiting).is_none(), "it is the first");
    let two = export(&mut window, flank(2), "two.apt");
    window.get_by_label(waiting);
    let begun = steps();
    for (purpose, name) in [(flank(1), "one.apt"), (ONE_CHANNEL, "rough.apt")] {
        let path = export(&mut window, purpose, name);
        wait_until(&mut window, |_| path.exists());
        settle_message(&mut window, name);
        assert!(!whole.exists(), "it is written first");
    }
    assert_eq!(window.state().running_task().map(|(name, _)| name), Some("Checking export"));
    wait_until(&mut window, |_| whole.exists());
    let done = steps() - begun;
    assert!(done < 100, "{done} steps of the check meanwhile");
    wait_until(&mut window, |_| two.exists());
    let then = steps();
    wait_until(&mut window, |_| steps() > then + 50);
    held.store(false, Ordering::SeqCst);
    settle(&mut window);
    assert!(window.state().state().results.checked.is_some(), "the check went on where it was");
}

/// Waits for the message about a file that was written.
fn settle_message(window: &mut Window, name: &str) {
    wait_until(window, |window| {
        let wrote = window.query_all_by_label_contains("Wrote ");
        wrote.into_iter().any(|node| node.value().is_some_and(|text| text.contains(name)))
    });
}

/// A message about a file that could not be written ends when one of the same kind is.
#[test]
fn a_file_that_is_written_ends_the_message_about_the_one_that_was_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let ctx = window.ctx.clone();
    let mut export = |purpose, name: &str| {
        window.state_mut().file_chosen(&ctx, purpose, folder.path().join(name));
        window.run_steps(2);
        settle(&mut window);
        window.run_steps(2);
        window.query_all_by_label_contains("p.apt").count()
    };
    let shown = export(ONE_CHANNEL, "nowhere/p.apt");
    assert!(shown > 0, "it cannot be written");
    assert!(export(Purpose::SaveSetup, "s.toml") > 0, "another kind of file");
    assert_eq!(export(ONE_CHANNEL, "q.apt"), 0);
}

#[test]
fn after_do_not_save_no_recovery_copy_is_left() {
    let folder = tempfile::tempdir().expect("a folder");
    let home = folder.path().join("home");
    let copies = || std::fs::read_dir(home.join("recovery")).into_iter().flatten().count();
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.state_mut().set_home(home.clone());
    window.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(6.5);
    window.run_steps(14);
    settle(&mut window);
    assert_eq!(copies(), 1);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Q);
    window.run_steps(2);
    window.get_by_label("Don't save").click();
    window.run_steps(14);
    assert_eq!(copies(), 0, "it was discarded on purpose");
}
