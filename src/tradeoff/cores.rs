//! Which plunges the core of another one relies on.

use rayon::prelude::*;

use crate::cutting::contact::{Columns, PLANNED_CONTACT, PlungeColumn, core_contact_among, core_interferes};
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
        let columns = plan.columns(blank);
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

    /// The columns of the plunges that are `kept`.
    pub fn columns_of(&self, kept: &[bool]) -> Columns {
        self.columns
            .as_slice()
            .iter()
            .zip(kept)
            .filter(|(_, kept)| **kept)
            .map(|(column, _)| *column)
            .collect()
    }

    /// The first plunge whose core would meet stock if `plunge` were left out of those that are `kept`: by the quick
    /// test of planning, and what passes it by the one that plans are judged by.
    pub fn first_to_meet_without(&self, plunge: usize, kept: &[bool]) -> Option<usize> {
        let quick = |later: &usize| {
            core_interferes(&self.columns.as_slice()[*later], self.near(*later, plunge, kept), self.blank)
        };
        let full = |later: &usize| {
            let column = &self.columns.as_slice()[*later];
            core_contact_among(column, self.near(*later, plunge, kept), self.blank) > PLANNED_CONTACT
        };
        let concerned = || {
            let later = self.after[plunge].par_iter().map(|&later| later as usize);
            later.filter(|&later| kept[later] && !self.met_before[later])
        };
        concerned().find_first(quick).or_else(|| concerned().find_first(full))
    }

    /// The kept plunges near the core of `later`, without `plunge`, in cutting order.
    fn near<'k>(
        &'k self,
        later: usize,
        plunge: usize,
        kept: &'k [bool],
    ) -> impl DoubleEndedIterator<Item = &'k PlungeColumn> {
        let numbers = self.before[later].iter().map(|&number| number as usize);
        let kept = numbers.filter(move |&number| kept[number] && number != plunge);
        kept.map(|number| &self.columns.as_slice()[number])
    }
}
