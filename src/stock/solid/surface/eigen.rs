//! Eigenvalues and eigenvectors of symmetric 3 × 3 matrices.

use crate::geometry::Vector;

/// Rotations of all three pairs after which a matrix is diagonal to rounding; convergence is quadratic.
const MAX_SWEEPS: usize = 12;
/// Squared share of the elements beside the diagonal at which it counts as diagonal.
const DIAGONAL: f64 = 1e-30;

/// The eigenvalues and unit eigenvectors of the symmetric matrix with the upper triangle `a` (Jacobi's
/// method, cyclic).
pub fn symmetric_parts(mut a: [[f64; 3]; 3]) -> [(f64, Vector); 3] {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..MAX_SWEEPS {
        let off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        let trace = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
        if off <= DIAGONAL * trace {
            break;
        }
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let apq = a[p][q];
            if apq == 0.0 {
                continue;
            }
            // The smaller of both angles that make the element zero.
            let theta = (a[q][q] - a[p][p]) / (2.0 * apq);
            let tan = 1f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cos = 1.0 / (tan * tan + 1.0).sqrt();
            let sin = tan * cos;
            a[p][p] -= tan * apq;
            a[q][q] += tan * apq;
            a[p][q] = 0.0;
            let (pr, qr) = ((p.min(r), p.max(r)), (q.min(r), q.max(r)));
            let (x, y) = (a[pr.0][pr.1], a[qr.0][qr.1]);
            a[pr.0][pr.1] = cos * x - sin * y;
            a[qr.0][qr.1] = sin * x + cos * y;
            let (x, y) = (vectors[p], vectors[q]);
            for k in 0..3 {
                vectors[p][k] = cos * x[k] - sin * y[k];
                vectors[q][k] = sin * x[k] + cos * y[k];
            }
        }
    }
    std::array::from_fn(|k| (a[k][k], Vector::from(vectors[k])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_matrix_are_orthogonal_and_make_it_again() {
        let unit = |i: usize| {
            let (a, b) = (2.4 * i as f64, 0.7 * i as f64);
            Vector::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos())
        };
        for count in 1..40 {
            // Sums of squares of normals, as in cells; of one normal alone, two eigenvalues are zero.
            let mut matrix = nalgebra::Matrix3::zeros();
            for i in 0..count.min(5) {
                matrix += unit(count + i) * unit(count + i).transpose();
            }
            let upper = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
            let parts = symmetric_parts(upper);
            let made: nalgebra::Matrix3<f64> =
                parts.iter().map(|(value, v)| v * v.transpose() * *value).sum();
            assert!((made - matrix).norm() < 1e-13, "{count}: {matrix} {parts:?}");
            for (i, (_, v)) in parts.iter().enumerate() {
                assert!((v.norm() - 1.0).abs() < 1e-14);
                assert!(parts[..i].iter().all(|(_, other)| v.dot(other).abs() < 1e-14));
            }
        }
    }
}
