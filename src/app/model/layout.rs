//! The layout of the panels as it is stored: how the docked ones are arranged, and which are open or float.
//! It belongs to the window, not to a project.

use serde::{Deserialize, Serialize};

use super::panels::{DockPanel, PanelState, Panels};

/// Version of the stored form. Layouts of other versions are not read.
const VERSION: u32 = 1;
/// Greatest size that is accepted, points.
const MAX_SIZE: f32 = 20_000.0;

/// Docked panels: one, or several that share an area.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LayoutNode {
    /// A panel.
    Panel(DockPanel),
    /// Side by side, from the left.
    Row(Vec<LayoutChild>),
    /// One below the other, from the top.
    Column(Vec<LayoutChild>),
    /// One in front of the other, with tabs.
    Tabs {
        /// Index of the one in front.
        active: usize,
        /// What the tabs show, from the left.
        tabs: Vec<Self>,
    },
}

/// What stands in a row or column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayoutChild {
    /// Width in a row, height in a column, points; 0: that of its content.
    pub size: f32,
    /// What stands there.
    pub node: LayoutNode,
}

/// Where a panel's own window is, points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindowPlace {
    /// Upper left corner.
    pub at: [f32; 2],
    /// Its size.
    pub size: [f32; 2],
}

impl WindowPlace {
    fn is_usable(&self) -> bool {
        self.at.iter().all(|x| (-MAX_SIZE..=MAX_SIZE).contains(x))
            && self.size.iter().all(|x| (0.0..=MAX_SIZE).contains(x))
    }
}

/// The layout of the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    version: u32,
    /// The docked panels. All panels have a place, those that float or are closed, too.
    pub docked: LayoutNode,
    panels: Vec<(DockPanel, PanelState)>,
    /// The windows of panels that float or have floated.
    #[serde(default)]
    pub windows: Vec<(DockPanel, WindowPlace)>,
}

impl Default for Layout {
    fn default() -> Self {
        use DockPanel as P;
        let panel = |panel| LayoutChild { size: 0.0, node: LayoutNode::Panel(panel) };
        let tabs = |panels: &[P]| LayoutChild {
            size: 0.0,
            node: LayoutNode::Tabs {
                active: 0,
                tabs: panels.iter().map(|&p| LayoutNode::Panel(p)).collect(),
            },
        };
        let column = |parts| LayoutChild { size: 0.0, node: LayoutNode::Column(parts) };
        let middle = [P::Picture, P::Plots, P::Axes, P::Timeline].map(panel);
        let table = tabs(&[P::Table, P::Machinability, P::Tradeoff, P::ToolLibrary, P::Study]);
        let right = vec![table, tabs(&[P::Details, P::SectionalView])];
        let docked = LayoutNode::Row(vec![panel(P::Setup), column(middle.into()), column(right)]);
        Self::new(docked, &Panels::default(), Vec::new())
    }
}

impl Layout {
    /// The layout of `docked` panels that are open and float as `panels` says, in these `windows`.
    pub fn new(docked: LayoutNode, panels: &Panels, windows: Vec<(DockPanel, WindowPlace)>) -> Self {
        let states = DockPanel::ALL.into_iter().map(|panel| {
            let state = panels.state(panel);
            // A window that a command opened is not opened by the next start.
            let is_open = state.is_open && !(state.is_floating && panel.is_window_at_first());
            (panel, PanelState { is_open, ..state })
        });
        Self { version: VERSION, docked, panels: states.collect(), windows }
    }

    /// Reads a stored layout; `None` if it is damaged, of another version, or lacks a panel.
    pub fn read(text: &str) -> Option<Self> {
        let layout: Self = serde_json::from_str(text).ok()?;
        let mut found = Vec::new();
        let has_sizes = check(&layout.docked, &mut found);
        let has_all = DockPanel::ALL.iter().all(|panel| found.contains(panel));
        let once = found.len() == DockPanel::ALL.len();
        let has_places = layout.windows.iter().all(|(_, place)| place.is_usable());
        (layout.version == VERSION && has_sizes && has_places && has_all && once).then_some(layout)
    }

    /// The stored form.
    pub fn write(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// Which panels are open and float.
    pub fn panels(&self) -> Panels {
        let mut panels = Panels::default();
        for &(panel, state) in &self.panels {
            panels.set(panel, state);
        }
        panels
    }
}

/// Adds the panels of `node` to `found`; `false` if a container is empty or a size out of range.
fn check(node: &LayoutNode, found: &mut Vec<DockPanel>) -> bool {
    match node {
        LayoutNode::Panel(panel) => {
            found.push(*panel);
            true
        }
        LayoutNode::Row(parts) | LayoutNode::Column(parts) => {
            !parts.is_empty()
                && parts.iter().all(|part| (0.0..=MAX_SIZE).contains(&part.size) && check(&part.node, found))
        }
        LayoutNode::Tabs { active, tabs } => *active < tabs.len() && tabs.iter().all(|tab| check(tab, found)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_is_read_as_it_was_written() {
        let mut panels = Panels::default();
        panels.pop_out(DockPanel::Table);
        panels.close(DockPanel::Timeline);
        panels.dock(DockPanel::Study);
        panels.open(DockPanel::Machinability);
        let place = WindowPlace { at: [40.0, 60.0], size: [300.0, 420.0] };
        let layout = Layout::new(Layout::default().docked, &panels, vec![(DockPanel::Table, place)]);
        let read = Layout::read(&layout.write()).expect("a layout");
        assert_eq!(read, layout);
        let read = read.panels();
        assert!(read.floats(DockPanel::Table) && !read.is_open(DockPanel::Timeline));
        assert!(read.is_open(DockPanel::Study) && !read.floats(DockPanel::Study));
        assert!(!read.is_open(DockPanel::Machinability), "a window of a command is closed at the start");
    }

    #[test]
    fn a_damaged_or_other_layout_is_not_read() {
        let text = Layout::default().write();
        assert!(Layout::read(&text).is_some());
        let deep = format!("{}{}", "[".repeat(5_000), "]".repeat(5_000));
        let faulty = [
            "",
            "{}",
            &text[..text.len() / 2],
            &text.replace("\"version\": 1", "\"version\": 2"),
            // A panel twice, another one missing.
            &text.replacen("\"setup\"", "\"table\"", 1),
            &text.replacen("\"timeline\"", "\"unheard_of\"", 1),
            &text.replacen("\"size\": 0.0", "\"size\": -5.0", 1),
            &text.replacen("\"size\": 0.0", "\"size\": 1e30", 1),
            &text.replacen("\"active\": 0", "\"active\": 9", 1),
            &text.replacen("\"row\"", "\"heap\"", 1),
            &deep,
        ];
        for text in faulty {
            assert_eq!(Layout::read(text), None, "{}", &text[..text.len().min(200)]);
        }
    }
}
