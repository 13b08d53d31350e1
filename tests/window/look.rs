//! The window at two scalings and in both themes, idle, and as a picture file.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::part_source::PartSource;
use vanecut::app::model::units::DisplayUnits;
use vanecut::drawing::flank::FlankColours;

use crate::fake;
use crate::flank::{plan_flank, with_plan};
use crate::harness::{
    Window, click_enabled, pixels_in, press, sample_in, scaled, settle, snapshot_view, turn_wheel, window,
    with_sample,
};

#[test]
fn both_themes_on_an_ordinary_screen() {
    both_themes_at(1.0);
}

#[test]
fn both_themes_on_a_dense_screen() {
    both_themes_at(1.5);
}

fn both_themes_at(scale: f32) {
    let (engine, _) = fake::engine();
    let mut window = sample_in(scaled(engine, scale));
    window.key_press(egui::Key::Num4);
    for (theme, name) in [(egui::Theme::Dark, "dark"), (egui::Theme::Light, "light")] {
        window.ctx.set_theme(theme);
        window.run_steps(6);
        assert_eq!(
            window.ctx.content_rect().size(),
            egui::vec2(900.0, 600.0),
            "the same room for everything"
        );
        snapshot_view(&mut window, &format!("{name}_at_{}", scale * 100.0));
    }
}

#[test]
fn at_rest_nothing_is_drawn() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.run_steps(20);
    assert!(window.run_ok().is_some_and(|steps| steps <= 2), "it comes to rest");
    assert!(!window.ctx.has_requested_repaint(), "and asks for nothing more");
}

#[test]
fn pictures_have_the_size_and_the_background_that_were_asked_for() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let folder = tempfile::tempdir().expect("a folder");
    window.key_press_modifiers(egui::Modifiers::COMMAND | egui::Modifiers::SHIFT, egui::Key::E);
    window.run_steps(3);
    window.get_by_label("Current view size").click();
    window.run_steps(2);
    window.get_by_label("Transparent background").click();
    window.get_by_label("Include legend").click();
    window.run_steps(2);
    click_enabled(&window, "Cancel");
    window.run_steps(2);
    let settings = window.state_mut().export_settings_mut();
    assert!(settings.size.is_some() && settings.transparent && settings.legend, "{settings:?}");
    settings.size = Some([640, 400]);
    let save = |window: &mut Window, name: &str| {
        let path = folder.path().join(name);
        let ctx = window.ctx.clone();
        window.state_mut().file_chosen(&ctx, Purpose::SavePicture, path.clone());
        settle(window);
        let bytes = std::fs::read(path).expect("a picture");
        let side = |at: usize| u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        ((side(16), side(20)), bytes.len())
    };
    let (size, transparent) = save(&mut window, "a.png");
    assert_eq!(size, (640, 400));
    let settings = window.state_mut().export_settings_mut();
    (settings.size, settings.transparent) = (Some([1280, 800]), false);
    let (size, opaque) = save(&mut window, "b.png");
    assert_eq!(size, (1280, 800));
    assert_ne!(transparent, opaque);
}

/// A picture of a view with both plans has both.
#[test]
fn pictures_of_both_plans_have_both() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("view.png");
    let saved = |window: &mut Window| {
        window.state_mut().export_settings_mut().size = Some([600, 400]);
        let ctx = window.ctx.clone();
        window.state_mut().file_chosen(&ctx, Purpose::SavePicture, path.clone());
        settle(window);
        let mut reader =
            png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).expect("a file")))
                .read_info()
                .expect("a PNG file");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let frame = reader.next_frame(&mut pixels).expect("a picture");
        assert_eq!((frame.width, frame.height), (600, 400));
        let row = pixels.len() / 400;
        let half = |first: usize| -> Vec<u8> {
            pixels.chunks(row).flat_map(|line| line[first..first + row / 2].to_vec()).collect()
        };
        [half(0), half(row / 2)]
    };
    let after = saved(&mut window);
    window.key_press(egui::Key::B);
    window.run_steps(3);
    let before = saved(&mut window);
    assert!(before[0] != after[0] && before[1] != after[1]);
    window.get_by_label("Wipe").click();
    window.run_steps(3);
    assert!(saved(&mut window) == [before[0].clone(), after[1].clone()]);
    window.get_by_label("Both").click();
    window.run_steps(3);
    let [left, right] = saved(&mut window);
    assert!(left != before[0] && right != after[1] && left != right);
}

/// What stands last in the setup is not under a bar that only the rounding of a dense screen would need.
#[test]
fn the_last_button_of_the_setup_takes_clicks_on_a_dense_screen() {
    let (engine, _) = fake::engine();
    let mut window = sample_in(scaled(engine, 1.5));
    // 1360 × 880 pixels.
    window.set_size(egui::vec2(1360.0, 880.0) / 1.5);
    window.run_steps(4);
    window.hover_at(egui::pos2(60.0, 300.0));
    for _ in 0..20 {
        turn_wheel(&mut window, -400.0, 4);
    }
    let button = window.get_by_role_and_label(Role::Button, "Edit tools and sections").rect();
    let at = egui::pos2(button.center().x, button.bottom() - 3.0);
    // Near a bar it grows.
    window.hover_at(at);
    window.run_steps(4);
    press(&mut window, at);
    window.run_steps(4);
    assert!(!window.state().state().document.edited.setup.tools.is_empty(), "clicked at {at} of {button}");
}

