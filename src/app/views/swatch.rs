//! Patches of a colour, for legends.

use egui::{Sense, Ui, Vec2};

use super::theme;
use crate::palette::Rgb;

/// A patch of a colour, `side` points wide.
pub fn swatch(ui: &mut Ui, colour: Rgb, side: f32) {
    let (at, _) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
    ui.painter().rect_filled(at, 2.0, theme::colour(colour));
}
