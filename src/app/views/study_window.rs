//! The results of a study: a plot of two figures, a table, and the way from a row to its plan.

use std::sync::Arc;

use egui::{Align2, ComboBox, FontId, Pos2, Rect, RichText, Role, Sense, Stroke, Ui, Vec2, WidgetInfo};
use egui_extras::{Column, TableBuilder};

use super::theme::{self, Condition};
use super::units;
use crate::app::model::study_table::{SHOWN, StudyColumn, StudyFigure, StudyTable};
use crate::app::model::units::DisplayUnits;
use crate::study::StudyResults;

/// Room for the scales at the left and below, and above and at the right, points.
const MARGIN: [Vec2; 2] = [Vec2::new(48.0, 32.0), Vec2::new(14.0, 10.0)];
/// Share of the height that the plot takes, and its least height, points.
const PLOT_SHARE: f32 = 0.42;
const MIN_PLOT: f32 = 120.0;
/// Distance from a point within which a click picks it, points.
const PICK: f32 = 10.0;
/// Widths of the columns of keys and figures, points.
const KEY_WIDTH: f32 = 150.0;
const FIGURE_WIDTH: f32 = 104.0;

/// The window, with the results while some were opened.
#[derive(Default)]
pub struct StudyWindow {
    table: Option<StudyTable>,
    is_open: bool,
}

impl StudyWindow {
    /// Shows results that were read.
    pub fn take(&mut self, results: StudyResults) {
        self.table = Some(StudyTable::new(results));
        self.is_open = true;
    }

    /// Whether results were opened.
    pub fn has_results(&self) -> bool {
        self.table.is_some()
    }

    /// Shows the results that were opened last.
    pub fn open(&mut self) {
        self.is_open = true;
    }

    /// Draws the window while it is open; returns the row whose run is to be planned.
    pub fn show(&mut self, ui: &Ui) -> Option<(Arc<StudyResults>, usize)> {
        let table = self.table.as_mut().filter(|_| self.is_open)?;
        let size = Vec2::new(760.0, 560.0).min(ui.ctx().content_rect().size() - Vec2::new(40.0, 80.0));
        let corner = ui.ctx().content_rect().center() - 0.5 * size;
        let window = egui::Window::new("Study results").open(&mut self.is_open).collapsible(false);
        let window = window.default_pos(corner).default_size(size).min_size([360.0, 300.0]);
        let wanted = window.show(ui.ctx(), |ui| content(ui, table)).and_then(|shown| shown.inner.flatten());
        wanted.map(|row| (Arc::clone(&table.results), row))
    }
}

fn content(ui: &mut Ui, table: &mut StudyTable) -> Option<usize> {
    let units = units::of(ui);
    head(ui, table);
    let height = (PLOT_SHARE * ui.available_height()).max(MIN_PLOT);
    if let Some(row) = plot(ui, table, height, units) {
        table.selected = Some(row);
    }
    let wanted = actions(ui, table, units);
    rows(ui, table, units);
    wanted
}

/// What was opened, and the figures of the plot.
fn head(ui: &mut Ui, table: &mut StudyTable) {
    let results = &table.results;
    let path = results.path.display().to_string();
    let name = results.path.file_name().map_or(path.clone(), |name| name.to_string_lossy().into_owned());
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).strong()).on_hover_text(path);
        let count = results.table.rows.len();
        let without = (0..count).filter(|&row| !results.has_plan(row)).count();
        let mut text = format!("{count} runs");
        if without > 0 {
            text += &format!(", {without} without a plan");
        }
        if let Some(missing) = results.missing.filter(|missing| *missing > 0) {
            text += &format!(", {missing} not finished");
        }
        ui.label(RichText::new(text).weak());
    });
    let mut axes = table.axes;
    ui.horizontal(|ui| {
        axis_list(ui, "Across", &mut axes[0]);
        axis_list(ui, "Up", &mut axes[1]);
        ui.label(RichText::new("the line joins the runs that no other beats in both").weak());
    });
    table.set_axes(axes);
}

