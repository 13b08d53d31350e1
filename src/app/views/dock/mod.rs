//! The docked panels: a tree of rows, columns and tabs in which each panel can be moved, and from which it
//! pops out into a window. Whether a panel is open or floats is in
//! [`Panels`](crate::app::model::panels::Panels); the tree keeps the places of all of them.

mod behavior;
mod content;
mod fronts;
mod grip;
mod sizes;
mod splitters;
mod stored;
mod windows;

use std::collections::{HashMap, HashSet};

use egui::containers::scroll_area::ScrollSource;
use egui::style::ScrollStyle;
use egui::{Context, Pos2, Rect, ScrollArea, Ui, UiBuilder, Vec2};
use egui_tiles::{Container, LinearDir, SimplificationOptions, Tile, TileId, Tree};

pub use windows::in_front;

use crate::app::App;
use crate::app::model::layout::{Layout, WindowPlace};
use crate::app::model::panels::DockPanel;
use crate::app::views::panels;

use behavior::DockBehavior;
use fronts::FrontTabs;
pub use grip::{PanelRequest, WindowEdge, panel_menu};
use sizes::{KeptSize, Sizes};

/// Size below which the docked panels scroll as a whole, points: columns of the usual widths beside a 3D view
/// whose controls do not lie over each other.
const MIN_SIZE: Vec2 = Vec2::new(770.0, 260.0);
/// Height of the middle below which the plots under the 3D view are hidden in favour of it, points.
const MIN_HEIGHT_FOR_PLOTS: f32 = 400.0;
/// What stays for other panels beside one that is as high as its content, points.
const MIN_BESIDE_DETAILS: f32 = 120.0;
/// Height of the details before their content was measured, points.
const FIRST_DETAILS: f32 = 200.0;

/// The places of the panels.
#[derive(Clone)]
pub struct Dock {
    tree: Tree<DockPanel>,
    fronts: FrontTabs,
    /// Sizes set by hand of tiles whose content needs another size now.
    kept: HashMap<TileId, KeptSize>,
    /// Height of the content of [`DockPanel::Details`], points.
    details_height: f32,
    /// Panels whose places below the 3D view are left to it, as it would be too low.
    without_room: Vec<DockPanel>,
    /// Where a window appears that was just popped out.
    popped_out: Option<(DockPanel, Pos2)>,
    /// Where the windows of panels are, or were when they were closed.
    windows: HashMap<DockPanel, WindowPlace>,
    /// The layout that is stored.
    stored: Layout,
}

impl Default for Dock {
    fn default() -> Self {
        Self::from_layout(&Layout::default())
    }
}

impl Dock {
    /// The panels arranged by `layout`.
    pub fn from_layout(layout: &Layout) -> Self {
        let tree = stored::tree_of(&layout.docked);
        Self {
            fronts: FrontTabs::from_tree(&tree),
            tree,
            kept: HashMap::new(),
            details_height: FIRST_DETAILS,
            without_room: Vec::new(),
            popped_out: None,
            windows: layout.windows.iter().copied().collect(),
            stored: layout.clone(),
        }
    }

    /// Where a panel is docked; `None` if it floats, is closed, or behind another tab.
    pub fn rect(&self, panel: DockPanel) -> Option<Rect> {
        self.tree.tiles.find_pane(&panel).and_then(|tile| self.tree.tiles.rect(tile))
    }

    /// The row, column or tabs in which a panel has its place.
    fn parent_of(&self, panel: DockPanel) -> Option<TileId> {
        self.tree.tiles.find_pane(&panel).and_then(|tile| self.tree.tiles.parent_of(tile))
    }

    /// Whether a panel is docked behind another tab.
    fn is_behind(&self, panel: DockPanel) -> bool {
        let tiles = &self.tree.tiles;
        let parent = self.parent_of(panel).and_then(|parent| tiles.get_container(parent));
        matches!(parent, Some(Container::Tabs(tabs)) if tabs.active != tiles.find_pane(&panel))
    }

    /// The 3D view, with the timeline where it is below it.
    pub fn picture_rect(&self) -> Option<Rect> {
        let timeline = self.parent_of(DockPanel::Timeline);
        let common = self.parent_of(DockPanel::Picture).filter(|own| timeline == Some(*own));
        common.and_then(|tile| self.tree.tiles.rect(tile)).or_else(|| self.rect(DockPanel::Picture))
    }

    /// The panel in a tile; `None` for several.
    fn panel_in(&self, tile: TileId) -> Option<DockPanel> {
        self.tree.tiles.get_pane(&tile).copied()
    }

