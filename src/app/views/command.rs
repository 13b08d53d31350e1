//! Every command of the window: one list for menus, shortcuts, tooltips and the palette.

use egui::{Context, Event, Key, KeyboardShortcut, Modifiers, Ui};

use super::list_keys::take_presses;

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;

/// Defines the list: `Name "Label" "Effect, in one sentence" [modifiers, key]`.
macro_rules! commands {
    ($($name:ident $label:literal $tip:literal [$($keys:expr, $key:ident)?];)*) => {
        /// A command of the window.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs, reason = "the tips below describe the variants")]
        pub enum Command {
            $($name,)*
        }

        impl Command {
            /// All commands.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// Text of menu items and buttons.
            pub fn label(self) -> &'static str {
                match self {
                    $(Self::$name => $label,)*
                }
            }

            /// Effect of the command, in one sentence.
            pub fn tip(self) -> &'static str {
                match self {
                    $(Self::$name => $tip,)*
                }
            }

            /// Keyboard shortcut, if any.
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
    NewProject "New" "Closes the project and starts a new one" [CTRL, N];
    OpenProject "Open project…" "Opens a project: part, setup, variants and view" [];
    SaveProject "Save project" "Writes the project to its file" [CTRL, S];
    SaveProjectAs "Save project as…" "Writes the project to another file" [CTRL | SHIFT, S];
    OpenPart "Open part…"
        "Opens an impeller: .toml, .geomTurbo, TurboGrid .inf, CAD (.step) or a mesh (.stl, .glb, .gltf)" [CTRL, O];
    AssignRoles "Assign surfaces…"
        "Sets what a STEP, STL or glTF file leaves open: unit, axis, blades, rotation, roles of its bodies" [];
    OpenSetup "Open setup…" "Opens a setup (.toml) for the part" [CTRL | SHIFT, O];
    OpenBlank "Open blank…"
        "Takes the stock before the first cut from a file: a mesh (.stl) or an outline, lines r z (.txt)" [];
    OpenMachine "Open machine file…"
        "Takes the machine of the setup from a machine file (.toml): its axes, limits, control and zero point" [];
    ToolLibrary "Shop library…"
        "Shows the tool library of the shop: search, look at, edit, take into the setup" [];
    OpenLibrary "Open library…"
        "Opens a tool library of Fusion (.json, .tools), FreeCAD (.fctb, .fctl) or our own (.toml)" [];
    SaveLibrary "Save library…" "Writes the tool library: our own (.toml) or Fusion (.json)" [];
    OpenStudy "Open study results…"
        "Opens what `vanecut study` found: its merged table (.csv), or the study.json in its folder" [];
    StudyResults "Study results" "Shows the results of the study that was opened last" [];
    SaveSetup "Save setup…" "Writes the current setup" [];
    ExportCl "Export CL (APT)…"
        "Writes the plan of the selected operation, for one channel, as an APT cutter-location file" [CTRL, E];
    ExportClSome "Export CL of several channels…"
        "Writes the plan of the selected operation, for as many channels as you say, as an APT cutter-location file" [];
    ExportClAll "Export CL of all channels…"
        "Writes the plan of the selected operation, for every channel of the part, as an APT cutter-location file" [];
    ExportFlank "Export flank CL (APT)…"
        "Writes the flank plan as an APT cutter-location file" [];
    ExportNc "Export NC program…"
        "Writes the plan as NC code for a machine and its control" [CTRL | SHIFT, N];
    ExportSheet "Export setup sheet…"
        "Writes what one takes to the machine as HTML: zero point, tools, sections with times, warnings" [];
    CheckProgram "Check program…"
        "Opens an APT or NC program and checks it against part and setup: faults with line and place" [];
    CheckAgain "Check again" "Reads the program again and checks it with the current setup" [NONE, F7];
    CloseProgram "Close program" "Closes the checked program" [];
    ExportScene "Export scene…"
        "Writes the part, with the shown plan (of two that of the active side), as a glTF scene (.glb)" [];
    ExportStock "Export stock…"
        "Writes the stock of the shown or active side at the position of the timeline as a solid: STL or glTF (.glb)" [];
    SavePicture "Save picture…" "Writes the 3D view as a PNG" [CTRL | SHIFT, E];
    Palette "Search commands" "Finds any command by its name" [CTRL, K];
    KeepSet "Save as variant" "Stores the current setup as a variant, to compare others with it" [CTRL, D];
    FollowEdits "Auto-update" "Recalculates after every edit, also while a slider moves" [];
    DismissProblems "Dismiss problems" "Closes all problem messages" [];
    Quit "Quit" "Closes the window" [CTRL, Q];
    Undo "Undo" "Undoes the last change of setup or variants" [CTRL, Z];
    Redo "Redo" "Redoes the change" [CTRL, Y];
    Plan "Calculate roughing" "Plans the rough milling of the channel with the current setup" [NONE, F5];
    Assess "Machinability"
        "Shows twist, depth, width, largest cutter, and what the tools reach, before any plan" [NONE, A];
    CompareAll "Compare all strategies"
        "The next calculation plans every axis strategy, not only the chosen one, or that alone again" [];
    TimeAgainstStock "Time against stock"
        "Shows what less time costs in stock on the hub; drag the handle, and the plan follows" [NONE, G];
    SaveAssessment "Save machinability page…"
        "Writes the machinability of the part with its pictures as HTML" [];
    PlanFlank "Calculate flank"
        "Plans the flank milling toolpath of the channel with the current setup" [NONE, F6];
    Cancel "Cancel"
        "Stops and keeps the best plan so far; pressed again: the last finished plan" [NONE, Escape];
    Deselect "Deselect" "Clears the selected position, pass or fault" [NONE, Escape];
    NextFault "Next fault"
        "Selects the next interfering plunge in cutting order, or fault of a checked program" [NONE, N];
    PreviousFault "Previous fault" "Selects the interfering plunge or the fault before" [SHIFT, N];
    NextRow "Next row of the table"
        "Selects the row below in the filtered and sorted table" [NONE, ArrowDown];
    PreviousRow "Previous row of the table" "Selects the row above" [NONE, ArrowUp];
    StepForward "Step forward" "Cuts one more position and selects it" [NONE, ArrowRight];
    StepBack "Step back" "Undoes the position cut last" [NONE, ArrowLeft];
    LeapForward "Step forward by 100" "Cuts 100 more positions" [SHIFT, ArrowRight];
    LeapBack "Step back by 100" "Undoes the last 100 positions" [SHIFT, ArrowLeft];
    NextTool "Next tool change" "Moves the timeline to the first plunge of the next tool" [NONE, T];
    PreviousTool "Previous tool change"
        "Moves the timeline to the first plunge of the tool before" [SHIFT, T];
    NextSection "Next section or layer"
        "Moves the timeline to where the next section begins, or the next layer of flank passes" [NONE, C];
    PreviousSection "Previous section or layer"
        "Moves the timeline to where the section before begins, or that layer of flank passes" [SHIFT, C];
    Play "Play" "Plays the positions in cutting order, or stops" [NONE, Space];
    ToBlank "Go to start" "Shows the channel before the first position" [NONE, Home];
    ToEnd "Go to end" "Shows the channel after the last position" [NONE, End];
    BeforeAfter "Switch before and after"
        "Shows the conventional plan (before) or the repaired one (after)" [NONE, B];
    SideBySide "Before and after side by side"
        "Shows before and after side by side, under one camera" [SHIFT, B];
    Wipe "Before and after with a wipe"
        "Shows before and after in one picture with a border to drag" [];
    Difference "Difference map"
        "Colours the floor by the residual stock after minus before" [SHIFT, D];
    Fit "Fit" "Brings the whole part into view" [NONE, F];
    FlyToSelection "Zoom to selection" "Brings the selected position into view" [NONE, Z];
    ViewIso "Isometric view" "The whole wheel, isometric" [NONE, Num1];
    ViewFront "Front view" "The whole wheel from the side" [NONE, Num2];
    ViewTop "Top view" "The whole wheel along its axis" [NONE, Num3];
    ViewChannel "Current channel" "The current channel, looking onto its floor" [NONE, Num4];
    ViewSection "Current section"
        "The section of the selected position, else the first" [NONE, Num5];
    Perspective "Switch perspective and parallel"
        "Switches between perspective and parallel projection" [NONE, P];
    SectionPlane "Section plane" "Cuts the part open along a plane" [NONE, X];
    Measure "Measure" "Measures between two points: distance, Δx, Δy, Δz" [NONE, M];
    ShowInTable "Show in table" "Scrolls the table to the selected position" [];
    OpenSection "Open sectional view"
        "Shows the sectional view through the selected position along its row" [];
    ScrubHere "Simulate to here" "Shows the stock after the selected position" [];
    MeasureHere "Measure from here"
        "Starts measuring at the point under the pointer, else at the tip of the selected position" [];
    EditPlunge "Edit plunge" "Shows what can be changed in the selected plunge or row by hand" [NONE, E];
    DeletePlunge "Delete plunge" "Leaves the selected plunge out of the plan" [NONE, Delete];
    DeleteRow "Delete row" "Leaves the row of the selected plunge out of the plan" [SHIFT, Delete];
    LockPlunge "Lock plunge" "Keeps the selected plunge in every plan as it is, or no longer" [NONE, L];
    LockRow "Lock row"
        "Keeps the plunges of the selected row in every plan as they are, or no longer" [SHIFT, L];
    CutEarlier "Cut earlier" "Cuts the selected plunge before the one that is cut before it" [];
    CutLater "Cut later" "Cuts the selected plunge after the one that is cut after it" [];
    CutRowEarlier "Cut row earlier" "Cuts the row of the selected plunge before the row before it" [];
    CutRowLater "Cut row later" "Cuts the row of the selected plunge after the row after it" [];
    Plots "Plots along the row"
        "Shows lead angle, contact, stock, step, engaged arc and chip along the row of the selected position" [];
    SetupPanel "Setup panel" "Shows or hides part, operations, and what they are planned with" [];
    RotaryAxesPanel "Rotary axes panel" "Shows or hides the rotary axes of the machine over the program" [];
    TimelinePanel "Timeline panel" "Shows or hides the timeline with the line of the program" [];
    TablePanel "Table panel" "Shows or hides the table of positions, passes or faults" [];
    DetailsPanel "Details panel" "Shows or hides what is known of the selected position" [];
    SectionalViewPanel "Enlarged sectional view"
        "Shows or hides the sectional view through the selected position, enlarged" [];
    ResetLayout "Reset layout" "Arranges all panels as at first" [];
    Hub "Hub" "Shows the hub with the residual stock on it" [];
    Blades "Blades" "Shows the blades" [];
    Shroud "Shroud" "Shows the shroud, transparent" [];
    Cutters "Cutters" "Shows the cutters at the end of their plunges" [];
    Axes "Axes" "Shows the tool axes up to the retract points" [];
    Holders "Holders" "Shows the holders of the tool where the timeline stands and of the selected plunge" [];
    Links "Rapids" "Shows the rapids of plunges, from retract point to retract point, or between flank passes" [];
    Stock "Stock"
        "Shows the stock as a solid at the position of the timeline, instead of hub and blades" [NONE, S];
    Machine "Machine"
        "Shows table and head of the machine of the setup, if it has one, as simple solids that move with the timeline. \
         The head is left out while it hides most of the view" [];
    FlankCurves "Flank passes" "Shows the passes of the flank plan" [];
    PassesByLayer "Passes by layer" "Colours the flank passes by layer" [];
    PassesByRegion "Passes by region" "Colours the flank passes by region of the channel" [];
    PassesByFeed "Passes by feed rate"
        "Colours the flank passes by feed rate, from slow to fast" [];
    PassesByWalls "Passes by walls"
        "Colours the walls by what flank milling leaves on them, and by overcut" [];
    TextLarger "Text size: larger" "Makes text and controls larger (Ctrl +)" [];
    TextSmaller "Text size: smaller" "Makes text and controls smaller (Ctrl −)" [];
    TextUsual "Text size: usual" "Shows text and controls in their usual size (Ctrl 0)" [];
    MouseVanecut "Mouse: Vanecut" "Left button orbits, middle or shift-left pans" [];
    MouseNx "Mouse: NX" "Middle button orbits, shift-middle pans, ctrl-middle zooms" [];
    MouseSolidworks "Mouse: SolidWorks" "Middle button orbits, ctrl-middle pans, shift-middle zooms" [];
    MouseOnshape "Mouse: Onshape" "Right button orbits, middle or ctrl-right pans" [];
    MouseBlender "Mouse: Blender"
        "Middle button orbits, shift-middle pans, ctrl-middle zooms; left with alt does the same" [];
    UnitsMetric "Units: mm" "Shows lengths in mm and feed rates in mm/min" [];
    UnitsInch "Units: inch"
        "Shows lengths in inches and feed rates in in/min, and takes numbers as such; files stay in mm" [];
    SwitchTheme "Switch light and dark" "Switches between the light and dark theme" [];
    ShowShortcuts "Keyboard shortcuts" "Lists all keys" [NONE, F1];
    ShowGlossary "Glossary" "Explains the words of the window" [];
    ShowTour "Tour" "Shows in five steps what the parts of the window are for" [];
    ShowAbout "About Vanecut" "Shows version, licence and graphics device" [];
}

