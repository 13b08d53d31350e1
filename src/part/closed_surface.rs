//! A closed surface of triangles, and whether points lie in it.

use crate::geometry::Point;

/// Cells of the grid over x and y, each way.
const CELLS: usize = 48;

/// A closed surface of triangles that all have the same sense, indexed for the question which points it
/// encloses.
#[derive(Clone, Debug)]
pub struct ClosedSurface {
    triangles: Vec<[Point; 3]>,
    /// Lower corner of the grid over x and y, mm, and cells per mm.
    corner: [f64; 2],
    cells_per_mm: [f64; 2],
    /// Triangles whose bounding rectangle meets a cell, cell by cell, row by row.
    cells: Vec<Vec<u32>>,
}

impl ClosedSurface {
    /// The surface of these triangles, lengths in mm.
    pub fn new(triangles: Vec<[Point; 3]>) -> Self {
        let over = |k: usize| {
            let values = triangles.iter().flatten().map(|p| p[k]);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let bounds = [over(0), over(1)];
        let cells_per_mm =
            bounds.map(|[low, high]| if high > low { CELLS as f64 / (high - low) } else { 0.0 });
        let corner = bounds.map(|[low, _]| low);
        let mut surface = Self { triangles, corner, cells_per_mm, cells: vec![Vec::new(); CELLS * CELLS] };
        for (index, corners) in surface.triangles.iter().enumerate() {
            let span = |k: usize| {
                let of_corners = corners.map(|p| surface.cell(k, p[k]));
                of_corners.into_iter().fold([usize::MAX, 0], |[low, high], c| [low.min(c), high.max(c)])
            };
            let ([left, right], [lower, upper]) = (span(0), span(1));
            for row in lower..=upper {
                for cell in &mut surface.cells[row * CELLS..][left..=right] {
                    cell.push(index as u32);
                }
            }
        }
        surface
    }

    /// Cell of coordinate `k` (0 for x, 1 for y); the outermost for places beside the grid.
    fn cell(&self, k: usize, x: f64) -> usize {
        // Casts saturate: what is below the grid gets its first cell.
        (((x - self.corner[k]) * self.cells_per_mm[k]) as usize).min(CELLS - 1)
    }

    /// Whether `point` is inside: the triangles above it, counted by their sense, wind around it.
    ///
    /// Where the surface crosses itself this is what the winding number says: inside is where it is not 0.
    pub fn contains(&self, point: &Point) -> bool {
        let above = &self.cells[self.cell(1, point.y) * CELLS + self.cell(0, point.x)];
        above.iter().map(|&index| winding_above(point, &self.triangles[index as usize])).sum::<i32>() != 0
    }
}

/// +1 or −1 where the triangle is above `point`, by its sense seen from there, else 0.
fn winding_above(point: &Point, corners: &[Point; 3]) -> i32 {
    let [a, b, c] = corners;
    let turns = crossing(point, a, b) + crossing(point, b, c) + crossing(point, c, a);
    if turns == 0 {
        return 0;
    }
    let below_plane = (b - a).cross(&(c - a)).dot(&(a - point));
    if below_plane * f64::from(turns) > 0.0 { turns } else { 0 }
}

/// What the edge from `from` to `to` adds to the turns of a polygon in x and y around `point`: +1 where it
/// crosses the ray along +x upwards, −1 downwards. Half-open in y, so that a common corner of two edges
/// counts once. Both directions of an edge reckon with the same numbers, so that neighbours agree whatever
/// is rounded.
fn crossing(point: &Point, from: &Point, to: &Point) -> i32 {
    if (from.y <= point.y) == (to.y <= point.y) {
        return 0;
    }
    let (lower, upper, sense) = if to.y > from.y { (from, to, 1) } else { (to, from, -1) };
    let left = (upper.x - lower.x) * (point.y - lower.y) - (point.x - lower.x) * (upper.y - lower.y) > 0.0;
    if left { sense } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Solid angle of a triangle seen from `point` (Van Oosterom and Strackee, 1983).
    fn solid_angle(point: &Point, corners: &[Point; 3]) -> f64 {
        let [a, b, c] = corners.map(|corner| corner - point);
        let (x, y, z) = (a.norm(), b.norm(), c.norm());
        2.0 * a.dot(&b.cross(&c)).atan2(x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y)
    }

    /// A torus of `rings` times `sides` quadrilaterals around an axis along (1, 1, 1), or around z.
    fn torus([rings, sides]: [usize; 2], is_tilted: bool) -> Vec<[Point; 3]> {
        let at = |i: usize, j: usize| {
            let [u, v] = [(i % rings, rings), (j % sides, sides)]
                .map(|(k, n)| std::f64::consts::TAU * k as f64 / n as f64);
            let radius = 10.0 + 4.0 * v.cos();
            let point = Point::new(radius * u.cos(), radius * u.sin(), 4.0 * v.sin());
            let axis = nalgebra::Unit::new_normalize(crate::geometry::Vector::new(1.0, -1.0, 0.0));
            let turn = nalgebra::Rotation3::from_axis_angle(&axis, 0.955);
            if is_tilted { turn * point } else { point }
        };
        let quads = (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j)));
        quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    proptest! {
        #[test]
        fn a_point_is_inside_where_the_solid_angle_is_a_full_one(
            rings in 3..40usize, sides in 3..20usize, is_tilted: bool,
            at in [-15.0..15.0f64, -15.0..15.0, -15.0..15.0], is_on_grid: bool,
        ) {
            let triangles = torus([rings, sides], is_tilted);
            // Straight above and below corners and edges, too.
            let at = if is_on_grid { at.map(|x: f64| if x > 0.0 { x.round() } else { 0.0 }) } else { at };
            let point = Point::from(at);
            let turned: f64 = triangles.iter().map(|corners| solid_angle(&point, corners)).sum();
            // Not on the surface itself.
            let share = turned.abs() / (4.0 * std::f64::consts::PI);
            prop_assume!((share - share.round()).abs() < 1e-6);
            prop_assert_eq!(ClosedSurface::new(triangles).contains(&point), share > 0.5);
        }
    }
}
