//! The windows over the picture, closed by Escape before it cancels anything.

use egui::{Context, Id, Key, Modifiers};

use crate::app::App;
use crate::app::model::panels::DockPanel;
use crate::app::views::dock;

/// Whether a field is typed in, or was in the frame before: Escape has taken the focus from it already. Call
/// once per frame.
pub(in crate::app) fn is_typing(ctx: &Context) -> bool {
    let key = Id::unique("a field is typed in");
    let (now, before) = (ctx.text_edit_focused(), ctx.data(|data| data.get_temp::<bool>(key)));
    ctx.data_mut(|data| data.insert_temp(key, now));
    now || before.unwrap_or_default()
}

impl App {
    /// Closes the window in front if Escape was pressed; `true` while there is one, which has that key first.
    /// A field that is typed in ([`is_typing`]) gives up the focus before its window closes, and a search in
    /// the window in front is cancelled first.
    pub(in crate::app) fn escape_closes_window(&mut self, ctx: &Context, typing: bool) -> bool {
        let Some(front) = dock::in_front(ctx, &self.state.look.panels) else { return false };
        if !typing && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
            if front == DockPanel::Tradeoff && self.weighing.is_busy() {
                self.cancel_curve();
            } else {
                self.state.look.panels.close(front);
            }
        }
        true
    }
}
