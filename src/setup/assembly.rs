//! Shank and holder of a tool, and what a shop's library says about it beyond the cutter.

use crate::geometry::{Frustum, Point, Vector};

/// What a tool has beyond cutter and overhang; everything may be absent. Lengths mm.
///
/// Segments run from the cutter towards the spindle.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct ToolAssembly {
    /// Name in the shop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What else is known of it in words: maker, order number, use.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Material of its edges, such as carbide.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Length of the cutting edges from the tip; the shank begins there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flute_length: Option<f64>,
    /// Number of teeth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub teeth: Option<u32>,
    /// Half angle of a tapered cutter, rad (degrees in files).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub taper_rad: Option<f64>,
    /// Neck and shank as `[diameter, length]`; the last one runs on to the holder.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shank: Vec<[f64; 2]>,
    /// Holder as `[lower diameter, upper diameter, length]`, from the end of the overhang.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub holder: Vec<[f64; 3]>,
    /// Number of the length offset in the control.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_offset: Option<u32>,
    /// Number of the diameter offset in the control.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_offset: Option<u32>,
    /// Feed per tooth, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feed_per_tooth: Option<f64>,
    /// Cutting speed, m/min.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutting_speed: Option<f64>,
    /// The rates of the tool that are not given, but follow from others.
    #[serde(skip)]
    pub missing_rates: MissingRates,
}

/// Rates that a tool, or the library it is from, does not say: they follow from its cutting speed and feed
/// per tooth, else from the material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissingRates {
    /// Its plunge feed is not given.
    pub plunge_feed: bool,
    /// Its spindle speed is not given.
    pub spindle: bool,
}

impl MissingRates {
    /// Neither rate is given.
    pub const ALL: Self = Self { plunge_feed: true, spindle: true };

    /// Whether all that is missing here is missing in `other`, too.
    pub fn is_within(self, other: Self) -> bool {
        (other.plunge_feed || !self.plunge_feed) && (other.spindle || !self.spindle)
    }
}

/// Part of a tool above its cutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AssemblyPart {
    /// Neck and shank.
    Shank,
    /// Holder.
    Holder,
}

impl AssemblyPart {
    /// Both, in the order of their numbers.
    pub const ALL: [Self; 2] = [Self::Shank, Self::Holder];

    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shank => "shank",
            Self::Holder => "holder",
        }
    }
}

/// A cylinder or cone of a tool, relative to its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssemblySegment {
    /// Shank or holder.
    pub part: AssemblyPart,
    /// Height of its lower end above the tip, mm.
    pub from: f64,
    /// Its length, mm.
    pub length: f64,
    /// Radius at its lower and at its upper end, mm.
    pub radii: [f64; 2],
}

impl AssemblySegment {
    /// The segment of a tool with its tip at `tip` and its unit `axis`.
    pub fn placed(&self, tip: &Point, axis: &Vector) -> Frustum {
        Frustum { base: tip + axis * self.from, axis: *axis, length: self.length, radii: self.radii }
    }
}

impl ToolAssembly {
    /// Whether neither shank nor holder is given.
    pub fn is_empty(&self) -> bool {
        self.shank.is_empty() && self.holder.is_empty()
    }

    /// Height above the tip at which the edges end and the shank begins, with the holder `overhang` mm above
    /// the tip, mm: the given length, else what the shank leaves of the overhang.
    pub fn flutes_end(&self, overhang: f64) -> f64 {
        let shank = || self.shank.iter().map(|[_, length]| length).sum::<f64>();
        self.flute_length.unwrap_or_else(|| overhang - shank()).max(0.0)
    }

    /// Segments of shank and holder with the holder beginning `overhang` mm above the tip.
    pub fn segments(&self, overhang: f64) -> Vec<AssemblySegment> {
        let mut from = self.flutes_end(overhang);
        let mut segments = Vec::with_capacity(self.shank.len() + self.holder.len());
        for (index, &[diameter, length]) in self.shank.iter().enumerate() {
            let end = if index + 1 == self.shank.len() { overhang } else { (from + length).min(overhang) };
            if end > from {
                let radii = [0.5 * diameter; 2];
                let part = AssemblyPart::Shank;
                segments.push(AssemblySegment { part, from, length: end - from, radii });
                from = end;
            }
        }
        from = overhang;
        for &[lower, upper, length] in &self.holder {
            let radii = [0.5 * lower, 0.5 * upper];
            segments.push(AssemblySegment { part: AssemblyPart::Holder, from, length, radii });
            from += length;
        }
        segments
    }
}

/// `[clearance]`: distances that shank and holder keep from the finished part with its allowances, and from
/// the blank, mm. Only tools with a given shank or holder are held to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearanceSetup {
    /// Distance of the shank.
    pub shank: f64,
    /// Distance of the holder.
    pub holder: f64,
}

impl ClearanceSetup {
    /// The clearance of a part of the tool, mm.
    pub fn of_part(&self, part: AssemblyPart) -> f64 {
        match part {
            AssemblyPart::Shank => self.shank,
            AssemblyPart::Holder => self.holder,
        }
    }
}

impl Default for ClearanceSetup {
    fn default() -> Self {
        Self { shank: 1.0, holder: 1.0 }
    }
}