    /// Moves a panel to an edge of the window.
    fn move_to(&mut self, panel: DockPanel, edge: WindowEdge) {
        let tree = &mut self.tree;
        let (Some(tile), Some(root)) = (tree.tiles.find_pane(&panel), tree.root) else { return };
        let (dir, index) = match edge {
            WindowEdge::Left => (LinearDir::Horizontal, 0),
            WindowEdge::Right => (LinearDir::Horizontal, usize::MAX),
            WindowEdge::Bottom => (LinearDir::Vertical, usize::MAX),
        };
        let is_along = match tree.tiles.get(root) {
            Some(Tile::Container(Container::Linear(linear))) => linear.dir == dir,
            _ => false,
        };
        let into = if is_along {
            root
        } else {
            let wrapper = tree.tiles.insert_container(Container::new_linear(dir, vec![root]));
            tree.root = Some(wrapper);
            wrapper
        };
        tree.move_tile_to_container(tile, into, index, false);
    }

    /// Whether the pointer holds a panel outside of the area of the docked ones.
    fn is_held_outside(&self, ctx: &Context, area: Rect) -> bool {
        self.tree.dragged_id(ctx).is_some()
            && ctx.input(|input| input.pointer.interact_pos()).is_some_and(|at| !area.contains(at))
    }
}

/// Rules by which the tree is kept simple.
fn simplification() -> SimplificationOptions {
    SimplificationOptions { flatten_tabs_in_tabs: true, ..SimplificationOptions::default() }
}

impl App {
    /// Draws the docked panels in the rest of `ui`. Where that is too small for them, as in a small window
    /// with large text, they scroll as a whole.
    pub(in crate::app) fn docked_panels(&mut self, ui: &mut Ui) {
        let (available, solid) = (ui.available_size(), ScrollStyle::solid());
        let is_narrow = available.x < MIN_SIZE.x;
        let bar = if is_narrow { solid.allocated_width() } else { 0.0 };
        let is_low = available.y - bar < MIN_SIZE.y;
        if !is_narrow && !is_low {
            return self.panels_in(ui);
        }
        // Beside the bars nothing else would be drawn.
        ui.painter().rect_filled(ui.available_rect_before_wrap(), 0.0, ui.visuals().panel_fill);
        let inner = std::mem::replace(&mut ui.spacing_mut().scroll, solid);
        // Bars alone scroll it: the wheel zooms the 3D view and scrolls tables.
        let area = ScrollArea::new([is_narrow, is_low]).scroll_source(ScrollSource::SCROLL_BAR);
        area.id_salt("docked panels").auto_shrink(false).show(ui, |ui| {
            ui.spacing_mut().scroll = inner;
            let visible = ui.available_size();
            let width = if is_narrow { MIN_SIZE.x } else { visible.x };
            let height = if is_low { MIN_SIZE.y } else { visible.y };
            let (_, rect) = ui.allocate_space(Vec2::new(width, height));
            self.panels_in(&mut ui.new_child(UiBuilder::new().max_rect(rect)));
        });
    }

    /// Draws the docked panels in the rest of `ui`.
    fn panels_in(&mut self, ui: &mut Ui) {
        // Commands of the panels ask where these are.
        let mut dock = self.dock.clone();
        if std::mem::take(&mut self.state.look.panels.wants_reset) {
            dock = Dock { stored: dock.stored, ..Dock::default() };
            ui.ctx().memory_mut(|memory| memory.reset_areas());
        }
        dock.tree.simplify(&simplification());
        let area = ui.available_rect_before_wrap();
        for panel in DockPanel::ALL {
            let Some(tile) = dock.tree.tiles.find_pane(&panel) else { continue };
            let state = self.state.look.panels.state(panel);
            let is_shown = state.is_open && !state.is_floating && self.has_content(panel);
            dock.tree.set_visible(tile, is_shown);
        }
        dock.fronts.restore(&mut dock.tree);
        self.make_room(&mut dock, area);
        // It waits for its content; a window leaves the tabs as they are.
        let opened = self.state.look.panels.opened.filter(|&panel| self.has_content(panel));
        if let Some(opened) = opened {
            self.state.look.panels.opened = None;
            if !self.state.look.panels.floats(opened) {
                dock.tree.make_active(|_, tile| matches!(tile, Tile::Pane(panel) if *panel == opened));
            }
        }
        let (bars, rigid) = self.fit_panels(&mut dock, area);

        let held = dock.tree.dragged_id(ui.ctx());
        let is_outside = dock.is_held_outside(ui.ctx(), area);
        let is_over_window = held.and_then(|tile| dock.panel_in(tile)).is_some_and(|panel| {
            self.state.look.panels.floats(panel) && windows::is_under_pointer(ui.ctx(), panel)
        });
        // The tree would take a panel dropped outside of it to the nearest place.
        let tree_before = (is_outside || is_over_window).then(|| dock.tree.clone());
        let with_bar = bars.iter().filter_map(|bar| dock.tree.tiles.get_container(*bar));
        let tabbed: Vec<TileId> = with_bar.flat_map(|container| container.children().copied()).collect();
        let mut behavior = DockBehavior {
            app: self,
            bars,
            tabbed,
            is_outside: is_outside || is_over_window,
            view: ui.clip_rect(),
            details_height: &mut dock.details_height,
            was_dropped: false,
            request: None,
        };
        dock.tree.ui(&mut behavior, ui);
        let (was_dropped, request) = (behavior.was_dropped, behavior.request);
        splitters::show(ui, &mut dock.tree, &rigid, &mut dock.kept);
        if let Some(tree) = tree_before.filter(|_| was_dropped) {
            dock.tree = tree;
        }
        if let Some(panel) = held.filter(|_| was_dropped).and_then(|tile| dock.panel_in(tile)) {
            if is_outside && panel.can_leave() {
                let at = ui.input(|input| input.pointer.interact_pos()).unwrap_or(area.center());
                dock.popped_out = Some((panel, at));
                self.state.look.panels.pop_out(panel);
            } else if !is_outside && !is_over_window {
                self.state.look.panels.dock(panel);
            }
            ui.ctx().request_repaint();
        }
        dock.fronts.follow(&dock.tree);
        self.dock = dock;
        if let Some((panel, request)) = request {
            self.change_panel(ui.ctx(), panel, request);
        }
    }

