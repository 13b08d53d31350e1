//! `vanecut assess`.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::args::AssessArgs;
use super::output::{blades_text, head, number};
use super::output_folder::check_directory;
#[cfg(feature = "gpu")]
use super::output_folder::create_directory;
use super::stdout::print_stdout;
use super::{Failure, open};
use crate::assess::BladeMeasure;
use crate::assess::passage::PassageMeasure;
use crate::assess::reach::{ReachMap, ReachSides};
use crate::assess::shape::Twist;
#[cfg(feature = "gpu")]
use crate::io::write::write_all_atomically;
use crate::job::assess::AssessedPart;
#[cfg(feature = "gpu")]
use crate::report::assessment::assessment_page;
use crate::setup::SectionKind;

/// Assesses a part, writes pictures if requested, prints the figures.
///
/// # Errors
/// [`Failure::input`] when an input is invalid, [`Failure::work`] when pictures cannot be drawn.
pub fn run(args: &AssessArgs) -> Result<(), Failure> {
    let started = std::time::Instant::now();
    let (_, part) = open::part(&args.part, &args.mesh)?;
    let opened = open::setup(args.setup.as_deref(), &args.part, &part)?;
    if let Some(folder) = &args.output {
        check_directory(folder)?;
    }
    let found = AssessedPart::from_part(part, &opened.setup);
    if let Some(fault) = found.no_reach.clone().filter(|_| args.setup.is_some()) {
        return Err(opened.failure(fault));
    }
    let drawn = match &args.output {
        Some(folder) => write_pictures(folder, &found)?,
        None => String::new(),
    };
    if args.json {
        let mut map = object(&found);
        map.insert("elapsed".into(), number(started.elapsed().as_secs_f64()));
        print_stdout(&format!("{}\n", Value::Object(map)))
    } else {
        let reach = match &found.no_reach {
            Some(fault) => format!("reach: not computed, {fault}\n"),
            None => reach_table(&found),
        };
        print_stdout(&format!("{}{reach}{drawn}", tables(&found)))
    }
}

/// Writes the page and its pictures; returns a line for the user.
#[cfg(feature = "gpu")]
fn write_pictures(folder: &Path, found: &AssessedPart) -> Result<String, Failure> {
    let document = assessment_page(found, "").map_err(Failure::of_work)?;
    create_directory(folder)?;
    let page = folder.join("assess.html");
    write_all_atomically(&document.files_at(&page))?;
    Ok(format!("wrote {} and its pictures\n", page.display()))
}

#[cfg(not(feature = "gpu"))]
fn write_pictures(_: &Path, _: &AssessedPart) -> Result<String, Failure> {
    super::without_gpu::no_pictures()
}

/// Keys in JSON of [`ReachSides::CLASSES`].
const CLASS_KEYS: [&str; 4] = ["reached", "from_outlet", "from_inlet", "from_both"];

fn object(found: &AssessedPart) -> Map<String, Value> {
    let (part, a) = (&found.workpiece.part, &found.assessment);
    let (narrow, wide) = a.width_range();
    let share = |wanted: fn(ReachSides) -> bool| {
        a.reach.as_ref().map_or(Value::Null, |map| number(map.share(wanted)))
    };
    let mut map = head(part, None);
    let mut put = |key: &str, value: Value| {
        map.insert(key.to_owned(), value);
    };
    put("twisting", number(a.twisting().to_degrees()));
    put("bending", number(a.max_bow()));
    put("passage_depth", number(a.depth()));
    put("passage_width_min", number(narrow));
    put("passage_width_max", number(wide));
    put("largest_cutter", number(a.largest_cutter()));
    put("reachable_share", share(|s| s.any));
    for (key, wanted) in CLASS_KEYS.iter().zip(ReachSides::CLASSES).skip(1) {
        put(&format!("reachable_{key}"), share(wanted));
    }
    put("envelope_gap", number(a.blades.iter().map(BladeMeasure::envelope_gap).fold(0.0, f64::max)));
    put("splitter_leading_edge", json!(found.workpiece.channel.splitter_s));
    put("by_blade", a.blades.iter().map(blade_object).collect());
    put("depths", a.depths.iter().map(|(s, depth)| json!({"s": s, "depth": depth})).collect());
    put("passages", a.passages.iter().map(passage_object).collect());
    put("sections", sections_object(found));
    put("reach", a.reach.as_ref().map_or(Value::Null, reach_object));
    map
}

