//! The floor of the channel in work with a value per cell: height of stock, or depth of contact.

use glam::Vec3;

use super::mesh::{Mesh, Vertex, quads};
use crate::plunge::plan::PlungePlan;
use crate::residual::FloorGrid;

/// Most mesh lines along s and across, in still pictures.
pub const FINE: (usize, usize) = (257, 129);
/// The same in motion.
pub const DRAFT: (usize, usize) = (65, 25);

/// Which cells of a grid become corners of the mesh.
#[derive(Clone, Debug, PartialEq)]
struct Stride {
    rows: Vec<usize>,
    columns: Vec<usize>,
}

impl Stride {
    fn of(grid: &FloorGrid, most: (usize, usize)) -> Self {
        let pick = |count: usize, most: usize| -> Vec<usize> {
            let kept = count.min(most);
            let step = |i: usize| if kept > 1 { i * (count - 1) / (kept - 1) } else { 0 };
            (0..kept).map(step).collect()
        };
        Self { rows: pick(grid.rows, most.0), columns: pick(grid.columns, most.1) }
    }

    fn cells<'a>(&'a self, grid: &'a FloorGrid) -> impl Iterator<Item = usize> + 'a {
        self.rows.iter().flat_map(move |&i| self.columns.iter().map(move |&j| i * grid.columns + j))
    }
}

/// Height below which a cell counts as cut although the blank is hardly higher, mm.
const UNCUT_TOLERANCE: f32 = 1e-3;

/// Mesh of the floor with a height of stock per corner, thinned to `most` lines either way.
/// Cells that are no floor (under a splitter, within the allowance of a wall) are left out.
///
/// Returns `None` when `heights` does not fit the grid.
pub fn floor_mesh(grid: &FloorGrid, heights: &[f32], most: (usize, usize)) -> Option<Mesh> {
    if heights.len() != grid.points.len() {
        return None;
    }
    let stride = Stride::of(grid, most);
    let vertices = stride
        .cells(grid)
        .map(|cell| Vertex {
            position: grid.points[cell],
            value: heights[cell],
            normal: grid.normals[cell],
            uncut: f32::from(heights[cell] >= grid.blank_heights[cell] - UNCUT_TOLERANCE),
        })
        .collect();
    let floor = |i: usize, j: usize| grid.floor[stride.rows[i] * grid.columns + stride.columns[j]];
    let keep = |i: usize, j: usize| floor(i, j) && floor(i + 1, j) && floor(i, j + 1) && floor(i + 1, j + 1);
    Some(Mesh { vertices, indices: quads(stride.rows.len(), stride.columns.len(), keep) })
}

/// The same floor with a value of another kind per cell, such as the difference of two plans; none of it counts
/// as uncut. `None` when `values` does not fit the grid.
pub fn value_mesh(grid: &FloorGrid, values: &[f32]) -> Option<Mesh> {
    let mut mesh = floor_mesh(grid, values, FINE)?;
    for vertex in &mut mesh.vertices {
        vertex.uncut = 0.0;
    }
    Some(mesh)
}

/// The same floor with, per corner, the deepest contact of a core that ends above it, mm.
pub fn contact_mesh(grid: &FloorGrid, plan: &PlungePlan) -> Mesh {
    let contacts: Vec<(Vec3, Vec3, f32, f32)> = plan
        .positions
        .iter()
        .filter(|p| p.contact.interferes())
        .filter_map(|p| {
            let tool = &plan.sections.get(p.section)?.tool;
            let to = |v: [f64; 3]| Vec3::from_array(v.map(|x| x as f32));
            Some((to(p.tip.into()), to(p.axis.into()), tool.core_radius() as f32, p.contact.depth as f32))
        })
        .collect();
    let stride = Stride::of(grid, FINE);
    let mut mesh = floor_mesh(grid, &grid.blank_heights, FINE).unwrap_or_default();
    for (vertex, cell) in mesh.vertices.iter_mut().zip(stride.cells(grid)) {
        let p = Vec3::from_array(grid.points[cell]);
        vertex.uncut = 0.0;
        vertex.value = 0.0;
        for &(tip, axis, core, depth) in &contacts {
            let d = p - tip;
            let along = d.dot(axis);
            // The foot lies under the bottom by the allowance and what the plan leaves; further
            // down it is another part of the hub.
            let below = along < 1.0 && along > -4.0 * core.max(1.0);
            if below && (d - axis * along).length() <= core {
                vertex.value = vertex.value.max(depth);
            }
        }
    }
    mesh
}

