//! Cache of the sections of the last plan: only the sections that depend on a change, and all that are cut
//! after them, are planned again.

use std::sync::Arc;

use super::choice::rest::rest_threshold_after;
use super::cut::SectionCut;
use crate::setup::{
    AllowanceSetup, AxisPolicy, ClearanceSetup, Goal, Machine, PlungeSetup, SectionSetup, Setup, SetupFault,
    Tool, tool_of,
};

/// Cache key of a section: what its rows depend on, besides the part and the earlier sections.
#[derive(Clone, Debug, PartialEq)]
struct SectionKey {
    stock: AllowanceSetup,
    clearances: ClearanceSetup,
    tool: Tool,
    section: SectionSetup,
    plunge: PlungeSetup,
    machine: Machine,
    /// Layer from which on stock is left to a later rest-milling section, mm.
    rest_from: Option<f64>,
}

impl SectionKey {
    /// Key of section `index`. Values that do not influence the position of the cutter are normalised.
    fn from_setup(setup: &Setup, index: usize) -> Result<Self, SetupFault> {
        let section = &setup.plunge.sections[index];
        let tool = tool_of(setup, section.tool)?;
        Ok(Self {
            stock: AllowanceSetup { safety_distance: 0.0, material: None, ..setup.allowances.clone() },
            clearances: setup.clearances,
            tool: Tool { number: 0, plunge_feed: 0.0, spindle: 0.0, ..tool.with_given_rates() },
            section: SectionSetup { tool: 0, ..section.clone() },
            plunge: PlungeSetup {
                axis: AxisPolicy::Conventional,
                sections: Vec::new(),
                edits: Vec::new(),
                rest: false,
                goal: Goal::default(),
                lead_out: None,
                peck: None,
                adapt_feed: false,
                rapid_approach: false,
                ..setup.plunge.clone()
            },
            machine: setup.machine.clone(),
            rest_from: rest_threshold_after(setup, index)?,
        })
    }
}

/// Cache of the sections of the last plan of a part by one policy.
#[derive(Debug, Default)]
pub struct SectionCache {
    sections: Vec<(SectionKey, Arc<SectionCut>)>,
    /// All sections of the last finished plan, stale or not: the source of the warm start.
    complete: Vec<(SectionKey, Arc<SectionCut>)>,
}

impl SectionCache {
    /// Number of leading sections that are valid for `setup`.
    ///
    /// # Errors
    /// When the tool of a section is missing in the setup.
    pub fn valid_prefix(&self, setup: &Setup) -> Result<usize, SetupFault> {
        for (index, (before, _)) in self.sections.iter().enumerate() {
            if index == setup.plunge.sections.len() || *before != SectionKey::from_setup(setup, index)? {
                return Ok(index);
            }
        }
        Ok(self.sections.len())
    }

    /// The same with the first `count` sections alone.
    pub fn leading(&self, count: usize) -> Self {
        Self { sections: self.sections.iter().take(count).cloned().collect(), complete: Vec::new() }
    }

    /// Stores the current plan as the last finished one, if all of its `sections` sections are cached.
    pub(super) fn store_complete(&mut self, sections: usize) {
        if self.sections.len() == sections {
            self.complete.clone_from(&self.sections);
        }
    }

    /// The sections of the last finished plan, if `setup` has as many with the same cutters.
    ///
    /// # Errors
    /// As [`Self::valid_prefix`].
    pub(super) fn last_complete(&self, setup: &Setup) -> Result<Option<Vec<Arc<SectionCut>>>, SetupFault> {
        if self.complete.is_empty() || self.complete.len() != setup.plunge.sections.len() {
            return Ok(None);
        }
        for (index, (before, _)) in self.complete.iter().enumerate() {
            let now = SectionKey::from_setup(setup, index)?;
            if (&before.tool, before.section.kind) != (&now.tool, now.section.kind) {
                return Ok(None);
            }
        }
        Ok(Some(self.complete.iter().map(|(_, cut)| Arc::clone(cut)).collect()))
    }

    /// Section `index` of a plan by `setup` from the cache, or else from `make`, which gets the previous
    /// section; the result is cached if it is finished. All previous sections must be cached.
    ///
    /// # Errors
    /// Those of `make`, and when the tool of the section is missing.
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
            self.sections.push((SectionKey::from_setup(setup, index)?, Arc::clone(&cut)));
        }
        Ok(cut)
    }

    /// Drops the sections that are stale for `setup`.
    ///
    /// # Errors
    /// As [`Self::valid_prefix`].
    pub(super) fn invalidate(&mut self, setup: &Setup) -> Result<(), SetupFault> {
        self.sections.truncate(self.valid_prefix(setup)?);
        Ok(())
    }
}
