//! The Pareto set of a merged study: rows that no other row of the same part beats in every figure.

use std::collections::BTreeMap;

use super::csv::records;
use super::result::{FIGURES, MACHINE_TIME, RunStatus};
use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::io::source::{quote_for_message, read_bytes_up_to};
use crate::io::table::known_or_none;

/// Maximum size of a table, bytes.
pub const MAX_TABLE_BYTES: usize = 512 << 20;
/// Maximum number of figures.
const MAX_FIGURES: usize = 8;

/// The table of a study, as merged.
#[derive(Clone, Debug)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Fields of each row, as many as columns.
    pub rows: Vec<Vec<String>>,
}

/// The Pareto set of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParetoSet {
    /// Indices of the rows of the set: part by part in the order of the table, in each by the first figure.
    pub rows: Vec<usize>,
    /// Number of rows that were compared.
    pub compared: usize,
    /// Number of rows left out: no plan, a plan with faults, or a figure that is missing.
    pub left_out: usize,
}

impl Table {
    /// Reads a merged table.
    ///
    /// # Errors
    /// When the file cannot be read or is not such a table.
    pub fn read(path: &std::path::Path) -> Result<Self, InputError> {
        let bytes = read_bytes_up_to(path, MAX_TABLE_BYTES)?;
        Self::read_bytes(&path.display().to_string(), &bytes)
    }

    /// Reads a table from bytes; `name` is the file name used in messages.
    ///
    /// # Errors
    /// When the bytes are not such a table.
    pub fn read_bytes(name: &str, bytes: &[u8]) -> Result<Self, InputError> {
        let help = "give the table that `vanecut study merge` wrote";
        let fault =
            |line: usize, what: String| InputError::new(ErrorCode::StudyResults, name, line, what, help);
        let text = std::str::from_utf8(bytes).map_err(|_| fault(0, "is not UTF-8 text".to_owned()))?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut records = records(text).map_err(|(line, what)| fault(line, what))?.into_iter();
        let Some((_, columns)) = records.next() else { return Err(fault(0, "is empty".to_owned())) };
        let mut rows = Vec::with_capacity(records.len());
        for (line, row) in records {
            if row.len() != columns.len() {
                return Err(fault(line, format!("has {} fields, not {}", row.len(), columns.len())));
            }
            rows.push(row);
        }
        for needed in ["part", "status"] {
            if !columns.iter().any(|column| column == needed) {
                return Err(fault(1, format!("has no column `{needed}`")));
            }
        }
        Ok(Self { columns, rows })
    }

    /// Place of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// The figure that tells how long plans take: the time on the machine where each plan has one, else the
    /// estimate.
    pub fn time_figure(&self) -> &'static str {
        let has_time = |place: usize| {
            let (status, mut rows) = (self.column("status"), self.rows.iter());
            let is_plan = |row: &Vec<String>| status.is_none_or(|at| row[at] != RunStatus::Error.name());
            rows.all(|row| !is_plan(row) || !row[place].is_empty())
        };
        match self.column(MACHINE_TIME) {
            Some(place) if has_time(place) => MACHINE_TIME,
            _ => "time_estimate",
        }
    }

    /// Figures that are compared unless others are named.
    pub fn default_figures(&self) -> [&'static str; 2] {
        [self.time_figure(), "residual_p95"]
    }

    /// The Pareto set over `figures`, of each of which less is better. Parts are not compared.
    ///
    /// # Errors
    /// When a figure is not a column of figures.
    pub fn pareto(&self, figures: &[&str]) -> Result<ParetoSet, UserError> {
        if figures.is_empty() || figures.len() > MAX_FIGURES {
            let what = format!("{} figures are compared", figures.len());
            return Err(UserError::new(ErrorCode::Arguments, what, format!("name 1 to {MAX_FIGURES}")));
        }
        let mut places = Vec::with_capacity(figures.len());
        for figure in figures {
            let place = self.column(figure).filter(|_| FIGURES.contains(figure));
            places.push(place.ok_or_else(|| {
                let what = format!("{} is not a figure of the table", quote_for_message(figure));
                UserError::new(ErrorCode::UnknownName, what, known_or_none("figure", figure, &FIGURES))
            })?);
        }
        let (part, status) = (self.column("part"), self.column("status"));
        let field =
            |row: usize, place: Option<usize>| place.map_or("", |place| self.rows[row][place].as_str());
        let mut by_part: BTreeMap<usize, Vec<(Vec<f64>, usize)>> = BTreeMap::new();
        let mut first_of: BTreeMap<&str, usize> = BTreeMap::new();
        let mut compared = 0;
        for row in 0..self.rows.len() {
            let number =
                |place: &usize| field(row, Some(*place)).parse().ok().filter(|x: &f64| x.is_finite());
            let numbers: Option<Vec<f64>> = places.iter().map(number).collect();
            let Some(numbers) = numbers.filter(|_| field(row, status) == RunStatus::Done.name()) else {
                continue;
            };
            compared += 1;
            let first = *first_of.entry(field(row, part)).or_insert(row);
            by_part.entry(first).or_default().push((numbers, row));
        }
        let rows = by_part.into_values().flat_map(non_dominated).collect();
        Ok(ParetoSet { rows, compared, left_out: self.rows.len() - compared })
    }
}

