//! Cutting data by material, and the feed rate of a plunge by its engagement.

use super::{Tool, ToolAssembly};

/// Least and greatest spindle speed that a tool may have, rev/min.
pub const SPINDLE_RANGE: [f64; 2] = [1.0, 1e6];
/// Least and greatest plunge feed, mm/min.
pub const PLUNGE_FEED_RANGE: [f64; 2] = [0.01, 1e5];
/// Feed rate and spindle speed of a tool that says nothing about them, in no known material.
const DEFAULT_FEED: f64 = 300.0;
const DEFAULT_SPINDLE: f64 = 1200.0;
/// Greatest spindle speed that cutting data lead to, rev/min.
pub const MAX_SPINDLE: f64 = 20_000.0;
/// A tool that turns faster than the cutting speed for its material by more than this factor is named.
const MUCH_FASTER: f64 = 2.0;
/// Number of such tools that are named.
const MAX_NAMED: usize = 4;
/// Teeth of a tool that does not say how many it has, where its feed rate comes from cutting data: the fewest
/// that plunge quietly.
pub const ASSUMED_TEETH: u32 = 2;
/// Greatest step along a row, in insert widths, by the largest stick-out in diameters: the whole width up to
/// 4 D, less where a tool is more slender, as its overhang decides on the radial cut (Dormer Pramet 2021,
/// p. 774, which ends at 8 D).
const STEP_OF_INSERTS: [(f64, f64); 4] = [(4.0, 1.0), (8.5, 0.8), (10.0, 0.65), (f64::INFINITY, 0.5)];
/// The same of solid cutters, which are made up to 15 D.
const STEP_OF_SOLID: [(f64, f64); 3] = [(5.0, 1.0), (15.5, 0.8), (f64::INFINITY, 0.5)];
/// Diameter from which on cutters have inserts, mm.
const INSERTS_FROM: f64 = 13.0;
/// Engaged arcs, rad: up to which a cutter cuts beside what is open, and from which on a plunge counts as one
/// into full stock. Between them the feed rate goes down.
const HALF_ARC_RAD: f64 = std::f64::consts::PI;
const FULL_ARC_RAD: f64 = 300.0 * std::f64::consts::PI / 180.0;
/// Engaged arcs between which the feed rate goes down from the greatest to that of the tool, rad.
const SMALL_ARC_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
const USUAL_ARC_RAD: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Share of the feed rate into full stock: half, as makers give for ramps (Kyocera general catalogue 2021,
/// p. M136).
const FULL_SHARE: f64 = 0.5;
/// The same where the cut is interrupted, and where little is engaged (Dormer Pramet 2021, p. 210: 25 % less
/// where a tool vibrates, 25 % more where it is rigid).
const INTERRUPTED_SHARE: f64 = 0.75;
const SMALL_SHARE: f64 = 1.25;

/// A group of materials that are cut alike, by ISO 513.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialGroup {
    /// P: unalloyed and low-alloy steel.
    Steel,
    /// M: stainless steel.
    Stainless,
    /// N: aluminium.
    Aluminium,
    /// S: titanium and its alloys.
    Titanium,
    /// S: nickel alloys.
    Nickel,
}

/// Cutting data of a group, for carbide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuttingData {
    /// The group.
    pub group: MaterialGroup,
    /// Its name in setups, then other names and grades that mean it.
    pub names: &'static [&'static str],
    /// Cutting speed, m/min: the middle of the range that the source gives.
    pub cutting_speed: f64,
    /// Feed per tooth of mills with inserts, mm.
    pub feed_per_tooth: f64,
    /// Feed per tooth below which an edge rubs instead of cutting, and the greatest one, mm.
    pub feed_range: [f64; 2],
    /// Where the figures are from.
    pub source: &'static str,
}

const TUNGALOY: &str = "Tungaloy general catalogue 2020, p. 1084: slotting, ae ≥ 0.4 D; plunging: Kyocera \
                        general catalogue 2021, p. M136, at most 0.1 mm a tooth; floor: Ceratizit \
                        e-catalogue 2026, p. 802";
const TUNGALOY_HARD: &str = "Tungaloy new products, p. 131, shoulder milling; plunging: Kyocera general \
                             catalogue 2021, p. M136, at most 0.1 mm a tooth";

