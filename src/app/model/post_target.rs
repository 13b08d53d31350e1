//! Where an NC program is to run: its machine, control and output.

use std::path::Path;

use crate::io::InputError;
use crate::io::machine_file::read_machine;
use crate::io::nc::{Dialect, read_post};
use crate::machine::OutputKind;

/// Machine, control and output of an NC program.
#[derive(Clone, Debug, PartialEq)]
pub struct PostTarget {
    /// Name of the machine, or its file.
    pub machine: String,
    /// Name of the control, or the file of its post.
    pub control: String,
    /// What the program gives; one of `outputs`.
    pub output: OutputKind,
    /// What the control takes.
    pub outputs: Vec<OutputKind>,
    /// Whether another program calls it; only where the post takes subprograms.
    pub is_subprogram: bool,
    /// Whether the post takes subprograms.
    pub takes_subprograms: bool,
    /// Grammar of the control; the ending of the file follows from it.
    pub dialect: Dialect,
    /// What the control calls the upper limit of the machine's Z, mm.
    pub retract_z: f64,
    /// Where the program retracts to, in words.
    pub retract: String,
}

impl PostTarget {
    /// The machine of that name or file, with its own control and output.
    ///
    /// # Errors
    /// When the machine or the post of its control cannot be read.
    pub fn of_machine(name: &str) -> Result<Self, InputError> {
        let machine = read_machine(Path::new(name))?;
        let post = read_post(&machine.control)?;
        let target = Self {
            machine: name.to_owned(),
            control: machine.control,
            output: machine.output,
            outputs: post.outputs().collect(),
            is_subprogram: false,
            takes_subprograms: post.takes_subprograms(),
            dialect: post.dialect,
            retract_z: machine.links.retract_z,
            retract: post.retract_words(machine.links.retract_z),
        };
        Ok(target.with_known_output())
    }

    /// The same on the machine of that name or file. What was chosen other than the machine before has it,
    /// control and output, stays; the rest is that of the machine.
    ///
    /// # Errors
    /// When the machine or the post cannot be read.
    pub fn with_machine(&self, name: &str) -> Result<Self, InputError> {
        let own = Self::of_machine(name)?;
        // A machine whose file is gone says nothing: all counts as chosen.
        let before = Self::of_machine(&self.machine).ok();
        let keeps_control = before.as_ref().is_none_or(|before| before.control != self.control);
        let keeps_output = before.as_ref().is_none_or(|before| before.output != self.output);
        let mut target = if keeps_control { own.with_control(&self.control)? } else { own };
        if keeps_output && target.outputs.contains(&self.output) {
            target.output = self.output;
        }
        target.is_subprogram = self.is_subprogram && target.takes_subprograms;
        Ok(target)
    }

    /// The same machine with the control of that name, or with the post of that file.
    ///
    /// # Errors
    /// When the post cannot be read.
    pub fn with_control(&self, name: &str) -> Result<Self, InputError> {
        let post = read_post(name)?;
        let target = Self {
            control: name.to_owned(),
            outputs: post.outputs().collect(),
            is_subprogram: self.is_subprogram && post.takes_subprograms(),
            takes_subprograms: post.takes_subprograms(),
            dialect: post.dialect,
            retract: post.retract_words(self.retract_z),
            ..self.clone()
        };
        Ok(target.with_known_output())
    }

    /// The same with an output that the control takes: its first where the chosen one is unknown to it.
    fn with_known_output(self) -> Self {
        let first = self.outputs.first().copied();
        let output = Some(self.output).filter(|output| self.outputs.contains(output)).or(first);
        Self { output: output.unwrap_or(self.output), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_that_does_not_take_the_output_gives_another() {
        let target = PostTarget::of_machine("ac-trunnion").expect("known");
        assert!(target.outputs.contains(&target.output));
        for name in crate::io::nc::built_in_posts() {
            let other = target.with_control(name).expect("known");
            assert!(other.outputs.contains(&other.output), "{name}: {other:?}");
            assert_eq!((other.control.as_str(), &other.machine), (name, &target.machine));
        }
        assert!(target.with_control("no-such-control").is_err());
        assert!(target.with_machine("no-such-machine").is_err());
        assert!(PostTarget::of_machine("no-such-machine").is_err());
    }

    #[test]
    fn another_machine_keeps_what_was_chosen() {
        let own = PostTarget::of_machine("bc-head").expect("known");
        let other = PostTarget::of_machine("bc-trunnion").expect("known");
        assert_ne!(own.control, other.control, "each has a control of its own");
        assert_eq!(own.with_machine("bc-trunnion").expect("known"), other, "nothing was chosen");
        let chosen = own.with_control("siemens").expect("known");
        let output = *chosen.outputs.iter().find(|&&output| output != own.output).expect("another");
        let chosen = PostTarget { output, is_subprogram: true, ..chosen };
        let moved = chosen.with_machine("bc-trunnion").expect("known");
        assert_eq!((moved.machine.as_str(), moved.control.as_str()), ("bc-trunnion", "siemens"));
        assert_eq!((moved.output, moved.is_subprogram), (output, true));
    }
}
