//! The one JSON member of a ZIP archive: stored or deflated, neither encrypted nor ZIP64.

use super::json::MAX_LIBRARY_BYTES;
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::Source;

/// Largest number of members that are looked at.
const MAX_MEMBERS: usize = 10_000;
/// Signatures and sizes of the end record, of an entry of the central directory, and of a member.
const END: (&[u8], usize) = (b"PK\x05\x06", 22);
const ENTRY: (&[u8], usize) = (b"PK\x01\x02", 46);
const MEMBER: (&[u8], usize) = (b"PK\x03\x04", 30);

/// Bytes of the first member whose name ends in `.json`.
///
/// # Errors
/// When the bytes are not such an archive.
pub fn json_member(name: &str, bytes: &[u8]) -> Result<Vec<u8>, InputError> {
    let fault = |what: &str, help: &str| Source::new(name, ErrorCode::ToolFile).fault(0, what, help);
    let broken = |what: &str| fault(what, "export the library again");
    let u16_at = |at: usize| Some(usize::from(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?)));
    let u32_at = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    // The end record is last, before a comment of at most 65,535 bytes.
    let first = bytes.len().saturating_sub(END.1 + 0xffff);
    let end = (first..=bytes.len().saturating_sub(END.1)).rev().find(|&at| bytes[at..].starts_with(END.0));
    let end =
        end.ok_or_else(|| broken("is not a ZIP archive, or is cut off").with_code(ErrorCode::FileCutOff))?;
    let lost = || broken("the directory of the archive is damaged");
    let count = u16_at(end + 10).ok_or_else(lost)?;
    let mut at = u32_at(end + 16).ok_or_else(lost)?;
    for _ in 0..count.min(MAX_MEMBERS) {
        if !bytes.get(at..).is_some_and(|rest| rest.starts_with(ENTRY.0)) {
            return Err(lost());
        }
        let field = |offset: usize| u16_at(at + offset).ok_or_else(lost);
        let size = |offset: usize| u32_at(at + offset).ok_or_else(lost);
        let (flags, method) = (field(8)?, field(10)?);
        let (crc, packed, unpacked, local) = (size(16)?, size(20)?, size(24)?, size(42)?);
        let [name_length, extra, comment] = [field(28)?, field(30)?, field(32)?];
        let file = bytes.get(at + ENTRY.1..at + ENTRY.1 + name_length).ok_or_else(lost)?;
        at += ENTRY.1 + name_length + extra + comment;
        if !file.to_ascii_lowercase().ends_with(b".json") {
            continue;
        }
        if flags & 1 != 0 {
            return Err(fault("the library in the archive is encrypted", "export it without a password"));
        }
        if packed.max(unpacked).max(local) == u32::MAX as usize || unpacked > MAX_LIBRARY_BYTES {
            return Err(fault("the library in the archive is larger than 256 MiB", "split the library")
                .with_code(ErrorCode::FileTooLarge));
        }
        if !bytes.get(local..).is_some_and(|rest| rest.starts_with(MEMBER.0)) {
            return Err(lost());
        }
        let skip = [26, 28].map(|offset| u16_at(local + offset));
        let [Some(name_length), Some(extra)] = skip else { return Err(lost()) };
        let from = local + MEMBER.1 + name_length + extra;
        let data = bytes
            .get(from..from + packed)
            .ok_or_else(|| broken("the archive is cut off").with_code(ErrorCode::FileCutOff))?;
        let json = match method {
            0 => data.to_vec(),
            8 => miniz_oxide::inflate::decompress_to_vec_with_limit(data, unpacked)
                .map_err(|_| broken("the library in the archive is damaged"))?,
            _ => return Err(fault("the archive is packed by an unknown method", "pack it with deflate")),
        };
        if json.len() != unpacked || crc32(&json) as usize != crc {
            return Err(broken("the library in the archive is damaged: its checksum differs"));
        }
        return Ok(json);
    }
    Err(fault("the archive holds no .json file", "give a tool library of Fusion"))
}

/// CRC-32 (IEEE 802.3), by a table of the polynomial's remainders.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    let table: [u32; 256] = std::array::from_fn(|i| {
        (0..8).fold(i as u32, |crc, _| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 })
    });
    !bytes.iter().fold(!0, |crc, &byte| table[((crc ^ u32::from(byte)) & 0xff) as usize] ^ (crc >> 8))
}
