//! Meshes of blade walls with a measured value per corner.

use glam::Vec3;

use crate::gpu::mesh::{Mesh, PointGrid};
use crate::part::BladeSide;

/// Mesh of `wall` over the parameter lines `u` and `v`, with `values[i · v.len() + j]` at `u[i]`, `v[j]`;
/// `back` is the other side of the blade and orients the normals. Returns `None` when the sizes do not match.
pub fn wall_mesh(wall: &BladeSide, back: &BladeSide, u: &[f64], v: &[f64], values: &[f64]) -> Option<Mesh> {
    if values.len() != u.len() * v.len() || u.len() < 2 || v.len() < 2 {
        return None;
    }
    let point = |side: &BladeSide, u: f64, v: f64| {
        let p = side.point(u, v);
        Vec3::new(p.x as f32, p.y as f32, p.z as f32)
    };
    let grid = PointGrid::sample(u, v, |u, v| point(wall, u, v));
    let behind = PointGrid::sample(u, v, |u, v| point(back, u, v));
    Some(grid.mesh(|i, j| grid.at(i, j) - behind.at(i, j), |i, j| values[i * v.len() + j] as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn values_stand_at_their_corners() {
        let u = [0.0, 0.3, 0.7, 1.0];
        let side = |y: f64| {
            let row = |x: f64| u.iter().map(|&z| Point::new(x, y, z)).collect::<Vec<_>>();
            BladeSide::loft(&u, &[0.0, 1.0], &[row(10.0), row(20.0)])
        };
        let (wall, back) = (side(1.0), side(-1.0));
        let values: Vec<f64> = (0..8).map(f64::from).collect();
        let mesh = wall_mesh(&wall, &back, &u, &[0.0, 1.0], &values).expect("fits");
        assert_eq!(mesh.triangles(), 6);
        let corner = mesh.vertices[5];
        assert_eq!((corner.value, corner.position), (5.0, [20.0, 1.0, 0.7]));
        assert!(mesh.vertices.iter().all(|v| v.normal[1] > 0.9), "normals point away from the blade");
        assert_eq!(wall_mesh(&wall, &back, &u, &[0.0, 1.0], &values[1..]), None);
    }
}
