//! What the panels of flank milling say, and that it can be read in narrow ones.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::flank::region::{Region, WallName};
use vanecut::flank::{UncutLength, UncutReason};
use vanecut::job::flank::FlankOutcome;

use crate::channels::show_channels;
use crate::fake;
use crate::flank::{plan_flank, set_depth, with_plan};
use crate::harness::{Window, labels, pixels_in, settle, with_sample};

/// Beside columns of numbers the reasons would have one of a few letters.
#[test]
fn reasons_of_skipped_stretches_are_read_at_the_least_size() {
    const REASON: &str = "too short between obstacles for a pass";
    let (engine, _) = fake::engine();
    let flank = |outcome: &mut FlankOutcome| {
        let (why, overhang) = (UncutReason::new(REASON), None);
        let left = UncutLength { layer: 0, region: Region::INLET, length: 12.0, why, overhang };
        outcome.plan.uncut = vec![left.clone(), left];
    };
    let mut window = with_sample(fake::with_changed_flank(engine, flank));
    plan_flank(&mut window, 10.0);
    for size in [[1280.0, 900.0], [800.0, 900.0], [800.0, 500.0]] {
        window.set_size(size.into());
        window.run_steps(6);
        let reason = window.get_by_label("Too short between obstacles for a pass").rect();
        let number = window.get_by_label("2 stretches, 24.0 mm").rect();
        assert!(reason.height() < 2.5 * number.height(), "{size:?}: {reason} in two lines at most");
        assert!(number.top() >= reason.bottom(), "{size:?}: {number} below {reason}");
        assert!(reason.right() <= size[0] && number.right() <= size[0], "{size:?}");
    }
}

/// Checks that no head of the table of passes and no cell of `word` is cut.
fn is_read(window: &Window, word: &str) {
    let heads = ["Layer", "Region", "Length", "Time"].map(|head| {
        let found = window.query_all_by_role_and_label(Role::Label, head).map(|node| node.rect());
        found.max_by(|a, b| a.left().total_cmp(&b.left())).expect("a head")
    });
    let edge = window.ctx.content_rect().right();
    assert!(heads.windows(2).all(|pair| pair[0].right() < pair[1].left()), "{heads:?}");
    assert!(heads.iter().all(|head| head.right() < edge - 4.0), "{heads:?} within {edge}");
    let mut cells = window.query_all_by_label(word).map(|node| node.rect());
    let cell = cells.next().expect("a cell");
    assert!(heads[0].right() < cell.left() && cell.right() < heads[2].left(), "{word}: {cell} {heads:?}");
}

#[test]
fn regions_of_passes_are_whole_words() {
    let mut window = with_plan();
    let rows = window.state().state().results.passes.clone();
    let along = rows.passes.iter().position(|pass| pass.along_wall).expect("passes along the walls");
    let word = match rows.passes[along].region.low {
        WallName::Low => "suction wall",
        _ => "pressure wall",
    };
    for size in [[1280.0, 800.0], [800.0, 800.0]] {
        window.set_size(size.into());
        window.state_mut().look_mut().flank.pass = Some(along);
        window.state_mut().look_mut().flank.reveal = true;
        window.run_steps(6);
        is_read(&window, word);
    }
    window.state_mut().look_mut().flank.pass = None;
    show_channels(&mut window, 2.0);
    window.state_mut().look_mut().flank.pass = Some(along);
    window.state_mut().look_mut().flank.reveal = true;
    window.run_steps(6);
    is_read(&window, word);
}

/// In the verdict line, in the panel and at both ends of the scale.
#[test]
fn deviations_of_walls_have_the_same_decimals_everywhere() {
    let (engine, _) = fake::engine();
    let flank = |outcome: &mut FlankOutcome| {
        let verdict = outcome.verdict.as_mut().expect("verified");
        (verdict.max_overcut, verdict.max_undercut) = (0.0125, 1.2339);
    };
    let mut window = with_sample(fake::with_changed_flank(engine, flank));
    window.set_size(egui::vec2(1280.0, 900.0));
    plan_flank(&mut window, 10.0);
    window.get_by_label("walls").click_accesskit();
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    window.get_by_label("−0.0125 / +1.2339 mm");
    window.get_by_label_contains("wall error: −0.0125 mm overcut, +1.2339 mm undercut");
    window.get_by_label("−1.2339 mm");
    let view = window.get_by_label("3D view").rect();
    for k in 0..400 {
        let share = egui::vec2((k % 20) as f32 / 20.0, (k / 20) as f32 / 20.0);
        window.hover_at(view.min + view.size() * share);
        window.step();
        if let Some(here) = labels(&window, "").into_iter().find(|text| text.ends_with(" mm here")) {
            let (_, decimals) = here.trim_end_matches(" mm here").split_once('.').expect("a fraction");
            assert_eq!(decimals.len(), 4, "{here}");
            return;
        }
    }
    panic!("no wall under the pointer");
}

/// Only whole plans are judged: what is planned of one until it is stopped is not shown as a plan.
#[test]
fn a_flank_calculation_that_is_stopped_says_what_is_kept() {
    let (engine, _) = fake::engine();
    let (engine, held) = fake::with_held_flank(engine);
    let mut window = with_sample(engine);
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    set_depth(&mut window, 10.0);
    let stop = |window: &mut Window| {
        window.key_press(egui::Key::F6);
        window.run_steps(3);
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
        settle(window);
        window.state().state().notice.clone().expect("a word about it").text
    };
    let text = stop(&mut window);
    assert_eq!(text, "Flank calculation cancelled; an unfinished flank plan is not kept");
    assert!(window.state().state().results.flank.is_none());
    held.store(false, Ordering::SeqCst);
    window.key_press(egui::Key::F6);
    window.run_steps(3);
    settle(&mut window);
    let kept = window.state().state().results.flank.clone().expect("planned");
    held.store(true, Ordering::SeqCst);
    let text = stop(&mut window);
    assert_eq!(text, "Flank calculation cancelled; the last flank plan is kept");
    assert!(Arc::ptr_eq(&kept, window.state().state().results.flank.as_ref().expect("kept")));
    held.store(false, Ordering::SeqCst);
}

/// A layer that would change nothing is not offered; one that is offered changes the picture.
#[test]
fn layers_of_flank_are_those_that_it_has() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    plan_flank(&mut window, 10.0);
    window.get_by_role_and_label(Role::Button, "Layers").click();
    window.run_steps(3);
    let offered = |window: &Window| {
        let layers = ["Cutters", "Axes", "Holders", "Rapids"].into_iter();
        let is_offered = |name: &&str| {
            let switch = window.get_by_role_and_label(Role::CheckBox, name);
            !switch.accesskit_node().is_disabled()
        };
        layers.filter(is_offered).collect::<Vec<_>>()
    };
    assert_eq!(offered(&window), ["Rapids"]);
    let view = window.get_by_label("3D view").rect().shrink(80.0);
    let without = pixels_in(&mut window, view);
    window.get_by_role_and_label(Role::CheckBox, "Rapids").click();
    window.run_steps(4);
    let changed = pixels_in(&mut window, view).iter().zip(&without).filter(|(a, b)| a != b).count();
    assert!(changed > 50, "{changed} pixels");
    // The tool stands in the wheel, and may have a holder.
    window.state_mut().look_mut().flank.cut = Some(40);
    window.run_steps(4);
    assert_eq!(offered(&window), ["Holders", "Rapids"]);
}
