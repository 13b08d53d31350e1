//! Writing a setup, and the files it names as seen from where it is saved.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::VERSION;
use super::edits::write_edits;
use crate::io::InputError;
use crate::io::blank_file::blank_name;
use crate::io::machine_file::{is_built_in, read_machine};
use crate::io::table::{degrees_text, quoted};
use crate::io::tool_file::{WrittenRates, write_tools};
use crate::part::{BlankFile, BlankShape};
use crate::setup::{ChannelSetup, ClearanceSetup, CutDirection, Goal, SectionKind, SemiFinishing, Setup};

/// Writes a setup file. It reads back equal: angles that were read from degrees exactly, other angles to the
/// last bit of an f64. A blank from a file is written with its outline, so that the text does not depend on
/// that file; see [`write_setup_beside`]. Rates of tools that are not given are left out.
pub fn write_setup(setup: &Setup) -> String {
    let mut out = String::new();
    // `write!` to a `String` cannot fail.
    let _ = write_to(&mut out, setup, true, WrittenRates::Given);
    out
}

/// As [`write_setup`], with all rates of the tools: a plan keeps those that it was made with.
pub fn write_full_setup(setup: &Setup) -> String {
    let mut out = String::new();
    let _ = write_to(&mut out, setup, true, WrittenRates::All);
    out
}

/// Writes a setup file that is to be saved at `path`: as [`write_setup`], but a blank from a file is written
/// as the path of that file, relative to the setup where it is in the same folder or below.
pub fn write_setup_beside(setup: &Setup, path: &Path) -> String {
    let mut out = String::new();
    let _ = write_to(&mut out, &beside(setup, path), false, WrittenRates::Given);
    out
}

/// The file of a machine that the setup at `path` names: absolute, so that it is found from anywhere.
/// Machines that come with the program keep their names.
///
/// # Errors
/// When the file is there and is not that of a machine. One that is not there is needed for times alone.
pub fn locate_machine(setup: &mut Setup, path: &Path) -> Result<(), InputError> {
    let Some(name) = setup.machine.file.as_deref().filter(|name| !is_built_in(name)) else { return Ok(()) };
    let file = path.parent().unwrap_or(Path::new("")).join(name);
    let absolute = std::path::absolute(&file).unwrap_or_else(|_| file.clone());
    setup.machine.file = Some(absolute.to_string_lossy().into_owned());
    if file.exists() { read_machine(&file).map(drop) } else { Ok(()) }
}

/// `setup` with the files of its blank and its machine named as seen from a file at `path`.
pub(in crate::io) fn beside(setup: &Setup, path: &Path) -> Setup {
    let mut setup = setup.clone();
    if let Some(file) = setup.machine.file.as_deref().map(Path::new).filter(|file| file.is_absolute()) {
        setup.machine.file = Some(relative(file, path).to_string_lossy().into_owned());
    }
    if let BlankShape::File(file) = &setup.allowances.blank {
        let name = relative(&file.path, path).to_string_lossy().into_owned();
        setup.allowances.blank = BlankShape::File(Arc::new(BlankFile { name, ..BlankFile::clone(file) }));
    }
    setup
}

/// `file` relative to the folder of `path`, if it is in that folder or below; else absolute.
pub(in crate::io) fn relative(file: &Path, path: &Path) -> PathBuf {
    let (Some(whole), Some(own)) = (std::path::absolute(file).ok(), std::path::absolute(path).ok()) else {
        return file.to_owned();
    };
    let beside = own.parent().and_then(|folder| whole.strip_prefix(folder).ok().map(Path::to_owned));
    beside.unwrap_or(whole)
}

