//! Mouse control of the camera: a table of presets that match other programs.

use egui::{Modifiers, PointerButton};

use crate::app::model::mouse_preset::MousePreset;
use crate::app::views::command::Command;

/// Effect of a drag on the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// Orbits around the grabbed point.
    Orbit,
    /// Pans; the grabbed point stays under the cursor.
    Pan,
    /// Zooms towards the grabbed point (down) or away from it (up).
    Zoom,
}

/// One line of a preset: button, modifiers, and the effect of a drag with them.
type Hold = (PointerButton, Modifiers, Gesture);

const LEFT: PointerButton = PointerButton::Primary;
const MIDDLE: PointerButton = PointerButton::Middle;
const RIGHT: PointerButton = PointerButton::Secondary;
const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::CTRL;
const ALT: Modifiers = Modifiers::ALT;
const ALT_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::ALT };
const ALT_CTRL: Modifiers = Modifiers { ctrl: true, ..Modifiers::ALT };

/// The presets. Of a button's lines, the first whose modifiers are all held applies.
const PRESETS: [(MousePreset, Command, &[Hold]); 5] = {
    use Gesture::{Orbit, Pan, Zoom};
    [
        (
            MousePreset::Vanecut,
            Command::MouseVanecut,
            &[(LEFT, SHIFT, Pan), (LEFT, NONE, Orbit), (MIDDLE, NONE, Pan)],
        ),
        (
            MousePreset::Nx,
            Command::MouseNx,
            &[(MIDDLE, SHIFT, Pan), (MIDDLE, CTRL, Zoom), (MIDDLE, NONE, Orbit)],
        ),
        (
            MousePreset::Solidworks,
            Command::MouseSolidworks,
            &[(MIDDLE, CTRL, Pan), (MIDDLE, SHIFT, Zoom), (MIDDLE, NONE, Orbit)],
        ),
        (
            MousePreset::Onshape,
            Command::MouseOnshape,
            &[(RIGHT, CTRL, Pan), (RIGHT, NONE, Orbit), (MIDDLE, NONE, Pan)],
        ),
        (
            MousePreset::Blender,
            Command::MouseBlender,
            &[
                (MIDDLE, SHIFT, Pan),
                (MIDDLE, CTRL, Zoom),
                (MIDDLE, NONE, Orbit),
                (LEFT, ALT_SHIFT, Pan),
                (LEFT, ALT_CTRL, Zoom),
                (LEFT, ALT, Orbit),
            ],
        ),
    ]
};

impl MousePreset {
    /// All presets, each with the command that selects it.
    pub fn all() -> impl Iterator<Item = (Self, Command)> {
        PRESETS.iter().map(|&(preset, command, _)| (preset, command))
    }

    /// The preset that a command selects.
    pub fn from_command(command: Command) -> Option<Self> {
        Self::all().find(|&(_, of)| of == command).map(|(preset, _)| preset)
    }

    fn holds(self) -> &'static [Hold] {
        PRESETS.iter().find(|(preset, ..)| *preset == self).map_or(&[], |(.., holds)| holds)
    }

    /// Effect of a drag with `button` while the modifiers `held` are pressed; `None`: no effect.
    pub fn gesture(self, button: PointerButton, held: Modifiers) -> Option<Gesture> {
        let all_held = |wanted: Modifiers| {
            (held.shift || !wanted.shift) && (held.ctrl || !wanted.ctrl) && (held.alt || !wanted.alt)
        };
        let lines = self.holds().iter();
        lines.copied().find(|&(b, wanted, _)| b == button && all_held(wanted)).map(|(.., gesture)| gesture)
    }

    /// Help text: one line per gesture.
    pub fn help(self) -> String {
        let mut lines: Vec<String> = Vec::new();
        for (gesture, does) in [
            (Gesture::Orbit, "orbit around the point under the cursor"),
            (Gesture::Pan, "pan"),
            (Gesture::Zoom, "zoom"),
        ] {
            let ways = self.holds().iter().filter(|(.., g)| *g == gesture);
            let ways: Vec<String> = ways.map(|&(button, held, _)| words(button, held)).collect();
            if !ways.is_empty() {
                lines.push(format!("Drag with {}: {does}", ways.join(", or ")));
            }
        }
        lines.push("Wheel: zoom to the cursor".to_owned());
        lines.push("Click: select. Double-click: centre the view here".to_owned());
        lines.push("Right-click: context menu".to_owned());
        lines.join("\n")
    }
}

fn words(button: PointerButton, held: Modifiers) -> String {
    let name = match button {
        LEFT => "left",
        MIDDLE => "middle",
        _ => "right",
    };
    let held = [(held.alt, "alt-"), (held.shift, "shift-"), (held.ctrl, "ctrl-")];
    let held: String = held.iter().filter(|(held, _)| *held).map(|(_, word)| *word).collect();
    format!("{held}{name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_turns_and_moves_and_the_most_modifiers_win() {
        for (preset, _) in MousePreset::all() {
            let does = |gesture| preset.holds().iter().any(|&(.., g)| g == gesture);
            assert!(does(Gesture::Orbit) && does(Gesture::Pan), "{preset:?}");
            for &(button, held, gesture) in preset.holds() {
                assert_eq!(preset.gesture(button, held), Some(gesture), "{preset:?}: a line hides another");
            }
        }
        assert_eq!(MousePreset::Vanecut.gesture(RIGHT, NONE), None);
        assert_eq!(MousePreset::Vanecut.gesture(LEFT, CTRL), Some(Gesture::Orbit), "what is held besides");
        assert!(MousePreset::Nx.help().contains("shift-middle: pan"), "{}", MousePreset::Nx.help());
    }
}
