//! Plots along the row of the selected position: lead angle, contact, residual stock, step, engaged arc,
//! thickness of the chip. A click selects.

use std::sync::Arc;

use egui::text::{LayoutJob, TextWrapping};
use egui::{Align2, FontId, Galley, PointerButton, Popup, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

use crate::plunge::inspect::{row_of, step_before};

use super::positions::position_menu;
use crate::app::model::number::with_minus_signs;
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::app::views::command::Command;
use crate::app::views::theme::{self, Condition};

/// Height of the plots, points.
pub const HEIGHT: f32 = 92.0;

/// The thickness of the chip: hundredths of a mm.
const CHIP: &str = "Chip";
/// The engaged arc.
const ARC: &str = "Arc";
/// Between plots, points.
const GAP: f32 = 6.0;
/// Plots narrower than this do not show their range, points.
const NARROW: f32 = 112.0;
/// In plots narrower than this the value is below the name, points.
const TIGHT: f32 = 80.0;
/// Margins of the head of a plot, and between its name and value, points.
const HEAD_MARGINS: f32 = 15.0;
/// Margin of texts at the sides of a plot, points.
const SIDE_MARGIN: f32 = 5.0;
/// Height of a line of text, points.
const LINE: f32 = 12.0;

/// One plotted quantity with its scale.
struct PlotCurve {
    name: &'static str,
    unit: &'static str,
    /// Units whose decimals its numbers have, and the decimals of the selected value in metric ones.
    decimals: DisplayUnits,
    digits: usize,
    from_zero: bool,
    /// Minimum length of the scale, so that noise is not magnified.
    min_range: f64,
    /// Index of the row's first position.
    first: usize,
    values: Vec<f64>,
}

/// Draws the plots; a click on one selects the position there. Returns a command from the context menu of a
/// plot, with the position it is for.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<(Command, usize)> {
    let shown = state.shown()?;
    let plan = shown.plan();
    let index = state.look.selected.unwrap_or(0);
    let row = row_of(plan, index);
    if row.is_empty() {
        return None;
    }
    let curve = |name: &'static str, unit, (from_zero, least), value: &dyn Fn(usize) -> f64| PlotCurve {
        name,
        unit,
        decimals: if unit == " in" { DisplayUnits::Inch } else { DisplayUnits::Metric },
        digits: match name {
            CHIP => 4,
            // It is known to ten degrees.
            ARC => 0,
            _ => 2,
        },
        from_zero,
        min_range: least,
        first: row.start,
        values: row.clone().map(value).collect(),
    };
    let at = |k: usize| &plan.positions[k];
    let units = state.look.units;
    let unit = match units {
        DisplayUnits::Metric => " mm",
        DisplayUnits::Inch => " in",
    };
    let range = |mm: f64| (true, units.of_mm(mm));
    let curves = [
        curve("Lead angle", "°", (false, 1.0), &|k| at(k).alpha_rad.to_degrees()),
        curve("Contact", unit, range(0.1), &|k| units.of_mm(at(k).evaluation.contact.depth)),
        curve("Stock", unit, range(0.1), &|k| units.of_mm(shown.stock(k).into())),
        curve("Step", unit, range(0.1), &|k| units.of_mm(step_before(plan, k))),
        curve(ARC, "°", (true, 30.0), &|k| at(k).evaluation.engagement.max_arc_rad.to_degrees()),
        curve(CHIP, unit, range(0.02), &|k| units.of_mm(plan.chip_thickness_of(k).unwrap_or(f64::NAN))),
    ];
    let faulty: Vec<bool> = row.clone().map(|k| at(k).condition() == Condition::Interfering).collect();
    let (mut clicked, mut menu) = (None, None);
    let (columns, size) = arranged(ui.available_size(), curves.len());
    ui.spacing_mut().item_spacing = Vec2::splat(GAP);
    for curves in curves.chunks(columns) {
        ui.horizontal(|ui| {
            for curve in curves {
                let chosen =
                    row.contains(&index).then(|| index - row.start).filter(|_| state.look.selected.is_some());
                let picked = plot(ui, size, curve, &faulty, chosen);
                clicked = picked.clicked.map(|k| row.start + k).or(clicked);
                menu = picked.menu.map(|(command, k)| (command, row.start + k)).or(menu);
            }
        });
    }
    if clicked.is_some() {
        state.look.select(clicked);
    }
    menu
}

