//! Which plunges the core of another one relies on.

use rayon::prelude::*;

use crate::cutting::contact::{BlankTop, Columns, PlungeColumn, core_interferes};
use crate::part::Blank;
use crate::plunge::PlungePlan;

/// The plunges of a plan with those before each that may have cut stock out of the way of its core.
pub(super) struct Cores<'a> {
    blank: &'a Blank,
    columns: Columns,
    /// Earlier plunges near the core of each, in cutting order.
    before: Vec<Vec<u32>>,
    /// Later plunges near whose core each one is.
    after: Vec<Vec<u32>>,
    /// Whether the core met stock in the whole plan already.
    met_before: Vec<bool>,
}

impl<'a> Cores<'a> {
    /// The cores of the plunges of `plan` in `blank`.
    pub fn new(plan: &PlungePlan, blank: &'a Blank) -> Self {
        let top = BlankTop::new(blank);
        let columns: Columns = plan
            .positions
            .iter()
            .map(|p| {
                let tool = &plan.sections[p.section].tool;
                PlungeColumn::new(tool.placed(p.tip, p.axis), tool.core_radius(), &top)
            })
            .collect();
        let near = |k: usize| columns.before(k).numbers_near(&columns.as_slice()[k]);
        let before: Vec<Vec<u32>> = (0..columns.len()).into_par_iter().map(near).collect();
        let mut after = vec![Vec::new(); columns.len()];
        for (k, earlier) in before.iter().enumerate() {
            for &number in earlier {
                after[number as usize].push(k as u32);
            }
        }
        let met_before = plan.positions.iter().map(|p| p.contact.interferes()).collect();
        Self { blank, columns, before, after, met_before }
    }

    /// The first plunge whose core would meet stock if `plunge` were left out of those that are `kept`.
    pub fn first_to_meet_without(&self, plunge: usize, kept: &[bool]) -> Option<usize> {
        let meets = |later: &usize| {
            let later = *later;
            if !kept[later] || self.met_before[later] {
                return false;
            }
            let all = self.columns.as_slice();
            let near = self.before[later]
                .iter()
                .map(|&number| number as usize)
                .filter(|&number| kept[number] && number != plunge);
            core_interferes(&all[later], near.map(|number| &all[number]), self.blank)
        };
        self.after[plunge].par_iter().map(|&later| later as usize).find_first(meets)
    }
}
