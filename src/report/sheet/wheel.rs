//! All channels of a wheel: their order, how often tools are changed for them, and their time.

use crate::machine::{MachineTime, MachineTool};
use crate::report::html::escaped;
use crate::setup::{ChannelOrder, ChannelSetup};
use crate::toolpath::TOOL_CHANGE_S;

/// What takes the time of a wheel.
pub(super) enum WheelTime<'a> {
    /// The machine, with tool changes.
    OnMachine(&'a MachineTool),
    /// Feed rates and rapids alone, as that machine cannot run the program.
    Refused(&'a MachineTool),
    /// Feed rates and rapids alone.
    Estimated,
}

/// All channels of a wheel, as a sheet tells them.
pub(super) struct WheelLine<'a> {
    pub channels: usize,
    pub order: ChannelSetup,
    pub tool_changes: usize,
    /// Time of all channels, s; tool changes are in it where it is that of a machine.
    pub time_s: f64,
    pub of: WheelTime<'a>,
}

/// A program of one channel that another program calls once for each.
pub(super) struct CalledProgram {
    /// How often it loads a tool.
    pub tool_loads: usize,
    /// How often tools are loaded in all calls.
    pub tool_changes: usize,
    /// Its estimated time, s.
    pub estimate_s: f64,
    /// Its time on the machine.
    pub machine_time: Option<MachineTime>,
}

impl WheelLine<'_> {
    /// The same where the program is called for each channel: every call finishes its channel, whatever the
    /// order of the setup.
    pub fn in_calls(self, program: &CalledProgram) -> Self {
        let channels = self.channels as f64;
        let time_s = match program.machine_time {
            Some(MachineTime { total_s, tool_changes_s }) => {
                let one_change_s = tool_changes_s / program.tool_loads.max(1) as f64;
                (total_s - tool_changes_s) * channels + one_change_s * program.tool_changes as f64
            }
            None => program.estimate_s * channels,
        };
        let order = ChannelSetup { order: ChannelOrder::ChannelByChannel, ..self.order };
        Self { order, tool_changes: program.tool_changes, time_s, ..self }
    }

    /// In words, to follow those on one channel.
    pub fn words(&self) -> String {
        let changes_s = TOOL_CHANGE_S * self.tool_changes as f64;
        let (time_s, what) = match self.of {
            WheelTime::OnMachine(machine) => (self.time_s, on_machine_text(machine)),
            WheelTime::Refused(machine) => (
                self.time_s + changes_s,
                format!("accelerations left out: {} cannot run the program", escaped(&machine.name)),
            ),
            WheelTime::Estimated => (self.time_s + changes_s, "accelerations left out".to_owned()),
        };
        format!(
            "the wheel, {} channels and {}, {}, about {:.0} min ({what})",
            self.channels,
            match self.tool_changes {
                1 => "one tool change".to_owned(),
                count => format!("{count} tool changes"),
            },
            self.order.words(),
            time_s / 60.0,
        )
    }
}

/// What the times of a program on its machine count.
fn on_machine_text(machine: &MachineTool) -> String {
    format!("on {} with accelerations", escaped(&machine.name))
}
