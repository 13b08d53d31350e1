//! The built-in tool libraries, from which tools are chosen when a setup lists none: `assets/tools/*.toml`,
//! in the format of the `[[tool]]` tables of a setup.

use std::sync::LazyLock;

use super::tool_file::read_tools_bytes;
use crate::setup::Tool;

/// Text of the library files.
const PLUNGE: &str = include_str!("../../assets/tools/plunge.toml");
const FLANK: &str = include_str!("../../assets/tools/flank.toml");

/// Plunge milling tools, in file order.
///
/// # Panics
/// Never in practice: a test reads the file.
pub fn plunge_cutters() -> &'static [Tool] {
    static TOOLS: LazyLock<Vec<Tool>> = LazyLock::new(|| {
        read_tools_bytes("assets/tools/plunge.toml", PLUNGE.as_bytes()).expect("the library is sound")
    });
    &TOOLS
}

/// Ball-end mills, in file order.
///
/// # Panics
/// Never in practice: a test reads the file.
pub fn flank_cutters() -> &'static [Tool] {
    static TOOLS: LazyLock<Vec<Tool>> = LazyLock::new(|| {
        read_tools_bytes("assets/tools/flank.toml", FLANK.as_bytes()).expect("the library is sound")
    });
    &TOOLS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flank_cutters_are_balls_with_numbers_of_their_own() {
        let tools = flank_cutters();
        assert!(tools.len() > 20);
        for tool in tools {
            assert_eq!(tool.corner_radius, tool.radius(), "tool {} is a ball", tool.number);
            assert!(plunge_cutters().iter().all(|t| t.number != tool.number), "tool {}", tool.number);
        }
    }

    #[test]
    fn cutters_are_sound_and_cover_small_and_large_wheels() {
        let tools = plunge_cutters();
        for tool in tools {
            assert!(tool.insert_width < tool.radius(), "tool {} has a core", tool.number);
            assert!(
                tool.corner_radius <= tool.insert_width,
                "tool {}: corner within the insert",
                tool.number
            );
            assert!(tool.overhang >= 2.0 * tool.diameter, "tool {} is no stub", tool.number);
        }
        let [least, most] = [f64::min, f64::max].map(|of| tools.iter().map(|t| t.diameter).reduce(of));
        assert_eq!((least, most), (Some(0.2), Some(63.0)), "range of diameters, mm");
    }

    #[test]
    fn a_longer_cutter_of_one_size_is_fed_no_faster() {
        for pair in plunge_cutters().windows(2).filter(|pair| pair[0].diameter == pair[1].diameter) {
            assert!(pair[0].overhang < pair[1].overhang, "tool {} is the longer", pair[1].number);
            assert!(pair[0].plunge_feed >= pair[1].plunge_feed, "tool {} is the slower", pair[1].number);
        }
    }
}
