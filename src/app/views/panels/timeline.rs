//! The timeline: number of positions cut, to scrub and play.

use egui::containers::menu::MenuButton;
use egui::{Button, FontId, Rect, RichText, Sense, Slider, Stroke, Ui};

use super::flank_passes::describe;
use super::positions::cutter_tooltip;
use crate::app::model::figures::{format_clock, format_duration};
use crate::app::model::look::{Look, Operation};
use crate::app::model::machine::{AxisPositions, ProgramOnMachine};
use crate::app::model::number::with_minus_signs;
use crate::app::model::state::AppState;
use crate::app::model::state::Boundary;
use crate::app::model::units::DisplayUnits;
use crate::app::views::command::Command;
use crate::app::views::theme::{self, Condition};
use crate::report::words::NOT_ON_MACHINE;

/// Height of the timeline, points.
const HEIGHT: f32 = 34.0;
/// Width below which the buttons of its ends are left out, points.
const NARROW: f32 = 320.0;
/// Height of each line below it, of the program and of the machine, points.
const LINE_HEIGHT: f32 = 20.0;

/// Height of the panel, points.
pub fn height(state: &AppState) -> f32 {
    let has_machine = shows_axes(state);
    HEIGHT + LINE_HEIGHT * if has_machine { 2.0 } else { 1.0 }
}

/// Whether the axes of a machine are shown.
fn shows_axes(state: &AppState) -> bool {
    state.timeline_machine().is_some()
}

/// Draws the timeline, with the line of the program and the axes of the machine; returns the command that was
/// pressed.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<Command> {
    let (chosen, clock) = slider(ui, state);
    program_line(ui, state, clock);
    if shows_axes(state) {
        axes(ui, state);
    }
    chosen
}

/// The line of the exported program at the position of the timeline. It begins with the time `clock`, s, if
/// that does not fit beside the slider.
fn program_line(ui: &mut Ui, state: &AppState, clock: Option<f64>) {
    let Some(listing) = &state.results.listing else {
        ui.label(RichText::new("Program: listing…").weak());
        return;
    };
    let Some(line) = listing.line_after(state.timeline_cut()) else {
        ui.label(RichText::new("Program: not in it").weak())
            .on_hover_text("The exported program has no move for this place");
        return;
    };
    let clock = clock.map_or_else(String::new, |now| format!("{}  ", format_clock(now)));
    let text = format!("{clock}Line {line}: {}", listing.statement(line));
    let label = ui.add(egui::Label::new(RichText::new(text).monospace().size(12.0)).truncate());
    label.on_hover_ui(|ui| {
        ui.label(match state.look.operation {
            Operation::Program => "The checked program, at the position of the timeline",
            _ if state.shown_channels().is_some() => {
                "The exported APT program of the shown channels, at the position of the timeline"
            }
            _ => "The exported APT program of one channel, at the position of the timeline",
        });
        for number in line.saturating_sub(LINES_AROUND).max(1)..=line + LINES_AROUND {
            let Some(text) = listing.line(number) else { break };
            let text = RichText::new(format!("{number:>6}  {text}")).monospace().size(12.0);
            ui.label(if number == line { text.strong() } else { text.weak() });
        }
    });
}

/// Lines of the program that its tooltip shows before and after that of the timeline.
const LINES_AROUND: usize = 6;

/// Where the axes of the chosen machine stand at the position of the timeline, or why it cannot run the plan.
fn axes(ui: &mut Ui, state: &AppState) {
    if let Some((what, help)) = state.axes_fault() {
        let ink = Condition::Interfering.text(ui.visuals());
        let text = RichText::new(format!("{what}; {help}")).color(ink);
        ui.add(egui::Label::new(text).truncate()).on_hover_text(format!("{what}\nFix: {help}"));
        return;
    }
    match state.on_machine() {
        None => {
            ui.label(RichText::new("Axes: calculating…").weak());
        }
        Some(plan) => match plan.at(state.timeline_cut()) {
            None => {
                ui.label(RichText::new(&plan.machine.name).weak());
            }
            Some(at) => {
                let texts = axis_texts(plan, at, state.look.units);
                let font = FontId::monospace(AXES_SIZE);
                let glyph = ui.fonts_mut(|fonts| fonts.glyph_width(&font, '0'));
                let columns = (ui.available_width() / glyph.max(1.0)) as usize;
                let fitting = texts.iter().find(|text| text.chars().count() <= columns);
                let text = fitting.or(texts.last()).map_or("", String::as_str);
                let label = egui::Label::new(RichText::new(text).monospace().size(AXES_SIZE)).truncate();
                ui.add(label).on_hover_text(format!("{}\n{AXES_TIP}", texts[0]));
            }
        },
    }
}

/// Size of the text of the axes, points.
const AXES_SIZE: f32 = 12.0;

