//! Keys in the order in which they were pressed, also in slow frames.
//!
//! A slow frame brings several keys at once. With the key Tab among them egui moves the focus before widgets
//! take the keys of the frame: what was typed before Tab and behind it would go to both fields.

use egui::{Context, Event, Key, Plugin, RawInput};

/// Holds back keys until the focus is where it was when they were pressed.
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
/// typed behind Tab.
fn count_of_one_focus(events: &[Event]) -> usize {
    let is_tab = |event: &Event| matches!(event, Event::Key { key: Key::Tab, pressed: true, .. });
    let is_typed = |event: &Event| {
        let is_press = matches!(event, Event::Key { pressed: true, .. } | Event::Text(_) | Event::Paste(_));
        is_press && !is_tab(event)
    };
    let Some(tab) = events.iter().position(is_tab) else { return events.len() };
    if events[..tab].iter().any(is_typed) {
        return tab;
    }
    let behind = |event: &Event| is_tab(event) || is_typed(event);
    events[tab + 1..].iter().position(behind).map_or(events.len(), |k| tab + 1 + k)
}

#[cfg(test)]
mod tests {
    use egui::Modifiers;

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
}
