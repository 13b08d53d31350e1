//! Everything the window can be told to do: one list for menus, shortcuts, tooltips and the palette.

use egui::{Context, Key, KeyboardShortcut, Modifiers, Ui};

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;

/// Defines the list: `Name "Label" "What it does, in one sentence" [modifiers, key]`.
macro_rules! commands {
    ($($name:ident $label:literal $tip:literal [$($keys:expr, $key:ident)?];)*) => {
        /// A command of the window.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // Each name's tip says it below; another wording would only drift.
        pub enum Command {
            $($name,)*
        }

        impl Command {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// Text on menu items and buttons.
            pub fn label(self) -> &'static str {
                match self {
                    $(Self::$name => $label,)*
                }
            }

            /// What it does, in one sentence.
            pub fn tip(self) -> &'static str {
                match self {
                    $(Self::$name => $tip,)*
                }
            }

            /// The keys.
            pub fn shortcut(self) -> Option<KeyboardShortcut> {
                match self {
                    $(Self::$name => keys!($($keys, $key)?),)*
                }
            }
        }
    };
}

macro_rules! keys {
    () => {
        None
    };
    ($modifiers:expr, $key:ident) => {
        Some(KeyboardShortcut::new($modifiers, Key::$key))
    };
}

commands! {
    NewProject "New" "Closes the project and begins anew" [CTRL, N];
    OpenProject "Open project…" "Opens a project: part, setup, what-if sets and view" [];
    SaveProject "Save project" "Writes the project to its file" [CTRL, S];
    SaveProjectAs "Save project as…" "Writes the project to another file" [CTRL | SHIFT, S];
    OpenPart "Open part…" "Opens an impeller: .toml, .geomTurbo, TurboGrid .inf, or a mesh (.glb, .gltf)" [CTRL, O];
    AssignRoles "Assign roles…" "Tells which node of the part's mesh file is hub, shroud, blade or splitter" [];
    OpenSetup "Open setup…" "Opens a setup (.toml) for the part" [CTRL | SHIFT, O];
    SaveSetup "Save setup…" "Writes the setup as it stands" [];
    ExportCl "Export CL…" "Writes the plan shown as \"after\" as an APT cutter-location file" [CTRL, E];
    ExportFlank "Export flank CL…" "Writes the flank plan as an APT cutter-location file" [];
    ExportScene "Export scene…" "Writes the part, with the plan that is shown, as a glTF scene (.glb)" [];
    SavePicture "Save picture…" "Writes the 3D view as a PNG" [CTRL | SHIFT, E];
    Palette "Search a command" "Finds any command by its name" [CTRL, K];
    KeepSet "Keep as what-if set" "Keeps the setup as it stands, to compare others with it" [CTRL, D];
    FollowEdits "Follow edits" "Plans edits as they come, also while a slider moves" [];
    DismissProblems "Dismiss problems" "Closes the messages about what went wrong" [];
    Quit "Quit" "Closes the window" [CTRL, Q];
    Undo "Undo" "Takes the last change of setup or sets back" [CTRL, Z];
    Redo "Redo" "Makes the change again" [CTRL, Y];
    Plan "Plan channel" "Plans the channel with the setup as it stands" [NONE, F5];
    PlanFlank "Plan flank curves" "Plans the flank curves of the channel with the setup as it stands" [NONE, F6];
    Cancel "Cancel" "Stops the work; of a plan the best so far stays, or pressed again the last good one" [NONE, Escape];
    NextFault "Next interferential" "Selects the next interferential position in cutting order" [NONE, N];
    PreviousFault "Previous interferential" "Selects the interferential position before" [SHIFT, N];
    NextRow "Next row of the table" "Selects the row below, as the table is filtered and sorted" [NONE, ArrowDown];
    PreviousRow "Previous row of the table" "Selects the row above" [NONE, ArrowUp];
    StepForward "Step forward" "Cuts one more position and selects it" [NONE, ArrowRight];
    StepBack "Step back" "Takes the position cut last back" [NONE, ArrowLeft];
    LeapForward "Step forward by 100" "Cuts 100 more positions" [SHIFT, ArrowRight];
    LeapBack "Step back by 100" "Takes 100 positions back" [SHIFT, ArrowLeft];
    Play "Play" "Runs through the positions in cutting order, or stops" [NONE, Space];
    ToBlank "To the blank" "Shows the channel before the first position" [NONE, Home];
    ToEnd "To the end" "Shows the channel after the last position" [NONE, End];
    BeforeAfter "Switch before and after" "Shows the conventional plan (before) or the repaired one (after)" [NONE, B];
    SideBySide "Before and after side by side" "Shows before and after side by side, under one camera" [SHIFT, B];
    Wipe "Before and after with a wipe" "Shows before and after in one picture with a border to drag" [];
    Difference "Difference map" "Colours the floor by how much more is left after than before" [SHIFT, D];
    Fit "Fit" "Brings the whole part into view" [NONE, F];
    FlyToSelection "Fly to the selection" "Brings the selected position into view" [NONE, Z];
    ViewIso "Isometric view" "The whole wheel from obliquely above" [NONE, Num1];
    ViewFront "Front view" "The whole wheel from the side" [NONE, Num2];
    ViewTop "Top view" "The whole wheel along its axis" [NONE, Num3];
    ViewChannel "Channel in work" "The channel in work, seen onto its floor" [NONE, Num4];
    ViewSection "Section in work" "The section of the selected position, else the first" [NONE, Num5];
    Perspective "Switch perspective and parallel" "Switches between perspective and parallel projection" [NONE, P];
    SectionPlane "Section plane" "Cuts the part open along a plane" [NONE, X];
    Measure "Measure" "Measures between two points: distance, Δx, Δy, Δz" [NONE, M];
    ShowInTable "Show in table" "Brings the row of the selected position into sight" [];
    OpenSection "Open section" "Shows the cut through the selected position along its row" [];
    ScrubHere "Scrub to here" "Shows the channel as it is after the selected position" [];
    MeasureHere "Measure from here" "Begins to measure at the point under the pointer, else at the tip of the selected position" [];
    Plots "Plots along the row" "Shows tilt, contact, stock and step along the row of the selected position" [];
    Hub "Hub" "Shows the hub with the stock left on it" [];
    Blades "Blades" "Shows the blades" [];
    Shroud "Shroud" "Shows the shroud as glass" [];
    Cutters "Cutters" "Shows the cutters at the end of their plunges" [];
    Axes "Axes" "Shows the tool axes up to the retract points" [];
    Holders "Holders" "Shows the holder of the cutter in work and of the selected one" [];
    Links "Rapids" "Shows the rapids from retract point to retract point" [];
    FlankCurves "Flank curves" "Shows the curves of the flank plan" [];
    MouseVanecut "Mouse: Vanecut" "Left button turns, middle or shift-left moves" [];
    MouseNx "Mouse: NX" "Middle button turns, shift-middle moves, ctrl-middle zooms" [];
    MouseSolidworks "Mouse: SolidWorks" "Middle button turns, ctrl-middle moves, shift-middle zooms" [];
    MouseOnshape "Mouse: Onshape" "Right button turns, middle or ctrl-right moves" [];
    MouseBlender "Mouse: Blender" "Middle button turns, shift-middle moves, ctrl-middle zooms; left with alt does the same" [];
    SwitchTheme "Switch light and dark" "Switches between light and dark" [];
}

