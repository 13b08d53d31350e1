//! The workpiece: a part with what every planner and every check needs of it, prepared once.

use std::sync::Arc;

use super::blank::Blank;
use super::channel::Channel;
use super::finished::FinishedPart;
use super::impeller::Impeller;

/// A part, the blank that it is cut from, and its channel with the surfaces around it. A setup makes it, by
/// [`workpiece_of`](crate::setup::AllowanceSetup::workpiece_of).
#[derive(Debug)]
pub struct Workpiece {
    /// The part.
    pub part: Arc<Impeller>,
    /// Its channel 1.
    pub channel: Channel,
    /// The blank before the first cut.
    pub blank: Blank,
    /// The finished surfaces around the channel.
    pub finished: FinishedPart,
}

impl Workpiece {
    /// `part`, cut from `blank`.
    pub fn new(part: impl Into<Arc<Impeller>>, blank: Blank) -> Self {
        let part = part.into();
        let channel = Channel::from_part(&part);
        let finished = FinishedPart::new(&part, &channel.sides);
        Self { part, channel, blank, finished }
    }
}