    /// Whether an open panel is in view: in a window of its own, or docked and not behind another tab.
    pub(in crate::app) fn is_in_view(&self, panel: DockPanel) -> bool {
        let panels = &self.state.look.panels;
        // One that was just opened comes to the front when it is drawn.
        let is_in_front = panels.opened == Some(panel) || !self.dock.is_behind(panel);
        panels.is_open(panel) && (panels.floats(panel) || is_in_front)
    }

    /// Hides the plots under the 3D view where that would be too low.
    fn make_room(&self, dock: &mut Dock, area: Rect) {
        let has_timeline = self.has_content(DockPanel::Timeline);
        let timeline = if has_timeline { panels::timeline::height(&self.state) } else { 0.0 };
        dock.without_room.clear();
        if area.height() - timeline > MIN_HEIGHT_FOR_PLOTS {
            return;
        }
        let picture = dock.parent_of(DockPanel::Picture);
        for panel in [DockPanel::Plots, DockPanel::Axes] {
            let is_below = dock.parent_of(panel) == picture;
            if let Some(tile) = dock.tree.tiles.find_pane(&panel).filter(|_| is_below) {
                dock.tree.set_visible(tile, false);
                dock.without_room.push(panel);
            }
        }
    }

    /// Shows or hides a panel. A docked panel without enough room opens in a window of its own.
    pub(in crate::app) fn switch_panel(&mut self, ctx: &Context, panel: DockPanel) {
        let is_docked = !self.state.look.panels.state(panel).is_floating;
        if is_docked && self.dock.without_room.contains(&panel) {
            self.change_panel(ctx, panel, PanelRequest::PopOut);
        } else {
            self.state.look.panels.toggle(panel);
        }
    }

    /// Sizes the docked panels; returns the tabs that have a bar, and the columns that cannot be resized.
    fn fit_panels(&self, dock: &mut Dock, area: Rect) -> (HashSet<TileId>, HashSet<TileId>) {
        let details = dock.details_height.min((area.height() - MIN_BESIDE_DETAILS).max(0.0));
        let height = |panel: DockPanel| self.height_of(panel, details);
        let Some(root) = dock.tree.root else { return Default::default() };
        let mut sizes = Sizes {
            tiles: &mut dock.tree.tiles,
            kept: &mut dock.kept,
            height: &height,
            table_width: self.table_width(),
            bars: Default::default(),
            rigid: Default::default(),
        };
        sizes.fit(root, area.size());
        (sizes.bars, sizes.rigid)
    }

    /// Does what was chosen for a panel in a menu.
    pub(in crate::app) fn change_panel(&mut self, ctx: &Context, panel: DockPanel, request: PanelRequest) {
        match request {
            PanelRequest::PopOut => {
                let corner = self.dock.rect(panel).map(|rect| rect.min + egui::vec2(24.0, 24.0));
                self.dock.popped_out = corner.map(|at| (panel, at));
                self.state.look.panels.pop_out(panel);
            }
            PanelRequest::Dock => self.state.look.panels.dock(panel),
            PanelRequest::Move(edge) => {
                self.dock.move_to(panel, edge);
                self.state.look.panels.dock(panel);
            }
            PanelRequest::Hide => self.state.look.panels.close(panel),
            PanelRequest::Reset => self.state.look.panels.reset(),
        }
        ctx.request_repaint();
    }

    /// The layout, if it differs from the stored one and no panel is being moved.
    pub(in crate::app) fn changed_layout(&mut self, ctx: &Context) -> Option<Layout> {
        if ctx.input(|input| input.pointer.any_down()) || self.state.look.panels.wants_reset {
            return None;
        }
        let dock = &mut self.dock;
        let panels = &self.state.look.panels;
        let layout = stored::layout_of(&dock.tree, &dock.kept, &dock.fronts, panels, &dock.windows)?;
        (layout != dock.stored).then(|| {
            dock.stored.clone_from(&layout);
            layout
        })
    }

    /// Arranges the panels by a stored layout.
    pub(in crate::app) fn take_layout(&mut self, layout: &Layout) {
        self.dock = Dock::from_layout(layout);
        self.state.look.panels = layout.panels();
    }
}
