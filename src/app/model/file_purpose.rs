//! What a chosen file is for: titles, endings, and whether it is written.

use std::path::Path;

use super::look::Operation;
use super::planned::Side;
use crate::io::nc::Dialect;
use crate::io::project_file::EXTENSION;

/// Endings of programs: APT, and NC code of the known controls.
pub const PROGRAM_ENDINGS: &[&str] =
    &["apt", "cl", "aptsource", "nc", "ngc", "mpf", "spf", "h", "i", "tap", "cnc", "iso", "gcode"];

/// Endings of parts, and of plans, which hold their part.
pub const PART_ENDINGS: &[&str] =
    &["toml", "geomTurbo", "geomturbo", "inf", "step", "stp", "p21", "stl", "glb", "gltf", "json"];

/// Purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A part to open.
    OpenPart,
    /// A project to open.
    OpenProject,
    /// Target of a project.
    SaveProject,
    /// A setup to open.
    OpenSetup,
    /// A blank to take.
    OpenBlank,
    /// A machine file to take.
    OpenMachine,
    /// A tool library to open.
    OpenLibrary,
    /// The part of a project whose file is not where that says.
    LocatePart,
    /// Results of a study to open.
    OpenStudy,
    /// Target of a tool library.
    SaveLibrary,
    /// Target of a setup.
    SaveSetup,
    /// Target of the CL file of the shown plunge plan.
    ExportCl {
        /// Number of channels that the program mills, from the first on.
        channels: usize,
    },
    /// Target of the flank plan's CL file.
    ExportFlank {
        /// Number of channels that the program mills, from the first on.
        channels: usize,
    },
    /// Target of the NC program of an operation.
    ExportNc {
        /// Roughing or flank.
        operation: Operation,
        /// Grammar of its control.
        dialect: Dialect,
    },
    /// A post to write NC programs with.
    OpenPost,
    /// A post to read the program with that is checked.
    OpenPostOfCheck,
    /// Target of the setup sheet of an operation: of the shown plunge plan, or the flank plan.
    ExportSheet {
        /// Roughing or flank.
        operation: Operation,
    },
    /// Target of the page on machinability.
    SaveAssessment,
    /// Target of the glTF scene.
    ExportScene {
        /// The side whose plan is in it, where both are shown; `None`: the one that is shown.
        side: Option<Side>,
    },
    /// Target of the stock as a solid.
    ExportStock {
        /// As of the scene.
        side: Option<Side>,
    },
    /// A program to check.
    CheckProgram,
    /// Target of the picture.
    SavePicture,
}

/// Where files of a kind lie, for the folder in which a dialog starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilePlace {
    /// With a part or its project.
    Part,
    /// With the setups.
    Setups,
    /// With the machines, tools and posts of the shop.
    Shop,
    /// Anywhere else.
    Work,
}

impl Purpose {
    /// Where its files lie.
    pub fn place(self) -> FilePlace {
        match self {
            Self::OpenPart | Self::LocatePart | Self::OpenProject | Self::SaveProject => FilePlace::Part,
            Self::OpenSetup | Self::SaveSetup => FilePlace::Setups,
            Self::OpenMachine
            | Self::OpenLibrary
            | Self::SaveLibrary
            | Self::OpenPost
            | Self::OpenPostOfCheck => FilePlace::Shop,
            _ => FilePlace::Work,
        }
    }

