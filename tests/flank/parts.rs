//! Parts of the repository.

use std::path::Path;

use vanecut::io::part_file::read_part;
use vanecut::part::Impeller;

/// The part in the file at `path`, seen from the repository.
pub fn part_at(path: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}