fn axis_list(ui: &mut Ui, name: &str, axis: &mut StudyFigure) {
    let label = ui.label(name);
    let list = ComboBox::from_id_salt(name).width(110.0).selected_text(axis.head);
    let list = list.show_ui(ui, |ui| {
        for figure in SHOWN {
            ui.selectable_value(axis, figure, figure.head);
        }
    });
    list.response.labelled_by(label.id);
}

/// Draws the plot; returns the row that was clicked.
fn plot(ui: &mut Ui, table: &StudyTable, height: f32, units: DisplayUnits) -> Option<usize> {
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
    let places: Vec<(usize, (f64, f64))> =
        (0..table.results.table.rows.len()).filter_map(|row| Some((row, table.place(row, units)?))).collect();
    if places.is_empty() {
        painter.text(inner.center(), Align2::CENTER_CENTER, "No run has these figures", font, weak);
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
    let (across, up) = (range(|at| at.0), range(|at| at.1));
    let place = |(x, y): (f64, f64)| {
        let share = |value: f64, (low, high): (f64, f64)| ((value - low) / (high - low)) as f32;
        Pos2::new(
            inner.left() + inner.width() * share(x, across),
            inner.bottom() - inner.height() * share(y, up),
        )
    };
    let decimals = |(low, high): (f64, f64)| match (high - low) / 4.0 {
        step if step >= 2.0 => 0,
        step if step >= 0.2 => 1,
        step if step >= 0.02 => 2,
        _ => 3,
    };
    for k in 0..=4 {
        let share = f64::from(k) / 4.0;
        let at = |(low, high): (f64, f64)| low + (high - low) * share;
        let (x, y) = (at(across), at(up));
        let below = Pos2::new(place((x, up.0)).x, inner.bottom() + 2.0);
        painter.text(below, Align2::CENTER_TOP, format!("{x:.*}", decimals(across)), font.clone(), weak);
        let left = Pos2::new(inner.left() - 4.0, place((across.0, y)).y);
        painter.text(left, Align2::RIGHT_CENTER, format!("{y:.*}", decimals(up)), font.clone(), weak);
    }
    let axes = table.axes.map(|axis| axis.title(units));
    let below = Pos2::new(inner.center().x, rect.bottom());
    painter.text(below, Align2::CENTER_BOTTOM, format!("{}; {}", axes[0], axes[1]), font, weak);
    best_line(&painter, table, &place, units, theme::accent(ui.visuals()));
    let faulty = |row: usize| table.results.field(row, "status").is_some_and(|status| status != "done");
    for &(row, at) in &places {
        let condition = if faulty(row) { Condition::Interfering } else { Condition::Sound };
        painter.circle_stroke(place(at), 3.5, Stroke::new(1.5, condition.text(ui.visuals())));
    }
    if let Some((_, at)) = places.iter().find(|(row, _)| table.selected == Some(*row)) {
        painter.circle_filled(place(*at), 5.0, theme::accent(ui.visuals()));
    }
    let nearest = |to: Pos2| {
        let distance = |at: &(f64, f64)| place(*at).distance(to);
        let near = places.iter().min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
        near.filter(|(_, at)| distance(at) <= PICK).map(|(row, _)| *row)
    };
    if let Some(row) = response.hover_pos().and_then(nearest) {
        response.clone().on_hover_text_at_pointer(describe(table, row, units));
    }
    response.interact_pointer_pos().filter(|_| response.clicked()).and_then(nearest)
}

/// Joins the runs that no other beats, part by part.
fn best_line(
    painter: &egui::Painter,
    table: &StudyTable,
    place: &dyn Fn((f64, f64)) -> Pos2,
    units: DisplayUnits,
    colour: egui::Color32,
) {
    let part = |row: usize| table.results.field(row, "part").map(str::to_owned);
    for of_part in table.best.chunk_by(|&a, &b| part(a) == part(b)) {
        let mut line: Vec<Pos2> =
            of_part.iter().filter_map(|&row| table.place(row, units)).map(place).collect();
        line.sort_by(|a, b| a.x.total_cmp(&b.x));
        painter.line(line, Stroke::new(1.4, colour));
    }
}

/// A run in words: its keys and the figures of the plot.
fn describe(table: &StudyTable, row: usize, units: DisplayUnits) -> String {
    let keys = table.results.keys().into_iter();
    let keys = keys.map(|key| format!("{key} = {}", table.results.field(row, key).unwrap_or_default()));
    let figure = |axis: &StudyFigure| {
        let value = axis.text(table.results.figure(row, axis.name), units);
        format!("{} {value} {}", axis.head, axis.unit(units))
    };
    keys.chain(table.axes.iter().map(figure)).collect::<Vec<_>>().join("\n")
}

/// The selected run and what can be done with it; returns the row to be planned.
fn actions(ui: &mut Ui, table: &StudyTable, units: DisplayUnits) -> Option<usize> {
    let mut wanted = None;
    ui.horizontal(|ui| {
        let row = table.selected;
        let can = row.is_some_and(|row| table.results.has_plan(row));
        let button = ui.add_enabled(can, egui::Button::new("Open as plan"));
        let tip = "Takes the setup of the selected run, opens its part unless it is open, and calculates it";
        if button.on_hover_text(tip).clicked() {
            wanted = row;
        }
        let words = match row {
            None => "Select a run in the plot or the table".to_owned(),
            Some(row) => match table.results.field(row, "error").filter(|error| !error.is_empty()) {
                Some(error) => error.to_owned(),
                None => describe(table, row, units).replace('\n', ", "),
            },
        };
        ui.add(egui::Label::new(RichText::new(words).weak()).truncate());
    });
    wanted
}

/// The table; a click on a head sorts, one on a row selects.
fn rows(ui: &mut Ui, table: &mut StudyTable, units: DisplayUnits) {
    let (mut sorted, mut clicked) = (None, None);
    egui::ScrollArea::horizontal().auto_shrink([false, false]).show(ui, |ui| {
        let mut builder = TableBuilder::new(ui)
            .striped(true)
            .sense(Sense::click())
            .auto_shrink([false, false])
            .cell_layout(egui::Layout::left_to_right(egui::Align::Center));
        for column in &table.columns {
            let width = match column {
                StudyColumn::Key(_) => KEY_WIDTH,
                _ => FIGURE_WIDTH,
            };
            builder = builder.column(Column::exact(width).clip(true));
        }
        builder
            .header(theme::ROW_HEIGHT, |mut header| {
                for column in 0..table.columns.len() {
                    header.col(|ui| {
                        let direction = table.sort.filter(|(of, _)| *of == column).map(|(_, down)| down);
                        let title = table.head(column, units);
                        let text = RichText::new(&title);
                        let text = if direction.is_some() { text.strong() } else { text.weak() };
                        let label = egui::Label::new(text).selectable(false).sense(Sense::click());
                        let response = ui.add(label.truncate());
                        if let Some(descending) = direction {
                            theme::sort_mark(ui, response.rect.center_bottom(), descending);
                        }
                        let name = format!("Sort runs by {title}");
                        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
                        if response.on_hover_text("Click to sort").clicked() {
                            sorted = Some(column);
                        }
                    });
                }
            })
            .body(|body| {
                body.rows(theme::ROW_HEIGHT, table.order.len(), |mut row| {
                    let Some(&of) = table.order.get(row.index()) else { return };
                    let is_selected = table.selected == Some(of);
                    row.set_selected(is_selected);
                    for column in 0..table.columns.len() {
                        row.col(|ui| {
                            let text = RichText::new(table.cell(of, column, units));
                            ui.add(egui::Label::new(text).selectable(false).truncate());
                        });
                    }
                    let name = format!("Run {}", of + 1);
                    let response = row.response();
                    response.widget_info(|| WidgetInfo::selected(Role::Row, true, is_selected, &name));
                    if response.clicked() {
                        clicked = Some(of);
                    }
                });
            });
    });
    if let Some(column) = sorted {
        table.sort_by(column);
    }
    if clicked.is_some() {
        table.selected = clicked;
    }
}
