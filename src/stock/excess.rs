//! Excess of stock: the distance of points to the finished surfaces of one channel, or of all.

use crate::geometry::{Meridional, Point, rotate_z};
use crate::part::{Channel, ClosedBlade, Impeller, Workpiece};

/// Stations along the channel at which the angle of its middle is kept.
const STATIONS: usize = 64;

/// The finished surfaces around channel 1 of a part, prepared for the distances of many points.
pub struct Excess<'a> {
    part: &'a Impeller,
    channel: &'a Channel,
    blades: Vec<ClosedBlade>,
    /// Angles of the middle of channel 1 along the hub, rad, where points of all channels are asked for.
    middle: Vec<f64>,
}

impl<'a> Excess<'a> {
    /// The surfaces of `workpiece`.
    pub fn new(workpiece: &'a Workpiece) -> Self {
        let Workpiece { part, channel, .. } = workpiece;
        // Both sides of each blade follow each other.
        let blades = channel.sides.chunks_exact(2).map(|pair| ClosedBlade::new([&pair[0], &pair[1]]));
        Self { part, channel, blades: blades.collect(), middle: Vec::new() }
    }

    /// The surfaces of all channels: those of channel 1, turned.
    #[must_use]
    pub fn in_all_channels(self) -> Self {
        let at = |station: usize| {
            let s = station as f64 / STATIONS as f64;
            self.channel.full.wall_angles(self.part, s, 0.0).map_or(0.0, |[low, high]| 0.5 * (low + high))
        };
        Self { middle: (0..=STATIONS).map(at).collect(), ..self }
    }

    /// Distance of `point` to the nearest finished surface, mm: stock that stands there, negative where the
    /// finished part is cut into.
    pub fn at(&self, point: &Point) -> f64 {
        let (t, above_hub) = self.part.hub.curve().project(Meridional::from_point(point));
        // The finished part is the union of hub and blades.
        let below = |nearest: f64, point: &Point| {
            self.blades.iter().fold(nearest, |nearest, blade| {
                blade
                    .distance_below(point, nearest.max(0.0))
                    .map_or(nearest, |distance| distance.min(nearest))
            })
        };
        if self.middle.is_empty() {
            return below(above_hub, point);
        }
        let s = self.part.hub.s_at(t).clamp(0.0, 1.0);
        let middle = self.middle[(s * STATIONS as f64).round() as usize];
        let pitch = self.part.pitch();
        let ahead = ((point.y.atan2(point.x) - middle) / pitch).round();
        // Of leaning blades the nearest may be a wall of the next channel.
        [ahead - 1.0, ahead, ahead + 1.0]
            .into_iter()
            .fold(above_hub, |nearest, channel| below(nearest, &rotate_z(point, -pitch * channel)))
    }
}
