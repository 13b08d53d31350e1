//! The part: impeller, channel, blank, and the workpiece that holds them with the finished surfaces.

mod blade;
pub mod blank;
mod blank_envelope;
mod blank_mesh;
pub mod blank_shape;
pub mod body;
pub mod bounded_passage;
mod camber;
pub mod channel;
mod closed_blade;
mod closed_surface;
mod curve_order;
pub mod description;
mod end_face;
pub mod envelope;
mod finished;
mod flowpath;
pub mod impeller;
pub mod meridional_outline;
mod nose;
mod order;
pub mod probe;
mod rotation;
mod side;
mod width;
mod workpiece;

pub use blade::Blade;
pub use blank::Blank;
pub use blank_mesh::BlankMesh;
pub use blank_shape::{BlankFile, BlankShape};
pub use bounded_passage::{BoundedPassage, splitter_name};
pub use channel::{Channel, ChannelPoint, Division, Passage, SplitterWalls, Wall, WallAngle, passage_angle};
pub use closed_blade::ClosedBlade;
pub use description::{
    BladeDescription, CamberSpan, CurveDescription, Meridional, PartDescription, PartError,
};
pub use envelope::{BladeWall, WallEnvelope};
pub use finished::{ENDLESS, FinishedPart};
pub use flowpath::Flowpath;
pub use impeller::Impeller;
pub use meridional_outline::{MeridionalOutline, OutlineFault};
pub use probe::{NearestOnSide, SideProbe};
pub use rotation::Rotation;
pub use side::BladeSide;
pub use width::PassageWidth;
pub use workpiece::Workpiece;
