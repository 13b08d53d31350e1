//! Pictures of a plan for its setup sheet.

use glam::UVec2;

use super::PagePicture;
use crate::drawing::{scene_of_part, show_plan};
use crate::error::UserError;
use crate::gpu::image::draw_png;
use crate::gpu::{FloorColours, Gpu, Renderer, SceneOptions, View};
use crate::job::{PlanOutcome, PolicyResult};
use crate::stock::surface::fitting_range;

/// Size of the pictures, pixels.
pub(super) const SIZE: UVec2 = UVec2::new(900, 640);

/// Stock and interference before and after: those of the conventional plan and of `after`, on one scale. The names
/// of the files begin with `prefix`.
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
    let range = fitting_range(&outcome.grid, &outcome.before.field.heights);
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
