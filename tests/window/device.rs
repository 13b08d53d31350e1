//! Without a graphics device, and when it is lost: the work goes on.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use vanecut::app::App;
use vanecut::app::dialogs::Purpose;
use vanecut::formats::project_file::read_project;

use crate::fake;
use crate::harness::{press, sample_in, settle, vulkan, window};

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
        assert!(start.elapsed().as_secs() < 60, "the work does not end");
        std::thread::sleep(std::time::Duration::from_millis(2));
        window.step();
    }
    window.run_steps(3);
    window.get_by_label("no 3D view");
    window.get_by_label("Interferential 5 to 0");
    window.get_by_label("Position 3").click();
    window.run_steps(3);
    assert_eq!(window.state().state().look.selected, Some(2), "the table works");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.vanecut");
    let ctx = window.ctx.clone();
    window.state_mut().file_chosen(&ctx, Purpose::SaveProject, path.clone());
    while window.state().is_busy() {
        assert!(start.elapsed().as_secs() < 60, "the work does not end");
        std::thread::sleep(std::time::Duration::from_millis(2));
        window.step();
    }
    assert!(path.exists(), "and the work can be saved");
}

#[test]
fn a_device_that_is_lost_leaves_the_work_intact_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let predictable = eframe::egui_wgpu::RendererOptions::PREDICTABLE;
    let drawn_on = create_render_state(vulkan(), predictable);
    let device = drawn_on.device.clone();
    let to_app = engine.clone();
    let mut lost = sample_in(
        egui_kittest::Harness::builder()
            .with_size([900.0, 600.0])
            .renderer(WgpuTestRenderer::from_render_state(drawn_on))
            .build_eframe(|cc| App::with_engine(cc, to_app)),
    );
    lost.state_mut().set_home(folder.path().join("home"));
    lost.get_by_role_and_label(Role::SpinButton, "Step").set_value_accesskit(5.0);
    lost.run_steps(2);
    settle(&mut lost);
    device.destroy();
    // The next use of the device brings it to light; at rest the window draws nothing.
    device.poll(wgpu::PollType::wait_indefinitely()).expect("polls");
    lost.run_steps(3);
    lost.get_by_label("The graphics device reports: device lost");
    lost.get_by_label("To do: save the project and start again with VANECUT_GPU=software");
    let copies = std::fs::read_dir(folder.path().join("home/recovery")).expect("a folder").flatten();
    let copy = copies.map(|entry| entry.path()).next().expect("a copy was written at once");
    assert_eq!(read_project(&copy).expect("reads").setup.plunge.step, Some(5.0), "with the latest edit");

    // Everything that does not draw goes on, and what draws does no harm.
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
