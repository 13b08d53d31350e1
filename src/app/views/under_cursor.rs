//! What is under the cursor in the 3D views.

use egui::Pos2;

use crate::gpu::camera::Camera;
use crate::gpu::scene::SceneOptions;

use crate::app::App;
use crate::app::model::planned::Side;
use crate::app::views::legend::Values;
use crate::app::views::panels;
use crate::app::views::view3d::{ViewHit, view_point};
use crate::app::views::viewport::Pane;

/// Cached hit under the cursor, with the inputs it was computed for.
#[derive(Clone, Copy, Debug)]
pub(in crate::app) struct Hover {
    at: Pos2,
    picture: HoveredPicture,
    pub(super) hit: ViewHit,
    other: Option<f32>,
}

/// The picture under the cursor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HoveredPicture {
    side: Side,
    camera: Camera,
    options: SceneOptions,
    /// Grows with every change of what the views draw.
    drawn: u64,
}

impl App {
    /// Values under the cursor; cached until cursor, camera or what is drawn changes.
    pub(in crate::app) fn values_under_cursor(&mut self, panes: &[Pane], camera: &Camera) -> Values {
        let at = |pane: &&Pane| {
            let at = pane.response.hover_pos().filter(|_| !pane.response.dragged())?;
            pane.visible.contains(at).then_some(at)
        };
        let Some((pane, at)) = panes.iter().find_map(|pane| Some((pane, at(&pane)?))) else {
            self.hover = None;
            return Values::default();
        };
        let options = self.options(pane.side);
        let drawn = |pane: &Pane| Some(self.pictures.as_mut()?.side(pane.side)?.generation());
        let drawn: u64 = panes.iter().filter_map(drawn).sum();
        let picture = HoveredPicture { side: pane.side, camera: *camera, options, drawn };
        let known = self.hover.filter(|hover| hover.at == at && hover.picture == picture);
        let hover = known.or_else(|| {
            let pictures = self.pictures.as_mut()?;
            let hit =
                pictures.side(pane.side)?.hit(camera, &options, view_point(pane.rect, at), pane.rect.size());
            let other = (panes.len() > 1)
                .then(|| hit.point.filter(|_| hit.stock.is_some()))
                .flatten()
                .and_then(|point| pictures.side(pane.side.other())?.stock_at(point));
            Some(Hover { at, picture, hit, other })
        });
        self.hover = hover;
        let Some(hover) = hover else { return Values::default() };
        if let Some(position) = hover.hit.position {
            let state = &self.state;
            pane.response.clone().on_hover_ui_at_pointer(|ui| {
                panels::positions::cutter_tooltip(ui, state, pane.side, position, 0);
            });
        }
        Values {
            here: hover.hit.stock,
            deviation: hover.hit.deviation,
            other: hover.other.map(|stock| (pane.side.other(), stock)),
        }
    }
}