impl Command {
    /// Whether its keys belong to whatever has the keyboard: they type, move or press there.
    fn yields(shortcut: &KeyboardShortcut) -> bool {
        !shortcut.modifiers.command && !matches!(shortcut.logical_key, Key::F5 | Key::F6 | Key::Escape)
    }

    /// Commands whose keys were pressed since the last look. Keys that also type or move count only while no
    /// field has the focus; keys of what cannot be done now are left to others. What cannot be done now leaves its keys to others.
    pub fn pressed(ctx: &Context, can: impl Fn(Self) -> bool) -> Vec<Self> {
        let taken = ctx.text_edit_focused() || ctx.memory(|memory| memory.focused().is_some());
        let typing = ctx.text_edit_focused();
        let mut order: Vec<(Self, KeyboardShortcut)> =
            Self::ALL.iter().filter_map(|&command| Some((command, command.shortcut()?))).collect();
        // Those with more modifiers first: a shortcut also answers to keys with further modifiers held.
        let weight = |m: Modifiers| usize::from(m.shift) + usize::from(m.command) + usize::from(m.alt);
        order.sort_by_key(|(_, keys)| std::cmp::Reverse(weight(keys.modifiers)));
        let mut pressed = Vec::new();
        for (command, keys) in order {
            let letter = !matches!(
                keys.logical_key,
                Key::ArrowUp
                    | Key::ArrowDown
                    | Key::ArrowLeft
                    | Key::ArrowRight
                    | Key::Space
                    | Key::Home
                    | Key::End
            );
            let kept = if letter { typing } else { taken };
            if kept && Self::yields(&keys) || !can(command) {
                continue;
            }
            if ctx.input_mut(|input| input.consume_shortcut(&keys)) {
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
    fn labels_and_keys_are_unique() {
        for (i, a) in Command::ALL.iter().enumerate() {
            for b in &Command::ALL[i + 1..] {
                assert_ne!(a.label(), b.label(), "two commands with one label");
                assert!(a.shortcut().is_none() || a.shortcut() != b.shortcut(), "{a:?} and {b:?} share keys");
            }
        }
    }
}
