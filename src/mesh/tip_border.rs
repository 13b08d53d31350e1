//! The shroud of an open wheel by the border of its blades in the meridional plane: for blades whose tip
//! merges smoothly with leading and trailing edge, as in models from CAD.
//!
//! Projected into the meridional plane, the blades cover a region that hub, leading edge, tip and trailing
//! edge bound. The tip is the stretch of its border opposite the hub that runs along the channel: it ends at
//! corners, or, where a tip merges smoothly with an edge, where its direction turns across the channel. The
//! border is the envelope of the tips: where one side of a blade ends lower than the other, it is that of the
//! higher one, and the lower side is extended to it later.

use super::profile::{Course, FittedProfile};
use super::surface::MeshSurface;
use super::tips::edge_corners;
use crate::geometry::{Meridional, MeridionalCurve};

/// Distance from the border within which a corner is on the tip, mm per mm of the channel's height.
const NEAR: f64 = 2e-3;
/// Multiples of [`NEAR`] that are tried until the corners cover the tip: with the smallest, only the higher
/// side of a tip that is not turned counts, so that the curve does not zigzag between both.
const WIDER: [f64; 4] = [0.1, 1.0, 2.0, 4.0];
/// Widest stretch of the tip without corners, as a share of it.
const WIDEST_GAP: f64 = 0.15;
/// Number of intervals of the border over the blade's extent along the channel.
const INTERVALS: usize = 480;
/// Number of intervals over which a direction of the border is taken.
const BASE: usize = 5;
/// Largest angle between tip and hub, rad.
const ACROSS: f64 = 1.05;
/// Smallest turn of the border at a corner, rad.
const CORNER: f64 = 0.45;
/// Largest height over the hub at which the border of a blade without leading edge begins, as a share of that
/// of the tip.
const AT_HUB: f64 = 0.1;
/// Largest turn of that border, rad.
const NO_TURN: f64 = 0.4;
/// Fewest corners that a curve is fitted through.
const FEWEST: usize = 8;

/// The meridional curve through the tips of `blade` over the hub with the points `hub`; `None` where none can
/// be fitted.
pub fn fit_tip_border(blade: &MeshSurface, hub: &[Meridional], course: &Course) -> Option<FittedProfile> {
    let outline = TipOutline::from_blade(blade, hub, course)?;
    WIDER.into_iter().find_map(|wider| {
        let near = NEAR * wider * outline.height;
        // The tips have no sharp edges where they are rounded: then every corner is a candidate.
        [true, false].into_iter().find_map(|sharp| outline.fit(&edge_corners(blade, sharp), course, near))
    })
}

/// Where the tip of `blade` begins and ends by its border, as distances along the course, mm; `None` where
/// the border does not tell.
pub fn tip_extent(blade: &MeshSurface, hub: &[Meridional], course: &Course) -> Option<(f64, f64)> {
    let TipOutline { from, step, tip, .. } = TipOutline::from_blade(blade, hub, course)?;
    Some((from + step * tip.0 as f64, from + step * tip.1 as f64))
}

/// Whether `blade` has no leading edge: its border goes on from the hub, where it begins, to the end of its
/// tip without a turn.
pub fn begins_in_hub(blade: &MeshSurface, hub: &[Meridional], course: &Course) -> bool {
    let Some(outline) = TipOutline::from_blade(blade, hub, course) else { return false };
    let Some(first) = (0..outline.tip.1).find(|k| outline.across[*k].is_finite()) else { return false };
    let slope =
        |a: usize, b: usize| (outline.across[b] - outline.across[a]).atan2(outline.step * (b - a) as f64);
    let (from, to) = (first + 1, outline.tip.1 - 1);
    let tip = slope(outline.tip.0, to);
    let is_alike = |k: usize| (slope(k, k + BASE) - tip).abs() < NO_TURN;
    // The tip of a leading edge, with which the border may begin, is far from the hub.
    let hub: Vec<(f64, f64)> = hub.iter().map(|p| course.coordinates_of(*p)).collect();
    let x = outline.from + outline.step * first as f64;
    let over = outline.across[first] - outline.sign * along_hub(&hub, x).0;
    let begins = over < AT_HUB * outline.height && x > hub[0].0 - 2.0 * outline.step;
    begins && to > from + 4 * BASE && (from..to - BASE).all(is_alike)
}

