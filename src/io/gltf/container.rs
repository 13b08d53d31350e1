//! The container of a glTF file: the chunks of a `.glb`, the JSON, and the buffers, which are in the file,
//! in data URIs or in files beside it.

use std::path::{Component, Path};

use super::document::GltfDocument;
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{MAX_BYTES, Source, quote_for_message, read_bytes_up_to};

/// Maximum size of a `.glb` or buffer file, bytes: four million triangles without shared corners.
pub const MAX_MESH_BYTES: usize = 512 << 20;

const MAGIC: &[u8] = b"glTF";
pub(super) const JSON_CHUNK: u32 = 0x4E4F_534A;
pub(super) const BINARY_CHUNK: u32 = 0x004E_4942;
/// Help text where a file contradicts itself.
pub(super) const EXPORT_AGAIN: &str = "export the file again";

/// Supported extensions that affect the meshes or their transforms.
const SUPPORTED_EXTENSIONS: [&str; 2] = ["EXT_mesh_gpu_instancing", "KHR_mesh_quantization"];
/// Name prefixes of extensions that only affect the appearance.
const APPEARANCE_PREFIXES: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "EXT_lights_"];

/// A document and its buffers.
pub struct Container<'a> {
    /// The file, for the location of errors.
    pub source: Source<'a>,
    /// Its JSON.
    pub document: GltfDocument,
    /// Bytes of the buffers that have been loaded.
    buffers: Vec<Option<Vec<u8>>>,
    /// Folder of the file; `None` for bytes without a file.
    folder: Option<&'a Path>,
}

impl<'a> Container<'a> {
    /// Parses the container; buffers in other files are read on first use.
    ///
    /// # Errors
    /// When the chunks or the JSON are invalid, or a required extension is not supported.
    pub fn open(source: Source<'a>, bytes: Vec<u8>, folder: Option<&'a Path>) -> Result<Self, InputError> {
        let (document, binary) = if bytes.starts_with(MAGIC) {
            let (json, binary) = chunks(source, &bytes)?;
            let document = parse(source, &bytes[json])?;
            (document, binary.map(|range| bytes[range].to_vec()))
        } else {
            (parse(source, &bytes)?, None)
        };
        drop(bytes);
        let mut buffers: Vec<Option<Vec<u8>>> = document.buffers.iter().map(|_| None).collect();
        if let (Some(first), Some(binary)) = (buffers.first_mut(), binary)
            && document.buffers[0].uri.is_none()
        {
            *first = Some(binary);
        }
        let container = Self { source, document, buffers, folder };
        container.check_extensions()?;
        Ok(container)
    }

    /// An error of this file.
    pub fn fault(&self, what: impl Into<String>, help: impl Into<String>) -> InputError {
        self.source.fault(0, what, help)
    }

    /// The error of a file that refers to `what`, which it does not have.
    pub fn missing(&self, what: impl std::fmt::Display) -> InputError {
        self.fault(format!("{what} does not exist"), EXPORT_AGAIN).with_code(ErrorCode::GltfReference)
    }

    /// The error of a file with more than the program takes.
    pub fn too_large(&self, what: impl Into<String>) -> InputError {
        self.fault(what, "export the impeller alone, with fewer triangles").with_code(ErrorCode::FileTooLarge)
    }

    fn check_extensions(&self) -> Result<(), InputError> {
        for name in &self.document.extensions_required {
            if name == "KHR_draco_mesh_compression" {
                return Err(self.compressed("Draco"));
            }
            if name.ends_with("_meshopt_compression") {
                return Err(self.compressed("meshopt"));
            }
            let known = SUPPORTED_EXTENSIONS.contains(&name.as_str());
            if !known && !APPEARANCE_PREFIXES.iter().any(|start| name.starts_with(start)) {
                let what = format!("needs the extension {}, which is not supported", quote_for_message(name));
                return Err(self
                    .fault(what, "export it without that extension")
                    .with_code(ErrorCode::GltfExtension));
            }
        }
        Ok(())
    }

    /// The error for a compressed file.
    pub fn compressed(&self, how: &str) -> InputError {
        self.fault(format!("its meshes are compressed with {how}"), "export it without mesh compression")
            .with_code(ErrorCode::MeshCompressed)
    }

