//! `vanecut render`.

use glam::UVec2;

use super::args::RenderArgs;
use super::render_words::{SOLID, parse_range, parse_size};
use super::{Failure, open, plan, render_flank, render_solid};
use crate::drawing::{scene_of_part, show_plan};
use crate::error::{ErrorCode, UserError};
use crate::gpu::image::draw_png;
use crate::gpu::{CutterFilter, FloorColours, Gpu, GpuError, Renderer, SceneOptions, Theme, View};
use crate::io::flank_file::{is_flank, read_flank_bytes};
use crate::io::plan_file::read_plan_bytes;
use crate::io::replaced::check_is_no_input;
use crate::io::source::{name_of, read_bytes};
use crate::io::write::write_atomically;
use crate::job::FIELD_CELLS;
use crate::monitor::Monitor;
use crate::part::Impeller;
use crate::plunge::PlungePlan;
use crate::stock::surface::fitting_range;
use crate::stock::{FloorGrid, FloorSource, ResidualField, field_cutters, residual_field, stretches_of};
use crate::toolpath::ClProgram;

impl From<GpuError> for Failure {
    fn from(error: GpuError) -> Self {
        Self::of_work(error)
    }
}

/// Draws one picture.
///
/// # Errors
/// [`Failure::input`] when an argument or the input is invalid or the file cannot be written,
/// [`Failure::work`] when drawing fails.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    check_is_no_input(&args.output, &[Some(&args.source)])?;
    let size = parse_size(&args.size)?;
    let view: View = args.view.parse().map_err(|error: UserError| Failure::from(error).at("--view"))?;
    let is_plan = args.source.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let plan_bytes = if is_plan { Some(read_bytes(&args.source)?) } else { None };
    if let Some(bytes) = plan_bytes.as_deref().filter(|bytes| is_flank(bytes)) {
        let plan = read_flank_bytes(&name_of(&args.source), bytes)?;
        write_atomically(&args.output, &render_flank::picture(args, &plan, view, size)?)?;
        return Ok(());
    }
    let as_solid = args.show.as_deref() == Some(SOLID);
    let colours: FloorColours = match &args.show {
        Some(_) if as_solid => FloorColours::Residual,
        Some(word) => word.parse().map_err(|error: UserError| Failure::from(error).at("--show"))?,
        None if is_plan => FloorColours::Residual,
        None => FloorColours::Plain,
    };
    let mut options = SceneOptions::for_colours(colours);
    options.up_to = args.at;
    options.show_shroud = args.shroud;
    options.transparent = args.transparent;
    options.theme = if args.dark { Theme::Dark } else { Theme::Light };
    let range = args.range.as_deref().map(parse_range).transpose()?;
    if let Some(word) = &args.cutters {
        options.show_cutters = match word.as_str() {
            "all" => CutterFilter::All,
            "faulty" => CutterFilter::Faulty,
            "none" => CutterFilter::Hidden,
            other => {
                return Err(Failure::input(ErrorCode::UnknownName, "not known", "give all, faulty or none")
                    .at(format!("--cutters {other}")));
            }
        };
    }
    let (part, stored, program) = if let Some(bytes) = &plan_bytes {
        let stored = read_plan_bytes(&name_of(&args.source), bytes)?;
        let program = as_solid.then(|| stored.program(&Monitor::default())).transpose()?;
        (stored.part, Some((stored.setup, stored.plan)), program)
    } else {
        let (_, part) = open::part(&args.source, &args.mesh)?;
        // A part is drawn without a plan unless the options need one; it is then planned with the defaults.
        if colours == FloorColours::Plain && args.at.is_none() && args.cutters.is_none() {
            (part, None, None)
        } else {
            let setup = open::setup(None, &args.source, &part)?;
            let outcome = plan::plan_with_progress(part, &setup, setup.setup.plunge.axis, false)?;
            let part = Impeller::clone(&outcome.workpiece.part);
            let program = as_solid.then(|| ClProgram::of_plan(&part.name, &outcome.after.plan));
            (part, Some((outcome.setup, outcome.after.plan)), program)
        }
    };
    let png = match (&stored, &program) {
        (Some((setup, _)), Some(program)) => {
            let count = plunges_as_moves(args.at, program);
            render_solid::picture(args, &part, setup, program, count, view, size)?
        }
        (None, _) => picture(&part, None, range, view, options, size, args.legend)?,
        (Some((setup, plan)), None) => {
            let shown = args.at.unwrap_or(plan.positions.len()).min(plan.positions.len());
            let workpiece = setup.allowances.workpiece_of(part.clone());
            let stretches = stretches_of(&plan.sections);
            let source = FloorSource::of_setup(&workpiece, setup, &stretches);
            let grid = FloorGrid::new(&source, FIELD_CELLS);
            let field = residual_field(&grid, &field_cutters(plan)[..shown]);
            picture(&part, Some((plan, &grid, &field)), range, view, options, size, args.legend)?
        }
    };
    write_atomically(&args.output, &png)?;
    Ok(())
}

/// Number of moves of the first `plunges`, or of all.
fn plunges_as_moves(plunges: Option<usize>, program: &ClProgram) -> usize {
    let starts = program.plunge_starts();
    plunges.and_then(|plunges| starts.get(plunges).copied()).unwrap_or(program.moves.len())
}

type Planned<'a> = Option<(&'a PlungePlan, &'a FloorGrid, &'a ResidualField)>;

fn picture(
    part: &Impeller,
    planned: Planned,
    range: Option<(f32, f32)>,
    view: View,
    options: SceneOptions,
    size: UVec2,
    legend: bool,
) -> Result<Vec<u8>, Failure> {
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    let mut scene = scene_of_part(&gpu, part);
    let mut options = options;
    if let Some((plan, grid, field)) = planned {
        options.range_mm = range.unwrap_or_else(|| fitting_range(grid, &field.heights));
        show_plan(&mut scene, &gpu, plan, grid, &field.heights);
    }
    draw_png(&gpu, &mut renderer, &scene, view, &options, size, legend).map_err(Failure::of_work)
}
