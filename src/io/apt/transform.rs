//! The transforms `TRACUT` and `TRANS`, from the program's frame to the part frame.

use crate::geometry::{Point, Vector};

/// Tolerance on the orthonormality of the rows of a `TRACUT` matrix.
const ROTATION_TOLERANCE: f64 = 1e-6;

/// The transform of all following positions: first the matrix of `TRACUT`, then the shift of `TRANS`.
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
    /// When there are not 12 numbers, or the matrix is not orthonormal.
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

    /// `TRACUT/NOMORE`: removes the matrix.
    pub fn clear_matrix(&mut self) {
        *self = Self { shift: self.shift, ..Self::default() };
    }

    /// `TRANS/x,y,z`, mm; replaces the previous shift.
    pub fn set_shift(&mut self, shift: Vector) {
        self.shift = shift;
    }

    fn turned(&self, v: &Vector) -> Vector {
        Vector::new(self.rows[0].dot(v), self.rows[1].dot(v), self.rows[2].dot(v))
    }

    /// Transforms a tip (mm) and its tool axis.
    pub fn apply(&self, tip: &Point, axis: &Vector) -> (Point, Vector) {
        (Point::from(self.turned(&tip.coords) + self.offset + self.shift), self.turned(axis))
    }
}