    /// Bytes of a buffer view; loads its buffer if necessary.
    ///
    /// # Errors
    /// When the view or its buffer does not exist, is compressed, too large or too short, or cannot be read.
    pub fn view(&mut self, view: usize) -> Result<&[u8], InputError> {
        let Some(described) = self.document.buffer_views.get(view) else {
            return Err(self.missing(format!("buffer view {view}")));
        };
        let (buffer, offset, length) = (described.buffer, described.byte_offset, described.byte_length);
        if described.extensions.as_ref().is_some_and(|e| e.meshopt.is_some()) {
            return Err(self.compressed("meshopt"));
        }
        self.load(buffer)?;
        let source = self.source;
        let bytes = self.buffers.get(buffer).and_then(Option::as_deref).unwrap_or_default();
        offset.checked_add(length).and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            let what = format!(
                "buffer view {view} takes {length} bytes from {offset} on, but buffer {buffer} has {}",
                bytes.len()
            );
            source.cut_off(0, what)
        })
    }

    fn load(&mut self, index: usize) -> Result<(), InputError> {
        let Some(buffer) = self.document.buffers.get(index) else {
            return Err(self.missing(format!("buffer {index}")));
        };
        if self.buffers[index].is_some() {
            return Ok(());
        }
        let taken: usize = self.buffers.iter().flatten().map(Vec::len).sum();
        if taken.saturating_add(buffer.byte_length) > MAX_MESH_BYTES {
            return Err(self.too_large("its buffers hold more than 512 MiB"));
        }
        let bytes = match &buffer.uri {
            None => {
                return Err(self
                    .fault(format!("buffer {index} has no data"), EXPORT_AGAIN)
                    .with_code(ErrorCode::MeshBuffer));
            }
            Some(uri) => match uri.strip_prefix("data:") {
                Some(data) => self.embedded(index, data)?,
                None => self.beside(index, uri)?,
            },
        };
        if bytes.len() < buffer.byte_length {
            let what = format!("buffer {index} has {} of its {} bytes", bytes.len(), buffer.byte_length);
            return Err(self.source.cut_off(0, what));
        }
        self.buffers[index] = Some(bytes);
        Ok(())
    }

    /// Decodes a data URI, given without its `data:`.
    fn embedded(&self, index: usize, data: &str) -> Result<Vec<u8>, InputError> {
        data.split_once(";base64,").and_then(|(_, text)| base64(text)).ok_or_else(|| {
            self.fault(format!("buffer {index} has a data URI that is not base64"), EXPORT_AGAIN)
        })
    }

    /// Reads the file that `uri` names, which must be in the folder of this file or below.
    fn beside(&self, index: usize, uri: &str) -> Result<Vec<u8>, InputError> {
        let outside = || {
            let what =
                format!("buffer {index} lies outside the file's folder, at {}", quote_for_message(uri));
            self.fault(what, "put it beside the file and name it without a path, or save as .glb")
                .with_code(ErrorCode::MeshBuffer)
        };
        let path = unescaped(uri).ok_or_else(outside)?;
        let plain = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        // A colon may be a URI scheme or a drive, a backslash is a separator on other systems.
        if path.is_empty() || path.contains([':', '\\', '\0']) || !Path::new(&path).components().all(plain) {
            return Err(outside());
        }
        let Some(folder) = self.folder else {
            let what = format!("buffer {index} is in another file, {}", quote_for_message(uri));
            return Err(self
                .fault(what, "open the file from the folder that holds both")
                .with_code(ErrorCode::MeshBuffer));
        };
        let full = folder.join(&path);
        if let (Ok(folder), Ok(real)) = (folder.canonicalize(), full.canonicalize())
            && !real.starts_with(&folder)
        {
            return Err(outside());
        }
        read_bytes_up_to(&full, MAX_MESH_BYTES)
    }
}

/// Byte ranges of the JSON chunk and the binary chunk of a `.glb`.
type Chunks = (std::ops::Range<usize>, Option<std::ops::Range<usize>>);

fn chunks(source: Source<'_>, bytes: &[u8]) -> Result<Chunks, InputError> {
    let word = |at: usize| {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
    };
    let cut = || source.cut_off(0, "ends inside its chunks");
    match word(4).ok_or_else(cut)? {
        2 => {}
        other => {
            let what = format!("is version {other} of binary glTF");
            return Err(source.fault(0, what, "export it as glTF 2.0").with_code(ErrorCode::GltfVersion));
        }
    }
    let length = word(8).ok_or_else(cut)? as usize;
    if length > bytes.len() {
        let what = format!("has {} of its {length} bytes", bytes.len());
        return Err(source.cut_off(0, what));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12_usize;
    while at + 8 <= length {
        let size = word(at).ok_or_else(cut)? as usize;
        let kind = word(at + 4).ok_or_else(cut)?;
        let start = at + 8;
        let end = start.checked_add(size).filter(|end| *end <= length).ok_or_else(cut)?;
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(start..end),
            BINARY_CHUNK if binary.is_none() => binary = Some(start..end),
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or_else(|| source.fault(0, "has no JSON chunk", EXPORT_AGAIN))?;
    Ok((json, binary))
}

fn parse(source: Source<'_>, json: &[u8]) -> Result<GltfDocument, InputError> {
    if json.len() > MAX_BYTES {
        let error = source.fault(0, "its JSON is larger than 64 MiB", "save it as .glb");
        return Err(error.with_code(ErrorCode::FileTooLarge));
    }
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let document: GltfDocument = serde_json::from_slice(json).map_err(|e| {
        source.fault(e.line(), format!("is not glTF 2.0 ({e})"), "check the file or export it again")
    })?;
    if !document.asset.version.starts_with("2.") {
        let what = format!("is glTF {}", quote_for_message(&document.asset.version));
        return Err(source.fault(0, what, "export it as glTF 2.0").with_code(ErrorCode::GltfVersion));
    }
    Ok(document)
}

/// Decodes percent escapes: `%41` is `A`.
fn unescaped(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let digit = |b: Option<u8>| char::from(b?).to_digit(16);
            bytes.push((16 * digit(rest.next())? + digit(rest.next())?) as u8);
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
}

/// Decodes base64, standard or URL-safe alphabet, with or without padding.
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=');
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut count) = (0_u32, 0);
    for c in text.bytes() {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_escapes_are_decoded() {
        assert_eq!(base64("TWFu").unwrap(), b"Man");
        assert_eq!(base64("TWE=").unwrap(), b"Ma");
        assert_eq!(base64("TQ==").unwrap(), b"M");
        assert!(base64("T Q").is_none());
        assert_eq!(unescaped("a%20b").unwrap(), "a b");
        assert!(unescaped("a%2").is_none());
    }
}
