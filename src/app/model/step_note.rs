//! What is said at a length of the setup of which a tool takes less.

use super::units::DisplayUnits;
use crate::plunge::spacing::max_step;
use crate::setup::Tool;
use crate::setup::cutting_data::step_share_by_stick_out;

/// What is said at a field: the line below it, and the whole text.
pub type FieldNote = [String; 2];

/// What is said at a step of `mm` that is more than any tool takes: the most of each, and why. `None` where
/// one takes it.
pub fn step_note(mm: f64, tools: &[Tool], units: DisplayUnits) -> Option<FieldNote> {
    let why = |tool: &Tool| {
        let (share, width) = (step_share_by_stick_out(tool), units.short(tool.insert_width, 3));
        let width = format!("its insert width of {width} {}", units.length_unit());
        if max_step(tool) < share * tool.insert_width {
            return "its radius".to_owned();
        }
        let slender = tool.overhang / tool.diameter;
        match share < 1.0 {
            true => format!("{share} of {width}, as its stick-out is {slender:.1} diameters"),
            false => width,
        }
    };
    let [line, text] = note_of(mm, tools, (max_step, why), units)?;
    Some([line, format!("{text}\nA wider insert or a shorter stick-out permits more")])
}

/// What is said at a lead-out of `mm` that is longer than any tool takes: their radius. `None` where one
/// takes it.
pub fn lead_out_note(mm: f64, tools: &[Tool], units: DisplayUnits) -> Option<FieldNote> {
    note_of(mm, tools, (Tool::radius, |_: &Tool| "its radius".to_owned()), units)
}

/// The most that the tools take and why, where that is less than `mm` for all of them. The line gives the
/// greatest.
fn note_of(
    mm: f64,
    tools: &[Tool],
    (most, why): (fn(&Tool) -> f64, impl Fn(&Tool) -> String),
    units: DisplayUnits,
) -> Option<FieldNote> {
    let limit = |mm: f64| format!("{} {}", units.short(mm, 3), units.length_unit());
    let greatest = tools.iter().map(most).reduce(f64::max).filter(|greatest| *greatest < mm - 1e-9)?;
    let line = format!("At most {}", limit(greatest));
    let of_tool =
        |tool: &Tool| format!("T{} takes at most {}: {}", tool.number, limit(most(tool)), why(tool));
    Some([line, tools.iter().map(of_tool).collect::<Vec<_>>().join("\n")])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plunge::spacing::step_limit;
    use crate::setup::{PlungeSetup, Setup, ToolAssembly};

    fn tool(number: u32, overhang: f64) -> Tool {
        Tool {
            number,
            diameter: 12.0,
            corner_radius: 0.5,
            insert_width: 6.0,
            overhang,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: ToolAssembly::default(),
        }
    }

    #[test]
    fn a_step_that_a_tool_does_not_take_is_said_with_its_limit() {
        let tools = [tool(1, 90.0), tool(2, 40.0)];
        for (mm, line) in [(4.0, None), (6.0, None), (20.0, Some("At most 6 mm"))] {
            let note = step_note(mm, &tools, DisplayUnits::Metric);
            assert_eq!(note.as_ref().map(|[line, _]| line.as_str()), line, "{mm}");
            // Where nothing is said the planner takes it.
            let asked = PlungeSetup { step: Some(mm), ..Setup::default().plunge };
            let is_taken = tools.iter().any(|tool| step_limit(&asked, tool, false) == mm);
            assert_eq!(is_taken, line.is_none(), "{mm}");
        }
        let [_, text] = step_note(20.0, &tools, DisplayUnits::Metric).expect("a note");
        let why = "0.8 of its insert width of 6 mm, as its stick-out is 7.5 diameters";
        assert!(
            text.contains(why) && text.contains("T2 takes at most 6 mm: its insert width of 6 mm"),
            "{text}"
        );
        let [line, _] = step_note(6.0, &tools[..1], DisplayUnits::Metric).expect("a note");
        assert_eq!(line, "At most 4.8 mm");
        let [line, text] = lead_out_note(8.0, &tools[..1], DisplayUnits::Metric).expect("a note");
        assert_eq!((line.as_str(), text.as_str()), ("At most 6 mm", "T1 takes at most 6 mm: its radius"));
    }
}