fn write_to(out: &mut String, setup: &Setup, with_outline: bool, rates: WrittenRates) -> std::fmt::Result {
    writeln!(out, "version = {VERSION}")?;
    if let Some(part) = &setup.part {
        writeln!(out, "part = {}", quoted(part))?;
    }
    let stock = &setup.allowances;
    writeln!(out, "\n[stock]")?;
    writeln!(out, "hub_allowance = {:?}", stock.hub_allowance)?;
    writeln!(out, "blade_allowance = {:?}", stock.blade_allowance)?;
    writeln!(out, "safety_distance = {:?}", stock.safety_distance)?;
    writeln!(out, "inlet_extension = {:?}", stock.inlet_extension)?;
    if stock.blank != BlankShape::Edges {
        writeln!(out, "blank = {}", quoted(blank_name(&stock.blank)))?;
    }
    if let BlankShape::File(file) = &stock.blank
        && with_outline
    {
        let points = file.outline.points();
        let rows = points.iter().chain(points.first()).map(|p| format!("[{:?}, {:?}]", p.r, p.z));
        writeln!(out, "blank_outline = [{}]", rows.collect::<Vec<_>>().join(", "))?;
    }
    if let Some(material) = &stock.material {
        writeln!(out, "material = {}", quoted(material))?;
    }
    let ClearanceSetup { shank, holder } = setup.clearances;
    writeln!(out, "\n[clearance]\nshank = {shank:?}\nholder = {holder:?}")?;
    write_tools(out, &setup.tools, rates)?;
    let plunge = &setup.plunge;
    let axis = plunge.axis.name();
    writeln!(out, "\n[plunge]\naxis = \"{axis}\"")?;
    if let Some(step) = plunge.step {
        writeln!(out, "step = {step:?}")?;
    }
    if let Some(stepover) = plunge.stepover {
        writeln!(out, "stepover = {stepover:?}")?;
    }
    writeln!(out, "wall_scallop = {:?}", plunge.wall_scallop)?;
    writeln!(out, "max_axis_change = {}", degrees_text(plunge.max_axis_change_rad))?;
    writeln!(out, "max_tilt = {}", degrees_text(plunge.max_tilt_rad))?;
    match plunge.goal {
        Goal::Stock { max_time_min: None } => {}
        Goal::Stock { max_time_min: Some(minutes) } => {
            writeln!(out, "goal = \"stock\"\nmax_time = {minutes:?}")?;
        }
        Goal::Time { max_stock } => writeln!(out, "goal = \"time\"\nmax_stock = {max_stock:?}")?,
        Goal::Balance => writeln!(out, "goal = \"balance\"")?,
        Goal::Total { finishing } => {
            writeln!(out, "goal = \"total\"")?;
            match finishing {
                SemiFinishing::Rate { mm3_per_min } => writeln!(out, "finish_rate = {mm3_per_min:?}")?,
                SemiFinishing::Passes { depth, pass_time_min } => {
                    writeln!(out, "finish_depth = {depth:?}\nfinish_pass_time = {pass_time_min:?}")?;
                }
            }
        }
    }
    if let Some(lead_out) = plunge.lead_out {
        writeln!(out, "lead_out = {lead_out:?}")?;
    }
    if let Some(peck) = plunge.peck {
        writeln!(out, "peck = {peck:?}")?;
    }
    if !plunge.adapt_feed {
        writeln!(out, "adapt_feed = false")?;
    }
    if plunge.rapid_approach {
        writeln!(out, "rapid_approach = true")?;
    }
    if !plunge.rest {
        writeln!(out, "rest = false")?;
    }
    for section in &plunge.sections {
        writeln!(out, "\n[[plunge.section]]\ntool = {}", section.tool)?;
        writeln!(out, "from = {:?}\nto = {:?}", section.from, section.to)?;
        match section.cut_direction {
            Some(CutDirection::OutletToInlet) => writeln!(out, "cutting_direction = \"outlet_to_inlet\"")?,
            Some(CutDirection::InletToOutlet) => writeln!(out, "cutting_direction = \"inlet_to_outlet\"")?,
            None => {}
        }
        match section.kind {
            SectionKind::Rows => {}
            SectionKind::Rest => writeln!(out, "rest = true")?,
            SectionKind::Opening => writeln!(out, "opening = true")?,
        }
    }
    write_edits(out, &plunge.edits)?;
    writeln!(out, "\n[flank]")?;
    if let Some(tool) = setup.flank.tool {
        writeln!(out, "tool = {tool}")?;
    }
    writeln!(out, "scheme = \"{}\"", setup.flank.strategy.name())?;
    writeln!(out, "layer_depth = {:?}", setup.flank.layer_depth)?;
    writeln!(out, "scallop_height = {:?}", setup.flank.scallop_height)?;
    if let Some(extension) = setup.flank.lead_in_out {
        writeln!(out, "extension = {extension:?}")?;
    }
    let flank = &setup.flank;
    for (key, feed) in [
        ("feed", flank.feed_mm_per_min),
        ("slot_feed", flank.slot_feed_mm_per_min),
        ("wall_feed", flank.wall_feed_mm_per_min),
        ("ramp_feed", flank.ramp_feed_mm_per_min),
        ("approach_feed", flank.approach_feed_mm_per_min),
    ] {
        if let Some(feed) = feed {
            writeln!(out, "{key} = {feed:?}")?;
        }
    }
    if setup.channels != ChannelSetup::default() {
        let ChannelSetup { order, sequence } = setup.channels;
        writeln!(out, "\n[channels]\norder = \"{}\"\nsequence = \"{}\"", order.name(), sequence.name())?;
    }
    if setup.machine != Setup::default().machine {
        writeln!(out, "\n[machine]")?;
        if let Some(file) = &setup.machine.file {
            writeln!(out, "file = {}", quoted(file))?;
        }
        writeln!(out, "max_axis_tilt = {}", degrees_text(setup.machine.max_axis_tilt_rad))?;
    }
    Ok(())
}
