//! The choice of the tool of a flank plan: the one that the setup names, otherwise the thickest that leaves
//! enough space for passes side by side, or a thicker one where that is too short. The tools of the setup
//! come first, where one of them is a ball end that fits.

use super::uncut::UncutLength;
use crate::error::ErrorCode;
use crate::part::{Channel, Impeller, Passage, PassageWidth, Workpiece};
use crate::setup::{AllowanceSetup, AssemblyPart, Setup, SetupFault, SetupPlace, Tool, check_taper};

/// Maximum ratio of the tool diameter to the narrowest width of the channel, so that a tool does not cut both
/// walls at once.
const MAX_DIAMETER_SHARE: f64 = 0.5;
/// The same where no tool within it is long enough to reach the hub with its holder outside.
const MAX_DIAMETER_SHARE_FOR_LENGTH: f64 = 0.7;
/// If the allowances leave less than this share of the thinnest tool or of the narrowest width, the message
/// suggests a smaller allowance.
const MIN_ROOM_SHARE: f64 = 0.1;
/// The overhang exceeds the channel's depth by this factor, as axes are inclined.
const OVERHANG_MARGIN: f64 = 1.15;
/// Stations along a passage at which its width is measured.
const STATIONS: usize = 24;

/// A tool, and why it was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenTool {
    /// The tool.
    pub tool: Tool,
    /// The reason as one line of text; `None` where the setup names the tool.
    pub reason: Option<String>,
}

/// The tools that a flank plan of `setup` may be given by number: its own, then those of `library` whose
/// numbers it does not use.
pub fn selectable<'a>(setup: &'a Setup, library: &'a [Tool]) -> impl Iterator<Item = &'a Tool> {
    let is_own = move |number: u32| setup.tools.iter().any(|own| own.number == number);
    setup.tools.iter().chain(library.iter().filter(move |tool| !is_own(tool.number)))
}

/// The tool for `setup`: by its number, otherwise from its tools if a ball end among them fits into the
/// channel, otherwise from `library` if one does there, otherwise the best of its tools. Those of `library`
/// have rates for steel, and get those for the material of `setup`.
///
/// # Errors
/// When neither the setup nor the library has a tool of that number, or no tool fits between the blades.
pub fn choose_tool(workpiece: &Workpiece, setup: &Setup, library: &[Tool]) -> Result<ChosenTool, SetupFault> {
    ChannelSpace::from_workpiece(workpiece, &setup.allowances).choose_tool(setup, library)
}

/// A tool chosen from the library because no tool of the `setup` fits, under a number not yet in use.
fn from_library(chosen: ChosenTool, setup: &Setup) -> ChosenTool {
    let ChosenTool { mut tool, reason } = chosen;
    if setup.tools.iter().any(|own| own.number == tool.number) {
        tool.renumber(setup.tools.iter().map(|own| own.number).max().unwrap_or(0) + 1);
    }
    let why = "from the tool library, as no ball end of the setup fits into the channel";
    ChosenTool { tool, reason: reason.map(|reason| format!("{reason}; {why}")) }
}

/// The space in the channel that a tool has to fit into.
#[derive(Clone, Copy, Debug)]
pub struct ChannelSpace {
    /// Minimum and maximum width of the channel, mm.
    widths: [f64; 2],
    /// Maximum height of the channel above the hub, mm.
    depth: f64,
    /// See [`crate::setup::AllowanceSetup`], mm.
    blade_allowance: f64,
}

impl ChannelSpace {
    /// The space in a channel with these allowances.
    pub fn from_workpiece(workpiece: &Workpiece, allowances: &AllowanceSetup) -> Self {
        Self {
            widths: widths(&workpiece.part, &workpiece.channel),
            depth: deepest(&workpiece.part),
            blade_allowance: allowances.blade_allowance,
        }
    }

    /// As [`choose_tool`], for a workpiece whose space is known.
    ///
    /// # Errors
    /// As [`choose_tool`].
    pub fn choose_tool(&self, setup: &Setup, library: &[Tool]) -> Result<ChosenTool, SetupFault> {
        let library: &[Tool] = &setup.allowances.tools_for_material(library);
        if let Some(number) = setup.flank.tool {
            let tool = selectable(setup, library).find(|t| t.number == number).ok_or_else(|| {
                SetupFault::new(
                    ErrorCode::UndefinedTool,
                    format!("neither the setup nor the tool library has tool {number}"),
                    "add the tool, name another, or leave `tool` out to have one chosen",
                )
                .at(SetupPlace::Flank("tool"))
            })?;
            check_taper(tool)?;
            return Ok(ChosenTool { tool: tool.clone(), reason: None });
        }
        let own = if setup.tools.is_empty() { library } else { &setup.tools };
        let chosen = choose_from(own, self);
        if setup.tools.is_empty() || chosen.as_ref().is_ok_and(|chosen| self.fits_ball_end(&chosen.tool)) {
            return chosen;
        }
        match choose_from(library, self) {
            Ok(other) if self.fits_ball_end(&other.tool) => Ok(from_library(other, setup)),
            _ => chosen,
        }
    }

