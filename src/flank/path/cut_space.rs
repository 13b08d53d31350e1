//! The space that the passes of a program have cut: how far down along its axis a cutter meets no stock.

use crate::geometry::{CutterSolid, Meridional, Point, Vector};
use crate::part::Blank;
use crate::setup::Tool;

/// The passes that are cut, as sweeps of the cutter.
pub(super) struct CutSpace<'a> {
    tool: &'a Tool,
    blank: &'a Blank,
    /// Height above the tip up to which a cutter cuts, mm.
    flutes: f64,
    /// Lines of the bottom that are looked at: distance from the axis, direction, and height above the tip.
    lines: Vec<([f64; 2], f64)>,
    sweeps: Vec<SweptStretch>,
}

/// A stretch of a pass.
struct SweptStretch {
    moves: Vec<SweptMove>,
    /// One of its positions, tip and unit axis, and how far the axes of the cutter at the others are from its
    /// own at most, mm.
    middle: (Point, Vector),
    apart: f64,
}

/// Number of moves of a stretch.
const STRETCH: usize = 16;

/// Distances of the lines from the axis, in radii, with the number of lines on each circle: the next one is
/// at most about a third of a radius away.
const CIRCLES: [(f64, usize); 4] = [(0.0, 1), (0.33, 6), (0.66, 12), (0.99, 24)];
/// Step along a line, mm, and in radii at most.
const STEP: f64 = 0.5;
const MAX_STEP_RADII: f64 = 0.2;
/// Resolution of heights, mm.
const RESOLUTION: f64 = 0.05;
/// Depth by which a cutter may touch stock and count as clear, mm: passes side by side leave as much between
/// their straight moves.
const SKIM: f64 = 0.02;

