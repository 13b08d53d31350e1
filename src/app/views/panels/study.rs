//! The results of a study: a plot of two figures, a table, and the way from a row to its plan.

use std::sync::Arc;

use egui::{ComboBox, RichText, Role, Sense, Ui, WidgetInfo};
use egui_extras::{Column, TableBuilder};

use super::study_plot::StudyPlot;
use crate::app::model::study_table::{StudyColumn, StudyFigure, StudyTable};
use crate::app::model::units::DisplayUnits;
use crate::app::views::theme;
use crate::app::views::units;
use crate::study::StudyResults;

/// Share of the height that the plot takes, and its least height, points.
const PLOT_SHARE: f32 = 0.42;
const MIN_PLOT: f32 = 120.0;
/// Widths of the columns of keys and figures, points.
const KEY_WIDTH: f32 = 150.0;
const FIGURE_WIDTH: f32 = 104.0;

/// The panel, with the results while some were opened.
#[derive(Default)]
pub struct StudyPanel {
    table: Option<StudyTable>,
    plot: StudyPlot,
}

impl StudyPanel {
    /// Shows results that were read.
    pub fn take(&mut self, results: StudyResults) {
        self.table = Some(StudyTable::new(results));
        self.plot = StudyPlot::default();
    }

    /// How often the runs were gone through for the plot.
    pub fn passes(&self) -> usize {
        self.plot.passes
    }

    /// Whether results were opened.
    pub fn has_results(&self) -> bool {
        self.table.is_some()
    }

    /// Draws the results; returns the row whose run is to be planned.
    pub fn show(&mut self, ui: &mut Ui) -> Option<(Arc<StudyResults>, usize)> {
        let table = self.table.as_mut()?;
        let wanted = content(ui, table, &mut self.plot);
        wanted.map(|row| (Arc::clone(&table.results), row))
    }
}

fn content(ui: &mut Ui, table: &mut StudyTable, figures: &mut StudyPlot) -> Option<usize> {
    let units = units::of(ui);
    head(ui, table);
    let height = (PLOT_SHARE * ui.available_height()).max(MIN_PLOT);
    table.selected = figures.show(ui, table, height, units).or(table.selected);
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
        let mut text = format!("{count} runs");
        if table.without_plan > 0 {
            text += &format!(", {} without a plan", table.without_plan);
        }
        if let Some(missing) = results.missing.filter(|missing| *missing > 0) {
            text += &format!(", {missing} not finished");
        }
        ui.label(RichText::new(text).weak());
    });
    let mut axes = table.axes;
    ui.horizontal(|ui| {
        axis_list(ui, "Across", &mut axes[0], table.shown);
        axis_list(ui, "Up", &mut axes[1], table.shown);
        ui.label(RichText::new("the line joins the runs that no other beats in both").weak());
    });
    table.set_axes(axes);
}

fn axis_list(ui: &mut Ui, name: &str, axis: &mut StudyFigure, shown: impl IntoIterator<Item = StudyFigure>) {
    let label = ui.label(name);
    let list = ComboBox::from_id_salt(name).width(110.0).selected_text(axis.head);
    let list = list.show_ui(ui, |ui| {
        for figure in shown {
            ui.selectable_value(axis, figure, figure.head);
        }
    });
    list.response.labelled_by(label.id);
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
                None => table.describe(row, units).replace('\n', ", "),
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
