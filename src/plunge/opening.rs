//! Opening: plunges along the axis of rotation that remove what stands above the shroud in the way of the
//! tools of the channel.
//!
//! A blank that is higher than the shroud, as a cylinder is, would have the plunges of the channel begin at
//! its outside: deeper than their tools are long. Rows lie in planes through the axis of rotation and run
//! from the outside inwards, each plunge down to the shroud. They are those of one pitch, repeated all
//! around; a row that is not needed further inwards, where rows come closer, ends there.

use super::spacing::{step_limit, stepover};
use crate::cutting::retract::RetractSurface;
use crate::geometry::{Meridional, Point};
use crate::part::{Blank, Impeller};
use crate::setup::{Setup, Tool};

/// Gap between core and blank at the start of a row, and above the allowance on the blade tips, mm.
const MARGIN: f64 = 0.05;
/// Depth of stock that is worth a plunge, in cutter radii.
const MIN_DEPTH_RADII: f64 = 0.1;
/// Maximum number of times that the rows of a pitch are doubled.
const MAX_DOUBLINGS: u32 = 12;

/// What stands above the shroud of a part.
#[derive(Debug)]
pub struct Opening<'a> {
    part: &'a Impeller,
    setup: &'a Setup,
    blank: &'a Blank,
    /// The blank that ends at the shroud.
    below: Blank,
}

/// A row of plunges from the outside inwards, in a plane through the axis of rotation.
#[derive(Clone, Debug)]
pub struct OpeningRow {
    /// Share of the pitch by which it is turned from the plane y = 0.
    pub share: f64,
    /// Tips in cutting order.
    pub tips: Vec<Point>,
    /// Height of the stock above each tip, mm.
    pub depths: Vec<f64>,
}

impl<'a> Opening<'a> {
    /// What stands above the shroud of `part` in `blank`.
    pub fn new(part: &'a Impeller, blank: &'a Blank, setup: &'a Setup) -> Self {
        Self { part, setup, blank, below: Blank::from_part(part, setup.allowances.inlet_extension) }
    }

    /// The rows of one pitch with `tool`.
    pub fn rows(&self, tool: &Tool) -> Vec<OpeningRow> {
        let outside = self.blank.extent().0 + tool.core_radius().max(0.0) + MARGIN;
        let pitch = self.part.pitch();
        let gap = outside * pitch.abs() / stepover(&self.setup.plunge, tool);
        let doublings = gap.log2().ceil().clamp(0.0, f64::from(MAX_DOUBLINGS)) as u32;
        let count = 1u32 << doublings;
        let places = self.places(tool, outside);
        let row = |number: u32| {
            let share = f64::from(number) / f64::from(count);
            // Distance of the two rows beside it, which are of coarser doublings, in pitches: the row is
            // needed where that exceeds the stepover.
            let without = f64::from(2u32 << number.trailing_zeros().min(doublings)) / f64::from(count);
            let is_needed =
                |r: f64| number == 0 || without * pitch.abs() * r > stepover(&self.setup.plunge, tool);
            let kept = places.iter().take_while(|(p, _)| is_needed(p.r));
            let (tips, depths) = kept.map(|(p, depth)| (p.at_angle(share * pitch), *depth)).unzip();
            OpeningRow { share, tips, depths }
        };
        (0..count).map(row).collect()
    }

    /// Tips of a row that runs through, with the height of the stock above each.
    fn places(&self, tool: &Tool, outside: f64) -> Vec<(Meridional, f64)> {
        let axis = self.part.out_of_inlet();
        let (corner, up) = (tool.corner_radius, axis.z);
        let gap = self.setup.allowances.blade_allowance + MARGIN;
        let surface = RetractSurface::new(&self.below, gap + corner);
        // Beyond the rim down to where the hub ends.
        let floor = self.part.hub.point(1.0).z + up * (self.setup.allowances.hub_allowance + MARGIN);
        let inner = self.part.hub.point(0.0).r;
        let step = step_limit(&self.setup.plunge, tool, false);
        let count = ((outside - inner) / step).floor().max(0.0) as usize;
        let place = |k: usize| {
            let r = outside - step * k as f64;
            let base = Point::new(r, 0.0, floor);
            let height = surface.height(&base, &axis, tool.radius() - corner);
            let tip = base + axis * (height - corner).max(0.0);
            let depth = self.blank.outline_touch(&tip, &axis, tool.radius(), 0.0)?;
            (depth > MIN_DEPTH_RADII * tool.radius()).then_some((Meridional { r, z: tip.z }, depth))
        };
        (0..=count).filter_map(place).collect()
    }
}
