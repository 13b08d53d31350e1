//! The earlier plunges that may meet a core, and what they remove of its lines.

use super::columns::PlungeColumn;
use super::crossed::{CoreFrame, CoreLine, CrossedPlunge};
use super::remainder::LineRemainder;

/// Capacity of the list of [`Neighbours::entered_below`]; where more plunges are found, all are evaluated.
const MAX_ENTERED: usize = 24;

/// The earlier plunges that may meet a core column.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Latest first, until lines move those that they met to the front.
    columns: Vec<CrossedPlunge>,
    /// Plunges cut after all of `columns`.
    passed: Vec<CrossedPlunge>,
    frame: CoreFrame,
}

impl Neighbours {
    /// The neighbours of `column`: the `earlier` plunges that may meet it, in cutting order.
    pub fn around<'c>(
        column: &PlungeColumn,
        earlier: impl DoubleEndedIterator<Item = &'c PlungeColumn>,
    ) -> Self {
        let mut near = Self::default();
        near.gather(column, earlier);
        near
    }

    /// Where the core is.
    pub fn frame(&self) -> CoreFrame {
        self.frame
    }

    /// As [`Self::around`], reusing the existing allocation.
    pub fn gather<'c>(
        &mut self,
        column: &PlungeColumn,
        earlier: impl DoubleEndedIterator<Item = &'c PlungeColumn>,
    ) {
        self.frame = CoreFrame::from_cutter(&column.cutter);
        self.columns.clear();
        self.passed.clear();
        let crossed =
            |(number, c): (usize, &PlungeColumn)| CrossedPlunge::new(number, &c.cutter, &self.frame);
        self.columns.extend(earlier.rev().enumerate().map(crossed));
    }

    /// Replaces the plunges cut after the gathered ones by `passed`, in cutting order.
    pub fn set_passed<'c>(&mut self, passed: impl DoubleEndedIterator<Item = &'c PlungeColumn>) {
        self.passed.clear();
        let crossed =
            |(number, c): (usize, &PlungeColumn)| CrossedPlunge::new(number, &c.cutter, &self.frame);
        self.passed.extend(passed.rev().enumerate().map(crossed));
    }

    /// Number of gathered plunges.
    pub fn count(&self) -> usize {
        self.columns.len()
    }

    /// Removes from `left` what the gathered plunges cut; stops as soon as further ones change nothing
    /// relevant. `note` gets the numbers of those that mattered, 0 for the latest.
    ///
    /// The order of the plunges does not matter. Those that did are moved to the front: the next line is
    /// mostly beside this one, and the same few plunges leave nothing of it.
    pub fn cut_line(
        &mut self,
        left: &mut LineRemainder,
        line: &CoreLine,
        deep: f64,
        mut note: impl FnMut(usize),
    ) {
        let mut front = 0;
        for index in 0..self.columns.len() {
            if left.is_complete(deep) {
                break;
            }
            if left.remove(&self.columns[index], line) {
                note(self.columns[index].number);
                self.columns.swap(index, front);
                front += 1;
            }
        }
    }

    /// Removes from `left` what the plunges after the gathered ones cut, as [`Self::cut_line`].
    pub fn cut_line_by_passed(&self, left: &mut LineRemainder, line: &CoreLine, deep: f64) {
        for crossed in &self.passed {
            if left.is_complete(deep) {
                break;
            }
            left.remove(crossed, line);
        }
    }

    /// Lowest height at which the line enters removed stock, mm, infinite if it does not, and the number of
    /// the plunge that removed it.
    pub fn first_entry(&self, line: &CoreLine) -> (f64, usize) {
        first_entry(self.passed.iter().chain(&self.columns), line)
    }

    /// The plunges that one of `lines` enters below `height`. On lines between these, the first entry is into
    /// one of them.
    pub fn entered_below(&self, height: f64, lines: &[CoreLine]) -> Entered<'_> {
        let mut entered = Entered { near: self, numbers: [0; MAX_ENTERED], count: 0 };
        for (number, crossed) in self.passed.iter().chain(&self.columns).enumerate() {
            let enters = |line| crossed.removed_by_sharp(line).is_some_and(|(low, _)| low < height);
            if lines.iter().any(enters) {
                if entered.count < MAX_ENTERED {
                    entered.numbers[entered.count] = number;
                }
                entered.count += 1;
            }
        }
        entered
    }

    /// Plunge `number` of passed and gathered ones, latest first.
    fn get(&self, number: usize) -> &CrossedPlunge {
        let later = self.passed.len();
        if number < later { &self.passed[number] } else { &self.columns[number - later] }
    }
}

/// The few plunges of [`Neighbours`] that some lines enter first.
pub struct Entered<'n> {
    near: &'n Neighbours,
    numbers: [usize; MAX_ENTERED],
    count: usize,
}

impl Entered<'_> {
    /// As [`Neighbours::first_entry`], among these plunges.
    pub fn first_entry(&self, line: &CoreLine) -> (f64, usize) {
        match self.numbers.get(..self.count) {
            Some(numbers) => first_entry(numbers.iter().map(|&number| self.near.get(number)), line),
            None => self.near.first_entry(line),
        }
    }
}

fn first_entry<'c>(plunges: impl Iterator<Item = &'c CrossedPlunge>, line: &CoreLine) -> (f64, usize) {
    let mut first = (f64::INFINITY, 0);
    for crossed in plunges {
        if let Some((low, high)) = crossed.removed_by_sharp(line)
            && low < first.0
            && let Some((low, high)) = crossed.round_corner(line, low, high)
            && high > 0.0
            && low < first.0
        {
            first = (low, crossed.number);
        }
    }
    first
}
