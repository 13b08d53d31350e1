//! Output of the commands: JSON objects for programs, and tables for users.

use serde_json::{Map, Value, json};

use crate::job::{PolicyResult, Summary};
use crate::machine::MachineTool;
use crate::part::Impeller;
use crate::plunge::{Breach, DropReason, LimitedBy, PlungePlan, Position, SectionPlan, StopReason};
use crate::setup::cutting_data::CuttingData;
use crate::setup::{CutDirection, SectionKind, Setup, Tool};
use crate::stock::{CornerLimit, FloorGrid, InaccessibleFloor};
use crate::verify::{AssemblyDistances, Fault, PlungeReport};

/// Share of the floor from which on a cause of inaccessible floor has a line of its own.
const MIN_PRINTED_SHARE: f64 = 5e-4;

/// Travel of both rotary axes (rad) by their letters, in degrees.
pub fn rotary_travel(machine: &MachineTool, travel_rad: [f64; 2]) -> Value {
    let axes = machine.rotary.iter().zip(travel_rad);
    axes.map(|(axis, travel)| (axis.letter.to_string(), number(travel.to_degrees())))
        .collect::<Map<_, _>>()
        .into()
}

/// A number, or null if it is not finite. An empty sum is −0; adding 0 makes it 0.
pub fn number(x: f64) -> Value {
    if x.is_finite() { json!(x + 0.0) } else { Value::Null }
}

/// The keys of contact and residual stock.
fn residual_keys(s: &Summary) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("interferential".into(), json!(s.interfering));
    map.insert("max_contact_depth".into(), number(s.max_contact_depth));
    map.insert("residual_mean".into(), number(s.residual_mean));
    map.insert("residual_p95".into(), number(s.residual_p95));
    map.insert("residual_max".into(), number(s.residual_max));
    map.insert("uncut_share".into(), number(s.uncut_share));
    map.insert("unreachable_share".into(), number(s.inaccessible_share));
    map
}

/// Keys that every object of `--json` has, null where they do not apply.
const SHARED_KEYS: [&str; 29] = [
    "channels",
    "positions",
    "rows",
    "sections",
    "interferential",
    "max_contact_depth",
    "residual_mean",
    "residual_p95",
    "residual_max",
    "uncut_share",
    "unreachable_share",
    "min_hub_clearance",
    "min_blade_clearance",
    "min_retract_clearance",
    "shank_clearance_min",
    "holder_clearance_min",
    "max_axis_change",
    "cut_length",
    "rapid_length",
    "time_estimate",
    "feed_time",
    "blocked",
    "held",
    "settled",
    "stopped",
    "rounds",
    "elapsed",
    "max_overcut",
    "max_undercut",
];

/// "12 blades and as many splitters".
pub fn blades_text(part: &Impeller) -> String {
    let blades = part.blade_count;
    match part.splitters.len() {
        0 => format!("{blades} blades"),
        1 => format!("{blades} blades and as many splitters"),
        several => format!("{blades} blades and {} splitters", several * blades),
    }
}

/// The first keys of every object: the part, and the number of `channels` cut, if any.
pub fn head(part: &Impeller, channels: Option<usize>) -> Map<String, Value> {
    let mut map: Map<String, Value> =
        SHARED_KEYS.iter().map(|key| ((*key).to_owned(), Value::Null)).collect();
    map.insert("by_section".into(), json!([]));
    map.insert("part".into(), json!(part.name));
    map.insert("blades".into(), json!(part.blade_count));
    map.insert("splitters".into(), json!(part.splitters.len() * part.blade_count));
    if let Some(channels) = channels {
        map.insert("channels".into(), json!(channels));
    }
    map
}

/// Figures of a plan or program, and of each of its sections.
#[derive(Clone, Debug)]
pub struct PlungeFigures<'a> {
    /// The plan; `None` for a program, of whose planning nothing is known.
    pub plan: Option<&'a PlungePlan>,
    /// Figures of the whole.
    pub summary: Summary,
    /// The sections that are cut.
    pub sections: Vec<SectionFigures<'a>>,
    /// Number of rows in all channels.
    pub rows: usize,
}

