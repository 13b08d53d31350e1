//! The window without a graphics device, and recovery when the device is lost.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use vanecut::app::App;
use vanecut::app::control::handover::RecoverySlot;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::tasks::engine::Engine;
use vanecut::io::project_file::read_project;

use crate::fake;
use crate::harness::{HANG, Window, press, sample_in, settle, vulkan, window};

#[test]
fn without_a_device_everything_but_the_picture_works() {
    let (engine, _) = fake::engine();
    let mut window = egui_kittest::Harness::builder()
        .with_size([900.0, 600.0])
        .build_eframe(|cc| App::with_engine(cc, engine));
    window.run_steps(2);
    window.get_by_label("impeller532").click();
    window.step();
    let start = std::time::Instant::now();
    while window.state().is_busy() || window.state().state().results.planned.is_none() {
        assert!(start.elapsed() < HANG, "the work does not end");
        std::thread::sleep(std::time::Duration::from_millis(2));
        window.step();
    }
    window.run_steps(3);
    window.get_by_label("no 3D view");
    window.get_by_label("Interfering plunges 5 to 0");
    window.get_by_label("Position 3").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.selected, Some(2), "the table works");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, path.clone());
    while window.state().is_busy() {
        assert!(start.elapsed() < HANG, "the work does not end");
        std::thread::sleep(std::time::Duration::from_millis(2));
        window.step();
    }
    assert!(path.exists(), "and the work can be saved");
}

/// A window with the sample part, and its graphics device.
fn sample_on_a_device(engine: Engine) -> (Window, wgpu::Device) {
    let drawn_on = create_render_state(vulkan(), eframe::egui_wgpu::RendererOptions::PREDICTABLE);
    let device = drawn_on.device.clone();
    let window = sample_in(
        egui_kittest::Harness::builder()
            .with_size([900.0, 600.0])
            .renderer(WgpuTestRenderer::from_render_state(drawn_on))
            .build_eframe(|cc| App::with_engine(cc, engine)),
    );
    (window, device)
}

#[test]
fn a_device_that_is_lost_leaves_the_work_intact_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let (mut lost, device) = sample_on_a_device(engine.clone());
    lost.state_mut().set_home(folder.path().join("home"));
    lost.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(5.0);
    lost.run_steps(2);
    settle(&mut lost);
    device.destroy();
    // The loss shows at the next use of the device; an idle window draws nothing.
    device.poll(wgpu::PollType::wait_indefinitely()).expect("polls");
    lost.run_steps(3);
    lost.get_by_label("The graphics device reports: device lost");
    lost.get_by_label("Fix: save the project and restart with VANECUT_GPU=software");
    let copies = std::fs::read_dir(folder.path().join("home/recovery")).expect("a folder").flatten();
    let copy = copies.map(|entry| entry.path()).next().expect("a copy was written at once");
    assert_eq!(read_project(&copy).expect("reads").setup.plunge.step, Some(5.0), "with the latest edit");

    // Everything except drawing still works, and drawing does no harm.
    lost.get_by_label("Position 3").click();
    lost.run_steps(3);
    assert_eq!(lost.state().state().look.selected, Some(2), "the table works");
    let at = lost.get_by_label("3D view").rect().center();
    press(&mut lost, at);
    lost.run_steps(3);
    lost.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(4.0);
    lost.run_steps(2);
    settle(&mut lost);
    assert_eq!(lost.state().state().position_count(), 80, "planning works");
    let path = folder.path().join("p.vanecut");
    let ctx = lost.ctx.clone();
    lost.state_mut().file_chosen(&ctx, Purpose::SaveProject, path.clone());
    settle(&mut lost);
    drop(lost);

    let mut again = window(engine);
    again.state_mut().open_path(path);
    settle(&mut again);
    assert_eq!(again.state().state().document.edited.setup.plunge.step, Some(4.0), "all of it was saved");
}

#[test]
fn a_window_whose_device_is_lost_closes_and_the_next_one_is_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let way_out = RecoverySlot::default();
    let (mut lost, device) = sample_on_a_device(engine.clone());
    lost.state_mut().set_home(folder.path().join("home"));
    lost.state_mut().set_recovery_slot(way_out.clone());
    lost.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(5.0);
    lost.run_steps(6);
    settle(&mut lost);
    lost.get_by_label("Position 3").click();
    lost.run_steps(8);
    let camera = lost.state().camera();
    device.destroy();
    device.poll(wgpu::PollType::wait_indefinitely()).expect("polls");
    lost.step();
    let commands = &lost.output().viewport_output[&egui::ViewportId::ROOT].commands;
    assert!(commands.contains(&egui::ViewportCommand::Close), "the window closes: {commands:?}");
    assert_eq!(lost.output().shapes.len(), 0, "nothing is drawn on a device that is gone");
    let left = way_out.take().expect("everything is left");
    assert!(left.reason().contains("device lost"), "{}", left.reason());
    drop(lost);

    let mut again = egui_kittest::Harness::builder()
        .with_size([900.0, 600.0])
        .wgpu_setup(vulkan())
        .build_eframe(move |cc| App::resumed(cc, engine, left));
    again.run_steps(4);
    let said = again.state().state().problems[0].message.clone();
    assert!(said.contains("The graphics device was lost"), "{said}");
    assert!(again.query_all_by_label(&said).next().is_some(), "and it is on the screen");
    again.get_by_label("3D view");
    let state = again.state().state();
    assert_eq!(state.document.edited.setup.plunge.step, Some(5.0));
    assert!(state.document.is_unsaved() && state.document.can_undo());
    assert_eq!((state.look.selected, state.position_count()), (Some(2), 64), "plan and selection");
    assert_eq!(again.state().camera(), camera, "the view");
    let copies = std::fs::read_dir(folder.path().join("home/recovery")).expect("a folder").flatten();
    assert_eq!(copies.count(), 1, "and the copy that survives anything is there");
}
