//! The setup file: TOML; lengths in mm, angles in degrees, feed rates in mm/min, spindle speeds in rev/min.
//!
//! Every key is optional; absent keys keep the values of the default setup,
//! [`crate::setup::Setup::for_part`]. An unknown key is an error that names a near known key.
//!
//! ```toml
//! version = 2                # of the file format; absent: that of the program
//! part = "impeller"          # the only part this setup applies to
//! [stock]                    # hub_allowance, blade_allowance, safety_distance, inlet_extension, blank,
//!                            # material
//! hub_allowance = 0.5
//! [clearance]                # shank, holder
//! holder = 1.0
//! [[tool]]                   # see `tool_file`
//! diameter = 30.0            # the only required key of a tool
//! [plunge]                   # axis, step, stepover, wall_scallop, max_axis_change, max_tilt, rest,
//!                            # goal, max_stock, max_time, finish_rate, finish_depth, finish_pass_time,
//!                            # lift, peck, adapt_feed, rapid_approach;
//!                            # edits of single plunges: [[plunge.edit]]
//! axis = "monotone"
//! [[plunge.section]]         # tool, from, to, cutting_direction, rest
//! tool = 1
//! from = 1.0
//! to = 0.6
//! [flank]                    # tool, layer_depth, scallop_height
//! layer_depth = 3.0
//! [channels]                 # order, sequence
//! order = "channel_by_channel"
//! [machine]                  # file, max_axis_tilt
//! max_axis_tilt = 95.0
//! ```

mod edits;
mod goal;
mod keys;
mod plunge;
mod read;
mod tolerant;
mod write;

pub use keys::unit_of_key;
pub use plunge::parse_axis_policy;
pub(crate) use read::setup_of_table;
pub use read::{
    line_of_place, parse_channel_order, parse_channel_sequence, parse_flank_strategy, read_setup,
    read_setup_bytes, read_setup_with_defaults,
};
pub use tolerant::{SetupEntry, SetupEntryFault, TolerantSetup, read_setup_tolerantly};
pub(super) use write::{beside, relative};
pub use write::{locate_machine, write_full_setup, write_setup, write_setup_beside};

/// Whether TOML is a setup rather than a part or a machine, by its tables. A tool library looks like one,
/// too.
pub fn looks_like_setup(bytes: &[u8]) -> bool {
    const TABLES: [&str; 9] = [
        "[stock]",
        "[clearance]",
        "[[tool]]",
        "[plunge]",
        "[[plunge.section]]",
        "[[plunge.edit]]",
        "[flank]",
        "[channels]",
        "[machine]",
    ];
    let is_of_setup = |line: &str| TABLES.iter().any(|table| line.starts_with(table));
    String::from_utf8_lossy(bytes).lines().map(str::trim).any(is_of_setup)
}

/// Version of the file format, key `version`: 2 since keys were renamed. Newer files are rejected.
const VERSION: u32 = 2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::InputError;
    use crate::setup::{
        AxisPolicy, ChannelOrder, ChannelSequence, ChannelSetup, CutDirection, MissingRates, SectionKind,
        Setup, Tool, ToolAssembly,
    };

    const SAMPLE: &str = r#"part = "D 532"
