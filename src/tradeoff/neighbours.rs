//! Plunges that are still in the plan before and after each one of a chain.

/// Chains of plunges, each a doubly linked list.
pub(super) struct KeptNeighbours {
    links: Vec<KeptLink>,
}

/// The kept plunges beside one.
#[derive(Clone, Copy, Debug, Default)]
struct KeptLink {
    before: Option<usize>,
    after: Option<usize>,
}

impl KeptNeighbours {
    /// `count` plunges, none of which is in a chain.
    pub fn unlinked(count: usize) -> Self {
        Self { links: vec![KeptLink::default(); count] }
    }

    /// Links the plunges of `chain`, of which none is in a chain yet, in this order.
    pub fn link(&mut self, chain: &[usize]) {
        for pair in chain.windows(2) {
            self.links[pair[0]].after = Some(pair[1]);
            self.links[pair[1]].before = Some(pair[0]);
        }
    }

    pub fn before(&self, plunge: usize) -> Option<usize> {
        self.links[plunge].before
    }

    pub fn after(&self, plunge: usize) -> Option<usize> {
        self.links[plunge].after
    }

    /// Takes `plunge` out of its chain.
    pub fn leave_out(&mut self, plunge: usize) {
        let KeptLink { before, after } = std::mem::take(&mut self.links[plunge]);
        if let Some(before) = before {
            self.links[before].after = after;
        }
        if let Some(after) = after {
            self.links[after].before = before;
        }
    }
}
