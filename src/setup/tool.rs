//! Tools.

use std::collections::{BTreeMap, BTreeSet};

use super::assembly::{AssemblyPart, ClearanceSetup, MissingRates, ToolAssembly};
use crate::geometry::{CutterSolid, Point, Vector};

/// Length of a holder that is drawn where it is only assumed, in diameters of the cutter.
const ASSUMED_HOLDER: f64 = 1.2;
/// Least corner radius of a ball end, in radii of the cutter. On the samples a bottom that is flat, or
/// nearly, leaves 8 to 40 % of the floor in gaps of flank passes, one with this corner 1.5 to 2.4 %, and a
/// ball of any size below 0.5 %.
const MIN_BALL_SHARE: f64 = 0.95;
/// Cylinders that stand for a cone of a holder which widens.
const CONE_SLICES: u32 = 4;

/// Part of a tool in a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutlineKind {
    /// Where its edges are.
    Cutter,
    /// As thick as the cutter, above its edges.
    Body,
    /// Neck or shank.
    Shank,
    /// Holder.
    Holder,
    /// A holder that the setup does not describe.
    AssumedHolder,
}

/// A cylinder or cone of a drawing of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePiece {
    /// What it is.
    pub kind: OutlineKind,
    /// Height of its lower end above the tip, mm.
    pub from: f64,
    /// Its length, mm.
    pub length: f64,
    /// Radius at its lower and at its upper end, mm.
    pub radii: [f64; 2],
}

/// Chords of a rounded corner in a drawing.
const CORNER_CHORDS: u32 = 8;

