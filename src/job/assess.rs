//! The assessment job that window and command line share: a part, and the tools that its setup chooses.

use std::sync::Arc;

use super::resolve;
use crate::assess::Assessment;
use crate::assess::reach::{ReachLimits, ReachSection};
use crate::part::{Impeller, Workpiece};
use crate::setup::{SectionKind, SectionSetup, Setup, SetupFault};

/// A part that was assessed.
#[derive(Debug)]
pub struct AssessedPart {
    /// The part with its blank.
    pub workpiece: Workpiece,
    /// The setup, with the tools and sections that were chosen.
    pub setup: Setup,
    /// All measures.
    pub assessment: Assessment,
    /// Why the reach of the tools is not known: no tools suit the part.
    pub no_reach: Option<SetupFault>,
}

impl AssessedPart {
    /// Measures `part`, and the reach of the tools of `setup`.
    pub fn from_part(part: impl Into<Arc<Impeller>>, setup: &Setup) -> Self {
        let workpiece = setup.allowances.workpiece_of(part);
        let (setup, no_reach) = match resolve(setup, &workpiece) {
            Ok(resolved) => (resolved.setup, None),
            // A part without a suitable cutter can still be measured.
            Err(fault) => (setup.clone(), Some(fault)),
        };
        let limits = ReachLimits {
            hub_allowance: setup.allowances.hub_allowance,
            blade_allowance: setup.allowances.blade_allowance,
            max_tilt_rad: setup.plunge.max_tilt_rad,
            clearances: setup.clearances,
        };
        let assessment = Assessment::from_workpiece(&workpiece, &sections_of(&setup), &limits);
        Self { workpiece, setup, assessment, no_reach }
    }

    /// The stretches of the floor, each with its tool.
    pub fn sections(&self) -> Vec<ReachSection<'_>> {
        sections_of(&self.setup)
    }
}

fn sections_of(setup: &Setup) -> Vec<ReachSection<'_>> {
    let tool = |number: u32| setup.tools.iter().find(|t| t.number == number);
    let sections = setup.plunge.sections.iter();
    // Above the shroud no tool comes to the floor.
    let on_floor = sections.filter(|section| section.kind != SectionKind::Opening);
    on_floor
        .filter_map(|&SectionSetup { from, to, tool: number, kind, .. }| {
            Some(ReachSection { from, to, tool: tool(number)?, kind })
        })
        .collect()
}
