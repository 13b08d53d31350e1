//! Shared by plan and project files: the version check, the part and setup embedded as text in their own
//! formats, values held by their name, and checks of coordinates.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::InputError;
use super::part_file::read_part_bytes;
use super::setup_file::read_setup_bytes;
use super::source::MAX_COORDINATE;
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::part::{Impeller, PartDescription};
use crate::setup::{AxisPolicy, Setup};

/// Tolerance on the length of a unit axis.
const UNIT_TOLERANCE: f64 = 1e-6;

/// The part and setup that a plan was made from.
pub(super) struct StoredInputs {
    pub(super) description: PartDescription,
    pub(super) part: Impeller,
    pub(super) setup: Setup,
}

/// Returns an error if a file's `version` is newer than `known`, the newest supported one; `kind` is the
/// kind of the file `name` in the message.
pub(super) fn check_version(name: &str, kind: &str, version: u32, known: u32) -> Result<(), InputError> {
    if version <= known {
        return Ok(());
    }
    let what = format!("the {kind} has version {version}, this program reads up to {known}");
    Err(InputError::new(ErrorCode::NewerFile, name, 0, what, "open it with a newer vanecut"))
}

/// Reads the part and setup of a plan file from the texts under its keys `part` and `setup`. `policy` is the
/// one that a plunge plan was made by: in older files the setup may name another.
pub(super) fn read_inputs(
    name: &str,
    part: &str,
    setup: &str,
    policy: Option<AxisPolicy>,
) -> Result<StoredInputs, InputError> {
    let place = inside(name, "part");
    let description = read_part_bytes(&place, part.as_bytes(), "toml")?;
    let part = Impeller::build(&description).map_err(|e| InputError::of_part(&place, e))?;
    let mut setup = read_setup_bytes(&inside(name, "setup"), setup.as_bytes())?;
    setup.plunge.axis = policy.unwrap_or(setup.plunge.axis);
    Ok(StoredInputs { description, part, setup })
}

/// Name in messages of a text embedded in a file.
pub(super) fn inside(name: &str, what: &str) -> String {
    format!("{name} ({what})")
}

/// The error of a plan file whose syntax is valid but whose values are not.
pub(super) fn damaged(name: &str, what: impl Into<String>) -> InputError {
    InputError::new(ErrorCode::PlanFile, name, 0, what, "plan the part again")
}

/// Whether all `numbers` are finite and within the coordinate limit, mm.
pub(super) fn are_coordinates<'n>(numbers: impl IntoIterator<Item = &'n f64>) -> bool {
    numbers.into_iter().all(|x| x.abs() < MAX_COORDINATE)
}

/// A point from its coordinates in a file, mm.
pub(super) fn point(coordinates: [f64; 3]) -> Point {
    Point::from(Vector::from(coordinates))
}

/// A tool axis from its components in a file; `None` if it is not a unit vector.
pub(super) fn unit_axis(axis: [f64; 3]) -> Option<Vector> {
    let axis = Vector::from(axis);
    ((axis.norm() - 1.0).abs() <= UNIT_TOLERANCE).then_some(axis)
}

/// A kind of value with a name for each of its values.
pub(super) trait Named: Copy + 'static {
    /// All values.
    const ALL: &[Self];

    /// The name in files.
    fn name(self) -> &'static str;
}

/// A value that a record holds by its name.
#[derive(Clone, Copy)]
pub(super) struct ByName<T>(pub T);

impl<T: Named> Serialize for ByName<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

impl<'de, T: Named> Deserialize<'de> for ByName<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let known = || T::ALL.iter().map(|value| value.name()).collect::<Vec<_>>().join(", ");
        let found = T::ALL.iter().find(|value| value.name() == name);
        found
            .map(|value| Self(*value))
            .ok_or_else(|| D::Error::custom(format!("unknown name `{name}`; known: {}", known())))
    }
}
