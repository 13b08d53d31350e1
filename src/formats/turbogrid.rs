//! .
use super::InputError;
use crate::part::PartDescription;
pub(super) fn read(_f: &std::path::Path) -> Result<PartDescription, InputError> {
    todo!()
}
