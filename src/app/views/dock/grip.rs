//! The grip at the upper edge of a panel, which moves it, and the menu of a panel.

use egui::{CursorIcon, Popup, Rect, Role, Sense, Ui, Vec2, WidgetInfo};

use crate::app::model::panels::DockPanel;
use crate::app::views::theme;

/// Size of the grip, points.
const SIZE: Vec2 = Vec2::new(44.0, 7.0);
/// Height of the strip below the upper edge in which the pointer makes it appear, points; its part of a low
/// panel.
const REACH: f32 = 28.0;
const REACH_SHARE: f32 = 0.15;

/// An edge of the area of the docked panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowEdge {
    /// At the left of all others.
    Left,
    /// At the right of all others.
    Right,
    /// Below all others.
    Bottom,
}

/// What is asked for a panel in its menu.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelRequest {
    /// Show it in a window of its own.
    PopOut,
    /// Show it at its place among the docked panels.
    Dock,
    /// Dock it at an edge.
    Move(WindowEdge),
    /// Hide it.
    Hide,
    /// Arrange all panels as at first.
    Reset,
}

/// What was done with a grip.
#[derive(Clone, Copy, Debug, Default)]
pub struct GripUse {
    /// Whether a drag of the panel began.
    pub drag_started: bool,
    /// What was chosen in its menu.
    pub request: Option<PanelRequest>,
}

/// Draws the grip of a panel in `rect`. It is visible while the pointer is near. The Tab key skips it and
/// moves from field to field; the View menu has the same commands.
pub fn grip(ui: &Ui, rect: Rect, panel: DockPanel, is_floating: bool) -> GripUse {
    let at = Rect::from_center_size(rect.center_top() + Vec2::new(0.0, 0.5 * SIZE.y), SIZE);
    let id = egui::Id::unique(("grip of a panel", panel));
    let response = ui.interact(at, id, Sense::CLICK | Sense::DRAG);
    let name = format!("Move panel: {}", panel.title());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let strip = rect.split_top_bottom_at_y(rect.top() + REACH.min(REACH_SHARE * rect.height())).0;
    let menu = Popup::menu(&response).show(|ui| panel_menu(ui, panel, is_floating));
    if ui.rect_contains_pointer(strip) || menu.is_some() {
        let visuals = ui.visuals();
        let ink = if response.hovered() { theme::accent(visuals) } else { visuals.weak_text_color() };
        ui.painter().rect_filled(at.shrink2(Vec2::new(4.0, 2.0)), 2.0, ink);
    }
    let drag_started = response.drag_started();
    let tip = match panel.can_leave() {
        true => {
            "Drag to dock the panel elsewhere; drop it on the menu or the status bar to pop it out.\nClick for more"
        }
        false => "Drag to dock the view elsewhere.\nClick for more",
    };
    response.on_hover_cursor(CursorIcon::Grab).on_hover_text(tip);
    GripUse { drag_started, request: menu.and_then(|menu| menu.inner) }
}

/// Draws the menu of a panel; returns what was chosen.
pub fn panel_menu(ui: &mut Ui, panel: DockPanel, is_floating: bool) -> Option<PanelRequest> {
    let leave = if is_floating {
        ("Dock", "Shows the panel at its place beside the others", PanelRequest::Dock)
    } else {
        ("Pop out", "Shows the panel in a window of its own", PanelRequest::PopOut)
    };
    let hide = ("Hide", "Hides the panel; View, Panels shows it again", PanelRequest::Hide);
    let edges = [
        ("Move to the left", "Docks the panel at the left edge", PanelRequest::Move(WindowEdge::Left)),
        ("Move to the right", "Docks the panel at the right edge", PanelRequest::Move(WindowEdge::Right)),
        ("Move to the bottom", "Docks the panel below all others", PanelRequest::Move(WindowEdge::Bottom)),
    ];
    let mut chosen = None;
    let mut item = |ui: &mut Ui, (label, tip, request)| {
        if ui.button(label).on_hover_text(tip).clicked() {
            chosen = Some(request);
            ui.close();
        }
    };
    if panel.can_leave() {
        item(ui, leave);
    }
    edges.into_iter().for_each(|edge| item(ui, edge));
    if panel.can_leave() {
        item(ui, hide);
    }
    ui.separator();
    item(ui, ("Reset layout", "Arranges all panels as at first", PanelRequest::Reset));
    chosen
}