/// All groups.
pub const CUTTING_DATA: [CuttingData; 5] = [
    CuttingData {
        group: MaterialGroup::Steel,
        names: &["steel", "P", "C45", "1.0503", "42CrMo4", "1.7225"],
        cutting_speed: 110.0,
        feed_per_tooth: 0.1,
        feed_range: [0.08, 0.12],
        source: TUNGALOY,
    },
    CuttingData {
        group: MaterialGroup::Stainless,
        names: &[
            "stainless",
            "M",
            "1.4301",
            "1.4313",
            "1.4404",
            "1.4418",
            "1.4542",
            "1.4571",
            "17-4PH",
            "316L",
        ],
        cutting_speed: 80.0,
        feed_per_tooth: 0.09,
        feed_range: [0.06, 0.1],
        source: TUNGALOY,
    },
    CuttingData {
        group: MaterialGroup::Aluminium,
        names: &["aluminium", "aluminum", "N", "6061", "7075", "2618A"],
        cutting_speed: 400.0,
        feed_per_tooth: 0.12,
        feed_range: [0.05, 0.15],
        source: TUNGALOY,
    },
    CuttingData {
        group: MaterialGroup::Titanium,
        names: &["titanium", "Ti6Al4V", "Ti-6Al-4V", "3.7165"],
        cutting_speed: 40.0,
        feed_per_tooth: 0.08,
        feed_range: [0.05, 0.1],
        source: TUNGALOY,
    },
    CuttingData {
        group: MaterialGroup::Nickel,
        names: &["nickel", "S", "Inconel 718", "2.4668", "Inconel 625", "2.4856"],
        cutting_speed: 30.0,
        feed_per_tooth: 0.07,
        feed_range: [0.04, 0.08],
        source: TUNGALOY_HARD,
    },
];

/// Feed per tooth of solid cutters, in diameters (Iscar solid carbide 2022, p. 92: 0.003 to 0.006 D).
const SOLID_FEED_SHARE: f64 = 0.005;
/// Share of the feed range's floor that a solid cutter may go down to: its edges are sharp.
const SOLID_FLOOR_SHARE: f64 = 0.5;

impl CuttingData {
    /// The data for a material as the shop calls it; `None` for one that is not known.
    pub fn of_name(name: &str) -> Option<&'static Self> {
        let is_name = |known: &&str| known.eq_ignore_ascii_case(name.trim());
        CUTTING_DATA.iter().find(|data| data.names.iter().any(&is_name))
    }

    /// First name of every material with data.
    pub fn known_names() -> impl Iterator<Item = &'static str> {
        CUTTING_DATA.iter().map(|data| data.names[0])
    }

    /// Feed per tooth for a cutter of `diameter` mm, mm.
    pub fn feed_per_tooth_for(&self, diameter: f64) -> f64 {
        self.feed_per_tooth.min(SOLID_FEED_SHARE * diameter)
    }

    /// Least and greatest feed per tooth for a cutter of `diameter` mm, mm.
    pub fn feed_range_for(&self, diameter: f64) -> [f64; 2] {
        let [floor, ceiling] = self.feed_range;
        let usual = self.feed_per_tooth_for(diameter);
        if usual < self.feed_per_tooth {
            let share = usual / self.feed_per_tooth;
            let floor_share = if diameter < INSERTS_FROM { SOLID_FLOOR_SHARE } else { 1.0 };
            return [floor_share * floor * share, ceiling * share];
        }
        [floor, ceiling]
    }

    /// Spindle speed for a cutter of `diameter` mm, rev/min.
    pub fn spindle_for(&self, diameter: f64) -> f64 {
        spindle_at(self.cutting_speed, diameter).round().clamp(1.0, MAX_SPINDLE)
    }

    /// Says which of `tools` turn much faster than the cutting speed, and how fast; `None` where none does.
    pub fn too_fast<'t>(&self, tools: impl IntoIterator<Item = &'t Tool>) -> Option<String> {
        let mut fast: Vec<String> = Vec::new();
        for tool in tools {
            let speed = cutting_speed_at(tool.spindle, tool.diameter);
            let text = format!("T{} {speed:.0} m/min", tool.number);
            if speed > MUCH_FASTER * self.cutting_speed && !fast.contains(&text) {
                fast.push(text);
            }
        }
        let named = fast.get(..MAX_NAMED).unwrap_or(&fast);
        let more = match fast.len() - named.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        (!named.is_empty()).then(|| {
            let list = named.join(", ");
            format!("much faster than the {} m/min for {}: {list}{more}", self.cutting_speed, self.names[0])
        })
    }

    /// `tool`, whose spindle speed and feed rate are for steel, with those for this material: they count as
    /// given.
    pub fn scaled_from_steel(&self, tool: &Tool) -> Tool {
        let [steel, ..] = &CUTTING_DATA;
        let spindle =
            (tool.spindle * self.cutting_speed / steel.cutting_speed).min(MAX_SPINDLE.max(tool.spindle));
        let faster = spindle / tool.spindle * self.feed_per_tooth / steel.feed_per_tooth;
        Tool {
            spindle: spindle.round(),
            plunge_feed: (tool.plunge_feed * faster).round().max(1.0),
            ..tool.with_given_rates()
        }
    }
}

