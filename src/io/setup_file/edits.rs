//! The tables `[[plunge.edit]]` of a setup: edits of single plunges and rows.

use std::fmt::Write;

use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::io::source::quote_for_message;
use crate::io::table::{NumberRange, TomlTable, degrees_text, nearest_note};
use crate::io::tool_file::{MAX_LENGTH, MAX_NUMBER, check_count};
use crate::setup::{PlungeChange, PlungeEdit, PlungeMove, PlungePose};

/// Maximum number of edits in a setup.
const MAX_EDITS: usize = 10_000;
const SHIFT: NumberRange = NumberRange::Between(-MAX_LENGTH, MAX_LENGTH);
const TURN: NumberRange = NumberRange::Between(-90.0, 90.0);
/// Deviation from length 1 that is tolerated of an axis as rounding.
const AXIS_TOLERANCE: f64 = 1e-6;
/// Names of the changes.
const CHANGES: [&str; 5] = ["delete", "lift", "lock", "move", "reorder"];

/// Reads the edits of the table `[plunge]`.
pub(super) fn read_edits(table: &TomlTable<'_>) -> Result<Vec<PlungeEdit>, InputError> {
    let tables = table.tables("edit")?;
    check_count(&tables, MAX_EDITS, "edits")?;
    tables.iter().map(edit).collect()
}

fn edit(table: &TomlTable<'_>) -> Result<PlungeEdit, InputError> {
    table.check_keys(&[
        "at", "row", "change", "by", "tool", "lifted", "along", "across", "lead", "tilt", "before",
    ])?;
    let needed = |key: &str, help: &str| {
        table.fault(format!("{} has no `{key}`", table.shown()), help).with_code(ErrorCode::MissingKey)
    };
    let plunge = pose(table, "at")?
        .ok_or_else(|| needed("at", "give tip and axis of the plunge, as in its line of the program"))?;
    let whole_row = table.boolean("row")?.is_some_and(|row| row.value);
    let change = table
        .string("change")?
        .ok_or_else(|| needed("change", "say \"delete\", \"lift\", \"lock\", \"move\" or \"reorder\""))?;
    let change = match change.value {
        "delete" => PlungeChange::Delete,
        "lift" => {
            let by = table.number("by", SHIFT)?;
            PlungeChange::Lift(by.ok_or_else(|| needed("by", "say by how many mm it stops short"))?.value)
        }
        "lock" => {
            let tool = table.whole("tool", 1, MAX_NUMBER)?;
            let tool = tool.ok_or_else(|| needed("tool", "give the number of its tool"))?.value;
            PlungeChange::Lock { tool, lift: table.number_or("lifted", SHIFT, 0.0)? }
        }
        "move" => {
            let angle = |key: &str| Ok(table.number_or(key, TURN, 0.0)?.to_radians());
            PlungeChange::Move(PlungeMove {
                along: table.number_or("along", SHIFT, 0.0)?,
                across: table.number_or("across", SHIFT, 0.0)?,
                lead_rad: angle("lead")?,
                tilt_rad: angle("tilt")?,
            })
        }
        "reorder" => PlungeChange::Reorder(pose(table, "before")?),
        other => {
            let what = format!("{} is not a change", quote_for_message(other));
            let known = CHANGES.map(|change| format!("\"{change}\"")).join(", ");
            let help = format!("use {known}{}", nearest_note(other, &CHANGES));
            return Err(table.fault_at(change.at, what, help).with_code(ErrorCode::UnknownName));
        }
    };
    Ok(PlungeEdit { plunge, whole_row, change })
}

/// Tip and axis: x, y, z in mm, i, j, k of length 1.
fn pose(table: &TomlTable<'_>, key: &str) -> Result<Option<PlungePose>, InputError> {
    let Some(numbers) = table.numbers(key)? else { return Ok(None) };
    let help = "give x, y, z (mm) and i, j, k, of length 1, as in a GOTO line";
    let wrong = |what: String| Err(table.fault_at(numbers.at, what, help).with_code(ErrorCode::ValueRange));
    let &[x, y, z, i, j, k] = numbers.value.as_slice() else {
        return wrong(format!("`{key}` has {} numbers, not 6", numbers.value.len()));
    };
    let (tip, axis) = (Point::new(x, y, z), Vector::new(i, j, k));
    let length = axis.norm();
    if (length - 1.0).abs() > AXIS_TOLERANCE {
        return wrong(format!("the axis of `{key}` has length {length:.6}, not 1"));
    }
    if tip.coords.amax() > 10.0 * MAX_LENGTH {
        return wrong(format!("the tip of `{key}` is too far away"));
    }
    Ok(Some(PlungePose { tip, axis }))
}