/// Share of a stretch along the course, mm, that a curve goes along.
pub fn covered_share(curve: &[Meridional], (low, high): (f64, f64), course: &Course) -> f64 {
    let (from, to) = course.extent_of(curve);
    (to.min(high) - from.max(low)) / f64::max(high - low, 1e-300)
}

/// How far a curve goes on before and past a stretch along the course, mm, as a share of the stretch.
pub fn past_share(curve: &[Meridional], (low, high): (f64, f64), course: &Course) -> f64 {
    let (from, to) = course.extent_of(curve);
    ((low - from).max(0.0) + (to - high).max(0.0)) / f64::max(high - low, 1e-300)
}

/// The border of a blade away from the hub, as a function of the distance along the course, mm.
struct TipOutline {
    from: f64,
    step: f64,
    /// Distance across the course at each place, positive away from the hub.
    across: Vec<f64>,
    /// +1 or −1: direction across the course that is away from the hub.
    sign: f64,
    /// First and last place of the tip.
    tip: (usize, usize),
    /// Greatest height of the border over the hub, mm.
    height: f64,
}

/// The place across the course of a hub, extended straight, at a distance along it, and its slope there.
fn along_hub(hub: &[(f64, f64)], x: f64) -> (f64, f64) {
    let i = hub.partition_point(|p| p.0 < x).clamp(1, hub.len() - 1);
    let (a, b) = (hub[i - 1], hub[i]);
    let slope = (b.1 - a.1) / (b.0 - a.0).max(1e-9);
    (a.1 + slope * (x - a.0), slope)
}

/// +1 or −1: on which side of a hub most places over it are. Those at the feet of fillets are on it.
fn side_of_hub(hub: &[(f64, f64)], places: &[(f64, f64)]) -> f64 {
    let (Some(first), Some(last)) = (hub.first(), hub.last()) else { return 1.0 };
    let over = places.iter().filter(|p| (first.0..=last.0).contains(&p.0));
    let sum: f64 = over.map(|p| p.1 - along_hub(hub, p.0).0).sum();
    sum.signum()
}

