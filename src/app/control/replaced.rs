//! What a chosen file must not replace.

use std::path::Path;

use crate::app::model::file_purpose::Purpose;
use crate::app::model::state::AppState;
use crate::io::InputError;
use crate::io::replaced::check_replaced_setup;
use crate::io::shop_tools::check_replaced_library;
use crate::io::source::is_same_file;
use crate::io::write::not_replaced;
use crate::part::BlankShape;

/// Checks that a file for `purpose` replaces neither what is open nor a file of another kind.
///
/// # Errors
/// When it does.
pub(in crate::app) fn check_replaced(
    state: &AppState,
    purpose: Purpose,
    path: &Path,
) -> Result<(), InputError> {
    if !purpose.saves() {
        return Ok(());
    }
    let document = &state.document;
    let part = document.part.as_ref().and_then(|part| part.source.file());
    if part.is_some_and(|(part, _)| is_same_file(part, path)) {
        return Err(not_replaced(path, "is the part that is open"));
    }
    if let BlankShape::File(blank) = &document.edited.setup.allowances.blank
        && is_same_file(&blank.path, path)
    {
        return Err(not_replaced(path, "is the blank of the setup"));
    }
    match purpose {
        Purpose::SaveSetup => check_replaced_setup(path),
        Purpose::SaveLibrary => check_replaced_library(path),
        _ => Ok(()),
    }
}
