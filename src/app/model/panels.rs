//! The panels of the window, which of them are open, and which float in a window of their own.

use serde::{Deserialize, Serialize};

/// A panel of the window. It is docked beside the others, or pops out into a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DockPanel {
    /// Part, operations, and the form of the selected operation.
    Setup,
    /// The 3D view; it is always docked.
    Picture,
    /// Plots along the row of the selected position.
    Plots,
    /// Rotary axes of the machine over the program.
    Axes,
    /// The timeline.
    Timeline,
    /// Table of positions or passes, or list of faults.
    Table,
    /// The selected position, or the results of flank milling.
    Details,
    /// The sectional view, enlarged.
    SectionalView,
    /// The machinability of the part.
    Machinability,
    /// Time against stock.
    Tradeoff,
    /// The tools of the shop.
    ToolLibrary,
    /// The results of a study.
    Study,
}

impl DockPanel {
    /// All panels, in the order of menus.
    pub const ALL: [Self; 12] = [
        Self::Setup,
        Self::Picture,
        Self::Plots,
        Self::Axes,
        Self::Timeline,
        Self::Table,
        Self::Details,
        Self::SectionalView,
        Self::Machinability,
        Self::Tradeoff,
        Self::ToolLibrary,
        Self::Study,
    ];

    /// Title of its tab, window and menu item.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Setup => "Setup",
            Self::Picture => "3D view",
            Self::Plots => "Plots along the row",
            Self::Axes => "Rotary axes",
            Self::Timeline => "Timeline",
            Self::Table => "Table",
            Self::Details => "Details",
            Self::SectionalView => "Sectional view, enlarged",
            Self::Machinability => "Machinability",
            Self::Tradeoff => "Time against stock",
            Self::ToolLibrary => "Shop library",
            Self::Study => "Study results",
        }
    }

    /// What it shows, in one sentence.
    pub fn tip(self) -> &'static str {
        match self {
            Self::Setup => "Part, operations, and what they are planned with",
            Self::Picture => "Part and plan in 3D",
            Self::Plots => "Lead angle, contact, stock, step, engaged arc and chip along a row",
            Self::Axes => "Rotary axes of the machine over the program",
            Self::Timeline => "Position up to which the plan is simulated, and the line of the program",
            Self::Table => "Positions, passes of flank milling, or faults of a program",
            Self::Details => "The selected position, or the results of flank milling",
            Self::SectionalView => "The sectional view through the selected position",
            Self::Machinability => "Twist, depth, width, and what the tools reach",
            Self::Tradeoff => "What less time costs in stock on the hub",
            Self::ToolLibrary => "The tools of the shop",
            Self::Study => "The runs of a study",
        }
    }

    /// Whether it opens by a command, in a window of its own unless it was docked; the others are docked and
    /// open at first.
    pub fn is_window_at_first(self) -> bool {
        match self {
            Self::SectionalView | Self::Machinability | Self::Tradeoff | Self::ToolLibrary | Self::Study => {
                true
            }
            Self::Setup
            | Self::Picture
            | Self::Plots
            | Self::Axes
            | Self::Timeline
            | Self::Table
            | Self::Details => false,
        }
    }

    /// Whether it can be hidden and popped out: all but the 3D view, which the others are arranged about.
    pub fn can_leave(self) -> bool {
        self != Self::Picture
    }

    fn index(self) -> usize {
        self as usize
    }
}

/// Where a panel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PanelState {
    /// Whether it is shown, as soon as it has content.
    pub is_open: bool,
    /// Whether it is in a window of its own. Its place among the docked panels is kept.
    pub is_floating: bool,
}

/// Where all panels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Panels {
    states: [PanelState; DockPanel::ALL.len()],
    /// The panel that was opened last, until it is drawn: its tab comes to the front.
    pub opened: Option<DockPanel>,
    /// Whether the default layout is asked for.
    pub wants_reset: bool,
}

impl Default for Panels {
    fn default() -> Self {
        let state = |panel: DockPanel| PanelState {
            is_open: !panel.is_window_at_first(),
            is_floating: panel.is_window_at_first(),
        };
        Self { states: DockPanel::ALL.map(state), opened: None, wants_reset: false }
    }
}

