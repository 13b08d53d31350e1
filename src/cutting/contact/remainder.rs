//! What earlier plunges leave of one line of a core, as disjoint intervals.

use super::crossed::{CoreLine, CrossedPlunge};

/// Maximum number of disjoint uncut intervals of one line.
const MAX_INTERVALS: usize = 12;

/// What plunges left of a line: uncut intervals and the first entry.
#[derive(Clone, Copy, Debug)]
pub struct LineRemainder {
    /// Intervals of height that none of them removed, mm.
    pub open: [(f64, f64); MAX_INTERVALS],
    pub count: usize,
    /// Lowest height at which one of them removed something, mm; infinite where none did.
    pub first: f64,
}

impl LineRemainder {
    /// The line from the bottom of the core up to `top`.
    pub fn whole(top: f64) -> Self {
        Self { open: [(0.0, top); MAX_INTERVALS], count: 1, first: f64::INFINITY }
    }

    /// Whether nothing is left and `first` is at most `deep`, so that further plunges change nothing
    /// relevant.
    pub fn is_complete(&self, deep: f64) -> bool {
        self.count == 0 && self.first <= deep
    }

    /// Height from which on an interval changes nothing, mm.
    #[inline]
    fn reach(&self) -> f64 {
        self.open[..self.count].last().map_or(self.first, |(_, top)| top.max(self.first))
    }

    /// Removes the interval that a plunge cut; whether it may have mattered.
    #[inline]
    pub fn remove(&mut self, crossed: &CrossedPlunge, line: &CoreLine) -> bool {
        let Some((low, high)) = crossed.removed_by_sharp_below(self.reach(), line) else { return false };
        // A rounded corner removes less than a sharp one, so the sharp interval is a quick reject.
        let is_open = self.open[..self.count].iter().any(|&(a, b)| low < b && high > a);
        if high <= 0.0 || low >= self.first && !is_open {
            return false;
        }
        let Some((low, high)) = crossed.round_corner(line, low, high) else { return false };
        if high > 0.0 {
            self.first = self.first.min(low);
        }
        if !is_open {
            return true;
        }
        let mut kept = [(0.0, 0.0); MAX_INTERVALS];
        let mut n = 0;
        for &(a, b) in &self.open[..self.count] {
            for piece in [(a, b.min(low)), (a.max(high), b)] {
                if piece.0 >= piece.1 {
                    continue;
                }
                if n < MAX_INTERVALS {
                    kept[n] = piece;
                    n += 1;
                } else {
                    // On the safe side: the gap before the piece counts as stock.
                    kept[n - 1].1 = piece.1;
                }
            }
        }
        (self.open, self.count) = (kept, n);
        true
    }
}
