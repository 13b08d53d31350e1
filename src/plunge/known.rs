//! Sections of the plan before that still hold: planned again is only what depends on what was changed, and all that is cut
//! after it.

use std::sync::Arc;

use super::cycle::{Planner, SectionCut};
use super::sections::{SetupFault, tool_of};
use crate::part::setup::{AxisPolicy, PlungeSetup, SectionSetup, Stock};
use crate::part::{Machine, Setup, Tool};

/// What a section's rows depend on, besides the part and the sections before.
#[derive(Clone, Debug, PartialEq)]
struct Input {
    stock: Stock,
    tool: Tool,
    section: SectionSetup,
    plunge: PlungeSetup,
    machine: Machine,
}

impl Input {
    /// Of section `index`. What has no influence on where the cutter goes is made the same for all.
    fn of(setup: &Setup, index: usize) -> Result<Self, SetupFault> {
        let section = &setup.plunge.sections[index];
        let tool = tool_of(setup, section.tool)?;
        Ok(Self {
            stock: Stock { safety_distance: 0.0, ..setup.stock.clone() },
            tool: Tool { number: 0, overhang: 0.0, plunge_feed: 0.0, spindle: 0.0, ..tool.clone() },
            section: SectionSetup { tool: 0, ..section.clone() },
            plunge: PlungeSetup {
                axis: AxisPolicy::Conventional,
                sections: Vec::new(),
                ..setup.plunge.clone()
            },
            machine: setup.machine.clone(),
        })
    }
}

/// The sections of the last plan of a part by one policy, from the first on.
#[derive(Debug, Default)]
pub struct KnownSections {
    sections: Vec<(Input, Arc<SectionCut>)>,
}

impl Planner<'_> {
    /// Section `index`, from `known` or else from `make`, which is given the section before. What was known of it and of those after it
    /// is forgotten when it has changed.
    ///
    /// # Errors
    /// Those of `make`, and when the setup has no such tool.
    pub(super) fn known_or<E: From<SetupFault>>(
        &self,
        index: usize,
        known: &mut KnownSections,
        make: impl FnOnce(Option<&SectionCut>) -> Result<SectionCut, E>,
    ) -> Result<Arc<SectionCut>, E> {
        let input = Input::of(self.setup, index)?;
        if let Some((before, cut)) = known.sections.get(index)
            && *before == input
        {
            return Ok(Arc::clone(cut));
        }
        known.sections.truncate(index);
        let cut = Arc::new(make(known.sections.last().map(|(_, cut)| cut.as_ref()))?);
        known.sections.push((input, Arc::clone(&cut)));
        Ok(cut)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::part_file::read_part_bytes;
    use crate::monitor::Monitor;
    use crate::part::{Channel, Impeller};
    use crate::plunge::PlungePlan;

    fn tool(number: u32, diameter: f64) -> Tool {
        Tool {
            number,
            diameter,
            corner_radius: 0.0,
            insert_width: 0.3 * diameter,
            overhang: 120.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
        }
    }

    fn section(tool: u32, from: f64, to: f64) -> SectionSetup {
        SectionSetup { tool, from, to, feed: None }
    }

    #[test]
    fn only_stale_sections_are_planned_again_and_the_plan_is_the_same() {
        let text = include_bytes!("../../assets/parts/impeller532.toml");
        let description = read_part_bytes("impeller532.toml", text, "toml").unwrap();
        let part = Impeller::build(&description).unwrap();
        let channel = Channel::of(&part);
        let mut setup = Setup { tools: vec![tool(1, 30.0), tool(2, 16.0)], ..Setup::default() };
        setup.plunge.sections = vec![section(1, 1.0, 0.7), section(2, 0.7, 0.45)];
        let monitor = Monitor::default();
        let policy = AxisPolicy::Monotone;
        let mut known = KnownSections::default();
        let mut replanned = |setup: &Setup| -> (PlungePlan, Vec<Arc<SectionCut>>) {
            let planner = Planner::new(&part, &channel, setup);
            let plan = planner.plan_knowing(policy, &mut known, &monitor).unwrap();
            assert_eq!(plan, planner.plan(policy, &monitor).unwrap(), "as planned from scratch");
            (plan, known.sections.iter().map(|(_, cut)| Arc::clone(cut)).collect())
        };
        let (_, first) = replanned(&setup);

        setup.stock.safety_distance = 5.0;
        setup.tools[0].plunge_feed = 111.0;
        setup.tools[1].number = 7;
        setup.plunge.sections[1].tool = 7;
        let (higher, all_known) = replanned(&setup);
        assert!(
            first.iter().zip(&all_known).all(|(a, b)| Arc::ptr_eq(a, b)),
            "nothing that cuts has changed"
        );
        assert!(higher.positions.iter().all(|p| p.retract_clearance >= 5.0 - 1e-6), "but links have");

        setup.plunge.sections[1].to = 0.5;
        let (_, end_moved) = replanned(&setup);
        assert!(Arc::ptr_eq(&first[0], &end_moved[0]) && !Arc::ptr_eq(&first[1], &end_moved[1]));

        setup.plunge.sections[0].to = 0.75;
        setup.plunge.sections[1].from = 0.75;
        let (_, border_moved) = replanned(&setup);
        assert!(!Arc::ptr_eq(&first[0], &border_moved[0]));

        setup.stock.hub_allowance = 0.7;
        let (_, thicker) = replanned(&setup);
        assert!(!Arc::ptr_eq(&border_moved[0], &thicker[0]) && !Arc::ptr_eq(&border_moved[1], &thicker[1]));
    }
}
