//! Excess of stock: the distance of points to the finished surfaces of one channel.

use crate::geometry::{Meridional, Point};
use crate::part::{ClosedBlade, Impeller, Workpiece};

/// The finished surfaces around channel 1 of a part, prepared for the distances of many points.
pub struct Excess<'a> {
    part: &'a Impeller,
    blades: Vec<ClosedBlade>,
}

impl<'a> Excess<'a> {
    /// The surfaces of `workpiece`.
    pub fn new(workpiece: &'a Workpiece) -> Self {
        let Workpiece { part, channel, .. } = workpiece;
        // Both sides of each blade follow each other.
        let blades = channel.sides.chunks_exact(2).map(|pair| ClosedBlade::new([&pair[0], &pair[1]]));
        Self { part, blades: blades.collect() }
    }

    /// Distance of `point` to the nearest finished surface, mm: stock that stands there, negative where the
    /// finished part is cut into.
    pub fn at(&self, point: &Point) -> f64 {
        let (_, above_hub) = self.part.hub.curve().project(Meridional::of(point));
        // The finished part is the union of hub and blades.
        self.blades.iter().fold(above_hub, |nearest, blade| {
            blade.distance_below(point, nearest.max(0.0)).map_or(nearest, |distance| distance.min(nearest))
        })
    }
}
