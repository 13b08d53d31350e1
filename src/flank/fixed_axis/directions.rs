//! Grids of directions.

use crate::geometry::{Vector, frame_about};

/// Angle between directions of the grid, rad.
pub(super) const GRID: f64 = 6.0 * std::f64::consts::PI / 180.0;

/// Directions over the whole sphere, neighbours about [`GRID`] apart (Fibonacci spiral).
pub(super) fn directions() -> Vec<Vector> {
    let count = (4.0 * std::f64::consts::PI / (GRID * GRID)).ceil();
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count as usize)
        .map(|k| {
            let z = 1.0 - (2.0 * k as f64 + 1.0) / count;
            let (sin, cos) = (golden * k as f64).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            Vector::new(r * cos, r * sin, z)
        })
        .collect()
}

/// Eight directions at `angle` (rad) to `axis`.
pub(super) fn ring(axis: &Vector, angle: f64) -> [Vector; 8] {
    let (e1, e2) = frame_about(axis);
    std::array::from_fn(|k| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * k as f64).sin_cos();
        (axis * angle.cos() + (e1 * cos + e2 * sin) * angle.sin()).normalize()
    })
}
