//! From the tree of the docked panels to the stored layout, and back.

use std::collections::HashMap;

use egui::Id;
use egui_tiles::{Container, Linear, LinearDir, Tabs, Tile, TileId, Tiles, Tree};

use super::fronts::FrontTabs;
use super::sizes::KeptSize;
use crate::app::model::layout::{Layout, LayoutChild, LayoutNode, WindowPlace};
use crate::app::model::panels::{DockPanel, Panels};

/// The tree of a stored layout.
pub fn tree_of(node: &LayoutNode) -> Tree<DockPanel> {
    let mut tiles = Tiles::default();
    let root = insert(&mut tiles, node);
    Tree::new(Id::unique("docked panels"), root, tiles)
}

fn insert(tiles: &mut Tiles<DockPanel>, node: &LayoutNode) -> TileId {
    match node {
        LayoutNode::Panel(panel) => tiles.insert_pane(*panel),
        LayoutNode::Row(parts) => insert_linear(tiles, LinearDir::Horizontal, parts),
        LayoutNode::Column(parts) => insert_linear(tiles, LinearDir::Vertical, parts),
        LayoutNode::Tabs { active, tabs } => {
            let children: Vec<TileId> = tabs.iter().map(|tab| insert(tiles, tab)).collect();
            let active = children.get(*active).copied();
            tiles.insert_container(Tabs { children, active })
        }
    }
}

fn insert_linear(tiles: &mut Tiles<DockPanel>, dir: LinearDir, parts: &[LayoutChild]) -> TileId {
    let children: Vec<TileId> = parts.iter().map(|part| insert(tiles, &part.node)).collect();
    let mut linear = Linear::new(dir, children.clone());
    children.into_iter().zip(parts).for_each(|(child, part)| linear.shares.set_share(child, part.size));
    tiles.insert_container(linear)
}

/// The layout of a tree; `None` for an empty one. `kept`: sizes set by hand of tiles that have another one
/// now.
pub fn layout_of(
    tree: &Tree<DockPanel>,
    kept: &HashMap<TileId, KeptSize>,
    fronts: &FrontTabs,
    panels: &Panels,
    windows: &HashMap<DockPanel, WindowPlace>,
) -> Option<Layout> {
    let docked = node_of(&tree.tiles, kept, fronts, tree.root?)?;
    let windows = DockPanel::ALL.into_iter().filter_map(|panel| Some((panel, *windows.get(&panel)?)));
    Some(Layout::new(docked, panels, windows.collect()))
}

fn node_of(
    tiles: &Tiles<DockPanel>,
    kept: &HashMap<TileId, KeptSize>,
    fronts: &FrontTabs,
    id: TileId,
) -> Option<LayoutNode> {
    let container = match tiles.get(id)? {
        Tile::Pane(panel) => return Some(LayoutNode::Panel(*panel)),
        Tile::Container(container) => container,
    };
    let nodes =
        || container.children().filter_map(|&child| Some((child, node_of(tiles, kept, fronts, child)?)));
    Some(match container {
        Container::Tabs(tabs) => {
            let front = fronts.get(id).or(tabs.active);
            let active = nodes().position(|(child, _)| Some(child) == front).unwrap_or(0);
            LayoutNode::Tabs { active, tabs: nodes().map(|(_, node)| node).collect() }
        }
        Container::Linear(linear) => {
            let part = |(child, node)| {
                let size = kept.get(&child).map_or(linear.shares[child], |kept| kept.own);
                // What holds the 3D view takes what is left in a window of any size.
                let size = if holds_picture(&node) { 0.0 } else { size.round() };
                LayoutChild { size, node }
            };
            let parts = nodes().map(part).collect();
            match linear.dir {
                LinearDir::Horizontal => LayoutNode::Row(parts),
                LinearDir::Vertical => LayoutNode::Column(parts),
            }
        }
        // None is ever made.
        Container::Grid(_) => {
            LayoutNode::Row(nodes().map(|(_, node)| LayoutChild { size: 0.0, node }).collect())
        }
    })
}

fn holds_picture(node: &LayoutNode) -> bool {
    match node {
        LayoutNode::Panel(panel) => *panel == DockPanel::Picture,
        LayoutNode::Row(parts) | LayoutNode::Column(parts) => {
            parts.iter().any(|part| holds_picture(&part.node))
        }
        LayoutNode::Tabs { tabs, .. } => tabs.iter().any(holds_picture),
    }
}