/// Positions of the axes, from the longest text to the shortest: in a narrow view no axis is cut off.
fn axis_texts(plan: &ProgramOnMachine, at: &AxisPositions, units: DisplayUnits) -> [String; 4] {
    let values = |width: usize, digits: usize, gap: &str| {
        let values = plan.named(at).map(|(name, value, unit)| match unit {
            "°" => {
                let value = with_minus_signs(&format!("{value:.digits$}"));
                format!("{name} {value:>width$}{unit}")
            }
            // Once for the three lengths.
            _ if name == 'Z' => {
                format!("{name} {:>width$} {}", units.number(value, digits), units.length_unit())
            }
            _ => format!("{name} {:>width$}", units.number(value, digits)),
        });
        values.join(gap)
    };
    // Padded, so that nothing jumps while the axes move.
    let padded = values(8, 3, "  ");
    [format!("{padded}  {}", plan.machine.name), padded, values(6, 1, " "), values(0, 1, " ")]
}

const AXES_TIP: &str = "Where the axes of the machine stand at the position of the timeline: machine coordinates\n\
     of the spindle nose, rotary axes as NC code commands them, else as `vanecut post` chooses them\n\
     over the whole program";

/// Draws buttons, slider and clock; returns the command that was pressed, and the time where the clock does
/// not fit.
fn slider(ui: &mut Ui, state: &mut AppState) -> (Option<Command>, Option<f64>) {
    let count = state.timeline_len();
    let (mut chosen, mut left_out) = (None, None);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let playing = state.look.playing.is_some();
        // In a narrow view the slider, whose ends these are, has priority.
        let is_narrow = ui.available_width() < NARROW;
        let commands =
            [Command::ToBlank, Command::StepBack, Command::Play, Command::StepForward, Command::ToEnd];
        let is_end = |command: &Command| matches!(command, Command::ToBlank | Command::ToEnd);
        for command in commands.into_iter().filter(|command| !(is_narrow && is_end(command))) {
            if icon(ui, command, playing, count > 0) {
                chosen = Some(command);
            }
        }
        let cut = state.timeline_cut().unwrap_or(count);
        let unit = if state.timeline_is_of_moves() { "moves" } else { "plunges" };
        let text = match (count, state.timeline_cut()) {
            (0, _) => format!("no {unit}"),
            (_, None) => format!("all {count}"),
            (_, Some(cut)) => format!("{cut} of {count}"),
        };
        let rate = state.play_rate() / state.look.play_speed;
        play_menu(ui, &mut state.look, rate, unit);
        // In a narrow view the slider has priority.
        let clock = state.clock().filter(|_| ui.available_width() > 300.0);
        left_out = state.clock().filter(|_| clock.is_none()).map(|(now, _)| now);
        // The widest that it becomes, so that the slider keeps its length.
        let widest = (theme::width_of_text(ui, &format!("{count} of {count}")) + 10.0).max(COUNT);
        let has_count = ui.available_width() > widest + MIN_SLIDER;
        let words = if has_count { widest } else { 0.0 } + if clock.is_some() { CLOCK } else { 0.0 };
        ui.spacing_mut().slider_width = (ui.available_width() - words - 8.0).max(20.0);
        let mut now = cut;
        let slider = Slider::new(&mut now, 0..=count.max(1))
            .show_value(false)
            .handle_shape(egui::style::HandleShape::Rect { aspect_ratio: 0.4 });
        let response = ui.add_enabled(count > 0, slider);
        response.widget_info(|| egui::WidgetInfo::slider(count > 0, cut as f64, "Timeline"));
        ticks(ui, response.rect, state);
        tooltip(&response, state);
        if now != cut {
            state.look.playing = None;
            state.set_timeline(Some(now));
        }
        if has_count {
            ui.add_space(4.0);
            ui.label(text);
        }
        if let Some((now, whole)) = clock {
            ui.add_space(6.0);
            let text = format!("{} of {}", format_clock(now), format_clock(whole));
            ui.label(RichText::new(text).weak()).on_hover_text(clock_tip(state, whole));
        }
    });
    (chosen, left_out)
}

/// What the clock counts; `whole`: time at the end of the timeline, s.
fn clock_tip(state: &AppState, whole: f64) -> String {
    let from = match state.machine_clock() {
        Some(_) => "on the machine, with tool changes and accelerations",
        None => "from feed rates and rapids; without tool changes and accelerations",
    };
    let wheel = match state.look.operation {
        Operation::Program => return format!("Time of the program up to here, {from}"),
        Operation::Flank => state.results.flank.as_ref().map(|outcome| outcome.wheel_time_s),
        Operation::Roughing => state.shown().map(|shown| {
            let channels = shown.planned.outcome.workpiece.part.blade_count;
            Some(shown.planned.result(shown.policy).summary.time_of_channels_s(channels, channels))
        }),
    };
    let wheel = wheel.unwrap_or(Some(whole)).map_or_else(|| NOT_ON_MACHINE.to_owned(), format_duration);
    let of_flank = state.results.flank_run.as_ref();
    let of_flank = of_flank.filter(|run| state.look.operation == Operation::Flank && run.count() > 1);
    let several = state.shown_channels().map(|channels| (channels.count(), channels.order()));
    let of = match several.or_else(|| of_flank.map(|run| (run.count(), run.order()))) {
        Some((count, order)) => format!("{count} channels, {},", order.words()),
        None => "one channel".to_owned(),
    };
    format!("Time of {of} up to here, {from}\nWhole wheel: {wheel}")
}

