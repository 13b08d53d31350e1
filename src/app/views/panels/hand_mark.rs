//! What was done by hand to a position, as a mark and in words.

use egui::{Pos2, Rect, Stroke, Ui, vec2};

use crate::app::views::theme;
use crate::plunge::PlungeMark;

/// What was done by hand, right of `left`: a padlock, or a bar for other edits.
pub fn hand_mark(ui: &Ui, left: Pos2, of: PlungeMark) {
    let (painter, ink) = (ui.painter(), theme::accent(ui.visuals()));
    let at = left + vec2(3.5, 0.0);
    match of {
        PlungeMark::Planned => {}
        PlungeMark::Edited => {
            painter.rect_filled(Rect::from_center_size(at, vec2(3.0, 9.0)), 1.0, ink);
        }
        PlungeMark::Locked(_) => {
            let body = Rect::from_center_size(at + vec2(0.0, 1.5), vec2(7.0, 5.0));
            painter.rect_filled(body, 1.0, ink);
            painter.circle_stroke(at - vec2(0.0, 1.5), 2.3, Stroke::new(1.2, ink));
        }
    }
}

/// What was done by hand to a position, in words; `None` where nothing was.
pub fn hand_words(of: PlungeMark) -> Option<&'static str> {
    match of {
        PlungeMark::Planned => None,
        PlungeMark::Edited => Some("Edited by hand"),
        PlungeMark::Locked(_) => Some("Locked: stays in every plan"),
    }
}
