//! Which cutter works where: sections given by the setup, or a sensible choice.

use crate::part::setup::{Feed, PlungeSetup, SectionSetup};
use crate::part::{Channel, Impeller, PassageWidth, Setup, Tool};

/// What of a setup a fault is about, so that whoever has its file can tell the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupPlace {
    /// Nothing in particular.
    Whole,
    /// The key `part`.
    Part,
    /// A key of `[stock]`.
    Stock(&'static str),
    /// A key of `[plunge]`.
    Plunge(&'static str),
    /// The tool of this number.
    Tool(u32),
    /// A section by its index; its tool where the setup leaves the sections to us.
    Section {
        /// Index in the list of sections.
        index: usize,
        /// Number of its tool.
        tool: u32,
    },
}

/// Why a setup does not go with a part.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what}; {cure}")]
pub struct SetupFault {
    /// What is wrong.
    pub what: String,
    /// What to do about it.
    pub cure: String,
    /// What of the setup it is about.
    pub place: SetupPlace,
}

impl SetupFault {
    /// A fault of the setup as a whole, with its cure.
    pub fn new(what: impl Into<String>, cure: impl Into<String>) -> Self {
        Self { what: what.into(), cure: cure.into(), place: SetupPlace::Whole }
    }

    /// The fault at `place`.
    pub fn at(self, place: SetupPlace) -> Self {
        Self { place, ..self }
    }
}

/// Most positions a plan of one channel may have: ten times what the smallest cutters for a wheel need.
pub const MAX_POSITIONS: usize = 20_000;

/// Diameters of the standard cutters, mm.
const STANDARD_DIAMETERS: [f64; 25] = [
    0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0,
    25.0, 30.0, 40.0, 50.0, 63.0,
];
/// Stations of s at which the passage is measured.
const STATIONS: usize = 50;

/// Nearest distance between the walls of the narrowest passage at evenly spaced s from 0 to 1, mm.
pub fn passage_widths(part: &Impeller, channel: &Channel) -> Vec<f64> {
    let full = PassageWidth::new(part, &channel.full);
    let beside: Vec<_> = channel.beside_splitter.iter().map(|p| PassageWidth::new(part, p)).collect();
    (0..=STATIONS)
        .map(|i| {
            let s = i as f64 / STATIONS as f64;
            match channel.splitter_s {
                Some([hub, shroud]) if s >= hub.min(shroud) => {
                    beside.iter().map(|p| p.narrowest(s)).fold(f64::INFINITY, f64::min)
                }
                _ => full.narrowest(s),
            }
        })
        .collect()
}

/// The setup with tools and sections filled in where it gives none.
pub fn resolve(setup: &Setup, part: &Impeller, channel: &Channel) -> Result<Setup, SetupFault> {
    check_part(setup, part)?;
    check_hub_allowance(setup, part)?;
    let widths = passage_widths(part, channel);
    let mut resolved = setup.clone();
    if resolved.tools.is_empty() {
        check_blade_allowance(setup, &widths)?;
        resolved.tools = standard_tools(&widths, setup, part);
    }
    if resolved.plunge.sections.is_empty() {
        resolved.plunge.sections =
            sections_for(&resolved.tools, &widths, channel, setup.stock.blade_allowance);
    }
    for (index, section) in resolved.plunge.sections.iter().enumerate() {
        let place = SetupPlace::Section { index, tool: section.tool };
        let tool = tool_of(&resolved, section.tool).map_err(|fault| fault.at(place))?;
        check_fit(tool, section, &widths, setup.stock.blade_allowance).map_err(|fault| fault.at(place))?;
    }
    check_size(&resolved, part, &widths)?;
    Ok(resolved)
}

/// Refuses a setup that names another part.
pub fn check_part(setup: &Setup, part: &Impeller) -> Result<(), SetupFault> {
    match &setup.part {
        Some(name) if *name != part.name => Err(SetupFault::new(
            format!("the setup is for part \"{name}\", not for \"{}\"", part.name),
            "give the setup of this part, or change its `part` key",
        )
        .at(SetupPlace::Part)),
        _ => Ok(()),
    }
}

fn check_hub_allowance(setup: &Setup, part: &Impeller) -> Result<(), SetupFault> {
    let height_at = |s: f64| part.hub.point(s).distance(part.shroud.point(s));
    let height = (0..=STATIONS).map(|i| height_at(i as f64 / STATIONS as f64)).fold(f64::INFINITY, f64::min);
    if setup.stock.hub_allowance < 0.9 * height {
        return Ok(());
    }
    Err(SetupFault::new(
        format!(
            "`hub_allowance` is {}, but hub and shroud come within {height:.2} mm",
            setup.stock.hub_allowance
        ),
        format!("give less than {:.2} mm", 0.9 * height),
    )
    .at(SetupPlace::Stock("hub_allowance")))
}

/// Whether there is a cutter to choose at all.
fn check_blade_allowance(setup: &Setup, widths: &[f64]) -> Result<(), SetupFault> {
    let narrowest = widths.iter().copied().fold(f64::INFINITY, f64::min);
    let most = 0.5 * (narrowest - 1.25 * STANDARD_DIAMETERS[0]);
    if setup.stock.blade_allowance <= most {
        return Ok(());
    }
    Err(SetupFault::new(
        format!(
            "`blade_allowance` is {}, but the blades come within {narrowest:.2} mm of each other",
            setup.stock.blade_allowance
        ),
        format!("give at most {:.2} mm", most.max(0.0)),
    )
    .at(SetupPlace::Stock("blade_allowance")))
}

/// Upper limit of the step along a row, mm: the insert width, what the setup asks for, and at walls the scallop
/// S ≤ 2·√(2Rh − h²).
pub fn step_limit(plunge: &PlungeSetup, tool: &Tool, wall_row: bool) -> f64 {
    let radius = tool.radius();
    let mut limit = tool.insert_width.min(radius);
    limit = limit.min(plunge.step.unwrap_or(0.8 * tool.insert_width));
    if wall_row {
        let h = plunge.wall_scallop.min(radius);
        limit = limit.min(2.0 * (2.0 * radius * h - h * h).sqrt());
    }
    limit
}

/// Upper limit of the spacing of rows, mm.
pub fn row_spacing(plunge: &PlungeSetup, tool: &Tool) -> f64 {
    plunge.row_spacing.unwrap_or(4.0 / 3.0 * tool.radius())
}

/// Refuses a setup whose plan would have more than [`MAX_POSITIONS`] positions, by a low estimate.
fn check_size(setup: &Setup, part: &Impeller, widths: &[f64]) -> Result<(), SetupFault> {
    let plunge = &setup.plunge;
    let mut total = 0.0;
    for (index, section) in plunge.sections.iter().enumerate() {
        let tool = tool_of(setup, section.tool)?;
        let length = (section.from - section.to) * part.hub.length().max(part.shroud.length());
        let width = widths_in(section, widths).map(|(_, w)| w).fold(0.0, f64::max);
        let room = (width - tool.diameter - 2.0 * setup.stock.blade_allowance).max(0.0);
        let inner =
            (room / row_spacing(plunge, tool) - 1.0).max(0.0) * length / step_limit(plunge, tool, false);
        let walls = 2.0 * length / step_limit(plunge, tool, true);
        total += inner + walls;
        if total > MAX_POSITIONS as f64 {
            let place = SetupPlace::Section { index, tool: section.tool };
            return Err(too_many(total, plunge, tool, place));
        }
    }
    Ok(())
}

/// The fault of a plan with about so many `positions`, where the setup is finest.
pub(super) fn too_many(positions: f64, plunge: &PlungeSetup, tool: &Tool, place: SetupPlace) -> SetupFault {
    let step = 0.8 * tool.insert_width;
    let asked = [
        (plunge.step, step, "step"),
        (plunge.row_spacing, 4.0 / 3.0 * tool.radius(), "row_spacing"),
        (Some(step_limit(plunge, tool, true)), step_limit(plunge, tool, false), "wall_scallop"),
    ];
    let finest = asked
        .into_iter()
        .filter_map(|(value, usual, key)| Some((value? / usual, key)))
        .filter(|(share, _)| *share < 0.4)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let (cure, place) = match finest {
        Some((_, key)) => (format!("give a greater `{key}`"), SetupPlace::Plunge(key)),
        None => (format!("use a larger cutter or wider inserts than those of tool {}", tool.number), place),
    };
    let count = if positions < 1e6 { format!("about {positions:.0}") } else { "over a million".to_owned() };
    let what = format!("the plan would have {count} positions; the limit is {MAX_POSITIONS}");
    SetupFault::new(what, cure).at(place)
}

/// Stations of a section with the width of the passage there.
fn widths_in<'w>(section: &SectionSetup, widths: &'w [f64]) -> impl Iterator<Item = (f64, f64)> + use<'w> {
    let (from, to) = (section.from, section.to);
    // A section between two stations has the width of the nearer one.
    let at = |s: f64| (s * STATIONS as f64).round() / STATIONS as f64;
    let (high, low) = (from.max(at(from)), to.min(at(to)));
    widths
        .iter()
        .enumerate()
        .map(|(i, &width)| (i as f64 / STATIONS as f64, width))
        .filter(move |(s, _)| *s >= low - 1e-9 && *s <= high + 1e-9)
}

