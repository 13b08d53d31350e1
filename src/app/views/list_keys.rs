//! Keys that may be pressed more than once within a slow frame: all of them count, in their order.

use egui::{Context, Event, EventFilter, InputState, Key, Modifiers, Response, Ui};

/// Takes those key presses that `meaning` knows out of the input, and returns what they mean in the order in
/// which they came.
pub fn take_presses<T>(ctx: &Context, mut meaning: impl FnMut(Key, Modifiers) -> Option<T>) -> Vec<T> {
    let mut pressed = Vec::new();
    ctx.input_mut(|input| {
        input.events.retain(|event| {
            let Event::Key { key, pressed: true, modifiers, .. } = event else { return true };
            let known = meaning(*key, *modifiers);
            let is_left = known.is_none();
            pressed.extend(known);
            is_left
        });
    });
    pressed
}

/// Number of entries by which the arrow keys move the choice in a list, whose chosen entry or closed box is
/// `shown`: 0 while that has not the focus, or where its open list takes the keys.
pub fn step(ui: &Ui, shown: &Response) -> isize {
    if !shown.has_focus() || egui::Popup::is_any_open(ui.ctx()) {
        return 0;
    }
    // Otherwise they would move the focus to another field.
    let filter = EventFilter { vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(shown.id, filter));
    ui.input_mut(step_in)
}

/// Number of entries by which the arrow keys in `input` move a choice.
pub fn step_in(input: &mut InputState) -> isize {
    let mut presses = |key: Key| input.count_and_consume_key(Modifiers::NONE, key) as isize;
    presses(Key::ArrowDown) - presses(Key::ArrowUp)
}

/// Index `step` after `now` in a list of `count` entries, which does not begin anew at its ends; `None` where
/// that is `now`.
pub fn moved(now: usize, step: isize, count: usize) -> Option<usize> {
    let to = now.saturating_add_signed(step).min(count.checked_sub(1)?);
    (to != now).then_some(to)
}
