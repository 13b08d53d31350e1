//! Cutter-location programs in APT (ISO 4343): a writer and a tolerant reader.

mod read;
mod transform;
mod words;
mod write;

pub use read::{read_apt, read_apt_bytes};
pub(in crate::io) use write::section_words;
pub use write::write_apt;

#[cfg(test)]
mod tests;
