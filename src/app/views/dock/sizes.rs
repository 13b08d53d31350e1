//! Sizes of the docked panels. The shares that `egui_tiles` divides an area by are kept in points: what holds
//! the 3D view takes what the others leave, so that these keep their size in a larger window.

use std::collections::{HashMap, HashSet};

use egui::Vec2;
use egui_tiles::{Container, LinearDir, Tile, TileId, Tiles};

use crate::app::model::panels::DockPanel;
use crate::app::views::theme;

/// Width of the line between panels, points.
pub const GAP: f32 = 1.0;
/// Height of a bar of tabs, points.
pub const TAB_BAR: f32 = 24.0;
/// Shares below this are not sizes: those of a tile that was just put somewhere.
const MIN_SHARE: f32 = 20.0;
/// Least part of a row or column that what holds the 3D view gets.
const MIN_PICTURE_SHARE: f32 = 0.25;
/// Least height of a panel, points.
const MIN_HEIGHT: f32 = 60.0;
/// Share of a column that a panel gets that was not resized.
const HEIGHT_SHARE: f32 = 0.38;
/// The same of the table, below which the others stand.
const TABLE_SHARE: f32 = 0.62;

/// Width of a panel that was not resized, and its least width, points. Those at the sides of the window end
/// with the line. `table`: width that the columns of the table need.
fn widths(panel: DockPanel, table: f32) -> (f32, f32) {
    match panel {
        DockPanel::Setup => (theme::LEFT_WIDTH - GAP, 200.0 - GAP),
        DockPanel::Table => (table.max(theme::RIGHT_WIDTH - GAP), table.max(240.0 - GAP)),
        DockPanel::Details => (theme::RIGHT_WIDTH - GAP, 240.0 - GAP),
        DockPanel::ToolLibrary => (620.0, 240.0),
        DockPanel::Study | DockPanel::Machinability => (480.0, 240.0),
        DockPanel::Tradeoff | DockPanel::SectionalView => (400.0, 240.0),
        DockPanel::Picture | DockPanel::Plots | DockPanel::Axes | DockPanel::Timeline => (400.0, 100.0),
    }
}

/// A size set by hand, and the one that is in force instead, points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptSize {
    /// Set by hand.
    pub own: f32,
    in_force: f32,
}

/// Sizes the tiles of a tree before they are laid out.
pub struct Sizes<'a> {
    /// The tiles.
    pub tiles: &'a mut Tiles<DockPanel>,
    /// What a tile was sized to by hand before its content needed another size.
    pub kept: &'a mut HashMap<TileId, KeptSize>,
    /// Height of a panel that is as high as its content, points.
    pub height: &'a dyn Fn(DockPanel) -> Option<f32>,
    /// Width that the columns of the table need, points.
    pub table_width: f32,
    /// Tabs that have a bar: of more than one panel.
    pub bars: HashSet<TileId>,
    /// Columns with no border to drag.
    pub rigid: HashSet<TileId>,
}

