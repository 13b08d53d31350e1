//! `vanecut stock`.

use std::path::Path;
use std::time::Instant;

use serde_json::{Map, Value, json};

use super::args::StockArgs;
use super::output::{self, number};
use super::stdout::{MAX_SHOWN, print_stdout};
use super::watch::run_with_progress;
use super::{Failure, open};
use crate::error::ErrorCode;
use crate::io::apt::{as_written, read_apt_bytes};
use crate::io::blank_file::{is_stl, read_blank};
use crate::io::flank_file::{is_flank, read_flank_bytes};
use crate::io::gltf::GltfScene;
use crate::io::plan_file::read_plan_bytes;
use crate::io::replaced::check_is_no_input;
use crate::io::stl::write_stl;
use crate::io::write_atomically;
use crate::monitor::Monitor;
use crate::part::{BlankShape, Impeller};
use crate::setup::Setup;
use crate::stock::solid::{Contact, SolidBlank, SolidError, SolidProgram, SolidStock, StockSurface};
use crate::toolpath::ClProgram;
use crate::verify::unjudged_tools;

/// Output format, by extension.
#[derive(Clone, Copy, PartialEq, Eq)]
enum StockFormat {
    Stl,
    Glb,
}

/// Simulates a program, writes the stock and prints the figures.
///
/// # Errors
/// [`Failure::input`] when an argument or an input is invalid, or the output cannot be written;
/// [`Failure::work`] when cancelled.
pub fn run(args: &StockArgs) -> Result<(), Failure> {
    let started = Instant::now();
    let format = format_of(&args.output)?;
    let (setup, blank) = (args.setup.as_deref(), args.blank.as_deref());
    check_is_no_input(&args.output, &[Some(&args.part), Some(&args.program), setup, blank])?;
    let (_, part) = open::part(&args.part, &args.mesh)?;
    if args.program == Path::new("-") && args.setup.as_deref() == Some(Path::new("-")) {
        return Err(open::both_from_standard_input());
    }
    let opened = open::setup(args.setup.as_deref(), &args.part, &part)?;
    let (name, program, planned) = read_program(&args.program)?;
    let setup = planned.filter(|_| args.setup.is_none()).unwrap_or(opened.setup);
    let simulated = SolidProgram::new(&program, &setup)
        .map_err(|fault| Failure::from(fault.error).at_line(&name, fault.line))?;
    let made = args.at.unwrap_or(simulated.count);
    if made > simulated.count {
        let what = format!("the program has {} moves", simulated.count);
        let help = format!("give 0 to {}", simulated.count);
        return Err(Failure::input(ErrorCode::Arguments, what, help).at(format!("--at {made}")));
    }
    let blank = blank_of(args.blank.as_deref(), &part, &setup)?;
    let spacing = args.spacing.unwrap_or_else(|| blank.default_spacing());
    let failed = |error: SolidError| match error {
        SolidError::Cancelled(cancelled) => cancelled.into(),
        SolidError::Empty => Failure::from(error.explained()).at("--blank"),
        other => Failure::from(other.explained()).at("--spacing"),
    };
    let mut stock = SolidStock::new(&blank, spacing).map_err(failed)?;
    let contacts = run_with_progress("cutting", |monitor| {
        stock.make_moves(&simulated.tools, simulated.first(made), monitor)
    })
    .map_err(failed)?;
    let surface = StockSurface::from_stock(&stock);
    let (whole, volume) = (blank.volume(), surface.volume());
    // The surface of an uncut blank may enclose a few mm³ more than the blank.
    let removed = (whole - volume).max(0.0);
    let bytes = match format {
        StockFormat::Stl => write_stl(&surface.points, &surface.triangles, &part.name),
        StockFormat::Glb => GltfScene::of_stock(&part.name, &surface, volume).glb(),
    };
    write_atomically(&args.output, &bytes)?;
    let collisions = Collisions { name: &name, program: &program, contacts: &contacts };
    let notes = unjudged_tools(&program, &setup);
    if args.json {
        let mut map = Map::new();
        map.insert("volume".into(), number(volume));
        map.insert("volume_removed".into(), number(removed));
        map.insert("spacing".into(), number(spacing));
        map.insert("moves".into(), json!(made));
        map.insert("collisions".into(), collisions.json());
        map.insert("notes".into(), json!(notes.as_slice()));
        map.insert("elapsed".into(), number(started.elapsed().as_secs_f64()));
        return print_stdout(&format!("{}\n", Value::Object(map)));
    }
    let mut text = format!(
        "wrote {}: {} triangles\n{made} of {} moves: {:.1} cm³ of {:.1} cm³ removed, {:.1} cm³ left; spacing \
         {spacing:.3} mm\n",
        args.output.display(),
        surface.triangles.len(),
        simulated.count,
        1e-3 * removed,
        1e-3 * whole,
        1e-3 * volume,
    );
    text += &output::notes_text(notes.as_slice());
    text += &collisions.text();
    print_stdout(&text)
}

