//! The machine of the setup: chosen from the list, or from a machine file.

use std::path::Path;

use crate::app::App;
use crate::app::model::field_faults::FaultyField;
use crate::app::model::machine::{choose_machine, take_machine};
use crate::app::model::machine_list::{NamedMachine, with_file_name};
use crate::app::model::problem::{Problem, Topic, without_markdown};
use crate::app::views::command::Command;
use crate::app::views::panels::machine::MachineChoice;
use crate::io::InputError;
use crate::machine::MachineTool;

impl App {
    /// Does what was chosen in the list of machines.
    pub(in crate::app) fn choose_machine(&mut self, ctx: &egui::Context, choice: MachineChoice) {
        let setup = &mut self.state.document.edited.setup;
        let chosen = match choice {
            MachineChoice::None => choose_machine(setup, None),
            MachineChoice::Named(name) => choose_machine(setup, Some(&name)),
            MachineChoice::OpenFile => return self.run_command(ctx, Command::OpenMachine),
        };
        match chosen {
            Ok(()) => self.state.solve(Topic::Machine),
            Err(error) => self.report_machine(&error),
        }
    }

    /// Takes the machine of a file that was opened for it. One that is faulty leaves the machine as it is.
    pub(super) fn take_machine(&mut self, path: &Path, read: Result<MachineTool, InputError>) {
        let machine = match read {
            Ok(machine) => machine,
            Err(error) => return self.report_machine(&error),
        };
        let file = path.to_string_lossy().into_owned();
        self.state.solve(Topic::Machine);
        self.state.report_done(format!("Opened {}: {}", path.display(), machine.name));
        self.state.machines.note(&NamedMachine::of(&file, Ok(&machine)));
        // The file may have been written since it was read last.
        self.state.machines.readings += 1;
        let was_same = self.state.document.edited.setup.machine.file.as_ref() == Some(&file);
        self.state.document.step();
        take_machine(&mut self.state.document.edited.setup, file, &machine);
        if was_same {
            self.plan();
        }
    }

    /// Reports why a machine file was not taken, in one line at the field too.
    fn report_machine(&mut self, error: &InputError) {
        let problem = Problem { topic: Topic::Machine, ..Problem::from(error) };
        let what = without_markdown(&with_file_name(error));
        self.state.report_problem(problem.at_field(Some(FaultyField::MACHINE), &what));
    }
}
