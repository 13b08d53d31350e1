//! What commands print: the JSON object that other programs rely on, and tables for people.

use serde_json::{Map, Value, json};

use crate::job::{PolicyResult, Summary};
use crate::part::{Feed, Impeller};
use crate::plunge::{Held, NoPlace, PlungePlan, Position, SectionPlan, Stopped};
use crate::residual::FloorGrid;

/// A number, or null where there is none.
pub fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { Value::Null }
}

/// The keys of contact and residual layer.
fn decisive(s: &Summary) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("interferential".into(), json!(s.interferential));
    map.insert("max_contact_depth".into(), number(s.max_contact_depth));
    map.insert("residual_mean".into(), number(s.residual_mean));
    map.insert("residual_p95".into(), number(s.residual_p95));
    map.insert("residual_max".into(), number(s.residual_max));
    map.insert("uncut_share".into(), number(s.uncut_share));
    map.insert("unreachable_share".into(), number(s.unreachable_share));
    map
}

/// The first keys of every object: the part, and how many of its `channels` are cut, where any is.
pub fn head(part: &Impeller, channels: Option<usize>) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("part".into(), json!(part.name));
    map.insert("blades".into(), json!(part.blade_count));
    map.insert("splitters".into(), json!(part.splitters.len() * part.blade_count));
    if let Some(channels) = channels {
        map.insert("channels".into(), json!(channels));
    }
    map
}

/// What every plan prints: the keys of CONTRACT that describe one plan. `reasons` say why each section was chosen.
pub fn plan_object(
    part: &Impeller,
    channels: usize,
    result: &PolicyResult,
    grid: &FloorGrid,
    reasons: &[Option<String>],
) -> Map<String, Value> {
    let (plan, s) = (&result.plan, &result.summary);
    let mut map = head(part, Some(channels));
    map.insert("positions".into(), json!(s.positions));
    map.insert("rows".into(), json!(plan.sections.iter().map(|s| s.rows).sum::<usize>()));
    map.insert("sections".into(), json!(plan.sections.iter().filter(|s| s.is_cut()).count()));
    map.append(&mut decisive(s));
    map.insert("min_hub_clearance".into(), number(s.min_hub_clearance));
    map.insert("min_blade_clearance".into(), number(s.min_blade_clearance));
    map.insert("min_retract_clearance".into(), number(s.min_retract_clearance));
    map.insert("max_axis_change".into(), number(s.max_axis_change.to_degrees()));
    map.insert("cut_length".into(), number(s.cut_length));
    map.insert("rapid_length".into(), number(s.rapid_length));
    map.insert("time_estimate".into(), number(s.time_estimate));
    map.insert("blocked".into(), json!(s.blocked));
    map.insert("held".into(), held_object(&held_back(plan, None)));
    map.insert("settled".into(), json!(plan.settled));
    map.insert("stopped".into(), json!(plan.is_unfinished().then(|| Stopped::Cancelled.name())));
    map.insert("rounds".into(), json!(plan.rounds));
    map.insert("by_section".into(), by_section(result, grid, reasons));
    map
}

/// Residual and contact keys of a plan, with its sections: for `before` and `policies`.
pub fn compared(result: &PolicyResult, grid: &FloorGrid, reasons: &[Option<String>]) -> Value {
    let mut map = decisive(&result.summary);
    map.insert("positions".into(), json!(result.summary.positions));
    map.insert("blocked".into(), json!(result.summary.blocked));
    map.insert("by_section".into(), by_section(result, grid, reasons));
    Value::Object(map)
}

fn by_section(result: &PolicyResult, grid: &FloorGrid, reasons: &[Option<String>]) -> Value {
    let sections = sections(result, grid)
        .map(|(index, section, s)| {
            let mut map = Map::new();
            map.insert("tool".into(), json!(section.tool.number));
            map.insert("diameter".into(), number(section.tool.diameter));
            map.insert("from".into(), number(section.from));
            map.insert("to".into(), number(section.to));
            map.insert("feed".into(), json!(feed_word(section.feed)));
            map.insert("rest".into(), json!(section.rest));
            map.insert("positions".into(), json!(s.positions));
            map.append(&mut decisive(&s));
            map.insert("blocked".into(), json!(s.blocked));
            map.insert("held".into(), held_object(&held_back(&result.plan, Some(index))));
            map.insert("added".into(), json!(section.added.map(|(count, _)| count)));
            map.insert("stopped".into(), json!(section.added.map(|(_, stopped)| stopped.name())));
            map.insert("reason".into(), json!(reasons.get(index).cloned().flatten()));
            Value::Object(map)
        })
        .collect();
    Value::Array(sections)
}

/// The sections of a plan's program, with their places in the plan and their figures.
fn sections<'r>(
    result: &'r PolicyResult,
    grid: &'r FloorGrid,
) -> impl Iterator<Item = (usize, &'r SectionPlan, Summary)> {
    let sections = result.plan.sections.iter().enumerate().filter(|(_, section)| section.is_cut());
    sections.map(|(i, section)| (i, section, Summary::of_section(&result.plan, grid, &result.field, i)))
}

