//! Tools.

use super::assembly::ToolAssembly;
use crate::geometry::{CutterSolid, Point, Vector};

/// A milling tool: cutter, shank, holder and cutting data. All lengths mm.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Tool {
    /// Number in the machine's magazine.
    pub number: u32,
    /// Diameter D = 2R of the cutter.
    pub diameter: f64,
    /// Radius of the rounded corner, 0 for a sharp one; at most R.
    pub corner_radius: f64,
    /// Radial width w of the bottom cutting edges; the core inside R − w has none.
    pub insert_width: f64,
    /// Free length from the tip to the holder.
    pub overhang: f64,
    /// Feed rate of a plunge, mm/min.
    pub plunge_feed: f64,
    /// Spindle speed, rev/min.
    pub spindle: f64,
    /// Shank, holder and what else a library says about the tool; empty where nothing is known.
    #[serde(flatten)]
    pub assembly: ToolAssembly,
}

impl Tool {
    /// R, mm.
    pub fn radius(&self) -> f64 {
        self.diameter / 2.0
    }

    /// Radius of the core, where no edge cuts: R − w, mm.
    pub fn core_radius(&self) -> f64 {
        self.radius() - self.insert_width
    }

    /// Largest diameter of the holder, mm; where none is given it is assumed to be twice the cutter's. The
    /// holder begins at the end of the overhang.
    pub fn holder_diameter(&self) -> f64 {
        let widest = |most: f64, [lower, upper, _]: &[f64; 3]| most.max(*lower).max(*upper);
        match self.assembly.holder.is_empty() {
            true => 2.0 * self.diameter,
            false => self.assembly.holder.iter().fold(0.0, widest),
        }
    }

    /// The cutter with the centre of its bottom at `tip` and its unit `axis` towards the holder.
    pub fn placed(&self, tip: Point, axis: Vector) -> CutterSolid {
        CutterSolid { tip, axis, radius: self.radius(), corner_radius: self.corner_radius }
    }

    /// The holder with the cutter at `tip` and its unit `axis`, as a cylinder of its largest diameter,
    /// unbounded towards the spindle: it contains the holder.
    pub fn holder(&self, tip: Point, axis: Vector) -> CutterSolid {
        let radius = 0.5 * self.holder_diameter();
        CutterSolid { tip: tip + axis * self.overhang, axis, radius, corner_radius: 0.0 }
    }

    /// Tip of the cutter with unit `axis` that touches a surface at `contact` with its corner, or with the
    /// rim of its bottom; `normal` is the unit normal of the surface, out of the stock.
    pub fn tip_at_contact(&self, contact: &Point, normal: &Vector, axis: &Vector) -> Point {
        let (rim, corner) = (self.radius() - self.corner_radius, self.corner_radius);
        let across = normal - axis * normal.dot(axis);
        let outwards = across.try_normalize(1e-9).unwrap_or_else(Vector::zeros);
        contact + normal * corner + outwards * rim - axis * corner
    }
}
