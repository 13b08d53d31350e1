//! The windows that float over the picture, and which of them is in front.

use egui::{Context, Id, LayerId, Order, Window};

/// A window that floats over the picture until it is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloatingWindow {
    /// The machinability of the part.
    Machinability,
    /// Time against stock.
    Tradeoff,
    /// The tools of the shop.
    ToolLibrary,
    /// The results of a study.
    Study,
    /// The sectional view, enlarged.
    Section,
}

impl FloatingWindow {
    const ALL: [Self; 5] =
        [Self::Machinability, Self::Tradeoff, Self::ToolLibrary, Self::Study, Self::Section];

    fn title(self) -> &'static str {
        match self {
            Self::Machinability => "Machinability",
            Self::Tradeoff => "Time against stock",
            Self::ToolLibrary => "Tool library",
            Self::Study => "Study results",
            Self::Section => "Sectional view, enlarged",
        }
    }

    fn id(self) -> Id {
        Id::unique(("floating window", self.title()))
    }

    /// The window, still without content.
    pub fn window(self) -> Window<'static> {
        Window::new(self.title()).id(self.id())
    }

    /// The one in front; `None` while none is open.
    pub fn in_front(ctx: &Context) -> Option<Self> {
        ctx.memory(|memory| {
            let areas = memory.areas();
            let layers: Vec<LayerId> = memory.layer_ids().collect();
            let of = |layer: &LayerId| {
                Self::ALL.into_iter().find(|w| LayerId::new(Order::Middle, w.id()) == *layer)
            };
            layers.iter().rev().filter(|layer| areas.is_visible(layer)).find_map(of)
        })
    }
}