/// What is cut at the place of the timeline under the pointer.
fn tooltip(response: &egui::Response, state: &AppState) {
    let Some(at) = response.hover_pos().filter(|_| !response.dragged()) else { return };
    let count = state.timeline_len();
    let Some(last) = count.checked_sub(1) else { return };
    let (left, right) = ends_of_slider(response.rect);
    let share = ((at.x - left) / (right - left).max(1.0)).clamp(0.0, 1.0);
    let k = ((share * count as f32).ceil() as usize).saturating_sub(1).min(last);
    response.clone().on_hover_ui_at_pointer(|ui| match state.look.operation {
        Operation::Flank => {
            let passes = &state.results.passes;
            let pass = passes.pass_after(k + 1).and_then(|k| Some((k, passes.passes.get(k)?)));
            match pass {
                Some((number, pass)) => describe(ui, state, number, pass),
                None => {
                    ui.label("Before the first pass");
                }
            }
        }
        Operation::Program => {
            let Some(checked) = &state.results.checked else { return };
            if let Some(line) = checked.listing.line_after(Some(k + 1)) {
                ui.label(RichText::new(format!("Line {line}")).strong());
                ui.label(RichText::new(checked.listing.statement(line)).monospace());
            }
            if let Some(time) = state.time_after(k + 1) {
                ui.label(format!("After {}", format_clock(time)));
            }
        }
        Operation::Roughing => {
            let Some((position, channel)) = state.position_of_step(k) else { return };
            if state.shown_channels().is_some() {
                ui.label(RichText::new(format!("Channel {channel}")).strong());
            }
            cutter_tooltip(ui, state, state.look.side, position, channel - 1);
        }
    });
}

/// Where a slider of this area has its ends, points.
fn ends_of_slider(rect: Rect) -> (f32, f32) {
    let inset = rect.height() * 0.2;
    (rect.left() + inset, rect.right() - inset)
}

/// Least width of the count, points.
const COUNT: f32 = 74.0;
/// Least width of the slider beside the count, points.
const MIN_SLIDER: f32 = 40.0;
/// Width of the clock, points.
const CLOCK: f32 = 136.0;

/// Speeds of playing.
const SPEEDS: [(f64, &str); 5] = [(0.25, "¼×"), (1.0, "1×"), (4.0, "4×"), (16.0, "16×"), (64.0, "64×")];

/// Menu of speed and loop of playing; `rate`: number of `unit` per second at speed 1.
fn play_menu(ui: &mut Ui, look: &mut Look, rate: f64, unit: &str) {
    let now = SPEEDS.iter().find(|(speed, _)| *speed == look.play_speed).map_or("1×", |(_, name)| name);
    let (menu, _) = MenuButton::new(now).ui(ui, |ui| {
        for (speed, name) in SPEEDS {
            let tip = format!("{} {unit} per second", rate * speed);
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

/// Marks above the slider at positions that are not sound, and moves with a fault; below it where a section
/// or layer begins, longer at a change of the tool.
fn ticks(ui: &Ui, rect: Rect, state: &AppState) {
    let count = state.timeline_len();
    let (left, right) = ends_of_slider(rect);
    let place = |k: usize| egui::lerp(left..=right, k as f32 / count.max(1) as f32);
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
    let mark = |k: usize, of: Condition| {
        let x = place(k + 1);
        let line = [egui::pos2(x, rect.top() - 2.0), egui::pos2(x, rect.top() + 3.0)];
        ui.painter().line_segment(line, Stroke::new(1.0, of.mark()));
    };
    match (state.look.operation, state.shown(), &state.results.flank_run) {
        (Operation::Flank, _, Some(run)) => {
            run.faulty.iter().for_each(|&step| mark(step, Condition::Interfering));
        }
        (Operation::Roughing, Some(shown), _) => {
            let positions = &shown.plan().positions;
            let condition =
                |k: usize| state.position_of_step(k).map(|(position, _)| positions[position].condition());
            let faulty = (0..count).filter_map(|k| Some((k, condition(k)?)));
            faulty.filter(|(_, of)| *of != Condition::Sound).for_each(|(k, of)| mark(k, of));
        }
        (Operation::Program, ..) => {
            let findings = state.results.checked.iter().flat_map(|checked| &checked.findings);
            let places = findings.filter_map(|finding| finding.first_move);
            places.for_each(|index| mark(index, Condition::Interfering));
        }
        _ => {}
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
