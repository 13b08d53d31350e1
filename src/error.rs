//! Errors that a user sees: their stable codes, and the plain error of a value that has no place in a file.
//!
//! Every such error has four parts: a code, a message (what is wrong), a help (what to do), and a place. The
//! place differs by layer: a line of a part file ([`crate::part::PartError`]), a key of a setup
//! ([`crate::setup::SetupFault`]), file and line ([`crate::io::InputError`]), or none ([`UserError`]).
//! Messages and helps may be reworded; programs and tests go by the code. `vanecut explain CODE` prints the
//! entry of a code, `docs/errors.md` holds all of them.

use std::fmt::{Display, Formatter, Write};

/// Declares [`ErrorCode`]: of each code its variant, its name, what it means and what to do, by group.
macro_rules! error_codes {
    ($($group:literal { $($variant:ident $name:literal, $meaning:literal, $cure:literal;)+ })+) => {
        /// Kind of an error, by what it takes to cure it. Names are stable: other programs rely on them.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum ErrorCode {
            $($(#[doc = $meaning] $variant,)+)+
        }

        /// All codes, by group.
        const GROUPS: &[(&str, &[ErrorCode])] = &[$(($group, &[$(ErrorCode::$variant),+])),+];

        impl ErrorCode {
            /// The name of the code, what it means, and what to do.
            const fn entry(self) -> [&'static str; 3] {
                match self {
                    $($(Self::$variant => [$name, $meaning, $cure],)+)+
                }
            }
        }
    };
}

error_codes! {
    "Files" {
        FileUnreadable "file-unreadable",
            "A file does not exist, is a folder, or cannot be read.",
            "Check the path, the permissions and the disk.";
        FileNotWritten "file-not-written",
            "An output file or folder cannot be written; what was there is unchanged.",
            "Give a folder that exists and that you may write to, and a name that is not an input.";
        FileFormat "file-format",
            "The extension or the content is not of a format that the command reads or writes.",
            "Give a file of one of the formats that the message lists.";
        FileEmpty "file-empty",
            "A file holds nothing.",
            "Check that it was written completely; export or copy it again.";
        FileCutOff "file-cut-off",
            "A file ends too early.",
            "Export or copy it again.";
        FileTooLarge "file-too-large",
            "A file, or what it holds, is larger than the program takes.",
            "Give a smaller or coarser file, or split it.";
        NotText "not-text",
            "A text file holds bytes that are not UTF-8 text.",
            "Check that it is the right file, or save it as UTF-8.";
        NewerFile "newer-file",
            "A file was written by a newer version of the program.",
            "Open it with that version.";
    }
    "Keys and values" {
        InvalidToml "invalid-toml",
            "The text is not TOML.",
            "Correct the line: a key, an equals sign, and a number, a text in quotes, true, false or a list.";
        UnknownKey "unknown-key",
            "A table has a key that its format does not know.",
            "Use a known key, such as the nearest one where the message names it, or remove the key.";
        MissingKey "missing-key",
            "A key, table or entry that the format needs is missing.",
            "Add it.";
        ConflictingKeys "conflicting-keys",
            "Two keys, tables or values exclude each other, or one is given twice.",
            "Keep one of them.";
        ValueType "value-type",
            "A value is of another kind than its key takes, such as a text for a number.",
            "Give a value of the kind that the message names.";
        ValueRange "value-range",
            "A value is outside the range of its key.",
            "Give a value in the range that the message names.";
        InvalidNumber "invalid-number",
            "A word is not a number, not finite, or larger than 1,000,000.",
            "Correct the number, or export the file again.";
        UnknownName "unknown-name",
            "A word is not one of the names that are possible here.",
            "Use one of the names that the message lists.";
    }
    "Contents of files" {
        PartFile "part-file",
            "A native, GeomTurbo or TurboGrid part does not describe curves and blades as its format asks.",
            "Correct the line, or export the part again.";
        MeshFile "mesh-file",
            "A glTF or STL file breaks its format.",
            "Export it again.";
        GltfVersion "gltf-version",
            "A glTF file is of another version than 2.",
            "Export it as glTF 2.0.";
        GltfExtension "gltf-extension",
            "A glTF file needs an extension that is not supported.",
            "Export it without that extension.";
        GltfReference "gltf-reference",
            "An element of a glTF file refers to one that does not exist, or that is taken already.",
            "Export it again; repair it if you wrote it by hand.";
        GltfAccessor "gltf-accessor",
            "The data of a glTF accessor are missing, or of a type that does not suit their use.",
            "Export it again.";
        MeshCompressed "mesh-compressed",
            "The meshes of a file are compressed.",
            "Export it without mesh compression (Draco, meshopt).";
        MeshBuffer "mesh-buffer",
            "A buffer of a glTF file is not in its folder, or cannot be opened with it.",
            "Put the buffer beside the file and name it without a path, or save as .glb.";
        MeshValues "mesh-values",
            "A corner of a mesh is not at a finite place, or a triangle has a corner that the mesh does not have.",
            "Repair the mesh and export it again.";
        NoTriangles "no-triangles",
            "A file holds no triangles.",
            "Export the surfaces of the impeller as meshes of triangles.";
        StepFile "step-file",
            "A STEP file breaks its format, holds no solids or surfaces, or an entity of it is not valid.",
            "Repair the model, or export it again as AP203, AP214 or AP242.";
        BlankFile "blank-file",
            "The outline of a blank bounds no body, or a blank does not enclose the part.",
            "Give the points of the outline in order; check unit and origin of the file.";
        SetupFile "setup-file",
            "Values of a setup do not go together.",
            "Correct the key at the line of the message.";
        ToolFile "tool-file",
            "A tool, or a tool library of another program, is not complete or not plausible.",
            "Correct the tool, or export the library again.";
        MachineFile "machine-file",
            "A machine or post file describes a machine or control that cannot be.",
            "Correct the key at the line of the message.";
        PlanFile "plan-file",
            "A plan or project file is damaged, or not such a file.",
            "Give a file that the program wrote; plan the part again.";
        StudyFile "study-file",
            "The axes or exclusions of a study do not go together.",
            "Correct the key at the line of the message.";
        StudyResults "study-results",
            "Results of a study are missing, damaged, or of another study.",
            "Run the study again; it redoes what is missing.";
    }
    "Part" {
        FlowCurve "flow-curve",
            "The curve of hub or shroud is not usable: too few points, wrong knots, or not a plausible size.",
            "Give the meridional curve from inlet to outlet, in the unit of the file.";
        CurvesSwapped "curves-swapped",
            "The hub lies outside the shroud.",
            "Exchange the two curves.";
        CurvesMeet "curves-meet",
            "Hub and shroud cross or touch.",
            "Check both curves; the shroud must stay outside the hub.";
        NoRadialOutlet "no-radial-outlet",
            "The hub does not turn away from the axis: the wheel is not centrifugal.",
            "Open a centrifugal impeller; axial rotors are not supported.";
        BladeCount "blade-count",
            "The number of main blades is missing, or cannot be.",
            "Give the number of main blades, 2 to 200.";
        BladeSections "blade-sections",
            "A blade has too few, too many or unusable sections.",
            "Give two or more sections from hub to shroud, each from leading to trailing edge.";
        BladeValues "blade-values",
            "An angle, a thickness or the leading edge of a blade cannot be.",
            "Correct the values of the section.";
        BladeTooShort "blade-too-short",
            "A blade does not reach hub or shroud, or does not extend along them.",
            "Give sections that reach both curves, in the same unit.";
        BladesOverlap "blades-overlap",
            "Neighbouring blades run into each other.",
            "Give fewer or thinner blades.";
        MeshRoles "mesh-roles",
            "Hub, shroud and blades cannot be identified in the meshes of the file.",
            "Export them as separate meshes, or name them with --role NODE=hub, shroud, blade or ignore.";
        MeshInOne "mesh-in-one",
            "Hub and blades of a wheel in a single mesh cannot be separated.",
            "Export hub and blades as separate meshes, or name them with --role NODE=hub and NODE=blade.";
        NoShroud "no-shroud",
            "No shroud curve can be fitted to the tips of the blades.",
            "Give a shroud with --role NODE=shroud.";
        NoRotationAxis "no-rotation-axis",
            "The hub of a mesh has no axis of rotation.",
            "Give it with --rotation-axis x, y or z.";
        MeshUnit "mesh-unit",
            "With its unit the wheel would not have a plausible size.",
            "Give the unit of the file with --unit.";
        NotRevolved "not-revolved",
            "The hub or the shroud of a mesh is not a surface of revolution.",
            "Check the roles of the meshes, and the axis of rotation (--rotation-axis).";
        MeshNotClosed "mesh-not-closed",
            "A blade or a blank made of triangles has a hole or a gap.",
            "Close the mesh and export it again.";
        BladeSpacing "blade-spacing",
            "The main blades are not evenly spaced.",
            "Check that all are main blades; name splitters and fragments with --role.";
    }
    "Setup and part" {
        WrongPart "wrong-part",
            "The setup names another part.",
            "Give the setup of this part, or change its key `part`.";
        HubAllowance "hub-allowance",
            "The hub allowance fills the channel.",
            "Give a smaller `hub_allowance`.";
        BladeAllowance "blade-allowance",
            "The blade allowance leaves no space for a cutter between the blades.",
            "Give a smaller `blade_allowance`, or a smaller cutter.";
        UndefinedTool "undefined-tool",
            "A section or a plan uses a tool that the setup does not define.",
            "Add a [[tool]] of that number, or name another.";
        CutterTooWide "cutter-too-wide",
            "The cutter does not fit between the blades.",
            "Use a smaller cutter; the message says which diameter fits.";
        TooManyPositions "too-many-positions",
            "The plan would have more positions than the program takes.",
            "Give a greater step, stepover or wall scallop, or a larger cutter.";
        SectionOrder "section-order",
            "A section runs the wrong way, or removes the rest of nothing.",
            "Give `from` at the outlet end and `to` below it; put rest milling after the sections before it.";
        CoreContact "core-contact",
            "The core of every plunge would meet stock.",
            "Begin a section at the outlet, take wider inserts, or plan with axis = \"staircase\".";
        OverhangTooShort "overhang-too-short",
            "No tool reaches down to the hub.",
            "Give more `overhang`.";
        AssemblyCollides "assembly-collides",
            "The shank or the holder of every plunge would come too near to part or blank, or a tool meets the table of \
             the machine.",
            "Give a thinner shank or holder, or more overhang.";
        NoFreeAxis "no-free-axis",
            "No plunge has an axis that blades, tilt limits and the machine allow.",
            "Allow more tilt, or use smaller cutters.";
        LayerDepth "layer-depth",
            "The depth of a layer is not possible in this channel.",
            "Give a `layer_depth` within what the message says.";
        FineScallop "fine-scallop",
            "The scallop height asks for more passes than the program takes.",
            "Give a greater `scallop_height`, or a tool with a larger corner radius.";
    }
    "Programs and machines" {
        AptStatement "apt-statement",
            "A statement of an APT program is not valid, or changes the path in a way that is not supported.",
            "Correct the line, or export straight moves (GOTO) in the coordinates of the part.";
        NcBlock "nc-block",
            "A block of an NC program is not read.",
            "Give a program as `vanecut post` writes it, or APT.";
        NothingMoves "nothing-moves",
            "A program or plan has no moves, or cuts nothing.",
            "Give a program with moves under feed; plan the part with tools that fit.";
        ProgramTool "program-tool",
            "A program cuts without a tool, or its tool has no diameter, number or spindle speed.",
            "Add LOADTL, CUTTER and SPINDL to the program, or a [[tool]] to the setup.";
        ProgramFeedRate "program-feed-rate",
            "A move under feed has no feed rate.",
            "Add FEDRAT to the program.";
        AxisLimits "axis-limits",
            "The machine does not reach a position: a direction is impossible, or an axis beyond its limits.",
            "Choose a machine that reaches it, or give the planner less `max_axis_tilt`.";
        AxisTurnsBack "axis-turns-back",
            "A rotary axis meets its limit in the middle of a cut.",
            "Choose a machine with a wider or endless axis.";
        AxisCannotFollow "axis-cannot-follow",
            "The tool axis turns faster than the machine can follow within its tolerance.",
            "Add positions there.";
        ControlOutput "control-output",
            "The control does not take this form of output.",
            "Give one of the forms that the message lists with --output.";
        ProgramFaults "program-faults",
            "The program breaks an allowance, collides, or leaves its limits.",
            "Correct the program at the lines of the report.";
        StockSpacing "stock-spacing",
            "The stock as a solid is empty, or too large or too small for its spacing.",
            "Give another --spacing or --blank.";
    }
    "Commands" {
        Arguments "arguments",
            "The arguments of the command are not complete, not known, or not possible.",
            "See `vanecut COMMAND --help`.";
        PlanIncomplete "plan-incomplete",
            "The plan or the study was finished only in part.",
            "See the message for what is left; correct the setup, or run it again.";
        Cancelled "cancelled",
            "The work was cancelled before it had a result.",
            "Start it again.";
        NotBuiltIn "not-built-in",
            "The program was built without its window or without pictures.",
            "Build it with --features window or --features gpu.";
        GraphicsDevice "graphics-device",
            "No graphics device or display can be used, or the device failed.",
            "Install a Vulkan driver (on Debian: mesa-vulkan-drivers), set DISPLAY, or use a command without pictures.";
        Picture "picture",
            "A picture cannot be encoded.",
            "Give another size.";
        System "system",
            "The operating system refused something, such as a thread or standard output.",
            "Free resources, or send the output elsewhere.";
        Defect "defect",
            "The program failed where it should not.",
            "Report it with the input.";
    }
}

impl ErrorCode {
    /// All codes, in the order of the documentation.
    pub fn all() -> impl Iterator<Item = Self> {
        GROUPS.iter().flat_map(|(_, codes)| codes.iter().copied())
    }

    /// The code of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|code| code.name() == name)
    }

    /// Its stable name, such as `unknown-key`.
    pub const fn name(self) -> &'static str {
        self.entry()[0]
    }

    /// What it means, one sentence.
    pub const fn meaning(self) -> &'static str {
        self.entry()[1]
    }

    /// What to do, one sentence.
    pub const fn cure(self) -> &'static str {
        self.entry()[2]
    }

    /// The page of all codes, Markdown: `docs/errors.md`.
    pub fn page() -> String {
        let mut page =
            "# Errors\n\nEvery error has a code. With `VANECUT_ERROR_CODES=1` in the environment the \
                        line of an error ends with it, in brackets.\n`vanecut explain CODE` prints the \
                        entry of one code, `vanecut explain` this page.\n"
                .to_owned();
        for (group, codes) in GROUPS {
            let _ = write!(page, "\n## {group}\n\n| code | meaning | what to do |\n|---|---|---|\n");
            for code in *codes {
                let [name, meaning, cure] = code.entry();
                let _ = writeln!(page, "| `{name}` | {meaning} | {cure} |");
            }
        }
        page
    }
}

