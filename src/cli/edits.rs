//! Edits by hand that could not be applied, as text and JSON.

use serde_json::{Value, json};

use super::output::number;
use crate::job::PlanOutcome;
use crate::plunge::UnappliedEdit;
use crate::setup::PlungePose;

/// A line for each edit of the setup that the plan could not apply; they count from 1, as they are in the
/// file.
pub fn unapplied_text(outcome: &PlanOutcome) -> String {
    let line = |unapplied: &UnappliedEdit| {
        let edit = outcome.setup.plunge.edits.get(unapplied.index)?;
        let tip = edit.plunge.tip;
        Some(format!(
            "  edit {}, {} of the {} at ({:.3}, {:.3}, {:.3}): {}\n",
            unapplied.index + 1,
            edit.change.name(),
            if edit.whole_row { "row of the plunge" } else { "plunge" },
            tip.x,
            tip.y,
            tip.z,
            unapplied.reason(|mm| format!("{mm:.3} mm")),
        ))
    };
    outcome.edits.unapplied.iter().filter_map(line).collect()
}

/// The same as a JSON array: mm, unit vectors.
pub fn unapplied_objects(outcome: &PlanOutcome) -> Value {
    let object = |unapplied: &UnappliedEdit| {
        let edit = outcome.setup.plunge.edits.get(unapplied.index)?;
        let PlungePose { tip, axis } = edit.plunge;
        let mut object = json!({
            "edit": unapplied.index + 1,
            "change": edit.change.name(),
            "row": edit.whole_row,
            "tip": [number(tip.x), number(tip.y), number(tip.z)],
            "axis": [number(axis.x), number(axis.y), number(axis.z)],
            "why": unapplied.reason(|mm| format!("{mm:.3} mm")),
        });
        if let (Some(near), Some(map)) = (unapplied.nearest, object.as_object_mut()) {
            map.insert("nearest_position".into(), json!(near.index + 1));
            map.insert("nearest_distance".into(), number(near.distance));
        }
        Some(object)
    };
    outcome.edits.unapplied.iter().filter_map(object).collect()
}
