//! What the window draws: panels, 3D views, menus, dialogs. Drawing reads the model, edits what the user
//! edits, and returns commands; [`super::control`] carries them out.

mod borders;
pub mod changed;
mod channel_order;
pub mod channels_dialog;
mod chart;
pub mod command;
mod count_field;
mod cube;
pub mod dialogs;
pub(in crate::app) mod dock;
pub(in crate::app) mod drop_sign;
pub(in crate::app) mod field_faults;
pub mod help;
pub mod key_order;
pub mod legend;
mod list_keys;
mod long_menu;
mod menu;
pub mod missing_part;
pub(in crate::app) mod modal;
mod mouse;
pub mod nc_dialog;
mod overlay;
pub mod palette;
pub mod panels;
pub mod picture;
pub mod picture_dialog;
pub mod pictures;
mod point_menu;
pub mod recover;
pub mod release;
pub mod roles;
pub mod scale_ends;
mod section_plane;
mod sides;
mod swatch;
pub mod theme;
mod ticks;
pub(in crate::app) mod timeline_tool;
mod tool_drawing;
pub mod tool_form;
pub mod tour;
pub(in crate::app) mod typed;
pub mod under_cursor;
pub(in crate::app) mod units;
pub mod unsaved;
pub mod view3d;
pub mod viewport;
mod wide_table;

use std::sync::Arc;

use egui::ScrollArea;

use super::model::state::AppState;
use super::tasks::Repaint;

/// What scrolls beyond a `height` (points). Of its own an area in a popup or dialog takes no more than 64.
fn scroll_area(height: f32) -> ScrollArea {
    ScrollArea::vertical().max_height(height).min_scrolled_height(height)
}

/// Makes units, faults and operation of `state` those of all that is drawn in this frame.
pub(in crate::app) fn begin_frame(ctx: &egui::Context, state: &AppState) {
    units::set(ctx, state.look.units);
    field_faults::set(ctx, state.field_faults());
    typed::follow(ctx, state.look.operation);
}

/// Draws the window of `ctx` again when called.
pub fn repaint(ctx: &egui::Context) -> Repaint {
    let ctx = ctx.clone();
    Arc::new(move || ctx.request_repaint())
}