impl<'a> CutSpace<'a> {
    /// Before the first pass of `tool` into `blank`.
    pub(super) fn new(tool: &'a Tool, blank: &'a Blank) -> Self {
        let (radius, corner) = (tool.radius(), tool.corner_radius);
        let lines = CIRCLES.iter().flat_map(|&(share, count)| {
            let across = share * radius;
            let beyond = (across - (radius - corner)).max(0.0);
            let height = corner - (corner * corner - beyond * beyond).max(0.0).sqrt();
            (0..count).map(move |k| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
                ([across * cos, across * sin], height)
            })
        });
        let flutes = tool.assembly.flutes_end(tool.overhang);
        Self { tool, blank, flutes, lines: lines.collect(), sweeps: Vec::new() }
    }

    /// Adds a pass to those that are cut.
    pub(super) fn add(&mut self, positions: &[(Point, Vector)]) {
        for first in (0..positions.len().saturating_sub(1)).step_by(STRETCH) {
            let positions = &positions[first..positions.len().min(first + STRETCH + 1)];
            let middle = positions[positions.len() / 2];
            let apart = |(tip, axis): &(Point, Vector)| {
                (tip - middle.0).norm() + self.flutes * (axis - middle.1).norm()
            };
            let apart = positions.iter().map(apart).fold(0.0, f64::max);
            let moves = positions.windows(2).map(|pair| self.swept([pair[0], pair[1]])).collect();
            self.sweeps.push(SweptStretch { moves, middle, apart });
        }
    }

    /// The straight move between two positions, tip and unit axis.
    fn swept(&self, [from, to]: [(Point, Vector); 2]) -> SweptMove {
        let along = to.0 - from.0;
        let across = along - from.1 * along.dot(&from.1);
        let apart = along.norm() + self.flutes * (to.1 - from.1).norm();
        SweptMove { from, to, across: across / across.norm_squared().max(1e-18), apart }
    }

    /// Height above `tip` along the unit `axis` from which on the cutter meets no stock, mm: at most `top`,
    /// above which there is none.
    pub(super) fn standing_height(&self, (tip, axis): (Point, Vector), top: f64) -> f64 {
        let near = self.near(tip, axis, top);
        let aside = axis.cross(&any_across(&axis)).normalize();
        let beside = axis.cross(&aside);
        let step = STEP.min(MAX_STEP_RADII * self.tool.radius());
        // The move that has cut the last point most often has cut the next one.
        let (mut last, mut warm) = (0, None);
        let mut is_free = |point: Point| {
            let is_cut = |swept: &SweptMove| self.is_cut(swept, &point);
            if near.get(last).copied().is_some_and(is_cut) {
                return true;
            }
            if !self.blank.is_solid(Meridional::from_point(&point), &mut warm) {
                return true;
            }
            let found = near.iter().copied().position(is_cut);
            last = found.unwrap_or(last);
            found.is_some()
        };
        let mut stands = 0.0;
        for &([x, y], bottom) in &self.lines {
            let origin = tip + aside * x + beside * y + axis * bottom;
            // Down to the highest that stands so far, where that line is looked at too: a thin layer would
            // lie between two steps.
            let (mut height, mut free) = (top, top);
            while height > stands && is_free(origin + axis * height) {
                (height, free) = ((height - step).max(stands), height);
            }
            if height > stands || !is_free(origin + axis * height) {
                while free - height > RESOLUTION {
                    let middle = 0.5 * (free + height);
                    *(if is_free(origin + axis * middle) { &mut free } else { &mut height }) = middle;
                }
                stands = free;
            }
        }
        stands
    }

    /// The moves of passes that may have cut something of what the cutter sweeps on its way down from `top`
    /// mm above `tip`, the nearest first.
    fn near(&self, tip: Point, axis: Vector, top: f64) -> Vec<&SweptMove> {
        let reach = 2.0 * self.tool.radius();
        let way = (tip, axis, top);
        let mut near = Vec::new();
        for sweep in &self.sweeps {
            let (tip, axis) = sweep.middle;
            if apart_of(way, (tip, axis, self.flutes)) > sweep.apart + reach {
                continue;
            }
            for swept in &sweep.moves {
                let (tip, axis) = swept.from;
                let distance = apart_of(way, (tip, axis, self.flutes));
                if distance <= reach + swept.apart {
                    near.push((distance, swept));
                }
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.into_iter().map(|(_, swept)| swept).collect()
    }

    /// Whether the cutter covers `point` on a move.
    fn is_cut(&self, swept: &SweptMove, point: &Point) -> bool {
        let SweptMove { from, to, across, apart } = swept;
        let (radius, corner_radius) = (self.tool.radius(), self.tool.corner_radius);
        let way = point - from.0;
        let height = way.dot(&from.1);
        let farthest = radius + SKIM + apart;
        if way.norm_squared() - height * height > farthest * farthest {
            return false;
        }
        let share = way.dot(across).clamp(0.0, 1.0);
        let tip = from.0 + (to.0 - from.0) * share;
        let Some(axis) = (from.1 + (to.1 - from.1) * share).try_normalize(1e-9) else { return false };
        let cutter = CutterSolid { tip, axis, radius, corner_radius };
        (point - tip).dot(&axis) <= self.flutes && cutter.distance(point) <= SKIM
    }
}

/// A straight move of a pass.
struct SweptMove {
    from: (Point, Vector),
    to: (Point, Vector),
    /// Across the first axis, towards the end: its product with the way to a point is the share of the move
    /// at which the axis passes that point.
    across: Vector,
    /// How far the line of the cutter moves at most, mm.
    apart: f64,
}

/// A vector that is not parallel to `axis`.
fn any_across(axis: &Vector) -> Vector {
    if axis.z.abs() < 0.8 { Vector::z() } else { Vector::x() }
}

/// Height above the start of a line (start, unit direction, length) of its point nearest to `point`, and the
/// distance between both.
fn nearest_on((start, direction, length): (Point, Vector, f64), point: &Point) -> (f64, f64) {
    let height = (point - start).dot(&direction).clamp(0.0, length);
    (height, (start + direction * height - point).norm())
}

/// Distance between two lines, each by start, unit direction and length.
fn apart_of(one: (Point, Vector, f64), other: (Point, Vector, f64)) -> f64 {
    let between = other.0 - one.0;
    let (cosine, along, along_other) = (one.1.dot(&other.1), between.dot(&one.1), between.dot(&other.1));
    let sine_squared = 1.0 - cosine * cosine;
    let height = match sine_squared > 1e-12 {
        true => ((cosine * along - along_other) / sine_squared).clamp(0.0, other.2),
        false => (-along_other).clamp(0.0, other.2),
    };
    // The nearest of both lines: of one to a point of the other, and back.
    let (mine, _) = nearest_on(one, &(other.0 + other.1 * height));
    nearest_on(other, &(one.0 + one.1 * mine)).1
}
