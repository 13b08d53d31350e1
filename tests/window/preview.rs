//! The stock on the floor is what the compute kernel left in its buffer.

use egui_kittest::kittest::Queryable;
use vanecut::app::model::planned::Side;
use vanecut::app::tasks::engine::Engine;
use vanecut::app::views::pictures::PreviewSource;
use vanecut::job::{JobError, Listener, PlanRequest};
use vanecut::monitor::Monitor;

use crate::fake;
use crate::harness::{Window, pixels_in, settle, with_sample};

/// The fake planner, whose fields have no stock anywhere; its plunges are as ever.
fn without_heights() -> Engine {
    let (engine, _) = fake::engine();
    let real = engine.plan.clone();
    let plan = move |request: &PlanRequest, monitor: &Monitor, listener: Listener| {
        let mut outcome = real(request, monitor, listener)?;
        for result in [&mut outcome.before, &mut outcome.after] {
            result.field.heights.fill(0.0);
        }
        Ok::<_, JobError>(outcome)
    };
    Engine { plan: std::sync::Arc::new(plan), ..engine }
}

/// A window that shows the floor of the channel, not hidden by cutters, under a fixed scale.
fn floor_of(engine: Engine, source: PreviewSource) -> Window {
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(900.0, 660.0));
    window.state_mut().set_preview_source(source);
    window.key_press(egui::Key::Num4);
    let look = window.state_mut().look_mut();
    look.layers.cutters = false;
    look.range = Some((0.0, 6.0));
    settle(&mut window);
    window
}

/// The pixels of the 3D view, RGBA, without the controls around it.
fn pixels(window: &mut Window) -> Vec<[u8; 4]> {
    settle(window);
    let rect = window.get_by_label("3D view").rect().shrink(70.0);
    pixels_in(window, rect)
}

/// Number of pixels that differ visibly.
fn differing(a: &[[u8; 4]], b: &[[u8; 4]]) -> usize {
    assert_eq!(a.len(), b.len());
    let far = |(a, b): &(&[u8; 4], &[u8; 4])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 8);
    a.iter().zip(b).filter(far).count()
}

/// Pixels that may differ between both kernels: rays that graze a cutter.
const GRAZING: usize = 40;

#[test]
fn the_kernel_draws_the_stock_before_after_between_and_their_difference() {
    let (engine, _) = fake::engine();
    let mut device = floor_of(engine.clone(), PreviewSource::Device);
    let mut core = floor_of(engine, PreviewSource::Core);
    // Were the heights of the core drawn, this window would show a floor without stock.
    let mut poisoned = floor_of(without_heights(), PreviewSource::Device);
    let mut bare = floor_of(without_heights(), PreviewSource::Core);
    let mut seen: Vec<Vec<[u8; 4]>> = Vec::new();
    let count = device.state().state().position_count();
    for (side, difference, cut) in [
        (Side::After, false, None),
        (Side::Before, false, None),
        (Side::After, true, None),
        (Side::After, false, Some(count / 3)),
        (Side::After, false, Some(0)),
    ] {
        for window in [&mut device, &mut core, &mut poisoned, &mut bare] {
            let look = window.state_mut().look_mut();
            (look.side, look.difference, look.cut_count) = (side, difference, cut);
        }
        let of_device = pixels(&mut device);
        let what = format!("{side:?}, difference {difference}, cut {cut:?}");
        assert!(differing(&of_device, &pixels(&mut core)) <= GRAZING, "{what}: kernel and core draw alike");
        assert!(
            differing(&of_device, &pixels(&mut poisoned)) <= GRAZING,
            "{what}: heights of the core are not drawn"
        );
        // Heights of part of a plan come from the core's own kernel.
        if cut.is_none() {
            assert!(differing(&of_device, &pixels(&mut bare)) > 2000, "{what}: other heights would be seen");
        }
        for other in &seen {
            assert!(differing(&of_device, other) > 500, "{what}: unlike the pictures before");
        }
        seen.push(of_device);
    }
}

#[test]
fn the_status_bar_says_what_computes_the_preview() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.get_by_label("Preview: GPU (llvmpipe)");
    window.state_mut().set_preview_source(PreviewSource::Core);
    window.run_steps(3);
    window.get_by_label("Preview: CPU");
}
