//! Links with one thing changed: `verify` finds it, or the cuts that follow are not where they were.

use vanecut::geometry::{Point, Vector};
use vanecut::io::nc::{NcReading, ReadContext, read_nc, read_post};
use vanecut::machine::{MachineTool, OutputKind, PlacedPart, StepMotion, even_turn, gauge_length};
use vanecut::monitor::Monitor;
use vanecut::verify::{report_plunges, verify};

use super::figures::{CELLS, MEANT, PLUNGED, figures_of, kinds_of};
use super::programs::{MACHINES, largest_difference, machine, moved, placed, plunges};

/// By what a changed program is seen to be another one; `None` where nothing tells.
pub fn found_by(machine: &MachineTool, control: &str, text: &str) -> Option<&'static str> {
    let planned = &*PLUNGED;
    let reading = match read(machine, control, text) {
        Ok(reading) => reading,
        Err(by) => return Some(by),
    };
    let (workpiece, setup, monitor) = (&planned.workpiece, &planned.setup, Monitor::default());
    // The floor is measured where the faults tell nothing.
    let verdict = verify(workpiece, setup, &reading.program, &monitor);
    if verdict.is_ok_and(|verdict| kinds_of(&verdict) != kinds_of(&MEANT.verdict)) {
        return Some("faults");
    }
    let read = report_plunges(workpiece, setup, &reading.program, CELLS, &monitor);
    let Ok(read) = read else { return Some("faults") };
    let figures = figures_of(&MEANT.summary).into_iter().zip(figures_of(&read.summary));
    let mut figures = figures.filter(|((_, meant, limit), (_, read, _))| (meant - read).abs() > *limit);
    if figures.next().is_some() {
        return Some("figures");
    }
    has_other_cuts(&reading).then_some("cuts")
}

/// Whether anything tells: where the cuts are is looked at before `verify` judges them, which takes longer.
fn is_found(machine: &MachineTool, control: &str, text: &str) -> bool {
    let is_like_planned = |reading: NcReading| !has_other_cuts(&reading);
    !read(machine, control, text).is_ok_and(is_like_planned) || found_by(machine, control, text).is_some()
}

/// The program as it is read, or by what it is refused.
fn read(machine: &MachineTool, control: &str, text: &str) -> Result<NcReading, &'static str> {
    let placed = PlacedPart::from_placement(&machine.part, &PLUNGED.workpiece.part);
    let context = ReadContext { machine, placed, tools: &PLUNGED.setup.tools };
    let dialect = read_post(control).unwrap().dialect;
    match read_nc("p.nc", text.as_bytes(), dialect, &context) {
        Ok(reading) if reading.overruns.is_empty() => Ok(reading),
        Ok(_) => Err("limits"),
        Err(_) => Err("reader"),
    }
}

/// Whether the cuts are not where they are planned.
fn has_other_cuts(reading: &NcReading) -> bool {
    let cuts = largest_difference(&PLUNGED.program, reading);
    cuts.map_or(true, |(tip, axis)| tip > 1e-3 || axis > 1e-4)
}

/// The feed rate of a line.
fn rate_of(line: &str) -> Option<f64> {
    line.split(' ').find_map(|word| word.strip_prefix('F')?.parse().ok())
}

/// A line without its rotary positions, or its direction.
fn without_turn(line: &str) -> String {
    let turns = |word: &str| {
        let number = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit() || "+-=".contains(c));
        ["A", "B", "C", "TX", "TY", "TZ", "I", "J", "K"]
            .iter()
            .any(|address| word.strip_prefix(address).is_some_and(number))
            || ["A3=", "B3=", "C3="].iter().any(|address| word.starts_with(address))
    };
    line.split(' ').filter(|word| !turns(word)).collect::<Vec<_>>().join(" ")
}

