//! .
use super::InputError;
use crate::part::PartDescription;
pub(super) fn read(_f: &str, _b: &[u8]) -> Result<PartDescription, InputError> {
    todo!()
}
