//! The name of the setup's machine, which a machine file gives.

use std::path::Path;

use super::Repaint;
use crate::app::model::machine_list::NamedMachine;
use crate::app::tasks::latest::Latest;
use crate::io::machine_file::{is_built_in, read_machine};
use crate::setup::Setup;

/// Reads machine files in the background: one may lie on a slow network.
pub(in crate::app) struct MachineNames(Latest<(String, u32), NamedMachine>);

impl MachineNames {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        let read = |(file, _): &(String, u32)| {
            let machine = read_machine(Path::new(file));
            NamedMachine::of(file, machine.as_ref().map_err(Clone::clone))
        };
        Self(Latest::new("machine name", repaint, read))
    }

    /// Requests the name of the machine file of `setup`, anew for each of its `readings`; returns it once it
    /// is read. `None` without one.
    pub(in crate::app) fn follow(&mut self, setup: &Setup, readings: u32) -> Option<&NamedMachine> {
        let file = setup.machine.file.clone().filter(|file| !is_built_in(file));
        self.0.request(file.map(|file| (file, readings)));
        self.0.answer().map(|(_, named)| named)
    }

    /// Whether a file is being read.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }
}
