//! Discrete linear Chebyshev approximation by the exchange algorithm (Remez, Stiefel).

use nalgebra::{Matrix3, Vector3};

/// Maximum number of exchanges per minimax step.
const EXCHANGES: usize = 40;

/// A deviation as a linear function of three parameters.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinearDeviation {
    /// Its slope by each parameter.
    pub(super) slope: Vector3<f64>,
    /// Deviation where the parameters are zero.
    pub(super) at_rest: f64,
    /// Whether it counts only where it is negative.
    pub(super) only_below: bool,
}

impl LinearDeviation {
    /// The deviation that counts, at the parameters `x`.
    fn off(&self, x: &Vector3<f64>) -> f64 {
        let deviation = self.at_rest + self.slope.dot(x);
        if self.only_below { -deviation } else { deviation.abs() }
    }
}

/// The parameters that minimise the maximum of the
/// `rows`. Four rows define the level; the row with the largest deviation replaces the one that lets the
/// level rise most. `first` are four different rows that count both above and below.
pub(super) fn minimax(rows: &[LinearDeviation], first: [usize; 4]) -> Option<Vector3<f64>> {
    let mut deciding = first;
    let mut best = reference_level(rows, &deciding)?;
    for _ in 0..EXCHANGES {
        let (level_now, x) = best;
        let worst = (0..rows.len()).max_by(|&i, &j| rows[i].off(&x).total_cmp(&rows[j].off(&x)))?;
        if rows[worst].off(&x) <= level_now * (1.0 + 1e-9) + 1e-12 || deciding.contains(&worst) {
            break;
        }
        let exchanged = (0..4).filter_map(|k| {
            let mut next = deciding;
            next[k] = worst;
            reference_level(rows, &next).map(|there| (there, next))
        });
        let Some((there, next)) = exchanged.max_by(|a, b| a.0.0.total_cmp(&b.0.0)) else { break };
        (best, deciding) = (there, next);
    }
    Some(best.1)
}

/// Minimax deviation of four rows alone, and the parameters that attain it; `None` where a row that counts
/// only below would be above.
fn reference_level(rows: &[LinearDeviation], four: &[usize; 4]) -> Option<(f64, Vector3<f64>)> {
    let row = |k: usize| &rows[four[k]];
    let others = |k: usize| [(k + 1) % 4, (k + 2) % 4, (k + 3) % 4];
    // Coefficients of the linear dependence of the four slopes.
    let weights: [f64; 4] = std::array::from_fn(|k| {
        let [a, b, c] = others(k);
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        sign * row(a).slope.dot(&row(b).slope.cross(&row(c).slope))
    });
    let total: f64 = weights.iter().map(|w| w.abs()).sum();
    let level = weights.iter().enumerate().map(|(k, w)| w * row(k).at_rest).sum::<f64>() / total;
    let above = |k: usize| row(k).only_below && level * weights[k] > 0.0;
    if (0..4).any(above) {
        return None;
    }
    let heaviest = (0..4).max_by(|&i, &j| weights[i].abs().total_cmp(&weights[j].abs()))?;
    let [a, b, c] = others(heaviest);
    let matrix = Matrix3::from_rows(&[row(a), row(b), row(c)].map(|r| r.slope.transpose()));
    let wanted = [a, b, c].map(|k| level * weights[k].signum() - row(k).at_rest);
    let x = matrix.try_inverse()? * Vector3::from(wanted);
    (level.is_finite() && x.iter().all(|x| x.is_finite())).then_some((level.abs(), x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parabola_through_a_quartic_is_chebyshev_s() {
        // Best quadratic approximation of x⁴ on [−1, 1]: x² − 1/8, greatest error 1/8.
        let rows: Vec<LinearDeviation> = (0..=400)
            .map(|k| {
                let x = f64::from(k) / 200.0 - 1.0;
                LinearDeviation {
                    slope: -Vector3::new(1.0, x, x * x),
                    at_rest: x.powi(4),
                    ..LinearDeviation::default()
                }
            })
            .collect();
        let found = minimax(&rows, [0, 100, 200, 300]).expect("a parabola");
        assert!((found - Vector3::new(-0.125, 0.0, 1.0)).norm() < 1e-3, "{found}");
    }

    #[test]
    fn no_other_numbers_do_better_and_what_decides_nothing_stays() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for case in 0..50 {
            let mut rows: Vec<LinearDeviation> = (0..12)
                .map(|k| LinearDeviation {
                    slope: Vector3::new(random(), random(), random()),
                    at_rest: random(),
                    only_below: k > 7 && case % 3 == 0,
                })
                .collect();
            if case % 2 == 0 {
                // The third parameter affects only the last row.
                rows.iter_mut().for_each(|row| row.slope.z = 0.0);
            }
            rows.push(LinearDeviation { slope: Vector3::new(0.0, 0.0, 1e-4), ..LinearDeviation::default() });
            let most = |x: &Vector3<f64>| rows.iter().map(|r| r.off(x)).fold(0.0, f64::max);
            let found = minimax(&rows, [0, 4, 7, 12]).expect("numbers");
            let least = most(&found);
            for _ in 0..2000 {
                let step = Vector3::new(random(), random(), random()) * 0.01;
                assert!(most(&(found + step)) >= least - 1e-9, "case {case}: {least} is not least");
            }
        }
    }
}
