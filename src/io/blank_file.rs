//! Blanks: an outline as text, or a closed mesh as STL.
//!
//! An outline is one point per line, `r z` in mm, in order around the body; `#` begins a remark. It is closed
//! where its last point repeats the first. Else both of its ends go straight to the axis. STL is in the frame
//! of the part.

use std::path::Path;
use std::sync::Arc;

use super::InputError;
use super::source::{Source, name_of, read_bytes, read_bytes_up_to, text};
use super::stl::{MAX_STL_BYTES, read_stl_bytes};
use crate::error::ErrorCode;
use crate::part::meridional_outline::MAX_OUTLINE_POINTS;
use crate::part::{BlankFile, BlankShape, Meridional, MeridionalOutline, OutlineFault};
use crate::stock::solid::MeshBlank;

/// Words of `[stock] blank` and `--blank` that are not files.
const EDGES: &str = "edges";
const TURNED: &str = "turned";

/// The blank by a word or a file: `edges`, `turned`, or the file `name` in `folder`; `None` where there is no
/// such file.
///
/// # Errors
/// When the file cannot be read or does not bound a blank.
pub fn read_blank(name: &str, folder: &Path) -> Result<Option<BlankShape>, InputError> {
    match name {
        EDGES => Ok(Some(BlankShape::Edges)),
        TURNED => Ok(Some(BlankShape::Turned)),
        _ => {
            let path = folder.join(name);
            if !path.is_file() {
                return Ok(None);
            }
            Ok(Some(BlankShape::File(Arc::new(read_blank_file(name, &path)?))))
        }
    }
}

/// The word or file by which a setup names a shape.
pub fn blank_name(shape: &BlankShape) -> &str {
    match shape {
        BlankShape::Edges => EDGES,
        BlankShape::Turned => TURNED,
        BlankShape::File(file) => &file.name,
    }
}

/// Reads a blank from the file at `path`, which a setup calls `name`.
///
/// # Errors
/// When it cannot be read, an STL is not closed, or an outline does not bound a body.
pub fn read_blank_file(name: &str, path: &Path) -> Result<BlankFile, InputError> {
    let file = name_of(path);
    let blank = |outline, mesh| BlankFile { name: name.to_owned(), path: path.to_owned(), outline, mesh };
    let no_outline = |fault: OutlineFault| InputError::at_file(&file, fault.explained());
    if is_stl(path) {
        let mesh = read_stl_bytes(&file, &read_bytes_up_to(path, MAX_STL_BYTES)?)?;
        let solid = MeshBlank::new(&mesh).map_err(|fault| InputError::at_file(&file, fault.explained()))?;
        let mesh = solid.into_mesh();
        let outline = BlankFile::envelope(&mesh).map_err(no_outline)?;
        return Ok(blank(outline, Some(mesh)));
    }
    Ok(blank(read_outline_bytes(&file, &read_bytes(path)?)?, None))
}

/// Whether a path is that of an STL file.
pub(crate) fn is_stl(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("stl"))
}

/// Reads an outline; `file` is the file name used in messages.
///
/// ```
/// let outline = vanecut::io::blank_file::read_outline_bytes("blank.txt", b"0 50 #\n80 50\n80 -5\n0 -5\n")?;
/// assert_eq!(outline.bounds(), (80.0, (-5.0, 50.0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When a line is not two numbers, or the points do not bound a body.
pub fn read_outline_bytes(file: &str, bytes: &[u8]) -> Result<MeridionalOutline, InputError> {
    let source = Source::new(file, ErrorCode::BlankFile);
    let mut points = Vec::new();
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(text(source, bytes)?.lines()) {
        let content = line.split('#').next().unwrap_or("");
        let mut words = content.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
        let (r, z) = match (words.next(), words.next(), words.next()) {
            (None, ..) => continue,
            (Some(r), Some(z), None) => (r, z),
            _ => {
                return Err(source.fault(number, "the line is not `r z`", "give two numbers in mm per line"));
            }
        };
        points.push(Meridional { r: source.length(number, r, 1.0)?, z: source.length(number, z, 1.0)? });
        lines.push(number);
        if points.len() > MAX_OUTLINE_POINTS {
            let what = format!("the outline has more than {MAX_OUTLINE_POINTS} points");
            return Err(source.fault(number, what, "leave out points"));
        }
    }
    MeridionalOutline::new(&points).map_err(|fault| match fault {
        OutlineFault::NoPoint(index) => {
            let line = lines.get(index - 1).copied().unwrap_or(0);
            source.fault(line, "r is negative", "give the distance from the axis, then the height")
        }
        other => InputError::at_file(file, other.explained()),
    })
}
