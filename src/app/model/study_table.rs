//! The results of a study as the window shows them: columns, order of the rows, places in the plot.

use std::cmp::Ordering;
use std::sync::Arc;

use super::figures::policy_label;
use super::units::DisplayUnits;
use crate::io::setup_file::unit_of_key;
use crate::setup::AxisPolicy;
use crate::study::{MACHINE_TIME, StudyResults};

/// What a figure of a study measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureKind {
    /// A number of things.
    Count,
    /// A time, s; shown in min.
    Time,
    /// A length, mm.
    Length,
    /// A share, 0…1; shown in %.
    Share,
}

/// A figure of a study with its head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StudyFigure {
    /// Its name in the table.
    pub name: &'static str,
    /// Its head.
    pub head: &'static str,
    /// What it measures.
    pub kind: FigureKind,
}

const fn figure(name: &'static str, head: &'static str, kind: FigureKind) -> StudyFigure {
    StudyFigure { name, head, kind }
}

/// The figures that are shown; the time is that on the machine where every plan has one.
const SHOWN: [StudyFigure; 8] = [
    figure("time_estimate", "Time", FigureKind::Time),
    figure("residual_p95", "Stock 95 %", FigureKind::Length),
    figure("residual_mean", "Stock mean", FigureKind::Length),
    figure("residual_max", "Stock max", FigureKind::Length),
    figure("uncut_share", "Not machined", FigureKind::Share),
    figure("positions", "Plunges", FigureKind::Count),
    figure("interferential", "Core contact", FigureKind::Count),
    figure("faults", "Faults", FigureKind::Count),
];

impl StudyFigure {
    /// The value in the unit in which it is shown.
    pub fn shown(self, value: f64, units: DisplayUnits) -> f64 {
        match self.kind {
            FigureKind::Count => value,
            FigureKind::Time => value / 60.0,
            FigureKind::Length => units.of_mm(value),
            FigureKind::Share => 100.0 * value,
        }
    }

    /// Its unit; empty for a number of things.
    pub fn unit(self, units: DisplayUnits) -> &'static str {
        match self.kind {
            FigureKind::Count => "",
            FigureKind::Time => "min",
            FigureKind::Length => units.length_unit(),
            FigureKind::Share => "%",
        }
    }

    /// Head with unit.
    pub fn title(self, units: DisplayUnits) -> String {
        match self.unit(units) {
            "" => self.head.to_owned(),
            unit => format!("{}, {unit}", self.head),
        }
    }

    /// The value as it is written in a cell.
    pub fn text(self, value: Option<f64>, units: DisplayUnits) -> String {
        let Some(value) = value else { return "-".to_owned() };
        match self.kind {
            FigureKind::Count => format!("{value:.0}"),
            FigureKind::Time => format!("{:.1}", self.shown(value, units)),
            FigureKind::Length => units.number(value, 2),
            FigureKind::Share => format!("{:.1}", self.shown(value, units)),
        }
    }
}

/// A column of the table.
#[derive(Clone, Debug, PartialEq)]
pub enum StudyColumn {
    /// How the run ended.
    Status,
    /// A key that varies.
    Key(String),
    /// A figure.
    Figure(StudyFigure),
}

/// Results of a study with what is chosen in them.
#[derive(Clone, Debug)]
pub struct StudyTable {
    /// The results.
    pub results: Arc<StudyResults>,
    /// The figures that are shown.
    pub shown: [StudyFigure; SHOWN.len()],
    /// The columns.
    pub columns: Vec<StudyColumn>,
    /// Rows in the order in which they are shown.
    pub order: Vec<usize>,
    /// Sort column, and whether the largest is first; `None`: in the order of the study.
    pub sort: Option<(usize, bool)>,
    /// Figures of the plot: across and up.
    pub axes: [StudyFigure; 2],
    /// Rows that no other of the same part beats in both figures of the plot.
    pub best: Vec<usize>,
    /// The selected row.
    pub selected: Option<usize>,
    /// Number of runs without a plan.
    pub without_plan: usize,
}

