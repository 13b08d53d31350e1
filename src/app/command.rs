//! Everything the window can be told to do: one list for menus, shortcuts and tooltips.

use egui::{Context, Key, KeyboardShortcut, Modifiers, Ui};

/// A command of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // Names, labels and tips say it below; a third wording would only drift.
pub enum Command {
    OpenPart,
    OpenSetup,
    SaveSetup,
    ExportCl,
    SavePicture,
    Quit,
    Undo,
    Redo,
    Plan,
    Cancel,
    NextFault,
    PreviousFault,
    NextPosition,
    PreviousPosition,
    BeforeAfter,
    Fit,
    ViewIso,
    ViewFront,
    ViewTop,
    ViewChannel,
    ViewSection,
    Perspective,
    Hub,
    Blades,
    Shroud,
    Cutters,
    Axes,
    SwitchTheme,
}

impl Command {
    /// All of them; shortcuts are tried in this order, those with more modifiers first where keys agree.
    pub const ALL: [Self; 28] = [
        Self::OpenSetup,
        Self::OpenPart,
        Self::SavePicture,
        Self::SaveSetup,
        Self::ExportCl,
        Self::Quit,
        Self::Redo,
        Self::Undo,
        Self::Plan,
        Self::Cancel,
        Self::PreviousFault,
        Self::NextFault,
        Self::NextPosition,
        Self::PreviousPosition,
        Self::BeforeAfter,
        Self::Fit,
        Self::ViewIso,
        Self::ViewFront,
        Self::ViewTop,
        Self::ViewChannel,
        Self::ViewSection,
        Self::Perspective,
        Self::Hub,
        Self::Blades,
        Self::Shroud,
        Self::Cutters,
        Self::Axes,
        Self::SwitchTheme,
    ];

