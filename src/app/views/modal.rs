//! What a modal dialog does to the window below it.

use egui::{Context, Id};

/// Takes the tooltips of the window away when a modal dialog opens: they would stay over it as long as the pointer
/// rests. To be called before the window is drawn.
pub fn hide_tooltips_below(ctx: &Context) {
    let is_open = ctx.memory(|memory| memory.top_modal_layer()).is_some();
    let was_open = ctx.data_mut(|data| std::mem::replace(data.get_temp_mut_or_default(key()), is_open));
    if is_open && !was_open {
        // A tooltip stays while the pointer is where it was.
        ctx.input_mut(|input| input.pointer = egui::PointerState::default());
    }
}

fn key() -> Id {
    Id::unique("whether a modal dialog was open")
}
