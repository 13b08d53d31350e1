//! Flank milling in the window.

use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::setup::FlankStrategy;

use crate::fake;
use crate::harness::{Window, settle, snapshot_view, with_sample, words};

/// Sets the depth of the layers in the panel of flank milling, mm.
fn set_depth(window: &mut Window, depth: f64) {
    let field = window.get_by_role_and_label(egui::accesskit::Role::Slider, "Layer depth");
    field.set_value_accesskit(depth);
    window.run_steps(4);
    settle(window);
}

#[test]
fn flank_curves_are_planned_shown_and_written() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    assert!(window.state().state().results.flank.is_none());
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    set_depth(&mut window, 8.0);
    window.key_press(egui::Key::F6);
    window.run_steps(2);
    settle(&mut window);
    let planned = window.state().state().results.flank.clone().expect("planned");
    assert_eq!(planned.plan.layout.strategy, FlankStrategy::Balanced);
    assert!(window.state().state().look.flank.shown, "what was asked for is shown");
    assert!(!window.state().state().flank_is_stale());
    window.key_press(egui::Key::Num4);
    window.run_steps(4);
    settle(&mut window);
    snapshot_view(&mut window, "flank");

    // Shows the walls instead of the stock on the hub, then the hub again.
    window.state_mut().look_mut().layers.cutters = false;
    window.get_by_label("walls").click_accesskit();
    window.run_steps(4);
    let most = window.state().state().shown_deviation().expect("walls are shown");
    window.get_by_label("Residual on walls");
    window.get_by_label(&vanecut::app::views::legend::format_signed(most, most));
    snapshot_view(&mut window, "flank_walls");
    // The value under the cursor has a sign: above or below the allowance.
    let view = window.get_by_label("3D view").rect();
    let (mut above, mut below) = (0, 0);
    // Points spread over the view in a pseudo-random order.
    for k in (1..576).map(|k| 217 * k % 576) {
        let share = egui::vec2((k % 24) as f32 / 24.0, (k / 24) as f32 / 24.0);
        window.hover_at(view.min + view.size() * share);
        window.step();
        let Some(text) = words(&window, " mm here") else { continue };
        let value: f32 = text.trim_end_matches(" mm here").replace('−', "-").parse().expect("a figure");
        assert!(value.abs() <= most + 1e-4, "{text} of {most}");
        above += usize::from(text.starts_with('+') && value > 0.0);
        below += usize::from(text.starts_with('−'));
        if above >= 3 && below >= 3 {
            break;
        }
    }
    window.event(egui::Event::PointerGone);
    window.run_steps(2);
    assert!(above > 0 && below > 0, "both signs are found: {above} above, {below} below");
    window.get_by_label("layer").click_accesskit();
    window.run_steps(4);
    window.get_by_label_contains("layer 1, at the hub");
    snapshot_view(&mut window, "flank_layers");

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flank.apt");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::ExportFlank, path.clone());
    settle(&mut window);
    let program = vanecut::io::apt::read_apt(&path).expect("a CL file");
    assert_eq!(program.moves.len(), planned.plan.moves.len());
}

#[test]
fn an_edit_of_flank_milling_is_followed_and_until_then_marked_and_the_plunge_plan_stays() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Flank: not calculated").click();
    window.run_steps(4);
    // Few layers.
    set_depth(&mut window, 10.0);
    window.get_by_label("Calculate flank").click_accesskit();
    window.run_steps(2);
    settle(&mut window);
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    assert!(window.query_by_label("Out of date:").is_none());
    set_depth(&mut window, 8.0);
    window.get_by_label("Out of date:");
    window.get_by_label("Flank: out of date");
    window.get_by_label("Setup edited: recalculate flank (F6)");
    assert!(!window.state().state().out_of_date(), "the plunge plan does not depend on it");
    window.get_by_label("Auto-update").click();
    window.run_steps(2);
    settle(&mut window);
    assert!(window.query_by_label("Out of date:").is_none(), "followed");
    let planned = window.state().state().results.flank.clone().expect("planned");
    assert_eq!(planned.setup.flank.layer_depth, 8.0);
    window.get_by_label_contains("Flank calculated in");
}
