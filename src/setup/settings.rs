//! The setup: allowances, clearances, tools and planner parameters. Keys as in the TOML file.

use std::borrow::Cow;
use std::sync::Arc;

use super::channel_settings::ChannelSetup;
use super::cutting_data::CuttingData;
use super::fault::{SetupFault, SetupPlace};
use super::flank_settings::{FlankSetup, FlankStrategy};
use super::plunge_settings::{AxisPolicy, Goal, PlungeSetup};
use super::tool::shared_length_offsets;
use super::{ClearanceSetup, Tool};
use crate::error::ErrorCode;
use crate::geometry::Vector;
use crate::part::{Blank, BlankShape, Channel, Impeller, PassageWidth, Workpiece};

/// Tilt beyond the machine's limit that is tolerated as rounding, rad.
pub const TILT_TOLERANCE: f64 = 1e-6;
/// Ratio of the outlet diameter to the default allowances on a small wheel.
const ALLOWANCES_PER_DIAMETER: f64 = 200.0;
/// Default allowances on wheels of usual size, mm, and the diameter above which they grow again, mm.
const USUAL_ALLOWANCE: f64 = 0.5;
const LARGE_DIAMETER: f64 = 500.0;
/// Largest default allowance, as shares of the narrowest passage and of the least height of the channel.
const NARROWEST_SHARE: f64 = 0.1;
const HEIGHT_SHARE: f64 = 0.1;
/// Stations along the channel at which its width and height are sampled.
const STATIONS: u32 = 40;
/// Smallest default allowance, mm.
const MIN_ALLOWANCE: f64 = 0.02;

/// `[stock]`: allowances and clearances, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct AllowanceSetup {
    /// Stock that must stay on the hub.
    pub hub_allowance: f64,
    /// Stock that must stay on the blades.
    pub blade_allowance: f64,
    /// Clearance between the cutter and the blank in a rapid.
    pub safety_distance: f64,
    /// Length of blank upstream of the leading edge, along hub and shroud.
    pub inlet_extension: f64,
    /// Shape of the blank: everything that holds a tool against stock uses it.
    pub blank: BlankShape,
    /// Material of the blank, as the shop calls it. Where it is one of [`CUTTING_DATA`], tools that do not
    /// say how fast they are get their speeds and feeds from there.
    ///
    /// [`CUTTING_DATA`]: super::cutting_data::CUTTING_DATA
    pub material: Option<String>,
}

/// Clearance below the wanted one that is tolerated as rounding, mm.
const CLEARANCE_ROUNDING: f64 = 1e-3;

/// Whether a clearance misses the wanted one by more than rounding, both mm.
pub fn falls_short(clearance: f64, wanted: f64) -> bool {
    clearance < wanted - CLEARANCE_ROUNDING
}

impl AllowanceSetup {
    /// Cutting data of the material; `None` where it is not named, or not known.
    pub fn cutting_data(&self) -> Option<&'static CuttingData> {
        self.material.as_deref().and_then(CuttingData::of_name)
    }

    /// Says which of `tools` turn much faster than the cutting data for the material give, and how fast.
    pub fn too_fast<'t>(&self, tools: impl IntoIterator<Item = &'t Tool>) -> Option<String> {
        self.cutting_data()?.too_fast(tools)
    }

    /// What must be known of `tools` before they cut: which turn too fast for the material, and which share a
    /// length offset.
    pub fn tool_remarks<'t>(&self, tools: impl IntoIterator<Item = &'t Tool>) -> Vec<String> {
        let tools: Vec<&Tool> = tools.into_iter().collect();
        let too_fast = self.too_fast(tools.iter().copied());
        too_fast.into_iter().chain(shared_length_offsets(&tools)).collect()
    }

    /// The tools of a `library`, whose rates are for steel, with those for the material; as they are where it
    /// has no data.
    pub fn tools_for_material<'t>(&self, library: &'t [Tool]) -> Cow<'t, [Tool]> {
        match self.cutting_data() {
            Some(data) => library.iter().map(|tool| data.scaled_from_steel(tool)).collect(),
            None => library.into(),
        }
    }

    /// The blank of `part`.
    pub fn blank_of(&self, part: &Impeller) -> Blank {
        Blank::shaped(part, self.inlet_extension, &self.blank)
    }

    /// `part` with its blank, prepared for planners and checks.
    ///
    /// ```
    /// # let part = vanecut::io::part_file::read_part("assets/parts/impeller532.toml".as_ref())?;
    /// # let part = vanecut::part::Impeller::build(&part)?;
    /// let setup = vanecut::setup::Setup::for_part(&part);
    /// let workpiece = setup.allowances.workpiece_of(part);
    /// assert_eq!(workpiece.channel.passages.len(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn workpiece_of(&self, part: impl Into<Arc<Impeller>>) -> Workpiece {
        let part = part.into();
        let blank = self.blank_of(&part);
        Workpiece::new(part, blank)
    }

    /// Checks that the blank encloses `part`.
    ///
    /// # Errors
    /// When hub or blades stick out of it: by how much and where.
    pub fn check_blank(&self, part: &Impeller) -> Result<(), SetupFault> {
        let Some(outside) = self.blank.outside(part) else { return Ok(()) };
        let (p, distance) = (outside.point, outside.distance);
        let message = format!(
            "the blank does not enclose the part: the {} is {distance:.2} mm outside of it at r {:.2}, \
             z {:.2}",
            outside.what, p.r, p.z
        );
        Err(SetupFault::new(
            ErrorCode::BlankFile,
            message,
            "give a larger blank, or check its units and where its zero is",
        )
        .at(SetupPlace::Stock("blank")))
    }
}

