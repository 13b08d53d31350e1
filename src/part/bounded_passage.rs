//! Where each passage of a channel begins and ends, and between which blades it lies.

use super::channel::{Channel, Division};

/// A passage of a channel with its bounds.
#[derive(Clone, Copy, Debug)]
pub struct BoundedPassage {
    /// Index in [`Channel::passages`].
    pub index: usize,
    /// The blades on its two sides: positions in [`Channel::splitters`], `None` for a main blade.
    pub splitters: [Option<usize>; 2],
    /// s at which it begins, on the hub and on the shroud: 0, or the leading edge of a splitter.
    pub begins: [f64; 2],
    /// s of the leading edge that divides it, on the hub and on the shroud; infinite where none does.
    pub ends: [f64; 2],
}

impl Channel {
    /// All passages with their bounds: the whole channel, then from the first wall to the second those that
    /// splitters divide it into, each before those that it is divided into.
    pub fn bounded_passages(&self) -> Vec<BoundedPassage> {
        let mut found = Vec::new();
        let mut open = vec![(0, [None; 2], [0.0; 2], self.division.as_deref())];
        while let Some((index, splitters, begins, division)) = open.pop() {
            let ends = division.map_or([f64::INFINITY; 2], |division| division.s);
            found.push(BoundedPassage { index, splitters, begins, ends });
            if let Some(Division { splitter, s, passages, inner }) = division {
                let beside = [[splitters[0], Some(*splitter)], [Some(*splitter), splitters[1]]];
                let begins = [0, 1].map(|end| s[end].max(begins[end]));
                for side in [1, 0] {
                    open.push((passages[side], beside[side], begins, inner[side].as_deref()));
                }
            }
        }
        found
    }

    /// s on hub and shroud at which splitters begin, the longest first.
    pub fn noses(&self) -> Vec<[f64; 2]> {
        let mut noses: Vec<[f64; 2]> = self.splitters.iter().map(|splitter| splitter.s).collect();
        noses.sort_by(|a, b| (a[0].max(a[1])).total_cmp(&b[0].max(b[1])));
        noses
    }
}

/// Name of a splitter by its number, counted from 0 at the suction side of the main blade, among the `count`
/// splitters of a pitch.
pub fn splitter_name(number: usize, count: usize) -> String {
    if count == 1 { "splitter".to_owned() } else { format!("splitter {}", number + 1) }
}
