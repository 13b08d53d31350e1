//! Flank programs of several channels: what is cut in each, the links from channel to channel, and `verify`
//! of the whole.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use vanecut::cutting::link::AxisTurn;
use vanecut::cutting::retract::bottom_clearance;
use vanecut::flank::FlankOpening;
use vanecut::flank::channels::FlankChannels;
use vanecut::geometry::{rotate_vector_z, rotate_z};
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::io::flank_file::{StoredFlank, read_flank_bytes, write_flank};
use vanecut::io::read_part;
use vanecut::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use vanecut::job::flank_channels::FlankProgram;
use vanecut::monitor::Monitor;
use vanecut::part::{BlankShape, Impeller};
use vanecut::setup::{ChannelOrder, ChannelSequence, ChannelSetup, FlankStrategy, Setup, Tool};
use vanecut::toolpath::{ClProgram, Motion, Move, Travel};
use vanecut::verify::verify_flank;

const EVERY_ORDER: [ChannelSetup; 4] = [
    ChannelSetup { order: ChannelOrder::ToolByTool, sequence: ChannelSequence::Adjacent },
    ChannelSetup { order: ChannelOrder::ToolByTool, sequence: ChannelSequence::Opposite },
    ChannelSetup { order: ChannelOrder::ChannelByChannel, sequence: ChannelSequence::Adjacent },
    ChannelSetup { order: ChannelOrder::ChannelByChannel, sequence: ChannelSequence::Opposite },
];

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name)
}

/// A plan of few layers, checked in so many channels in an order.
fn planned(
    name: &str,
    channels: usize,
    order: ChannelSetup,
    layer_depth: f64,
    blank: BlankShape,
) -> FlankOutcome {
    let part = Impeller::build(&read_part(&sample(name)).expect("readable")).expect("an impeller");
    let mut setup = Setup::default();
    setup.flank.strategy = FlankStrategy::Regions;
    setup.flank.layer_depth = layer_depth;
    // Fewer passes than by default.
    setup.flank.scallop_height = 0.6;
    setup.allowances.blank = blank;
    setup.channels = order;
    let request = FlankRequest { part: Arc::new(part), setup };
    let job = FlankJob::default();
    job.run_for_channels(&request, channels, &Monitor::default()).expect("a plan")
}

/// One tool.
static PUMP: LazyLock<FlankOutcome> =
    LazyLock::new(|| planned("pump6.toml", 2, EVERY_ORDER[1], 16.0, BlankShape::Edges));
/// Two tools: plunges above the shroud come before the passes.
static TURNED: LazyLock<FlankOutcome> =
    LazyLock::new(|| planned("pump6.toml", 2, EVERY_ORDER[2], 16.0, BlankShape::Turned));
/// A splitter, nine channels.
static WITH_SPLITTER: LazyLock<FlankOutcome> =
    LazyLock::new(|| planned("impeller9x9.toml", 2, EVERY_ORDER[1], 20.0, BlankShape::Edges));

/// The program of three channels of the first, as it is judged with its plan.
static PUMP_IN_THREE: LazyLock<FlankProgram> = LazyLock::new(|| judged(&PUMP, 3));

fn judged(outcome: &FlankOutcome, channels: usize) -> FlankProgram {
    outcome.program_for_channels(channels, &Monitor::default()).expect("judged")
}

/// Two tools in every order, and one tool in every order on one of two wheels, with the program of so many
/// channels: a whole wheel, and parts of wheels.
static IN_CHANNELS: LazyLock<Vec<(FlankOutcome, usize, FlankChannels)>> = LazyLock::new(|| {
    let plans: [(&FlankOutcome, usize, &[usize]); 3] =
        [(&*PUMP, 6, &[1, 2]), (&*TURNED, 6, &[0, 1, 2, 3]), (&*WITH_SPLITTER, 4, &[0, 3])];
    let in_order = |outcome: &FlankOutcome, channels: usize, order: usize| {
        let outcome = ordered(outcome, EVERY_ORDER[order]);
        let program = in_channels(&outcome, channels);
        (outcome, channels, program)
    };
    let in_orders = |&(outcome, channels, orders): &(&FlankOutcome, usize, &[usize])| {
        orders.iter().map(|&order| in_order(outcome, channels, order)).collect::<Vec<_>>()
    };
    plans.iter().flat_map(in_orders).collect()
});

