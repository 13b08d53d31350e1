//! Studies: from a study file to the merged table, by the command line and by the library.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod files;
#[cfg(feature = "parquet")]
mod parquet;
mod rounds;
