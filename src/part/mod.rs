//! The part in work: impeller, channel, blank, tools and setup.

pub mod description;
pub mod impeller;
pub mod setup;
pub mod tool;

pub use description::{
    BladeDescription, CamberSpan, CurveDescription, Meridional, PartDescription, PartError,
};
pub use impeller::{Blade, BladeSide, Flowpath, Impeller};
pub use setup::{AxisPolicy, Feed, Setup};
pub use tool::Tool;
