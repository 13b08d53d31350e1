//! Points of the curve of time against stock.

use std::cmp::Ordering;

use super::Thinning;
use super::limits::AS_GOOD;
use crate::setup::{Goal, SemiFinishing};
use crate::stock::ExcessStock;

/// Times at which `Goal::Balance` looks for the bend of the curve, and `Goal::Total` for the least total.
const GOAL_POINTS: usize = 24;
/// Most passes of semi-finishing whose plans `Goal::Total` compares.
const MAX_PASSES: usize = 64;

/// A point of the curve: a plan, not yet made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TradeoffPoint {
    /// The plan that it is made of, see [`Tradeoff::thinning`].
    pub plan: usize,
    /// Plunges left out of that plan.
    pub left_out: usize,
    /// Time of one channel, s.
    pub time_s: f64,
    /// Mean residual stock, mm.
    pub residual_mean: f64,
    /// 95th percentile of the residual stock, mm.
    pub residual_p95: f64,
    /// Stock above the allowance of the hub.
    pub excess: ExcessStock,
}

impl TradeoffPoint {
    /// Time of one channel with that of `finishing`, s.
    pub fn total_s(&self, finishing: &SemiFinishing) -> f64 {
        self.time_s + finishing.time_s(self.excess.volume, self.excess.p95)
    }
}

/// Plans of the same channel, each with the order in which its plunges are left out. Their curves together
/// are the curve of time against stock: where plunges are few, a plan of fewer rows is ahead of one that was
/// thinned.
pub struct Tradeoff<'a> {
    /// The one with the least stock first.
    thinnings: Vec<Thinning<'a>>,
}

impl<'a> Tradeoff<'a> {
    /// The curve of a plan of the least stock, thinned by `thinning`.
    pub fn new(thinning: Thinning<'a>) -> Self {
        Self { thinnings: vec![thinning] }
    }

    /// The curve with that of a further plan; unless that leaves more of the floor uncut than is allowed.
    pub fn and(mut self, thinning: Thinning<'a>) -> Self {
        if thinning.uncut_share() <= self.thinnings[0].max_uncut_share() {
            self.thinnings.push(thinning);
        }
        self
    }

    /// Whether a stop ended the search for the order of one of the plans.
    pub fn is_cut_short(&self) -> bool {
        self.thinnings.iter().any(Thinning::is_cut_short)
    }

    /// The order of plan `number`.
    pub fn thinning(&self, number: usize) -> &Thinning<'a> {
        &self.thinnings[number]
    }

    /// At most `count` points from the first plan, with all of its plunges, to the fastest, evenly in time;
    /// fewer where they fall together.
    pub fn points(&self, count: usize) -> Vec<TradeoffPoint> {
        let times = even_times(self.time_range(), count);
        let mut points: Vec<TradeoffPoint> =
            times.filter_map(|time_s| self.within(time_s).min_by(by_stock)).collect();
        points.dedup_by_key(|point| (point.plan, point.left_out));
        points
    }

    /// The point with the least time of plunging and `finishing`: the best at some times, and at more between
    /// the neighbours of that one. The total need not have one minimum only.
    fn min_total(&self, finishing: &SemiFinishing) -> Option<TradeoffPoint> {
        let least = |points: &[TradeoffPoint]| {
            points.iter().min_by(|a, b| a.total_s(finishing).total_cmp(&b.total_s(finishing))).copied()
        };
        let [slow, fast] = self.time_range();
        let first = least(&self.points_at([slow, fast]))?;
        let apart = (slow - fast) / (GOAL_POINTS - 1) as f64;
        let around = [(first.time_s + apart).min(slow), (first.time_s - apart).max(fast)];
        let mut points = self.points_at(around);
        points.push(first);
        if let SemiFinishing::Passes { depth, .. } = *finishing {
            // The time of passes rises in steps: the last plan before each of them counts.
            let most =
                self.all(|thinning| Some(thinning.len())).map(|point| point.excess.p95).fold(0.0, f64::max);
            let passes = ((most / depth).ceil() as usize + 1).min(MAX_PASSES);
            let rise = |passes: usize| self.thinnings[0].hub_allowance() + depth * passes as f64 - 1e-9;
            let last = |passes| self.all(move |thinning| thinning.last_within_stock(rise(passes)));
            points.extend((0..=passes).flat_map(last));
        }
        least(&points)
    }

    /// The points of all plans at [`GOAL_POINTS`] times in `range`, s.
    fn points_at(&self, range: [f64; 2]) -> Vec<TradeoffPoint> {
        even_times(range, GOAL_POINTS).flat_map(|time_s| self.within(time_s)).collect()
    }

    /// Times of the first plan, with all of its plunges, and of the fastest, s.
    fn time_range(&self) -> [f64; 2] {
        let slow = self.thinnings[0].time_without(0);
        [slow, self.thinnings.iter().map(|t| t.time_without(t.len())).fold(slow, f64::min)]
    }

    /// The slowest point of each plan within `time_s`; none of a plan that is not as fast.
    fn within(&self, time_s: f64) -> impl Iterator<Item = TradeoffPoint> {
        let points = self.all(move |thinning| Some(thinning.first_within_time(time_s)));
        points.filter(move |point| !is_longer(point.time_s, time_s))
    }

    /// The point of each plan at the count that `choose` gives.
    fn all<'c>(
        &'c self,
        choose: impl Fn(&Thinning<'a>) -> Option<usize> + 'c,
    ) -> impl Iterator<Item = TradeoffPoint> + 'c {
        self.thinnings.iter().enumerate().filter_map(move |(number, thinning)| {
            Some(TradeoffPoint { plan: number, ..thinning.point(choose(thinning)?) })
        })
    }

    /// Whether a point meets `goal`.
    pub fn reaches(&self, goal: Goal) -> bool {
        match goal {
            Goal::Stock { max_time_min: Some(minutes) } => {
                let mut fastest = self.all(|thinning| Some(thinning.len()));
                fastest.any(|point| !is_longer(point.time_s, 60.0 * minutes))
            }
            Goal::Time { max_stock } => {
                let limit = self.thinnings[0].hub_allowance() + max_stock;
                self.all(|thinning| thinning.last_within_stock(limit)).next().is_some()
            }
            Goal::Stock { max_time_min: None } | Goal::Balance | Goal::Total { .. } => true,
        }
    }

    /// The point for `goal`; where none meets it, the one that comes nearest.
    pub fn choose(&self, goal: Goal) -> TradeoffPoint {
        let first = &self.thinnings[0];
        let chosen = match goal {
            Goal::Stock { max_time_min } => {
                let good = first.point(first.last_as_good());
                let limit = 60.0 * max_time_min.unwrap_or(f64::INFINITY);
                if is_longer(good.time_s, limit) {
                    let within = self.within(limit).min_by(by_stock);
                    within.or_else(|| self.all(|thinning| Some(thinning.len())).min_by(by_time))
                } else {
                    Some(good)
                }
            }
            Goal::Time { max_stock } => {
                let limit = first.hub_allowance() + max_stock;
                self.all(|thinning| thinning.last_within_stock(limit)).min_by(by_time)
            }
            Goal::Balance => bend(&self.points(GOAL_POINTS)),
            Goal::Total { finishing } => self.min_total(&finishing),
        };
        chosen.unwrap_or_else(|| first.point(0))
    }
}