/// Figures of a section.
#[derive(Clone, Debug)]
pub struct SectionFigures<'a> {
    /// Its index among all sections of the plan or program.
    pub index: usize,
    /// Its figures.
    pub summary: Summary,
    /// The section.
    pub section: &'a SectionPlan,
}

impl<'a> PlungeFigures<'a> {
    /// Figures of a plan of one channel.
    pub fn of_result(result: &'a PolicyResult, grid: &FloorGrid) -> Self {
        let PolicyResult { plan, field, .. } = result;
        let figures = |(index, section): (usize, &'a SectionPlan)| {
            let summary = Summary::of_section(plan, grid, field, index);
            SectionFigures { index, summary, section }
        };
        Self {
            plan: Some(plan),
            summary: result.summary.clone(),
            sections: plan.sections.iter().enumerate().filter(|(_, s)| s.is_cut()).map(figures).collect(),
            rows: plan.sections.iter().map(|section| section.rows).sum(),
        }
    }

    /// Figures of a verified program.
    pub fn of_program(report: &'a PlungeReport) -> Self {
        let figures = |(index, (section, summary)): (usize, (&'a SectionPlan, &Summary))| SectionFigures {
            index,
            summary: summary.clone(),
            section,
        };
        let sections = report.verdict.sections.iter().zip(&report.sections).enumerate();
        Self {
            plan: None,
            summary: report.summary.clone(),
            sections: sections.filter(|(_, (s, _))| s.is_cut()).map(figures).collect(),
            rows: report.verdict.rows(),
        }
    }

    /// A value that only a plan has; null for a program.
    fn if_planned(&self, value: impl FnOnce(&PlungePlan) -> Value) -> Value {
        self.plan.map_or(Value::Null, value)
    }
}

/// The JSON object of a plan or program; `reasons` say why each section was chosen.
pub fn plan_object(
    part: &Impeller,
    channels: usize,
    figures: &PlungeFigures,
    reasons: &[Option<String>],
) -> Map<String, Value> {
    let s = &figures.summary;
    let mut map = head(part, Some(channels));
    map.insert("positions".into(), json!(s.positions));
    map.insert("rows".into(), json!(figures.rows));
    map.insert("sections".into(), json!(figures.sections.len()));
    map.append(&mut residual_keys(s));
    map.insert("min_hub_clearance".into(), number(s.min_hub_clearance));
    map.insert("min_blade_clearance".into(), number(s.min_blade_clearance));
    map.insert("min_retract_clearance".into(), number(s.min_retract_clearance));
    map.insert("max_axis_change".into(), number(s.max_axis_change_rad.to_degrees()));
    map.insert("cut_length".into(), number(s.cut_length));
    map.insert("rapid_length".into(), number(s.rapid_length));
    map.insert("time_estimate".into(), number(s.time_estimate));
    map.insert("feed_time".into(), number(s.feed_time));
    map.insert("tool_loads".into(), json!(s.tool_loads));
    map.append(&mut machine_time_key(s));
    map.insert("blocked".into(), json!(s.blocked));
    map.insert("held".into(), figures.if_planned(|plan| limited_object(&limited_counts(plan, None))));
    map.insert("settled".into(), figures.if_planned(|plan| json!(plan.converged)));
    let stopped = |plan: &PlungePlan| json!(plan.is_unfinished().then(|| StopReason::Cancelled.name()));
    map.insert("stopped".into(), figures.if_planned(stopped));
    map.insert("rounds".into(), figures.if_planned(|plan| json!(plan.iterations)));
    map.insert("by_section".into(), by_section(figures, reasons));
    map
}

/// Contact and residual keys of a plan with its sections, for the keys `before` and `policies`.
pub fn comparison_object(figures: &PlungeFigures, reasons: &[Option<String>]) -> Value {
    let mut map = residual_keys(&figures.summary);
    map.insert("positions".into(), json!(figures.summary.positions));
    map.insert("blocked".into(), json!(figures.summary.blocked));
    map.insert("time_estimate".into(), number(figures.summary.time_estimate));
    map.append(&mut machine_time_key(&figures.summary));
    map.insert("by_section".into(), by_section(figures, reasons));
    Value::Object(map)
}

/// The time of a plan on its machine, where it is known.
fn machine_time_key(s: &Summary) -> Map<String, Value> {
    s.machine_time.map(|time| ("machine_time".to_owned(), number(time.total_s))).into_iter().collect()
}

fn by_section(figures: &PlungeFigures, reasons: &[Option<String>]) -> Value {
    let object = |&SectionFigures { index, summary: ref s, section }: &SectionFigures| {
        let mut map = Map::new();
        map.insert("tool".into(), json!(section.tool.number));
        map.insert("diameter".into(), number(section.tool.diameter));
        map.insert("from".into(), number(section.from));
        map.insert("to".into(), number(section.to));
        map.insert("feed".into(), json!(feed_word(section.feed)));
        map.insert("rest".into(), json!(section.kind == SectionKind::Rest));
        if section.kind == SectionKind::Opening {
            map.insert("opening".into(), json!(true));
        }
        map.insert("positions".into(), json!(s.positions));
        map.append(&mut residual_keys(s));
        map.insert("blocked".into(), json!(s.blocked));
        let held = |plan: &PlungePlan| limited_object(&limited_counts(plan, Some(index)));
        map.insert("held".into(), figures.if_planned(held));
        let left_out =
            |plan: &PlungePlan| LeftOut::of_section(plan, index).iter().map(LeftOut::json).collect();
        map.insert("left_out".into(), figures.if_planned(left_out));
        map.insert("added".into(), json!(section.added.map(|added| added.count)));
        map.insert("stopped".into(), json!(section.added.map(|added| added.stopped.name())));
        map.insert("reason".into(), json!(reasons.get(index).cloned().flatten()));
        Value::Object(map)
    };
    Value::Array(figures.sections.iter().map(object).collect())
}

/// The list `faults` of `--json`; `what` is the older name of `message`, kept for compatibility.
pub fn fault_list(faults: &[Fault]) -> Value {
    let one = |f: &Fault| {
        let value = f.value.map_or(Value::Null, number);
        // The help is part of the message, as it has been from the first version on.
        let message = f.to_string();
        json!({"line": f.line, "kind": f.kind, "value": value, "message": message, "what": message})
    };
    Value::Array(faults.iter().map(one).collect())
}

fn feed_word(feed: CutDirection) -> &'static str {
    match feed {
        CutDirection::OutletToInlet => "inward",
        CutDirection::InletToOutlet => "outward",
    }
}

