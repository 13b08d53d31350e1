//! `TRACUT` and `TRANS`: where the positions of a program really are.

use crate::geometry::{Point, Vector};

/// By how much rows of a `TRACUT` matrix may miss being those of a rotation.
const ROTATION_TOLERANCE: f64 = 1e-6;

/// What is done to every position from a statement on: first the matrix of `TRACUT`, then the shift of `TRANS`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transform {
    rows: [Vector; 3],
    offset: Vector,
    shift: Vector,
}

impl Default for Transform {
    fn default() -> Self {
        let rows = [Vector::x(), Vector::y(), Vector::z()];
        Self { rows, offset: Vector::zeros(), shift: Vector::zeros() }
    }
}

impl Transform {
    /// `TRACUT/a1,b1,c1,d1,…,d3`: rows of a rotation, each with its shift; lengths in units of `unit` mm.
    ///
    /// # Errors
    /// What is wrong with the numbers.
    pub fn set_matrix(&mut self, numbers: &[f64], unit: f64) -> Result<(), String> {
        let [a1, b1, c1, d1, a2, b2, c2, d2, a3, b3, c3, d3] = *numbers else {
            return Err(format!("TRACUT has {} numbers, not 12", numbers.len()));
        };
        let rows = [Vector::new(a1, b1, c1), Vector::new(a2, b2, c2), Vector::new(a3, b3, c3)];
        for (i, row) in rows.iter().enumerate() {
            for (j, other) in rows.iter().enumerate().skip(i) {
                let wanted = if i == j { 1.0 } else { 0.0 };
                if (row.dot(other) - wanted).abs() > ROTATION_TOLERANCE {
                    return Err("the matrix of TRACUT is not that of a rotation".to_owned());
                }
            }
        }
        (self.rows, self.offset) = (rows, Vector::new(d1, d2, d3) * unit);
        Ok(())
    }

    /// `TRACUT/NOMORE`.
    pub fn clear_matrix(&mut self) {
        *self = Self { shift: self.shift, ..Self::default() };
    }

    /// `TRANS/x,y,z`, mm; it takes the place of the one before.
    pub fn set_shift(&mut self, shift: Vector) {
        self.shift = shift;
    }

    fn turned(&self, v: &Vector) -> Vector {
        Vector::new(self.rows[0].dot(v), self.rows[1].dot(v), self.rows[2].dot(v))
    }

    /// A position, with its axis.
    pub fn apply(&self, tip: &Point, axis: &Vector) -> (Point, Vector) {
        (Point::from(self.turned(&tip.coords) + self.offset + self.shift), self.turned(axis))
    }
}
