//! Pictures of a flank plan.

use glam::UVec2;

use super::Failure;
use super::args::RenderArgs;
use super::render::draw;
use crate::formats::flank_file::StoredFlank;
use crate::gpu::flank::{FlankColours, lines};
use crate::gpu::{FloorColours, Gpu, Renderer, Scene, SceneOptions, Theme, View};

/// The curves of a flank plan by layer or region, or its moves by the way they are made (`--show feed`), as a PNG file in
/// memory. `--at` shows that many moves only.
pub fn picture(args: &RenderArgs, plan: &StoredFlank, view: View, size: UVec2) -> Result<Vec<u8>, Failure> {
    let colours: FlankColours = match &args.show {
        Some(word) => word.parse().map_err(|e| Failure::Input(format!("--show: {e}")))?,
        None => FlankColours::default(),
    };
    let options = SceneOptions {
        show_shroud: args.shroud,
        transparent: args.transparent,
        theme: if args.dark { Theme::Dark } else { Theme::Light },
        ..SceneOptions::showing(FloorColours::Plain)
    };
    let shown = args.at.unwrap_or(plan.moves.len()).min(plan.moves.len());
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    let mut scene = Scene::new(&gpu, &plan.part);
    scene.set_paths(&gpu, &lines(&plan.curves, &plan.moves[..shown], plan.layers, colours));
    draw(&gpu, &mut renderer, &scene, view, &options, size, false)
}