/// `count` times from one end of a range to the other, s.
fn even_times([from, to]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| from + (to - from) * (k as f64 / (count.max(2) - 1) as f64))
}

/// Whether a time is longer than the limit, both s.
fn is_longer(time_s: f64, limit_s: f64) -> bool {
    time_s > limit_s * (1.0 + 1e-12)
}

/// Less stock first, then less time.
fn by_stock(a: &TradeoffPoint, b: &TradeoffPoint) -> Ordering {
    a.residual_p95.total_cmp(&b.residual_p95).then(a.time_s.total_cmp(&b.time_s))
}

/// Less time first, then less stock.
fn by_time(a: &TradeoffPoint, b: &TradeoffPoint) -> Ordering {
    a.time_s.total_cmp(&b.time_s).then(a.residual_p95.total_cmp(&b.residual_p95))
}

impl Thinning<'_> {
    /// Whether a plan without plunges that buy nothing meets `goal`, so that no other plan is needed.
    pub fn is_least_stock_enough(&self, goal: Goal) -> bool {
        let Goal::Stock { max_time_min } = goal else { return false };
        max_time_min.is_none_or(|minutes| !is_longer(self.time_without(self.last_as_good()), 60.0 * minutes))
    }

    /// The point without the first `count` plunges.
    fn point(&self, count: usize) -> TradeoffPoint {
        let stock = self.stock_without(count);
        TradeoffPoint {
            plan: 0,
            left_out: count,
            time_s: self.time_without(count),
            residual_mean: f64::from(stock.mean),
            residual_p95: f64::from(stock.p95),
            excess: stock.excess_above(self.hub_allowance()),
        }
    }

    /// The least number of plunges to leave out for a time of at most `time_s`; all that can be where that is
    /// not enough. Bisection: time falls with nearly every plunge that goes; on a machine a new link may take
    /// longer.
    fn first_within_time(&self, time_s: f64) -> usize {
        let too_long = |count: usize| is_longer(self.time_without(count), time_s);
        if too_long(0) { (self.last_where(too_long) + 1).min(self.len()) } else { 0 }
    }

    /// The most plunges that can go while the 95th percentile of the stock is at most `limit` mm; `None`
    /// where it is more with all of them.
    fn last_within_stock(&self, limit: f64) -> Option<usize> {
        let too_much = |count| f64::from(self.stock_without(count).p95) > limit;
        (!too_much(0)).then(|| self.last_where(|count| !too_much(count)))
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

/// The point furthest below the chord from the first to the last point, both axes scaled to it.
fn bend(points: &[TradeoffPoint]) -> Option<TradeoffPoint> {
    let (first, last) = (points.first()?, points.last()?);
    let (time, stock) = (first.time_s - last.time_s, last.residual_p95 - first.residual_p95);
    if time <= 0.0 || stock <= 0.0 {
        return Some(*last);
    }
    let below =
        |p: &TradeoffPoint| (first.time_s - p.time_s) / time - (p.residual_p95 - first.residual_p95) / stock;
    points.iter().max_by(|a, b| below(a).total_cmp(&below(b))).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bend_is_where_more_time_buys_little() {
        let point = |left_out, time_s, residual_p95| TradeoffPoint {
            plan: 0,
            left_out,
            time_s,
            residual_mean: 0.0,
            residual_p95,
            excess: ExcessStock::default(),
        };
        let points = [point(0, 100.0, 1.0), point(10, 60.0, 1.1), point(20, 50.0, 1.3), point(30, 40.0, 4.0)];
        let left_out = |points: &[TradeoffPoint]| bend(points).map(|point| point.left_out);
        assert_eq!(left_out(&points), Some(20));
        assert_eq!(left_out(&points[..1]), Some(0));
        assert_eq!(left_out(&[]), None);
    }
}
