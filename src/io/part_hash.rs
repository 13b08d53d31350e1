//! Hashes of a part, by which files say which one they belong to: equal for all files that describe the same
//! part.

use super::hash::{FNV_START, fnv1a};
use super::native::write_native;
use super::sha256::sha256_hex;
use crate::part::PartDescription;

/// The hashes of a part, over its description in the native format.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartHash {
    /// FNV-1a, as in project files.
    pub fnv1a: u64,
    /// SHA-256 in hexadecimal digits, as in the results of studies.
    pub sha256: String,
}

impl PartHash {
    /// The hashes of `part`.
    pub fn from_part(part: &PartDescription) -> Self {
        let text = write_native(part);
        Self { fnv1a: fnv1a(FNV_START, text.bytes()), sha256: sha256_hex(text.as_bytes()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_tells_parts_apart() {
        let read = |text: &str| crate::io::read_part_bytes("p.toml", text.as_bytes(), "toml").expect("reads");
        let text = include_str!("../../assets/parts/pump6.toml");
        let (a, b) = (read(text), read(&format!("# a remark\n{text}")));
        assert_eq!(PartHash::from_part(&a), PartHash::from_part(&b), "remarks do not count");
        let mut other = a.clone();
        other.blade_count += 1;
        let (a, other) = (PartHash::from_part(&a), PartHash::from_part(&other));
        assert!(a.fnv1a != other.fnv1a && a.sha256 != other.sha256);
    }
}
