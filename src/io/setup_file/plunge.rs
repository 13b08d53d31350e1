//! Reading the table `[plunge]` of a setup, with its sections.

use super::edits::read_edits;
use super::goal::read_goal;
use super::keys::{PLUNGE_KEYS, RENAMED_IN_SECTION, SECTION_KEYS};
use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::io::source::quote_for_message;
use crate::io::table::{NumberRange, TomlTable, nearest_note};
use crate::io::tool_file::{ALLOWANCE, LENGTH, MAX_NUMBER, check_count};
use crate::setup::{AxisPolicy, CutDirection, PlungeSetup, SectionKind, SectionSetup, Tool};

const ANGLE: NumberRange = NumberRange::Above(0.0, 90.0);

/// Maximum number of sections in a setup.
const MAX_SECTIONS: usize = 100;

/// Reads the table `[plunge]` over the values of `plunge`; the sections name some of `tools`.
pub(super) fn plunge(
    table: &TomlTable<'_>,
    tools: &[Tool],
    plunge: &mut PlungeSetup,
) -> Result<(), InputError> {
    table.check_keys(&PLUNGE_KEYS.map(|(key, _)| key))?;
    if let Some(axis) = table.string("axis")? {
        plunge.axis = parse_axis_policy(axis.value).map_err(|error| table.locate(axis.at, error))?;
    }
    plunge.step = table.number("step", LENGTH)?.map(|step| step.value);
    plunge.stepover = table.number("stepover", LENGTH)?.map(|stepover| stepover.value);
    plunge.wall_scallop = table.number_or("wall_scallop", LENGTH, plunge.wall_scallop)?;
    if let Some(angle) = table.number("max_axis_change", ANGLE)? {
        plunge.max_axis_change_rad = angle.value.to_radians();
    }
    if let Some(angle) = table.number("max_tilt", ANGLE)? {
        plunge.max_tilt_rad = angle.value.to_radians();
    }
    plunge.goal = read_goal(table)?.unwrap_or(plunge.goal);
    plunge.lead_out = table.number("lead_out", ALLOWANCE)?.map(|way| way.value).filter(|way| *way > 0.0);
    plunge.peck = table.number("peck", LENGTH)?.map(|peck| peck.value);
    if let Some(adapt) = table.boolean("adapt_feed")? {
        plunge.adapt_feed = adapt.value;
    }
    if let Some(rapid) = table.boolean("rapid_approach")? {
        plunge.rapid_approach = rapid.value;
    }
    if let Some(rest) = table.boolean("rest")? {
        plunge.rest = rest.value;
    }
    let sections: Vec<_> =
        table.tables("section")?.into_iter().map(|t| t.with_renamed_keys(RENAMED_IN_SECTION)).collect();
    check_count(&sections, MAX_SECTIONS, "sections")?;
    plunge.sections = sections.iter().map(|table| section(table, tools)).collect::<Result<_, _>>()?;
    plunge.edits = read_edits(table)?;
    check_section_order(&plunge.sections, &sections)
}

/// Checks that sections above the shroud come first, and those for the rest after others.
fn check_section_order(sections: &[SectionSetup], tables: &[TomlTable<'_>]) -> Result<(), InputError> {
    let is_opening = |section: &SectionSetup| section.kind == SectionKind::Opening;
    let first = sections.iter().position(|section| !is_opening(section)).unwrap_or(sections.len());
    let wrong = |index: usize, what: &str, help: &str| {
        let table = &tables[index];
        Err(table.fault(format!("{} {what}", table.shown()), help).with_code(ErrorCode::SectionOrder))
    };
    if sections.get(first).is_some_and(|section| section.kind == SectionKind::Rest) {
        let help = "put it after the sections whose residual stock it removes";
        return wrong(first, "is rest milling, but no section comes before it", help);
    }
    match sections.iter().skip(first).position(is_opening) {
        Some(after) => wrong(
            first + after,
            "is above the shroud, but comes after one that is not",
            "put it first: the tools of the others pass through what it removes",
        ),
        None => Ok(()),
    }
}

fn section(table: &TomlTable<'_>, tools: &[Tool]) -> Result<SectionSetup, InputError> {
    table.check_keys(&SECTION_KEYS.map(|(key, _)| key))?;
    let needed = |key: &str| {
        table
            .fault(format!("{} has no `{key}`", table.shown()), "give tool, from (outlet end) and to")
            .with_code(ErrorCode::MissingKey)
    };
    let tool = table.whole("tool", 1, MAX_NUMBER)?.ok_or_else(|| needed("tool"))?;
    if !tools.iter().any(|known| known.number == tool.value) {
        let numbers: Vec<String> = tools.iter().take(20).map(|tool| tool.number.to_string()).collect();
        let help = match numbers.is_empty() {
            true => format!("add a [[tool]] with number = {}", tool.value),
            false => format!("use one of the tools {}", numbers.join(", ")),
        };
        return Err(table
            .fault_at(tool.at, format!("there is no tool {}", tool.value), help)
            .with_code(ErrorCode::UndefinedTool));
    }
    let s = NumberRange::Between(0.0, 1.0);
    let from = table.number("from", s)?.ok_or_else(|| needed("from"))?;
    let to = table.number("to", s)?.ok_or_else(|| needed("to"))?;
    if from.value <= to.value {
        let what = format!("the section runs from {} to {}", from.value, to.value);
        let help = "`from` is the outlet end (1 at the rim) and must be greater than `to`";
        return Err(table.fault_at(to.at, what, help).with_code(ErrorCode::SectionOrder));
    }
    let cut_direction = match table.string("cutting_direction")? {
        None => None,
        Some(direction) => Some(match direction.value {
            "outlet_to_inlet" | "inward" => CutDirection::OutletToInlet,
            "inlet_to_outlet" | "outward" => CutDirection::InletToOutlet,
            other => {
                let what = format!("{} is not a cutting direction", quote_for_message(other));
                let help = "use \"outlet_to_inlet\" or \"inlet_to_outlet\"";
                return Err(table.fault_at(direction.at, what, help).with_code(ErrorCode::UnknownName));
            }
        }),
    };
    let rest = table.boolean("rest")?.is_some_and(|rest| rest.value);
    let opening = table.boolean("opening")?.filter(|opening| opening.value);
    let kind = match (rest, opening) {
        (true, Some(opening)) => {
            let what = "a section is either for the rest or above the shroud";
            return Err(table.fault_at(opening.at, what, "remove `rest` or `opening`"));
        }
        (true, None) => SectionKind::Rest,
        (false, Some(_)) => SectionKind::Opening,
        (false, None) => SectionKind::Rows,
    };
    Ok(SectionSetup { tool: tool.value, from: from.value, to: to.value, cut_direction, kind })
}

/// The axis policy with this name, from a file or the command line.
///
/// # Errors
/// When no policy has this name: what is wrong, and what to do.
pub fn parse_axis_policy(name: &str) -> Result<AxisPolicy, UserError> {
    match AxisPolicy::ALL.into_iter().find(|policy| policy.name() == name) {
        Some(policy) => Ok(policy),
        None => {
            let other = name;
            let near = nearest_note(other, &AxisPolicy::ALL.map(AxisPolicy::name));
            Err(UserError::new(
                ErrorCode::UnknownName,
                format!("{} is not an axis policy", quote_for_message(other)),
                format!("use \"conventional\", \"monotone\", \"minimal\" or \"staircase\"{near}"),
            ))
        }
    }
}
