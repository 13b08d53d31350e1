//! The windows over the picture, closed by Escape before it cancels anything.

use egui::{Context, Key, Modifiers};

use crate::app::App;
use crate::app::model::panels::DockPanel;
use crate::app::views::dock;

impl App {
    /// Closes the window in front if Escape was pressed; `true` while there is one, which has that key first.
    /// A field that is typed in gives up the focus before its window closes, and a search in the window in
    /// front is cancelled first.
    pub(in crate::app) fn escape_closes_window(&mut self, ctx: &Context) -> bool {
        let Some(front) = dock::in_front(ctx, &self.state.look.panels) else { return false };
        if front == DockPanel::Tradeoff && self.weighing.is_busy() {
            return false;
        }
        let typing = ctx.text_edit_focused();
        if !typing && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
            self.state.look.panels.close(front);
        }
        true
    }
}
