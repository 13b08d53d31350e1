//! Pictures of the stock as a solid.

use std::sync::Arc;

use glam::UVec2;

use super::Failure;
use super::args::RenderArgs;
use super::render_words::parse_range;
use super::watch::run_with_progress;
use crate::drawing::scene_of_part;
use crate::drawing::solid::solid_mesh;
use crate::gpu::image::draw_png;
use crate::gpu::mesh::Paint;
use crate::gpu::{CutterFilter, FloorColours, Gpu, Renderer, SceneOptions, Theme, View};
use crate::part::Impeller;
use crate::setup::Setup;
use crate::stock::excess::Excess;
use crate::stock::solid::{SolidBlank, SolidProgram, SolidStock, SpanEnd, StockSurface};
use crate::toolpath::ClProgram;

/// Upper end of the colour scale unless one is given, in allowances of the hub.
const RANGE_IN_ALLOWANCES: f64 = 8.0;

/// PNG file of the blank of `part` after the first `count` moves of `program`, coloured by the distance of
/// what is cut to the finished part.
///
/// # Errors
/// [`Failure::input`] when the program cannot be simulated or the scale is invalid, [`Failure::work`] when
/// cancelled or when drawing fails.
pub fn picture(
    args: &RenderArgs,
    part: &Impeller,
    setup: &Setup,
    program: &ClProgram,
    count: usize,
    view: View,
    size: UVec2,
) -> Result<Vec<u8>, Failure> {
    let allowances = &setup.allowances;
    let low = allowances.hub_allowance;
    let fitted = (low as f32, (RANGE_IN_ALLOWANCES * low).max(1.0) as f32);
    let range_mm = args.range.as_deref().map(parse_range).transpose()?.unwrap_or(fitted);
    let moves = SolidProgram::new(program, setup).map_err(|fault| Failure::from(fault.error))?;
    let workpiece = allowances.workpiece_of(part.clone());
    let blank = SolidBlank::from_part(part, &workpiece.blank);
    let spacing = blank.default_spacing();
    let mut stock = SolidStock::new(&blank, spacing).map_err(Failure::of_work)?;
    run_with_progress("cutting", |monitor| stock.make_moves(&moves.tools, moves.first(count), monitor))
        .map_err(Failure::of_work)?;
    let surface = StockSurface::from_stock(&stock);
    let paint = |cut_by: u32| if cut_by == SpanEnd::BLANK { Paint::UNCUT } else { Paint::BY_VALUE };
    let excess = Excess::new(&workpiece).in_all_channels();
    let mesh =
        run_with_progress("drawing", |monitor| solid_mesh(&surface, spacing, Some(&excess), paint, monitor))
            .map_err(Failure::of_work)?;
    let options = SceneOptions {
        show_solid: true,
        show_cutters: CutterFilter::Hidden,
        range_mm,
        show_shroud: args.shroud,
        transparent: args.transparent,
        theme: if args.dark { Theme::Dark } else { Theme::Light },
        ..SceneOptions::for_colours(FloorColours::Residual)
    };
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    let mut scene = scene_of_part(&gpu, part);
    scene.set_solid(&gpu, Some(Arc::new(mesh)));
    draw_png(&gpu, &mut renderer, &scene, view, &options, size, args.legend).map_err(Failure::of_work)
}
