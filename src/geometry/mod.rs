//! Geometry in f64, millimetres and radians: a catalogue of curves, surfaces and queries.

/// A point in the frame of the part: rotation axis Z, mm.
pub type Point = nalgebra::Point3<f64>;
/// A vector in the frame of the part, mm (or without unit for directions).
pub type Vector = nalgebra::Vector3<f64>;
