//! Documents to print or to open in a browser: the setup sheet of a plan, and the page of an assessment. Both
//! are HTML with drawings as SVG; pictures stand beside them as PNG. Window and command line write the same
//! ones.

#[cfg(feature = "gpu")]
pub mod assessment;
#[cfg(feature = "gpu")]
pub mod assessment_figures;
pub mod chart;
mod html;
#[cfg(feature = "gpu")]
pub mod pictures;
pub mod sheet;
pub mod words;

use std::path::{Path, PathBuf};

/// A page, and the pictures that stand beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportPage {
    /// The page as HTML.
    pub page: String,
    /// Its pictures.
    pub pictures: Vec<PagePicture>,
}

/// A picture of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct PagePicture {
    /// Its file's name, without a folder.
    pub name: String,
    /// Its content, PNG or SVG.
    pub bytes: Vec<u8>,
    /// What it shows.
    pub caption: String,
}

impl ReportPage {
    /// All files of the document whose page is saved at `path`; the page comes last.
    pub fn files_at(&self, path: &Path) -> Vec<(PathBuf, &[u8])> {
        let pictures = self.pictures.iter();
        let pictures = pictures.map(|picture| (path.with_file_name(&picture.name), &picture.bytes[..]));
        pictures.chain([(path.to_owned(), self.page.as_bytes())]).collect()
    }
}
