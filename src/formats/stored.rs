//! What files of plans and projects have in common: a version, the part and the setup within them as the text of their
//! own formats, and coordinates to be checked.

use super::InputError;
use super::part_file::read_part_bytes;
use super::setup_file::read_setup_bytes;
use crate::geometry::{Point, Vector};
use crate::part::{Impeller, PartDescription, Setup};

/// Greatest coordinate that is taken for one, mm.
const FURTHEST: f64 = 1e6;
/// An axis may be so much longer or shorter than 1.
const UNIT_TOLERANCE: f64 = 1e-6;

/// What a plan was made from, read back.
pub(super) struct Origin {
    pub(super) description: PartDescription,
    pub(super) part: Impeller,
    pub(super) setup: Setup,
}

/// Refuses a file of a later version than this program knows; `kind` says what the file `name` is.
pub(super) fn check_version(name: &str, kind: &str, version: u32, known: u32) -> Result<(), InputError> {
    if version <= known {
        return Ok(());
    }
    let what = format!("the {kind} has version {version}, this program reads up to {known}");
    Err(InputError::new(name, 0, what, "open it with a newer vanecut"))
}

/// Part and setup of a plan file: the texts under its keys `part` and `setup`.
pub(super) fn origin(name: &str, part: &str, setup: &str) -> Result<Origin, InputError> {
    let place = inside(name, "part");
    let description = read_part_bytes(&place, part.as_bytes(), "toml")?;
    let part = Impeller::build(&description).map_err(|e| InputError::new(&place, e.line, e.what, e.cure))?;
    Ok(Origin { description, part, setup: setup_within(name, "setup", setup)? })
}

/// The setup that the file `name` holds as `what`.
pub(super) fn setup_within(name: &str, what: &str, text: &str) -> Result<Setup, InputError> {
    read_setup_bytes(&inside(name, what), text.as_bytes())
}

/// How messages name what stands within a file.
fn inside(name: &str, what: &str) -> String {
    format!("{name} ({what})")
}

/// A plan file that reads, but says what cannot be.
pub(super) fn damaged(name: &str, what: impl Into<String>) -> InputError {
    InputError::new(name, 0, what, "plan the part again")
}

/// Whether all of `numbers` can be coordinates, mm.
pub(super) fn are_sane<'n>(numbers: impl IntoIterator<Item = &'n f64>) -> bool {
    numbers.into_iter().all(|x| x.abs() < FURTHEST)
}

/// A point as it stands in a file.
pub(super) fn point(coordinates: [f64; 3]) -> Point {
    Point::from(Vector::from(coordinates))
}

/// The axis that a file gives; `None` where it is no unit vector.
pub(super) fn unit_axis(axis: [f64; 3]) -> Option<Vector> {
    let axis = Vector::from(axis);
    ((axis.norm() - 1.0).abs() <= UNIT_TOLERANCE).then_some(axis)
}
