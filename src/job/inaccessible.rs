//! What makes floor of a planned channel inaccessible.

use super::PlanOutcome;
use crate::stock::{FloorSource, InaccessibleFloor, inaccessible_floor, stretches_of_setup};

impl PlanOutcome {
    /// What makes floor inaccessible, whichever the policy, the largest share first.
    pub fn inaccessible_floor(&self) -> Vec<InaccessibleFloor> {
        let cutters = stretches_of_setup(&self.setup);
        let stock = &self.setup.allowances;
        inaccessible_floor(&FloorSource { workpiece: &self.workpiece, stock, cutters: &cutters }, &self.grid)
    }
}
