//! Pictures of a flank plan.

use glam::UVec2;

use super::args::RenderArgs;
use super::render_words::SOLID;
use super::{Failure, render_solid};
use crate::drawing::flank::{FlankColours, toolpath_lines, wall_deviations, wall_scale_end};
use crate::drawing::scene_of_part;
use crate::error::{ErrorCode, UserError};
use crate::gpu::image::draw_png;
use crate::gpu::{ColourMap, FloorColours, Gpu, Renderer, SceneOptions, Theme, View};
use crate::io::flank_file::StoredFlank;
use crate::monitor::Monitor;

/// PNG file of a flank plan: passes coloured by layer or region, moves by feed rate (`--show feed`), or walls
/// by the residual stock (`--show walls`), or the stock as a solid (`--show solid`). `--at` limits the number
/// of moves.
///
/// # Errors
/// [`Failure::input`] for an unknown `--show`, [`Failure::work`] when drawing fails.
pub fn picture(args: &RenderArgs, plan: &StoredFlank, view: View, size: UVec2) -> Result<Vec<u8>, Failure> {
    if args.show.as_deref() == Some(SOLID) {
        let program = plan.program(&Monitor::default())?;
        let missing = || Failure::input(ErrorCode::PlanFile, "the flank plan has no tool", "plan it again");
        let program = program.ok_or_else(missing)?;
        let count = args.at.unwrap_or(program.moves.len());
        return render_solid::picture(args, &plan.part, &plan.setup, &program, count, view, size);
    }
    let colours: FlankColours = match &args.show {
        Some(word) => word.parse().map_err(|error: UserError| Failure::from(error).at("--show"))?,
        None => FlankColours::default(),
    };
    if args.legend && colours != FlankColours::Walls {
        eprintln!("vanecut: --legend: only `--show walls` of a flank plan has a colour scale");
    }
    let walls = (colours == FlankColours::Walls).then(|| wall_deviations(&plan.part, &plan.walls));
    let (shown_on, map, most) = match &walls {
        Some((_, most)) => (FloorColours::Walls, ColourMap::Difference, wall_scale_end(*most)),
        None => (FloorColours::Plain, ColourMap::default(), 1.0),
    };
    let options = SceneOptions {
        map,
        range_mm: (-most, most),
        // The blades would hide the coloured walls that lie on them.
        show_blades: walls.is_none(),
        show_shroud: args.shroud,
        transparent: args.transparent,
        theme: if args.dark { Theme::Dark } else { Theme::Light },
        ..SceneOptions::for_colours(shown_on)
    };
    let shown = args.at.unwrap_or(plan.moves.len()).min(plan.moves.len());
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    let mut scene = scene_of_part(&gpu, &plan.part);
    if let Some((mesh, _)) = walls {
        scene.set_values(&gpu, mesh);
    }
    let rapids = colours == FlankColours::Feed;
    let lines = toolpath_lines(&plan.passes, &plan.moves[..shown], plan.layers, colours, rapids);
    scene.set_paths(&gpu, &lines);
    draw_png(&gpu, &mut renderer, &scene, view, &options, size, args.legend).map_err(Failure::of_work)
}
