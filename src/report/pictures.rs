//! Pictures of a plan for its setup sheet.

use glam::UVec2;

use super::PagePicture;
use crate::drawing::flank::{FlankColours, toolpath_lines, wall_deviations, wall_scale_end};
use crate::drawing::{scene_of_part, show_plan};
use crate::error::UserError;
use crate::gpu::image::draw_png;
use crate::gpu::{ColourMap, FloorColours, Gpu, Renderer, Scene, SceneOptions, View};
use crate::io::flank_file::shown_passes;
use crate::job::flank::FlankOutcome;
use crate::job::{PlanOutcome, PolicyResult};
use crate::stock::surface::fitting_range;

/// Size of the pictures, pixels.
pub(super) const SIZE: UVec2 = UVec2::new(900, 640);

/// The passes of a flank plan by layer, and its walls by what is left on them. The names of the files begin
/// with `prefix`.
///
/// # Errors
/// As [`plan_pictures`].
pub fn flank_pictures(outcome: &FlankOutcome, prefix: &str) -> Result<Vec<PagePicture>, UserError> {
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    let (part, plan) = (&outcome.workpiece.part, &outcome.plan);
    let mut pictures = Vec::new();
    let mut draw = |scene: &Scene, options: &SceneOptions, name: &str, caption: String| {
        let bytes = draw_png(&gpu, &mut renderer, scene, View::Channel, options, SIZE, false)?;
        pictures.push(PagePicture { name: format!("{prefix}{name}.png"), bytes, caption });
        Ok::<(), UserError>(())
    };
    let mut scene = scene_of_part(&gpu, part);
    let layers = plan.layout.layers.len();
    let lines = toolpath_lines(&shown_passes(plan), &plan.moves, layers, FlankColours::Layer, false);
    scene.set_paths(&gpu, &lines);
    let options = SceneOptions::for_colours(FloorColours::Plain);
    draw(&scene, &options, "passes", "passes by layer: dark next to the hub, light at the top".to_owned())?;
    let mut scene = scene_of_part(&gpu, part);
    let (mesh, most) = wall_deviations(part, &outcome.shown_walls());
    let most = wall_scale_end(most);
    scene.set_values(&gpu, mesh);
    let options = SceneOptions {
        map: ColourMap::Difference,
        range_mm: (-most, most),
        // The blades would hide the coloured walls that lie on them.
        show_blades: false,
        ..SceneOptions::for_colours(FloorColours::Walls)
    };
    draw(
        &scene,
        &options,
        "walls",
        format!("walls: stock against the allowance, −{most:.4} to +{most:.4} mm"),
    )?;
    Ok(pictures)
}

/// Stock and interference before and after: those of the conventional plan and of `after`, on one scale. The
/// names of the files begin with `prefix`.
///
/// # Errors
/// When no graphics device is available, or when drawing fails.
pub fn plan_pictures(
    outcome: &PlanOutcome,
    after: &PolicyResult,
    prefix: &str,
) -> Result<Vec<PagePicture>, UserError> {
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    let mut scene = scene_of_part(&gpu, &outcome.workpiece.part);
    let fit = |result: &PolicyResult| fitting_range(&outcome.grid, &result.field.heights);
    let range = common_range(fit(&outcome.before), fit(after));
    let stock = format!("stock on the hub, {:.2} mm (dark) to {:.2} mm (bright)", range.0, range.1);
    let mut pictures = Vec::new();
    for (name, result) in [("before", &outcome.before), ("after", after)] {
        show_plan(&mut scene, &gpu, &result.plan, &outcome.grid, &result.field.heights);
        for (show, caption, colours) in [
            ("residual", stock.as_str(), FloorColours::Residual),
            ("interference", "interfering plunges", FloorColours::Interference),
        ] {
            let options = SceneOptions { range_mm: range, ..SceneOptions::for_colours(colours) };
            let bytes = draw_png(&gpu, &mut renderer, &scene, View::Channel, &options, SIZE, false)?;
            let caption = format!("{name}: {caption}");
            pictures.push(PagePicture { name: format!("{prefix}{name}_{show}.png"), bytes, caption });
        }
    }
    Ok(pictures)
}

/// A scale that fits both of two plans, mm. One that is narrower than its captions tell would show what is
/// next to nothing in the colours of extremes.
fn common_range(a: (f32, f32), b: (f32, f32)) -> (f32, f32) {
    const MIN_WIDTH: f32 = 0.1;
    let low = a.0.min(b.0);
    (low, a.1.max(b.1).max(low + MIN_WIDTH))
}

#[cfg(test)]
mod tests {
    use super::common_range;

    #[test]
    fn the_scale_fits_both_plans_and_is_no_narrower_than_its_captions_tell() {
        assert_eq!(common_range((0.5, 4.0), (0.4, 1.2)), (0.4, 4.0));
        assert_eq!(common_range((0.5, 0.502), (0.5, 0.9)), (0.5, 0.9));
        assert_eq!(common_range((0.5, 0.502), (0.5, 0.501)), (0.5, 0.6));
    }
}
