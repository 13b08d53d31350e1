//! A cutter against part and stock: distances, drop-cutter depth, retracts, rapid links, contact of the core.
//!
//! | file | answers |
//! |---|---|
//! | [`approach`] | how far down a tool may come in rapid, over what earlier plunges left |
//! | [`assembly_move`] | where along a move shank and holder have to be looked at |
//! | [`assembly`] | how far shank and holder are from the finished part and the blank |
//! | [`assembly_path`] | how far they are over a move |
//! | [`drop_cutter`] | how deep it goes along its axis until it touches a surface of revolution |
//! | [`retract`] | from which height above its tip a tool is clear of the blank |
//! | [`link`] | how far a rapid from one position to another stays clear of the blank |
//! | [`channel_link`] | the rapid from channel to channel, outside the blank |
//! | `stick_out` | with which overhang a holder that is in the way would be clear |
//! | [`contact`] | where the core of a plunge meets stock that earlier plunges left |

pub mod approach;
pub mod assembly;
pub mod assembly_move;
pub mod assembly_path;
pub mod channel_link;
pub mod contact;
pub mod drop_cutter;
pub mod link;
pub mod retract;
mod stick_out;
