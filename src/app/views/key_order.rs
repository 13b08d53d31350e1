//! Keys in the order in which they were pressed, also in slow frames.
//!
//! A slow frame brings several keys and clicks at once. egui moves the focus by the key Tab before widgets
//! take the keys of the frame: what was typed before Tab and behind it would go to both fields. And what a
//! click, Enter or a shortcut opens is there only at the end of the frame: what was typed behind them would
//! go to the window below.

use egui::{Context, Event, Key, Plugin, RawInput};

/// Holds back keys until what they were pressed for is there.
#[derive(Debug, Default)]
pub struct KeyOrder {
    /// Events of later frames.
    later: Vec<Event>,
}

impl Plugin for KeyOrder {
    fn debug_name(&self) -> &'static str {
        "key order"
    }

    fn input_hook(&mut self, ctx: &Context, input: &mut RawInput) {
        self.later.append(&mut input.events);
        let rest = self.later.split_off(count_of_one_focus(&self.later));
        input.events = std::mem::replace(&mut self.later, rest);
        if !self.later.is_empty() {
            ctx.request_repaint();
        }
    }
}

/// Number of the first `events` that belong into one frame: up to where Tab moves the focus, or up to what is
/// typed behind Tab, Enter, a shortcut or a click.
fn count_of_one_focus(events: &[Event]) -> usize {
    let (mut typed, mut moved) = (false, false);
    for (k, event) in events.iter().enumerate() {
        let is_press = matches!(event, Event::Key { pressed: true, .. } | Event::Text(_) | Event::Paste(_));
        let is_tab = matches!(event, Event::Key { key: Key::Tab, pressed: true, .. });
        if is_press && moved || is_tab && typed {
            return k;
        }
        typed |= is_press && !is_tab;
        moved |= is_tab || opens(event);
    }
    events.len()
}

/// Whether an event may open something that takes the keys behind it.
fn opens(event: &Event) -> bool {
    match event {
        Event::Key { key, pressed: true, modifiers, .. } => *key == Key::Enter || modifiers.command,
        Event::PointerButton { pressed, .. } => !pressed,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use egui::{Modifiers, PointerButton, Pos2};

    use super::*;

    fn press(key: Key) -> Event {
        Event::Key { key, pressed: true, modifiers: Modifiers::NONE, repeat: false, physical_key: None }
    }

    #[test]
    fn each_frame_has_the_keys_of_one_field() {
        let mut events = vec![
            Event::Text("1".into()),
            press(Key::Tab),
            Event::PointerGone,
            Event::Text("2".into()),
            press(Key::Tab),
            press(Key::Tab),
            press(Key::Enter),
        ];
        let mut frames = Vec::new();
        while !events.is_empty() {
            let rest = events.split_off(count_of_one_focus(&events));
            frames.push(events.len());
            events = rest;
        }
        assert_eq!(frames, [1, 2, 1, 1, 1, 1]);
        assert_eq!(count_of_one_focus(&[Event::PointerGone, press(Key::B)]), 2, "nothing waits without Tab");
    }

    #[test]
    fn keys_behind_what_opens_a_dialog_wait_for_it() {
        let button = |pressed| Event::PointerButton {
            pos: Pos2::ZERO,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        let shortcut = Event::Key {
            key: Key::E,
            pressed: true,
            modifiers: Modifiers::COMMAND,
            repeat: false,
            physical_key: None,
        };
        let text = || Event::Text("l".into());
        assert_eq!(count_of_one_focus(&[button(true), button(false), press(Key::L), text()]), 2, "a click");
        assert_eq!(count_of_one_focus(&[shortcut, press(Key::L), text()]), 1, "a shortcut");
        assert_eq!(count_of_one_focus(&[text(), press(Key::Enter), text()]), 2, "Enter");
        assert_eq!(count_of_one_focus(&[press(Key::L), text(), text()]), 3, "what is typed stays together");
    }
}