    /// Title of the dialog.
    pub fn title(self) -> &'static str {
        match self {
            Self::OpenPart => "Open part",
            Self::LocatePart => "Locate the part of the project",
            Self::OpenProject => "Open project",
            Self::SaveProject => "Save project",
            Self::OpenSetup => "Open setup",
            Self::OpenBlank => "Open blank",
            Self::OpenMachine => "Open machine file",
            Self::OpenLibrary => "Open library",
            Self::OpenStudy => "Open study results",
            Self::SaveLibrary => "Save library",
            Self::SaveSetup => "Save setup",
            Self::ExportCl { channels: 1 } => "Export CL (APT)",
            Self::ExportCl { .. } => "Export CL of several channels (APT)",
            Self::ExportFlank { channels: 1 } => "Export flank CL (APT)",
            Self::ExportFlank { .. } => "Export flank CL of several channels (APT)",
            Self::ExportNc { .. } => "Export NC program",
            Self::OpenPost | Self::OpenPostOfCheck => "Open post",
            Self::ExportSheet { operation: Operation::Flank } => "Export setup sheet of flank",
            Self::ExportSheet { .. } => "Export setup sheet",
            Self::SaveAssessment => "Save machinability page",
            Self::ExportScene { side: None } => "Export scene",
            Self::ExportScene { side: Some(Side::Before) } => "Export scene of the side Before",
            Self::ExportScene { side: Some(Side::After) } => "Export scene of the side After",
            Self::ExportStock { side: None } => "Export stock",
            Self::ExportStock { side: Some(Side::Before) } => "Export stock of the side Before",
            Self::ExportStock { side: Some(Side::After) } => "Export stock of the side After",
            Self::CheckProgram => "Check program",
            Self::SavePicture => "Save picture",
        }
    }

    /// What is written: a file of one kind does not make up for one of another. Empty for a file that is
    /// read.
    pub fn kind(self) -> &'static str {
        match self {
            Self::SaveProject => "project",
            Self::SaveSetup => "setup",
            Self::SaveLibrary => "tool library",
            Self::ExportCl { .. } => "plunge program",
            Self::ExportFlank { .. } => "flank program",
            Self::ExportNc { .. } => "NC program",
            Self::ExportSheet { .. } => "setup sheet",
            Self::SaveAssessment => "machinability page",
            Self::ExportScene { .. } => "scene",
            Self::ExportStock { .. } => "stock",
            Self::SavePicture => "picture",
            Self::OpenPart
            | Self::OpenProject
            | Self::OpenSetup
            | Self::OpenBlank
            | Self::OpenMachine
            | Self::OpenLibrary
            | Self::LocatePart
            | Self::OpenStudy
            | Self::OpenPost
            | Self::OpenPostOfCheck
            | Self::CheckProgram => "",
        }
    }

    /// The operation whose plan is written; `None` for other files.
    pub fn planned_operation(self) -> Option<Operation> {
        match self {
            Self::ExportCl { .. } | Self::ExportScene { .. } => Some(Operation::Roughing),
            Self::ExportFlank { .. } => Some(Operation::Flank),
            Self::ExportNc { operation, .. } | Self::ExportSheet { operation } => Some(operation),
            _ => None,
        }
    }

    /// Whether a file is written.
    pub fn saves(self) -> bool {
        !self.kind().is_empty()
    }

    /// Whether a file must have one of its endings: one that is written, and a machine file, which shares its
    /// ending with others.
    pub fn requires_ending(self) -> bool {
        self.saves() || self == Self::OpenMachine
    }

    /// Whether the ending of a name is one of this purpose.
    pub fn fits(self, name: &Path) -> bool {
        let ending = name.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        self.filter().1.iter().any(|known| ending.as_deref() == Some(known.to_lowercase().as_str()))
    }

    /// What the files are, and their endings.
    pub fn filter(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::OpenPart | Self::LocatePart => ("Impellers and plans", PART_ENDINGS),
            Self::OpenProject | Self::SaveProject => ("Projects", &[EXTENSION]),
            Self::OpenSetup | Self::SaveSetup => ("Setups", &["toml"]),
            Self::OpenLibrary => ("Tool libraries", &["toml", "json", "tools", "fctb", "fctl"]),
            Self::SaveLibrary => ("Tool libraries", &["toml", "json"]),
            Self::OpenStudy => ("Study results", &["csv", "json"]),
            Self::OpenBlank => ("Blanks", &["stl", "txt"]),
            Self::OpenMachine => ("Machine files", &["toml"]),
            Self::ExportCl { .. } | Self::ExportFlank { .. } => ("APT cutter location", &["apt", "cl"]),
            Self::ExportNc { dialect, .. } => ("NC programs", endings_of(dialect)),
            Self::OpenPost | Self::OpenPostOfCheck => ("Posts", &["toml"]),
            Self::ExportSheet { .. } | Self::SaveAssessment => ("Pages", &["html"]),
            Self::CheckProgram => ("Programs", PROGRAM_ENDINGS),
            Self::ExportScene { .. } => ("glTF scenes", &["glb"]),
            Self::ExportStock { .. } => ("Solids", &["stl", "glb"]),
            Self::SavePicture => ("Pictures", &["png"]),
        }
    }
}

/// Endings of the programs of a control; the first is added to a name without one.
fn endings_of(dialect: Dialect) -> &'static [&'static str] {
    match dialect {
        Dialect::Heidenhain => &["h"],
        Dialect::Siemens => &["mpf", "spf"],
        Dialect::Fanuc | Dialect::Haas => &["nc", "tap", "cnc", "ngc"],
        Dialect::LinuxCnc => &["ngc", "nc"],
    }
}

/// The ending that is proposed for a program of a control.
pub fn ending_of(dialect: Dialect, is_subprogram: bool) -> &'static str {
    match dialect {
        Dialect::Siemens if is_subprogram => "spf",
        _ => endings_of(dialect).first().copied().unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::part_file;

    #[test]
    fn every_part_that_is_read_is_listed() {
        assert_eq!(&PART_ENDINGS[..part_file::EXTENSIONS.len()], part_file::EXTENSIONS);
    }
}
