//! How much of a cutter's circumference is engaged in stock while it plunges.

use super::{Earlier, LineRemainder, Neighbours, PlungeColumn};
use crate::geometry::{Meridional, Vector};
use crate::part::Blank;

/// Number of lines around the circumference, and of heights above the bottom at which each is evaluated.
const LINES: usize = 36;
const HEIGHTS: usize = 8;
/// Radius of the lines, in radii of the cutter: well within its edges.
const LINES_AT: f64 = 0.97;
/// Lowest height, mm: on the bottom itself a line is as often in stock as not.
const LOWEST: f64 = 0.01;
/// Lines without stock between two engaged arcs from which on the cut counts as interrupted.
const GAP_LINES: usize = 3;

/// Engagement of a cutter over one plunge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Engagement {
    /// Largest engaged arc over the plunge, rad.
    pub max_arc_rad: f64,
    /// Engaged arc at the end of the plunge, rad.
    pub bottom_arc_rad: f64,
    /// Unit direction across the axis from the axis to the middle of the arc at the end of the plunge; zero
    /// where nothing, or everything all around, is engaged there.
    pub towards_stock: Vector,
    /// Whether the teeth leave the stock and enter it again within a turn.
    pub is_interrupted: bool,
}

/// Engagement of the plunge of `whole`, its whole cutter as a column, after `earlier` plunges.
pub fn engagement(whole: &PlungeColumn, earlier: Earlier, blank: &Blank) -> Engagement {
    if whole.top <= 0.0 {
        return Engagement::default();
    }
    let mut near = Neighbours::around(whole, earlier.near(whole));
    let height = |level: usize| LOWEST + whole.top * level as f64 / HEIGHTS as f64;
    let mut engaged = [[false; LINES]; HEIGHTS];
    let mut away = [Vector::zeros(); LINES];
    let mut warm = None;
    for (number, away) in away.iter_mut().enumerate() {
        let phi = std::f64::consts::TAU * number as f64 / LINES as f64;
        let line = near.frame().line(LINES_AT * whole.cutter.radius, phi);
        *away = (line.origin - whole.cutter.tip).normalize();
        let mut left = LineRemainder::whole(whole.top);
        near.cut_line(&mut left, &line, f64::INFINITY, |_| {});
        let open = &left.open[..left.count];
        for (level, engaged) in engaged.iter_mut().enumerate() {
            let h = height(level);
            engaged[number] = open.iter().any(|&(from, to)| (from..to).contains(&h))
                && blank.is_solid(Meridional::from_point(&line.at(h)), &mut warm);
        }
    }
    let arc = |engaged: &[bool; LINES]| {
        std::f64::consts::TAU * engaged.iter().filter(|engaged| **engaged).count() as f64 / LINES as f64
    };
    let sum: Vector = away.iter().zip(engaged[0]).filter(|(_, engaged)| *engaged).map(|(away, _)| away).sum();
    Engagement {
        max_arc_rad: engaged.iter().map(arc).fold(0.0, f64::max),
        bottom_arc_rad: arc(&engaged[0]),
        towards_stock: sum.try_normalize(0.5).unwrap_or_else(Vector::zeros),
        is_interrupted: engaged.iter().any(|engaged| gaps(engaged) > 1),
    }
}

/// Number of gaps without stock of [`GAP_LINES`] lines or more; shorter ones are scallops.
fn gaps(engaged: &[bool; LINES]) -> usize {
    let Some(first) = engaged.iter().position(|engaged| *engaged) else { return 0 };
    let mut gaps = 0;
    let mut free = 0;
    for k in 1..=LINES {
        if engaged[(first + k) % LINES] {
            gaps += usize::from(free >= GAP_LINES);
            free = 0;
        } else {
            free += 1;
        }
    }
    gaps
}
