//! From the frame of the part to that of the program: inlet up or down, clocking.

use super::model::PartPlacement;
use crate::geometry::{Point, Vector, rotate_vector_z, rotate_z};
use crate::part::Impeller;

/// The turn from the part frame to the program's, whose Z is the table's normal at rest.
///
/// A part whose inlet points the other way than the machine wants is turned by half a turn about X, then the
/// part is turned about Z by its clocking. The origins agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedPart {
    flipped: bool,
    clock_rad: f64,
}

impl PlacedPart {
    /// A part whose inlet points along +Z of its own frame, or (`inlet_up_in_part` false) along −Z.
    pub fn new(placement: &PartPlacement, inlet_up_in_part: bool) -> Self {
        Self { flipped: placement.inlet_up != inlet_up_in_part, clock_rad: placement.clock_rad }
    }

    /// `part` by its own inlet.
    pub fn from_placement(placement: &PartPlacement, part: &Impeller) -> Self {
        Self::new(placement, part.out_of_inlet().z > 0.0)
    }

    /// How the part lies otherwise than in its own frame, for the head of a program: lines that a control can
    /// show; none where it lies as in its frame.
    pub fn comments(&self) -> Vec<String> {
        let turned_over = self.flipped.then(|| "part turned over by half a turn about its X".to_owned());
        let degrees = self.clock_rad.to_degrees();
        // Less than the last decimal is none.
        let clocked = (degrees.abs() >= 5e-4).then(|| format!("part turned by {degrees:.3} deg about Z"));
        turned_over.into_iter().chain(clocked).collect()
    }

    /// A tip of the part frame, in the program's.
    pub fn point_in_program(&self, p: &Point) -> Point {
        rotate_z(&if self.flipped { Point::new(p.x, -p.y, -p.z) } else { *p }, self.clock_rad)
    }

    /// A direction of the part frame, in the program's.
    pub fn vector_in_program(&self, v: &Vector) -> Vector {
        rotate_vector_z(&if self.flipped { Vector::new(v.x, -v.y, -v.z) } else { *v }, self.clock_rad)
    }

    /// The inverse of [`Self::point_in_program`].
    pub fn point_in_part(&self, p: &Point) -> Point {
        let p = rotate_z(p, -self.clock_rad);
        if self.flipped { Point::new(p.x, -p.y, -p.z) } else { p }
    }

    /// The inverse of [`Self::vector_in_program`].
    pub fn vector_in_part(&self, v: &Vector) -> Vector {
        let v = rotate_vector_z(v, -self.clock_rad);
        if self.flipped { Vector::new(v.x, -v.y, -v.z) } else { v }
    }
}
