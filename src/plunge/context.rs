//! What every step of planning reads and none changes: the workpiece and the complete setup, with what
//! follows from both whichever policy plans. It is made in one place,
//! [`plan_context`](super::opening_section::plan_context).

use rayon::prelude::*;

use super::assembly::AssemblyRule;
use super::error::PlanError;
use super::locked_plunge::LockedPlunge;
use super::position_limit::{MAX_POSITIONS, too_many_positions};
use super::row_density::RowDensity;
use super::section_layout::{StretchLayout, section_layout};
use super::thoroughness::{Thoroughness, row_places};
use crate::cutting::contact::Columns;
use crate::monitor::Monitor;
use crate::part::Workpiece;
use crate::setup::{SectionKind, SectionSetup, Setup, SetupFault, SetupPlace, Tool, tool_of};

/// Progress of planning one channel when its first section begins, and share of the sections in it; what
/// remains is assembling and evaluating the plan.
const BEFORE_SECTIONS_SHARE: f64 = 0.1;
const SECTIONS_SHARE: f64 = 0.7;

/// The context of planning one channel.
#[derive(Debug)]
pub(super) struct PlanContext<'a> {
    /// The part with its channel, blank and finished surfaces.
    pub workpiece: &'a Workpiece,
    /// Allowances, tools, machine and sections; complete, see [`super::sections::resolve`].
    pub setup: &'a Setup,
    /// How closely `minimal` places its rows.
    pub density: RowDensity,
    /// The plunges of the sections that open the blank.
    pub opening: Columns,
    /// The locked plunges of each section, around which the others are planned; empty without any.
    pub locked: Vec<Vec<LockedPlunge>>,
    /// Whether `minimal` begins no other section after one that starves.
    pub ends_where_starved: bool,
    /// How thoroughly `minimal` searches each section.
    thoroughness: Vec<Thoroughness>,
    /// Layout of each section; empty for sections that do not cut rows.
    layouts: Vec<Result<Vec<StretchLayout<'a>>, PlanError>>,
}

impl<'a> PlanContext<'a> {
    /// The context without the plunges that open the blank, which are planned in it.
    pub fn new(workpiece: &'a Workpiece, setup: &'a Setup, density: RowDensity) -> Self {
        let layout = |section: &SectionSetup| match section.kind {
            SectionKind::Rows => section_layout(workpiece, setup, section, density),
            SectionKind::Rest | SectionKind::Opening => Ok(Vec::new()),
        };
        let sections = &setup.plunge.sections;
        let layouts: Vec<Result<Vec<StretchLayout>, PlanError>> = sections.par_iter().map(layout).collect();
        let places = |(section, layouts): (&SectionSetup, &Result<Vec<StretchLayout>, PlanError>)| {
            // A section that cannot be planned is reported when it is.
            let (Ok(layouts), Ok(tool)) = (layouts, tool_of(setup, section.tool)) else { return 0.0 };
            row_places(layouts, &setup.plunge, tool)
        };
        let thoroughness = Thoroughness::of_sections(sections.iter().zip(&layouts).map(places));
        Self {
            workpiece,
            setup,
            density,
            opening: Columns::default(),
            locked: Vec::new(),
            ends_where_starved: false,
            thoroughness,
            layouts,
        }
    }

    /// Section `index` of the setup.
    pub fn section(&self, index: usize) -> &'a SectionSetup {
        &self.setup.plunge.sections[index]
    }

    /// The tool of section `index`.
    ///
    /// # Errors
    /// When the setup lacks it.
    pub fn tool_of_section(&self, index: usize) -> Result<&'a Tool, SetupFault> {
        tool_of(self.setup, self.section(index).tool)
    }

    /// How thoroughly `minimal` searches section `index`.
    pub fn thoroughness(&self, index: usize) -> Thoroughness {
        self.thoroughness[index]
    }

    /// The locked plunges of section `index`.
    pub fn locked(&self, index: usize) -> Vec<LockedPlunge> {
        self.locked.get(index).cloned().unwrap_or_default()
    }

    /// Layout of section `index`; empty for one that does not cut rows.
    ///
    /// # Errors
    /// When the section's tool is missing.
    pub fn layouts(&self, index: usize) -> Result<&[StretchLayout<'a>], PlanError> {
        self.layouts[index].as_deref().map_err(PlanError::clone)
    }

    /// The rule for shank and holder of `tool`; `None` where neither is given.
    pub fn assembly_rule<'r>(&'r self, tool: &'r Tool) -> Option<AssemblyRule<'r>> {
        let Workpiece { finished, blank, .. } = self.workpiece;
        AssemblyRule::new(tool, finished, blank, self.setup).map(|rule| rule.after(self.opening.all()))
    }

    /// Checks that the plan may have this number of `positions`, of which the last ones are cut by `tool`.
    ///
    /// # Errors
    /// At `place` when they are too many.
    pub fn check_count(&self, positions: usize, tool: &Tool, place: SetupPlace) -> Result<(), PlanError> {
        if positions <= MAX_POSITIONS {
            return Ok(());
        }
        Err(too_many_positions(positions as f64, &self.setup.plunge, tool, place).into())
    }

    /// Reports that a share (0…1) of the work on section `index` is done.
    pub fn report_section(&self, index: usize, share: f64, monitor: &Monitor) {
        let done = (index as f64 + share) / self.setup.plunge.sections.len() as f64;
        monitor.report(BEFORE_SECTIONS_SHARE + SECTIONS_SHARE * done);
    }
}