/// A colour range that one outlier does not ruin: lowest height to the 98th percentile of what
/// was cut, mm. (0, 1) when nothing was.
pub fn fitting_range(grid: &FloorGrid, heights: &[f32]) -> (f32, f32) {
    let mut cut: Vec<f32> = heights
        .iter()
        .zip(&grid.blank_heights)
        .zip(&grid.floor)
        .filter(|((height, blank), floor)| **floor && **height < **blank - UNCUT_TOLERANCE)
        .map(|((height, _), _)| *height)
        .collect();
    if cut.is_empty() {
        return (0.0, 1.0);
    }
    cut.sort_by(f32::total_cmp);
    let low = cut[0];
    let high = cut[(cut.len() - 1) * 98 / 100];
    (low, high.max(low + 1e-3))
}

/// Cell of the grid at a point of the floor, for the value under the cursor; `None` away from it.
pub fn cell_at(grid: &FloorGrid, point: Vec3) -> Option<usize> {
    let distance = |cell: usize| Vec3::from_array(grid.points[cell]).distance_squared(point);
    let nearest = (0..grid.points.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
    // A few cells' width: the point lies on facets, and on stock above the floor.
    let reach = 3.0 * grid.areas[nearest].max(0.0).sqrt() + 1.0;
    (distance(nearest) <= reach * reach && grid.floor[nearest]).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(rows: usize, columns: usize) -> FloorGrid {
        let count = rows * columns;
        FloorGrid {
            rows,
            columns,
            points: (0..count).map(|k| [(k / columns) as f32, (k % columns) as f32, 0.0]).collect(),
            normals: vec![[0.0, 0.0, 1.0]; count],
            blank_heights: vec![20.0; count],
            areas: vec![1.0; count],
            floor: vec![true; count],
            reachable: vec![true; count],
        }
    }

    #[test]
    fn large_grids_are_thinned_and_keep_their_corners() {
        let grid = grid(600, 400);
        let heights: Vec<f32> = (0..600 * 400).map(|k| k as f32 * 1e-5).collect();
        let mesh = floor_mesh(&grid, &heights, FINE).expect("fits");
        assert_eq!(mesh.triangles(), 256 * 128 * 2);
        assert_eq!(mesh.vertices[0].position, [0.0, 0.0, 0.0]);
        assert_eq!(mesh.vertices.last().expect("some").position, [599.0, 399.0, 0.0]);
    }

    #[test]
    fn cells_without_floor_are_left_out_and_uncut_ones_marked() {
        let mut grid = grid(4, 4);
        grid.floor[5] = false;
        let mut heights = vec![1.0; 16];
        heights[15] = 20.0;
        let mesh = floor_mesh(&grid, &heights, FINE).expect("fits");
        assert_eq!(mesh.triangles(), (9 - 4) * 2);
        assert_eq!(mesh.vertices[15].uncut, 1.0);
        assert_eq!(mesh.vertices[14].uncut, 0.0);
        assert_eq!(floor_mesh(&grid, &heights[1..], FINE), None);
    }

    #[test]
    fn the_cell_under_a_point_is_the_nearest_one_unless_it_is_far() {
        let grid = grid(10, 10);
        assert_eq!(cell_at(&grid, Vec3::new(3.2, 4.1, 0.5)), Some(34));
        assert_eq!(cell_at(&grid, Vec3::new(3.0, 40.0, 0.0)), None);
    }

    #[test]
    fn the_range_ignores_uncut_cells_and_outliers() {
        let grid = grid(10, 20);
        let mut heights: Vec<f32> = (0..200).map(|k| 0.5 + k as f32 * 0.01).collect();
        heights[0] = 20.0;
        heights[1] = 15.0;
        let (low, high) = fitting_range(&grid, &heights);
        assert!((low - 0.52).abs() < 1e-6 && high < 2.5, "{low} {high}");
        assert_eq!(fitting_range(&grid, &[20.0; 200]), (0.0, 1.0));
    }
}