impl Sizes<'_> {
    /// Sizes what is in the tile `id`, which is `size` points large.
    pub fn fit(&mut self, id: TileId, size: Vec2) {
        let Some(container) = self.tiles.get_container(id) else { return };
        let children = self.shown(container);
        match container {
            Container::Tabs(_) => {
                let bar = if children.len() > 1 { TAB_BAR } else { 0.0 };
                if children.len() > 1 {
                    self.bars.insert(id);
                }
                children.into_iter().for_each(|child| self.fit(child, size - Vec2::new(0.0, bar)));
            }
            Container::Linear(linear) => {
                let (dir, shares) =
                    (linear.dir, children.iter().map(|&child| linear.shares[child]).collect());
                self.fit_linear(id, dir, size, &children, shares);
            }
            // None is ever made.
            Container::Grid(_) => {}
        }
    }

    fn fit_linear(
        &mut self,
        id: TileId,
        dir: LinearDir,
        size: Vec2,
        children: &[TileId],
        mut shares: Vec<f32>,
    ) {
        let is_column = dir == LinearDir::Vertical;
        let whole = if is_column { size.y } else { size.x };
        let extent = (whole - GAP * children.len().saturating_sub(1) as f32).max(1.0);
        let (mut free, mut owns) = (Vec::new(), Vec::new());
        let mut taken = 0.0;
        for (k, (&child, share)) in children.iter().zip(&mut shares).enumerate() {
            // What is in force may have been resized by hand since.
            let kept = self.kept.remove(&child).filter(|kept| (kept.in_force - *share).abs() < 0.5);
            let own = kept.map_or(*share, |kept| kept.own);
            match self.height_of(child).filter(|_| is_column) {
                Some(height) => {
                    *share = height;
                    taken += height;
                }
                None => {
                    let (default, least) = self.default_and_least(child, is_column, extent);
                    *share = if own < MIN_SHARE { default } else { own.max(least) };
                    free.push(k);
                }
            }
            owns.push(own);
        }
        if is_column && free.len() < 2 {
            self.rigid.insert(id);
        }
        let picture = free.iter().copied().find(|&k| self.holds_picture(children[k]));
        if let Some(picture) = picture {
            let others: f32 = free.iter().filter(|&&k| k != picture).map(|&k| shares[k]).sum();
            shares[picture] = (extent - taken - others).max(MIN_PICTURE_SHARE * extent);
        } else if let Some((&last, others)) = free.split_last() {
            let sum: f32 = free.iter().map(|&k| shares[k]).sum();
            let scale = (extent - taken).max(MIN_HEIGHT) / sum;
            let mut rest = (extent - taken).max(MIN_HEIGHT);
            for &k in others {
                shares[k] *= scale;
                rest -= shares[k];
            }
            shares[last] = rest;
        }
        for (k, (&child, &own)) in children.iter().zip(&owns).enumerate() {
            if Some(k) != picture && shares[k] != own {
                self.kept.insert(child, KeptSize { own, in_force: shares[k] });
            }
        }
        let sum: f32 = shares.iter().sum();
        if let Some(Tile::Container(Container::Linear(linear))) = self.tiles.get_mut(id) {
            children.iter().zip(&shares).for_each(|(&child, &share)| linear.shares.set_share(child, share));
        }
        for (&child, share) in children.iter().zip(&shares) {
            let part = extent * share / sum;
            self.fit(child, if is_column { Vec2::new(size.x, part) } else { Vec2::new(part, size.y) });
        }
    }

    /// Visible children of a container.
    fn shown(&self, container: &Container) -> Vec<TileId> {
        shown_children(self.tiles, container).collect()
    }

    /// Height of a tile whose panels are all as high as their content.
    fn height_of(&self, id: TileId) -> Option<f32> {
        let container = match self.tiles.get(id)? {
            Tile::Pane(panel) => return (self.height)(*panel),
            Tile::Container(container) => container,
        };
        let children = self.shown(container);
        let heights: Vec<f32> = children.iter().map(|&child| self.height_of(child)).collect::<Option<_>>()?;
        let highest = heights.iter().copied().fold(0.0, f32::max);
        Some(match container {
            Container::Tabs(_) if heights.len() > 1 => highest + TAB_BAR,
            Container::Linear(linear) if linear.dir == LinearDir::Vertical => {
                heights.iter().sum::<f32>() + GAP * heights.len().saturating_sub(1) as f32
            }
            _ => highest,
        })
    }

    /// Size of a tile that was not resized, and its least size.
    fn default_and_least(&self, id: TileId, is_column: bool, extent: f32) -> (f32, f32) {
        let mut panels = self.panels_in(id);
        // What a command opens as a tab does not move its neighbours.
        if panels.iter().any(|panel| !panel.is_window_at_first()) {
            panels.retain(|panel| !panel.is_window_at_first());
        }
        if is_column {
            let share = if panels.contains(&DockPanel::Table) { TABLE_SHARE } else { HEIGHT_SHARE };
            return (share * extent, MIN_HEIGHT);
        }
        let all = panels.into_iter().map(|panel| widths(panel, self.table_width));
        all.fold((0.0, 0.0), |widest, one| (widest.0.max(one.0), widest.1.max(one.1)))
    }

    fn holds_picture(&self, id: TileId) -> bool {
        holds_picture(self.tiles, id)
    }

    fn panels_in(&self, id: TileId) -> Vec<DockPanel> {
        panels_in(self.tiles, id)
    }
}

/// The children of a container that are shown.
pub fn shown_children<'t>(
    tiles: &'t Tiles<DockPanel>,
    container: &'t Container,
) -> impl Iterator<Item = TileId> + 't {
    container.children().copied().filter(|&child| tiles.is_visible_in_layout(child))
}

/// Whether a tile is the 3D view or contains it.
pub fn holds_picture(tiles: &Tiles<DockPanel>, id: TileId) -> bool {
    panels_in(tiles, id).contains(&DockPanel::Picture)
}

/// The panels in a tile that are shown.
fn panels_in(tiles: &Tiles<DockPanel>, id: TileId) -> Vec<DockPanel> {
    match tiles.get(id) {
        Some(Tile::Pane(panel)) => vec![*panel],
        Some(Tile::Container(container)) => {
            shown_children(tiles, container).flat_map(|child| panels_in(tiles, child)).collect()
        }
        None => Vec::new(),
    }
}
