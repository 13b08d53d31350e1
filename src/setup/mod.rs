//! The setup: allowances and clearances, tools, machine, and the settings of the planners.
//!
//! | file | holds |
//! |---|---|
//! | [`settings`](Setup) | the setup with its defaults, which follow the size of the wheel |
//! | [`plunge_settings`](PlungeSetup), [`flank_settings`](FlankSetup) | what the planners are asked for |
//! | [`channel_settings`](ChannelSetup) | the order of a program of several channels |
//! | [`tool`] | cutters and their cutting data |
//! | [`cutting_data`] | cutting data by material, feed rate by engagement |
//! | [`assembly`](ToolAssembly) | shank and holder of a tool |
//! | [`edits`](PlungeEdit) | edits of single plunges and rows |
//! | [`fault`](SetupFault) | the error of a setup that a part cannot be planned with |

mod assembly;
mod channel_settings;
pub mod cutting_data;
pub mod edits;
mod fault;
mod flank_settings;
mod plunge_settings;
mod settings;
pub mod tool;

pub use assembly::{AssemblyPart, AssemblySegment, ClearanceSetup, MissingRates, ToolAssembly};
pub use channel_settings::{ChannelOrder, ChannelSequence, ChannelSetup};
pub use edits::{PlungeChange, PlungeEdit, PlungeMove, PlungePose};
pub use fault::{SetupFault, SetupPlace, check_taper, round_down, round_up};
pub use flank_settings::{FlankFeedRates, FlankSetup, FlankStrategy};
pub use plunge_settings::{
    AxisPolicy, CutDirection, Goal, PlungeSetup, SectionKind, SectionSetup, SemiFinishing,
};
pub use settings::{AllowanceSetup, Machine, Setup, TILT_TOLERANCE, falls_short, tool_of};
pub use tool::{OutlineKind, OutlinePiece, Tool};