/// `[machine]`: the machine and its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Name of a machine that comes with the program, or the path of a machine file, as the setup gives it.
    pub file: Option<String>,
    /// Largest angle between a tool axis and the part's axis of rotation, in the direction out of the inlet,
    /// rad (degrees in the file). π: no limit.
    pub max_axis_tilt_rad: f64,
}

impl Machine {
    /// Angle by which `axis` (unit, tip → holder) on `part` exceeds the machine's limit, rad; 0 or less
    /// within it.
    pub fn excess_tilt_rad(&self, part: &Impeller, axis: &Vector) -> f64 {
        axis.angle(&part.out_of_inlet()) - self.max_axis_tilt_rad
    }
}

/// A complete setup. [`Setup::for_part`] gives that of an empty file.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Name of the part the setup is meant for, if it says so (`part = "…"`).
    pub part: Option<String>,
    /// `[stock]`.
    pub allowances: AllowanceSetup,
    /// `[clearance]`.
    pub clearances: ClearanceSetup,
    /// `[[tool]]`, in file order; empty: chosen for the part from the tool library.
    pub tools: Vec<Tool>,
    /// `[plunge]`.
    pub plunge: PlungeSetup,
    /// `[flank]`.
    pub flank: FlankSetup,
    /// `[channels]`.
    pub channels: ChannelSetup,
    /// `[machine]`.
    pub machine: Machine,
}

impl Setup {
    /// Whether the other setup leads to the same plunge plan of one channel: both differ at most in `[flank]`
    /// and in the order of channels.
    pub fn plans_equal_channel(&self, other: &Self) -> bool {
        Self { channels: other.channels, ..self.clone() }.equals_except_flank(other)
    }

    /// Whether the other setup leads to the same plunge programs: both differ at most in `[flank]`, and in
    /// which rates of their tools are given and which of the same amount follow from others.
    pub fn equals_except_flank(&self, other: &Self) -> bool {
        Tool::cut_alike(&self.tools, &other.tools)
            && Self { flank: other.flank.clone(), tools: other.tools.clone(), ..self.clone() } == *other
    }
}

impl Setup {
    /// The setup of an empty file for `part`: [`Setup::default`], which suits wheels of 100 to 500 mm, scaled
    /// to the size of the wheel, with allowances that are small relative to its narrowest passage and its
    /// least height.
    ///
    /// ```
    /// # let part = vanecut::io::part_file::read_part("assets/parts/impeller532.toml".as_ref())?;
    /// # let part = vanecut::part::Impeller::build(&part)?;
    /// let setup = vanecut::setup::Setup::for_part(&part);
    /// assert!(setup.allowances.hub_allowance > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn for_part(part: &Impeller) -> Self {
        let diameter = 2.0 * part.rim_radius();
        let usual = (diameter / ALLOWANCES_PER_DIAMETER).min(USUAL_ALLOWANCE);
        let unit = round_down(usual.max(USUAL_ALLOWANCE * diameter / LARGE_DIAMETER));
        let channel = Channel::from_part(part);
        // Beside one splitter these are the same.
        let at_outlet = if channel.splitters.len() > 1 { channel.passages_at_outlet() } else { Vec::new() };
        let passages = [&channel.full].into_iter().chain(&channel.beside_splitter).chain(&at_outlet);
        let widths: Vec<PassageWidth> = passages.map(|passage| PassageWidth::new(part, passage)).collect();
        let (mut width, mut height) = (f64::INFINITY, f64::INFINITY);
        for i in 0..=STATIONS {
            let s = f64::from(i) / f64::from(STATIONS);
            width = widths.iter().map(|passage| passage.least(s)).fold(width, f64::min);
            // Near the leading edge, where hub and shroud may meet, there is nothing to cut.
            if (0.1..=1.0).contains(&s) {
                height = height.min(part.hub.point(s).distance(part.shroud.point(s)));
            }
        }
        let blade_allowance = unit.min(round_down(NARROWEST_SHARE * width));
        let hub_allowance = unit.min(round_down(HEIGHT_SHARE * height)).max(MIN_ALLOWANCE);
        let mut setup = Self::default();
        for value in setup.scaled_values() {
            *value = round_down(*value * unit / USUAL_ALLOWANCE * (1.0 + 1e-9));
        }
        setup.allowances.hub_allowance = hub_allowance;
        setup.allowances.blade_allowance = blade_allowance.max(MIN_ALLOWANCE);
        setup
    }

    /// Replaces what still equals the defaults `old` by `new`: the defaults of another wheel, or of the same
    /// one in another unit. What was edited stays.
    pub fn follow_defaults(&mut self, old: &Self, new: &Self) {
        let (mut old, mut new) = (old.clone(), new.clone());
        let values = self.scaled_values().into_iter().zip(old.scaled_values()).zip(new.scaled_values());
        for ((value, old), new) in values {
            if value == old {
                *value = *new;
            }
        }
    }

    /// The values whose defaults scale with the wheel.
    fn scaled_values(&mut self) -> [&mut f64; 8] {
        [
            &mut self.allowances.hub_allowance,
            &mut self.allowances.blade_allowance,
            &mut self.allowances.safety_distance,
            &mut self.clearances.shank,
            &mut self.clearances.holder,
            &mut self.plunge.wall_scallop,
            &mut self.flank.layer_depth,
            &mut self.flank.scallop_height,
        ]
    }
}