impl StudyTable {
    /// The table of `results`, in the order of the study.
    pub fn new(results: StudyResults) -> Self {
        let shown = SHOWN.map(|figure| match figure.kind {
            FigureKind::Time => {
                let name = results.table.time_figure();
                let head = if name == MACHINE_TIME { "Time on machine" } else { figure.head };
                StudyFigure { name, head, ..figure }
            }
            _ => figure,
        });
        let keys = results.keys().into_iter().map(|key| StudyColumn::Key(key.to_owned()));
        let columns = keys.chain([StudyColumn::Status]).chain(shown.map(StudyColumn::Figure)).collect();
        let rows = 0..results.table.rows.len();
        let mut table = Self {
            shown,
            columns,
            without_plan: rows.clone().filter(|&row| !results.has_plan(row)).count(),
            order: rows.collect(),
            sort: None,
            axes: [shown[0], shown[1]],
            best: Vec::new(),
            selected: None,
            results: Arc::new(results),
        };
        table.compare();
        table
    }

    /// Sorts by a column; by the same once more, the other way round.
    pub fn sort_by(&mut self, column: usize) {
        let descending = matches!(self.sort, Some((last, false)) if last == column);
        self.sort = Some((column, descending));
        let mut order: Vec<usize> = (0..self.results.table.rows.len()).collect();
        let values: Vec<Option<f64>> = order.iter().map(|&row| self.value(row, column)).collect();
        order.sort_by(|&a, &b| {
            let (left, right) = (values[a], values[b]);
            // What has no value comes last either way.
            match (left, right) {
                (Some(left), Some(right)) if descending => right.total_cmp(&left),
                (Some(left), Some(right)) => left.total_cmp(&right),
                (Some(_), None) => Ordering::Less,
                (None, Some(_)) => Ordering::Greater,
                (None, None) => {
                    let (left, right) = (self.text(a, column), self.text(b, column));
                    if descending { right.cmp(left) } else { left.cmp(right) }
                }
            }
        });
        self.order = order;
    }

    /// Returns to the order of the study.
    pub fn unsort(&mut self) {
        self.sort = None;
        self.order = (0..self.results.table.rows.len()).collect();
    }

    /// Chooses the figures of the plot.
    pub fn set_axes(&mut self, axes: [StudyFigure; 2]) {
        if self.axes != axes {
            self.axes = axes;
            self.compare();
        }
    }

    fn compare(&mut self) {
        let names = self.axes.map(|axis| axis.name);
        // One figure on both axes has a best, too.
        let names = if names[0] == names[1] { &names[..1] } else { &names[..] };
        self.best = self.results.table.pareto(names).map(|set| set.rows).unwrap_or_default();
    }

    /// Number in a cell; `None` for a text.
    fn value(&self, row: usize, column: usize) -> Option<f64> {
        match &self.columns[column] {
            StudyColumn::Status => None,
            StudyColumn::Key(key) => self.results.figure(row, key),
            StudyColumn::Figure(figure) => self.results.figure(row, figure.name),
        }
    }

    /// Field of a cell as it is in the table.
    fn text(&self, row: usize, column: usize) -> &str {
        let name = match &self.columns[column] {
            StudyColumn::Status => "status",
            StudyColumn::Key(key) => key,
            StudyColumn::Figure(figure) => figure.name,
        };
        self.results.field(row, name).unwrap_or_default()
    }

    /// Text of a cell.
    pub fn cell(&self, row: usize, column: usize, units: DisplayUnits) -> String {
        match &self.columns[column] {
            StudyColumn::Figure(figure) => figure.text(self.results.figure(row, figure.name), units),
            StudyColumn::Status | StudyColumn::Key(_) => self.text(row, column).to_owned(),
        }
    }

    /// Head of a column.
    pub fn head(&self, column: usize, units: DisplayUnits) -> String {
        match &self.columns[column] {
            StudyColumn::Status => "Status".to_owned(),
            StudyColumn::Key(key) => match unit_of_key(key) {
                "" => key.clone(),
                unit => format!("{key}, {unit}"),
            },
            StudyColumn::Figure(figure) => figure.title(units),
        }
    }

    /// What a column is, with what the window calls the values of its key, where that is another name.
    pub fn tip(&self, column: usize, units: DisplayUnits) -> String {
        let head = self.head(column, units);
        match &self.columns[column] {
            StudyColumn::Key(key) if matches!(key.as_str(), "plunge.axis" | "policy") => {
                let lines = AxisPolicy::ALL
                    .map(|policy| format!("\n{}: {} in the window", policy.name(), policy_label(policy)));
                head + &lines.concat()
            }
            _ => head,
        }
    }

