//! Patches of a colour, and bars of the colours of a map, for legends.

use egui::{Color32, Rect, Rgba, Sense, Stroke, StrokeKind, Ui, Vec2};

use super::theme;
use crate::palette::{ColourMap, Rgb, TABLE_LEN};

/// Least contrast of a patch with the panel without an outline, as a ratio of luminances.
const MIN_CONTRAST: f32 = 1.5;

/// A patch of a colour, `side` points wide; one that would not be seen on the panel has an outline.
pub fn swatch(ui: &mut Ui, colour: Rgb, side: f32) {
    let (at, _) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
    let fill = theme::colour(colour);
    ui.painter().rect_filled(at, 2.0, fill);
    if contrast(fill, ui.visuals().panel_fill) < MIN_CONTRAST {
        let outline = Stroke::new(1.0, ui.visuals().weak_text_color());
        ui.painter().rect_stroke(at, 2.0, outline, StrokeKind::Inside);
    }
}

/// Contrast ratio of two colours by their relative luminance (WCAG 2).
fn contrast(a: Color32, b: Color32) -> f32 {
    let luminance = |colour: Color32| {
        let [r, g, b, _] = Rgba::from(colour).to_array();
        0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05
    };
    let (a, b) = (luminance(a), luminance(b));
    a.max(b) / a.min(b)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_colours_near_that_of_the_panel_have_an_outline() {
        let panel = Color32::from_gray(27);
        let ends = [0, TABLE_LEN - 1].map(|k| {
            let [r, g, b] = ColourMap::Viridis.table()[k];
            Color32::from_rgb(r, g, b)
        });
        assert!(contrast(ends[0], panel) < MIN_CONTRAST && contrast(ends[1], panel) > MIN_CONTRAST);
        assert!((contrast(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 1e-3);
    }
}
