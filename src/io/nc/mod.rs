//! NC programs: posts that write them, and readers of what they write.
//!
//! A post is data (`assets/posts/*.toml`, a shop copies and changes one) over a dialect in code. The writer
//! knows words, no geometry: it gets the motion of a machine. The readers are written from the grammar of the
//! controls and share nothing with the writer but the machine's kinematics: what a program says is run
//! through the chain of axes and comes out as a [`ClProgram`](crate::toolpath::ClProgram).

mod format;
mod plane;
pub mod post;
mod read;
mod write;

pub use post::{Dialect, Post, built_in_posts, read_post, read_post_bytes};
pub use read::{AxisOverrun, NcReading, ReadContext, is_apt, read_nc};
pub use write::{NcProgram, write_nc};
