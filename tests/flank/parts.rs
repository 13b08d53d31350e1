//! Parts of the repository, and cutters.

use std::path::Path;

use vanecut::io::part_file::{read_part, read_part_bytes};
use vanecut::part::Impeller;
use vanecut::setup::Tool;

/// The part in the file at `path`, seen from the repository.
pub fn part_at(path: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

/// The part that a text in our own format describes.
pub fn described(text: &str) -> Impeller {
    let description = read_part_bytes("part.toml", text.as_bytes(), "toml");
    Impeller::build(&description.expect("readable")).expect("an impeller")
}

/// A cutter of this diameter, corner radius and overhang, mm.
pub fn cutter(diameter: f64, corner_radius: f64, overhang: f64) -> Tool {
    Tool {
        number: 1,
        diameter,
        corner_radius,
        insert_width: 0.45 * diameter,
        overhang,
        plunge_feed: 300.0,
        spindle: 5000.0,
        assembly: Default::default(),
    }
}