impl Display for ErrorCode {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// An error that has no place in a file. Displayed as `message; help`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UserError {
    /// Its kind.
    pub code: ErrorCode,
    /// What is wrong.
    pub message: String,
    /// What to do about it; empty where nothing can be done.
    pub help: String,
}

impl UserError {
    /// An error: its kind, what is wrong and what to do.
    pub fn new(code: ErrorCode, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { code, message: message.into(), help: help.into() }
    }
}

impl Display for UserError {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self.help.as_str() {
            "" => f.write_str(&self.message),
            help => write!(f, "{}; {help}", self.message),
        }
    }
}

impl std::error::Error for UserError {}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_are_unique_and_kebab_case() {
        let names: BTreeSet<&str> = ErrorCode::all().map(ErrorCode::name).collect();
        assert_eq!(names.len(), ErrorCode::all().count());
        for name in names {
            let is_kebab = name.split('-').all(|word| {
                !word.is_empty() && word.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit())
            });
            assert!(is_kebab, "{name}");
            assert_eq!(ErrorCode::named(name).map(ErrorCode::name), Some(name));
        }
    }

    #[test]
    fn the_page_of_the_documentation_is_up_to_date() {
        let written = include_str!("../docs/errors.md");
        assert!(written == ErrorCode::page(), "write it anew: vanecut explain > docs/errors.md");
    }
}