    /// Text on menu items and buttons.
    pub fn label(self) -> &'static str {
        match self {
            Self::OpenPart => "Open part…",
            Self::OpenSetup => "Open setup…",
            Self::SaveSetup => "Save setup…",
            Self::ExportCl => "Export CL…",
            Self::SavePicture => "Save picture…",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::Plan => "Plan channel",
            Self::Cancel => "Cancel",
            Self::NextFault => "Next interferential",
            Self::PreviousFault => "Previous interferential",
            Self::NextPosition => "Next position",
            Self::PreviousPosition => "Previous position",
            Self::BeforeAfter => "Switch before and after",
            Self::Fit => "Fit",
            Self::ViewIso => "Isometric view",
            Self::ViewFront => "Front view",
            Self::ViewTop => "Top view",
            Self::ViewChannel => "Channel in work",
            Self::ViewSection => "Section in work",
            Self::Perspective => "Switch perspective and parallel",
            Self::Hub => "Hub",
            Self::Blades => "Blades",
            Self::Shroud => "Shroud",
            Self::Cutters => "Cutters",
            Self::Axes => "Axes",
            Self::SwitchTheme => "Switch light and dark",
        }
    }

    /// What it does, in one sentence.
    pub fn tip(self) -> &'static str {
        match self {
            Self::OpenPart => "Opens an impeller: .toml, .geomTurbo or TurboGrid .inf",
            Self::OpenSetup => "Opens a setup (.toml) for the part",
            Self::SaveSetup => "Writes the setup as it stands",
            Self::ExportCl => "Writes the plan shown as \"after\" as an APT cutter-location file",
            Self::SavePicture => "Writes the 3D view as a PNG",
            Self::Quit => "Closes the window",
            Self::Undo => "Takes the last change of the setup back",
            Self::Redo => "Makes the change again",
            Self::Plan => "Plans the channel with the setup as it stands",
            Self::Cancel => "Stops the work; the last good plan stays",
            Self::NextFault => "Selects the next interferential position in cutting order",
            Self::PreviousFault => "Selects the interferential position before",
            Self::NextPosition => "Selects the next position in cutting order",
            Self::PreviousPosition => "Selects the position before",
            Self::BeforeAfter => "Shows the conventional plan (before) or the repaired one (after)",
            Self::Fit => "Brings the whole part into view",
            Self::ViewIso => "The whole wheel from obliquely above",
            Self::ViewFront => "The whole wheel from the side",
            Self::ViewTop => "The whole wheel along its axis",
            Self::ViewChannel => "The channel in work, seen onto its floor",
            Self::ViewSection => "The section of the selected position, else the first",
            Self::Perspective => "Switches between perspective and parallel projection",
            Self::Hub => "Shows the hub with the stock left on it",
            Self::Blades => "Shows the blades",
            Self::Shroud => "Shows the shroud as glass",
            Self::Cutters => "Shows the cutters at the end of their plunges",
            Self::Axes => "Shows the tool axes up to the retract points",
            Self::SwitchTheme => "Switches between light and dark",
        }
    }

    /// The keys.
    pub fn shortcut(self) -> Option<KeyboardShortcut> {
        let ctrl = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
        let ctrl_shift = |key| KeyboardShortcut::new(Modifiers::COMMAND | Modifiers::SHIFT, key);
        let plain = |key| KeyboardShortcut::new(Modifiers::NONE, key);
        let shift = |key| KeyboardShortcut::new(Modifiers::SHIFT, key);
        Some(match self {
            Self::OpenPart => ctrl(Key::O),
            Self::OpenSetup => ctrl_shift(Key::O),
            Self::SaveSetup => ctrl(Key::S),
            Self::ExportCl => ctrl(Key::E),
            Self::SavePicture => ctrl_shift(Key::S),
            Self::Quit => ctrl(Key::Q),
            Self::Undo => ctrl(Key::Z),
            Self::Redo => ctrl(Key::Y),
            Self::Plan => plain(Key::F5),
            Self::Cancel => plain(Key::Escape),
            Self::NextFault => plain(Key::N),
            Self::PreviousFault => shift(Key::N),
            Self::NextPosition => plain(Key::ArrowRight),
            Self::PreviousPosition => plain(Key::ArrowLeft),
            Self::BeforeAfter => plain(Key::B),
            Self::Fit => plain(Key::F),
            Self::ViewIso => plain(Key::Num1),
            Self::ViewFront => plain(Key::Num2),
            Self::ViewTop => plain(Key::Num3),
            Self::ViewChannel => plain(Key::Num4),
            Self::ViewSection => plain(Key::Num5),
            Self::Perspective => plain(Key::P),
            Self::Hub | Self::Blades | Self::Shroud | Self::Cutters | Self::Axes | Self::SwitchTheme => {
                return None;
            }
        })
    }

    /// Commands whose keys were pressed since the last look. Keys that also type or move in a text
    /// field count only while no field has the focus.
    pub fn pressed(ctx: &Context) -> Vec<Self> {
        let typing = ctx.text_edit_focused();
        let mut pressed = Vec::new();
        for command in Self::ALL {
            let Some(shortcut) = command.shortcut() else { continue };
            let types = !shortcut.modifiers.command && shortcut.logical_key != Key::F5;
            if typing && types {
                continue;
            }
            if ctx.input_mut(|input| input.consume_shortcut(&shortcut)) {
                pressed.push(command);
            }
        }
        pressed
    }

    /// Tip with the keys behind it.
    pub fn tip_with_keys(self, ctx: &Context) -> String {
        match self.shortcut() {
            Some(keys) => format!("{} ({})", self.tip(), ctx.format_shortcut(&keys)),
            None => self.tip().to_owned(),
        }
    }

    /// Menu item; `true` when it was chosen.
    pub fn menu_item(self, ui: &mut Ui, enabled: bool) -> bool {
        let mut button = egui::Button::new(self.label());
        if let Some(keys) = self.shortcut() {
            button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
        }
        let clicked = ui.add_enabled(enabled, button).on_hover_text(self.tip()).clicked();
        if clicked {
            ui.close();
        }
        clicked
    }
}

#[cfg(test)]
mod tests {
    use super::Command;

    #[test]
    fn every_command_is_listed_once_and_keys_are_unique() {
        for (i, a) in Command::ALL.iter().enumerate() {
            for b in &Command::ALL[i + 1..] {
                assert_ne!(a, b, "listed twice");
                assert_ne!(a.label(), b.label(), "two commands with one label");
                assert!(a.shortcut().is_none() || a.shortcut() != b.shortcut(), "{a:?} and {b:?} share keys");
            }
        }
    }
}