/// How many of `count` plots stand side by side in a panel, and the size of each: all of them, unless they
/// would be too narrow and the panel is high enough for more rows.
fn arranged(panel: Vec2, count: usize) -> (usize, Vec2) {
    let width = |columns: usize| (panel.x - (columns - 1) as f32 * GAP) / columns as f32;
    let rows = |columns: usize| count.div_ceil(columns);
    let high = |columns: usize| (rows(columns) as f32) * (HEIGHT + GAP) - GAP;
    let mut columns = count;
    while let Some(fewer) = (1..columns).rev().find(|fewer| rows(*fewer) > rows(columns)) {
        if width(columns) >= NARROW || high(fewer) > panel.y {
            break;
        }
        // As many in each row.
        columns = count.div_ceil(rows(fewer));
    }
    (columns, Vec2::new(width(columns).max(20.0), panel.y.min(HEIGHT)))
}

/// What was done in a plot: indices within it.
#[derive(Default)]
pub(super) struct Picked {
    /// Where it was clicked or dragged.
    pub clicked: Option<usize>,
    /// A command from the context menu, and where it was opened.
    pub menu: Option<(Command, usize)>,
}

/// Where the values of positions stand in a plot, side by side.
#[derive(Clone, Copy)]
pub(super) struct PositionScale {
    /// The plot without its head and margins.
    pub inner: Rect,
    /// Number of positions, at least one.
    pub count: usize,
}

impl PositionScale {
    fn last(self) -> f32 {
        (self.count - 1).max(1) as f32
    }

    /// The place of a value at the `height` (0 at the bottom, 1 at the top) of position `k`.
    pub fn place(self, k: usize, height: f32) -> Pos2 {
        let Rect { min, max } = self.inner;
        Pos2::new(min.x + self.inner.width() * k as f32 / self.last(), max.y - self.inner.height() * height)
    }

    /// The position nearest to a place.
    pub fn near(self, at: Pos2) -> usize {
        let share = (at.x - self.inner.left()) / self.inner.width().max(1.0);
        ((share * self.last()).round().clamp(0.0, self.last()) as usize).min(self.count - 1)
    }

    /// Where `response` to the plot is clicked or dragged.
    pub fn clicked(self, response: &Response) -> Option<usize> {
        let picks = response.clicked() || response.dragged_by(PointerButton::Primary);
        response.interact_pointer_pos().filter(|_| picks).map(|at| self.near(at))
    }

    /// What `response` to the plot picks; in the table its first position has the number `first`.
    pub fn picked(self, ui: &Ui, response: &Response, first: usize) -> Picked {
        let pointer = response.interact_pointer_pos();
        // The menu stays with the position that was right-clicked.
        let id = response.id.with("menu position");
        if let Some(at) = pointer.filter(|_| response.secondary_clicked()) {
            ui.data_mut(|data| data.insert_temp(id, self.near(at)));
        }
        let of_menu: usize = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        let menu = Popup::context_menu(response).show(|ui| position_menu(ui, first + of_menu, false));
        let menu = menu.and_then(|menu| menu.inner).map(|command| (command, of_menu));
        Picked { clicked: self.clicked(response), menu }
    }
}

