//! Points of the curve of time against stock.

use super::Thinning;
use super::limits::AS_GOOD;
use crate::setup::Goal;

/// A point of the curve: a plan, not yet made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TradeoffPoint {
    /// Plunges left out of the whole plan.
    pub left_out: usize,
    /// Time of one channel, s.
    pub time_s: f64,
    /// Mean residual stock, mm.
    pub residual_mean: f64,
    /// 95th percentile of the residual stock, mm.
    pub residual_p95: f64,
}

/// Points by which `Goal::Balance` looks for the bend of the curve.
const BALANCE_POINTS: usize = 24;

impl Thinning<'_> {
    /// The point without the first `count` plunges.
    pub fn point(&self, count: usize) -> TradeoffPoint {
        let stock = self.stock_without(count);
        TradeoffPoint {
            left_out: count,
            time_s: self.time_without(count),
            residual_mean: f64::from(stock.mean),
            residual_p95: f64::from(stock.p95),
        }
    }

    /// `count` points from the whole plan to the thinnest one, evenly in time; fewer where they fall
    /// together.
    pub fn points(&self, count: usize) -> Vec<TradeoffPoint> {
        let (slow, fast) = (self.time_without(0), self.time_without(self.len()));
        let mut counts: Vec<usize> = (0..count)
            .map(|k| {
                let share = k as f64 / (count.max(2) - 1) as f64;
                self.first_within_time(slow + (fast - slow) * share)
            })
            .collect();
        counts.dedup();
        counts.into_iter().map(|count| self.point(count)).collect()
    }

    /// The least number of plunges to leave out for a time of at most `time_s`; all that can be where that is
    /// not enough. Bisection: time falls with every plunge that goes.
    fn first_within_time(&self, time_s: f64) -> usize {
        let too_long = |count: usize| self.time_without(count) > time_s * (1.0 + 1e-12);
        if too_long(0) { (self.last_where(too_long) + 1).min(self.len()) } else { 0 }
    }

    /// The most plunges that can go before mean or 95th percentile of the stock above the allowance rise by
    /// more than [`AS_GOOD`].
    fn last_as_good(&self) -> usize {
        let whole = self.stock_without(0);
        let limit = |figure: f32| {
            let allowance = self.hub_allowance();
            allowance + (f64::from(figure) - allowance).max(0.0) * (1.0 + AS_GOOD)
        };
        let (mean, p95) = (limit(whole.mean), limit(whole.p95));
        let is_worse = |count| {
            let stock = self.stock_without(count);
            f64::from(stock.mean) > mean || f64::from(stock.p95) > p95
        };
        self.last_where(|count| !is_worse(count))
    }

    /// The greatest count for which `holds`, which holds for all counts below it too; 0 if for none.
    fn last_where(&self, holds: impl Fn(usize) -> bool) -> usize {
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = (low + high).div_ceil(2);
            if holds(middle) { low = middle } else { high = middle - 1 }
        }
        low
    }
}

/// The number of plunges to leave out for `goal`.
pub fn choose_point(thinning: &Thinning, goal: Goal) -> usize {
    match goal {
        Goal::Stock { max_time_min: None } => thinning.last_as_good(),
        Goal::Stock { max_time_min: Some(minutes) } => {
            thinning.first_within_time(60.0 * minutes).max(thinning.last_as_good())
        }
        Goal::Time { max_stock } => {
            let allowance = thinning.hub_allowance();
            let too_much = |count| f64::from(thinning.stock_without(count).p95) - allowance > max_stock;
            thinning.last_where(|count| !too_much(count))
        }
        Goal::Balance => bend(&thinning.points(BALANCE_POINTS)),
    }
}

/// The point furthest below the chord from the first to the last point, both axes scaled to it.
fn bend(points: &[TradeoffPoint]) -> usize {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return 0 };
    let (time, stock) = (first.time_s - last.time_s, last.residual_p95 - first.residual_p95);
    if time <= 0.0 || stock <= 0.0 {
        return last.left_out;
    }
    let below =
        |p: &TradeoffPoint| (first.time_s - p.time_s) / time - (p.residual_p95 - first.residual_p95) / stock;
    points.iter().max_by(|a, b| below(a).total_cmp(&below(b))).map_or(0, |point| point.left_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bend_is_where_more_time_buys_little() {
        let point = |left_out, time_s, residual_p95| TradeoffPoint {
            left_out,
            time_s,
            residual_mean: 0.0,
            residual_p95,
        };
        let points = [point(0, 100.0, 1.0), point(10, 60.0, 1.1), point(20, 50.0, 1.3), point(30, 40.0, 4.0)];
        assert_eq!(bend(&points), 20);
        assert_eq!(bend(&points[..1]), 0);
        assert_eq!(bend(&[]), 0);
    }
}
