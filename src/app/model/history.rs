//! Undo and redo: states of a value, of which one becomes a step once it has been stable for a while.

use std::collections::VecDeque;

/// How long a value must stay unchanged to become a step, s.
const STABLE_S: f64 = 1.0;
/// A value that keeps changing becomes a step after this time, s.
const STEP_AT_LEAST_EVERY_S: f64 = 30.0;
/// Maximum number of steps; the oldest are dropped first.
const MAX_STEPS: usize = 100;

/// The steps of a value.
#[derive(Clone, Debug)]
pub struct History<T> {
    /// The last is the latest step; the current value may be newer.
    undos: VecDeque<HistoryStep<T>>,
    redos: Vec<HistoryStep<T>>,
    /// A value that differs from the latest step, while it is not stable.
    change: Option<Change<T>>,
    /// The window's clock, s.
    now_s: f64,
}

/// A value, and when it became that, on the window's clock, s.
#[derive(Clone, Debug)]
struct HistoryStep<T> {
    value: T,
    changed_s: f64,
}

/// A value that changes.
#[derive(Clone, Debug)]
struct Change<T> {
    latest: T,
    /// Times on the window's clock, s.
    began: f64,
    changed: f64,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { undos: VecDeque::new(), redos: Vec::new(), change: None, now_s: 0.0 }
    }
}

impl<T: Clone + PartialEq> History<T> {
    /// Notes the current value; call once per frame. `time` in seconds.
    pub fn watch(&mut self, time: f64, now: &T) {
        self.now_s = time;
        let Some(last) = self.last() else {
            self.add(now);
            return;
        };
        if last == now {
            self.change = None;
            return;
        }
        self.redos.clear();
        let is_step = match &self.change {
            None => {
                self.change = Some(Change { latest: now.clone(), began: time, changed: time });
                false
            }
            Some(change) if change.latest == *now => time - change.changed >= STABLE_S,
            Some(change) => time - change.began >= STEP_AT_LEAST_EVERY_S,
        };
        if is_step {
            self.add(now);
        } else if let Some(change) = self.change.as_mut().filter(|change| change.latest != *now) {
            (change.latest, change.changed) = (now.clone(), time);
        }
    }

    /// Adds the current value as a step, unless it is the latest one.
    pub fn add(&mut self, now: &T) {
        let changed_s = self.newest_s(now);
        self.change = None;
        if self.last() == Some(now) {
            return;
        }
        self.undos.push_back(HistoryStep { value: now.clone(), changed_s });
        if self.undos.len() > MAX_STEPS {
            self.undos.pop_front();
        }
    }

    /// When the value changed last, s, where it has changed since the latest step.
    fn newest_s(&self, now: &T) -> f64 {
        let change = self.change.as_ref().filter(|change| change.latest == *now);
        change.map_or(self.now_s, |change| change.changed)
    }

    /// The latest step; `None` before the first.
    pub fn last(&self) -> Option<&T> {
        self.undos.back().map(|step| &step.value)
    }

    /// When the change came about that [`Self::undo`] takes back, on the window's clock, s; `None` where it
    /// takes back none.
    pub fn changed_s(&self, now: &T) -> Option<f64> {
        let last = self.undos.back()?;
        if last.value != *now {
            return Some(self.newest_s(now));
        }
        (self.undos.len() > 1).then_some(last.changed_s)
    }

    /// Likewise for the change that [`Self::redo`] makes again; none where the value has changed since.
    pub fn undone_s(&self, now: &T) -> Option<f64> {
        self.redos.last().filter(|_| self.last() == Some(now)).map(|step| step.changed_s)
    }

    /// Whether there is a step before the current value.
    pub fn can_undo(&self, now: &T) -> bool {
        self.changed_s(now).is_some()
    }

    /// Whether there is a step that was undone, and the value has not changed since.
    pub fn can_redo(&self, now: &T) -> bool {
        self.undone_s(now).is_some()
    }

    /// The value before the current one; `None` without one.
    pub fn undo(&mut self, now: &T) -> Option<T> {
        let changed_s = self.changed_s(now)?;
        self.change = None;
        if self.last() == Some(now) {
            self.undos.pop_back();
        }
        self.redos.push(HistoryStep { value: now.clone(), changed_s });
        self.last().cloned()
    }

    /// The value that was undone last; `None` without one.
    pub fn redo(&mut self, now: &T) -> Option<T> {
        if !self.can_redo(now) {
            return None;
        }
        let next = self.redos.pop()?;
        self.undos.push_back(next.clone());
        Some(next.value)
    }
}

#[cfg(test)]
mod tests {
    use super::History;

    #[test]
    fn a_drag_is_one_step_and_redo_ends_with_a_new_change() {
        let mut history = History::default();
        history.watch(0.0, &1);
        assert!(!history.can_undo(&1));
        for (time, value) in [(0.1, 2), (0.2, 3), (0.3, 4), (1.2, 4), (1.3, 4)] {
            history.watch(time, &value);
        }
        assert_eq!(history.undo(&4), Some(1), "the values between are no steps");
        assert_eq!(history.undo(&1), None);
        assert_eq!(history.redo(&1), Some(4));
        // A change that is not stable yet can be undone, too.
        history.watch(2.0, &5);
        assert_eq!(history.undo(&5), Some(4));
        assert!(history.can_redo(&4));
        history.watch(2.1, &6);
        assert!(!history.can_redo(&6), "a new change");
        history.add(&6);
        assert_eq!(history.undo(&6), Some(4));
    }

    #[test]
    fn steps_know_when_they_came_about() {
        let mut history = History::default();
        for (time, value) in [(0.0, 1), (2.0, 2), (3.5, 2), (5.0, 3)] {
            history.watch(time, &value);
        }
        assert_eq!(history.changed_s(&3), Some(5.0), "not stable yet");
        assert_eq!((history.undo(&3), history.changed_s(&2)), (Some(2), Some(2.0)));
        assert_eq!((history.undo(&2), history.changed_s(&1)), (Some(1), None));
        assert_eq!((history.undone_s(&1), history.redo(&1)), (Some(2.0), Some(2)));
        assert_eq!((history.undone_s(&2), history.changed_s(&2)), (Some(5.0), Some(2.0)));
    }

    #[test]
    fn a_value_that_never_rests_becomes_a_step_in_the_end() {
        let mut history = History::default();
        for tenth in 0..=310 {
            history.watch(0.1 * f64::from(tenth), &tenth);
        }
        let before = history.undo(&310).expect("a step");
        assert!((295..=305).contains(&before), "{before}");
    }
}