/// Rounds down to a preferred number: 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 times a power of ten. Infinite
/// values are returned as they are.
fn round_down(value: f64) -> f64 {
    const DIGITS: [f64; 10] = [80.0, 60.0, 50.0, 40.0, 30.0, 25.0, 20.0, 15.0, 12.0, 10.0];
    if !value.is_finite() || value <= 0.0 {
        return value;
    }
    let exponent = value.log10().floor() as i32 - 1;
    // Dividing by a power of ten gives the number nearest to the decimal one; multiplying by 0.1 would not.
    let scaled = |digits: f64| match exponent {
        0.. => digits * 10f64.powi(exponent),
        _ => digits / 10f64.powi(-exponent),
    };
    let digits = value / scaled(1.0) * (1.0 + 1e-12);
    scaled(DIGITS.into_iter().find(|plain| *plain <= digits).unwrap_or(10.0))
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            part: None,
            allowances: AllowanceSetup {
                hub_allowance: 0.5,
                blade_allowance: 0.5,
                safety_distance: 2.0,
                inlet_extension: 0.0,
                blank: BlankShape::Edges,
                material: None,
            },
            clearances: ClearanceSetup::default(),
            tools: Vec::new(),
            plunge: PlungeSetup {
                axis: AxisPolicy::Minimal,
                step: None,
                stepover: None,
                wall_scallop: 0.6,
                max_axis_change_rad: 5f64.to_radians(),
                max_tilt_rad: 45f64.to_radians(),
                lead_out: None,
                peck: None,
                adapt_feed: true,
                rapid_approach: false,
                goal: Goal::default(),
                rest: true,
                sections: Vec::new(),
                edits: Vec::new(),
            },
            flank: FlankSetup {
                tool: None,
                strategy: FlankStrategy::Balanced,
                layer_depth: 3.0,
                scallop_height: 0.25,
                lead_in_out: None,
                feed_mm_per_min: None,
                slot_feed_mm_per_min: None,
                wall_feed_mm_per_min: None,
                ramp_feed_mm_per_min: None,
                approach_feed_mm_per_min: None,
            },
            channels: ChannelSetup::default(),
            machine: Machine { file: None, max_axis_tilt_rad: std::f64::consts::PI },
        }
    }
}

/// Tool number `number` of the setup.
///
/// # Errors
/// When the setup has no tool of that number.
pub fn tool_of(setup: &Setup, number: u32) -> Result<&Tool, SetupFault> {
    setup.tools.iter().find(|t| t.number == number).ok_or_else(|| {
        SetupFault::new(
            ErrorCode::UndefinedTool,
            format!("a section uses tool {number}, which the setup does not define"),
            "add the tool or name another",
        )
        .at(SetupPlace::Tool(number))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_numbers_one_would_write() {
        for (value, written) in [
            (0.5, 0.5),
            (0.532, 0.5),
            (0.114, 0.1),
            (0.0972, 0.08),
            (0.077, 0.06),
            (3.0, 3.0),
            (2.13, 2.0),
            (17.0, 15.0),
            (900.0, 800.0),
        ] {
            assert_eq!(round_down(value), written, "{value}");
        }
        assert_eq!(round_down(f64::INFINITY), f64::INFINITY);
    }
}