impl Command {
    /// Whether a focused widget takes precedence: without Ctrl the keys also type, move or press there.
    fn yields_to_focus(shortcut: &KeyboardShortcut) -> bool {
        !shortcut.modifiers.command
            && !matches!(shortcut.logical_key, Key::F1 | Key::F5 | Key::F6 | Key::F7 | Key::Escape)
    }

    /// Commands whose keys were pressed in this frame, in their order. Keys that also type or move count
    /// only while no field has the focus. Keys of commands that are not available now are not consumed: of
    /// two with the same keys the first that is available has them.
    pub fn pressed(ctx: &Context, can: impl Fn(Self) -> bool) -> Vec<Self> {
        // An open list or menu takes the arrows before any of its entries has the focus.
        let has_focus = ctx.memory(|memory| memory.focused().is_some());
        let taken = ctx.text_edit_focused() || has_focus || egui::Popup::is_any_open(ctx);
        let typing = ctx.text_edit_focused();
        let mut order: Vec<(Self, KeyboardShortcut)> =
            Self::ALL.iter().filter_map(|&command| Some((command, command.shortcut()?))).collect();
        // Shortcuts with more modifiers first: egui also matches a shortcut when extra modifiers are held.
        let weight = |m: Modifiers| usize::from(m.shift) + usize::from(m.command) + usize::from(m.alt);
        order.sort_by_key(|(_, keys)| std::cmp::Reverse(weight(keys.modifiers)));
        let presses: Vec<(Key, Modifiers)> = ctx.input(|input| {
            input
                .events
                .iter()
                .filter_map(|event| match event {
                    Event::Key { key, pressed: true, modifiers, .. } => Some((*key, *modifiers)),
                    _ => None,
                })
                .collect()
        });
        // What is available is asked of few of them.
        order.retain(|(_, keys)| presses.iter().any(|&(key, modifiers)| is_meant(keys, key, modifiers)));
        let is_heard = |(command, keys): &(Self, KeyboardShortcut)| {
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
            !(kept && Self::yields_to_focus(keys)) && can(*command)
        };
        order.retain(is_heard);
        take_presses(ctx, |key, modifiers| {
            order.iter().find(|(_, keys)| is_meant(keys, key, modifiers)).map(|(command, _)| *command)
        })
    }