/// The keys of the least distances of shank and holder; null without them.
pub fn assembly_keys(least: &AssemblyDistances) -> [(String, Value); 2] {
    [("shank_clearance_min", least.shank), ("holder_clearance_min", least.holder)]
        .map(|(key, value)| (key.to_owned(), number(value)))
}

/// Text on the least distances of shank and holder; empty without them.
pub fn assembly_text(least: &AssemblyDistances) -> String {
    let near = [("shank", least.shank), ("holder", least.holder)];
    let near: Vec<String> =
        near.iter().filter(|(_, d)| d.is_finite()).map(|(name, d)| format!("{name} {d:.2} mm")).collect();
    if near.is_empty() { String::new() } else { format!("least distance to the part: {}\n", near.join(", ")) }
}

/// Table of plans under their names, section by section.
pub fn table<'a>(rows: impl Iterator<Item = (&'a str, PlungeFigures<'a>)>) -> String {
    let mut text = String::from(
        "policy        section         tool    positions  interf.  contact mm  hub stock mean/95 % mm  \
         uncut %  inaccessible %  blocked\n",
    );
    for (name, figures) in rows {
        let whole = (String::from("all"), String::new(), &figures.summary);
        let parts = figures.sections.iter().map(|SectionFigures { section, summary, .. }| {
            let SectionPlan { from, to, tool, .. } = section;
            (format!("{from:.2} to {to:.2}"), format!("D {}", tool.diameter), summary)
        });
        for (section, tool, s) in parts.chain([whole]) {
            let blocked = s.blocked.map_or_else(|| "-".to_owned(), |count| count.to_string());
            text += &format!(
                "{name:<13} {section:<15} {tool:<7} {:>9}  {:>7}  {:>10.2}  {:>11.2} / {:<9.2}  \
                 {:>7.1}  {:>14.1}  {blocked:>7}\n",
                s.positions,
                s.interfering,
                s.max_contact_depth,
                s.residual_mean,
                s.residual_p95,
                100.0 * s.uncut_share,
                100.0 * s.inaccessible_share,
            );
        }
    }
    text
}

