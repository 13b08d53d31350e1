//! STL: triangles without shared corners, binary or text. Lengths are mm.

use std::path::Path;

use super::InputError;
use super::source::{
    MAX_COORDINATE, MAX_TRIANGLES, Source, line_at, name_of, number, quote_for_message, read_bytes_up_to,
    stem_of,
};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::mesh::describe::describe_source;
use crate::mesh::source::MeshSource;
use crate::mesh::{LengthUnit, MeshOptions, NamedMesh, TriangleMesh};
use crate::part::PartDescription;

/// Maximum file size, bytes.
pub const MAX_STL_BYTES: usize = 512 << 20;
/// Length of the head of a binary file with the number of triangles, bytes, and of a triangle.
const HEAD: usize = 84;
const RECORD: usize = 50;

/// Reads STL from bytes, binary or text; `name` is the file name used in messages. Corners are not joined.
///
/// # Errors
/// When the bytes are not STL, are cut off, or have a coordinate that is not a finite number up to 1,000,000.
pub fn read_stl_bytes(name: &str, bytes: &[u8]) -> Result<TriangleMesh, InputError> {
    let source = Source::new(name, ErrorCode::MeshFile);
    if bytes.len() > MAX_STL_BYTES {
        let what = format!("is larger than {} MiB", MAX_STL_BYTES >> 20);
        return Err(source.fault(0, what, "give a smaller file").with_code(ErrorCode::FileTooLarge));
    }
    // A binary head may begin with `solid`, too; its length tells.
    let count = bytes.get(80..HEAD).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let fits = count.is_some_and(|count| bytes.len() == HEAD + RECORD * count as usize);
    let text = bytes.trim_ascii_start().get(..5).is_some_and(|b| b.eq_ignore_ascii_case(b"solid"));
    let mesh = match count {
        Some(count) if fits || !text => read_binary(source, bytes, count as usize)?,
        _ if text => read_text(source, bytes)?,
        _ => {
            return Err(source
                .fault(0, "is not an STL file", "check that this is the right file")
                .with_code(ErrorCode::FileFormat));
        }
    };
    if mesh.triangles.is_empty() {
        return Err(source.fault(0, "has no triangles", "export it again").with_code(ErrorCode::NoTriangles));
    }
    Ok(mesh)
}

fn push(mesh: &mut TriangleMesh, corners: [Point; 3]) {
    let first = mesh.points.len() as u32;
    mesh.points.extend(corners);
    mesh.triangles.push([first, first + 1, first + 2]);
}

fn too_many(source: Source<'_>) -> InputError {
    source
        .fault(0, format!("has more than {MAX_TRIANGLES} triangles"), "export a coarser mesh")
        .with_code(ErrorCode::FileTooLarge)
}

fn read_binary(source: Source<'_>, bytes: &[u8], count: usize) -> Result<TriangleMesh, InputError> {
    let records = bytes.get(HEAD..).unwrap_or_default().chunks_exact(RECORD);
    if records.len() < count {
        let what = format!("ends after {} of {count} triangles", records.len());
        return Err(source.cut_off(0, what));
    }
    if count > MAX_TRIANGLES {
        return Err(too_many(source));
    }
    let mut mesh = TriangleMesh::default();
    for (index, record) in records.take(count).enumerate() {
        let mut numbers = record
            .chunks_exact(4)
            .skip(3)
            .map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap_or_default())));
        let mut corner = || {
            let mut next = || numbers.next().unwrap_or(f64::NAN);
            Point::new(next(), next(), next())
        };
        let corners = [corner(), corner(), corner()];
        if corners.iter().any(|p| !p.iter().all(|x| x.abs() <= MAX_COORDINATE)) {
            let what = format!("triangle {} has a corner that is not within 1,000,000 mm", index + 1);
            let error = source.fault(0, what, "check its units, or export it again");
            return Err(error.with_code(ErrorCode::MeshValues));
        }
        push(&mut mesh, corners);
    }
    Ok(mesh)
}

fn read_text(source: Source<'_>, bytes: &[u8]) -> Result<TriangleMesh, InputError> {
    let mut mesh = TriangleMesh::default();
    let mut corners: Vec<Point> = Vec::with_capacity(3);
    let mut ended = false;
    for (index, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let mut words = line.split_ascii_whitespace();
        let fault = |what: String| source.fault(index + 1, what, "export it again");
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => {
                let mut next = || match words.next() {
                    Some(word) => number(word).map_err(|wrong| fault(wrong.message)),
                    None => Err(fault("vertex has fewer than three numbers".to_owned())),
                };
                corners.push(Point::new(next()?, next()?, next()?));
                if corners.len() > 3 {
                    return Err(fault("a facet has more than three corners".to_owned()));
                }
            }
            Some("endfacet") => {
                let Ok(three) = <[Point; 3]>::try_from(corners.as_slice()) else {
                    return Err(fault(format!("a facet has {} corners instead of three", corners.len())));
                };
                corners.clear();
                if mesh.triangles.len() == MAX_TRIANGLES {
                    return Err(too_many(source));
                }
                push(&mut mesh, three);
            }
            Some("endsolid") => ended = true,
            None | Some("solid" | "facet" | "outer" | "endloop") => {}
            Some(other) => return Err(fault(format!("{} is not a word of STL", quote_for_message(other)))),
        }
    }
    if !ended || !corners.is_empty() {
        return Err(source.cut_off(line_at(bytes, bytes.len()), "lacks `endsolid`"));
    }
    Ok(mesh)
}

