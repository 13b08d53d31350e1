//! The goals of a plan as they were given last: who looks at another one and comes back finds the own values.

use crate::setup::{Goal, SemiFinishing};

/// Goals of different kinds, the latest last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnownGoals(Vec<Goal>);

/// Whether two goals have the same values to give.
fn are_alike(a: &Goal, b: &Goal) -> bool {
    use SemiFinishing::{Passes, Rate};
    match (a, b) {
        (Goal::Total { finishing: a }, Goal::Total { finishing: b }) => {
            matches!((a, b), (Rate { .. }, Rate { .. }) | (Passes { .. }, Passes { .. }))
        }
        _ => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}

impl KnownGoals {
    /// Keeps `goal` for its kind.
    pub fn note(&mut self, goal: Goal) {
        self.0.retain(|known| !are_alike(known, &goal));
        self.0.push(goal);
    }

    /// The latest goal that `is_it`.
    pub fn latest(&self, is_it: impl Fn(&Goal) -> bool) -> Option<Goal> {
        self.0.iter().rev().find(|goal| is_it(goal)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_goal_of_each_kind_is_known() {
        let rate = |mm3_per_min| Goal::Total { finishing: SemiFinishing::Rate { mm3_per_min } };
        let passes = Goal::Total { finishing: SemiFinishing::Passes { depth: 0.3, pass_time_min: 7.0 } };
        let mut known = KnownGoals::default();
        for goal in [rate(900.0), Goal::Time { max_stock: 0.8 }, passes, rate(700.0), Goal::Balance] {
            known.note(goal);
        }
        let is_total = |goal: &Goal| matches!(goal, Goal::Total { .. });
        assert_eq!(known.latest(is_total), Some(rate(700.0)));
        assert_eq!(known.latest(|goal| is_total(goal) && *goal != rate(700.0)), Some(passes));
        assert_eq!(known.latest(|goal| matches!(goal, Goal::Stock { .. })), None);
    }
}