/// What the column `interf.` of [`table`] leaves out: plunges of a plan that interfere since they exceed an
/// allowance or the reach of the machine. Empty without any.
pub fn breach_text(plan: &PlungePlan) -> String {
    let breaches = Breach::ALL.map(|kind| {
        (plan.positions.iter().filter(|p| p.evaluation.breach == Some(kind)).count(), kind.words())
    });
    let lines: String = breaches
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, words)| format!(", {count} {words}"))
        .collect();
    if lines.is_empty() {
        return String::new();
    }
    let contact = plan.positions.iter().filter(|p| p.evaluation.contact.interferes()).count();
    let (policy, count) = (plan.policy.name(), plan.count_interfering());
    let words = if count == 1 { "plunge interferes" } else { "plunges interfere" };
    format!("{policy}: {count} {words}: {contact} with the core in stock{lines}\n")
}

/// Inaccessible floor by its causes, for `--json`.
pub fn inaccessible_list(parts: &[InaccessibleFloor]) -> Value {
    let object = |part: &InaccessibleFloor| {
        json!({
            "wall": part.obstacle.name(),
            "limit": part.limit.map(CornerLimit::name),
            "tool": part.tool,
            "diameter": number(part.diameter),
            "from": number(part.from),
            "to": number(part.to),
            "share": number(part.share),
        })
    };
    parts.iter().map(object).collect()
}

/// Text on what makes floor inaccessible; empty without such floor.
pub fn inaccessible_text(parts: &[InaccessibleFloor]) -> String {
    let line = |part: &InaccessibleFloor| {
        let InaccessibleFloor { obstacle, limit, tool, diameter, from, to, share } = part;
        let (share, words) = (100.0 * share, obstacle.words());
        let limit = limit.map_or_else(String::new, |limit| format!(", {}", limit.words()));
        format!(
            "inaccessible to tool {tool} (D {diameter}): {share:.1} % {words}{limit}, s = {from:.2} to {to:.2}\n"
        )
    };
    parts.iter().filter(|part| part.share >= MIN_PRINTED_SHARE).map(line).collect()
}

/// Number of positions of a plan (or of one section) whose axis is limited, per cause; see [`LimitedBy`].
fn limited_counts(plan: &PlungePlan, section: Option<usize>) -> [(LimitedBy, usize); 4] {
    LimitedBy::ALL.map(|held| {
        let ours = |p: &&Position| p.limited_by == Some(held) && section.is_none_or(|s| p.section == s);
        (held, plan.positions.iter().filter(ours).count())
    })
}

fn limited_object(counts: &[(LimitedBy, usize)]) -> Value {
    Value::Object(counts.iter().map(|(held, count)| (held.name().to_owned(), json!(count))).collect())
}

/// Text on the positions with a limited axis and on those lifted to keep the core free, or by hand where the
/// plan is `edited`; empty if there are none.
pub fn limited_text(plan: &PlungePlan, edited: bool) -> String {
    let counts = limited_counts(plan, None);
    let lifted = plan.positions.iter().filter(|p| p.lift > 0.02).count();
    let mut text = String::new();
    let limited = counts.iter().filter(|(_, count)| *count > 0);
    let words: Vec<String> =
        limited.map(|(held, count)| format!("{count} limited by {}", held.words())).collect();
    if !words.is_empty() {
        text += &format!("positions not at the axis that leaves least: {}\n", words.join(", "));
    }
    if lifted > 0 {
        let most = plan.positions.iter().map(|p| p.lift).fold(0.0, f64::max);
        let why = if edited { "to keep the core free or by hand" } else { "to keep the core free" };
        text += &format!("stopped short {why}: {lifted} positions, by up to {most:.2} mm\n");
    }
    text
}

/// Text on why each section was chosen, for sections not given by the setup.
pub fn reasons_text(plan: &PlungePlan, reasons: &[Option<String>]) -> String {
    let mut text = String::new();
    for (section, reason) in plan.sections.iter().zip(reasons).filter(|(section, _)| section.is_cut()) {
        let Some(reason) = reason else { continue };
        let tool = &section.tool;
        text += &format!(
            "{:.2} to {:.2}, tool {} (D {}): {reason}\n",
            section.from, section.to, tool.number, tool.diameter
        );
    }
    text
}