/// Tool number `number` of the setup.
pub fn tool_of(setup: &Setup, number: u32) -> Result<&Tool, SetupFault> {
    setup.tools.iter().find(|t| t.number == number).ok_or_else(|| {
        SetupFault::new(
            format!("a section asks for tool {number}, which the setup does not have"),
            "add the tool or name another",
        )
        .at(SetupPlace::Tool(number))
    })
}

fn check_fit(tool: &Tool, section: &SectionSetup, widths: &[f64], allowance: f64) -> Result<(), SetupFault> {
    let mut narrow: Option<(f64, f64)> = None;
    for (s, width) in widths_in(section, widths) {
        if width < tool.diameter + 2.0 * allowance && narrow.is_none_or(|(w, _)| width < w) {
            narrow = Some((width, s));
        }
    }
    match narrow {
        None => Ok(()),
        Some((width, s)) => {
            let room = width - 2.0 * allowance;
            let diameter = STANDARD_DIAMETERS.iter().rev().find(|&&d| d < room);
            let cure = match diameter {
                Some(d) => format!("use a cutter of at most D {d} there, or end the section before it"),
                None => "lower the blade allowance".to_string(),
            };
            Err(SetupFault::new(
                format!(
                    "tool {} (D {}) is wider than the channel: {width:.2} mm between the walls at s = {s:.2}, \
                     {room:.2} mm inside the allowances",
                    tool.number, tool.diameter
                ),
                cure,
            ))
        }
    }
}

