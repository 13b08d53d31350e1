//! The plot of two figures of a study. What it shows of the runs is found once for its size, figures and
//! theme: a frame draws no more marks than the plot has places, however many runs there are.

use std::collections::{HashMap, HashSet};

use egui::{Align2, Color32, FontId, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo};

use crate::app::model::study_table::{StudyFigure, StudyTable};
use crate::app::model::units::DisplayUnits;
use crate::app::views::theme::{self, Condition};
use crate::app::views::ticks::ticks;

/// Room for the scales at the left and below, and at the right and for the title above, points.
const MARGIN: [Vec2; 2] = [Vec2::new(48.0, 32.0), Vec2::new(14.0, 20.0)];
/// Distance from a point within which a click picks it, points.
const PICK: f32 = 10.0;
/// Runs closer than this share a mark, points.
const SAME_MARK: f32 = 2.0;
/// Radius of a mark, points.
const MARK: f32 = 3.5;

/// What the marks depend on.
#[derive(Clone, Debug, PartialEq)]
struct PlotKey {
    axes: [StudyFigure; 2],
    units: DisplayUnits,
    inner: Rect,
    is_dark: bool,
}

/// The marks of the runs in the plot.
struct PlotMarks {
    /// Ranges of the figures across and up.
    ranges: [(f64, f64); 2],
    shapes: Vec<Shape>,
    /// Runs with their places, by square of side [`PICK`].
    squares: HashMap<(i32, i32), Vec<(usize, Pos2)>>,
}

/// The plot of one study, with the marks that it showed last.
#[derive(Default)]
pub struct StudyPlot {
    /// The marks are `None` where no run has the figures.
    marks: Option<(PlotKey, Option<PlotMarks>)>,
    /// How often the runs were gone through.
    pub(super) passes: usize,
}

/// A figure's place on an axis of `range`, 0…1.
fn share(value: f64, (low, high): (f64, f64)) -> f32 {
    ((value - low) / (high - low)) as f32
}

/// The point of a run in the plot.
fn point(inner: Rect, [across, up]: [(f64, f64); 2], (x, y): (f64, f64)) -> Pos2 {
    Pos2::new(inner.left() + inner.width() * share(x, across), inner.bottom() - inner.height() * share(y, up))
}

fn square_of(at: Pos2, side: f32) -> (i32, i32) {
    ((at.x / side).floor() as i32, (at.y / side).floor() as i32)
}

impl StudyPlot {
    /// Draws the plot; returns the row that was clicked.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        table: &StudyTable,
        height: f32,
        units: DisplayUnits,
    ) -> Option<usize> {
        let size = Vec2::new(ui.available_width(), height);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let name = format!("{} over {}", table.axes[1].head, table.axes[0].head);
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
        let inner = Rect::from_min_max(
            rect.min + Vec2::new(MARGIN[0].x, MARGIN[1].y),
            rect.max - Vec2::new(MARGIN[1].x, MARGIN[0].y),
        );
        let painter = ui.painter_at(rect);
        let font = FontId::proportional(theme::MIN_TEXT_SIZE);
        let weak = ui.visuals().weak_text_color();
        painter.rect_filled(inner, 2.0, ui.visuals().extreme_bg_color);
        let visuals = ui.visuals();
        let colours = [Condition::Sound, Condition::Interfering].map(|c| c.text(visuals));
        let key = PlotKey { axes: table.axes, units, inner, is_dark: visuals.dark_mode };
        let Some(marks) = self.marks(key, table, colours, theme::accent(visuals)) else {
            painter.text(inner.center(), Align2::CENTER_CENTER, "No run has these figures", font, weak);
            return None;
        };
        let [across, up] = marks.ranges;
        let (values, decimals) = ticks(across);
        for value in values {
            let below = Pos2::new(point(inner, marks.ranges, (value, up.0)).x, inner.bottom() + 2.0);
            painter.text(below, Align2::CENTER_TOP, format!("{value:.decimals$}"), font.clone(), weak);
        }
        let (values, decimals) = ticks(up);
        for value in values {
            let left = Pos2::new(inner.left() - 4.0, point(inner, marks.ranges, (across.0, value)).y);
            painter.text(left, Align2::RIGHT_CENTER, format!("{value:.decimals$}"), font.clone(), weak);
        }
        let titles = table.axes.map(|axis| axis.title(units));
        let [across_title, up_title] = titles;
        let below = Pos2::new(inner.center().x, rect.bottom());
        painter.text(below, Align2::CENTER_BOTTOM, across_title, font.clone(), weak);
        let above = Pos2::new(rect.left() + 4.0, rect.top() + 2.0);
        painter.text(above, Align2::LEFT_TOP, up_title, font, weak);
        painter.extend(marks.shapes.iter().cloned());
        if let Some(at) = table.selected.and_then(|row| table.place(row, units)) {
            painter.circle_filled(point(inner, marks.ranges, at), 5.0, theme::accent(ui.visuals()));
        }
        let clicked = response.interact_pointer_pos().filter(|_| response.clicked());
        let clicked = clicked.and_then(|at| marks.nearest(at));
        if let Some(row) = response.hover_pos().and_then(|at| marks.nearest(at)) {
            response.on_hover_text_at_pointer(table.describe(row, units));
        }
        clicked
    }

    /// The marks for `key`, from the last frame if they are the same; `None` where no run has the figures.
    fn marks(
        &mut self,
        key: PlotKey,
        table: &StudyTable,
        colours: [Color32; 2],
        accent: Color32,
    ) -> Option<&PlotMarks> {
        if self.marks.as_ref().is_none_or(|(known, _)| *known != key) {
            self.passes += 1;
            let marks = PlotMarks::new(&key, table, colours, accent);
            self.marks = Some((key, marks));
        }
        self.marks.as_ref().and_then(|(_, marks)| marks.as_ref())
    }
}

