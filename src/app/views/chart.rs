//! A line chart of a document, drawn in the window.

use egui::{Align2, FontId, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo};

use super::units;
use crate::app::model::units::DisplayUnits;
use crate::palette::{CURVES, to_bytes};
use crate::report::chart::{LineChart, Series};

/// Height of a chart with its scales, points.
const HEIGHT: f32 = 190.0;
/// Room for the scales at the left and below, points.
const MARGIN: Vec2 = Vec2::new(38.0, 30.0);
/// Room for the title, points.
const TITLE: f32 = 20.0;
/// Lengths of dashes and of the gaps between them, by style, points; none for solid lines.
const DASHES: [Option<(f32, f32)>; 3] = [None, Some((7.0, 3.0)), Some((2.0, 3.0))];

/// Draws `chart` in the whole width, its legend below. x runs from 0 to 1, as in the document.
pub fn show(ui: &mut Ui, chart: &LineChart) {
    let in_units = shown_in(units::display_units(ui), chart);
    let chart = in_units.as_ref().unwrap_or(chart);
    let (rect, response) = ui.allocate_exact_size(Vec2::new(ui.available_width(), HEIGHT), Sense::hover());
    let title = chart.title.clone();
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &title));
    let inner = Rect::from_min_max(
        Pos2::new(rect.left() + MARGIN.x, rect.top() + TITLE),
        Pos2::new(rect.right() - 8.0, rect.bottom() - MARGIN.y),
    );
    let (step, y_max) = chart.y_scale();
    let place = |(x, y): (f64, f64)| {
        Pos2::new(
            inner.left() + inner.width() * x as f32,
            inner.bottom() - inner.height() * (y / y_max) as f32,
        )
    };
    let painter = ui.painter_at(rect);
    let (text, weak) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    let font = FontId::proportional(11.0);
    let grid = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    painter.text(rect.left_top(), Align2::LEFT_TOP, &chart.title, FontId::proportional(13.0), text);
    for i in 0..=5 {
        let x = f64::from(i) / 5.0;
        let at = place((x, 0.0));
        painter.vline(at.x, inner.y_range(), grid);
        painter.text(at + Vec2::new(0.0, 2.0), Align2::CENTER_TOP, format!("{x:.1}"), font.clone(), weak);
    }
    let decimals = if step < 1.0 { (-step.log10()).ceil() as usize } else { 0 };
    for i in 0..=(y_max / step).round() as usize {
        let y = i as f64 * step;
        let at = place((0.0, y));
        painter.hline(inner.x_range(), at.y, grid);
        let label = format!("{y:.decimals$}");
        painter.text(at - Vec2::new(4.0, 0.0), Align2::RIGHT_CENTER, label, font.clone(), weak);
    }
    let below = Pos2::new(inner.center().x, rect.bottom());
    let axes = format!("{}; {}", chart.x_label, chart.y_label);
    painter.text(below, Align2::CENTER_BOTTOM, axes, font, weak);
    let painter = painter.with_clip_rect(inner.expand(1.0));
    for series in &chart.series {
        let stroke = stroke(series);
        let points: Vec<Pos2> = series.points.iter().map(|&point| place(point)).collect();
        match DASHES[series.dash % DASHES.len()] {
            None => {
                painter.line(points, stroke);
            }
            Some((dash, gap)) => {
                painter.extend(Shape::dashed_line(&points, stroke, dash, gap));
            }
        }
        if let Some(mark) = series.mark {
            painter.circle_filled(place(mark), 3.5, stroke.color);
        }
    }
    ui.horizontal_wrapped(|ui| {
        for series in &chart.series {
            let (rect, _) = ui.allocate_exact_size(Vec2::new(22.0, 10.0), Sense::hover());
            let ends = [rect.left_center(), rect.right_center()];
            match DASHES[series.dash % DASHES.len()] {
                None => {
                    ui.painter().line_segment(ends, stroke(series));
                }
                Some((dash, gap)) => {
                    ui.painter().extend(Shape::dashed_line(&ends, stroke(series), dash, gap));
                }
            }
            ui.label(&series.name);
        }
    });
}

/// `chart` with lengths in `units`; `None` where that changes nothing.
fn shown_in(units: DisplayUnits, chart: &LineChart) -> Option<LineChart> {
    if units == DisplayUnits::Metric || chart.y_label != "mm" {
        return None;
    }
    let mut shown = chart.clone();
    units.length_unit().clone_into(&mut shown.y_label);
    for series in &mut shown.series {
        for (_, y) in series.points.iter_mut().chain(series.mark.as_mut()) {
            *y = units.of_mm(*y);
        }
    }
    Some(shown)
}

fn stroke(series: &Series) -> Stroke {
    let [r, g, b] = to_bytes(CURVES[series.colour % CURVES.len()]);
    Stroke::new(1.5, egui::Color32::from_rgb(r, g, b))
}