/// Reads a part from an `.stl` file; the result is in mm, about Z.
///
/// # Errors
/// When the file cannot be read, is not STL, or does not describe a part.
pub fn read_part(path: &Path, options: &MeshOptions) -> Result<PartDescription, InputError> {
    read_part_bytes(&name_of(path), &read_bytes_up_to(path, MAX_STL_BYTES)?, options)
}

/// Reads the mesh of an `.stl` file, named as the file.
///
/// # Errors
/// When the file cannot be read or is not STL.
pub fn read_meshes(path: &Path) -> Result<Vec<NamedMesh>, InputError> {
    let name = name_of(path);
    let mesh = read_stl_bytes(&name, &read_bytes_up_to(path, MAX_STL_BYTES)?)?;
    Ok(vec![named_mesh(stem_of(&name), mesh)])
}

fn named_mesh(name: String, mesh: TriangleMesh) -> NamedMesh {
    NamedMesh { name, other_names: Vec::new(), node: 0, instance: 0, mesh }
}

/// As [`read_part`], from bytes; `name` is the file name used in messages.
///
/// # Errors
/// As [`read_part`].
pub fn read_part_bytes(
    name: &str,
    bytes: &[u8],
    options: &MeshOptions,
) -> Result<PartDescription, InputError> {
    let mesh = read_stl_bytes(name, bytes)?;
    let stem = stem_of(name);
    let mut source = MeshSource::from_unit(LengthUnit::Millimetre);
    if options.unit.is_none() {
        source.notes.push("STL has no unit: mm are assumed; give --unit if they are not".to_owned());
    }
    describe_source(&stem, vec![named_mesh(stem.clone(), mesh)], source, options)
        .map_err(|e| InputError::of_part(name, e))
}

/// Writes triangles over shared `points` as binary STL. `about` goes to its head, up to 75 characters.
pub fn write_stl(points: &[Point], triangles: &[[u32; 3]], about: &str) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEAD + RECORD * triangles.len());
    // Not `solid` in front, by which text files begin.
    let mut head: Vec<u8> = about.bytes().filter(u8::is_ascii_graphic).take(75).collect();
    head.splice(0..0, *b"stl: ");
    head.resize(80, b' ');
    out.extend(head);
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        // The normal is that of the corners as they are written, in single precision.
        let corners = t.map(|i| points[i as usize].map(|x| x as f32));
        let [a, b, c] = corners.map(|p| p.map(f64::from));
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let numbers = normal.iter().map(|x| *x as f32);
        let numbers = numbers.chain(corners.iter().flat_map(|p| [p.x, p.y, p.z]));
        out.extend(numbers.flat_map(f32::to_le_bytes));
        out.extend([0; 2]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> TriangleMesh {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 2.0]].map(Point::from);
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        TriangleMesh { points: points.to_vec(), triangles }
    }

    #[test]
    fn what_is_written_is_read() {
        let mesh = tetrahedron();
        let bytes = write_stl(&mesh.points, &mesh.triangles, "a part");
        assert_eq!(bytes.len(), 84 + 4 * 50);
        let read = read_stl_bytes("a.stl", &bytes).expect("sound");
        let corners = |m: &TriangleMesh| -> Vec<Point> {
            m.triangles.iter().flatten().map(|&i| m.points[i as usize]).collect()
        };
        assert_eq!(corners(&read), corners(&mesh));
    }

    #[test]
    fn text_is_read_and_faults_name_their_line() {
        let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\n\
                     endfacet\n";
        let good = format!("solid a\n{facet}endsolid a\n");
        assert_eq!(read_stl_bytes("a.stl", good.as_bytes()).expect("sound").triangles.len(), 1);
        for (from, to, line, code) in [
            ("vertex 1 0 0\n", "", 7, ErrorCode::MeshFile),
            ("1 0 0", "1 0 nan", 5, ErrorCode::MeshFile),
            ("1 0 0", "1 0", 5, ErrorCode::MeshFile),
            ("endloop", "loopend", 7, ErrorCode::MeshFile),
            ("endsolid a", "", 10, ErrorCode::FileCutOff),
        ] {
            let error = read_stl_bytes("a.stl", good.replacen(from, to, 1).as_bytes()).expect_err(to);
            assert_eq!((error.line, error.code), (line, code), "{error}");
        }
        let empty = read_stl_bytes("a.stl", b"solid a\nendsolid a\n").expect_err("holds nothing");
        assert_eq!(empty.code, ErrorCode::NoTriangles, "{empty}");
    }

    #[test]
    fn damaged_binary_files_are_refused() {
        let mesh = tetrahedron();
        let whole = write_stl(&mesh.points, &mesh.triangles, "");
        for end in [0, 3, 60, 84, 100, whole.len() - 1] {
            assert!(read_stl_bytes("a.stl", &whole[..end]).is_err(), "{end} bytes");
        }
        let mut huge = whole.clone();
        huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(read_stl_bytes("a.stl", &huge).expect_err("too short").code, ErrorCode::FileCutOff);
        let mut endless = whole;
        endless[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
        let error = read_stl_bytes("a.stl", &endless).expect_err("a corner is infinite");
        assert_eq!(error.code, ErrorCode::MeshValues, "{error}");
        assert!(error.message.contains("triangle 1"), "{error}");
    }
}