impl OutlinePiece {
    /// Its side in a drawing of `tool`, from its lower to its upper end: radius and height above the tip, mm.
    /// A cutter has its rounded corner.
    pub fn side(&self, tool: &Tool) -> Vec<[f64; 2]> {
        let end = self.from + self.length;
        if self.kind != OutlineKind::Cutter || tool.corner_radius <= 0.0 {
            return vec![[self.radii[0], self.from], [self.radii[1], end]];
        }
        let corner = tool.corner_radius;
        let flat = (tool.radius() - corner).max(0.0);
        let turn = std::f64::consts::FRAC_PI_2 - tool.assembly.taper_rad.unwrap_or(0.0);
        let chord = |k: u32| {
            let (sin, cos) = (turn * f64::from(k) / f64::from(CORNER_CHORDS)).sin_cos();
            [flat + corner * sin, corner * (1.0 - cos)]
        };
        let mut side: Vec<[f64; 2]> = (0..=CORNER_CHORDS).map(chord).filter(|[_, up]| *up < end).collect();
        side.push([self.radii[1], end]);
        side
    }
}

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

    /// The tool with its rates as if all of them were given. Tools that differ only in that cut alike.
    pub fn with_given_rates(&self) -> Self {
        let assembly = ToolAssembly { missing_rates: MissingRates::default(), ..self.assembly.clone() };
        Self { assembly, ..self.clone() }
    }

    /// Whether it is `other` but for which of its rates are given and which, of the same amount, follow from
    /// others: plans do not depend on that.
    pub fn cuts_like(&self, other: &Self) -> bool {
        self == other || self.with_given_rates() == other.with_given_rates()
    }

    /// Whether each of `tools` cuts like that of `others` in its place.
    pub fn cut_alike<'t>(
        tools: impl IntoIterator<Item = &'t Self>,
        others: impl IntoIterator<Item = &'t Self>,
    ) -> bool {
        let (mut tools, mut others) = (tools.into_iter(), others.into_iter());
        loop {
            match (tools.next(), others.next()) {
                (None, None) => return true,
                (Some(tool), Some(other)) if tool.cuts_like(other) => {}
                _ => return false,
            }
        }
    }

    /// Whether its bottom is flat but for its corners: a mill for plunging. Others end in a ball, or nearly.
    pub fn is_flat(&self) -> bool {
        self.corner_radius < 0.5 * self.radius()
    }

    /// Whether its bottom is a ball, or hardly differs from one.
    pub fn is_ball(&self) -> bool {
        self.corner_radius >= MIN_BALL_SHARE * self.radius()
    }

    /// Whether its edges widen towards the shank; planners know cylindrical cutters only.
    pub fn is_tapered(&self) -> bool {
        self.assembly.taper_rad.is_some_and(|taper| taper > 0.0)
    }

    /// The edges of a tapered cutter as a cone, from where the rounded corner ends tangentially up to the end
    /// of the edges: its lower end above the tip, its length and the radii of its ends, mm. `None` for other
    /// cutters.
    pub fn taper_cone(&self) -> Option<(f64, f64, [f64; 2])> {
        let taper = self.assembly.taper_rad.filter(|taper| *taper > 0.0)?;
        let corner = self.corner_radius;
        let from = corner * (1.0 - taper.sin());
        let lower = (self.radius() - corner).max(0.0) + corner * taper.cos();
        let length = self.assembly.flutes_end(self.overhang) - from;
        (length > 0.0).then(|| (from, length, [lower, lower + length * taper.tan()]))
    }

    /// Number of its length offset in the control: without another one that of the tool.
    pub fn length_offset_number(&self) -> u32 {
        self.assembly.length_offset.unwrap_or(self.number)
    }

    /// Gives the tool another number. Offsets that had its former number get the new one: the former is that
    /// of another tool.
    pub fn renumber(&mut self, number: u32) {
        let ToolAssembly { length_offset, diameter_offset, .. } = &mut self.assembly;
        for offset in [length_offset, diameter_offset].into_iter().flatten() {
            if *offset == self.number {
                *offset = number;
            }
        }
        self.number = number;
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

    /// The tool as a drawing shows it, from the tip up: cutter, shank, holder, an assumed one where none is
    /// given.
    pub fn outline(&self) -> Vec<OutlinePiece> {
        let segments = self.assembly.segments(self.overhang);
        let above = segments.iter().find(|segment| segment.part == AssemblyPart::Shank);
        let flutes = self.assembly.flutes_end(self.overhang).min(self.overhang);
        let piece = |kind, from, length, radii| OutlinePiece { kind, from, length, radii };
        let upper = self.taper_cone().map_or(self.radius(), |(_, _, radii)| radii[1]);
        let mut outline = vec![piece(OutlineKind::Cutter, 0.0, flutes, [self.radius(), upper])];
        if above.is_none() && flutes < self.overhang {
            outline.push(piece(OutlineKind::Body, flutes, self.overhang - flutes, [upper; 2]));
        }
        for segment in &segments {
            let kind = match segment.part {
                AssemblyPart::Shank => OutlineKind::Shank,
                AssemblyPart::Holder => OutlineKind::Holder,
            };
            outline.push(piece(kind, segment.from, segment.length, segment.radii));
        }
        if self.assembly.holder.is_empty() {
            let radii = [0.5 * self.holder_diameter(); 2];
            outline.push(piece(
                OutlineKind::AssumedHolder,
                self.overhang,
                ASSUMED_HOLDER * self.diameter,
                radii,
            ));
        }
        outline
    }

    /// What is wider than the cutter above it, as cylinders unbounded towards the spindle that contain shank
    /// and holder with `clearances` around them: height above the tip from which on, and radius, each wider
    /// than the one before, mm. The holder that is assumed where none is given has no clearance.
    pub fn assembly_steps(&self, clearances: &ClearanceSetup) -> Vec<(f64, f64)> {
        let mut steps: Vec<(f64, f64)> = Vec::new();
        let mut widest = self.radius();
        let mut add = |from: f64, radius: f64| {
            if radius > widest {
                widest = radius;
                steps.push((from, radius));
            }
        };
        for segment in self.assembly.segments(self.overhang) {
            let clearance = clearances.of_part(segment.part);
            // Cones in slices, each as wide as its wider end.
            let slices = if segment.radii[0] < segment.radii[1] { CONE_SLICES } else { 1 };
            for k in 0..slices {
                let [low, high] = [k, k + 1].map(|k| f64::from(k) / f64::from(slices));
                let at = |share: f64| segment.radii[0] + (segment.radii[1] - segment.radii[0]) * share;
                add(segment.from + low * segment.length - clearance, at(low).max(at(high)) + clearance);
            }
        }
        if self.assembly.holder.is_empty() {
            add(self.overhang, 0.5 * self.holder_diameter());
        }
        steps
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
/// Says which of `tools` have the same length offset, with which a control takes the length of one for that
/// of another; `None` where none do. Offset 0 is none.
pub fn shared_length_offsets(tools: &[&Tool]) -> Option<String> {
    let mut numbers: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for tool in tools {
        numbers.entry(tool.length_offset_number()).or_default().insert(tool.number);
    }
    let shared = numbers.iter().filter(|(offset, tools)| **offset > 0 && tools.len() > 1);
    let words = |(offset, tools): (&u32, &BTreeSet<u32>)| {
        let tools: Vec<String> = tools.iter().map(|number| format!("T{number}")).collect();
        format!("{} have the same length offset, H{offset}", tools.join(" and "))
    };
    let lines: Vec<String> = shared.map(words).collect();
    (!lines.is_empty()).then(|| lines.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_follow_the_number_unless_they_differ_from_it_and_none_is_shared_unsaid() {
        let mut tool = Tool {
            number: 7,
            diameter: 12.0,
            corner_radius: 0.0,
            insert_width: 4.0,
            overhang: 60.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: ToolAssembly::default(),
        };
        (tool.assembly.length_offset, tool.assembly.diameter_offset) = (Some(7), Some(57));
        let other = tool.clone();
        tool.renumber(9);
        assert_eq!((tool.assembly.length_offset, tool.assembly.diameter_offset), (Some(9), Some(57)));
        assert_eq!(shared_length_offsets(&[&tool, &other, &tool]), None);
        tool.assembly.length_offset = Some(7);
        let words = shared_length_offsets(&[&tool, &other, &tool]);
        assert_eq!(words.as_deref(), Some("T7 and T9 have the same length offset, H7"));
        let [a, b] = [tool, other].map(|mut tool| {
            tool.assembly.length_offset = Some(0);
            tool
        });
        assert_eq!(shared_length_offsets(&[&a, &b]), None, "0 cancels the offset");
    }
}
