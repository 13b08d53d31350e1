//! Reconstruction of the rulings of a blade's side from its sections: a flank-milled blade is a ruled
//! surface, and plans follow its rulings from hub to tip.

use nalgebra::{DMatrix, DVector};

use super::sides::SideCurve;
use crate::geometry::{Cubic, Point, Vector};

/// Number of free values of the shift of the rulings' upper ends along the side.
const FREE: usize = 50;
/// Number of rulings whose distances are minimised.
const LINES: usize = 120;
/// The nose and its transition to the flank extend to the first parameter and get the second value as their
/// share of the knots, because the rulings turn quickest there.
const NOSE: (f64, f64) = (0.4, 0.7);
/// Number of points of a section's curve.
const SAMPLES: usize = 601;
/// Largest number of Gauss–Newton iterations.
const ROUNDS: usize = 12;
/// Change of a shift by which the slopes of the distances are found.
const SHIFT_STEP: f64 = 1e-5;
/// Largest free value.
const MAX_VALUE: f64 = 0.3;
/// Weight of a squared second difference of the shift relative to a square millimetre of distance.
const STIFFNESS: f64 = 0.02;

/// Rulings from the lowest section of a side to its highest.
#[derive(Clone, Debug)]
pub struct Rulings {
    lowest: Cubic<3>,
    highest: Cubic<3>,
    shift: Cubic<1>,
    /// Largest distance of a ruling from the sections in between, mm.
    pub max_distance_mm: f64,
}

fn sampled(side: &SideCurve) -> Cubic<3> {
    let w: Vec<f64> = (0..SAMPLES).map(|i| i as f64 / (SAMPLES - 1) as f64).collect();
    let points: Vec<[f64; 3]> = w.iter().map(|&w| side.point(w).coords.into()).collect();
    Cubic::interpolate(&w, &points)
}

/// The parameter at a share of the knots.
fn graded(share: f64) -> f64 {
    let (end, places) = NOSE;
    if share < places { end * share / places } else { end + (1.0 - end) * (share - places) / (1.0 - places) }
}

fn shift(values: &[f64]) -> Cubic<1> {
    let n = values.len() + 1;
    let knots: Vec<f64> = (0..=n).map(|i| graded(i as f64 / n as f64)).collect();
    // The shift is zero at both ends: the first and the last ruling are leading and trailing edge.
    let mut points = vec![[0.0]; n + 1];
    points[1..n].iter_mut().zip(values).for_each(|(p, v)| p[0] = *v);
    Cubic::interpolate(&knots, &points)
}

/// Shift of each line (row) by a unit of each free value (column).
fn shifts_by_value(line_at: impl Fn(usize) -> f64) -> DMatrix<f64> {
    let mut shifts = DMatrix::zeros(LINES, FREE);
    for k in 0..FREE {
        let mut unit = [0.0; FREE];
        unit[k] = 1.0;
        let curve = shift(&unit);
        for i in 0..LINES {
            shifts[(i, k)] = curve.point(line_at(i))[0];
        }
    }
    shifts
}

