//! What a plan was made from: the part and the setup in a `plan.json` or `flank.json`, without the plan.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Deserialize;

use super::InputError;
use super::source::{Source, name_of, read_bytes};
use super::stored::{StoredInputs, check_version, read_inputs};
use super::tool_library::flank_cutters;
use super::{flank_file, plan_file};
use crate::error::ErrorCode;
use crate::part::PartDescription;
use crate::setup::{AxisPolicy, Setup};

/// Bytes at the beginning of a plan file that hold its first key.
const HEAD: usize = 64;

/// Part and setup of a plan.
#[derive(Clone, Debug)]
pub struct PlanInputs {
    /// The part.
    pub description: PartDescription,
    /// The setup, with every default filled in.
    pub setup: Setup,
    /// Whether it is a flank plan.
    pub is_flank: bool,
}

/// The keys of both kinds of plan files that are read here.
#[derive(Deserialize)]
struct InputsRecord {
    vanecut_plan: Option<u32>,
    vanecut_flank: Option<u32>,
    part: String,
    setup: String,
    /// Of a plunge plan.
    policy: Option<AxisPolicy>,
}

/// Whether a file is a plan, by its ending and its first key.
pub fn is_plan_file(path: &Path) -> bool {
    let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let Some(mut file) = is_json.then(|| File::open(path).ok()).flatten() else { return false };
    let mut head = [0; HEAD];
    let mut filled = 0;
    while let Ok(count @ 1..) = file.read(&mut head[filled..]) {
        filled += count;
    }
    let head = String::from_utf8_lossy(&head[..filled]);
    ["\"vanecut_plan\"", "\"vanecut_flank\""].iter().any(|key| head.contains(key))
}

/// Reads part and setup of a plan file.
///
/// # Errors
/// When the file cannot be read, is not a plan file of a supported version, or contains an invalid part or
/// setup.
pub fn read_plan_inputs(path: &Path) -> Result<PlanInputs, InputError> {
    let (name, bytes) = (name_of(path), read_bytes(path)?);
    let help = "give a plan.json or flank.json that `vanecut` wrote";
    let source = Source::new(&name, ErrorCode::PlanFile);
    let file: InputsRecord =
        serde_json::from_slice(&bytes).map_err(|error| source.not_json(&error, "a plan file", help))?;
    for (version, known) in
        [(file.vanecut_plan, plan_file::VERSION), (file.vanecut_flank, flank_file::VERSION)]
    {
        check_version(&name, "plan file", version.unwrap_or(0), known)?;
    }
    let StoredInputs { description, mut setup, .. } =
        read_inputs(&name, &file.part, &file.setup, file.policy)?;
    let is_flank = file.vanecut_flank.is_some();
    if is_flank {
        leave_out_chosen_tool(&mut setup);
    }
    Ok(PlanInputs { description, setup, is_flank })
}

/// Takes out of the setup of a flank plan the tool that was chosen for it: where a setup has no tools, the
/// file has that one alone, and plunges would be planned with it. Its number names it among the tools of the
/// program. Plans of former versions have rates for steel, whatever the material.
fn leave_out_chosen_tool(setup: &mut Setup) {
    let rated = setup.allowances.tools_for_material(flank_cutters());
    let mut known = flank_cutters().iter().chain(rated.iter());
    if let [tool] = &setup.tools[..]
        && setup.flank.tool == Some(tool.number)
        && known.any(|own| own.with_given_rates() == *tool)
    {
        setup.tools.clear();
    }
}