/// Number of pixels of the box of an entry that stand out from what is around it.
fn seen(window: &mut Window, entry: &str) -> usize {
    let rect = window.get_by_role_and_label(Role::CheckBox, entry).rect();
    let pixels = pixels_in(window, rect.with_max_x(rect.left() + rect.height()));
    let light = |pixel: &[u8; 4]| {
        let linear = |byte: u8| ((f64::from(byte) / 255.0 + 0.055) / 1.055).powf(2.4);
        0.2126 * linear(pixel[0]) + 0.7152 * linear(pixel[1]) + 0.0722 * linear(pixel[2]) + 0.05
    };
    let ground = light(&pixels[0]);
    pixels.iter().map(light).filter(|light| light.max(ground) / light.min(ground) >= 2.0).count()
}

#[test]
fn boxes_without_a_mark_are_seen_in_menus() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    for theme in [egui::Theme::Dark, egui::Theme::Light] {
        window.ctx.set_theme(theme);
        window.run_steps(2);
        window.get_by_role_and_label(Role::Button, "Layers").click();
        window.run_steps(3);
        let count = seen(&mut window, "Shroud");
        assert!(count > 20, "{theme:?}: {count}");
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
    }
}

/// Texts of the legend and beside the timeline that do not end within the view.
fn cut_off(window: &Window) -> Vec<String> {
    let view = window.get_by_label("3D view").rect();
    let is_below = |at: &egui::Rect| {
        view.x_range().contains(at.left()) && (view.bottom()..view.bottom() + 64.0).contains(&at.center().y)
    };
    let texts = window.query_all_by(|node| matches!(node.role(), Role::Label | Role::Button));
    let texts: Vec<_> = texts.filter(|text| is_below(&text.rect())).collect();
    assert!(texts.len() > 2, "{} texts", texts.len());
    let is_cut = |text: &egui_kittest::Node<'_>| text.rect().right() > view.right();
    texts
        .iter()
        .filter(|text| is_cut(text))
        .map(|text| format!("{:?}", text.accesskit_node().value()))
        .collect()
}

/// Where the names of the regions do not fit beside each other, they are those of the table of passes.
#[test]
fn the_regions_beside_a_splitter_are_named_in_a_narrow_view() {
    let (engine, _) = fake::engine();
    let mut window = window(engine);
    window.state_mut().open_part(PartSource::Sample("impeller9x9".to_owned()));
    settle(&mut window);
    window.set_size(egui::vec2(907.0, 587.0));
    window.run_steps(3);
    plan_flank(&mut window, 6.0);
    window.state_mut().look_mut().flank.colours = FlankColours::Region;
    window.run_steps(6);
    assert_eq!(cut_off(&window), [""; 0]);
}

#[test]
fn nothing_below_a_narrow_view_is_cut_off() {
    let mut window = with_plan();
    window.state_mut().look_mut().flank.colours = FlankColours::Region;
    let count = window.state().state().timeline_len();
    window.get_by_role_and_label(Role::Slider, "Timeline").set_value_accesskit((count - 1) as f64);
    let sizes = [850.0, 907.0, 950.0, 1000.0];
    for width in sizes {
        window.set_size(egui::vec2(width, 587.0));
        window.run_steps(6);
        assert_eq!(cut_off(&window), [""; 0], "flank, {width}");
    }
    // The button that fits the scale comes to it; numbers are longer in inches.
    window.get_by_label_contains("Roughing: ").click();
    window.state_mut().look_mut().range = Some((0.0, 9.0));
    for units in [DisplayUnits::Metric, DisplayUnits::Inch] {
        window.state_mut().look_mut().units = units;
        for width in sizes {
            window.set_size(egui::vec2(width, 587.0));
            window.run_steps(6);
            settle(&mut window);
            assert_eq!(cut_off(&window), [""; 0], "roughing, {units:?}, {width}");
        }
        window.get_by_label("Fit scale");
    }
}

/// The name of a strategy in files is another than in the window.
#[test]
fn the_name_of_a_strategy_in_files_is_under_the_pointer() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 900.0));
    window.run_steps(3);
    let names = window
        .query_all_by(|node| node.role() == Role::Label && node.value().as_deref() == Some("Min. stock"));
    let at: Vec<egui::Pos2> = names.map(|node| node.rect().center()).collect();
    let view = window.get_by_label("3D view").rect();
    let mut in_view = at.into_iter().filter(|at| view.contains(*at)).peekable();
    assert!(in_view.peek().is_some());
    for at in in_view {
        window.hover_at(at);
        window.run_steps(20);
        window.get_by_label_contains("In files and on the command line: minimal");
        window.hover_at(egui::pos2(5.0, 5.0));
        window.run_steps(8);
    }
}