impl Rulings {
    /// Fits the rulings of a side to its sections, hub → tip, by damped Gauss–Newton iterations. `None` with
    /// fewer than three sections.
    pub fn from_sections(sections: &[&SideCurve]) -> Option<Self> {
        let curves: Vec<Cubic<3>> = sections.iter().map(|s| sampled(s)).collect();
        let (lowest, highest) = (curves.first()?, curves.last()?);
        let between = &curves[1..curves.len() - 1];
        if between.is_empty() {
            return None;
        }
        let line_at = |i: usize| graded((i as f64 + 0.5) / LINES as f64);
        // The shift of each line is linear in the free values.
        let by_value = shifts_by_value(line_at);
        let errors = |shifts: &DVector<f64>| -> Vec<f64> {
            let line = |i: usize| distances(lowest, highest, between, (line_at(i), shifts[i]));
            (0..LINES).flat_map(line).collect()
        };
        let cost = |errors: &[f64], values: &DVector<f64>| {
            errors.iter().map(|e| e * e).sum::<f64>()
                + STIFFNESS * LINES as f64 * second_differences(values.as_slice()).map(|b| b * b).sum::<f64>()
        };
        let mut values: DVector<f64> = DVector::zeros(FREE);
        let mut shifts = &by_value * &values;
        let mut here = errors(&shifts);
        let mut least = cost(&here, &values);
        for _ in 0..ROUNDS {
            // The distances of a line depend on its own shift only.
            let moved = errors(&shifts.add_scalar(SHIFT_STEP));
            let slopes = DMatrix::from_fn(here.len(), FREE, |row, k| {
                (moved[row] - here[row]) / SHIFT_STEP * by_value[(row / between.len(), k)]
            });
            let mut matrix = slopes.transpose() * &slopes;
            let mut right = -(slopes.transpose() * DVector::from_column_slice(&here));
            add_stiffness(&mut matrix, &mut right, values.as_slice());
            let Some(step) = matrix.cholesky().map(|c| c.solve(&right)) else { break };
            let mut found = false;
            for damping in [1.0, 0.5, 0.2, 0.05] {
                let tried = &values + damping * &step;
                if !tried.iter().all(|v| v.abs() < MAX_VALUE) {
                    continue;
                }
                let tried_shifts = &by_value * &tried;
                let errors = errors(&tried_shifts);
                let now = cost(&errors, &tried);
                if now < least {
                    found = now < least * (1.0 - 1e-4);
                    (values, shifts, here, least) = (tried, tried_shifts, errors, now);
                    break;
                }
            }
            if !found {
                break;
            }
        }
        let off = here.iter().fold(0.0, |worst: f64, e| worst.max(e.abs()));
        Some(Self {
            lowest: lowest.clone(),
            highest: highest.clone(),
            shift: shift(values.as_slice()),
            max_distance_mm: off,
        })
    }

    /// Both ends of the ruling at parameter `w` of the lowest section.
    pub fn ends(&self, w: f64) -> [Point; 2] {
        let upper = (w + self.shift.point(w)[0]).clamp(0.0, 1.0);
        [self.lowest.point(w), self.highest.point(upper)].map(|p| Point::from(Vector::from(p)))
    }
}

fn second_differences(values: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let at = |i: usize| if i == 0 || i > FREE { 0.0 } else { values[i - 1] };
    (1..=FREE).map(move |i| at(i - 1) - 2.0 * at(i) + at(i + 1))
}

fn add_stiffness(matrix: &mut DMatrix<f64>, right: &mut DVector<f64>, values: &[f64]) {
    let weight = STIFFNESS * LINES as f64;
    for (i, bend) in second_differences(values).enumerate() {
        let row = [(i.checked_sub(1), 1.0), (Some(i), -2.0), (Some(i + 1).filter(|k| *k < FREE), 1.0)];
        for (a, x) in row {
            let Some(a) = a else { continue };
            right[a] -= weight * x * bend;
            for (b, y) in row {
                if let Some(b) = b {
                    matrix[(a, b)] += weight * x * y;
                }
            }
        }
    }
}

/// Distances along the surface's normal of the ruling at `w` with its `shift` from each section in between,
/// mm (Newton iterations for the nearest point).
fn distances<'a>(
    lowest: &Cubic<3>,
    highest: &Cubic<3>,
    between: &'a [Cubic<3>],
    (w, shift): (f64, f64),
) -> impl Iterator<Item = f64> + 'a {
    let vector = |p: [f64; 3]| Vector::from(p);
    let upper = w + shift;
    let from = vector(lowest.point(w));
    let ruling = vector(highest.point(upper)) - from;
    let count = between.len() as f64 + 1.0;
    between.iter().enumerate().map(move |(k, curve)| {
        let mut at = w + (upper - w) * (k as f64 + 1.0) / count;
        let mut off = 0.0;
        for _ in 0..3 {
            let (p, d, _) = curve.derivatives(at);
            let (p, d) = (vector(p) - from, vector(d));
            let Some(normal) = d.cross(&ruling).try_normalize(1e-12) else { return 0.0 };
            let beside = ruling.cross(&normal);
            off = p.dot(&normal);
            at = (at - p.dot(&beside) / d.dot(&beside)).clamp(-0.1, 1.1);
        }
        off
    })
}
