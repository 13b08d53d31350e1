//! `vanecut convert`: converts parts between formats, and parts and plans to glTF scenes.

use std::path::{Path, PathBuf};

use super::args::{ConvertArgs, MeshArgs};
use super::plan::FIELD_CELLS;
use super::{Failure, open, say};
use crate::formats::flank_file::{StoredFlank, is_flank, read_flank_bytes};
use crate::formats::gltf::{CutterNodes, GltfScene, PlanScene};
use crate::formats::native::write_native;
use crate::formats::plan_file::{StoredPlan, read_plan_bytes};
use crate::formats::source::{name_of, read_bytes};
use crate::formats::write::{write_together, write_whole};
use crate::mesh::tessellate::{Fineness, Tessellation};
use crate::palette::ColourMap;
use crate::part::{Blank, Channel, Impeller, PartDescription};
use crate::residual::surface::fitting_range;
use crate::residual::{FloorGrid, FloorSource, cutters_of, residual_field, stretches_of};

/// Output format, by extension.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Native,
    Glb,
    Gltf,
}

/// Content of the input file.
enum Content {
    Part(Box<(PartDescription, Impeller)>),
    Plan(Box<StoredPlan>),
    Flank(Box<StoredFlank>),
}

/// Reads one file and writes another.
///
/// # Errors
/// [`Failure::Input`] when an argument or the input is invalid, or the output cannot be written.
pub fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let format = format_of(&args.output)?;
    if !(args.chord_error.is_finite() && (1e-4..=10.0).contains(&args.chord_error)) {
        return Err(Failure::Input(format!(
            "--chord-error {}: out of range; give 0.0001 to 10 mm",
            args.chord_error
        )));
    }
    let content = read(&args.input, &args.mesh)?;
    if same_file(&args.input, &args.output) {
        return Err(Failure::at(&name_of(&args.output), 0, "is the input file; name another file to write"));
    }
    let (description, part) = match &content {
        Content::Part(part) => (&part.0, &part.1),
        Content::Plan(plan) => (&plan.description, &plan.part),
        Content::Flank(plan) => (&plan.description, &plan.part),
    };
    if format == Format::Native {
        write_whole(&args.output, write_native(description).as_bytes())?;
        return say(&format!("wrote {}: {}\n", args.output.display(), part.name));
    }
    let asked = Fineness { chord_error: args.chord_error, ..Fineness::default() };
    let shape = Tessellation::new(part, &asked);
    let cutters = if args.plain { CutterNodes::Plain } else { CutterNodes::Instanced };
    let scene = match &content {
        Content::Part(_) => GltfScene::of_part(part, &shape),
        Content::Flank(plan) => GltfScene::of_flank(plan, &shape),
        Content::Plan(plan) => plan_scene(plan, &shape, cutters),
    };
    write_scene(&scene, &args.output, format)?;
    say(&told(args, part, &shape, &asked))
}

fn format_of(path: &Path) -> Result<Format, Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "toml" => Ok(Format::Native),
        "glb" => Ok(Format::Glb),
        "gltf" => Ok(Format::Gltf),
        other => {
            let what = if other.is_empty() {
                "has no extension, so its format is unknown".to_owned()
            } else {
                format!("`.{other}` is not an output format")
            };
            Err(Failure::at(&name_of(path), 0, &format!("{what}; give a .toml, .glb or .gltf file")))
        }
    }
}

fn read(path: &Path, mesh: &MeshArgs) -> Result<Content, Failure> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return Ok(Content::Part(Box::new(open::part(path, mesh)?)));
    }
    let (name, bytes) = (name_of(path), read_bytes(path)?);
    if is_flank(&bytes) {
        return Ok(Content::Flank(Box::new(read_flank_bytes(&name, &bytes)?)));
    }
    Ok(Content::Plan(Box::new(read_plan_bytes(&name, &bytes)?)))
}

fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// Scene of a plan. The residual stock is recomputed, as by `vanecut render`.
fn plan_scene(stored: &StoredPlan, shape: &Tessellation, cutters: CutterNodes) -> GltfScene {
    let StoredPlan { part, setup, plan, .. } = stored;
    let channel = Channel::of(part);
    let blank = Blank::of(part, setup.stock.inlet_extension);
    let source = FloorSource {
        part,
        channel: &channel,
        blank: &blank,
        stock: &setup.stock,
        cutters: &stretches_of(plan),
    };
    let grid = FloorGrid::new(&source, FIELD_CELLS);
    let field = residual_field(&grid, &cutters_of(plan));
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

fn write_scene(scene: &GltfScene, path: &Path, format: Format) -> Result<(), Failure> {
    if format == Format::Glb {
        return Ok(write_whole(path, &scene.glb())?);
    }
    let binary = path.with_extension("bin");
    // Beside an existing .gltf file the buffer is from an earlier run; otherwise it may belong to another
    // file.
    if binary.exists() && !path.exists() {
        return Err(Failure::at(
            &name_of(&binary),
            0,
            "exists already and would be overwritten by the buffer; name another file, or a .glb",
        ));
    }
    let (text, bytes) = scene.gltf(&uri_of(&binary));
    let files: [(PathBuf, &[u8]); 2] = [(binary, &bytes), (path.to_owned(), text.as_bytes())];
    Ok(write_together(&files)?)
}

/// The file name of `path` as a relative URI, percent-encoded.
fn uri_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-._~".contains(&b);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

fn told(args: &ConvertArgs, part: &Impeller, shape: &Tessellation, asked: &Fineness) -> String {
    let copies = part.blade_count
        * (shape.main.triangles() + shape.splitters.iter().map(|s| s.triangles()).sum::<usize>());
    let all = shape.hub.triangles() + shape.shroud.triangles() + copies;
    let mut text = format!(
        "wrote {}: {}, {} triangles, {all} with all blades, within {:.4} mm\n",
        args.output.display(),
        part.name,
        shape.triangles(),
        shape.chord_error
    );
    if shape.chord_error > asked.chord_error {
        text +=
            &format!("{} mm would take more than {} triangles\n", asked.chord_error, asked.most_triangles);
    }
    text
}