/// `outcome` with another order of its channels.
fn ordered(outcome: &FlankOutcome, order: ChannelSetup) -> FlankOutcome {
    let mut outcome = outcome.clone();
    outcome.setup.channels = order;
    outcome
}

fn in_channels(outcome: &FlankOutcome, channels: usize) -> FlankChannels {
    outcome.in_channels(channels, &Monitor::default()).expect("not cancelled")
}

/// With one tool and with two, and with splitters: `verify` finds as many channels and no fault, and its
/// figures are those of one channel where a channel is what counts.
#[test]
fn verify_finds_no_fault_in_programs_of_several_channels() {
    let (turned, splitter) = (judged(&TURNED, 2), judged(&WITH_SPLITTER, 2));
    for (outcome, channels, judged) in
        [(&*PUMP, 3, &*PUMP_IN_THREE), (&TURNED, 2, &turned), (&WITH_SPLITTER, 2, &splitter)]
    {
        let name = &outcome.workpiece.part.name;
        let one = outcome.verdict.as_ref().expect("verified");
        let order = outcome.setup.channels;
        let place = format!("{name}, {}", order.words());
        assert_eq!(judged.faults, [], "{place}");
        let verdict = judged.verdict.as_ref().expect("verified");
        assert_eq!((verdict.channels, verdict.positions), (channels, judged.positions()), "{place}");
        let safety = outcome.setup.allowances.safety_distance;
        assert!(verdict.min_retract_clearance > safety - 1e-3, "{place}: {verdict:?}");
        assert!((verdict.max_overcut - one.max_overcut).abs() < 1e-3, "{place}");
        // In a program of one channel its plunges above the neighbours count as cuts of these.
        if outcome.plan.opening.is_none() {
            assert!((verdict.max_undercut - one.max_undercut).abs() < 1e-3, "{place}");
            assert!((verdict.uncovered.share() - one.uncovered.share()).abs() < 1e-3, "{place}");
        }
        assert!((verdict.time_estimate - judged.time_estimate).abs() < 1.0, "{place}");
        let tools = if outcome.plan.opening.is_some() { 2 } else { 1 };
        // A channel whose plunges others have made loads no tool for them.
        let most = if order.order == ChannelOrder::ChannelByChannel { tools * channels } else { tools };
        assert!((tools..=most).contains(&verdict.tool_loads), "{place}: {}", verdict.tool_loads);
        assert_eq!(verdict.tool_loads, judged.program.tool_loads(), "{place}");
    }
}

/// The moves of each channel are those of channel 1, turned, in their order; all others are rapids.
#[test]
fn each_channel_repeats_the_moves_of_the_first() {
    for (outcome, channels, FlankChannels { program, origins }) in &*IN_CHANNELS {
        let (part, one) = (&outcome.workpiece.part, outcome.program());
        assert_eq!(program.moves.len(), origins.len());
        let mut next = vec![0; part.blade_count];
        let sequence = outcome.setup.channels.sequence.channels(part.blade_count);
        for (k, (step, origin)) in program.moves.iter().zip(origins).enumerate() {
            let Some(origin) = origin else {
                assert_eq!(step.motion, Motion::Rapid, "move {k} from channel to channel");
                continue;
            };
            assert_eq!(sequence[origin.place], origin.channel);
            let of_one = &one.moves[origin.index];
            assert_eq!((step.motion, step.tool), (of_one.motion, of_one.tool), "move {k}");
            let angle = part.pitch() * origin.channel as f64;
            assert!((step.axis - rotate_vector_z(&of_one.axis, angle)).norm() < 1e-12, "move {k}");
            let off = step.tip - rotate_z(&of_one.tip, angle);
            // The last retract before a link goes on to its height.
            let raised = off.dot(&step.axis);
            let is_last = origins.get(k + 1) == Some(&None);
            assert!((off - step.axis * raised).norm() < 1e-9, "move {k}");
            assert!(raised.abs() < 1e-9 || is_last && step.motion == Motion::Rapid && raised > 0.0, "{k}");
            assert!(origin.index >= next[origin.channel], "move {k} in its order");
            // Plunges above the shroud may be left out, as another channel has made them.
            let skipped = &one.moves[next[origin.channel]..origin.index];
            assert!(skipped.iter().all(|of_one| of_one.tool == Some(1)), "move {k}");
            next[origin.channel] = origin.index + 1;
        }
        for &channel in &sequence[..*channels] {
            assert_eq!(next[channel], one.moves.len(), "channel {}", channel + 1);
        }
    }
}

