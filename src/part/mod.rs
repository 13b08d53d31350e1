//! The part in work: impeller, channel, blank, tools and setup.

pub mod blank;
mod camber;
pub mod channel;
pub mod description;
pub mod envelope;
pub mod impeller;
pub mod probe;
pub mod setup;
mod side;
pub mod tool;
mod width;

pub use blank::Blank;
pub use channel::{Channel, ChannelPoint, Passage, Wall, WallAngle, passage_angle};
pub use description::{
    BladeDescription, CamberSpan, CurveDescription, Meridional, PartDescription, PartError,
};
pub use envelope::{BladeWall, WallEnvelope};
pub use impeller::{Blade, Flowpath, Impeller};
pub use probe::{Nearest, SideProbe};
pub use setup::{AxisPolicy, Feed, FlankScheme, FlankSetup, Machine, Setup};
pub use side::BladeSide;
pub use tool::Tool;
pub use width::PassageWidth;
