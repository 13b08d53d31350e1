//! Menus that may be higher than the window.

use egui::{TextWrapMode, Ui};

use super::scroll_area;

/// Space between the items of a menu and its scroll bar, points.
const BESIDE_BAR: f32 = 4.0;
/// Space below a menu, points.
const BELOW_MENU: f32 = 4.0;
/// Height of the window from which on every menu fits, points.
const ALL_FIT: f32 = 720.0;

/// Whether the menu of this name is drawn for the first time since it was closed: it begins at its top,
/// however far it was scrolled then.
fn has_opened(ui: &Ui, name: &str) -> bool {
    let key = egui::Id::unique(("last pass of a menu", name));
    let (now, last) = (ui.ctx().cumulative_pass_nr(), ui.data(|data| data.get_temp::<u64>(key)));
    ui.data_mut(|data| data.insert_temp(key, now));
    last.is_none_or(|last| last + 1 < now)
}

/// Draws the content of the menu of this name, which scrolls where the window is too low for it. `top`: least
/// height at which the menu begins, points.
pub fn long_content(ui: &mut Ui, name: &str, top: f32, content: impl FnOnce(&mut Ui)) {
    let screen = ui.ctx().content_rect();
    if screen.height() >= ALL_FIT {
        content(ui);
        return;
    }
    let height = screen.bottom() - top - BELOW_MENU - ui.spacing().menu_margin.sum().y;
    // Without the pointer on it, too, the bar says that there is more.
    let scroll = &mut ui.spacing_mut().scroll;
    (scroll.dormant_handle_opacity, scroll.dormant_background_opacity) =
        (scroll.active_handle_opacity, scroll.active_background_opacity);
    // Beside the keys of the items.
    scroll.floating_allocated_width = BESIDE_BAR + scroll.floating_width;
    // The menu is as wide as its items: none breaks for the bar.
    ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
    // A popup is as high as its content was in the frame before.
    let area = scroll_area(height);
    let area = if has_opened(ui, name) { area.vertical_scroll_offset(0.0) } else { area };
    area.show(ui, content);
}