fn blade_object(blade: &BladeMeasure) -> Value {
    let twist = |t: &Twist| {
        json!({
            "span": t.v,
            "twisting": t.angle_rad.to_degrees(),
            "chords": t.chord_angles_rad.map(f64::to_degrees),
            "split": t.split,
            "largest_tangent": t.max_tangent_rad.to_degrees(),
            "largest_tangent_at": t.max_tangent_at,
        })
    };
    let [suction, pressure] = &blade.envelopes;
    json!({
        "blade": blade.name,
        "twisting": blade.twisting().to_degrees(),
        "normal_turn": blade.shape.normal_turn_rad.to_degrees(),
        "most_twisted": blade.shape.max_twist().map(twist),
        "hub_mid_tip": blade.shape.hub_mid_tip().iter().map(twist).collect::<Vec<_>>(),
        "bending": blade.shape.bow.offset,
        "bending_at": blade.shape.bow.u,
        "bending_angle": blade.shape.sharpest_bow.angle_rad.to_degrees(),
        "envelope_gap_suction": suction.max_gap(),
        "envelope_gap_pressure": pressure.max_gap(),
    })
}

fn passage_object(passage: &PassageMeasure) -> Value {
    let widths: Vec<Value> = passage
        .widths
        .iter()
        .filter(|w| w.width.iter().any(Option::is_some))
        .map(|w| json!({"s": w.s, "hub": w.width[0], "middle": w.width[1], "tip": w.width[2]}))
        .collect();
    let cutters: Vec<Value> = passage
        .cutters
        .iter()
        .map(|c| {
            let (foot, axis): ([f64; 3], [f64; 3]) = (c.foot.into(), c.axis.into());
            json!({
                "s": c.s, "diameter": c.diameter, "section_width": c.section_width,
                "foot": foot, "axis": axis,
            })
        })
        .collect();
    json!({"passage": passage.blades.key(), "widths": widths, "cutters": cutters})
}

fn sections_object(found: &AssessedPart) -> Value {
    found
        .sections()
        .iter()
        .enumerate()
        .map(|(index, stretch)| {
            let mut map = Map::new();
            map.insert("tool".into(), json!(stretch.tool.number));
            map.insert("diameter".into(), json!(stretch.tool.diameter));
            map.insert("holder_diameter".into(), json!(stretch.tool.holder_diameter()));
            map.insert("overhang".into(), json!(stretch.tool.overhang));
            map.insert("from".into(), json!(stretch.from));
            map.insert("to".into(), json!(stretch.to));
            map.insert("rest".into(), json!(stretch.kind == SectionKind::Rest));
            for (key, wanted) in CLASS_KEYS.into_iter().zip(ReachSides::CLASSES) {
                let share = found.assessment.reach.as_ref();
                let share = share.map(|map| map.share_of_section(index, wanted));
                map.insert(key.into(), share.map_or(Value::Null, number));
            }
            Value::Object(map)
        })
        .collect()
}

fn reach_object(map: &ReachMap) -> Value {
    map.rows
        .iter()
        .map(|row| {
            let mut object = Map::new();
            object.insert("s".into(), json!(row.s));
            for (key, wanted) in CLASS_KEYS.into_iter().zip(ReachSides::CLASSES) {
                object.insert(key.into(), number(row.share(wanted)));
            }
            Value::Object(object)
        })
        .collect()
}