impl TipOutline {
    fn from_blade(blade: &MeshSurface, hub: &[Meridional], course: &Course) -> Option<Self> {
        let hub: Vec<(f64, f64)> = hub.iter().map(|p| course.coordinates_of(*p)).collect();
        if hub.len() < 2 {
            return None;
        }
        let places: Vec<(f64, f64)> =
            blade.points.iter().map(|p| course.coordinates_of(Meridional::from_point(p))).collect();
        let sign = side_of_hub(&hub, &places);
        let (low, high) =
            places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, p| (e.0.min(p.0), e.1.max(p.0)));
        let step = (high - low) / INTERVALS as f64;
        if !(step.is_finite() && step > 0.0) {
            return None;
        }
        let mut outline = Self {
            from: low,
            step,
            across: vec![f64::NEG_INFINITY; INTERVALS + 1],
            sign,
            tip: (0, INTERVALS),
            height: 0.0,
        };
        for t in &blade.triangles {
            for k in 0..3 {
                let (a, b) = (places[t[k] as usize], places[t[(k + 1) % 3] as usize]);
                outline.raise(a, b);
            }
        }
        outline.bound(&hub)?;
        Some(outline)
    }

    /// Raises the border to the edge from `a` to `b`.
    fn raise(&mut self, a: (f64, f64), b: (f64, f64)) {
        let (a, b) = if a.0 <= b.0 { (a, b) } else { (b, a) };
        let (first, last) = (((a.0 - self.from) / self.step).ceil(), ((b.0 - self.from) / self.step).floor());
        for k in first.max(0.0) as usize..=(last.max(0.0) as usize).min(INTERVALS) {
            let x = self.from + self.step * k as f64;
            if x < a.0 || x > b.0 {
                continue;
            }
            let share = if b.0 > a.0 { (x - a.0) / (b.0 - a.0) } else { 0.0 };
            self.across[k] = self.across[k].max(self.sign * (a.1 + (b.1 - a.1) * share));
        }
    }

    /// Finds the tip: of the stretches between corners and places that run across the channel, the one with
    /// the greatest length along the hub.
    fn bound(&mut self, hub: &[(f64, f64)]) -> Option<()> {
        // Hub as a function along the course, extended straight.
        let over = |x: f64| {
            let (y, slope) = along_hub(hub, x);
            (self.sign * y, (self.sign * slope).atan())
        };
        let filled: Vec<usize> = (0..=INTERVALS).filter(|&k| self.across[k].is_finite()).collect();
        let (&first, &last) = (filled.first()?, filled.last()?);
        if filled.len() != last - first + 1 || last - first < 4 * BASE {
            return None;
        }
        let direction =
            |a: usize, b: usize| (self.across[b] - self.across[a]).atan2(self.step * (b - a) as f64);
        let about = |k: usize| (k.saturating_sub(BASE).max(first), (k + BASE).min(last));
        let leans: Vec<f64> = (first..=last)
            .map(|k| {
                let (a, b) = about(k);
                direction(a, b) - over(self.from + self.step * k as f64).1
            })
            .collect();
        let turns: Vec<f64> = (first..=last)
            .map(|k| match about(k) {
                (a, b) if a + BASE <= k && k + BASE <= b => direction(a, k) - direction(k, b),
                _ => 0.0,
            })
            .collect();
        // A corner is the sharpest place around.
        let corner = |i: usize| {
            let around = i.saturating_sub(BASE)..(i + BASE + 1).min(turns.len());
            turns[i] > CORNER && turns[around].iter().all(|t| *t <= turns[i])
        };
        let (mut best, mut run) = ((0.0, 0, 0), None::<(f64, usize)>);
        for i in 0..=leans.len() {
            let along = leans.get(i).copied().filter(|lean| lean.abs() < ACROSS);
            if let Some((length, start)) = run
                && (along.is_none() || corner(i))
            {
                if length > best.0 {
                    best = (length, start, i - 1);
                }
                run = None;
            }
            if let Some(lean) = along {
                let run = run.get_or_insert((0.0, i));
                run.0 += lean.cos();
            }
        }
        let (length, start, end) = best;
        if length <= 0.0 || end - start < 4 * BASE {
            return None;
        }
        self.tip = (first + start, first + end);
        let height = |k: usize| self.across[k] - over(self.from + self.step * k as f64).0;
        self.height = (self.tip.0..=self.tip.1).map(height).fold(0.0, f64::max);
        (self.height > 0.0).then_some(())
    }

    /// Widest stretch of the tip without points, as a share of it.
    fn widest_gap(&self, points: &[Meridional], course: &Course) -> f64 {
        let end = |k: usize| self.from + self.step * k as f64;
        let mut along: Vec<f64> = points.iter().map(|p| course.coordinates_of(*p).0).collect();
        along.extend([end(self.tip.0), end(self.tip.1)]);
        along.sort_by(f64::total_cmp);
        let widest = along.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        widest / (end(self.tip.1) - end(self.tip.0))
    }

    /// The curve through the corners within `near` mm of the border of the tip.
    fn fit(&self, corners: &[Meridional], course: &Course, near: f64) -> Option<FittedProfile> {
        // Distance below the border, and distance from the ends of the tip in intervals, positive within.
        let place = |p: &Meridional| {
            let (x, y) = course.coordinates_of(*p);
            let at = ((x - self.from) / self.step).clamp(0.0, INTERVALS as f64);
            let k = (at as usize).min(INTERVALS - 1);
            let (a, b) = (self.across[k], self.across[k + 1]);
            let below = a + (b - a) * (at - k as f64) - self.sign * y;
            let steep = f64::hypot(self.step, b - a) / self.step;
            (below / steep, (at - self.tip.0 as f64).min(self.tip.1 as f64 - at))
        };
        let mut tips: Vec<Meridional> = Vec::new();
        let mut at_ends: Vec<Meridional> = Vec::new();
        let margin = BASE as f64;
        for p in corners {
            let (below, within) = place(p);
            if within >= margin && below < near {
                tips.push(*p);
            } else if within >= -margin {
                at_ends.push(*p);
            }
        }
        if tips.len() < FEWEST || self.widest_gap(&tips, course) > WIDEST_GAP {
            return None;
        }
        let core = course.fit_curve(&tips)?;
        if core.max_deviation_mm > near {
            return None;
        }
        // Near corners the border does not separate tip and edges, but the curve does, extended straight.
        let curve = MeridionalCurve::through(&core.points);
        let reach = NEAR * self.height;
        let mut all = tips;
        all.extend(at_ends.iter().filter(|p| curve.project_past_ends(**p).1.abs() < reach));
        course.fit_curve(&all).filter(|fit| fit.max_deviation_mm < near).or(Some(core))
    }
}