/// Gives `tool` the rates that it lacks, as they are in a setup of this material. One that would be out of
/// its range is given from then on, at the end of the range: a setup without it would be refused.
pub fn fill_rates(tool: &mut Tool, material: Option<&CuttingData>) {
    let within = |rate: f64, [least, most]: [f64; 2], is_missing: &mut bool| {
        let possible = rate.clamp(least, most);
        *is_missing = possible == rate;
        possible
    };
    let mut missing = tool.assembly.missing_rates;
    if missing.spindle {
        let spindle = usual_spindle(tool.diameter, &tool.assembly, material);
        tool.spindle = within(spindle, SPINDLE_RANGE, &mut missing.spindle);
    }
    if missing.plunge_feed {
        let feed = usual_feed(tool.diameter, &tool.assembly, tool.spindle, material);
        tool.plunge_feed = within(feed, PLUNGE_FEED_RANGE, &mut missing.plunge_feed);
    }
    tool.assembly.missing_rates = missing;
}

/// Spindle speed at which a cutter of `diameter` mm cuts at `speed` m/min, rev/min.
fn spindle_at(speed: f64, diameter: f64) -> f64 {
    speed * 1e3 / (std::f64::consts::PI * diameter)
}

/// Cutting speed of a cutter of `diameter` mm at a `spindle` speed in rev/min, m/min.
pub fn cutting_speed_at(spindle: f64, diameter: f64) -> f64 {
    std::f64::consts::PI * diameter * spindle / 1e3
}

/// Spindle speed of a tool that does not say it, rev/min: by its cutting speed, else by the material, else
/// the default.
pub fn usual_spindle(diameter: f64, assembly: &ToolAssembly, material: Option<&CuttingData>) -> f64 {
    match assembly.cutting_speed {
        Some(speed) => spindle_at(speed, diameter),
        None => material.map_or(DEFAULT_SPINDLE, |data| data.spindle_for(diameter)),
    }
}

/// Plunge feed of a tool that does not say it, mm/min: by feed per tooth and teeth at its `spindle` speed, of
/// the material where the tool has none, else the default.
pub fn usual_feed(
    diameter: f64,
    assembly: &ToolAssembly,
    spindle: f64,
    material: Option<&CuttingData>,
) -> f64 {
    let by_material = |data: &CuttingData| data.feed_per_tooth_for(diameter);
    let teeth = assembly.teeth.or(material.map(|_| ASSUMED_TEETH));
    match (assembly.feed_per_tooth.or(material.map(by_material)), teeth) {
        (Some(feed), Some(teeth)) => feed * f64::from(teeth) * spindle,
        _ => DEFAULT_FEED,
    }
}

/// Share of the insert width that a step along a row may be at most, by the stick-out of `tool`.
pub fn step_share_by_stick_out(tool: &Tool) -> f64 {
    let table: &[(f64, f64)] = if tool.diameter < INSERTS_FROM { &STEP_OF_SOLID } else { &STEP_OF_INSERTS };
    let slender = tool.overhang / tool.diameter;
    table.iter().find(|(most, _)| slender <= *most).map_or(0.5, |(_, share)| *share)
}

/// Greatest step along a row that insert width and stick-out of `tool` permit, mm.
pub fn step_by_stick_out(tool: &Tool) -> f64 {
    step_share_by_stick_out(tool) * tool.insert_width
}

