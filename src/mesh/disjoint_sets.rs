//! Sets that grow together.

/// Disjoint sets of numbers (union-find with path halving).
#[derive(Clone, Debug, Default)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Each number below `count` in a set of its own.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// Adds the next number, in a set of its own.
    pub fn add(&mut self) -> u32 {
        let number = self.parent.len() as u32;
        self.parent.push(number);
        number
    }

    /// The number that stands for the set of `number`.
    pub fn root(&mut self, mut number: u32) -> u32 {
        while self.parent[number as usize] != number {
            let above = self.parent[number as usize];
            self.parent[number as usize] = self.parent[above as usize];
            number = self.parent[number as usize];
        }
        number
    }

    /// Unites two sets; the root of `kept` stands for both.
    pub fn join(&mut self, kept: u32, other: u32) {
        let (kept, other) = (self.root(kept), self.root(other));
        self.parent[other as usize] = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_have_the_root_of_the_first() {
        let mut sets = DisjointSets::new(4);
        assert_eq!(sets.add(), 4);
        for (kept, other) in [(3, 1), (0, 4), (1, 0), (4, 3)] {
            sets.join(kept, other);
        }
        assert_eq!([0, 1, 2, 3, 4].map(|k| sets.root(k)), [3, 3, 2, 3, 3]);
    }
}