fn format_of(path: &Path) -> Result<StockFormat, Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "stl" => Ok(StockFormat::Stl),
        "glb" => Ok(StockFormat::Glb),
        _ => {
            let what = "is not a format of solids";
            Err(Failure::input(ErrorCode::FileFormat, what, "give a .stl or .glb file").at_path(path))
        }
    }
}

/// The program in an APT file, a plan.json or a flank.json; of a plan with its setup. Lines of a plan's moves
/// are those of the APT file that `plan` or `flank` writes beside it.
fn read_program(path: &Path) -> Result<(String, ClProgram, Option<Setup>), Failure> {
    let (name, bytes) = open::named_bytes(path)?;
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        let program = read_apt_bytes(&name, &bytes)?;
        return Ok((name, program, None));
    }
    let (program, setup) = if is_flank(&bytes) {
        let stored = read_flank_bytes(&name, &bytes)?;
        let Some(program) = stored.program(&Monitor::default())? else {
            return Err(Failure::input(ErrorCode::PlanFile, "has no tool", "plan it again").at(name));
        };
        (program, stored.setup)
    } else {
        let stored = read_plan_bytes(&name, &bytes)?;
        (stored.program(&Monitor::default())?, stored.setup)
    };
    if program.moves.is_empty() {
        return Err(Failure::input(ErrorCode::NothingMoves, "has no moves", "plan it again").at(name));
    }
    let program = as_written(&name, &program)?;
    Ok((name, program, Some(setup)))
}

/// The blank of the setup, or that by the word or the file given for it.
fn blank_of(given: Option<&Path>, part: &Impeller, setup: &Setup) -> Result<SolidBlank, Failure> {
    let mut allowances = setup.allowances.clone();
    if let Some(path) = given {
        let name = path.to_string_lossy();
        allowances.blank = read_blank(&name, Path::new(""))?.ok_or_else(|| {
            let help = "give edges, turned, or a file (.stl, or lines of r z)";
            Failure::input(ErrorCode::UnknownName, "there is no such file", help)
                .at(format!("--blank {name}"))
        })?;
    }
    if let BlankShape::File(file) = &allowances.blank
        && given.is_none()
        && file.mesh.is_none()
        && is_stl(&file.path)
    {
        eprintln!(
            "vanecut: the plan holds only the turned envelope of its blank {}; give --blank with the file \
             for its exact shape",
            file.name
        );
    }
    // A blank that does not enclose the part is of use here: that of a later operation.
    Ok(SolidBlank::from_part(part, &allowances.blank_of(part)))
}

/// Collisions with the lines of the program.
struct Collisions<'a> {
    name: &'a str,
    program: &'a ClProgram,
    contacts: &'a [Contact],
}

impl Collisions<'_> {
    fn line(&self, contact: &Contact) -> usize {
        self.program.moves.get(contact.number as usize).map_or(0, |step| step.line)
    }

    fn json(&self) -> Value {
        self.contacts
            .iter()
            .map(|contact| {
                json!({
                    "line": self.line(contact),
                    "part": contact.part,
                    "depth": number(contact.depth),
                    "point": contact.point.iter().map(|x| number(*x)).collect::<Vec<_>>(),
                })
            })
            .collect()
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for contact in self.contacts.iter().take(MAX_SHOWN) {
            let p = contact.point;
            text += &format!(
                "{}:{}: the {} meets stock, {:.2} mm deep, at {:.2}, {:.2}, {:.2}\n",
                self.name,
                self.line(contact),
                contact.part.name(),
                contact.depth,
                p.x,
                p.y,
                p.z
            );
        }
        match self.contacts.len() {
            0 => text += "no collision with stock\n",
            count if count > MAX_SHOWN => text += &format!("… and {} more collisions\n", count - MAX_SHOWN),
            _ => {}
        }
        text
    }
}
