//! Scrolling of the table of positions.

/// Scrolling of the table of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableScroll {
    /// Distance from the top of the first row to the top of the table, points.
    pub offset: f32,
    /// Height of its rows, points.
    pub height: f32,
    /// Whether the table was not drawn yet: it then starts at the top.
    pub is_new: bool,
}

impl Default for TableScroll {
    fn default() -> Self {
        Self { offset: 0.0, height: 0.0, is_new: true }
    }
}

impl TableScroll {
    /// The offset nearest to the present one at which row `index` of `pitch` points is in view, in a table
    /// with `height` points of rows.
    pub fn showing(&self, index: usize, pitch: f32, height: f32) -> f32 {
        let top = index as f32 * pitch;
        self.offset.min(top).max(top + pitch - height.max(pitch))
    }

    /// Whether row `index` of `pitch` points was in view, but is not in a table of `height` points: the panel
    /// below grew over it.
    pub fn loses(&self, index: usize, pitch: f32, height: f32) -> bool {
        let top = index as f32 * pitch;
        let within = |height: f32| top >= self.offset && top + pitch <= self.offset + height + 0.5;
        within(self.height) && !within(height)
    }
}