    /// Width that a tool leaves free where the channel is narrowest, mm.
    fn free_width(&self, tool: &Tool) -> f64 {
        self.widths[0] - 2.0 * (tool.radius() + self.blade_allowance)
    }

    /// Whether a tool is a ball-end cutter that fits the channel. Other shapes leave far more of the floor,
    /// and a ball larger than the channel is deep has no flank in it.
    fn fits_ball_end(&self, tool: &Tool) -> bool {
        !tool.is_tapered()
            && tool.is_ball()
            && tool.corner_radius <= self.depth
            && self.free_width(tool) >= 0.0
    }
}

/// Chooses one of `tools` for the channel.
///
/// # Errors
/// When there is none, or none fits between the blades.
fn choose_from(tools: &[Tool], space: &ChannelSpace) -> Result<ChosenTool, SetupFault> {
    let ChannelSpace { widths: [width, widest], depth, blade_allowance } = *space;
    let tools = suited(tools, depth)?;
    let free_width = |t: &Tool| space.free_width(t);
    let easy = |t: &Tool| t.diameter <= MAX_DIAMETER_SHARE * width && free_width(t) >= 0.0;
    let thickest = |fits: &dyn Fn(&&Tool) -> bool| {
        tools.iter().copied().filter(fits).map(|t| t.diameter).max_by(f64::total_cmp)
    };
    let least = tools.iter().map(|t| t.diameter).fold(f64::INFINITY, f64::min);
    // Where not even the thinnest tool passes the narrowest width it still cuts the wider part.
    let reaches = widest > least + 2.0 * blade_allowance;
    let diameter = thickest(&|t| easy(t))
        .or_else(|| thickest(&|t| free_width(t) >= 0.0))
        .or(Some(least).filter(|_| reaches && least.is_finite()));
    let Some(diameter) = diameter else {
        return Err(no_room([width, widest], least, blade_allowance));
    };
    // Of several lengths the shortest that reaches the hub with the holder outside, otherwise the longest.
    let wanted = OVERHANG_MARGIN * depth;
    let same = || tools.iter().copied().filter(|t| t.diameter == diameter);
    let reach = same().map(|t| t.overhang.min(wanted)).fold(0.0, f64::max);
    // Where that is too short: the thinnest of the thicker tools that reach further.
    let longer = tools
        .iter()
        .copied()
        .filter(|t| {
            t.diameter > diameter
                && t.diameter <= MAX_DIAMETER_SHARE_FOR_LENGTH * width
                && free_width(t) >= 0.0
        })
        .filter(|t| t.overhang.min(wanted) > reach)
        .max_by(|a, b| {
            let by_reach = a.overhang.min(wanted).total_cmp(&b.overhang.min(wanted));
            by_reach.then(b.diameter.total_cmp(&a.diameter)).then(b.overhang.total_cmp(&a.overhang))
        });
    let tool = longer
        .or_else(|| same().filter(|t| t.overhang >= reach).min_by(|a, b| a.overhang.total_cmp(&b.overhang)));
    let Some(tool) = tool else {
        return Err(SetupFault::new(
            ErrorCode::UndefinedTool,
            "there is no tool to choose from",
            "give a [[tool]]",
        ));
    };
    let which = match tool {
        tool if longer.is_some() && tool.overhang >= wanted => "thinnest cutter long enough for",
        _ if longer.is_some() => "longest cutter for",
        tool if easy(tool) => "thickest cutter within half of",
        tool if free_width(tool) >= 0.0 => "thickest cutter that fits",
        _ => "thinnest cutter, too thick for",
    };
    let reason = format!(
        "D {} is the {which} the narrowest passage, {width:.1} mm; overhang {} for a depth of {depth:.1} mm",
        tool.diameter, tool.overhang
    );
    Ok(ChosenTool { tool: tool.clone(), reason: Some(reason) })
}

