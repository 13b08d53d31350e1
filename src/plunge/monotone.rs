//! Stage 3 by paper A's rule: α grows from position to position in the order of cutting.
//!
//! The first position of a row stays as it is (or starts at a least angle); then every W moves along
//! the row's shroud curve, against the cut, by the least amount for which α exceeds that of the
//! position before. The paper walks a discretisation of that curve in steps of 1e-5; here the least
//! amount is solved for.

use super::plan::Blocked;
use super::row::{RowMaker, Station};
use crate::geometry::search;

/// How much α must grow at least, rad: it makes "greater" well defined in floating point.
pub const LEAST_GROWTH_RAD: f64 = 1e-9;
/// W is placed on the shroud curve to this fraction of its length.
const PLACE_TOLERANCE: f64 = 1e-9;
/// How far W may run upstream or downstream of the shroud curve's trimmed ends, in s.
const SHROUD_OVERRUN: f64 = 0.5;

impl RowMaker<'_> {
    /// α as the rule sees it: positive when the axis leans towards the uncut side.
    fn lean(&self, station: &Station) -> f64 {
        station.alpha * self.inward
    }

    /// Applies the rule to a conventional row. `start` is the least lean of the first position
    /// (`None`: first position unchanged). Axes tilt at most `max_tilt` from the conventional one.
    pub fn monotone(&self, conventional: &[Station], start: Option<f64>, max_tilt: f64) -> Vec<Station> {
        let mut row: Vec<Station> = Vec::with_capacity(conventional.len());
        for station in conventional {
            let wanted = match (row.last(), start) {
                (Some(previous), _) => self.lean(previous) + LEAST_GROWTH_RAD,
                (None, Some(start)) => start,
                (None, None) => f64::NEG_INFINITY,
            };
            let before = row.last().map_or(0.0, |p| (p.s_shroud_conventional - p.ends.s_shroud).abs());
            row.push(self.leaning_at_least(station, wanted, before, max_tilt));
        }
        row
    }

    /// The station with W moved by the least amount for which its lean is at least `wanted`; the last
    /// one that blades, shroud or tilt limit allow, marked as blocked, where it cannot be had.
    /// `likely` is the amount the neighbour needed, in s.
    fn leaning_at_least(&self, from: &Station, wanted: f64, likely: f64, max_tilt: f64) -> Station {
        if self.lean(from) >= wanted {
            return *from;
        }
        let moved = |amount: f64, warm: &Station| -> Result<Station, Blocked> {
            let s_shroud = from.s_shroud_conventional - amount * self.inward;
            if !(-SHROUD_OVERRUN..=1.0 + SHROUD_OVERRUN).contains(&s_shroud) {
                return Err(Blocked::ShroudEnd);
            }
            let station = self.station(from.ends.s_hub, s_shroud, Some(warm)).ok_or(Blocked::Walls)?;
            if station.axis.angle(&from.axis) > max_tilt {
                return Err(Blocked::TiltLimit);
            }
            Ok(Station { s_shroud_conventional: from.s_shroud_conventional, ..station })
        };
        // Bracket: grow the amount until the lean suffices.
        let mut low = (0.0, *from);
        let mut step = (1.1 * likely).max(0.5 / self.part.shroud.length());
        let mut high = loop {
            match moved(step, &low.1) {
                Ok(station) if self.lean(&station) >= wanted => break (step, station),
                Ok(station) => {
                    low = (step, station);
                    step += (0.3 * step).max(1.0 / self.part.shroud.length());
                }
                Err(_) if step - low.0 > 1e-4 => step = 0.5 * (low.0 + step),
                Err(why) => return Station { blocked: Some(why), ..low.1 },
            }
        };
        // Solve between stations whose side fit is known; in between the fit is nearly straight.
        for _ in 0..20 {
            if high.0 - low.0 <= PLACE_TOLERANCE {
                break;
            }
            let (a, b) = (low, high);
            let between = |amount: f64| {
                let share = (amount - a.0) / (b.0 - a.0);
                let mix = |x: f64, y: f64| x + share * (y - x);
                let mut ends = a.1.ends;
                ends.s_shroud = mix(a.1.ends.s_shroud, b.1.ends.s_shroud);
                ends.theta_hub = mix(a.1.ends.theta_hub, b.1.ends.theta_hub);
                ends.theta_shroud = mix(a.1.ends.theta_shroud, b.1.ends.theta_shroud);
                self.lean(&self.lowered(ends)) - wanted
            };
            let guess = search::root(between, a.0, b.0, 0.3 * PLACE_TOLERANCE);
            let mut closed = true;
            // The true curve crosses next to the guess: close in from both sides of it.
            let margin = (1e-3 * (b.0 - a.0)).clamp(0.4 * PLACE_TOLERANCE, 1e-4);
            for amount in [guess + 0.3 * margin, guess - 0.7 * margin] {
                if amount <= low.0 || amount >= high.0 {
                    continue;
                }
                match moved(amount, &low.1) {
                    Ok(station) if self.lean(&station) >= wanted => high = (amount, station),
                    Ok(station) => low = (amount, station),
                    Err(_) => closed = false,
                }
            }
            if !closed || high.0 - low.0 >= 0.5 * (b.0 - a.0) {
                let middle = 0.5 * (low.0 + high.0);
                match moved(middle, &low.1) {
                    Ok(station) if self.lean(&station) >= wanted => high = (middle, station),
                    Ok(station) => low = (middle, station),
                    Err(_) => break,
                }
            }
        }
        high.1
    }
}
