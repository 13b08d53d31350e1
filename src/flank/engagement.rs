//! Which passes of a layer run through full stock, and which beside one that is already cut.

use crate::geometry::{Point, Vector};
use crate::setup::Tool;

/// The passes of a layer that are already cut, as paths of the centre of the tool's corner: unlike the tip it
/// does not depend on the axis.
pub(super) struct CutPasses {
    corner_radius: f64,
    /// Distance below which a pass counts as beside another, mm.
    beside: f64,
    paths: Vec<CornerPath>,
}

struct CornerPath {
    points: Vec<Point>,
    /// Centre of a bounding ball.
    middle: Point,
    radius: f64,
}

/// Maximum distance of passes beside each other, in stepovers: gaps between fans exceed one stepover in some
/// spots.
const BESIDE: f64 = 1.3;
/// Number of sampled positions of a pass.
const SAMPLES: usize = 12;

impl CutPasses {
    pub(super) fn new(tool: &Tool, stepover: f64) -> Self {
        Self { corner_radius: tool.corner_radius, beside: BESIDE * stepover, paths: Vec::new() }
    }

    fn corner_path<'a>(&self, positions: &'a [(Point, Vector)]) -> impl Iterator<Item = Point> + 'a {
        let up = self.corner_radius;
        positions.iter().map(move |(tip, axis)| tip + axis * up)
    }

    /// Adds a pass to those already cut.
    pub(super) fn add(&mut self, positions: &[(Point, Vector)]) {
        let points: Vec<Point> = self.corner_path(positions).collect();
        let Some(&middle) = points.get(points.len() / 2) else { return };
        let radius = points.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        self.paths.push(CornerPath { points, middle, radius });
    }

    /// Whether most of a pass runs beside no pass that is cut.
    pub(super) fn are_far_from(&self, positions: &[(Point, Vector)]) -> bool {
        let stride = (positions.len() / SAMPLES).max(1);
        let (mut far, mut all) = (0, 0);
        for centre in self.corner_path(positions).step_by(stride) {
            all += 1;
            far += usize::from(!self.paths.iter().any(|path| path.is_within(&centre, self.beside)));
        }
        2 * far > all
    }
}

impl CornerPath {
    fn is_within(&self, centre: &Point, reach: f64) -> bool {
        if (centre - self.middle).norm() > self.radius + reach {
            return false;
        }
        self.points.windows(2).any(|p| {
            let (along, to) = (p[1] - p[0], centre - p[0]);
            let share = (to.dot(&along) / along.norm_squared().max(1e-18)).clamp(0.0, 1.0);
            (to - along * share).norm_squared() < reach * reach
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(y: f64) -> Vec<(Point, Vector)> {
        (0..30).map(|k| (Point::new(f64::from(k), y, 0.0), Vector::z())).collect()
    }

    #[test]
    fn a_pass_is_in_full_stock_until_its_neighbour_is_cut() {
        let tool = Tool {
            number: 1,
            diameter: 6.0,
            corner_radius: 3.0,
            insert_width: 3.0,
            overhang: 40.0,
            plunge_feed: 100.0,
            spindle: 5000.0,
            assembly: Default::default(),
        };
        let mut cut = CutPasses::new(&tool, 2.0);
        assert!(cut.are_far_from(&line(0.0)), "nothing is cut");
        cut.add(&line(0.0));
        assert!(!cut.are_far_from(&line(2.0)), "one stepover away");
        assert!(cut.are_far_from(&line(6.0)), "three stepovers away");
        // Another axis along the same path gives the same corner path.
        let tilted = Vector::new(0.0, 0.6, 0.8);
        let tilted_line: Vec<_> =
            line(2.0).iter().map(|(tip, axis)| (tip + (axis - tilted) * 3.0, tilted)).collect();
        assert!(!cut.are_far_from(&tilted_line));
        // Half beside it, half beyond its end.
        let half: Vec<_> = line(2.0).iter().map(|(tip, axis)| (tip + Vector::x() * 18.0, *axis)).collect();
        assert!(cut.are_far_from(&half));
    }
}
