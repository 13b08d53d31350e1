//! Which plunges the core of another one relies on.

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::cutting::contact::{Columns, PLANNED_CONTACT, PlungeColumn, core_contact_by, core_interferes};
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
    /// The kept plunges that clear the way of each core, ascending: while they stay, the others make no
    /// difference to it. Found with the first test of that core and anew with each later one, as the watched
    /// literals of a solver are. Most cores are near no plunge that a goal would leave out.
    needed: Vec<OnceLock<Vec<u32>>>,
}

/// A core that stays free, by its number, and the plunges that it needs then.
type FreeCore = (usize, Vec<u32>);

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
        let met_before = plan.positions.iter().map(|p| p.evaluation.contact.interferes()).collect();
        let needed = columns.as_slice().iter().map(|_| OnceLock::new()).collect();
        Self { blank, columns, before, after, met_before, needed }
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

    /// Leaves `plunge` out of those that are `kept` unless the core of a later one would meet stock then: by
    /// the quick test of planning, and what passes it by the one that plans are judged by.
    ///
    /// # Errors
    /// The first plunge whose core would.
    pub fn leave_out(&mut self, plunge: usize, kept: &mut [bool]) -> Result<(), usize> {
        let found = self.free_without(plunge, kept)?;
        kept[plunge] = false;
        for (core, needed) in found {
            self.needed[core] = OnceLock::from(needed);
        }
        Ok(())
    }

    /// The cores that need `plunge` and are free without it.
    fn free_without(&self, plunge: usize, kept: &[bool]) -> Result<Vec<FreeCore>, usize> {
        let stays = |number: usize| kept[number] && number != plunge;
        let needs = |core: &usize| {
            // As long as it is not known none of the plunges near the core has been left out.
            let needed = || self.needed[*core].get_or_init(|| self.contact(*core, |number| kept[number]).1);
            kept[*core] && !self.met_before[*core] && needed().binary_search(&(plunge as u32)).is_ok()
        };
        let concerned: Vec<usize> =
            self.after[plunge].par_iter().map(|&later| later as usize).filter(needs).collect();
        let meets = |core: &usize| {
            let (_, near) = self.near(*core, stays);
            core_interferes(&self.columns.as_slice()[*core], near.into_iter(), self.blank)
        };
        if let Some(&core) = concerned.par_iter().find_first(|core| meets(core)) {
            return Err(core);
        }
        let judged = concerned.into_par_iter().map(|core| match self.contact(core, stays) {
            (depth, _) if depth > PLANNED_CONTACT => Err(core),
            (_, needed) => Ok((core, needed)),
        });
        // In this order, whichever thread finds one first.
        judged.collect::<Vec<_>>().into_iter().collect()
    }

    /// Depth of contact of a core after the plunges that `stay`, mm, and those of them that clear its way.
    fn contact(&self, core: usize, stays: impl Fn(usize) -> bool) -> (f64, Vec<u32>) {
        let (mut numbers, near) = self.near(core, stays);
        let (depth, removed) = core_contact_by(&self.columns.as_slice()[core], near.into_iter(), self.blank);
        let mut removed = removed.into_iter();
        numbers.retain(|_| removed.next().unwrap_or(true));
        (depth, numbers)
    }

    /// The plunges near the core of `later` that `stay`, in cutting order: numbers and columns.
    fn near(&self, later: usize, stays: impl Fn(usize) -> bool) -> (Vec<u32>, Vec<&PlungeColumn>) {
        let of = |&number: &u32| {
            stays(number as usize).then(|| (number, &self.columns.as_slice()[number as usize]))
        };
        self.before[later].iter().filter_map(of).unzip()
    }
}
