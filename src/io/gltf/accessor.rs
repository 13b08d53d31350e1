//! Reads numbers from buffers. Every offset, stride and count is checked against the available bytes before
//! memory is allocated; values must be finite.

use super::container::{Container, EXPORT_AGAIN};
use crate::error::ErrorCode;
use crate::io::InputError;

/// Maximum number of elements of an accessor: corners or indices of one mesh.
pub const MAX_ELEMENTS: usize = 24_000_000;
/// Maximum number of elements of an accessor that has only sparse data.
const MAX_WITHOUT_DATA: usize = 1_000_000;

/// Component type of an accessor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of `bytes`, which must be long enough.
    fn number(self, bytes: &[u8], normalized: bool) -> f64 {
        let (value, largest) = match self {
            Self::I8 => (f64::from(bytes[0] as i8), 127.0),
            Self::U8 => (f64::from(bytes[0]), 255.0),
            Self::I16 => (f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
            Self::U16 => (f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
            Self::U32 => return f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
            Self::F32 => return f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        };
        if normalized { (value / largest).max(-1.0) } else { value }
    }
}

/// A run of `count` elements in a buffer view from `offset` on, packed or `stride` bytes apart.
struct ElementRun {
    view: usize,
    offset: usize,
    stride: Option<usize>,
    count: usize,
    component: Component,
    normalized: bool,
}

impl ElementRun {
    /// Calls `take` with every element of `N` numbers.
    fn each<const N: usize>(
        &self,
        container: &mut Container<'_>,
        what: &str,
        mut take: impl FnMut([f64; N]),
    ) -> Result<(), InputError> {
        let size = N * self.component.size();
        let stride = self.stride.unwrap_or(size);
        let source = container.source;
        let bytes = container.view(self.view)?;
        if self.count == 0 {
            return Ok(());
        }
        let last = (self.count - 1).checked_mul(stride).and_then(|x| x.checked_add(self.offset));
        let end = last.and_then(|x| x.checked_add(size));
        if stride < size || end.is_none_or(|end| end > bytes.len()) {
            let text = format!(
                "{what} needs {} elements of {size} bytes from {} on, but its buffer view has {} bytes",
                self.count,
                self.offset,
                bytes.len()
            );
            return Err(source.cut_off(0, text));
        }
        for i in 0..self.count {
            let at = self.offset + i * stride;
            let element = std::array::from_fn(|k| {
                self.component.number(&bytes[at + k * self.component.size()..], self.normalized)
            });
            take(element);
        }
        Ok(())
    }
}

/// The elements of an accessor of `N` numbers each, with sparse values applied; `what` names it in messages.
fn elements<const N: usize>(
    container: &mut Container<'_>,
    accessor: usize,
    what: &str,
    may: impl Fn(Component) -> bool,
) -> Result<Vec<[f64; N]>, InputError> {
    let Some(described) = container.document.accessors.get(accessor) else {
        return Err(container.missing(format!("{what}: accessor {accessor}")));
    };
    let what = format!("{what} (accessor {accessor})");
    let shape = match N {
        1 => "SCALAR",
        3 => "VEC3",
        _ => "VEC4",
    };
    let component = Component::from_code(described.component_type).filter(|c| may(*c));
    let (Some(component), true) = (component, described.shape == shape) else {
        let text = format!(
            "{what} holds {} of type {}, which does not suit it",
            described.shape, described.component_type
        );
        return Err(container.fault(text, EXPORT_AGAIN).with_code(ErrorCode::GltfAccessor));
    };
    let (count, normalized) = (described.count, described.normalized);
    let run = described.buffer_view.map(|view| ElementRun {
        view,
        offset: described.byte_offset,
        stride: container.document.buffer_views.get(view).and_then(|v| v.byte_stride),
        count,
        component,
        normalized,
    });
    let sparse = described.sparse.as_ref().map(|s| {
        let run = |view, offset, component| ElementRun {
            view,
            offset,
            stride: None,
            count: s.count,
            component,
            normalized,
        };
        let indices = Component::from_code(s.indices.component_type).filter(|c| is_index(*c));
        let values = run(s.values.buffer_view, s.values.byte_offset, component);
        (indices.map(|c| run(s.indices.buffer_view, s.indices.byte_offset, c)), values)
    });
    let max_count = if run.is_some() { MAX_ELEMENTS } else { MAX_WITHOUT_DATA };
    if count > max_count || sparse.as_ref().is_some_and(|(_, values)| values.count > count) {
        let text =
            format!("{what} has {count} elements, more than {max_count} or fewer than its sparse ones");
        return Err(container.too_large(text));
    }
    let mut found: Vec<[f64; N]> = match (&run, &sparse) {
        (Some(run), _) => {
            // The bytes are checked before memory is allocated: the count alone may be wrong.
            container.view(run.view)?;
            let mut found = Vec::new();
            run.each(container, &what, |element| found.push(element))?;
            found
        }
        (None, Some(_)) => vec![[0.0; N]; count],
        (None, None) => {
            let error = container.fault(format!("{what} has no data"), EXPORT_AGAIN);
            return Err(error.with_code(ErrorCode::GltfAccessor));
        }
    };
    if let Some((indices, values)) = sparse {
        let Some(indices) = indices else {
            let error = container.fault(format!("{what} has sparse indices of unknown type"), EXPORT_AGAIN);
            return Err(error.with_code(ErrorCode::GltfAccessor));
        };
        let mut places = Vec::new();
        indices.each(container, &what, |[place]: [f64; 1]| places.push(place as usize))?;
        if let Some(place) = places.iter().find(|place| **place >= count) {
            let text = format!("{what} replaces element {place} of {count}");
            return Err(container.fault(text, EXPORT_AGAIN).with_code(ErrorCode::GltfAccessor));
        }
        let mut places = places.into_iter();
        values.each(container, &what, |element| {
            if let Some(place) = places.next() {
                found[place] = element;
            }
        })?;
    }
    if let Some(place) = found.iter().position(|e| e.iter().any(|x| !x.is_finite())) {
        let text = format!("{what}: element {place} is not a finite number");
        return Err(container
            .fault(text, "repair the mesh and export it again")
            .with_code(ErrorCode::MeshValues));
    }
    Ok(found)
}

fn is_index(component: Component) -> bool {
    matches!(component, Component::U8 | Component::U16 | Component::U32)
}

/// Corners of a mesh, in the file's unit.
///
/// # Errors
/// When the accessor does not exist, is not of three-component vectors, or its data is invalid.
pub fn positions(
    container: &mut Container<'_>,
    accessor: usize,
    what: &str,
) -> Result<Vec<[f64; 3]>, InputError> {
    elements(container, accessor, what, |c| c != Component::U32)
}

/// Indices of a mesh with `corners` corners.
///
/// # Errors
/// When the accessor is not of indices, or an index is out of range.
pub fn indices(
    container: &mut Container<'_>,
    accessor: usize,
    corners: usize,
    what: &str,
) -> Result<Vec<u32>, InputError> {
    let found = elements::<1>(container, accessor, what, is_index)?;
    if let Some(place) = found.iter().position(|[i]| *i >= corners as f64) {
        let text = format!("{what}: index {place} is {}, but there are {corners} corners", found[place][0]);
        return Err(container.fault(text, EXPORT_AGAIN).with_code(ErrorCode::MeshValues));
    }
    Ok(found.into_iter().map(|[i]| i as u32).collect())
}

/// Translations or scales of instances.
///
/// # Errors
/// When the accessor is not of three-component float vectors, or its data is invalid.
pub fn vectors(
    container: &mut Container<'_>,
    accessor: usize,
    what: &str,
) -> Result<Vec<[f64; 3]>, InputError> {
    elements(container, accessor, what, |c| c == Component::F32)
}

/// Rotations of instances, as quaternions x y z w.
///
/// # Errors
/// When the accessor is not of four-component vectors, or its data is invalid.
pub fn quaternions(
    container: &mut Container<'_>,
    accessor: usize,
    what: &str,
) -> Result<Vec<[f64; 4]>, InputError> {
    elements(container, accessor, what, |c| matches!(c, Component::F32 | Component::I8 | Component::I16))
}
