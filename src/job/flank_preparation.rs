//! What a flank plan begins with: the stock, the clock and the tools, and what removes the stock that stands
//! above the shroud before the passes.

use std::sync::Arc;

use super::JobError;
use super::machine::clock_of;
use crate::flank::choice::{ChannelSpace, ChosenTool};
use crate::flank::{FlankMove, FlankOpening, MoveKind};
use crate::io::tool_library::{flank_cutters, plunge_cutters};
use crate::machine::{MachineClock, MachineTool};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Impeller, Workpiece};
use crate::plunge::choice::choose_opening;
use crate::plunge::choice::times::MoveTimes;
use crate::plunge::sections::check_part;
use crate::plunge::{PlanError, Planner};
use crate::setup::{Setup, Tool};

/// Step of the plunges above the shroud, in radii of the cutter for the passes: the stairs that they leave on
/// a steep shroud are in the way of its holder.
const OPENING_STEP_RADII: f64 = 0.5;

/// What a plan begins with: the stock, the clock and the tools.
pub(super) struct Preparation {
    /// The part with its blank.
    pub workpiece: Arc<Workpiece>,
    /// What removes the stock above the shroud before the passes, if it has to be.
    pub opener: Option<Opener>,
    /// The setup as given, with the tool of the opener.
    pub setup: Setup,
    /// What tells the time of programs on the machine of the setup, if it gives one.
    pub clock: Option<MachineClock>,
    /// The space in the channel for which the cutter was chosen.
    pub space: ChannelSpace,
    /// The tool for the passes.
    pub chosen: ChosenTool,
    /// Whether the stock above the shroud needs plunges, with a tool of the setup or of the library.
    pub needs_opening: bool,
}

impl Preparation {
    /// What a plan of `part` with the setup `given` begins with.
    ///
    /// # Errors
    /// When part and setup are incompatible.
    pub(super) fn new(part: &Arc<Impeller>, given: &Setup) -> Result<Self, JobError> {
        let setup = given;
        check_part(setup, part)?;
        let workpiece = Arc::new(setup.allowances.workpiece_of(Arc::clone(part)));
        let clock = clock_of(setup, &workpiece)?;
        let space = ChannelSpace::from_workpiece(&workpiece, &setup.allowances);
        let chosen = space.choose_tool(setup, flank_cutters())?;
        let machine = clock.as_ref().map(MachineClock::machine);
        let opener = Opener::from_part(part, setup, &chosen.tool, machine);
        let needs_opening = opener.is_some() || {
            let from_library = Setup { tools: Vec::new(), ..setup.clone() };
            Opener::from_part(part, &from_library, &chosen.tool, machine).is_some()
        };
        let mut setup = setup.clone();
        let more = opener.iter().map(|opener| &opener.tool).filter(|tool| !given.tools.contains(tool));
        setup.tools.extend(more.cloned());
        Ok(Self { workpiece, opener, setup, clock, space, chosen, needs_opening })
    }
}

/// Those of `tools` that plunges take: of those with a round bottom a plunge leaves much.
pub(super) fn for_plunges(tools: &[Tool]) -> impl Iterator<Item = &Tool> {
    tools.iter().filter(|tool| tool.is_flat() && !tool.is_tapered())
}

/// What removes the stock above the shroud before the passes.
pub(super) struct Opener {
    /// Its tool, one of the setup or with a number that no tool of the setup has.
    pub tool: Tool,
    /// A setup with one section, which opens the blank.
    setup: Setup,
}

impl Opener {
    /// The opener for passes with `tool`; `None` where the blank hardly stands above the shroud.
    pub(super) fn from_part(
        part: &Impeller,
        setup: &Setup,
        tool: &Tool,
        machine: Option<&MachineTool>,
    ) -> Option<Self> {
        let own: Vec<Tool> = for_plunges(&setup.tools).cloned().collect();
        let library = setup.allowances.tools_for_material(plunge_cutters());
        let from: &[Tool] = if own.is_empty() { &library } else { &own };
        let mut setup = setup.clone();
        let step = OPENING_STEP_RADII * tool.radius();
        setup.plunge.step = Some(setup.plunge.step.map_or(step, |given| given.min(step)));
        let setup = &setup;
        let mut section = choose_opening(setup, from, part, tool, None, MoveTimes::on(machine))?.section;
        let mut opener = from.iter().find(|tool| tool.number == section.tool)?.clone();
        if own.is_empty() {
            let numbers = setup.tools.iter().map(|tool| tool.number);
            opener.renumber(numbers.chain([tool.number]).max().unwrap_or(0) + 1);
        }
        section.tool = opener.number;
        let mut setup = Setup { tools: vec![opener.clone()], ..setup.clone() };
        setup.plunge.sections = vec![section];
        Some(Self { tool: opener, setup })
    }

    /// The plunges that `moves` of `tool` need.
    ///
    /// # Errors
    /// When cancelled.
    pub(super) fn opening(
        &self,
        workpiece: &Workpiece,
        tool: &Tool,
        moves: &[FlankMove],
        monitor: &Monitor,
    ) -> Result<Option<FlankOpening>, Cancelled> {
        let poses =
            moves.iter().filter(|step| step.kind != MoveKind::Rapid).map(|step| (step.tip, step.axis));
        let planned = Planner::new(workpiece, &self.setup).opening_for(tool, poses, monitor);
        let plan = match planned {
            Err(PlanError::Cancelled(cancelled)) => return Err(cancelled),
            Err(PlanError::Setup(_)) => return Ok(None),
            Ok(plan) => plan,
        };
        let plunges = plan.positions.iter().map(|p| (p.evaluation.retract, p.tip, p.axis)).collect();
        Ok(Some(FlankOpening { tool: self.tool.clone(), plunges, link: Vec::new() }))
    }
}