    /// Tip followed by the shortcut.
    pub fn tip_with_keys(self, ctx: &Context) -> String {
        match self.shortcut() {
            Some(keys) => format!("{} ({})", self.tip(), ctx.format_shortcut(&keys)),
            None => self.tip().to_owned(),
        }
    }

    /// Draws the menu item of a switch; `true` when it was clicked.
    pub fn menu_switch(self, ui: &mut Ui, mut is_on: bool) -> bool {
        let shown = ui.scope(|ui| {
            super::theme::draw_box_edges(ui);
            ui.checkbox(&mut is_on, self.label())
        });
        let clicked = shown.inner.on_hover_text(self.tip()).changed();
        if clicked {
            ui.close();
        }
        clicked
    }

    /// Draws a menu item; `true` when it was clicked.
    pub fn menu_item(self, ui: &mut Ui, enabled: bool) -> bool {
        let mut button = egui::Button::new(self.label());
        if let Some(keys) = self.shortcut() {
            button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
        }
        let item = ui.add_enabled(enabled, button);
        let clicked = item.on_hover_text(self.tip()).on_disabled_hover_text(self.tip()).clicked();
        if clicked {
            ui.close();
        }
        clicked
    }
}

/// Whether a pressed key is that of a shortcut, without more of Shift and Ctrl than this has, where it is a
/// letter: another shortcut may have these. Signs need Shift on some keyboards.
fn is_meant(shortcut: &KeyboardShortcut, key: Key, modifiers: Modifiers) -> bool {
    let KeyboardShortcut { logical_key, modifiers: wanted } = *shortcut;
    let is_letter = logical_key.name().len() == 1 && (Key::A..=Key::Z).contains(&logical_key);
    let has_modifiers =
        if is_letter { modifiers.matches_exact(wanted) } else { modifiers.matches_logically(wanted) };
    key == logical_key && has_modifiers
}

#[cfg(test)]
mod tests {
    use super::Command;

    #[test]
    fn labels_and_keys_are_unique() {
        for (i, a) in Command::ALL.iter().enumerate() {
            for b in &Command::ALL[i + 1..] {
                assert_ne!(a.label(), b.label(), "two commands with one label");
                // Where there is nothing to cancel, the key deselects.
                let takes_turns = (*a, *b) == (Command::Cancel, Command::Deselect);
                let differ = a.shortcut().is_none() || a.shortcut() != b.shortcut();
                assert!(differ || takes_turns, "{a:?} and {b:?} share keys");
            }
        }
    }
}
