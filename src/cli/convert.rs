//! `vanecut convert`: converts parts between formats, parts to STEP and STL, parts and plans to glTF scenes,
//! and tool libraries.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::args::{ConvertArgs, MeshArgs};
use super::stdout::print_stdout;
use super::{Failure, open};
use crate::error::ErrorCode;
use crate::io::flank_file::{StoredFlank, is_flank, read_flank_bytes};
use crate::io::gltf::{CutterNodes, GltfScene, PlanScene};
use crate::io::native::write_native;
use crate::io::plan_file::{StoredPlan, read_plan_bytes};
use crate::io::replaced::check_is_no_input;
use crate::io::shop_tools::{
    LibraryFormat, MergedLibrary, fusion_for, looks_like_library, read_library, toml_for,
};
use crate::io::source::{name_of, read_bytes};
use crate::io::step;
use crate::io::stl::write_stl;
use crate::io::write::{write_all_atomically, write_atomically};
use crate::job::FIELD_CELLS;
use crate::mesh::tessellate::{Fineness, Tessellation};
use crate::palette::ColourMap;
use crate::part::{Impeller, PartDescription};
use crate::report::words::counted;
use crate::stock::surface::fitting_range;
use crate::stock::{FloorGrid, FloorSource, field_cutters, residual_field, stretches_of};

/// Output format, by extension.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PartFormat {
    Native,
    Glb,
    Gltf,
    Step,
    Stl,
}

/// Content of the input file.
enum InputContent {
    Part(Box<(PartDescription, Impeller)>),
    Plan(Box<StoredPlan>),
    Flank(Box<StoredFlank>),
}

/// Reads one file and writes another.
///
/// # Errors
/// [`Failure::input`] when an argument or the input is invalid, or the output cannot be written.
pub fn run(args: &ConvertArgs) -> Result<(), Failure> {
    if let Some(format) = library_format(&args.input, &args.output)? {
        return convert_library(args, format);
    }
    // A wrong input is named before what follows from it for the output.
    open::check_is_input(&args.input)?;
    let format = format_of(&args.output)?;
    if !(args.chord_error.is_finite() && (1e-4..=10.0).contains(&args.chord_error)) {
        let option = format!("--chord-error {}", args.chord_error);
        return Err(Failure::input(ErrorCode::Arguments, "out of range", "give 0.0001 to 10 mm").at(option));
    }
    let content = read(&args.input, &args.mesh)?;
    check_is_no_input(&args.output, &[Some(&args.input)])?;
    let (description, part) = match &content {
        InputContent::Part(part) => (&part.0, &part.1),
        InputContent::Plan(plan) => (&plan.description, &plan.part),
        InputContent::Flank(plan) => (&plan.description, &plan.part),
    };
    if format == PartFormat::Native {
        write_atomically(&args.output, write_native(description).as_bytes())?;
        return print_stdout(&format!("wrote {}: {}\n", args.output.display(), part.name));
    }
    if format == PartFormat::Step {
        let file = args.output.file_name().unwrap_or_default().to_string_lossy();
        write_atomically(&args.output, step::write_part(part, &file).as_bytes())?;
        let solids = 1 + part.blade_count * (1 + part.splitters.len());
        let text =
            format!("wrote {}: {}, {solids} solids and the shroud\n", args.output.display(), part.name);
        return print_stdout(&text);
    }
    let asked = Fineness { chord_error: args.chord_error, ..Fineness::default() };
    let shape = Tessellation::new(part, &asked);
    if format == PartFormat::Stl {
        let mesh = shape.open_wheel(part);
        write_atomically(&args.output, &write_stl(&mesh.points, &mesh.triangles, &part.name))?;
        let count = format!("{} triangles", mesh.triangles.len());
        return print_stdout(&(summary_text(args, part, &count, (&shape, &asked)) + &sides_note(part)));
    }
    let cutters = if args.plain { CutterNodes::Plain } else { CutterNodes::Instanced };
    let scene = match &content {
        InputContent::Part(_) => GltfScene::of_part(part, &shape),
        InputContent::Flank(plan) => GltfScene::of_flank(plan, &shape),
        InputContent::Plan(plan) => plan_scene(plan, &shape, cutters),
    };
    write_scene(&scene, &args.output, format)?;
    print_stdout(&summary_text(args, part, &scene_count(part, &shape), (&shape, &asked)))
}

/// Extension of a path in lower case.
fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// The format of a tool library as input; `None` for parts and plans. TOML and JSON may be either: the
/// content decides.
fn library_format(input: &Path, output: &Path) -> Result<Option<LibraryFormat>, Failure> {
    let Some(format) = LibraryFormat::of_extension(&extension(input)) else { return Ok(None) };
    let shared = matches!(format, LibraryFormat::Toml | LibraryFormat::FusionJson);
    if shared && extension(output) != "json" && !looks_like_library(format, &read_bytes(input)?) {
        return Ok(None);
    }
    Ok(Some(format))
}