/// Largest standard diameter up to `limit`.
fn standard_below(limit: f64) -> f64 {
    STANDARD_DIAMETERS.iter().copied().filter(|&d| d <= limit).fold(STANDARD_DIAMETERS[0], f64::max)
}

fn standard_tools(widths: &[f64], setup: &Setup, part: &Impeller) -> Vec<Tool> {
    let room = |w: f64| w - 2.0 * setup.stock.blade_allowance;
    let least = |from: usize| widths[from..].iter().copied().fold(f64::INFINITY, f64::min);
    // Room for three rows at the outlet, no cutter that bridges the hub's curve or that is much wider than the
    // outlet is deep; at the narrowest place there is often room for little more than one row.
    let outlet = part.hub.point(1.0).distance(part.shroud.point(1.0));
    let first = standard_below(
        (0.65 * room(least(7 * STATIONS / 10))).min(0.12 * part.rim_radius()).min(2.0 * outlet),
    );
    let last = standard_below(0.8 * room(least(0))).min(first);
    let ratio = first / last;
    let mut diameters = vec![first];
    if ratio > 2.0 {
        let between = (first * last).sqrt();
        let nearest = STANDARD_DIAMETERS
            .iter()
            .copied()
            .min_by(|a, b| (a / between).ln().abs().total_cmp(&(b / between).ln().abs()))
            .unwrap_or(last);
        diameters.push(nearest);
    }
    if ratio > 1.2 {
        diameters.push(last);
    }
    let depth = (0..=10)
        .map(|i| {
            let s = f64::from(i) / 10.0;
            part.hub.point(s).distance(part.shroud.point(s))
        })
        .fold(0.0, f64::max);
    diameters
        .iter()
        .zip(1..)
        .map(|(&diameter, number)| {
            let spindle = (110_000.0 / (std::f64::consts::PI * diameter)).min(20_000.0).round();
            Tool {
                number,
                diameter,
                corner_radius: 0.0,
                insert_width: (0.65 * diameter / 2.0 * 100.0).round() / 100.0,
                overhang: (1.3 * depth).max(4.0 * diameter).ceil(),
                plunge_feed: (spindle * 0.2).round().clamp(50.0, 600.0),
                spindle,
            }
        })
        .collect()
}

/// Each cutter, largest first, as far inwards as it fits with a little room to tilt; the smallest to
/// the leading edge. Where passages join in front of a splitter a new section begins.
fn sections_for(tools: &[Tool], widths: &[f64], channel: &Channel, allowance: f64) -> Vec<SectionSetup> {
    let mut order: Vec<&Tool> = tools.iter().collect();
    order.sort_by(|a, b| b.diameter.total_cmp(&a.diameter));
    let mut sections: Vec<SectionSetup> = Vec::new();
    let mut from = 1.0;
    for (k, tool) in order.iter().enumerate() {
        let wanted = 1.12 * tool.diameter + 2.0 * allowance;
        let mut to = 1.0;
        for i in (0..=STATIONS).rev() {
            if widths[i] < wanted {
                break;
            }
            to = i as f64 / STATIONS as f64;
        }
        if k + 1 == order.len() {
            to = 0.0;
        }
        if to < from - 0.04 {
            let joint = channel.splitter_s.map(|[hub, shroud]| hub.max(shroud));
            if let Some(joint) = joint.filter(|j| (to + 0.04..from - 0.04).contains(j)) {
                sections.push(SectionSetup { tool: tool.number, from, to: joint, feed: Some(Feed::Inward) });
                from = joint;
            }
            sections.push(SectionSetup { tool: tool.number, from, to, feed: Some(Feed::Inward) });
            from = to;
        }
    }
    sections
}
