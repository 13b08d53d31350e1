//! The results of a study: a plot of two figures, a table, and the way from a row to its plan.

use std::sync::Arc;

use egui::{ComboBox, RichText, Ui};

use super::study_plot::StudyPlot;
use crate::app::model::study_table::{StudyColumn, StudyFigure, StudyTable};
use crate::app::model::units::DisplayUnits;
use crate::app::views::units;
use crate::app::views::wide_table::{TableClick, WideColumn, WideTable, width_of_column};
use crate::study::StudyResults;

/// Share of the height that the plot takes, and its least height, points.
const PLOT_SHARE: f32 = 0.42;
const MIN_PLOT: f32 = 110.0;
/// Width that lists and note need beside each other, and widths of the lists, points.
const WIDTH_OF_HEAD: f32 = 620.0;
const LIST: f32 = 110.0;
const NARROW_LIST: f32 = 86.0;
/// Width of the column of numbers, least widths of those of keys and figures, and the greatest one, points.
const RUN_WIDTH: f32 = 38.0;
const KEY_WIDTH: f32 = 90.0;
const FIGURE_WIDTH: f32 = 60.0;
const MAX_WIDTH: f32 = 200.0;

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
    let units = units::display_units(ui);
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
    let is_narrow = ui.available_width() < WIDTH_OF_HEAD;
    let note = RichText::new("line: faultless runs that none beats in both").weak();
    ui.horizontal(|ui| {
        let width = if is_narrow { NARROW_LIST } else { LIST };
        axis_list(ui, "Across", &mut axes[0], table.shown, width);
        axis_list(ui, "Up", &mut axes[1], table.shown, width);
        if !is_narrow {
            ui.label(note.clone());
        }
    });
    if is_narrow {
        ui.add(egui::Label::new(note).truncate());
    }
    table.set_axes(axes);
}

fn axis_list(
    ui: &mut Ui,
    name: &str,
    axis: &mut StudyFigure,
    shown: impl IntoIterator<Item = StudyFigure>,
    width: f32,
) {
    let label = ui.label(name);
    let list = ComboBox::from_id_salt(name).width(width).truncate().selected_text(axis.head);
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
    let sorted = |column: usize| table.sort.filter(|(of, _)| *of == column).map(|(_, down)| down);
    let first = WideColumn {
        head: "Run".to_owned(),
        tip: "Number in the study; click for the order of the study".to_owned(),
        name: "Sort runs by number".to_owned(),
        sorted: None,
        width: RUN_WIDTH,
    };
    let others = (0..table.columns.len()).map(|column| {
        let head = table.head(column, units);
        let least =
            if matches!(table.columns[column], StudyColumn::Key(_)) { KEY_WIDTH } else { FIGURE_WIDTH };
        WideColumn {
            tip: format!("{}\nClick to sort", table.tip(column, units)),
            name: format!("Sort runs by {head}"),
            sorted: sorted(column),
            width: width_of_column(ui, &head, least, MAX_WIDTH),
            head,
        }
    });
    let columns: Vec<WideColumn> = std::iter::once(first).chain(others).collect();
    let cell = |row: usize, column: usize| {
        let of = table.order[row];
        match column.checked_sub(1) {
            None => (of + 1).to_string(),
            Some(column) => table.cell(of, column, units),
        }
    };
    let clicked = WideTable {
        columns: &columns,
        rows: table.order.len(),
        selected: table.selected.and_then(|selected| table.order.iter().position(|&of| of == selected)),
        cell: &cell,
        name: &|row| format!("Run {}", table.order[row] + 1),
    }
    .show(ui);
    match clicked {
        Some(TableClick::Head(0)) => table.unsort(),
        Some(TableClick::Head(column)) => table.sort_by(column - 1),
        Some(TableClick::Row(row)) => table.selected = Some(table.order[row]),
        None => {}
    }
}
