//! How the tree of the docked panels looks and behaves.

use std::collections::HashSet;

use egui::{Color32, Popup, Rect, Response, Stroke, Ui, UiBuilder, Visuals, WidgetText};
use egui_tiles::{
    Behavior, EditAction, ResizeState, SimplificationOptions, TabState, Tabs, TileId, Tiles, UiResponse,
};

use super::grip::{PanelRequest, grip, panel_menu};
use super::sizes::{GAP, TAB_BAR};
use super::{content, simplification};
use crate::app::App;
use crate::app::model::panels::DockPanel;

/// Draws the tree, and collects what is asked for.
pub struct DockBehavior<'a> {
    /// What draws the panels.
    pub app: &'a mut App,
    /// Tabs that have a bar.
    pub bars: HashSet<TileId>,
    /// Tiles that have a tab.
    pub tabbed: Vec<TileId>,
    /// Whether the dragged panel would not be docked where the pointer is.
    pub is_outside: bool,
    /// What is seen of the docked panels.
    pub view: Rect,
    /// Height of the content of [`DockPanel::Details`], points.
    pub details_height: &'a mut f32,
    /// Whether a panel was dropped.
    pub was_dropped: bool,
    /// What was chosen in the menu of a panel.
    pub request: Option<(DockPanel, PanelRequest)>,
}

impl Behavior<DockPanel> for DockBehavior<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, tile: TileId, panel: &mut DockPanel) -> UiResponse {
        let (rect, panel) = (ui.max_rect(), *panel);
        // The tree draws each tile without the limits of what it stands in.
        ui.shrink_clip_rect(self.view);
        // What is opened and scrolled in a panel stays when it is moved.
        let builder = UiBuilder::new().max_rect(rect).scope_id(content::panel_id(panel));
        ui.scope_builder(builder, |ui| self.app.docked_panel(ui, panel, self.details_height));
        if self.tabbed.contains(&tile) {
            return UiResponse::None;
        }
        let used = grip(ui, rect, panel, false);
        self.request = used.request.map(|request| (panel, request)).or(self.request);
        if used.drag_started { UiResponse::DragStarted } else { UiResponse::None }
    }

    fn tab_title_for_pane(&mut self, panel: &DockPanel) -> WidgetText {
        panel.title().into()
    }

    fn tab_title_for_tile(&mut self, tiles: &Tiles<DockPanel>, tile: TileId) -> WidgetText {
        // Several panels go by the name of the first one.
        let mut first = tile;
        while let Some(container) = tiles.get_container(first) {
            let Some(child) = container.children().find(|child| tiles.is_visible_in_layout(**child)) else {
                break;
            };
            first = *child;
        }
        let panel = tiles.get_pane(&first).map_or("Panels", |panel| panel.title());
        if first == tile { panel.into() } else { format!("{panel}, …").into() }
    }

    fn on_tab_button(&mut self, tiles: &mut Tiles<DockPanel>, tile: TileId, button: Response) -> Response {
        let Some(&panel) = tiles.get_pane(&tile) else { return button };
        let menu = Popup::context_menu(&button).show(|ui| panel_menu(ui, panel, false));
        let request = menu.and_then(|menu| menu.inner);
        self.request = request.map(|request| (panel, request)).or(self.request);
        button.on_hover_text(panel.tip())
    }

    fn on_edit(&mut self, edit: EditAction) {
        self.was_dropped |= edit == EditAction::TileDropped;
    }

    fn drag_ui(&mut self, tiles: &Tiles<DockPanel>, ui: &mut Ui, tile: TileId) {
        let text = self.tab_title_for_tile(tiles, tile);
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.label(text);
        });
    }

    fn paint_drag_preview(&self, visuals: &Visuals, painter: &egui::Painter, _: Option<Rect>, preview: Rect) {
        if !self.is_outside {
            let (fill, line) = (self.drag_preview_color(visuals), self.drag_preview_stroke(visuals));
            painter.rect(preview, 2.0, fill, line, egui::StrokeKind::Inside);
        }
    }

    fn drag_preview_stroke(&self, visuals: &Visuals) -> Stroke {
        Stroke::new(1.0, crate::app::views::theme::accent(visuals))
    }

    fn drag_preview_color(&self, visuals: &Visuals) -> Color32 {
        crate::app::views::theme::accent(visuals).gamma_multiply(0.35)
    }

    fn is_tab_bar_visible(&self, tile: TileId, _: &Tabs) -> bool {
        self.bars.contains(&tile)
    }

    /// The borders are [`super::splitters`]: those of the tree would be stops of the Tab key, and halve their
    /// neighbours by a double click.
    fn is_container_resizable(&self, _: &Tiles<DockPanel>, _: TileId) -> bool {
        false
    }

    fn tab_bar_height(&self, _: &egui::Style) -> f32 {
        TAB_BAR
    }

    fn gap_width(&self, _: &egui::Style) -> f32 {
        GAP
    }

    fn min_size(&self) -> f32 {
        60.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        simplification()
    }

    fn resize_stroke(&self, style: &egui::Style, _: ResizeState) -> Stroke {
        style.visuals.widgets.noninteractive.bg_stroke
    }

    fn tab_text_color(
        &self,
        visuals: &Visuals,
        _: &Tiles<DockPanel>,
        _: TileId,
        state: &TabState,
    ) -> Color32 {
        if state.active { visuals.strong_text_color() } else { visuals.weak_text_color() }
    }
}
