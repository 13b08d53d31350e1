//! Patches of a colour, and bars of the colours of a map, for legends.

use egui::{Color32, Rect, Sense, Ui, Vec2};

use super::theme;
use crate::palette::{ColourMap, Rgb, TABLE_LEN};

/// A patch of a colour, `side` points wide.
pub fn swatch(ui: &mut Ui, colour: Rgb, side: f32) {
    let (at, _) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
    ui.painter().rect_filled(at, 2.0, theme::colour(colour));
}

/// A bar of the colours of `map`.
pub fn colour_bar(ui: &mut Ui, map: ColourMap, width: f32) {
    let (bar, _) = ui.allocate_exact_size(Vec2::new(width, 10.0), Sense::hover());
    let table = map.table();
    let steps = 64;
    for k in 0..steps {
        let at = |k: usize| egui::lerp(bar.left()..=bar.right(), k as f32 / steps as f32);
        let part =
            Rect::from_min_max(egui::pos2(at(k), bar.top()), egui::pos2(at(k + 1) + 0.5, bar.bottom()));
        let [r, g, b] = table[k * (TABLE_LEN - 1) / (steps - 1)];
        ui.painter().rect_filled(part, 0.0, Color32::from_rgb(r, g, b));
    }
}