impl PlotMarks {
    fn new(key: &PlotKey, table: &StudyTable, colours: [Color32; 2], accent: Color32) -> Option<Self> {
        let rows = 0..table.results.table.rows.len();
        let places: Vec<(usize, (f64, f64))> =
            rows.filter_map(|row| Some((row, table.place(row, key.units)?))).collect();
        if places.is_empty() {
            return None;
        }
        let range = |of: fn(&(f64, f64)) -> f64| {
            let ends = places
                .iter()
                .map(|(_, at)| of(at))
                .fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
            let span = (ends.1 - ends.0).max(1e-9 + 0.02 * ends.1.abs());
            (ends.0 - 0.06 * span, ends.0 + 1.06 * span)
        };
        let ranges = [range(|at| at.0), range(|at| at.1)];
        let mut shapes = best_lines(key, table, ranges, accent);
        let mut squares: HashMap<(i32, i32), Vec<(usize, Pos2)>> = HashMap::new();
        let mut drawn: HashSet<((i32, i32), bool)> = HashSet::new();
        for &(row, at) in &places {
            let is_faulty = table.results.field(row, "status").is_some_and(|status| status != "done");
            let at = point(key.inner, ranges, at);
            if drawn.insert((square_of(at, SAME_MARK), is_faulty)) {
                let stroke = Stroke::new(1.5, colours[usize::from(is_faulty)]);
                shapes.push(Shape::circle_stroke(at, MARK, stroke));
                squares.entry(square_of(at, PICK)).or_default().push((row, at));
            }
        }
        Some(Self { ranges, shapes, squares })
    }

    /// The run nearest to a point, if it is near.
    fn nearest(&self, to: Pos2) -> Option<usize> {
        let (x, y) = square_of(to, PICK);
        let around = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)));
        let near = around.filter_map(|square| self.squares.get(&square)).flatten();
        let near = near.map(|(row, at)| (*row, at.distance(to))).filter(|(_, distance)| *distance <= PICK);
        near.min_by(|(a, near), (b, far)| near.total_cmp(far).then(a.cmp(b))).map(|(row, _)| row)
    }
}

/// Joins the runs that no other beats, part by part.
fn best_lines(key: &PlotKey, table: &StudyTable, ranges: [(f64, f64); 2], accent: Color32) -> Vec<Shape> {
    let part = |row: usize| table.results.field(row, "part").map(str::to_owned);
    let line = |of_part: &[usize]| {
        let places = of_part.iter().filter_map(|&row| table.place(row, key.units));
        let mut line: Vec<Pos2> = places.map(|at| point(key.inner, ranges, at)).collect();
        line.sort_by(|a, b| a.x.total_cmp(&b.x));
        Shape::line(line, Stroke::new(1.4, accent))
    };
    table.best.chunk_by(|&a, &b| part(a) == part(b)).map(line).collect()
}
