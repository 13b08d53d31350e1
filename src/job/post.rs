//! The posting job that window and command line share: from a program to NC code of a control, with its
//! times.

use crate::error::{ErrorCode, UserError};
use crate::io::nc::{NcProgram, Post, write_nc};
use crate::machine::{
    BlankSize, ChannelCalls, INSTEAD_OF_CALLS, MachineProgram, MachineTime, MachineTool, MotionFault,
    MotionOptions, OutputKind, PartPlacement, PlacedPart, SectionTime, machine_program, section_times,
};
use crate::monitor::Monitor;
use crate::toolpath::ClProgram;

/// Where a program is to run, and in which words it is written.
#[derive(Clone, Debug)]
pub struct PostRequest {
    /// The machine.
    pub machine: MachineTool,
    /// The post of its control.
    pub post: Post,
    /// What the program gives; one of [`Post::outputs`].
    pub output: OutputKind,
    /// Whether the inlet of the part points to +Z in the part frame.
    pub inlet_up: bool,
    /// Extent of the blank; absent: what the moves say.
    pub blank: Option<BlankSize>,
    /// How often another program calls this one; absent: not at all.
    pub calls: Option<ChannelCalls>,
}

/// NC code, and the motion that it makes.
#[derive(Clone, Debug)]
pub struct PostedProgram {
    /// The motion of the machine.
    pub motion: MachineProgram,
    /// The code.
    pub written: NcProgram,
    /// Times by section, in cutting order.
    pub times: Vec<SectionTime>,
    /// How the part lies on the table.
    pub placed: PlacedPart,
}

impl PostedProgram {
    /// The largest error of the tip, in joint space and by rounding, mm.
    pub fn tip_error(&self) -> f64 {
        self.motion.tip_error + self.written.rounding_error
    }

    /// Time of the program with its tool changes, s.
    pub fn time_s(&self) -> f64 {
        MachineTime::of_sections(&self.times).total_s
    }
}

/// Why a program is not posted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PostFault {
    /// The machine cannot run it.
    #[error("{0}")]
    Motion(MotionFault),
    /// It cannot be written for the control.
    #[error("{0}")]
    Words(UserError),
}

/// Posts `program`: chooses rotary positions and links over the whole of it and writes it in the words of the
/// control.
///
/// # Errors
/// [`PostFault`] when the machine cannot run the program, the control cannot take it, or on a cancel.
pub fn post_program(
    program: &ClProgram,
    request: &PostRequest,
    monitor: &Monitor,
) -> Result<PostedProgram, PostFault> {
    let PostRequest { machine: given, post, output, inlet_up, blank, calls } = request;
    let called = calls.map(|calls| given.for_calls(calls, *output)).transpose().map_err(PostFault::Words)?;
    let machine = called.as_ref().unwrap_or(given);
    let placed = PlacedPart::new(&machine.part, *inlet_up);
    let mut options = MotionOptions::new(*output, post.format.angle_decimals);
    options.blank = *blank;
    let run = |machine: &MachineTool| machine_program(machine, &placed, program, &options, monitor);
    let motion =
        run(machine).map_err(|fault| match called.as_ref().map(|called| called.rotary[0].limits) {
            // Alone the program would run.
            Some(Some((low, high))) if given.rotary[0].limits != Some((low, high)) && run(given).is_ok() => {
                PostFault::Words(range_too_small(given.rotary[0].letter, high - low, &fault))
            }
            _ => PostFault::Motion(fault),
        })?;
    for turn in calls.iter().flat_map(|calls| given.unlike_calls(*calls)) {
        let part = PartPlacement { clock_rad: machine.part.clock_rad + turn, ..machine.part.clone() };
        let placed = PlacedPart::new(&part, *inlet_up);
        machine_program(machine, &placed, program, &options, monitor).map_err(PostFault::Motion)?;
    }
    // Who sets up the part, or writes the calling program, reads it on the control.
    let calls = calls.map_or_else(Vec::new, ChannelCalls::comments);
    let remarks = [placed.comments(), calls].concat();
    let written = write_nc(program, machine, &motion, post, *output, &remarks).map_err(PostFault::Words)?;
    let times = section_times(machine, program, &motion);
    Ok(PostedProgram { motion, written, times, placed })
}

/// The fault of a called program that the machine could run by itself, but not within `range` (rad): what the
/// other calls leave of the range of the axis that turns the part.
fn range_too_small(letter: char, range: f64, fault: &MotionFault) -> UserError {
    let fault = fault.explained();
    let what = format!(
        "the calls leave only {:.0}° of the range of {letter} for each of them: {}",
        range.to_degrees(),
        fault.message
    );
    UserError::new(ErrorCode::AxisLimits, what, INSTEAD_OF_CALLS)
}
