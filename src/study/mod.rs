//! Studies: many plans over parts and settings, on one machine or many.
//!
//! A study file names parts, a base setup and axes of variation ([`StudyFile`]); every combination is a run
//! ([`RunList`]). A run is named by a hash of its complete input, and its result is one file, written whole
//! ([`RunResult`]): a study goes on where it was cut off, without locks and without a server. Shards
//! ([`Shard`]) are done by independent processes ([`execute`]); [`merge`] puts the results into one table,
//! the same byte for byte whoever computed them, and [`pareto`] picks the plans that no other plan beats.

mod csv;
mod evaluate;
mod execute;
mod file;
pub mod merge;
pub mod pareto;
#[cfg(feature = "parquet")]
pub mod parquet;
mod result;
mod results;
mod runs;
mod setting;
mod shard;

pub use execute::{Execution, Tally, execute};
pub use file::{MAX_RUNS, StudyAxis, StudyFile};
pub use result::{MACHINE_TIME, RunResult, RunStatus};
pub use results::StudyResults;
pub use runs::{RESULT_VERSION, Run, RunList, StudyPart};
pub use shard::{Lookup, Shard};
