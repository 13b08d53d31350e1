//! Drives the window without a screen, on software Vulkan, and compares snapshots.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

use eframe::egui_wgpu::{RendererOptions, WgpuSetup, WgpuSetupExisting};
use egui_kittest::wgpu::create_render_state;
use egui_kittest::{Harness, SnapshotOptions};
use vanecut::app::App;
use vanecut::app::model::part_source::PartSource;
use vanecut::app::tasks::engine::Engine;

/// A window of 900 × 600 points.
pub type Window = Harness<'static, App>;

/// Opens a window over `engine`. Its 3D views are drawn for snapshots and by [`pixels_in`] only: on the
/// software driver they would take most of the time.
pub fn window(engine: Engine) -> Window {
    scaled(engine, 1.0)
}

/// The same on a screen with `scale` pixels per point.
pub fn scaled(engine: Engine, scale: f32) -> Window {
    let mut window: Window = Harness::builder()
        .with_size([900.0, 600.0])
        .with_pixels_per_point(scale)
        .with_theme(egui::Theme::Dark)
        .with_render_cursor(false)
        .wgpu_setup(WgpuSetup::Existing(DEVICE.clone()))
        .build_eframe(|cc| App::with_engine(cc, engine));
    window.state_mut().wait_to_draw_pictures();
    window
}

/// The device of all windows but those that lose theirs: to find a driver and open a device on it takes
/// longer than most tests.
static DEVICE: LazyLock<WgpuSetupExisting> = LazyLock::new(|| {
    let state = create_render_state(vulkan(), RendererOptions::PREDICTABLE);
    WgpuSetupExisting {
        instance: state.instance,
        adapter: state.adapter,
        device: state.device,
        queue: state.queue,
    }
});

/// The test harness's own setup without the fallback to OpenGL, which draws different pixels.
pub fn vulkan() -> WgpuSetup {
    let mut setup = egui_kittest::wgpu::default_wgpu_setup();
    if let WgpuSetup::CreateNew(new) = &mut setup {
        new.instance_descriptor.backends = wgpu::Backends::VULKAN;
    }
    setup
}

/// A window with a planned sample part.
pub fn with_sample(engine: Engine) -> Window {
    sample_in(window(engine))
}

/// Opens a sample part in a window, and plans it.
pub fn sample_in(mut window: Window) -> Window {
    window.state_mut().open_part(PartSource::Sample("impeller532".to_owned()));
    settle(&mut window);
    window
}

/// What takes longer hangs, on however busy a machine.
pub const HANG: Duration = Duration::from_secs(300);

/// Draws until all background tasks are done and their results are shown.
pub fn settle(window: &mut Window) {
    let start = Instant::now();
    window.step();
    // Handling a result may start another task.
    loop {
        while window.state().is_busy() {
            assert!(start.elapsed() < HANG, "the work does not end");
            // About the time of a frame, so that the task gets half of the processor.
            std::thread::sleep(Duration::from_millis(30));
            window.step();
        }
        window.run_steps(4);
        if window.state().is_busy() {
            continue;
        }
        // A fast task may have ended since the last frame: its result is handled in the next one.
        window.step();
        if !window.state().is_busy() {
            return;
        }
    }
}

/// Threshold and number of pixels that may differ between machines: anti-aliasing of text.
const UI: (f32, usize) = (0.6, 20);
/// Likewise for windows with a 3D view: edges of triangles.
const VIEW: (f32, usize) = (1.2, 400);

/// Compares a window without a 3D view with its snapshot.
pub fn snapshot_ui(window: &mut Window, name: &str) {
    snapshot(window, name, UI);
}

/// Compares a window with a 3D view with its snapshot.
pub fn snapshot_view(window: &mut Window, name: &str) {
    snapshot(window, name, VIEW);
}

/// [`snapshot_view`] with the status bar painted over from its left end: there stands a path that is another
/// in each run.
pub fn snapshot_view_without_path(window: &mut Window, name: &str) {
    use egui_kittest::kittest::Queryable;
    window.state_mut().draw_waiting_pictures();
    let text = window.get_by_label_contains("Wrote ").rect();
    let mut picture = window.render().expect("the window can be drawn");
    let (width, height) = picture.dimensions();
    for y in text.top() as u32..height.min(text.bottom().ceil() as u32) {
        for x in 0..width / 2 {
            picture.get_pixel_mut(x, y).0 = [128, 128, 128, 255];
        }
    }
    egui_kittest::image_snapshot_options(&picture, name, &options(VIEW));
}

fn snapshot(window: &mut Window, name: &str, tolerance: (f32, usize)) {
    window.state_mut().draw_waiting_pictures();
    window.snapshot_options(name, &options(tolerance));
}