/// What a longer tool would free, one line, where a holder is in the way of passes: the overhang that was
/// found for them; else, of a tool shorter than the channel asks for, one that keeps the holder out of the
/// channel, and that is enough where one was found.
pub fn overhang_note(tool: &Tool, uncut: &[UncutLength], part: &Impeller) -> Option<String> {
    let is_freed = |left: &&UncutLength| match left.why.hindered_by {
        Some(AssemblyPart::Holder) => true,
        Some(AssemblyPart::Shank) => left.overhang.is_some(),
        None => false,
    };
    let by = |part: AssemblyPart| uncut.iter().filter(move |left| left.why.is_by(part));
    let by_holder: f64 = by(AssemblyPart::Holder).map(|left| left.length).sum();
    let by_shank: f64 = by(AssemblyPart::Shank).filter(|left| !is_freed(left)).map(|left| left.length).sum();
    if by_shank > by_holder {
        return Some(
            "the shank is in the way of passes: give longer flutes, a thinner neck, or a smaller [clearance]"
                .to_owned(),
        );
    }
    let hindered = || uncut.iter().filter(is_freed);
    let known = hindered().map(|left| left.overhang).reduce(|a, b| a.zip(b).map(|(a, b)| a.max(b)))?;
    let has = tool.overhang;
    if let Some(most) = known {
        return Some(format!(
            "the holder is in the way of passes: an overhang of {most} mm would do, instead of {has}"
        ));
    }
    let depth = deepest(part);
    let found = hindered().filter_map(|left| left.overhang).fold(0.0, f64::max);
    let wanted = (OVERHANG_MARGIN * depth).ceil().max(found);
    (has < wanted).then(|| {
        format!(
            "the holder is in the way of passes: in a channel {depth:.1} mm deep give an overhang of {wanted} mm \
             or more, instead of {has}"
        )
    })
}

/// The tools to choose from: cylindrical ones, of these those that end in a ball, or else in more than half
/// of one, and of these those whose ball is not larger than the channel is deep (`depth`, mm), so that walls
/// are cut by the cylinder; each where there are such.
fn suited<'a>(tools: &'a [Tool], depth: f64) -> Result<Vec<&'a Tool>, SetupFault> {
    let cylindrical: Vec<&Tool> = tools.iter().filter(|tool| !tool.is_tapered()).collect();
    if cylindrical.is_empty() {
        tools.iter().try_for_each(check_taper)?;
    }
    let of = |tools: Vec<&'a Tool>, suits: &dyn Fn(&Tool) -> bool| -> Vec<&'a Tool> {
        let suited: Vec<&Tool> = tools.iter().copied().filter(|tool| suits(tool)).collect();
        if suited.is_empty() { tools } else { suited }
    };
    let balls = of(of(cylindrical, &|tool| !tool.is_flat()), &Tool::is_ball);
    Ok(of(balls, &|tool| tool.corner_radius <= depth))
}

/// The error that no tool fits into a channel of this narrowest and widest width, mm.
fn no_room([narrowest, widest]: [f64; 2], thinnest: f64, allowance: f64) -> SetupFault {
    let left = widest - 2.0 * allowance;
    let help = if left > thinnest.min(narrowest) * MIN_ROOM_SHARE {
        format!("give a cutter below D {left:.2} or a smaller blade allowance")
    } else {
        // The allowances alone fill the channel.
        let share = (0.1 * narrowest).max(1e-3);
        format!("give a blade allowance of {share:.3} mm and a cutter below D {:.2}", narrowest - 2.0 * share)
    };
    SetupFault::new(
        ErrorCode::CutterTooWide,
        format!(
            "no cutter fits between the blades: the channel is {narrowest:.2} to {widest:.2} mm wide, the \
             thinnest cutter is D {thinnest}, and the blade allowance is {allowance} mm on each side"
        ),
        help,
    )
}

/// Minimum and maximum over s of the least distance between the walls of the channel, beside splitters where
/// there are some, mm.
fn widths(part: &Impeller, channel: &Channel) -> [f64; 2] {
    let along = |passage: &Passage, from: f64, to: f64| {
        let width = PassageWidth::new(part, passage);
        (0..=STATIONS)
            .map(|i| width.least(from + (to - from) * i as f64 / STATIONS as f64))
            .filter(|width| width.is_finite())
            .fold([f64::INFINITY, 0.0], |[least, most], width| [least.min(width), f64::max(most, width)])
    };
    channel.bounded_passages().iter().fold([f64::INFINITY, 0.0], |[least, most], bounded| {
        let begins = bounded.begins[0].max(bounded.begins[1]);
        let ends = bounded.ends[0].min(bounded.ends[1]).clamp(begins, 1.0);
        let here = along(&channel.passages[bounded.index], begins, ends);
        [least.min(here[0]), most.max(here[1])]
    })
}

/// Maximum height of the channel above the hub, mm.
fn deepest(part: &Impeller) -> f64 {
    let at = |i: i32| {
        let s = f64::from(i) / 40.0;
        part.hub.curve().project(part.shroud.point(s)).1.max(part.hub.point(s).distance(part.shroud.point(s)))
    };
    (0..=40).map(at).fold(0.0, f64::max)
}
