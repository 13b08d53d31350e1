//! One plunge as the kernels of the heightfield take it.

use crate::geometry::{Point, Vector};
use crate::setup::Tool;

/// One plunge as the kernels take it: a cylinder from the tip upwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldCutter {
    /// Tip M: centre of the bottom, mm.
    pub tip: [f32; 3],
    /// Radius R, mm.
    pub radius: f32,
    /// Unit axis, tip → holder.
    pub axis: [f32; 3],
    /// Core radius R − w, mm.
    pub core_radius: f32,
    /// Corner radius, mm.
    pub corner_radius: f32,
}

impl FieldCutter {
    /// The plunge of `tool` to `tip` along the unit `axis`.
    pub fn from_tool(tool: &Tool, tip: Point, axis: Vector) -> Self {
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        Self {
            tip: single(tip.coords.into()),
            radius: tool.radius() as f32,
            axis: single(axis.into()),
            core_radius: tool.core_radius() as f32,
            corner_radius: tool.corner_radius as f32,
        }
    }
}
