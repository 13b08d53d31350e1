//! The machines that the lists of the window offer: those of the program, and the machine files that setups
//! of this session name.

use std::path::Path;
use std::sync::LazyLock;

use super::problem::without_markdown;
use crate::io::InputError;
use crate::io::machine_file::{built_in_names, is_built_in, read_machine};
use crate::machine::MachineTool;

/// Largest tilts that the machines of the program reach, radians.
static BUILT_IN_TILTS: LazyLock<Vec<(&str, f64)>> = LazyLock::new(|| {
    let tilt_of =
        |name| read_machine(Path::new(name)).ok().map(|machine| (name, machine.max_axis_tilt_rad()));
    built_in_names().filter_map(tilt_of).collect()
});

/// A machine file, and what was read from it.
#[derive(Clone, Debug)]
pub struct NamedMachine {
    /// The file, as setups name it.
    pub file: String,
    /// Name of the machine, or why it is not known.
    pub name: Result<String, InputError>,
    /// Largest angle between tool axis and part axis that it reaches, radians; `None` where it is not known.
    pub max_axis_tilt_rad: Option<f64>,
}

impl NamedMachine {
    /// What was read from `file`.
    pub fn of(file: &str, read: Result<&MachineTool, InputError>) -> Self {
        let max_axis_tilt_rad = read.as_ref().ok().map(|machine| machine.max_axis_tilt_rad());
        Self { file: file.to_owned(), name: read.map(|machine| machine.name.clone()), max_axis_tilt_rad }
    }
}

/// Machine files of the session, in the order in which they were first read.
#[derive(Clone, Debug, Default)]
pub struct MachineList {
    own: Vec<NamedMachine>,
    /// How often the machine file is read anew: when one is opened, and when a plan is calculated on demand.
    pub readings: u32,
}

impl MachineList {
    /// Keeps what was read last from a machine file.
    pub fn note(&mut self, read: &NamedMachine) {
        match self.own.iter_mut().find(|known| known.file == read.file) {
            Some(known) => known.clone_from(read),
            None => self.own.push(read.clone()),
        }
    }

    /// Files and names of all machines: files that were read, those of the program, and `chosen` in any case.
    pub fn entries(&self, chosen: Option<&str>) -> Vec<String> {
        let is_read = |own: &&NamedMachine| own.name.is_ok() || Some(own.file.as_str()) == chosen;
        let own = self.own.iter().filter(is_read).map(|own| own.file.clone());
        let known: Vec<String> = own.chain(built_in_names().map(str::to_owned)).collect();
        let missing = chosen.filter(|chosen| !known.iter().any(|known| known == chosen));
        missing.map(str::to_owned).into_iter().chain(known).collect()
    }

    /// Label of a machine in lists: its name, after its file name where it is read from a machine file, as
    /// copies of a machine share a name.
    pub fn label_of(&self, machine: &str) -> String {
        let file = Path::new(machine).file_name();
        let file = file.map_or_else(|| machine.into(), |file| file.to_string_lossy());
        match self.own.iter().find(|own| own.file == machine).map(|own| &own.name) {
            Some(Ok(name)) if !is_built_in(machine) => format!("{file} ({name})"),
            _ => file.into_owned(),
        }
    }

    /// Largest tilt that the machine of that name or file reaches, radians; `None` where it is not known.
    pub fn max_axis_tilt_rad(&self, machine: &str) -> Option<f64> {
        match self.own.iter().find(|own| own.file == machine) {
            Some(own) => own.max_axis_tilt_rad,
            None => BUILT_IN_TILTS.iter().find(|(name, _)| *name == machine).map(|(_, tilt)| *tilt),
        }
    }

    /// Why the machine of that file is not known; `None` where it is, and before it is read.
    pub fn fault_of(&self, machine: &str) -> Option<&InputError> {
        self.own.iter().find(|own| own.file == machine)?.name.as_ref().err()
    }
}

/// What is wrong with a machine file, and the line in it; the folders are left out.
pub fn with_file_name(error: &InputError) -> String {
    let file = Path::new(&error.file).file_name().unwrap_or_default().to_string_lossy();
    let named = InputError { file: file.into_owned(), ..error.clone() };
    match named.place().as_str() {
        "" => error.message.clone(),
        place => format!("{place}: {}", error.message),
    }
}

/// What is wrong with a machine file, and what to do, in plain text.
pub fn fault_words(error: &InputError) -> (String, String) {
    (without_markdown(&with_file_name(error)), without_markdown(&error.help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorCode;

    #[test]
    fn files_stand_before_the_machines_of_the_program_and_faulty_ones_only_while_chosen() {
        let mut list = MachineList::default();
        let of_program: Vec<String> = built_in_names().map(str::to_owned).collect();
        assert_eq!(list.entries(Some(of_program[1].as_str())), of_program, "none stands twice");
        let file = |file: &str, name| NamedMachine { file: file.to_owned(), name, max_axis_tilt_rad: None };
        let fault = InputError::new(ErrorCode::FileUnreadable, "b.toml", 0, "is gone".to_owned(), "find it");
        list.note(&file("/m/a.toml", Ok("Mill 5".to_owned())));
        list.note(&file("/m/b.toml", Err(fault)));
        assert_eq!(list.label_of("/m/a.toml"), "a.toml (Mill 5)");
        assert_eq!(
            (list.label_of("/m/b.toml"), list.label_of("bc-head")),
            ("b.toml".into(), "bc-head".into())
        );
        assert_eq!(list.entries(None)[0], "/m/a.toml");
        assert_eq!(list.entries(None).len(), 1 + of_program.len());
        assert_eq!(list.entries(Some("/m/b.toml")).len(), 2 + of_program.len());
        assert_eq!(list.entries(Some("/m/c.toml"))[0], "/m/c.toml", "before it is read");
        assert!(list.fault_of("/m/a.toml").is_none() && list.fault_of("/m/b.toml").is_some());
        list.note(&file("/m/b.toml", Ok("Mill 6".to_owned())));
        assert!(list.fault_of("/m/b.toml").is_none(), "it is there again");
    }
}
