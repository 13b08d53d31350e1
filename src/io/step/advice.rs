//! Help for files whose bodies are complete but from which no part can be made: closing meshes does not help
//! there.

use crate::error::ErrorCode;
use crate::part::PartError;

/// The same error with help for bodies of CAD; `whole`: the file's bodies have no gaps.
pub(super) fn for_solids(error: PartError, whole: bool) -> PartError {
    let help = match error.code {
        ErrorCode::MeshNotClosed if whole => {
            "the body itself is closed, but its blades have an edge there that was not understood: if they go \
             on past the rim of hub or shroud, cut them off there; else put hub and blades into the file as \
             bodies of their own"
        }
        ErrorCode::MeshInOne => {
            "put hub and blades into the file as bodies of their own, named `Hub` and `Blade`, as they were \
             before they were united"
        }
        ErrorCode::NoShroud => {
            "add the surface of revolution along the blade tips to the file, as a sheet named `Shroud`"
        }
        _ => return error,
    };
    PartError { help: help.to_owned(), ..error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_solid_is_not_to_be_closed() {
        let fault = |code| PartError::new(code, 0, "x", "close the mesh");
        let help = |code, whole| for_solids(fault(code), whole).help;
        for code in [ErrorCode::MeshNotClosed, ErrorCode::MeshInOne, ErrorCode::NoShroud] {
            assert!(!help(code, true).contains("mesh"), "{}", help(code, true));
        }
        assert_eq!(help(ErrorCode::MeshNotClosed, false), "close the mesh");
    }
}
