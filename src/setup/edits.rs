//! Edits of single plunges and rows: what a user changes in a plan by hand. They are part of the setup, so
//! that every front end makes the same plan, and apply in sequence to the plan that the planner found.

use crate::geometry::{Point, Vector};

/// Distance of tips (mm) and of the ends of unit axes up to which two poses are the same plunge: a plan is
/// planned again to the last bit, but files of other programs may round.
const SAME_POSE: f64 = 2e-6;

/// Where a plunge ends, in the frame of the part: as in its line of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlungePose {
    /// Centre of the bottom at the end of the plunge, mm.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
}

impl PlungePose {
    /// Whether both are the same plunge.
    pub fn is(&self, other: &Self) -> bool {
        (self.tip - other.tip).norm() <= SAME_POSE && (self.axis - other.axis).norm() <= SAME_POSE
    }

    /// The pose `by` mm up its axis.
    pub fn lifted(&self, by: f64) -> Self {
        Self { tip: self.tip + self.axis * by, axis: self.axis }
    }
}

/// What an edit does to a plunge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlungeChange {
    /// Leaves it out.
    Delete,
    /// Lets it stop short by this distance, mm; negative: lets it go deeper.
    Lift(f64),
    /// Keeps it in every plan, whatever the planner finds: in place of the plunge of the same tool that is
    /// nearest, if it is near, else in addition.
    Lock {
        /// Number of its tool.
        tool: u32,
        /// Distance by which it stops short of the hub allowance, mm.
        lift: f64,
    },
    /// Moves and turns it, and lowers it onto the hub allowance again.
    Move(PlungeMove),
    /// Cuts it, or its row, before the plunge or the row of this pose in the same section; `None`: last of
    /// the section.
    Reorder(Option<PlungePose>),
}

impl PlungeChange {
    /// Its name, as in setup files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Delete => "delete",
            Self::Lift(_) => "lift",
            Self::Lock { .. } => "lock",
            Self::Move(_) => "move",
            Self::Reorder(_) => "reorder",
        }
    }
}

/// A move of a plunge over the hub, and a turn of its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlungeMove {
    /// Distance along the channel, mm, positive towards the inlet.
    pub along: f64,
    /// Distance across the channel, mm, positive towards the pressure side of it.
    pub across: f64,
    /// Change of the lead angle, rad, positive towards the inlet.
    pub lead_rad: f64,
    /// Change of the tilt angle, rad, positive towards the pressure side.
    pub tilt_rad: f64,
}

/// An edit of a plunge, or of the row in which it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlungeEdit {
    /// The plunge, as the edits before left it.
    pub plunge: PlungePose,
    /// Whether all plunges of its row are edited.
    pub whole_row: bool,
    /// What is done.
    pub change: PlungeChange,
}

/// Adds `edit` to the `edits` of a setup. A lift of what was just lifted adds to that one, whether the plunge
/// is named as it was before or after.
pub fn add_edit(edits: &mut Vec<PlungeEdit>, edit: PlungeEdit) {
    if let (Some(last), PlungeChange::Lift(more)) = (edits.last_mut(), edit.change)
        && let PlungeChange::Lift(by) = last.change
        && last.whole_row == edit.whole_row
        && (last.plunge.is(&edit.plunge) || last.plunge.lifted(by).is(&edit.plunge))
    {
        last.change = PlungeChange::Lift(by + more);
        if (by + more).abs() <= SAME_POSE {
            edits.pop();
        }
        return;
    }
    edits.push(edit);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edit(z: f64, change: PlungeChange) -> PlungeEdit {
        let plunge = PlungePose { tip: Point::new(1.0, 2.0, z), axis: Vector::z() };
        PlungeEdit { plunge, whole_row: false, change }
    }

    #[test]
    fn lifts_of_one_plunge_add_up_and_cancel_out() {
        let mut edits = Vec::new();
        add_edit(&mut edits, edit(0.0, PlungeChange::Lift(1.0)));
        add_edit(&mut edits, edit(1.0, PlungeChange::Lift(0.5)));
        assert_eq!(edits, [edit(0.0, PlungeChange::Lift(1.5))]);
        add_edit(&mut edits, edit(7.0, PlungeChange::Lift(0.5)));
        assert_eq!(edits.len(), 2, "another plunge");
        add_edit(&mut edits, edit(7.5, PlungeChange::Lift(-0.5)));
        assert_eq!(edits.len(), 1, "back where it was");
    }
}
