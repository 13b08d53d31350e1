//! Which cutters are loaded, and by what they are coloured.

use std::sync::Arc;

use crate::app::model::cutter_colours::{CutterClass, CutterColours};
use crate::app::model::planned::DisplayPlan;
use crate::setup::AxisPolicy;

/// Colours of the cutters of a plan, and the classes that are left out.
#[derive(Clone, Debug)]
pub(super) struct ColouredCutters {
    pub(super) colours: CutterColours,
    pub(super) hidden: Vec<CutterClass>,
    pub(super) planned: Arc<DisplayPlan>,
    pub(super) policy: AxisPolicy,
    /// All plans in view, for which a colour means the same.
    pub(super) in_view: Vec<(Arc<DisplayPlan>, AxisPolicy)>,
}

impl PartialEq for ColouredCutters {
    /// Plans are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        (self.colours, &self.hidden, self.policy) == (other.colours, &other.hidden, other.policy)
            && Arc::ptr_eq(&self.planned, &other.planned)
            && self.in_view.len() == other.in_view.len()
            && self.in_view.iter().zip(&other.in_view).all(|(a, b)| Arc::ptr_eq(&a.0, &b.0) && a.1 == b.1)
    }
}
