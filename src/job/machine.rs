//! The machine of a setup, and the clock of its plans.

use crate::io::machine_file::machine_of_setup;
use crate::machine::{MachineClock, MachineTool};
use crate::part::Workpiece;
use crate::setup::{Setup, SetupFault};

/// The machine of `setup`; `None` where it names none, and where its file is gone, as of a plan that was sent
/// without it: that is planned all the same, with times without a machine.
///
/// # Errors
/// When the file is there and is not that of a machine.
pub(super) fn machine_of(setup: &Setup) -> Result<Option<MachineTool>, SetupFault> {
    machine_of_setup(setup).map_err(|error| {
        let what = format!("the machine file {}: {}", error.place(), error.message);
        SetupFault::new(error.code, what, error.help)
    })
}

/// The clock of plans with `setup` on its machine, if that is known.
///
/// # Errors
/// The errors of [`machine_of`].
pub(super) fn clock_of(setup: &Setup, workpiece: &Workpiece) -> Result<Option<MachineClock>, SetupFault> {
    let on = |machine| MachineClock::new(machine, workpiece, &setup.allowances);
    Ok(machine_of(setup)?.map(on))
}
