//! Tilted planes (3+2) as controls describe them.

use super::post::Dialect;
use crate::geometry::{Point, Vector};
use crate::machine::turned;

/// The tilted plane that is on.
#[derive(Clone, Copy)]
pub(super) struct TiltedPlane {
    /// Its angles as the control takes them, rad.
    pub angles: [f64; 3],
    /// Directions of X, Y and Z of the plane.
    frame: [Vector; 3],
}

impl Default for TiltedPlane {
    fn default() -> Self {
        Self { angles: [0.0; 3], frame: [Vector::x(), Vector::y(), Vector::z()] }
    }
}

impl TiltedPlane {
    /// The plane across `axis`, by the angles that a control of this dialect takes, rounded to `decimals` of
    /// a degree: positions in it are those in the plane that the control makes of them.
    pub fn across(dialect: Dialect, axis: &Vector, decimals: usize) -> Self {
        let scale = 10f64.powi(decimals as i32);
        let grid = |angle: f64| ((angle.to_degrees() * scale).round() / scale).to_radians();
        let tilt = grid(axis.z.clamp(-1.0, 1.0).acos());
        let (angles, turns) = match dialect {
            // Spatial angles: about Z, then the new Y, then the new X.
            Dialect::Heidenhain => {
                let about_z = grid(axis.y.atan2(axis.x));
                ([0.0, tilt, about_z], [(Vector::z(), about_z), (Vector::y(), tilt), (Vector::z(), 0.0)])
            }
            // Axis by axis: about X, then the new Y, then the new Z.
            Dialect::Siemens => {
                let about_y = grid(axis.x.clamp(-1.0, 1.0).asin());
                let about_x = grid((-axis.y).atan2(axis.z));
                (
                    [about_x, about_y, 0.0],
                    [(Vector::x(), about_x), (Vector::y(), about_y), (Vector::z(), 0.0)],
                )
            }
            // Euler angles: about Z, the new X, the new Z.
            _ => {
                let about_z = grid(axis.x.atan2(-axis.y));
                let turns = [(Vector::z(), about_z), (Vector::x(), tilt), (Vector::z(), -about_z)];
                ([about_z, tilt, -about_z], turns)
            }
        };
        let frame = [Vector::x(), Vector::y(), Vector::z()]
            .map(|v| turns.iter().rev().fold(v, |v, (axis, angle)| turned(axis, *angle, &v)));
        Self { angles, frame }
    }

    /// `p`, given in program coordinates, in those of the plane.
    pub fn coordinates(&self, p: &Point) -> Point {
        Point::new(self.frame[0].dot(&p.coords), self.frame[1].dot(&p.coords), self.frame[2].dot(&p.coords))
    }
}
