//! The part in work: impeller, channel, blank, tools and setup.

mod camber;
pub mod channel;
pub mod description;
pub mod impeller;
pub mod setup;
pub mod probe;
mod side;
pub mod tool;

pub use channel::{Channel, ChannelPoint, Passage, Wall};
pub use description::{
    BladeDescription, CamberSpan, CurveDescription, Meridional, PartDescription, PartError,
};
pub use impeller::{Blade, Flowpath, Impeller};
pub use probe::{Nearest, SideProbe};
pub use setup::{AxisPolicy, Feed, Setup};
pub use side::BladeSide;
pub use tool::Tool;