fn plot(ui: &mut Ui, size: Vec2, curve: &PlotCurve, faulty: &[bool], chosen: Option<usize>) -> Picked {
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let title = format!("{} along the row", curve.name);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &title));
    let visuals = ui.visuals();
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, visuals.extreme_bg_color);
    let finite = || curve.values.iter().copied().filter(|v| v.is_finite());
    let (mut low, mut high) =
        (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let values_range = (low, high);
    if curve.from_zero {
        low = low.min(0.0);
    }
    if !(high - low).is_finite() {
        // Of tools that do not say how many teeth they have.
        let at = rect.min + egui::vec2(5.0, 3.0);
        let font = FontId::proportional(11.0);
        let name = elided(ui, curve.name, &font, rect.width() - 2.0 * SIDE_MARGIN);
        painter.galley(at, name, visuals.text_color());
        painter.text(rect.center(), Align2::CENTER_CENTER, "unknown", font, visuals.weak_text_color());
        response.on_hover_text(format!("{}: the tool does not say how many teeth it has", curve.name));
        return Picked::default();
    }
    high = high.max(low + curve.min_range);
    let is_tight = rect.width() < TIGHT;
    let head = if is_tight { 18.0 + LINE } else { 18.0 };
    let inner = Rect::from_min_max(rect.min + egui::vec2(5.0, head), rect.max - egui::vec2(5.0, 6.0));
    let scale = PositionScale { inner, count: curve.values.len() };
    let place = |k: usize, v: f64| scale.place(k, ((v - low) / (high - low)) as f32);
    if low < 0.0 && high > 0.0 {
        let zero = place(0, 0.0).y;
        let ends = [egui::pos2(inner.left(), zero), egui::pos2(inner.right(), zero)];
        painter.line_segment(ends, Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.5)));
    }
    let accent = theme::accent(visuals);
    if let Some(k) = chosen {
        let x = place(k, low).x;
        let line = [egui::pos2(x, inner.top()), egui::pos2(x, inner.bottom())];
        painter.line_segment(line, Stroke::new(1.0, accent));
    }
    let ink = visuals.text_color();
    let mut piece: Vec<Pos2> = Vec::new();
    for (k, &v) in curve.values.iter().enumerate() {
        if v.is_finite() {
            piece.push(place(k, v));
        } else {
            painter.line(std::mem::take(&mut piece), Stroke::new(1.3, ink));
        }
    }
    if let ([single], 1) = (&piece[..], curve.values.len()) {
        // A row of one position has no line.
        painter.circle_filled(*single, 2.0, ink);
    }
    painter.line(piece, Stroke::new(1.3, ink));
    for (k, &v) in curve.values.iter().enumerate().filter(|(k, v)| v.is_finite() && faulty[*k]) {
        painter.circle_filled(place(k, v), 2.5, Condition::Interfering.mark());
    }
    let font = FontId::proportional(11.0);
    let value = chosen.and_then(|k| curve.values.get(k)).filter(|v| v.is_finite());
    let width = |text: &str| painter.layout_no_wrap(text.to_owned(), font.clone(), ink).size().x;
    let name_margins = |text: &str| if text.is_empty() { 2.0 * SIDE_MARGIN } else { HEAD_MARGINS };
    let fits = |name: &str, text: &str| width(name) + width(text) + name_margins(text) <= rect.width();
    let digits = |decimals: usize| curve.decimals.decimals(decimals);
    let text = match value {
        Some(v) => {
            let number = with_minus_signs(&format!("{v:.*}", digits(curve.digits)));
            // The unit is that of all lengths: it goes before a digit does.
            let text = format!("{number}{}", curve.unit);
            if width(&text) + SIDE_MARGIN <= rect.width() { text } else { number }
        }
        // Only the name fits in a narrow plot.
        None if rect.width() < NARROW => String::new(),
        None => Some(range_text(values_range, (low, high), curve.digits, (curve.decimals, curve.unit)))
            .filter(|range| fits(curve.name, range))
            .unwrap_or_default(),
    };
    let beside = if is_tight { "" } else { text.as_str() };
    let name = elided(ui, curve.name, &font, rect.width() - width(beside) - name_margins(beside));
    painter.galley(rect.min + egui::vec2(SIDE_MARGIN, 3.0), name, ink);
    let at = rect.right_top() + egui::vec2(-5.0, if is_tight { 3.0 + LINE } else { 3.0 });
    painter.text(at, Align2::RIGHT_TOP, text, font, if value.is_some() { accent } else { ink });
    let tip = response.hover_pos().map(|at| scale.near(at)).and_then(|k| Some((k, *curve.values.get(k)?)));
    if let Some((k, v)) = tip {
        let more = if curve.digits > 0 { 1 } else { 0 };
        let value = with_minus_signs(&format!("{v:.*}{}", digits(curve.digits + more), curve.unit));
        let name = curve.name;
        response.clone().on_hover_text_at_pointer(format!("{name}, {} of the row: {value}", k + 1));
    }
    scale.picked(ui, &response, curve.first)
}