/// Least distance of the bottom of `tool` to the blank over rapid `moves`, by a dense scan, mm.
fn min_clearance_of_rapids(outcome: &FlankOutcome, tool: &Tool, moves: &[Move]) -> f64 {
    const SAMPLES: usize = 60;
    let blank = &outcome.workpiece.blank;
    let of_move = |pair: &[Move]| {
        let turn = AxisTurn::new(pair[0].axis, &pair[1].axis);
        let clearance = |k: usize| {
            let share = k as f64 / SAMPLES as f64;
            let tip = pair[0].tip + (pair[1].tip - pair[0].tip) * share;
            bottom_clearance(&tool.placed(tip, turn.at(share).0), blank)
        };
        (0..=SAMPLES).map(clearance).fold(f64::INFINITY, f64::min)
    };
    moves.windows(2).map(of_move).fold(f64::INFINITY, f64::min)
}

/// Every link from channel to channel, looked at densely: rapids only, clear of the blank by the safety
/// distance, from the end of one channel to the start of the next.
#[test]
fn links_from_channel_to_channel_stay_clear_of_the_blank() {
    for (outcome, channels, FlankChannels { program, origins }) in &*IN_CHANNELS {
        let order = outcome.setup.channels;
        let safety = outcome.setup.allowances.safety_distance;
        let mut links = 0;
        let mut k = 0;
        while k < origins.len() {
            if origins[k].is_some() {
                k += 1;
                continue;
            }
            let end = k + origins[k..].iter().take_while(|origin| origin.is_none()).count();
            let moves = &program.moves[k - 1..=end];
            let tool = match (moves[0].tool, &outcome.plan.opening) {
                (Some(1), Some(opening)) => &opening.tool,
                _ => &outcome.plan.tool,
            };
            assert!(moves.iter().all(|step| step.motion == Motion::Rapid && step.tool == moves[0].tool));
            let clearance = min_clearance_of_rapids(outcome, tool, moves);
            assert!(clearance > safety - 1e-3, "move {k}, {}: {clearance}", order.words());
            links += 1;
            k = end;
        }
        let tools = if outcome.plan.opening.is_some() { 2 } else { 1 };
        let expected = match order.order {
            ChannelOrder::ChannelByChannel if tools > 1 => 0,
            _ => channels - 1,
        };
        assert!(links >= expected, "{links} links, {}", order.words());
    }
}

/// The time of the wheel is that of its program.
#[test]
fn the_time_of_the_wheel_is_that_of_its_program() {
    for plan in [&*PUMP, &*TURNED] {
        let count = plan.workpiece.part.blade_count;
        let is_whole = |(outcome, channels, _): &&(FlankOutcome, usize, FlankChannels)| {
            *channels == count
                && outcome.program().moves.len() == plan.program().moves.len()
                && outcome.setup.channels == plan.setup.channels
        };
        let (.., whole) = IN_CHANNELS.iter().find(is_whole).expect("a whole wheel");
        let travel = Travel::from_program(&whole.program);
        assert_eq!(plan.wheel_time_s, Some(travel.time));
        let one = Travel::from_program(&plan.program());
        assert!(travel.cut <= one.cut * count as f64 + 1e-6);
    }
}

/// A file holds the plan of a channel and how many it is repeated for; its program is that of the plan.
#[test]
fn a_file_of_several_channels_gives_their_program() {
    let outcome = ordered(&TURNED, EVERY_ORDER[1]);
    let description = read_part(&sample("pump6.toml")).expect("readable");
    let text = |channels| write_flank(&description, &outcome.setup, &outcome.plan, &[], channels);
    assert!(text(1).starts_with("{\"vanecut_flank\":2,") && !text(1).contains("\"channels\":"));
    assert!(text(4).starts_with("{\"vanecut_flank\":3,"));
    let stored = read_flank_bytes("flank.json", text(4).as_bytes()).expect("its own file");
    assert_eq!(stored.channels, 4);
    let read = |stored: &StoredFlank| -> ClProgram {
        stored.program(&Monitor::default()).expect("not cancelled").expect("with tools")
    };
    let (program, planned) = (read(&stored), in_channels(&outcome, 4).program);
    assert_eq!(program.moves.len(), planned.moves.len());
    let off = program.moves.iter().zip(&planned.moves).map(|(a, b)| (a.tip - b.tip).norm());
    assert!(off.fold(0.0, f64::max) < 1e-4);
}

