//! The cutter of a flank plan: the one the setup names, or the thickest that leaves room for curves side by side.

use crate::part::{Channel, Impeller, Passage, PassageWidth, Setup, Tool};
use crate::plunge::sections::{SetupFault, SetupPlace, tool_of};

/// A cutter is at most this share of the narrowest passage thick, so that it does not cut at both walls at once.
const THICKEST: f64 = 0.5;
/// The overhang exceeds the channel's depth by this factor: axes lean.
const OVERHANG_MARGIN: f64 = 1.15;
/// Places along a passage at which its width is measured.
const STATIONS: usize = 24;

/// A cutter, and why it was chosen; `None` where the setup names it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenTool {
    /// The cutter.
    pub tool: Tool,
    /// One line for people.
    pub reason: Option<String>,
}

/// The cutter for `setup`: by number, else from its tools, else from `library`.
///
/// # Errors
/// When the number is none of the setup's or the library's, or no cutter fits between the blades.
pub fn choose_tool(
    part: &Impeller,
    channel: &Channel,
    setup: &Setup,
    library: &[Tool],
) -> Result<ChosenTool, SetupFault> {
    if let Some(number) = setup.flank.tool {
        let tool = match library.iter().find(|t| t.number == number && setup.tools.is_empty()) {
            Some(tool) => tool,
            None => tool_of(setup, number).map_err(|fault| fault.at(SetupPlace::Flank("tool")))?,
        };
        return Ok(ChosenTool { tool: tool.clone(), reason: None });
    }
    let tools = if setup.tools.is_empty() { library } else { &setup.tools };
    let width = narrowest(part, channel);
    let depth = deepest(part);
    let room = |t: &Tool| width - 2.0 * (t.radius() + setup.stock.blade_allowance);
    let easy = |t: &Tool| t.diameter <= THICKEST * width && room(t) >= 0.0;
    let thickest =
        |fits: &dyn Fn(&&Tool) -> bool| tools.iter().filter(fits).map(|t| t.diameter).max_by(f64::total_cmp);
    let diameter = thickest(&|t| easy(t)).or_else(|| thickest(&|t| room(t) >= 0.0));
    let Some(diameter) = diameter else {
        let least = tools.iter().map(|t| t.diameter).fold(f64::INFINITY, f64::min);
        return Err(SetupFault::new(
            format!(
                "no cutter fits between the blades: the narrowest place is {width:.2} mm wide, the thinnest cutter D {least}"
            ),
            format!(
                "give a cutter below D {:.2} or a smaller blade allowance",
                width - 2.0 * setup.stock.blade_allowance
            ),
        ));
    };
    // Of several lengths the shortest that reaches the hub with the holder outside, else the longest.
    let wanted = OVERHANG_MARGIN * depth;
    let same = || tools.iter().filter(|t| t.diameter == diameter);
    let tool = same()
        .filter(|t| t.overhang >= wanted)
        .min_by(|a, b| a.overhang.total_cmp(&b.overhang))
        .or_else(|| same().max_by(|a, b| a.overhang.total_cmp(&b.overhang)));
    let Some(tool) = tool else {
        return Err(SetupFault::new("there is no tool to choose from", "give a [[tool]]"));
    };
    let reason = format!(
        "D {} is the thickest cutter {} the narrowest passage, {width:.1} mm; overhang {} for a depth of {depth:.1} mm",
        tool.diameter,
        if easy(tool) { "within half of" } else { "that fits" },
        tool.overhang
    );
    Ok(ChosenTool { tool: tool.clone(), reason: Some(reason) })
}

/// Least distance between the walls of the channel, beside the splitter where there is one, mm.
fn narrowest(part: &Impeller, channel: &Channel) -> f64 {
    let along = |passage: &Passage, from: f64, to: f64| {
        let width = PassageWidth::new(part, passage);
        (0..=STATIONS)
            .map(|i| width.narrowest(from + (to - from) * i as f64 / STATIONS as f64))
            .fold(f64::INFINITY, f64::min)
    };
    let [hub, shroud] = channel.splitter_s.unwrap_or([1.0, 1.0]);
    let nose = hub.min(shroud).clamp(0.0, 1.0);
    let beside = hub.max(shroud).clamp(0.0, 1.0);
    channel
        .beside_splitter
        .iter()
        .map(|passage| along(passage, beside, 1.0))
        .fold(along(&channel.full, 0.0, nose), f64::min)
}

/// Greatest height of the channel above the hub, mm.
fn deepest(part: &Impeller) -> f64 {
    let at = |i: i32| {
        let s = f64::from(i) / 40.0;
        part.hub.curve().project(part.shroud.point(s)).1.max(part.hub.point(s).distance(part.shroud.point(s)))
    };
    (0..=40).map(at).fold(0.0, f64::max)
}