fn feed_word(feed: Feed) -> &'static str {
    match feed {
        Feed::Inward => "inward",
        Feed::Outward => "outward",
    }
}

/// Table of plans, section by section.
pub fn table(results: &[&PolicyResult], grid: &FloorGrid) -> String {
    named_table(results.iter().map(|result| (result.plan.policy.name(), *result)), grid)
}

/// Table of plans under names of their own.
pub fn named_table<'r>(
    results: impl Iterator<Item = (&'r str, &'r PolicyResult)>,
    grid: &FloorGrid,
) -> String {
    let mut text = String::from(
        "policy        section         tool    positions  interf.  contact mm  hub stock mean/95 % mm  uncut %  out of reach %  blocked\n",
    );
    for (name, result) in results {
        let whole = [(String::from("all"), String::new(), result.summary.clone())];
        let parts = sections(result, grid).map(|(_, section, s)| {
            (format!("{:.2} to {:.2}", section.from, section.to), format!("D {}", section.tool.diameter), s)
        });
        for (section, tool, s) in parts.chain(whole) {
            text += &format!(
                "{name:<13} {section:<15} {tool:<7} {:>9}  {:>7}  {:>10.2}  {:>11.2} / {:<9.2}  {:>7.1}  {:>14.1}  {:>7}\n",
                s.positions,
                s.interferential,
                s.max_contact_depth,
                s.residual_mean,
                s.residual_p95,
                100.0 * s.uncut_share,
                100.0 * s.unreachable_share,
                s.blocked
            );
        }
    }
    text
}

/// How many positions of a plan (or of one section) something keeps from the axis that would leave the least.
fn held_back(plan: &PlungePlan, section: Option<usize>) -> [(Held, usize); 3] {
    Held::ALL.map(|held| {
        let ours = |p: &&Position| p.held == Some(held) && section.is_none_or(|s| p.section == s);
        (held, plan.positions.iter().filter(ours).count())
    })
}

fn held_object(counts: &[(Held, usize)]) -> Value {
    Value::Object(
        counts
            .iter()
            .map(|(held, count)| (json!(held).as_str().unwrap_or_default().to_owned(), json!(count)))
            .collect(),
    )
}

/// Says what keeps positions from the axis that would leave the least; empty where nothing does.
pub fn held(plan: &PlungePlan) -> String {
    let counts = held_back(plan, None);
    let lifted = plan.positions.iter().filter(|p| p.lift > 0.02).count();
    let mut text = String::new();
    if counts.iter().any(|(_, count)| *count > 0) {
        let words: Vec<String> =
            counts.iter().map(|(held, count)| format!("{count} by {}", held.words())).collect();
        text += &format!("held back from the axis that leaves least: {}\n", words.join(", "));
    }
    if lifted > 0 {
        let most = plan.positions.iter().map(|p| p.lift).fold(0.0, f64::max);
        text += &format!("stop short for the core to be free: {lifted} positions, by up to {most:.2} mm\n");
    }
    text
}

/// Why each section was chosen, where the setup did not give it.
pub fn reasons(plan: &PlungePlan, reasons: &[Option<String>]) -> String {
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
pub fn added(plan: &PlungePlan) -> String {
    let mut text = String::new();
    for section in &plan.sections {
        if let Some((count, stopped)) = section.added {
            let (from, to) = (section.from, section.to);
            let why = stopped.words();
            let what = match (section.rest, count) {
                _ if stopped == Stopped::Cancelled => format!("{count} plunges added; {why}"),
                (false, _) => format!("{count} plunges added to the rows; {why}"),
                (true, 0) => "nothing left that is thick enough for another cutter".to_owned(),
                (true, _) => format!("{count} plunges for the rest; {why}"),
            };
            text += &format!("{from:.2} to {to:.2}, D {}: {what}\n", section.tool.diameter);
        }
    }
    text
}

/// The lines under the table: clearances and time.
pub fn clearances(plan: &PlungePlan, s: &Summary) -> String {
    format!(
        "least clearance: hub {:.4} mm, blades {:.4} mm, retracts {:.3} mm; axis change up to {:.1}°\n\
         {} rounds, {}; about {:.0} min a channel (tool changes and accelerations left out)\n",
        s.min_hub_clearance,
        s.min_blade_clearance,
        s.min_retract_clearance,
        s.max_axis_change.to_degrees(),
        plan.rounds,
        if plan.settled { "settled" } else { "NOT settled" },
        s.time_estimate / 60.0
    )
}

/// Names every blocked position of a plan, section by section, and counts those that were left out.
pub fn blocked(plan: &PlungePlan) -> String {
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
        for (why, what) in [
            (NoPlace::Blades, "that clear no blade"),
            (NoPlace::Contact, "whose core would be free only far above the hub"),
        ] {
            let left_out = plan.dropped.iter().filter(|d| (d.section, d.why) == (index, why)).count();
            if left_out > 0 {
                text += &format!("left out with tool {}: {left_out} positions {what}\n", section.tool.number);
            }
        }
    }
    text
}
