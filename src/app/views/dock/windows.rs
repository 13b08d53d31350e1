//! Panels in windows of their own, over the others, and which of them is in front.

use egui::{Context, Id, LayerId, Order, Pos2, Rect, Ui, UiBuilder, Vec2, Window};

use super::content::panel_id;
use super::grip::grip;
use crate::app::App;
use crate::app::model::layout::WindowPlace;
use crate::app::model::panels::{DockPanel, Panels};
use crate::app::views::theme;

/// Distance of a new window from the upper edge of a low program window, below menus and figures, points.
const BELOW_VERDICT: f32 = 72.0;
/// Room that a new window leaves in a small program window, points.
const AROUND: Vec2 = Vec2::new(40.0, 80.0);

fn window_id(panel: DockPanel) -> Id {
    Id::unique(("floating window", panel.title()))
}

/// First size and least size of a window, points.
fn sizes(panel: DockPanel) -> ([f32; 2], [f32; 2]) {
    match panel {
        DockPanel::Setup => ([280.0, 560.0], [220.0, 160.0]),
        DockPanel::Table => ([300.0, 420.0], [260.0, 140.0]),
        DockPanel::Details => ([320.0, 400.0], [260.0, 160.0]),
        DockPanel::Plots => ([680.0, 92.0], [300.0, 60.0]),
        DockPanel::Axes => ([680.0, 66.0], [300.0, 50.0]),
        DockPanel::Timeline => ([680.0, 76.0], [300.0, 54.0]),
        DockPanel::SectionalView => ([620.0, 460.0], [300.0, 240.0]),
        DockPanel::Machinability => ([560.0, 520.0], [320.0, 200.0]),
        DockPanel::Tradeoff => ([460.0, 390.0], [300.0, 220.0]),
        DockPanel::Study => ([760.0, 560.0], [360.0, 300.0]),
        // As large as its content.
        DockPanel::ToolLibrary | DockPanel::Picture => ([0.0; 2], [0.0; 2]),
    }
}

/// Upper left corner of a new window of `size` points.
fn corner(panel: DockPanel, screen: Rect, size: Vec2) -> Pos2 {
    match panel {
        // In a corner of the picture, which follows the handle.
        DockPanel::Tradeoff => {
            let corner = screen.left_bottom() + Vec2::new(theme::LEFT_WIDTH + 20.0, -size.y - 140.0);
            Pos2::new(corner.x, corner.y.max(screen.top() + BELOW_VERDICT))
        }
        DockPanel::ToolLibrary => Pos2::new(60.0, 60.0),
        _ => screen.center() - 0.5 * size,
    }
}

/// The panel whose window is in front, of those that a command opened; `None` while none is open.
pub fn in_front(ctx: &Context, panels: &Panels) -> Option<DockPanel> {
    let windows =
        || DockPanel::ALL.into_iter().filter(|panel| panel.is_window_at_first() && panels.floats(*panel));
    ctx.memory(|memory| {
        let areas = memory.areas();
        let layers: Vec<LayerId> = memory.layer_ids().collect();
        let of = |layer: &LayerId| {
            windows().find(|&panel| LayerId::new(Order::Middle, window_id(panel)) == *layer)
        };
        layers.iter().rev().filter(|layer| areas.is_visible(layer)).find_map(of)
    })
}

/// Whether the pointer is over the window of a panel.
pub fn is_under_pointer(ctx: &Context, panel: DockPanel) -> bool {
    let pointer = ctx.input(|input| input.pointer.interact_pos());
    let rect = ctx.memory(|memory| memory.area_rect(window_id(panel)));
    pointer.zip(rect).is_some_and(|(at, rect)| rect.contains(at))
}

impl App {
    /// Draws the panels that float; without an open part, docked ones that need none, too.
    /// They stay below `menus`, the lower edge of the menu bar.
    pub(in crate::app) fn floating_panels(&mut self, ui: &Ui, menus: f32) {
        let is_open = self.state.document.part.is_some();
        for panel in DockPanel::ALL.into_iter().filter(|panel| panel.can_leave()) {
            let state = self.state.look.panels.state(panel);
            if state.is_open && (state.is_floating || !is_open) && self.has_content(panel) {
                self.floating_panel(ui, panel, menus);
            }
        }
    }

    fn floating_panel(&mut self, ui: &Ui, panel: DockPanel, menus: f32) {
        let (size, mut least) = sizes(panel);
        if panel == DockPanel::Table {
            // No narrower than its columns: with a machine there is one more.
            least[0] = least[0].max(self.table_width() + ui.spacing().window_margin.sum().x);
        }
        let screen = ui.ctx().content_rect();
        // As it was left, in an earlier session too.
        let known = self.dock.windows.get(&panel).copied();
        let size = Vec2::from(known.map_or(size, |place| place.size)).min(screen.size() - AROUND);
        let mut open = true;
        let mut window = Window::new(panel.title()).id(window_id(panel)).open(&mut open).collapsible(false);
        window = match self.dock.popped_out.take_if(|(popped, _)| *popped == panel) {
            Some((_, at)) => window.current_pos(at),
            None => {
                let at = known.map_or_else(|| corner(panel, screen, size), |place| Pos2::from(place.at));
                window.default_pos(at)
            }
        };
        window = match panel {
            DockPanel::ToolLibrary => window.resizable(false),
            _ => window.default_size(size).min_size(least),
        };
        window = window.constrain_to(screen.with_min_y(menus));
        let is_docked_at_first = !panel.is_window_at_first();
        // In its first frame it is measured, and has another size.
        let layer = LayerId::new(Order::Middle, window_id(panel));
        let was_visible = ui.memory(|memory| memory.areas().visible_last_frame(&layer));
        let shown = window.show(ui.ctx(), |ui| {
            let rect = ui.available_rect_before_wrap();
            if is_docked_at_first {
                // As it is docked, with what is opened and scrolled in it.
                let builder = UiBuilder::new().max_rect(rect).scope_id(panel_id(panel));
                ui.scope_builder(builder, |ui| self.scrolled_panel(ui, panel, Some(rect.height())));
            } else {
                self.panel(ui, panel, None);
            }
            grip(ui, rect, panel, true)
        });
        if !open {
            self.state.look.panels.close_window(panel);
        }
        let Some(shown) = shown else { return };
        let (at, size) = (shown.response.rect.min, shown.response.rect.size());
        let Some(used) = shown.inner else { return };
        let place = WindowPlace { at: [at.x.round(), at.y.round()], size: [size.x.round(), size.y.round()] };
        if was_visible {
            self.dock.windows.insert(panel, place);
        }
        if used.drag_started
            && let Some(tile) = self.dock.tree.tiles.find_pane(&panel)
        {
            // The tree shows where it would be docked.
            ui.ctx().set_dragged_id(tile.egui_id(self.dock.tree.id()));
        }
        if let Some(request) = used.request {
            self.change_panel(ui.ctx(), panel, request);
        }
    }
}