[stock]
hub_allowance = 0.25
[[tool]]
number = 7
diameter = 30.0
insert_width = 10.0
overhang = 120
[[tool]]
diameter = 16
corner_radius = 0.8
[plunge]
axis = "conventional"
step = 8.0
max_axis_change = 4.3
max_tilt = 30
wall_scallop = 0.4
rest = false
[[plunge.section]]
tool = 7
from = 1.0
to = 0.6
feed = "outward"
[[plunge.section]]
tool = 2
from = 0.6
to = 0.0
rest = true
[flank]
tool = 4
[channels]
order = "channel_by_channel"
sequence = "opposite"
"#;

    fn read(text: &str) -> Result<Setup, InputError> {
        read_setup_bytes("s.toml", text.as_bytes())
    }

    #[test]
    fn an_empty_file_is_the_default() {
        assert_eq!(read(" \n").unwrap(), Setup::default());
        assert_eq!(read("# nothing\n").unwrap(), Setup::default());
        assert_eq!(read(&write_setup(&Setup::default())).unwrap(), Setup::default());
    }

    #[test]
    fn reads_every_key_and_fills_in_the_rest() {
        let setup = read(SAMPLE).unwrap();
        assert_eq!(setup.part.as_deref(), Some("D 532"));
        assert_eq!((setup.allowances.hub_allowance, setup.allowances.blade_allowance), (0.25, 0.5));
        assert_eq!((setup.tools[0].number, setup.tools[0].core_radius()), (7, 5.0));
        let second = Tool {
            number: 2,
            diameter: 16.0,
            corner_radius: 0.8,
            insert_width: 7.2,
            overhang: 64.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: ToolAssembly { missing_rates: MissingRates::ALL, ..ToolAssembly::default() },
        };
        assert_eq!(setup.tools[1], second);
        assert_eq!(setup.plunge.axis, AxisPolicy::Conventional);
        assert_eq!((setup.plunge.step, setup.plunge.stepover), (Some(8.0), None));
        assert_eq!(setup.plunge.max_tilt_rad, 30f64.to_radians());
        assert_eq!(setup.plunge.sections[0].cut_direction, Some(CutDirection::InletToOutlet));
        assert_eq!((setup.plunge.rest, setup.plunge.sections[0].kind), (false, SectionKind::Rows));
        assert_eq!(setup.plunge.sections[1].kind, SectionKind::Rest);
        assert_eq!((setup.flank.tool, setup.flank.layer_depth), (Some(4), 3.0));
        let (order, sequence) = (ChannelOrder::ChannelByChannel, ChannelSequence::Opposite);
        assert_eq!(setup.channels, ChannelSetup { order, sequence });
    }

    #[test]
    fn a_written_setup_reads_back_equal() {
        let setup = read(SAMPLE).unwrap();
        assert_eq!(read(&write_setup(&setup)).unwrap(), setup);
    }

    #[test]
    fn rates_that_are_not_given_stay_so() {
        let given = SAMPLE.replace("overhang = 120", "overhang = 120\nspindle = 900");
        let setup = read(&given).unwrap();
        let text = write_setup(&setup);
        assert_eq!(
            (text.matches("spindle =").count(), text.matches("plunge_feed =").count()),
            (1, 0),
            "{text}"
        );
        let full = write_full_setup(&setup);
        let kept = read(&full).unwrap().tools;
        assert_eq!(kept, setup.tools.iter().map(Tool::with_given_rates).collect::<Vec<_>>());
        // Of a material they are those that a tool without rates gets.
        let text = text.replace("[stock]", "[stock]\nmaterial = \"titanium\"");
        let data = crate::setup::cutting_data::CuttingData::of_name("titanium").unwrap();
        let tools = read(&text).unwrap().tools;
        let [first, second] = &tools[..] else { panic!("two tools") };
        assert_eq!((first.spindle, second.spindle), (900.0, data.spindle_for(16.0)));
    }

    #[test]
    fn faults_name_their_line() {
        for (from, to, line, words) in [
            ("hub_allowance = 0.25", "hub_allowance = -0.1", 3, "0 to"),
            ("hub_allowance = 0.25", "hub_allowance = nan", 3, "not a finite number"),
            ("hub_allowance = 0.25", "hub_allowance = \"x\"", 3, "not a number"),
            ("hub_allowance", "hub_alowance", 3, "`hub_allowance`"),
            ("[stock]", "[stok]", 2, "`stock`"),
            ("number = 7", "number = 0", 5, "whole number"),
            ("number = 7", "number = 2", 9, "two tools have the number 2"),
            ("diameter = 30.0", "diameter = 0", 6, "greater than 0"),
            ("diameter = 30.0", "diameter = -30", 6, "greater than 0"),
            ("diameter = 30.0", "", 4, "no `diameter`"),
            ("insert_width = 10.0", "insert_width = 15.1", 7, "at most 15"),
            ("corner_radius = 0.8", "corner_radius = 8.5", 11, "at most 8"),
            ("overhang = 120", "overhang = 1e300", 8, "too large"),
            ("\"conventional\"", "\"monotnoe\"", 13, "`monotone`"),
            ("step = 8.0", "step = 0", 14, "greater than 0"),
            ("max_axis_change = 4.3", "max_axis_change = 91", 15, "at most 90"),
            ("max_tilt = 30", "max_tilt = -1", 16, "greater than 0"),
            ("tool = 7", "tool = 3", 20, "there is no tool 3; use one of the tools 7, 2"),
            ("to = 0.6", "to = 1.0", 22, "outlet end"),
            ("from = 1.0", "from = 1.5", 21, "from 0 to 1"),
            ("\"outward\"", "\"across\"", 23, "outlet_to_inlet"),
            (
                "feed = \"outward\"",
                "cutting_direction = \"inlet_to_outlet\"\nfeed = \"outward\"",
                24,
                "former name",
            ),
            (
                "\"channel_by_channel\"",
                "\"channelwise\"",
                32,
                "use \"tool_by_tool\" or \"channel_by_channel\"",
            ),
            ("\"opposite\"", "\"across\"", 33, "use \"adjacent\" or \"opposite\""),
            ("sequence = ", "sequenc = ", 33, "`sequence`"),
            ("sequence = \"opposite\"", "sequence = 2", 33, "not a text"),
            ("rest = false", "rest = 0", 18, "true or false"),
            ("outward\"", "outward\"\nrest = true", 19, "no section comes before it"),
            ("[[plunge.section]]", "[plunge.section]", 19, "TOML"),
        ] {
            assert!(SAMPLE.contains(from), "{from} must be in the sample");
            let error = read(&SAMPLE.replacen(from, to, 1)).expect_err(to);
            let shown = error.to_string();
            assert!(shown.contains(words), "{from} → {to}: {shown}");
            assert!(error.line.abs_diff(line) <= usize::from(words == "TOML") * 5, "{to}: {shown}");
        }
    }
}