fn options((threshold, pixels): (f32, usize)) -> SnapshotOptions {
    SnapshotOptions::new().threshold(threshold).max_failed_pixels(pixels)
}

/// The pixels of a part of the window, RGBA, row by row.
pub fn pixels_in(window: &mut Window, rect: egui::Rect) -> Vec<[u8; 4]> {
    window.state_mut().draw_waiting_pictures();
    let picture = window.render().expect("the window can be drawn");
    let (width, bytes) = (picture.width() as usize, picture.as_raw());
    let rows = rect.top() as usize..rect.bottom() as usize;
    let columns = rect.left() as usize..rect.right() as usize;
    let pixel = |i: usize, j: usize| std::array::from_fn(|k| bytes[4 * (i * width + j) + k]);
    rows.flat_map(|i| columns.clone().map(move |j| (i, j))).map(|(i, j)| pixel(i, j)).collect()
}

/// Clicks the left button at a point of the window.
pub fn press(window: &mut Window, at: egui::Pos2) {
    window.hover_at(at);
    window.run_steps(1);
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
        window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
    }
}

/// Clicks an item of the menu `File`, by a part of its label: that has its keys, too.
pub fn choose_in_file_menu(window: &mut Window, item: &str) {
    use egui_kittest::kittest::Queryable;
    window.get_by_label("File").click();
    window.run_steps(2);
    window.get_by_label_contains(item).click();
    window.run_steps(3);
}

/// Opens the list with this label and clicks one of its entries.
pub fn choose_in_list(window: &mut Window, list: &str, entry: &str) {
    use egui::accesskit::Role;
    use egui_kittest::kittest::Queryable;
    window.get_by_role_and_label(Role::ComboBox, list).click();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, entry).click();
    window.run_steps(3);
}

/// Types `text` into the field of this number among those of this name.
pub fn type_into(window: &mut Window, (field, number): (&str, usize), text: &str) {
    use egui::accesskit::Role;
    use egui_kittest::kittest::Queryable;
    let at = window.get_all_by_role_and_label(Role::SpinButton, field).nth(number).expect("a field").rect();
    press(window, at.center());
    window.run_steps(3);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text(text.to_owned()));
    window.run_steps(2);
    window.key_press(egui::Key::Enter);
    window.run_steps(4);
    settle(window);
}

/// Runs the first command that is found by `words`.
pub fn run_by_search(window: &mut Window, words: &str) {
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::K);
    window.run_steps(2);
    window.event(egui::Event::Text(words.to_owned()));
    window.run_steps(3);
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
}

/// Presses keys within one frame, as in a window that is drawn slowly.
pub fn press_at_once(window: &mut Window, keys: impl IntoIterator<Item = egui::Key>) {
    let events = keys.into_iter().flat_map(|key| {
        [true, false].map(|pressed| egui::Event::Key {
            key,
            pressed,
            modifiers: egui::Modifiers::NONE,
            repeat: false,
            physical_key: None,
        })
    });
    window.input_mut().events.extend(events);
    window.run_steps(3);
}

/// Clicks the enabled button with this label: the Cancel button of the status bar is disabled while nothing
/// runs.
pub fn click_enabled(window: &Window, label: &str) {
    use egui::accesskit::Role;
    use egui_kittest::kittest::{NodeT, Queryable};
    let mut buttons = window.get_all_by_role_and_label(Role::Button, label);
    let enabled = buttons.find(|button| !button.accesskit_node().is_disabled());
    enabled.expect("an enabled button").click();
}

/// Text of the label that contains `part`; `None` if there is none.
pub fn words(window: &Window, part: &str) -> Option<String> {
    use egui_kittest::kittest::{NodeT, Queryable};
    // The text of a label is its value.
    let label = window.query_by_label_contains(part)?;
    let node = label.accesskit_node();
    node.value().or_else(|| node.label())
}

/// Texts of all labels that begin with `start`: other than rows and buttons of that name.
pub fn labels(window: &Window, start: &str) -> Vec<String> {
    use egui::accesskit::Role;
    use egui_kittest::kittest::{NodeT, Queryable};
    let is_it = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == Role::Label;
    let text = |node: egui_kittest::Node<'_>| node.accesskit_node().value();
    let all = window.query_all_by(|node| node.value().is_some_and(|text| text.starts_with(start)));
    all.filter(is_it).filter_map(text).collect()
}

/// Turns the mouse wheel by `points` at the pointer, and runs `steps` frames.
pub fn turn_wheel(window: &mut Window, points: f32, steps: usize) {
    window.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, points),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    window.run_steps(steps);
}