/// The points that no other point dominates, in lexicographic order. In that order a point is dominated only
/// by points before it, and if by any, then by one of the set; of two figures, by the last one of the set,
/// which has the least second figure so far.
fn non_dominated(mut points: Vec<(Vec<f64>, usize)>) -> Vec<usize> {
    points.sort_by(|(a, at), (b, bt)| {
        let figures = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
        figures.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then).then(at.cmp(bt))
    });
    let mut set: Vec<(Vec<f64>, usize)> = Vec::new();
    for point in points {
        let from = if point.0.len() <= 2 { set.len().saturating_sub(1) } else { 0 };
        if !set[from..].iter().rev().any(|(other, _)| dominates(other, &point.0)) {
            set.push(point);
        }
    }
    set.into_iter().map(|(_, row)| row).collect()
}

/// Whether `a` is nowhere worse than `b`, and somewhere better.
fn dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table of pseudo-random figures on a coarse grid, so that many are equal.
    fn table(rows: usize, seed: u64) -> Table {
        let columns = ["part", "status", "time_estimate", "residual_p95", "uncut_share"];
        let mut state = seed;
        let mut next = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let row = |_| {
            let part = ["a", "b"][next(2) as usize];
            let status = ["done", "done", "done", "faults", "error"][next(5) as usize];
            let figure = |value: u64| if value == 0 { String::new() } else { value.to_string() };
            vec![part.to_owned(), status.to_owned(), figure(next(12)), figure(next(12)), figure(next(12))]
        };
        Table { columns: columns.map(str::to_owned).to_vec(), rows: (0..rows).map(row).collect() }
    }

    /// Every pair of comparable rows.
    fn plain(table: &Table, places: &[usize]) -> Vec<usize> {
        let usable =
            |row: &Vec<String>| row[1] == "done" && places.iter().all(|&place| !row[place].is_empty());
        let value = |row: &Vec<String>, place: usize| row[place].parse::<u32>().unwrap();
        let beats = |a: &Vec<String>, b: &Vec<String>| {
            a[0] == b[0]
                && places.iter().all(|&p| value(a, p) <= value(b, p))
                && places.iter().any(|&p| value(a, p) < value(b, p))
        };
        let rows: Vec<usize> = (0..table.rows.len()).filter(|&row| usable(&table.rows[row])).collect();
        let beaten = |&row: &usize| rows.iter().any(|&other| beats(&table.rows[other], &table.rows[row]));
        rows.iter().copied().filter(|row| !beaten(row)).collect()
    }

    #[test]
    fn the_set_is_that_of_all_pairs() {
        let mut sizes = Vec::new();
        for seed in 0..60 {
            let table = table(1 + 3 * seed as usize, seed);
            for places in [&[2][..], &[2, 3], &[3, 2], &[4, 2, 3]] {
                let figures: Vec<&str> = places.iter().map(|&place| table.columns[place].as_str()).collect();
                let set = table.pareto(&figures).unwrap();
                let mut rows = set.rows.clone();
                rows.sort_unstable();
                assert_eq!(rows, plain(&table, places), "seed {seed}, {figures:?}");
                assert_eq!(set.compared + set.left_out, table.rows.len());
                sizes.push(rows.len());
            }
        }
        assert!(sizes.iter().max() > Some(&10), "the sets must be large enough to mean something");
    }

    #[test]
    fn unknown_figures_and_damaged_tables_are_refused() {
        let error = table(3, 1).pareto(&["time_estimat"]).unwrap_err();
        assert_eq!(error.code, ErrorCode::UnknownName, "{error}");
        assert!(error.help.contains("`time_estimate`"), "{error}");
        assert!(table(3, 1).pareto(&["status"]).is_err());
        assert!(table(3, 1).pareto(&[]).is_err());
        for (bytes, words) in [
            (&b""[..], "is empty"),
            (b"\xff", "UTF-8"),
            (b"part,status\na", "2: has 1 fields, not 2"),
            (b"id,status\n", "no column `part`"),
            (b"part,status\n\"a,done\n", "2: a quoted field has no end"),
        ] {
            let error = Table::read_bytes("r.csv", bytes).unwrap_err().to_string();
            assert!(error.contains(words) && error.contains("study merge"), "{error}");
        }
    }
}
