//! The tab in front of each area with tabs, also while it has nothing to show and another one stands there.

use std::collections::HashMap;

use egui_tiles::{Container, Tile, TileId, Tree};

use crate::app::model::panels::DockPanel;

/// The chosen tab of each container of tabs.
#[derive(Clone, Debug, Default)]
pub struct FrontTabs(HashMap<TileId, TileId>);

impl FrontTabs {
    /// The tabs in front in `tree`.
    pub fn from_tree(tree: &Tree<DockPanel>) -> Self {
        let fronts = tree.tiles.iter().filter_map(|(&id, tile)| match tile {
            Tile::Container(Container::Tabs(tabs)) => Some((id, tabs.active?)),
            _ => None,
        });
        Self(fronts.collect())
    }

    /// The tab in front of the container `id`, seen or not.
    pub fn get(&self, id: TileId) -> Option<TileId> {
        self.0.get(&id).copied()
    }

    /// Brings the chosen tabs to the front that have something to show again.
    pub fn restore(&self, tree: &mut Tree<DockPanel>) {
        for (&id, &front) in &self.0 {
            if !tree.tiles.is_visible_in_layout(front) {
                continue;
            }
            if let Some(Tile::Container(Container::Tabs(tabs))) = tree.tiles.get_mut(id)
                && tabs.children.contains(&front)
            {
                tabs.active = Some(front);
            }
        }
    }

    /// Takes over what was chosen in `tree`. Where the chosen tab has nothing to show, the one that stands
    /// there instead was not chosen.
    pub fn follow(&mut self, tree: &Tree<DockPanel>) {
        let hidden = |id: &TileId, front: &TileId| {
            let is_hidden = !tree.tiles.is_visible_in_layout(*front);
            is_hidden && tree.tiles.get_container(*id).is_some_and(|container| container.has_child(*front))
        };
        let mut fronts = Self::from_tree(tree).0;
        fronts.extend(self.0.iter().filter(|(id, front)| hidden(id, front)).map(|(id, front)| (*id, *front)));
        self.0 = fronts;
    }
}
