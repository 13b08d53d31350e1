//! Which cutter works where: sections given by the setup, or a sensible choice.

use crate::part::setup::{Feed, SectionSetup};
use crate::part::{Channel, Impeller, Setup, SideProbe, Tool};

/// Why a setup does not go with a part.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what}; {cure}")]
pub struct SetupFault {
    /// What is wrong.
    pub what: String,
    /// What to do about it.
    pub cure: String,
}

impl SetupFault {
    /// A fault with its cure.
    pub fn new(what: impl Into<String>, cure: impl Into<String>) -> Self {
        Self { what: what.into(), cure: cure.into() }
    }
}

/// Diameters of the standard cutters, mm.
const STANDARD_DIAMETERS: [f64; 25] = [
    0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0,
    25.0, 30.0, 40.0, 50.0, 63.0,
];
/// Stations of s at which the passage is measured.
const STATIONS: usize = 50;

/// Nearest distance between the walls of the narrowest passage at evenly spaced s from 0 to 1, mm.
pub fn passage_widths(part: &Impeller, channel: &Channel) -> Vec<f64> {
    let width_at = |passage: &crate::part::Passage, probe: &SideProbe, s: f64| {
        (0..=4)
            .filter_map(|j| {
                let eta = f64::from(j) / 4.0;
                let wall = passage.walls[0].at(part, s, eta)?;
                Some(probe.nearest_to_point(&part.meridional(s, eta).at_angle(wall.theta)).distance)
            })
            .fold(f64::INFINITY, f64::min)
    };
    let probe = |p: &crate::part::Passage| SideProbe::new(p.walls[1].side(), 0.0, 1.0);
    let full = probe(&channel.full);
    let beside: Vec<_> = channel.beside_splitter.iter().map(|p| (p, probe(p))).collect();
    (0..=STATIONS)
        .map(|i| {
            let s = i as f64 / STATIONS as f64;
            match channel.splitter_s {
                Some([hub, shroud]) if s >= hub.min(shroud) => {
                    beside.iter().map(|(p, probe)| width_at(p, probe, s)).fold(f64::INFINITY, f64::min)
                }
                _ => width_at(&channel.full, &full, s),
            }
        })
        .collect()
}

/// The setup with tools and sections filled in where it gives none.
pub fn resolve(setup: &Setup, part: &Impeller, channel: &Channel) -> Result<Setup, SetupFault> {
    if let Some(name) = &setup.part
        && name != &part.name
    {
        return Err(SetupFault::new(
            format!("the setup is for part \"{name}\", not for \"{}\"", part.name),
            "give the setup of this part, or change its `part` key",
        ));
    }
    let widths = passage_widths(part, channel);
    let mut resolved = setup.clone();
    if resolved.tools.is_empty() {
        resolved.tools = standard_tools(&widths, setup, part);
    }
    if resolved.plunge.sections.is_empty() {
        resolved.plunge.sections =
            sections_for(&resolved.tools, &widths, channel, setup.stock.blade_allowance);
    }
    for section in &resolved.plunge.sections {
        let tool = tool_of(&resolved, section.tool)?;
        check_fit(tool, section, &widths, setup.stock.blade_allowance)?;
    }
    Ok(resolved)
}

/// Tool number `number` of the setup.
pub fn tool_of(setup: &Setup, number: u32) -> Result<&Tool, SetupFault> {
    setup.tools.iter().find(|t| t.number == number).ok_or_else(|| {
        SetupFault::new(
            format!("a section asks for tool {number}, which the setup does not have"),
            "add the tool or name another",
        )
    })
}

fn check_fit(tool: &Tool, section: &SectionSetup, widths: &[f64], allowance: f64) -> Result<(), SetupFault> {
    let mut narrow: Option<(f64, f64)> = None;
    for (i, &width) in widths.iter().enumerate() {
        let s = i as f64 / STATIONS as f64;
        if s >= section.to - 1e-9
            && s <= section.from + 1e-9
            && width < tool.diameter + 2.0 * allowance
            && narrow.is_none_or(|(w, _)| width < w)
        {
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
