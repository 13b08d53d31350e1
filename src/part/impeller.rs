//! The impeller: hub, shroud and blades, trimmed to each other and checked.

use super::description::{Meridional, PartDescription, PartError};
use crate::geometry::{Point, Vector};

/// Hub or shroud: a meridional curve with s = 0 where the main blade's leading edge meets it and
/// s = 1 at the rim. The curve itself may reach upstream of s = 0 (hub nose).
#[derive(Clone, Debug)]
pub struct Flowpath {}

impl Flowpath {
    /// Range of s the curve covers: (≤ 0, 1).
    pub fn s_range(&self) -> (f64, f64) {
        todo!()
    }
    /// Point at fraction `s` of the arc length; clamped to [`Self::s_range`].
    pub fn point(&self, _s: f64) -> Meridional {
        todo!()
    }
    /// Unit normal at `s` in the meridional plane, pointing into the channel for the hub and out
    /// of it for the shroud (both away from the hub body).
    pub fn normal(&self, _s: f64) -> Meridional {
        todo!()
    }
    /// Arc length from s = 0 to s = 1, mm.
    pub fn length(&self) -> f64 {
        todo!()
    }
}

/// One side of a blade, trimmed to hub and shroud.
#[derive(Clone, Debug)]
pub struct BladeSide {}

impl BladeSide {
    /// Point at u (0 LE … 1 TE) and v (0 on the hub … 1 at the shroud).
    pub fn point(&self, _u: f64, _v: f64) -> Point {
        todo!()
    }
    /// Point and derivatives by u and v.
    pub fn derivatives(&self, _u: f64, _v: f64) -> (Point, Vector, Vector) {
        todo!()
    }
    /// Values of u at which the file has points: where to put mesh lines.
    pub fn u_knots(&self) -> &[f64] {
        todo!()
    }
}

/// A blade in its place (first of its kind; the others follow by rotation of a pitch).
#[derive(Clone, Debug)]
pub struct Blade {
    /// Suction side.
    pub suction: BladeSide,
    /// Pressure side. At LE both sides meet; at a blunt TE they do not.
    pub pressure: BladeSide,
}

/// A centrifugal impeller.
#[derive(Clone, Debug)]
pub struct Impeller {
    /// Name of the part.
    pub name: String,
    /// Number of main blades.
    pub blade_count: usize,
    /// Hub.
    pub hub: Flowpath,
    /// Shroud.
    pub shroud: Flowpath,
    /// Main blade.
    pub main: Blade,
    /// Splitters of one pitch, in place.
    pub splitters: Vec<Blade>,
}

impl Impeller {
    /// Trims, extends and checks a description.
    pub fn build(_description: &PartDescription) -> Result<Self, PartError> {
        todo!()
    }
    /// Angle between neighbouring main blades, rad; signed: channel 1 lies between the suction side
    /// of `main` and the pressure side of `main` rotated about Z by this angle.
    pub fn pitch(&self) -> f64 {
        todo!()
    }
}