/// What the plan says of its program is what `verify` says, to the last bit.
#[test]
fn figures_of_a_program_are_those_of_verify() {
    let outcome = &*PUMP;
    let judged = &*PUMP_IN_THREE;
    let text = write_apt(&judged.program);
    let program = read_apt_bytes("flank.apt", text.as_bytes()).expect("readable");
    let setup =
        Setup { flank: outcome.setup.flank.clone(), channels: outcome.setup.channels, ..Setup::default() };
    let verdict = verify_flank(&outcome.workpiece, &setup, &program, &Monitor::default()).expect("judged");
    assert_eq!(format!("{verdict:?}"), format!("{:?}", judged.verdict.as_ref().expect("verified")));
}

/// Plunges above the shroud with the tool of the passes: as none is changed between, the way to the passes
/// leads over the blank, in one channel and in several.
#[test]
fn from_plunges_to_passes_with_the_same_tool_the_way_leads_over_the_blank() {
    let mut outcome = ordered(&PUMP, EVERY_ORDER[2]);
    let (tool, moves) = (outcome.plan.tool.clone(), outcome.plan.moves.clone());
    // A plunge on the other side of the wheel, from where the passes begin.
    let half = std::f64::consts::PI;
    let (above, axis) = (rotate_z(&moves[0].tip, half), rotate_vector_z(&moves[0].axis, half));
    let plunges = vec![(above, above - axis * 3.0, axis)];
    let mut opening = FlankOpening { tool: tool.clone(), plunges, link: Vec::new() };
    let safety = outcome.setup.allowances.safety_distance;
    let near = (&outcome.workpiece.blank, safety);
    let other = Tool { number: tool.number + 1, ..tool.clone() };
    opening.lead_to(&moves, &other, near, &Monitor::default()).expect("not cancelled");
    assert_eq!(opening.link, [], "a tool is changed far from the part");
    opening.lead_to(&moves, &tool, near, &Monitor::default()).expect("not cancelled");
    outcome.plan.opening = Some(opening.clone());
    let one = outcome.program();
    let way = &one.moves[2..=3 + opening.link.len()];
    assert!(one.tools.len() == 1 && way.iter().all(|step| step.motion == Motion::Rapid));
    assert_eq!((way.last().expect("moves").tip, way.len() >= 4), (moves[0].tip, true));
    let clearance = min_clearance_of_rapids(&outcome, &tool, way);
    assert!(clearance > safety - 1e-3, "{clearance}");
    let straight = [way[0].clone(), way[way.len() - 1].clone()];
    assert!(min_clearance_of_rapids(&outcome, &tool, &straight) < 0.0, "through the wheel");
    // In several channels each has its own, and what is a move of the passes is known as one.
    let FlankChannels { program, origins } = in_channels(&outcome, 2);
    let of_passes = |index: usize| {
        let of_one = origins[index].filter(|of_one| of_one.index >= 3 + opening.link.len())?;
        Some((of_one.channel, of_one.index))
    };
    let firsts: Vec<usize> = (1..program.moves.len())
        .filter(|&index| of_passes(index).is_some_and(|(_, first)| first == 3 + opening.link.len()))
        .collect();
    assert_eq!(firsts.len(), 2);
    for first in firsts {
        let way = &program.moves[first - opening.link.len() - 1..=first];
        assert!(min_clearance_of_rapids(&outcome, &tool, way) > safety - 1e-3, "move {first}");
    }
    // And its file holds it.
    let description = read_part(&sample("pump6.toml")).expect("readable");
    let text = write_flank(&description, &outcome.setup, &outcome.plan, &[], 1);
    let read = read_flank_bytes("flank.json", text.as_bytes()).expect("its own file");
    let again = read.opening.expect("an opening");
    assert_eq!(again.link.len(), opening.link.len());
    for (a, b) in again.link.iter().zip(&opening.link) {
        assert!((a.0 - b.0).norm() < 1e-5 && (a.1 - b.1).norm() < 1e-6, "{a:?} {b:?}");
    }
}
