//! Plot of both rotary axes of the machine over the program, with the position of the timeline. A click moves
//! the timeline there.

use egui::text::LayoutJob;
use egui::{Align, Align2, Color32, FontId, Rect, Sense, Stroke, Ui};

use super::plots::PositionScale;
use crate::app::model::machine::{AxisPositions, ProgramOnMachine};
use crate::app::model::number::with_minus_signs;
use crate::app::model::state::AppState;
use crate::app::model::state::Boundary;
use crate::app::views::command::Command;
use crate::app::views::theme;
use crate::palette::category;

/// Height of the plot, points.
pub const HEIGHT: f32 = 66.0;

/// Name for assistive technology.
const NAME: &str = "Rotary axes over the program";
/// Space beside a text in place of the plot, points.
const MARGIN: f32 = 5.0;
/// Height of the line with names and ranges, points.
const HEAD: f32 = 18.0;
/// Shortest scale, degrees, so that rounding is not magnified.
const MIN_RANGE: f64 = 1.0;

/// A rotary axis over the program.
struct AxisCurve {
    letter: char,
    colour: Color32,
    /// Degrees at the end of each step of the timeline; NaN where it is not known.
    values: Vec<f64>,
    /// Ends of its scale, degrees.
    range: (f64, f64),
}

impl AxisCurve {
    fn from_plan(plan: &ProgramOnMachine, axis: usize, colour: Color32) -> Self {
        let value = |at: &Option<_>| {
            at.as_ref().map_or(f64::NAN, |at: &AxisPositions| at.pose.angles[axis].to_degrees())
        };
        let values: Vec<f64> = plan.ends.iter().map(value).collect();
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        let range = (low, high.max(low + MIN_RANGE));
        Self { letter: plan.machine.rotary[axis].letter, colour, values, range }
    }

    /// Indices of the values that a line of `width` points shows: all known ones, or of many the lowest and
    /// the highest of each half point.
    fn drawn(&self, width: f32) -> Vec<usize> {
        let bins = (2.0 * width.max(1.0)) as usize;
        let known = |k: &usize| self.values[*k].is_finite();
        if self.values.len() <= 2 * bins {
            return (0..self.values.len()).filter(known).collect();
        }
        let size = self.values.len().div_ceil(bins);
        let of_bin = |start: usize| {
            let bin = || (start..(start + size).min(self.values.len())).filter(known);
            let by_value = |a: &usize, b: &usize| self.values[*a].total_cmp(&self.values[*b]);
            let (low, high) = (bin().min_by(by_value)?, bin().max_by(by_value)?);
            Some(if low < high { [low, high] } else { [high, low] })
        };
        let mut drawn: Vec<usize> =
            (0..self.values.len()).step_by(size).filter_map(of_bin).flatten().collect();
        drawn.dedup();
        drawn
    }
}

/// Writes `text` in the middle of `rect`, in as many lines as fit.
fn say_in(ui: &Ui, rect: Rect, text: String) {
    let (font, ink) = (FontId::proportional(theme::MIN_TEXT_SIZE), ui.visuals().weak_text_color());
    let line = ui.fonts_mut(|fonts| fonts.row_height(&font));
    let mut job = LayoutJob::simple(text, font, ink, rect.width() - 2.0 * MARGIN);
    job.halign = Align::Center;
    job.wrap.max_rows = ((rect.height() / line) as usize).max(1);
    let galley = ui.painter().layout_job(job);
    let top = rect.center().y - 0.5 * galley.size().y;
    ui.painter_at(rect).galley(egui::pos2(rect.center().x, top), galley, ink);
}

/// Draws the plot; a click moves the timeline. Returns a command from the context menu, with the position it
/// is for.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<(Command, usize)> {
    let size = egui::vec2(ui.available_width(), ui.available_height().min(HEIGHT));
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, NAME));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let Some(plan) = state.on_machine().filter(|plan| !plan.ends.is_empty()) else {
        let fault = state.axes_fault();
        let tip = fault.as_ref().map(|(what, help)| format!("{what}\nFix: {help}"));
        let text =
            fault.map_or_else(|| "Axes: calculating…".to_owned(), |(what, help)| format!("{what}; {help}"));
        say_in(ui, rect, text.clone());
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("{NAME}: {text}")));
        if let Some(tip) = tip {
            response.on_hover_text(tip);
        }
        return None;
    };
    // The second is too pale on a light ground.
    let classes = if ui.visuals().dark_mode { [0, 1] } else { [3, 2] };
    let colours = classes.map(|k| theme::colour(category(k)));
    let axes = plan.rotary_by_letter();
    let curves = [0, 1].map(|k| AxisCurve::from_plan(plan, axes[k], colours[k]));
    let count = plan.ends.len();
    let inner = Rect::from_min_max(rect.min + egui::vec2(5.0, HEAD), rect.max - egui::vec2(5.0, 5.0));
    let scale = PositionScale { inner, count };
    let vertical = |k: usize, stroke: Stroke| {
        painter.vline(scale.place(k, 0.0).x, inner.y_range(), stroke);
    };
    let faint = ui.visuals().weak_text_color().gamma_multiply(0.4);
    for k in state.boundaries(Boundary::Section).into_iter().filter(|&k| k > 0) {
        vertical(k, Stroke::new(1.0, faint));
    }
    let now = state.timeline_cut().map_or(count, |cut| cut.min(count)).checked_sub(1);
    let accent = theme::accent(ui.visuals());
    if let Some(k) = now {
        vertical(k, Stroke::new(1.0, accent));
    }
    let font = FontId::proportional(theme::MIN_TEXT_SIZE);
    let mut at = rect.min + egui::vec2(5.0, 3.0);
    for curve in &curves {
        let (low, high) = curve.range;
        let place = |k: usize, v: f64| scale.place(k, ((v - low) / (high - low)) as f32);
        let line = curve.drawn(inner.width()).into_iter().map(|k| place(k, curve.values[k])).collect();
        painter.line(line, Stroke::new(1.4, curve.colour));
        if let Some((k, &v)) =
            now.and_then(|k| Some((k, curve.values.get(k)?))).filter(|(_, v)| v.is_finite())
        {
            painter.circle_filled(place(k, v), 2.5, curve.colour);
        }
        let swatch = Rect::from_min_size(at + egui::vec2(0.0, 2.0), egui::vec2(9.0, 9.0));
        painter.rect_filled(swatch, 2.0, curve.colour);
        let text = with_minus_signs(&format!("{} {low:.1}° to {high:.1}°", curve.letter));
        let ink = ui.visuals().text_color();
        let drawn = painter.text(at + egui::vec2(13.0, 0.0), Align2::LEFT_TOP, text, font.clone(), ink);
        at.x = drawn.right() + 16.0;
    }
    if let Some(k) = response.hover_pos().map(|at| scale.near(at)) {
        let values = curves.iter().map(|curve| format!("{} {:.3}°", curve.letter, curve.values[k]));
        let step = match state.shown_channels() {
            Some(_) => "Plunge",
            None if state.timeline_is_of_moves() => "Move",
            None => "Position",
        };
        let text = format!("{step} {}: {}", k + 1, values.collect::<Vec<_>>().join(", "));
        response.clone().on_hover_text_at_pointer(with_minus_signs(&text));
    }
    if let Some(k) = scale.clicked(&response) {
        state.look.playing = None;
        state.set_timeline(Some(k + 1));
    }
    // Moves have no commands of their own, nor have plunges of other channels.
    if state.timeline_is_of_moves() || state.shown_channels().is_some() {
        None
    } else {
        scale.picked(ui, &response, 0).menu
    }
}
