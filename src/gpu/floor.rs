//! The floor of the channel in work with a value per cell: height of stock, or depth of contact.

use glam::Vec3;

use super::mesh::{Mesh, Vertex};
use crate::plunge::plan::PlungePlan;
use crate::residual::FloorGrid;
use crate::residual::surface::{FINE, FloorSurface, is_uncut};

/// Most lines along s and across, in motion.
pub const DRAFT: (usize, usize) = (65, 25);

/// Mesh of the floor with a height of stock per corner, thinned to `most` lines either way.
/// Cells that are no floor (under a splitter, within the allowance of a wall) are left out.
///
/// Returns `None` when `heights` does not fit the grid.
pub fn floor_mesh(grid: &FloorGrid, heights: &[f32], most: (usize, usize)) -> Option<Mesh> {
    if heights.len() != grid.points.len() {
        return None;
    }
    let surface = FloorSurface::new(grid, most);
    let corner = |&cell: &usize| Vertex {
        position: grid.points[cell],
        value: heights[cell],
        normal: grid.normals[cell],
        uncut: f32::from(is_uncut(grid, cell, heights[cell])),
    };
    Some(Mesh {
        vertices: surface.cells.iter().map(corner).collect(),
        indices: surface.triangles.into_flattened(),
    })
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
    let cells = FloorSurface::new(grid, FINE).cells;
    let mut mesh = floor_mesh(grid, &grid.blank_heights, FINE).unwrap_or_default();
    for (vertex, &cell) in mesh.vertices.iter_mut().zip(&cells) {
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

    #[test]
    fn cells_without_floor_are_left_out_and_uncut_ones_marked() {
        let mut grid = FloorGrid::flat(4, 4);
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
        let grid = FloorGrid::flat(10, 10);
        assert_eq!(cell_at(&grid, Vec3::new(3.2, 4.1, 0.5)), Some(34));
        assert_eq!(cell_at(&grid, Vec3::new(3.0, 40.0, 0.0)), None);
    }
}