/// Writes the edits of a setup; they read back equal.
pub(super) fn write_edits(out: &mut String, edits: &[PlungeEdit]) -> std::fmt::Result {
    for PlungeEdit { plunge, whole_row, change } in edits {
        writeln!(out, "\n[[plunge.edit]]\nat = {}", pose_text(plunge))?;
        if *whole_row {
            writeln!(out, "row = true")?;
        }
        match change {
            PlungeChange::Delete => writeln!(out, "change = \"delete\"")?,
            PlungeChange::Lift(by) => writeln!(out, "change = \"lift\"\nby = {by:?}")?,
            PlungeChange::Lock { tool, lift } => {
                writeln!(out, "change = \"lock\"\ntool = {tool}\nlifted = {lift:?}")?;
            }
            PlungeChange::Move(by) => {
                writeln!(out, "change = \"move\"\nalong = {:?}\nacross = {:?}", by.along, by.across)?;
                let [lead, tilt] = [by.lead_rad, by.tilt_rad].map(degrees_text);
                writeln!(out, "lead = {lead}\ntilt = {tilt}")?;
            }
            PlungeChange::Reorder(before) => {
                writeln!(out, "change = \"reorder\"")?;
                if let Some(before) = before {
                    writeln!(out, "before = {}", pose_text(before))?;
                }
            }
        }
    }
    Ok(())
}

fn pose_text(PlungePose { tip, axis }: &PlungePose) -> String {
    let numbers = [tip.x, tip.y, tip.z, axis.x, axis.y, axis.z].map(|x| format!("{x:?}"));
    format!("[{}]", numbers.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::setup_file::{read_setup_bytes, write_setup};
    use crate::setup::Setup;

    fn pose(x: f64) -> PlungePose {
        PlungePose { tip: Point::new(x, -2.0 / 3.0, 1e-7), axis: Vector::new(0.6, 0.0, -0.8) }
    }

    #[test]
    fn edits_come_back_as_they_were_written() {
        let mut setup = Setup::default();
        let by = PlungeMove { along: 1.25, across: -0.1, lead_rad: 0.1, tilt_rad: (-2f64).to_radians() };
        for change in [
            PlungeChange::Delete,
            PlungeChange::Lift(0.1 + 0.2),
            PlungeChange::Lock { tool: 64, lift: 0.7 },
            PlungeChange::Lock { tool: 64, lift: -0.5 },
            PlungeChange::Move(by),
            PlungeChange::Reorder(Some(pose(8.0))),
            PlungeChange::Reorder(None),
        ] {
            let whole_row = change == PlungeChange::Delete;
            setup.plunge.edits.push(PlungeEdit { plunge: pose(1.0), whole_row, change });
        }
        assert_eq!(read_setup_bytes("s.toml", write_setup(&setup).as_bytes()), Ok(setup));
    }

    #[test]
    fn faults_of_edits_are_named_with_their_line() {
        for (text, line, words) in [
            ("at = [1, 2, 3]\nchange = \"delete\"", 2, "has 3 numbers"),
            ("at = [1, 2, 3, 1, 1, 0]\nchange = \"delete\"", 2, "has length 1.414214"),
            ("at = [1, 2, 3, 0, 1, 0]\nchange = \"remove\"", 3, "is not a change"),
            ("at = [1, 2, 3, 0, 1, 0]\nchange = \"lift\"", 1, "no `by`"),
            ("at = [1, 2, 3, 0, 1, 0]\nchange = \"lock\"", 1, "no `tool`"),
            ("change = \"delete\"", 1, "no `at`"),
            ("at = [1, 2, 3, 0, 1, 0]", 1, "no `change`"),
        ] {
            let text = format!("[[plunge.edit]]\n{text}\n");
            let error = read_setup_bytes("s.toml", text.as_bytes()).expect_err(words);
            assert!(error.line == line && error.message.contains(words), "{error}");
        }
    }
}