/// Feed rate of a plunge of `tool`, mm/min, with an engaged arc of at most `arc_rad`: `None` where the tool
/// does not say how many teeth it has, so that the feed per tooth is unknown. `range`: least and greatest
/// feed per tooth, mm, of the material where that is known.
pub fn feed_by_engagement(
    tool: &Tool,
    arc_rad: f64,
    is_interrupted: bool,
    range: Option<[f64; 2]>,
) -> Option<f64> {
    let per_mm = f64::from(tool.assembly.teeth?) * tool.spindle;
    let between = |from: f64, to: f64| ((arc_rad - from) / (to - from)).clamp(0.0, 1.0);
    let share = 1.0 + (SMALL_SHARE - 1.0) * between(USUAL_ARC_RAD, SMALL_ARC_RAD)
        - (1.0 - FULL_SHARE) * between(HALF_ARC_RAD, FULL_ARC_RAD);
    let share = if is_interrupted { share.min(INTERRUPTED_SHARE) } else { share };
    let usual = tool.plunge_feed / per_mm;
    let wanted = share * usual;
    // A feed per tooth that the user gave outside of the range stays the limit on its side.
    let limited = range.map_or(wanted, |[floor, ceiling]| wanted.clamp(floor.min(usual), ceiling.max(usual)));
    Some(limited * per_mm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::MissingRates;

    fn tool(teeth: Option<u32>) -> Tool {
        let mut tool = Tool {
            number: 1,
            diameter: 25.0,
            corner_radius: 0.8,
            insert_width: 8.0,
            overhang: 100.0,
            plunge_feed: 420.0,
            spindle: 1400.0,
            assembly: Default::default(),
        };
        tool.assembly.teeth = teeth;
        tool
    }

    #[test]
    fn a_rate_beyond_its_range_is_given_at_the_end_of_the_range() {
        let mut filled = tool(Some(6));
        filled.assembly.cutting_speed = Some(400.0);
        filled.assembly.missing_rates = MissingRates { plunge_feed: true, spindle: true };
        filled.assembly.feed_per_tooth = Some(0.1);
        fill_rates(&mut filled, None);
        let both_missing = MissingRates { plunge_feed: true, spindle: true };
        assert_eq!(filled.assembly.missing_rates, both_missing, "they follow from others");
        filled.assembly.feed_per_tooth = Some(5.0);
        fill_rates(&mut filled, None);
        assert_eq!(filled.plunge_feed, PLUNGE_FEED_RANGE[1]);
        assert_eq!(filled.assembly.missing_rates, MissingRates { plunge_feed: false, spindle: true });
    }

    #[test]
    fn the_feed_follows_the_engaged_arc_within_floor_and_ceiling() {
        let feed = |arc: f64, interrupted: bool, range| {
            feed_by_engagement(&tool(Some(3)), arc.to_radians(), interrupted, range).expect("teeth are known")
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a}, not {b}");
        near(feed(360.0, false, None), 210.0);
        near(feed(170.0, false, None), 420.0);
        near(feed(240.0, false, None), 315.0);
        near(feed(170.0, true, None), 315.0);
        near(feed(30.0, false, None), 525.0);
        assert!(feed(100.0, false, None) > 420.0 && feed(100.0, false, None) < 525.0);
        // 0.1 mm a tooth: the floor and the ceiling of steel.
        near(feed(360.0, false, Some([0.08, 0.12])), 0.08 * 3.0 * 1400.0);
        near(feed(30.0, false, Some([0.08, 0.12])), 0.12 * 3.0 * 1400.0);
        assert_eq!(feed_by_engagement(&tool(None), 1.0, false, None), None, "no teeth, no feed per tooth");
    }

    #[test]
    fn every_material_is_known_by_its_names_and_its_data_are_in_order() {
        for data in &CUTTING_DATA {
            for name in data.names {
                assert_eq!(CuttingData::of_name(name).map(|found| found.group), Some(data.group), "{name}");
            }
            let [floor, ceiling] = data.feed_range;
            assert!(floor < data.feed_per_tooth && data.feed_per_tooth <= ceiling, "{:?}", data.group);
            for diameter in [0.5, 6.0, 25.0, 63.0] {
                let usual = data.feed_per_tooth_for(diameter);
                let [floor, ceiling] = data.feed_range_for(diameter);
                assert!(floor < usual && usual <= ceiling, "{:?}, D {diameter}", data.group);
            }
            assert!(!data.source.is_empty());
        }
        assert!(CuttingData::of_name("cheese").is_none());
    }

    #[test]
    fn a_slender_tool_takes_smaller_steps() {
        let step = |overhang: f64| step_by_stick_out(&Tool { overhang, ..tool(None) });
        assert_eq!(step(100.0), 8.0, "the insert width up to 4 D");
        assert!(step(200.0) < step(100.0) && step(230.0) < step(200.0) && step(300.0) < step(230.0));
    }
}
