//! The timeline: number of positions cut, to scrub and play.

use egui::containers::menu::MenuButton;
use egui::{Button, Rect, RichText, Sense, Slider, Stroke, Ui};

use crate::app::model::figures::{format_clock, format_duration};
use crate::app::model::look::Look;
use crate::app::model::state::{AppState, Boundary, PLAY_RATE};
use crate::app::views::command::Command;
use crate::app::views::theme::Condition;

/// Height of the timeline, points.
const HEIGHT: f32 = 34.0;
/// Height of the line of the machine below it, points.
const AXES_HEIGHT: f32 = 20.0;

/// Height of the panel, points.
pub fn height(state: &AppState) -> f32 {
    if state.document.edited.setup.machine.file.is_some() { HEIGHT + AXES_HEIGHT } else { HEIGHT }
}

/// Draws the timeline, with the axes of the machine; returns the command that was pressed.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<Command> {
    let chosen = slider(ui, state);
    if state.document.edited.setup.machine.file.is_some() {
        axes(ui, state);
    }
    chosen
}

/// Where the axes of the chosen machine stand at the position of the timeline, or why it cannot run the plan.
fn axes(ui: &mut Ui, state: &AppState) {
    let line = |ui: &mut Ui, text: String, tip: &str| {
        let text = RichText::new(text).color(Condition::Interfering.text(ui.visuals()));
        ui.add(egui::Label::new(text).truncate()).on_hover_text(tip);
    };
    match &state.results.on_machine {
        None => {
            ui.label(RichText::new("Axes: calculating…").weak());
        }
        Some(Err(error)) => line(ui, error.message.clone(), &error.help),
        Some(Ok(plan)) => match (&plan.fault, plan.at(state.look.cut_count)) {
            (Some((what, help)), _) => {
                line(ui, format!("{}: {what}", plan.machine.name), &format!("{what}\nTo do: {help}"));
            }
            (None, None) => {
                ui.label(RichText::new(&plan.machine.name).weak());
            }
            (None, Some(at)) => {
                // Padded, so that nothing jumps while the axes move.
                let values = plan.named(at).map(|(name, value, unit)| format!("{name} {value:>8.3}{unit}"));
                let text = RichText::new(format!("{}  {}", values.join("  "), plan.machine.name));
                ui.add(egui::Label::new(text.monospace().size(12.0)).truncate()).on_hover_text(AXES_TIP);
            }
        },
    }
}

const AXES_TIP: &str = "Where the axes of the machine stand at the position of the timeline: machine coordinates\n\
     of the spindle nose in mm, rotary axes as the program commands them, chosen over the whole program";

fn slider(ui: &mut Ui, state: &mut AppState) -> Option<Command> {
    let count = state.position_count();
    let mut chosen = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let playing = state.look.playing.is_some();
        for command in
            [Command::ToBlank, Command::StepBack, Command::Play, Command::StepForward, Command::ToEnd]
        {
            if icon(ui, command, playing, count > 0) {
                chosen = Some(command);
            }
        }
        let cut = state.look.cut_count.unwrap_or(count);
        let text = match (count, state.look.cut_count) {
            (0, _) => "no positions".to_owned(),
            (_, None) => format!("all {count}"),
            (_, Some(cut)) => format!("{cut} of {count}"),
        };
        play_menu(ui, &mut state.look);
        // In a narrow view the slider has priority.
        let clock = state.clock().filter(|_| ui.available_width() > 300.0);
        let words = if clock.is_some() { 74.0 + CLOCK } else { 74.0 };
        ui.spacing_mut().slider_width = (ui.available_width() - words - 8.0).max(20.0);
        let mut now = cut;
        let slider = Slider::new(&mut now, 0..=count.max(1))
            .show_value(false)
            .handle_shape(egui::style::HandleShape::Rect { aspect_ratio: 0.4 });
        let response = ui.add_enabled(count > 0, slider);
        response.widget_info(|| egui::WidgetInfo::slider(count > 0, cut as f64, "Timeline"));
        ticks(ui, response.rect, state);
        if now != cut {
            state.look.playing = None;
            state.set_timeline(Some(now));
        }
        ui.add_space(4.0);
        ui.label(text);
        if let Some((now, whole)) = clock {
            ui.add_space(6.0);
            let text = format!("{} of {}", format_clock(now), format_clock(whole));
            let part = state.document.part.as_ref();
            let wheel = part.map_or(1.0, |part| part.impeller.blade_count as f64) * whole;
            ui.label(RichText::new(text).weak()).on_hover_text(format!(
                "Time of one channel up to here, from feed rates and rapids; without tool changes\n\
                 Whole wheel: {}",
                format_duration(wheel)
            ));
        }
    });
    chosen
}