    /// A run in words: its keys and the figures of the plot.
    pub fn describe(&self, row: usize, units: DisplayUnits) -> String {
        let keys = self.columns.iter().filter_map(|column| match column {
            StudyColumn::Key(key) => {
                let value = self.results.field(row, key).unwrap_or_default();
                Some(format!("{key} = {value} {}", unit_of_key(key)).trim_end().to_owned())
            }
            StudyColumn::Status | StudyColumn::Figure(_) => None,
        });
        let figure = |axis: &StudyFigure| {
            let value = axis.text(self.results.figure(row, axis.name), units);
            format!("{} {value} {}", axis.head, axis.unit(units))
        };
        keys.chain(self.axes.iter().map(figure)).collect::<Vec<_>>().join("\n")
    }

    /// The figures of a row on the axes of the plot, in the units in which they are shown.
    pub fn place(&self, row: usize, units: DisplayUnits) -> Option<(f64, f64)> {
        let [x, y] = self.axes.map(|axis| Some(axis.shown(self.results.figure(row, axis.name)?, units)));
        x.zip(y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::pareto::Table;

    fn table() -> StudyTable {
        let text = "id,part,status,plunge.step,time_estimate,residual_p95\n\
                    a,p.toml,done,10,600,2.0\nb,p.toml,done,8,900,1.0\nc,p.toml,error,6,,\n\
                    d,p.toml,done,4,1200,1.5\n";
        let table = Table::read_bytes("t.csv", text.as_bytes()).expect("a table");
        let results = StudyResults { path: "t.csv".into(), table, missing: None, folder: None };
        StudyTable::new(results)
    }

    #[test]
    fn numbers_sort_by_value_and_missing_ones_come_last() {
        let mut table = table();
        assert_eq!(table.columns[0], StudyColumn::Key("plunge.step".to_owned()), "{:?}", table.columns);
        table.sort_by(0);
        assert_eq!(table.order, [3, 2, 1, 0], "4 is less than 10");
        table.sort_by(0);
        assert_eq!(table.order, [0, 1, 2, 3]);
        let time = table.columns.iter().position(|c| *c == StudyColumn::Figure(SHOWN[0])).expect("time");
        table.sort_by(time);
        assert_eq!(table.order, [0, 1, 3, 2]);
        table.sort_by(time);
        assert_eq!(table.order, [3, 1, 0, 2], "what has no plan stays last");
        assert_eq!(table.cell(0, time, DisplayUnits::Metric), "10.0");
    }

    #[test]
    fn keys_have_the_unit_of_setup_files() {
        let table = table();
        for units in [DisplayUnits::Metric, DisplayUnits::Inch] {
            assert_eq!(table.head(0, units), "plunge.step, mm");
            assert!(
                table.describe(0, units).starts_with("plunge.step = 10 mm\n"),
                "{}",
                table.describe(0, units)
            );
        }
        for (key, unit) in [("tool.2.spindle", "rev/min"), ("plunge.axis", ""), ("part", "")] {
            assert_eq!(unit_of_key(key), unit);
        }
    }

    #[test]
    fn the_best_are_those_that_no_other_beats() {
        let mut table = table();
        assert_eq!(table.best, [0, 1], "the last is slower and leaves more than the one before");
        assert_eq!(table.place(1, DisplayUnits::Metric), Some((15.0, 1.0)));
        assert_eq!(table.place(2, DisplayUnits::Metric), None);
        table.set_axes([SHOWN[1], SHOWN[1]]);
        assert_eq!(table.best, [1]);
    }

    #[test]
    fn axis_strategies_are_named_as_in_the_window() {
        let text = "id,part,status,plunge.axis,time_estimate\na,p.toml,done,minimal,600\n";
        let table = Table::read_bytes("t.csv", text.as_bytes()).expect("a table");
        let results = StudyResults { path: "t.csv".into(), table, missing: None, folder: None };
        let table = StudyTable::new(results);
        let tip = table.tip(0, DisplayUnits::Metric);
        assert!(
            tip.starts_with("plunge.axis\n") && tip.contains("\nminimal: Min. stock in the window"),
            "{tip}"
        );
    }
}