/// Every ninth cut: the last turn before it is left out, and the retract after it. Of turns in several blocks
/// that is the last; one of the others is made up for by the next block, and what comes of it is a link like
/// others. `a_mode_left_out_is_always_caught` tests whether the control holds the tip where it should.
#[test]
fn a_turn_or_a_retract_left_out_is_always_found() {
    for (name, control, output) in [
        ("ac-trunnion", "fanuc", OutputKind::TcpAngles),
        ("bc-head", "heidenhain", OutputKind::TcpVectors),
        ("b-head-c-table", "siemens", OutputKind::Joints),
        ("nutating-table", "linuxcnc", OutputKind::TcpAngles),
        ("bc-trunnion", "fanuc", OutputKind::Plane),
    ] {
        let machine = machine(name);
        let text = PLUNGED.posted(&machine, control, output).0.text;
        assert_eq!(found_by(&machine, control, &text), None, "{name} {control}");
        let lines: Vec<&str> = text.lines().collect();
        // Links in inverse time may have any number.
        let feed = PLUNGED.setup.tools[0].plunge_feed;
        let is_cut = |k: &usize| rate_of(lines[*k]) == Some(feed);
        let cuts: Vec<usize> = (0..lines.len()).filter(is_cut).collect();
        let mut tried = [0; 2];
        // Before the first cut the axes stand as they should already when the tip is first held.
        for &cut in cuts.iter().skip(1).step_by(9) {
            let case = |what: &str| format!("{name} {control} {}: {what}: {}", output.name(), lines[cut]);
            // A line of its own for the cut where the turn ends before it.
            let before = (0..cut).rev().take_while(|k| !is_cut(k));
            let turn = before.map(|k| (k, without_turn(lines[k]))).find(|(k, without)| *without != lines[*k]);
            if let Some((place, without)) = turn {
                let mut changed = lines.clone();
                changed[place] = &without;
                let is_found = is_found(&machine, control, &changed.join("\n"));
                assert!(is_found, "{}", case(&format!("turn of {}", lines[place])));
                tried[0] += 1;
            }
            let mut changed = lines.clone();
            let retract = changed.remove(cut + 1);
            let by = found_by(&machine, control, &changed.join("\n"));
            assert!(matches!(by, Some("faults" | "figures")), "{} by {by:?}", case(&format!("no {retract}")));
            tried[1] += 1;
        }
        assert!(tried.iter().all(|&count| count > 8), "{name} {control}: {tried:?}");
    }
}

/// Samples of a move between two steps.
const SAMPLES: usize = 16;

/// In links whose tip is held the bottom of the tool comes no nearer to what is below it than on the planned
/// way, between the blocks too: the tip lies on the planned line or above, by more than the axis leans out of
/// the plane of the planned turn. Where the control does not hold the tip, its way near the ends of a link is
/// no parabola: in these turns of 20° it comes 3.3 µm nearer on the nutating table, of the 10 µm by which it
/// may stray.
#[test]
fn held_links_come_no_nearer_than_planned() {
    let program = plunges();
    for name in MACHINES {
        for output in [OutputKind::TcpAngles, OutputKind::Joints] {
            let machine = machine(name);
            let motion = moved(&machine, &program, &read_post("fanuc").unwrap(), output).unwrap();
            let (mut held, mut nearest) = (0, 0.0);
            for (source, step) in program.moves.iter().enumerate().skip(1) {
                let steps: Vec<_> = motion.steps.iter().filter(|step| step.source == source).collect();
                let planned = [&program.moves[source - 1], step];
                let before = motion.steps.iter().rposition(|step| step.source + 1 == source);
                let chord = planned[1].tip - planned[0].tip;
                let is_held = steps.iter().all(|step| step.motion == StepMotion::Link)
                    && planned[0].tool == planned[1].tool
                    && planned[0].axis != planned[1].axis;
                let Some(before) = before.filter(|_| is_held) else { continue };
                let placed = placed(&machine);
                let tool = &program.tools[step.tool.unwrap()];
                let length = gauge_length(&machine, tool);
                let poses: Vec<_> = std::iter::once(&motion.steps[before].pose)
                    .chain(steps.iter().map(|s| &s.pose))
                    .collect();
                let off_line = |tip: &Point| {
                    let to_tip = placed.point_in_part(tip) - planned[0].tip;
                    let share = to_tip.dot(&chord) / chord.norm_squared();
                    (to_tip - chord * share, share)
                };
                // Others leave the part.
                if poses.iter().any(|pose| off_line(&pose.tip).0.norm() > 0.5) {
                    continue;
                }
                held += 1;
                for pair in poses.windows(2) {
                    let joints = [0, 1].map(|i| machine.joints(&pair[i].tip, &pair[i].angles, length));
                    for k in 0..=SAMPLES {
                        let at = k as f64 / SAMPLES as f64;
                        let mixed = |a: f64, b: f64| a + (b - a) * at;
                        let angles = [0, 1].map(|i| mixed(pair[0].angles[i], pair[1].angles[i]));
                        let tip = match output {
                            OutputKind::Joints => machine.tip(
                                &[0, 1, 2].map(|i| mixed(joints[0][i], joints[1][i])),
                                &angles,
                                length,
                            ),
                            _ => pair[0].tip + (pair[1].tip - pair[0].tip) * at,
                        };
                        let (off, share) = off_line(&tip);
                        let axis: Vector = placed.vector_in_part(&machine.tool_axis(&angles));
                        let meant = even_turn(&planned[0].axis, &planned[1].axis, share.clamp(0.0, 1.0));
                        nearest =
                            f64::min(nearest, off.dot(&meant) - 0.5 * tool.diameter * axis.angle(&meant));
                    }
                }
            }
            assert!(held > 5, "{name} {}: {held} links are held", output.name());
            let limit = if output == OutputKind::Joints { 4e-3 } else { 7e-4 };
            assert!(nearest > -limit, "{name} {}: {nearest} mm, {held} links", output.name());
        }
    }
}
