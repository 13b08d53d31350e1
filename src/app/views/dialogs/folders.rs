//! The folders in which file dialogs start: files of the shop lie elsewhere than those of a part.

use std::path::{Path, PathBuf};

use crate::app::model::file_purpose::{FilePlace, Purpose};

/// The folder of the last file of each place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Folders {
    work: Option<PathBuf>,
    setups: Option<PathBuf>,
    shop: Option<PathBuf>,
}

impl Folders {
    /// Folder in which a dialog starts. Before there is one of its place, it is that of other work, but never
    /// that of the shop: what is saved there by mistake is in the way of others.
    pub(super) fn start(&self, purpose: Purpose) -> Option<&Path> {
        let own = match purpose.place() {
            FilePlace::Work | FilePlace::Part => &self.work,
            FilePlace::Setups => &self.setups,
            FilePlace::Shop => &self.shop,
        };
        own.as_deref().or(self.work.as_deref())
    }

    /// Starts the next dialogs of this place in the folder of a file that was opened or written.
    pub(super) fn note(&mut self, place: FilePlace, file: &Path) {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        let Some(folder) = file.parent() else { return };
        let (known, setups) = match place {
            FilePlace::Work => (&mut self.work, None),
            // Setups of another part lie with that.
            FilePlace::Part | FilePlace::Setups => (&mut self.work, Some(&mut self.setups)),
            FilePlace::Shop => (&mut self.shop, None),
        };
        for known in std::iter::once(known).chain(setups) {
            *known = Some(folder.to_owned());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_file_does_not_lead_setups_to_its_folder() {
        let mut folders = Folders::default();
        let start = |folders: &Folders, purpose| folders.start(purpose).map(Path::to_owned);
        folders.note(Purpose::OpenMachine.place(), Path::new("/machines/mill.toml"));
        assert_eq!(start(&folders, Purpose::SaveSetup), None, "of a sample, which has no folder");
        folders.note(FilePlace::Part, Path::new("/parts/a.toml"));
        folders.note(Purpose::OpenMachine.place(), Path::new("/shop/mill.toml"));
        assert_eq!(start(&folders, Purpose::SaveSetup), Some("/parts".into()), "that of the part");
        assert_eq!(start(&folders, Purpose::OpenLibrary), Some("/shop".into()), "that of the shop");
        folders.note(Purpose::ExportCl { channels: 1 }.place(), Path::new("/nc/a.apt"));
        assert_eq!(start(&folders, Purpose::SaveSetup), Some("/parts".into()));
        folders.note(Purpose::SaveSetup.place(), Path::new("/setups/s.toml"));
        folders.note(Purpose::SavePicture.place(), Path::new("/pictures/s.png"));
        assert_eq!(start(&folders, Purpose::OpenSetup), Some("/setups".into()), "that of the last setup");
        folders.note(FilePlace::Part, Path::new("/other/b.toml"));
        assert_eq!(start(&folders, Purpose::SaveSetup), Some("/other".into()), "that of the new part");
    }
}