/// A text of one line that ends with "…" where it would be wider than `width`, points.
fn elided(ui: &Ui, text: &str, font: &FontId, width: f32) -> Arc<Galley> {
    let colour = ui.visuals().text_color();
    let mut job = LayoutJob::simple_singleline(text.to_owned(), font.clone(), colour);
    job.wrap = TextWrapping::truncate_at_width(width.max(1.0));
    ui.painter().layout_job(job)
}

/// Ends of the scale of a plot. Where all values, from the least to the greatest, read the same, that value
/// alone, as the scale goes on beyond it. With one decimal less than `most`, unless the greatest value would
/// then read 0.
fn range_text(
    values: (f64, f64),
    scale: (f64, f64),
    most: usize,
    (units, unit): (DisplayUnits, &str),
) -> String {
    let few = most.saturating_sub(1);
    let reads_zero = values.1 > 0.0 && values.1 < 0.5 * 0.1_f64.powi(units.decimals(few) as i32);
    let decimals = units.decimals(if reads_zero { most } else { few });
    let text = |value: f64| with_minus_signs(&format!("{value:.decimals$}"));
    if text(values.0) == text(values.1) {
        return format!("all {}{unit}", text(values.0));
    }
    format!("{} to {}{unit}", text(scale.0), text(scale.1))
}

#[cfg(test)]
mod tests {
    use super::{DisplayUnits, GAP, HEIGHT, NARROW, arranged, range_text};

    #[test]
    fn plots_stand_in_rows_where_they_would_be_narrow() {
        let columns = |width: f32, height: f32| arranged(egui::vec2(width, height), 6).0;
        assert_eq!(columns(900.0, HEIGHT), 6);
        assert_eq!(columns(900.0, 800.0), 6, "wide enough");
        assert_eq!(columns(330.0, HEIGHT), 6, "the panel is too low for a second row");
        assert_eq!(columns(330.0, 2.0 * HEIGHT + GAP), 3);
        assert_eq!(columns(330.0, 800.0), 2);
        assert_eq!(columns(150.0, 800.0), 1);
        let (_, size) = arranged(egui::vec2(360.0, 800.0), 6);
        assert!(size.x >= NARROW && size.y == HEIGHT, "{size}");
    }

    #[test]
    fn a_plot_of_equal_values_names_no_range() {
        let text = |values, scale| range_text(values, scale, 2, (DisplayUnits::Metric, " mm"));
        assert_eq!(text((0.0, 0.0), (0.0, 0.1)), "all 0.0 mm");
        assert_eq!(text((0.0, 0.26), (0.0, 0.26)), "0.0 to 0.3 mm");
        assert_eq!(text((0.2, 0.4), (0.0, 0.4)), "0.0 to 0.4 mm");
        assert_eq!(text((0.02, 0.02), (0.0, 0.1)), "all 0.02 mm");
        assert_eq!(text((0.0, 0.04), (0.0, 0.1)), "0.00 to 0.10 mm");
    }
}