/// Width of the clock, points.
const CLOCK: f32 = 136.0;

/// Speeds of playing.
const SPEEDS: [(f64, &str); 5] = [(0.25, "¼×"), (1.0, "1×"), (4.0, "4×"), (16.0, "16×"), (64.0, "64×")];

/// Menu of speed and loop of playing.
fn play_menu(ui: &mut Ui, look: &mut Look) {
    let now = SPEEDS.iter().find(|(speed, _)| *speed == look.play_speed).map_or("1×", |(_, name)| name);
    let (menu, _) = MenuButton::new(now).ui(ui, |ui| {
        for (speed, name) in SPEEDS {
            let rate = PLAY_RATE * speed;
            let tip = format!("{rate} plunges per second");
            if ui.radio(look.play_speed == speed, name).on_hover_text(tip).clicked() {
                look.play_speed = speed;
                ui.close();
            }
        }
        ui.separator();
        ui.checkbox(&mut look.play_loop, "Loop").on_hover_text("Starts again at the end");
    });
    menu.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Play speed"));
    menu.on_hover_text("Speed and loop of playing");
}

/// Marks above the slider at positions that are not sound; below it where a section begins, longer at a
/// change of the tool.
fn ticks(ui: &Ui, rect: Rect, state: &AppState) {
    let Some(shown) = state.shown() else { return };
    let positions = &shown.plan().positions;
    let inset = rect.height() * 0.2;
    let place =
        |k: usize| egui::lerp(rect.left() + inset..=rect.right() - inset, k as f32 / positions.len() as f32);
    let ink = ui.visuals().text_color();
    for (of, length) in [(Boundary::Section, 4.0), (Boundary::Tool, 7.0)] {
        for k in state.boundaries(of).into_iter().filter(|&k| k > 0) {
            let line = [
                egui::pos2(place(k), rect.bottom() - 2.0),
                egui::pos2(place(k), rect.bottom() - 2.0 + length),
            ];
            ui.painter().line_segment(line, Stroke::new(1.5, ink));
        }
    }
    for (k, position) in positions.iter().enumerate() {
        let of = position.condition();
        if of != Condition::Sound {
            let x = place(k + 1);
            let line = [egui::pos2(x, rect.top() - 2.0), egui::pos2(x, rect.top() + 3.0)];
            ui.painter().line_segment(line, Stroke::new(1.0, of.mark()));
        }
    }
}

/// A button with a drawn icon, as the fonts have no media symbols.
fn icon(ui: &mut Ui, command: Command, playing: bool, enabled: bool) -> bool {
    let size = egui::vec2(24.0, 22.0);
    let response = ui.add_enabled(enabled, Button::new("").min_size(size).sense(Sense::click()));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, command.label()));
    let visuals = ui.style().interact(&response);
    let ink = if enabled { visuals.fg_stroke.color } else { ui.visuals().weak_text_color() };
    let (middle, painter) = (response.rect.center(), ui.painter());
    let triangle = |x: f32, way: f32| {
        let at = |dx: f32, dy: f32| middle + egui::vec2(x + dx * way, dy);
        let corners = vec![at(-3.0, -5.0), at(4.0, 0.0), at(-3.0, 5.0)];
        painter.add(egui::Shape::convex_polygon(corners, ink, Stroke::NONE));
    };
    let bar = |x: f32| {
        let at = Rect::from_center_size(middle + egui::vec2(x, 0.0), egui::vec2(2.0, 10.0));
        painter.rect_filled(at, 0.0, ink);
    };
    match command {
        Command::ToBlank => {
            bar(-5.0);
            triangle(1.0, -1.0);
        }
        Command::ToEnd => {
            bar(5.0);
            triangle(-1.0, 1.0);
        }
        Command::StepBack => {
            bar(4.0);
            triangle(-1.0, -1.0);
        }
        Command::StepForward => {
            bar(-4.0);
            triangle(1.0, 1.0);
        }
        _ if playing => {
            bar(-2.5);
            bar(2.5);
        }
        _ => triangle(0.0, 1.0),
    }
    response.on_hover_text(command.tip_with_keys(ui.ctx())).clicked()
}
