//! The table of positions: which rows it has, in which order, and the selection in it.

use super::AppState;
use crate::app::model::look::{Filter, Operation, REVEAL, TableColumn};
use crate::app::model::machine::AxisDemand;
use crate::plunge::{Condition, Position};

impl AppState {
    /// Positions that pass the filter, in table order.
    pub fn rows(&self) -> Vec<usize> {
        let Some(shown) = self.shown() else { return Vec::new() };
        let plan = shown.plan();
        let filter = self.look.filter;
        let passes = |k: usize, position: &Position| match filter {
            Filter::All => true,
            Filter::Interfering => position.condition() == Condition::Interfering,
            Filter::Blocked => position.condition() == Condition::Blocked,
            Filter::AxisWarnings => self.axis_demand(k).is_some_and(AxisDemand::is_warning),
        };
        let passing = plan.positions.iter().enumerate().filter(|(k, p)| passes(*k, p));
        let mut rows: Vec<(f64, usize)> = passing
            .map(|(k, p)| {
                let key = match self.look.sort.column {
                    TableColumn::Order => k as f64,
                    TableColumn::Row => p.section as f64 * 1e6 + p.row as f64,
                    TableColumn::Diameter => plan.sections.get(p.section).map_or(0.0, |s| s.tool.diameter),
                    TableColumn::Alpha => p.alpha_rad,
                    TableColumn::Contact => p.evaluation.contact.depth,
                    // Without floor under the cutter: sort as the smallest.
                    TableColumn::Hub => {
                        Some(shown.stock(k)).filter(|s| s.is_finite()).map_or(-1.0, f64::from)
                    }
                    TableColumn::Axes => self.axis_demand(k).map_or(0.0, AxisDemand::weight),
                };
                (key, k)
            })
            .collect();
        let descending = self.look.sort.descending;
        rows.sort_by(|a, b| {
            let order = a.0.total_cmp(&b.0);
            (if descending { order.reverse() } else { order }).then(a.1.cmp(&b.1))
        });
        rows.into_iter().map(|(_, k)| k).collect()
    }

    /// Scrolls the table to the selected position; clears a filter that hides it.
    pub fn show_in_table(&mut self) {
        if self.look.selected.is_some_and(|k| !self.rows().contains(&k)) {
            self.look.filter = Filter::All;
        }
        self.look.reveal_selection = REVEAL;
    }

    /// Selects the row `step` below the selected one in table order, clamped to the first and last row.
    pub fn select_next_row(&mut self, step: isize) {
        match self.look.operation {
            Operation::Roughing => {}
            Operation::Flank => return self.select_next_pass(step),
            Operation::Program => return self.select_next_finding(step, false),
        }
        let rows = self.rows();
        let Some(last) = rows.len().checked_sub(1) else { return };
        let now = self.look.selected.and_then(|k| rows.iter().position(|&row| row == k));
        let next = match now {
            None => 0,
            Some(now) => now.saturating_add_signed(step).min(last),
        };
        self.look.select_and_zoom(rows.get(next).copied());
    }

    /// Indices of the interfering plunges of the shown plan, in cutting order.
    pub fn interfering_plunges(&self) -> Vec<usize> {
        let positions = self.shown().map_or(&[][..], |shown| &shown.plan().positions);
        let interferes = |k: &usize| positions[*k].condition() == Condition::Interfering;
        (0..positions.len()).filter(interferes).collect()
    }

    /// Selects the next or previous interfering plunge in cutting order, with wrap-around.
    pub fn select_next_fault(&mut self, forward: bool) {
        if self.look.operation == Operation::Program {
            self.select_next_finding(if forward { 1 } else { -1 }, true);
            return;
        }
        let faults = self.interfering_plunges();
        let Some((&first, &last)) = faults.first().zip(faults.last()) else { return };
        let next = match (self.look.selected, forward) {
            (None, true) => first,
            (None, false) => last,
            (Some(now), true) => faults.iter().copied().find(|&k| k > now).unwrap_or(first),
            (Some(now), false) => faults.iter().copied().rev().find(|&k| k < now).unwrap_or(last),
        };
        self.look.select_and_zoom(Some(next));
    }
}
