//! What earlier plunges leave of one line of a core, as disjoint intervals.

use super::crossed::{CoreLine, CrossedPlunge, LineQuadratic};

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
        // Most plunges are rejected here: inlined, that costs no call.
        match crossed.quadratic_below(self.reach(), line) {
            None => false,
            Some(quadratic) => self.remove_crossed(crossed, line, quadratic),
        }
    }

    /// The rest of [`Self::remove`].
    #[inline(never)]
    fn remove_crossed(&mut self, crossed: &CrossedPlunge, line: &CoreLine, quadratic: LineQuadratic) -> bool {
        let Some((low, high)) = crossed.interval(quadratic) else { return false };
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
        self.cut(low, high);
        true
    }

    /// Removes (`low`, `high`).
    #[inline]
    fn cut(&mut self, low: f64, high: f64) {
        let mut n = 0;
        for i in 0..self.count {
            let (a, b) = self.open[i];
            if low > a && high < b {
                // It is inside this interval, and meets no other one.
                self.split(i, low, high);
                return;
            }
            let piece = if low <= a { (a.max(high), b) } else { (a, b.min(low)) };
            if piece.0 < piece.1 {
                self.open[n] = piece;
                n += 1;
            }
        }
        self.count = n;
    }

    /// Removes (`low`, `high`) from the inside of interval `i`.
    fn split(&mut self, i: usize, low: f64, high: f64) {
        const LAST: usize = MAX_INTERVALS - 1;
        let ((from, to), (_, top)) = (self.open[i], self.open[LAST]);
        let was_full = self.count == MAX_INTERVALS;
        if !was_full {
            self.open.copy_within(i + 1..self.count, i + 2);
            self.count += 1;
        } else if i < LAST {
            // On the safe side: the gap before the last interval counts as stock.
            self.open.copy_within(i + 1..LAST, i + 2);
        } else {
            return;
        }
        (self.open[i], self.open[i + 1]) = ((from, low), (high, to));
        if was_full {
            self.open[LAST].1 = top;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of `open` without (`low`, `high`), piece by piece into a new list.
    fn removed_anew(open: &[(f64, f64)], low: f64, high: f64) -> Vec<(f64, f64)> {
        let mut kept: Vec<(f64, f64)> = Vec::new();
        for &(a, b) in open {
            for piece in [(a, b.min(low)), (a.max(high), b)] {
                if piece.0 < piece.1 {
                    if kept.len() < MAX_INTERVALS {
                        kept.push(piece);
                    } else {
                        kept[MAX_INTERVALS - 1].1 = piece.1;
                    }
                }
            }
        }
        kept
    }

    #[test]
    fn intervals_are_removed_in_place_as_into_a_new_list() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut full = 0;
        for _ in 0..2000 {
            let mut left = LineRemainder::whole(1.0);
            for _ in 0..40 {
                let low = random();
                let high = low + 0.05 * random();
                let wanted = removed_anew(&left.open[..left.count], low, high);
                left.cut(low, high);
                assert_eq!(left.open[..left.count], wanted[..]);
                full += usize::from(left.count == MAX_INTERVALS);
            }
        }
        assert!(full > 1000, "{full} lines with all intervals");
    }
}