impl Panels {
    /// Where a panel is.
    pub fn state(&self, panel: DockPanel) -> PanelState {
        self.states[panel.index()]
    }

    /// Sets where a panel is; the 3D view stays.
    pub fn set(&mut self, panel: DockPanel, state: PanelState) {
        if panel.can_leave() {
            self.states[panel.index()] = state;
        }
    }

    /// Whether a panel is open.
    pub fn is_open(&self, panel: DockPanel) -> bool {
        self.state(panel).is_open
    }

    /// Whether a panel is open in a window of its own.
    pub fn floats(&self, panel: DockPanel) -> bool {
        let state = self.state(panel);
        state.is_open && state.is_floating
    }

    /// Opens a panel where it was last; among tabs it comes to the front.
    pub fn open(&mut self, panel: DockPanel) {
        self.set(panel, PanelState { is_open: true, ..self.state(panel) });
        self.opened = Some(panel);
    }

    /// Closes a panel; its content stays.
    pub fn close(&mut self, panel: DockPanel) {
        self.set(panel, PanelState { is_open: false, ..self.state(panel) });
    }

    /// Opens or closes a panel.
    pub fn toggle(&mut self, panel: DockPanel) {
        if self.is_open(panel) { self.close(panel) } else { self.open(panel) }
    }

    /// Opens a panel in a window of its own.
    pub fn pop_out(&mut self, panel: DockPanel) {
        self.set(panel, PanelState { is_open: true, is_floating: true });
    }

    /// Opens a panel at its place among the docked ones.
    pub fn dock(&mut self, panel: DockPanel) {
        self.set(panel, PanelState { is_open: true, is_floating: false });
        self.opened = Some(panel);
    }

    /// What the button of a panel's window does: those that were docked at first return to their place.
    pub fn close_window(&mut self, panel: DockPanel) {
        if panel.is_window_at_first() { self.close(panel) } else { self.dock(panel) }
    }

    /// Asks for the default layout.
    pub fn reset(&mut self) {
        // What a command opened stays open.
        let is_open = DockPanel::ALL.map(|panel| panel.is_window_at_first() && self.is_open(panel));
        *self = Self { wants_reset: true, ..Self::default() };
        for panel in DockPanel::ALL.into_iter().filter(|panel| is_open[panel.index()]) {
            self.open(panel);
        }
        self.opened = None;
    }

    /// Closes the windows that show another part; docked panels stay.
    pub fn begin(&mut self) {
        for panel in [DockPanel::SectionalView, DockPanel::Machinability, DockPanel::Tradeoff] {
            if self.floats(panel) {
                self.close(panel);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_has_its_own_place_and_title() {
        for (k, panel) in DockPanel::ALL.into_iter().enumerate() {
            assert_eq!(panel.index(), k);
            assert!(DockPanel::ALL[..k].iter().all(|other| other.title() != panel.title()), "{panel:?}");
        }
    }

    #[test]
    fn the_3d_view_stays_and_a_popped_out_panel_returns_when_its_window_is_closed() {
        let mut panels = Panels::default();
        panels.close(DockPanel::Picture);
        panels.pop_out(DockPanel::Picture);
        assert_eq!(panels.state(DockPanel::Picture), Panels::default().state(DockPanel::Picture));
        panels.pop_out(DockPanel::Table);
        assert!(panels.floats(DockPanel::Table));
        panels.close_window(DockPanel::Table);
        assert!(panels.is_open(DockPanel::Table) && !panels.floats(DockPanel::Table));
        panels.open(DockPanel::Study);
        assert!(panels.floats(DockPanel::Study));
        panels.close_window(DockPanel::Study);
        assert!(!panels.is_open(DockPanel::Study));
    }

    #[test]
    fn another_part_closes_windows_and_leaves_docked_panels() {
        let mut panels = Panels::default();
        panels.open(DockPanel::Machinability);
        panels.dock(DockPanel::Tradeoff);
        panels.begin();
        assert!(!panels.is_open(DockPanel::Machinability) && panels.is_open(DockPanel::Tradeoff));
        assert!(panels.is_open(DockPanel::Setup));
    }
}
