//! Sections of the plan before that still hold: planned again is only what depends on what was changed, and all that is cut
//! after it.

use std::sync::Arc;

use super::choice::rest::thick_after;
use super::cycle::SectionCut;
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
    /// Layer that is left to a smaller cutter, mm.
    rest_from: Option<f64>,
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
                rest: false,
                ..setup.plunge.clone()
            },
            machine: setup.machine.clone(),
            rest_from: thick_after(setup, index)?,
        })
    }
}

/// The sections of the last plan of a part by one policy, from the first on.
#[derive(Debug, Default)]
pub struct KnownSections {
    sections: Vec<(Input, Arc<SectionCut>)>,
    /// All sections of the last plan that was finished, whether they still hold or not.
    whole: Vec<(Input, Arc<SectionCut>)>,
}

impl KnownSections {
    /// How many sections, from the first on, still hold for `setup`.
    ///
    /// # Errors
    /// When a section of the setup has no tool.
    pub fn holding(&self, setup: &Setup) -> Result<usize, SetupFault> {
        for (index, (before, _)) in self.sections.iter().enumerate() {
            if index == setup.plunge.sections.len() || *before != Input::of(setup, index)? {
                return Ok(index);
            }
        }
        Ok(self.sections.len())
    }

    /// Remembers the plan of so many `sections` as a whole, if all of them are known.
    pub(super) fn remember_whole(&mut self, sections: usize) {
        if self.sections.len() == sections {
            self.whole.clone_from(&self.sections);
        }
    }

    /// The sections of the last plan that was finished, if `setup` has as many with the same cutters.
    ///
    /// # Errors
    /// As [`Self::holding`].
    pub(super) fn last_whole(&self, setup: &Setup) -> Result<Option<Vec<Arc<SectionCut>>>, SetupFault> {
        if self.whole.is_empty() || self.whole.len() != setup.plunge.sections.len() {
            return Ok(None);
        }
        for (index, (before, _)) in self.whole.iter().enumerate() {
            let now = Input::of(setup, index)?;
            if (&before.tool, before.section.rest) != (&now.tool, now.section.rest) {
                return Ok(None);
            }
        }
        Ok(Some(self.whole.iter().map(|(_, cut)| Arc::clone(cut)).collect()))
    }

    /// Section `index` of a plan by `setup`, if it is known; else what `make` makes of the section before, which is remembered
    /// when it is finished. The sections before must be known.
    ///
    /// # Errors
    /// Those of `make`, and when the section has no tool.
    pub(super) fn get_or_make<E: From<SetupFault>>(
        &mut self,
        index: usize,
        setup: &Setup,
        make: impl FnOnce(Option<&SectionCut>) -> Result<SectionCut, E>,
    ) -> Result<Arc<SectionCut>, E> {
        if let Some((_, cut)) = self.sections.get(index) {
            return Ok(Arc::clone(cut));
        }
        let cut = Arc::new(make(self.sections.last().map(|(_, cut)| cut.as_ref()))?);
        if !cut.is_unfinished() {
            self.sections.push((Input::of(setup, index)?, Arc::clone(&cut)));
        }
        Ok(cut)
    }

    /// Forgets what does not hold for `setup`.
    ///
    /// # Errors
    /// As [`Self::holding`].
    pub(super) fn keep_for(&mut self, setup: &Setup) -> Result<(), SetupFault> {
        self.sections.truncate(self.holding(setup)?);
        Ok(())
    }
}