/// What was added to the rows of each section, and why no more.
pub fn added_text(plan: &PlungePlan) -> String {
    let mut text = String::new();
    for (index, section) in plan.sections.iter().enumerate() {
        if let Some(added) = section.added_words() {
            let (from, to) = (section.from, section.to);
            let what = plan.idle_words(index).map_or(added, |why| format!("no plunges, {why}"));
            text += &format!("{from:.2} to {to:.2}, D {}: {what}\n", section.tool.diameter);
        }
    }
    text
}

/// Lines where the material of `setup` has no cutting data, and of what must be known of the `tools` of a
/// program; empty otherwise.
pub fn tools_text<'t>(setup: &Setup, tools: impl IntoIterator<Item = &'t Tool>) -> String {
    let mut text = notes_text(&setup.allowances.tool_remarks(tools));
    if let Some(name) = &setup.allowances.material
        && setup.allowances.cutting_data().is_none()
    {
        text += &format!(
            "no cutting data for `{name}`: speeds and feed rates stay those of the tools; known: {}\n",
            CuttingData::known_names().collect::<Vec<_>>().join(", ")
        );
    }
    text
}

/// Notes, one per line.
pub fn notes_text(notes: &[String]) -> String {
    notes.iter().map(|note| format!("{note}\n")).collect()
}

/// Text on the convergence of the planning loop.
pub fn convergence_text(plan: &PlungePlan) -> String {
    format!(
        "{} {}, {}\n",
        plan.iterations,
        if plan.iterations == 1 { "iteration" } else { "iterations" },
        if plan.converged { "converged" } else { "NOT converged" }
    )
}

/// Positions of a section that were left out for one reason.
struct LeftOut {
    why: DropReason,
    count: usize,
    /// The least overhang with which they could be cut, mm; `None` where a longer one frees none.
    overhang: Option<f64>,
    /// How many no overhang frees.
    never: usize,
}

impl LeftOut {
    /// Those of a section, by reason.
    fn of_section(plan: &PlungePlan, section: usize) -> Vec<Self> {
        let of = |why: DropReason| {
            let ours = || plan.dropped.iter().filter(move |d| (d.section, d.why) == (section, why));
            let overhang = ours().filter_map(|d| d.stick_out).reduce(f64::max);
            Self {
                why,
                count: ours().count(),
                overhang,
                never: ours().filter(|d| d.stick_out.is_none()).count(),
            }
        };
        DropReason::ALL.map(of).into_iter().filter(|left_out| left_out.count > 0).collect()
    }

    fn text(&self, section: usize, tool: u32) -> String {
        let overhang = match (self.overhang, self.never) {
            (None, _) => String::new(),
            (Some(most), 0) => format!("; an overhang of {most} mm would do"),
            (Some(most), never) => {
                format!("; an overhang of {most} mm would do, except for {never} that none frees")
            }
        };
        let Self { count, why, .. } = self;
        format!("left out of section {section}, tool {tool}: {count} positions {}{overhang}\n", why.words())
    }

    fn json(&self) -> Value {
        json!({"why": self.why.name(), "positions": self.count, "overhang": self.overhang, "never": self.never})
    }
}

/// Text that lists the blocked positions of each section and counts those left out.
pub fn blocked_text(plan: &PlungePlan) -> String {
    let mut text = String::new();
    for (index, section) in plan.sections.iter().enumerate() {
        let ours = plan.positions.iter().enumerate().filter(|(_, p)| p.section == index);
        let names: Vec<String> = ours
            .filter_map(|(k, p)| {
                let why = match p.blocked? {
                    crate::plunge::Blocked::Walls => "walls",
                    crate::plunge::Blocked::ShroudEnd => "end of the shroud",
                    crate::plunge::Blocked::TiltLimit => "tilt limit",
                };
                Some(format!("{} ({why})", k + 1))
            })
            .collect();
        if !names.is_empty() {
            text += &format!("blocked with tool {}: position {}\n", section.tool.number, names.join(", "));
        }
        let left_out = LeftOut::of_section(plan, index);
        text.extend(left_out.iter().map(|left_out| left_out.text(index + 1, section.tool.number)));
    }
    text
}
