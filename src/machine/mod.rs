//! From a program of the part to the motion of a five-axis machine.
//!
//! | file | holds |
//! |---|---|
//! | [`model`](MachineTool) | what a machine file says |
//! | `kinematics` | the chain of axes, forwards and backwards, for any two rotary axes |
//! | [`placement`](PlacedPart) | how the part lies on the table |
//! | `reach` | how far the tool can be tilted |
//! | [`limits`](LimitFault) | positions beyond the limits, and near the pole |
//! | `choice` | rotary positions of a whole program: branches, turns, poles |
//! | [`course`](Pose) | how far a move in joint space strays from the planned one |
//! | `clear` | links that leave the part |
//! | [`step`](MachineStep) | one block |
//! | [`motion`](machine_program) | the blocks of a program |
//! | [`calls`](ChannelCalls) | programs that are called once a channel |
//! | `table` | tools that meet the table |
//! | [`time`](section_times) | how long they take |
//! | [`clock`](MachineClock) | how long programs of one part take on one machine |
//!
//! **Program coordinates** are fixed to the part: their origin is the part's, Z is the table's normal with
//! all rotary axes at 0. **Machine coordinates** are those of the gauge point (the spindle's nose). Angles
//! are positions of rotary axes in rad; which way a positive one turns, the machine file says.

mod calls;
mod choice;
mod clear;
mod clock;
mod course;
mod fault;
mod kinematics;
mod limits;
mod model;
mod motion;
mod placement;
mod reach;
mod step;
mod table;
mod time;

pub use calls::{ChannelCalls, INSTEAD_OF_CALLS};
pub use clear::BlankSize;
pub use clock::MachineClock;
pub use course::{Pose, even_turn, mixed_angles};
pub use fault::MotionFault;
pub use kinematics::{AngleSolution, MachineBody, turned};
pub use limits::{LimitFault, NEAR_POLE_RAD};
pub use model::{
    AxisSide, LINEAR_NAMES, LinearAxis, LinkSettings, MachineTable, MachineTool, OutputKind, PartPlacement,
    RotaryAxis, TurnLink,
};
pub use motion::{INSTEAD_OF_PLANES, MachineProgram, MotionOptions, gauge_length, machine_program};
pub use placement::PlacedPart;
pub use step::{MachineStep, MoveAngles, StepMotion};
pub use time::{MachineTime, SectionTime, block_times, move_clock, section_times};
