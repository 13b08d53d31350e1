//! Where a part comes from: a file, a mesh file with its options, or a built-in sample.

use std::path::{Path, PathBuf};

use crate::io::part_file::takes_mesh_options;
use crate::mesh::MeshOptions;

/// Source of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartSource {
    /// A file.
    File(PathBuf),
    /// A file from CAD or of meshes, with the options the user set for it.
    Mesh(PathBuf, MeshOptions),
    /// A built-in sample, by name.
    Sample(String),
}

impl PartSource {
    /// The file with its mesh options; `None` for a sample.
    pub fn file(&self) -> Option<(&Path, MeshOptions)> {
        match self {
            Self::File(path) => Some((path, MeshOptions::default())),
            Self::Mesh(path, options) => Some((path, options.clone())),
            Self::Sample(_) => None,
        }
    }

    /// The file with its mesh options, if it comes from CAD or holds meshes.
    pub fn mesh(&self) -> Option<(&Path, MeshOptions)> {
        self.file().filter(|(path, _)| takes_mesh_options(path))
    }

    /// The same at another place: a mesh file keeps its options.
    #[must_use]
    pub fn moved_to(&self, path: PathBuf) -> Self {
        match self {
            Self::Mesh(_, options) => Self::Mesh(path, options.clone()),
            Self::File(_) | Self::Sample(_) => Self::File(path),
        }
    }

    /// Display name.
    pub fn shown(&self) -> String {
        match self {
            Self::File(path) | Self::Mesh(path, _) => path.display().to_string(),
            Self::Sample(name) => name.clone(),
        }
    }
}

/// A built-in sample part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Name; also the part file's name without extension.
    pub name: &'static str,
    /// Short description.
    pub about: &'static str,
}