fn tables(found: &AssessedPart) -> String {
    let (part, a) = (&found.workpiece.part, &found.assessment);
    let mut text = format!("{}: {}, D {:.1}\n\n", part.name, blades_text(part), 2.0 * part.rim_radius());
    text += "blade        twist °  at span  split at  turn °  tangent ° hub / mid / tip      \
             bow mm      bow °  envelope gap mm\n";
    for blade in &a.blades {
        let (name, shape) = (&blade.name, &blade.shape);
        let (v, split) = shape.max_twist().map_or((f64::NAN, f64::NAN), |t| (t.v, t.split));
        let [hub, mid, tip] = shape.hub_mid_tip().map(|t| t.max_tangent_rad.to_degrees());
        text += &format!(
            "{name:<10} {:>9.1}  {v:>7.2}  {split:>8.2}  {:>6.1}  {:>26}  {:>10.3}  {:>9.2}  {:>15.3}\n",
            blade.twisting().to_degrees(),
            shape.normal_turn_rad.to_degrees(),
            format!("{hub:.1} / {mid:.1} / {tip:.1}"),
            shape.bow.offset,
            shape.sharpest_bow.angle_rad.to_degrees(),
            blade.envelope_gap(),
        );
    }
    text += "twist: angle of the camber line's chords to the rotation axis (twisting degree)\n\
             turn: rotation of the blade's normal from hub to tip; about 0 for cylindrical blades\n";
    for passage in &a.passages {
        text += &format!("\n{}\n{}", passage.blades.label(), passage_table(passage, &a.depths));
    }
    let (narrow, wide) = a.width_range();
    text += &format!(
        "\ndepth up to {:.2} mm, width {narrow:.2} to {wide:.2} mm, \
         largest cutter along the whole channel D {:.2}\n",
        a.depth(),
        a.largest_cutter()
    );
    text
}

/// Table of depth, widths and largest cutter of a passage at every tenth of s and at the station of the
/// smallest cutter.
fn passage_table(passage: &PassageMeasure, depths: &[(f64, f64)]) -> String {
    let mut text = String::from(
        "   s  depth mm  width mm hub / middle / tip  across its course mm  largest cutter mm\n",
    );
    let smallest = passage.cutters.iter().min_by(|a, b| a.diameter.total_cmp(&b.diameter)).map(|c| c.s);
    let same = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let shown = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.2}"));
    for station in passage.widths.iter().filter(|w| w.width.iter().any(Option::is_some)) {
        let tenth = same((10.0 * station.s).round(), 10.0 * station.s);
        if !tenth && !smallest.is_some_and(|s| same(s, station.s)) {
            continue;
        }
        let depth = depths.iter().find(|d| same(d.0, station.s)).map(|d| d.1);
        let cutter = passage.cutters.iter().find(|c| same(c.s, station.s));
        let [hub, middle, tip] = station.width.map(shown);
        text += &format!(
            "{:>4.2}  {:>8}  {:>27}  {:>20}  {:>17}\n",
            station.s,
            shown(depth),
            format!("{hub} / {middle} / {tip}"),
            shown(cutter.map(|c| c.section_width)),
            shown(cutter.map(|c| c.diameter))
        );
    }
    text
}

fn reach_table(found: &AssessedPart) -> String {
    let Some(map) = &found.assessment.reach else { return String::new() };
    let mut text = String::from(
        "\nreach          tool        overhang mm  floor reached %  from outlet %  from inlet %  from both %\n",
    );
    let mut line = |name: String, tool: String, overhang: String, shares: [f64; 4]| {
        let [any, outlet, inlet, both] = shares.map(|x| 100.0 * x);
        text += &format!(
            "{name:<13}  {tool:<10}  {overhang:>11}  \
             {any:>15.1}  {outlet:>13.1}  {inlet:>12.1}  {both:>11.1}\n"
        );
    };
    for (index, s) in found.sections().into_iter().enumerate() {
        let shares = ReachSides::CLASSES.map(|wanted| map.share_of_section(index, wanted));
        let name = format!("{:.2} to {:.2}", s.from, s.to);
        let tool = format!("D {}{}", s.tool.diameter, s.kind.suffix());
        line(name, tool, format!("{:.0}", s.tool.overhang), shares);
    }
    line("all".to_owned(), String::new(), String::new(), ReachSides::CLASSES.map(|wanted| map.share(wanted)));
    text
}