/// Reads a tool library and writes it as our TOML or as Fusion JSON.
fn convert_library(args: &ConvertArgs, format: LibraryFormat) -> Result<(), Failure> {
    let is_fusion = extension(&args.output) == "json";
    if !is_fusion && extension(&args.output) != "toml" {
        let what = "a tool library is written as .toml or .json";
        return Err(Failure::input(ErrorCode::FileFormat, what, "name such a file").at_path(&args.output));
    }
    let mut library = read_library(&args.input, format)?;
    check_is_no_input(&args.output, &[Some(&args.input)])?;
    let tools = counted(library.tools.len(), "tool", "tools");
    let mut text = format!("wrote {}: {tools}\n", args.output.display());
    let merged = if is_fusion { fusion_for } else { toml_for }(&args.output, &library)?;
    write_atomically(&args.output, merged.text.as_bytes())?;
    if merged.changed + merged.kept > 0 {
        let MergedLibrary { changed, added, kept, notes, .. } = merged;
        text += &format!("into the library there: {changed} changed, {added} added, {kept} as they were\n");
        text.extend(notes.into_iter().map(|note| note + "\n"));
    }
    if is_fusion {
        for entry in library.tools.iter_mut().filter(|entry| entry.tool.core_radius() > 0.0) {
            let what = "Fusion has no insert width; it has to be given again where the library is read";
            Arc::make_mut(entry).notes.push(what.to_owned());
        }
    }
    for remark in library.remarks() {
        text += &format!("{remark}\n");
    }
    print_stdout(&text)
}

fn format_of(path: &Path) -> Result<PartFormat, Failure> {
    match extension(path).as_str() {
        "toml" => Ok(PartFormat::Native),
        "glb" => Ok(PartFormat::Glb),
        "gltf" => Ok(PartFormat::Gltf),
        "step" | "stp" => Ok(PartFormat::Step),
        "stl" => Ok(PartFormat::Stl),
        other => {
            let what = if other.is_empty() {
                "has no extension, so its format is unknown".to_owned()
            } else {
                format!("`.{other}` is not an output format")
            };
            let help = "give a .toml, .step, .stl, .glb or .gltf file";
            Err(Failure::input(ErrorCode::FileFormat, what, help).at_path(path))
        }
    }
}

fn read(path: &Path, mesh: &MeshArgs) -> Result<InputContent, Failure> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return Ok(InputContent::Part(Box::new(open::part(path, mesh)?)));
    }
    let (name, bytes) = (name_of(path), read_bytes(path)?);
    if is_flank(&bytes) {
        return Ok(InputContent::Flank(Box::new(read_flank_bytes(&name, &bytes)?)));
    }
    Ok(InputContent::Plan(Box::new(read_plan_bytes(&name, &bytes)?)))
}

/// Scene of a plan. The residual stock is recomputed, as by `vanecut render`.
fn plan_scene(stored: &StoredPlan, shape: &Tessellation, cutters: CutterNodes) -> GltfScene {
    let StoredPlan { part, setup, plan, .. } = stored;
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let stretches = stretches_of(&plan.sections);
    let source = FloorSource::of_setup(&workpiece, setup, &stretches);
    let grid = FloorGrid::new(&source, FIELD_CELLS);
    let field = residual_field(&grid, &field_cutters(plan));
    GltfScene::of_plan(&PlanScene {
        part,
        shape,
        setup,
        plan,
        grid: &grid,
        heights: &field.heights,
        range: fitting_range(&grid, &field.heights),
        map: ColourMap::default(),
        cutters,
    })
}

fn write_scene(scene: &GltfScene, path: &Path, format: PartFormat) -> Result<(), Failure> {
    if format == PartFormat::Glb {
        return Ok(write_atomically(path, &scene.glb())?);
    }
    let binary = path.with_extension("bin");
    // Beside an existing .gltf file the buffer is from an earlier run; otherwise it may belong to another
    // file.
    if binary.exists() && !path.exists() {
        let what = "exists already and would be overwritten by the buffer";
        let help = "name another file, or a .glb";
        return Err(Failure::input(ErrorCode::FileNotWritten, what, help).at_path(&binary));
    }
    let (text, bytes) = scene.gltf(&uri_of(&binary));
    let files: [(PathBuf, &[u8]); 2] = [(binary, &bytes), (path.to_owned(), text.as_bytes())];
    Ok(write_all_atomically(&files)?)
}

/// The file name of `path` as a relative URI, percent-encoded.
fn uri_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-._~".contains(&b);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

/// Number of triangles of a scene, which has each kind of blade once and its copies as nodes.
fn scene_count(part: &Impeller, shape: &Tessellation) -> String {
    let copies = part.blade_count
        * (shape.main.triangle_count() + shape.splitters.iter().map(|s| s.triangle_count()).sum::<usize>());
    let all = shape.hub.triangle_count() + shape.shroud.triangle_count() + copies;
    format!("{} triangles, {all} with all blades", shape.triangle_count())
}

/// What was written, with this `count` of triangles, and where it is coarser than was asked for.
fn summary_text(
    args: &ConvertArgs,
    part: &Impeller,
    count: &str,
    (shape, asked): (&Tessellation, &Fineness),
) -> String {
    let mut text = format!(
        "wrote {}: {}, {count}, within {:.4} mm\n",
        args.output.display(),
        part.name,
        shape.chord_error
    );
    if shape.chord_error > asked.chord_error {
        text += &format!("{} mm would take more than {} triangles\n", asked.chord_error, asked.max_triangles);
    }
    text
}

/// A line about the sides of blades in a format that does not name them: where it is read, the wrap of the
/// blades decides, which need not agree with how `part` names its sides.
fn sides_note(part: &Impeller) -> String {
    let rotation = part.rotation();
    format!(
        "its pressure sides lead when it turns {rotation}, seen from the inlet; STL does not say so: with \
         --rotation {} its sides keep their names\n",
        rotation.name()
    )
}
