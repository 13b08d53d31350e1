//! Meshes of the floor of the active channel with a value per cell: stock height or contact depth.

use glam::Vec3;

use crate::gpu::FloorMeshes;
use crate::gpu::mesh::{Mesh, Vertex};
use crate::plunge::plan::PlungePlan;
use crate::stock::FloorGrid;
use crate::stock::surface::{FloorSurface, MAX_LINES, is_uncut};

/// Maximum number of grid lines along s and across, for pictures in motion.
const DRAFT_LINES: (usize, usize) = (65, 25);

/// Meshes of the floor with a stock height (mm) per corner; see [`floor_mesh`]. Returns `None` when `heights`
/// does not fit the grid.
pub fn floor_meshes(grid: &FloorGrid, heights: &[f32]) -> Option<FloorMeshes> {
    let fine = floor_mesh(grid, heights, MAX_LINES)?;
    Some(FloorMeshes { fine, draft: floor_mesh(grid, heights, DRAFT_LINES) })
}

/// Mesh of the floor with a stock height (mm) per corner, thinned to at most `max_lines` along s and across.
/// Cells that are not floor (under a splitter, within the allowance of a wall) are omitted.
///
/// Returns `None` when `heights` does not fit the grid.
pub fn floor_mesh(grid: &FloorGrid, heights: &[f32], max_lines: (usize, usize)) -> Option<Mesh> {
    if heights.len() != grid.points.len() {
        return None;
    }
    let surface = FloorSurface::new(grid, max_lines);
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

/// Mesh of the floor with any other value per cell, such as the difference of two plans; no cell counts as
/// uncut. Returns `None` when `values` does not fit the grid.
pub fn value_mesh(grid: &FloorGrid, values: &[f32]) -> Option<Mesh> {
    let mut mesh = floor_mesh(grid, values, MAX_LINES)?;
    for vertex in &mut mesh.vertices {
        vertex.uncut = 0.0;
    }
    Some(mesh)
}

/// Mesh of the floor with, per corner, the largest contact depth (mm) of the cores that end above it.
pub fn contact_mesh(grid: &FloorGrid, plan: &PlungePlan) -> Mesh {
    let contacts: Vec<(Vec3, Vec3, f32, f32)> = plan
        .positions
        .iter()
        .filter(|p| p.evaluation.contact.interferes())
        .filter_map(|p| {
            let tool = &plan.sections.get(p.section)?.tool;
            let to = |v: [f64; 3]| Vec3::from_array(v.map(|x| x as f32));
            Some((
                to(p.tip.into()),
                to(p.axis.into()),
                tool.core_radius() as f32,
                p.evaluation.contact.depth as f32,
            ))
        })
        .collect();
    let cells = FloorSurface::new(grid, MAX_LINES).cells;
    let mut mesh = floor_mesh(grid, &grid.blank_heights, MAX_LINES).unwrap_or_default();
    for (vertex, &cell) in mesh.vertices.iter_mut().zip(&cells) {
        let p = Vec3::from_array(grid.points[cell]);
        vertex.uncut = 0.0;
        vertex.value = 0.0;
        for &(tip, axis, core, depth) in &contacts {
            let d = p - tip;
            let along = d.dot(axis);
            // The floor lies below the cutter's bottom by the allowance and the residual stock; points
            // further down belong to another part of the hub.
            let below = along < 1.0 && along > -4.0 * core.max(1.0);
            if below && (d - axis * along).length() <= core {
                vertex.value = vertex.value.max(depth);
            }
        }
    }
    mesh
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
        let mesh = floor_mesh(&grid, &heights, MAX_LINES).expect("fits");
        assert_eq!(mesh.triangles(), (9 - 4) * 2);
        assert_eq!(mesh.vertices[15].uncut, 1.0);
        assert_eq!(mesh.vertices[14].uncut, 0.0);
        assert_eq!(floor_mesh(&grid, &heights[1..], MAX_LINES), None);
    }
}
