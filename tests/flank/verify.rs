//! `verify` on synthetic flank programs: correct ones, and ones that gouge, collide, cross stock in rapid, or
//! leave strips.

use std::sync::LazyLock;

use vanecut::cutting::drop_cutter::DepthSurface;
use vanecut::flank::wall::{WallAxes, WallFit, WallMilling, WallStation};
use vanecut::geometry::{Point, Vector, rotate_vector_z, rotate_z};
use vanecut::io::apt::{read_apt_bytes, write_apt};
use vanecut::monitor::{Cancelled, Monitor};
use vanecut::part::Workpiece;
use vanecut::setup::{Setup, Tool};
use vanecut::toolpath::{ClProgram, ClTool, Motion, Move};
use vanecut::verify::{FaultKind, FlankVerdict, FlankVerifier, VerifyError, verify_flank};

use super::parts::{cutter, described, part_at};

/// Range of the passes, as s of the foot of the axis: beyond the hub's ends, cutters would drop too low.
const ALONG: std::ops::RangeInclusive<f64> = 0.0..=0.98;

type Place = (Point, Vector);

struct Made {
    workpiece: Workpiece,
    tool: Tool,
    setup: Setup,
    /// Passes along the walls, on the lowest layer.
    walls: [Vec<Place>; 2],
    /// Passes between them.
    inner: Vec<Vec<Place>>,
}

/// The ball-end mill of these passes.
fn ball() -> Tool {
    cutter(8.0, 4.0, 90.0)
}

/// The impeller without splitters, and the axes along its walls on the lowest layer.
static AXES: LazyLock<(Workpiece, [WallAxes; 2])> = LazyLock::new(|| {
    let (tool, setup) = (ball(), Setup::default());
    let workpiece = setup.allowances.workpiece_of(part_at("assets/parts/impeller532.toml"));
    let stock = &setup.allowances;
    let milling = WallMilling {
        tool: &tool,
        blade_allowance: stock.blade_allowance,
        hub_allowance: stock.hub_allowance,
        lead_in_out: 12.0,
        step: 2.0,
        chord_error: 0.002,
    };
    let layer = lowest_layer(&workpiece, &tool);
    let axes = [0, 1].map(|wall| {
        let layers = std::slice::from_ref(&layer);
        let fit = WallFit::new(&workpiece.finished, &workpiece.channel.full, wall, &milling, layers);
        let fit = fit.expect("a wall");
        fit.axes(fit.sweep(0.0))
    });
    (workpiece, axes)
});

fn lowest_layer<'a>(workpiece: &'a Workpiece, tool: &Tool) -> DepthSurface<'a> {
    DepthSurface::new(
        workpiece.part.hub.curve(),
        Setup::default().allowances.hub_allowance + tool.corner_radius,
    )
}

/// Passes of a ball-end mill over its floor: two along the walls, `inner` between them.
fn made(inner: usize) -> Made {
    let (workpiece, axes) = &*AXES;
    let tool = ball();
    let layer = lowest_layer(workpiece, &tool);
    let walls = [0, 1].map(|wall| -> Vec<Place> {
        let tip = |s: &WallStation| Some((s.tip?, s.axis));
        axes[wall].stations(0).iter().filter(|s| ALONG.contains(&s.s)).filter_map(tip).collect()
    });
    // Foot and axis at a wall for s, interpolated between stations.
    let at = |wall: usize, s: f64| {
        let stations = axes[wall].stations(0);
        let k = stations.partition_point(|x| x.s < s).clamp(1, stations.len() - 1);
        let (a, b) = (&stations[k - 1], &stations[k]);
        let share = ((s - a.s) / (b.s - a.s)).clamp(0.0, 1.0);
        (a.foot + (b.foot - a.foot) * share, a.axis + (b.axis - a.axis) * share)
    };
    let inner = (1..=inner)
        .map(|k| {
            let lambda = k as f64 / (inner + 1) as f64;
            let place = |i: i32| {
                let s = ALONG.start() + (ALONG.end() - ALONG.start()) * f64::from(i) / 200.0;
                let ((p, a), (q, b)) = (at(0, s), at(1, s));
                let axis = (a + (b - a) * lambda).normalize();
                Some((layer.tip(&tool, &(p + (q - p) * lambda), &axis)?, axis))
            };
            (0..=200).filter_map(place).collect()
        })
        .collect();
    let setup = Setup::default();
    let workpiece = setup.allowances.workpiece_of(workpiece.part.clone());
    Made { workpiece, tool, setup, walls, inner }
}

/// A wheel of 26 mm with blades of .3 mm, and a cutter of .5 mm for it.
fn small() -> Made {
    let text = r#"
name = "small"
blades = 5
[hub]
control = [[3, -8], [3.3, -4], [6, -0.5], [13, 0]]
[shroud]
control = [[8, -8], [8.2, -6], [9.5, -3], [13, -2]]
[[main.span]]
span = 0.0
leading_edge = 0.1
theta_leading_edge = 0.0
angle = [[0.0, 20.0], [1.0, 30.0]]
thickness = [[0.0, 0.3], [1.0, 0.3]]
[[main.span]]
span = 1.0
leading_edge = 0.1
theta_leading_edge = 0.0
angle = [[0.0, 30.0], [1.0, 30.0]]
thickness = [[0.0, 0.3], [1.0, 0.3]]
"#;
    let part = described(text);
    let mut setup = Setup::default();
    (setup.allowances.hub_allowance, setup.allowances.blade_allowance) = (0.1, 0.1);
    let tool = cutter(0.5, 0.1, 10.0);
    let workpiece = setup.allowances.workpiece_of(part);
    Made { workpiece, tool, setup, walls: Default::default(), inner: Vec::new() }
}

impl Made {
    /// A program of passes, each with a rapid above its first position and from its last one; `change` may
    /// modify the moves.
    fn program<'p>(
        &self,
        passes: impl IntoIterator<Item = &'p Vec<Place>>,
        change: impl Fn(&mut Vec<Move>),
    ) -> ClProgram {
        let mut moves = Vec::new();
        for pass in passes {
            let mut go = |motion, (tip, axis): Place, up: f64| {
                moves.push(Move { motion, tip: tip + axis * up, axis, tool: Some(0), line: 0 });
            };
            let (first, last) = (pass[0], pass[pass.len() - 1]);
            go(Motion::Rapid, first, 150.0);
            go(Motion::Feed(Some(400.0)), first, 0.0);
            pass[1..].iter().for_each(|&place| go(Motion::Feed(Some(800.0)), place, 0.0));
            go(Motion::Rapid, last, 150.0);
        }
        change(&mut moves);
        let t = &self.tool;
        let tool = ClTool {
            number: t.number,
            diameter: t.diameter,
            corner_radius: t.corner_radius,
            insert_width: Some(t.insert_width),
            overhang: Some(t.overhang),
            feed_mm_per_min: Some(t.plunge_feed),
            spindle_rpm: Some(t.spindle),
            length_offset: None,
        };
        ClProgram { part: self.workpiece.part.name.clone(), tools: vec![tool], moves, ..ClProgram::default() }
    }

    /// The verdict of `verify` on the written program.
    fn verdict(&self, program: &ClProgram) -> FlankVerdict {
        let read = read_apt_bytes("flank.apt", write_apt(program).as_bytes()).expect("readable");
        assert!(read.mills_along_curves(), "a flank program");
        let verdict =
            verify_flank(&self.workpiece, &self.setup, &read, &Monitor::default()).expect("can be judged");
        // These programs mill the full depth at once, which is a separate fault.
        let others = verdict.faults.iter().filter(|fault| fault.kind != FaultKind::TooDeep);
        FlankVerdict { faults: others.cloned().collect(), ..verdict }
    }
}

fn shown(verdict: &FlankVerdict) -> Vec<String> {
    verdict.faults.iter().take(8).map(|fault| format!("{}: {fault}", fault.line)).collect()
}

/// Number of faults of a kind.
fn count(verdict: &FlankVerdict, kind: FaultKind) -> usize {
    verdict.faults.iter().filter(|fault| fault.kind == kind).count()
}

#[test]
fn a_good_program_has_no_fault_and_leaves_the_fewer_strips_the_more_passes() {
    let made = made(30);
    let all = made.verdict(&made.program(made.walls.iter().chain(&made.inner), |_| {}));
    assert!(all.faults.is_empty(), "{:#?}", shown(&all));
    assert!(all.deepest_cut > 50.0, "one layer as deep as the channel: {} mm", all.deepest_cut);
    assert!(all.max_overcut < 1e-3, "{} mm over", all.max_overcut);
    // The passes end slightly before the ends of the walls.
    assert!(all.max_undercut > 0.0 && all.max_undercut < 0.3, "{} mm under", all.max_undercut);
    assert!((all.min_blade_clearance - 0.5).abs() < 1e-3, "{}", all.min_blade_clearance);
    assert!((all.min_hub_clearance - 0.5).abs() < 1e-3, "{}", all.min_hub_clearance);
    let half = made.verdict(&made.program(made.walls.iter().chain(made.inner.iter().step_by(3)), |_| {}));
    let none = made.verdict(&made.program(&made.walls, |_| {}));
    assert!(all.uncovered.gap < 0.06, "{:?}", all.uncovered);
    assert!(half.uncovered.gap > all.uncovered.gap + 0.1, "{:?}", half.uncovered);
    assert!(none.uncovered.gap > half.uncovered.gap + 0.1, "{:?}", none.uncovered);
    // Beside the walls, the ball leaves a fillet up to a radius wide, whatever is cut between them.
    assert!(all.uncovered.fillet > 0.05 && all.uncovered.fillet < 0.25, "{:?}", all.uncovered);
    assert!((half.uncovered.fillet - all.uncovered.fillet).abs() < 0.05, "{:?}", half.uncovered);
    assert!(all.uncovered.no_axis < 0.01, "{:?}", all.uncovered);
}

#[test]
fn a_holder_that_comes_into_stock_is_found_and_one_above_cut_stock_is_not() {
    let mut made = made(30);
    let middle: Vec<Place> = made.inner[15][60..140].to_vec();
    // With a long cutter, the holder stays far above the part.
    let long = made.verdict(&made.program([&middle], |_| {}));
    assert_eq!(count(&long, FaultKind::HolderInStock), 0, "{:#?}", shown(&long));
    // In the middle of the channel, the holder of the short cutter clears the blades, but not the stock.
    made.tool.overhang = 25.0;
    let short = made.verdict(&made.program([&middle], |_| {}));
    assert!(count(&short, FaultKind::HolderInStock) > 0, "{:#?}", shown(&short));
    // After a long cutter has cleared the channel, there is no stock to collide with.
    made.tool.overhang = 90.0;
    let mut program = made.program(made.walls.iter().chain(&made.inner), |_| {});
    made.tool.overhang = 25.0;
    let again = made.program([&middle], |_| {});
    program.tools.push(again.tools[0].clone());
    program.tools[1].number = 2;
    program.moves.extend(again.moves.into_iter().map(|m| Move { tool: Some(1), ..m }));
    let after = made.verdict(&program);
    assert_eq!(count(&after, FaultKind::HolderInStock), 0, "{:#?}", shown(&after));
}

#[test]
fn a_flank_that_skims_stock_beside_it_is_no_deep_cut() {
    let mut made = made(3);
    let middle: Vec<Place> = made.inner[1][60..140].to_vec();
    let first = made.program([&middle], |_| {});
    // Where the first cutter has been, a wider one cuts no more than a wall of stock on both sides of it.
    let mut deep_cuts_of_wider = |by: f64| {
        let narrow = made.tool.clone();
        (made.tool.diameter, made.tool.corner_radius) = (narrow.diameter + by, 0.5 * (narrow.diameter + by));
        let second = made.program([&middle], |_| {});
        made.tool = narrow;
        let mut program = first.clone();
        program.tools.push(ClTool { number: 2, ..second.tools[0].clone() });
        program.moves.extend(second.moves.into_iter().map(|m| Move { tool: Some(1), ..m }));
        let read = read_apt_bytes("flank.apt", write_apt(&program).as_bytes()).expect("readable");
        let verdict = verify_flank(&made.workpiece, &made.setup, &read, &Monitor::default()).expect("judged");
        let begin = read.moves.iter().find(|step| step.tool == Some(1)).expect("a move").line;
        let is_deep =
            |fault: &&vanecut::verify::Fault| fault.kind == FaultKind::TooDeep && fault.line > begin;
        (verdict.faults.iter().filter(is_deep).count(), verdict.faults.len())
    };
    let (skims, all) = deep_cuts_of_wider(0.03);
    assert_eq!(skims, 0, "0.015 mm on each side are below what the floor resolves");
    assert!(all > 0, "the first cutter goes down to the floor at once");
    let (cuts, _) = deep_cuts_of_wider(0.5);
    assert!(cuts > 3, "{cuts}: 0.25 mm on each side are cut");
}

#[test]
fn stock_of_a_channel_that_is_not_cut_stands_in_the_way() {
    let made = made(3);
    let pitch = made.workpiece.part.pitch();
    let dip = |turn: f64| {
        made.program(&made.inner, |moves| {
            let (tip, axis) = made.inner[1][100];
            let (tip, axis) = (rotate_z(&tip, turn), rotate_vector_z(&axis, turn));
            for up in [150.0, 5.0, 150.0] {
                let at = Move { motion: Motion::Rapid, tip: tip + axis * up, axis, tool: Some(0), line: 0 };
                moves.push(at);
            }
        })
    };
    let cut = made.verdict(&dip(0.0));
    assert!(cut.faults.is_empty(), "{:#?}", shown(&cut));
    let uncut = made.verdict(&dip(pitch));
    // Down and up again.
    let depths: Vec<f64> = uncut
        .faults
        .iter()
        .filter(|fault| fault.kind == FaultKind::RapidInStock)
        .filter_map(|fault| fault.value)
        .collect();
    assert_eq!(depths.len(), 2, "{:#?}", shown(&uncut));
    assert!(depths.iter().all(|depth| (3.0..=4.0).contains(depth)), "up to the radius: {depths:?}");
}

#[test]
fn gouges_are_found_also_between_positions() {
    let made = made(0);
    // One position moved into the wall by 0.1 mm.
    let deep = made.program(&made.walls[..1], |moves| {
        let k = moves.len() / 2;
        let along = (moves[k + 1].tip - moves[k - 1].tip).normalize();
        let across = along.cross(&moves[k].axis).normalize();
        let wall = made.workpiece.channel.full.walls[0].side().point(0.5, 0.1);
        let towards = if across.dot(&(wall - moves[k].tip)) > 0.0 { across } else { -across };
        moves[k].tip += towards * 0.1;
    });
    let verdict = made.verdict(&deep);
    assert!((verdict.max_overcut - 0.1).abs() < 0.01, "{} mm over", verdict.max_overcut);
    assert!((1..=3).contains(&verdict.faults.len()), "{:#?}", shown(&verdict));
    assert!(verdict.faults.iter().all(|f| f.kind == FaultKind::BladeAllowance), "{:#?}", shown(&verdict));
    // Every position is correct, but straight moves between distant ones cut the convex wall.
    let over: Vec<f64> = made
        .walls
        .iter()
        .map(|wall| {
            let sparse: Vec<Place> = wall.iter().copied().step_by(25).collect();
            made.verdict(&made.program([&sparse], |_| {})).max_overcut
        })
        .collect();
    assert!(over.iter().copied().fold(0.0, f64::max) > 0.2, "{over:?}");
    // One position lowered into the hub's allowance.
    let low = made.program(&made.walls[..1], |moves| {
        let k = moves.len() / 2;
        let axis = moves[k].axis;
        moves[k].tip -= axis * 0.2;
    });
    let verdict = made.verdict(&low);
    assert!(verdict.min_hub_clearance < 0.35, "{}", verdict.min_hub_clearance);
    assert!(count(&verdict, FaultKind::HubAllowance) > 0, "{:#?}", shown(&verdict));
}

#[test]
fn a_cutter_that_comes_too_near_to_an_edge_between_two_positions_is_found() {
    let made = small();
    let side = made.workpiece.channel.full.walls[0].side();
    let clearance =
        |tip: Point, axis: Vector| made.workpiece.finished.blade_clearance(&made.tool.placed(tip, axis));
    // Steps of 1 mm across the leading edge, nearest to it at two thirds.
    for v in [0.3, 0.5, 0.7] {
        let (edge, behind) = (side.point(0.0, v), side.point(0.5, v));
        let axis = (side.point(0.0, v + 0.1) - edge).normalize();
        let across = axis.cross(&(edge - behind)).normalize();
        let ahead = across.cross(&axis);
        let (mut near, mut far) = (0.0, 2.0);
        for _ in 0..40 {
            let middle = 0.5 * (near + far);
            let is_near = clearance(edge + ahead * middle, axis) < 0.07;
            *if is_near { &mut near } else { &mut far } = middle;
        }
        let tip = edge + ahead * far;
        let pass = [-1.0, -0.65, 0.35].map(|way| (tip + across * way, axis)).to_vec();
        let at = |k: i32| clearance(pass[1].0 + across * 0.001 * f64::from(k), axis);
        let sampled = (0..=1000).map(at).fold(f64::INFINITY, f64::min);
        let ends = at(0).min(at(1000));
        assert!(sampled < 0.071 && ends > 0.145, "{sampled} mm between ends with {ends} mm");
        let verdict = made.verdict(&made.program([&pass], |_| {}));
        assert!((verdict.min_blade_clearance - sampled).abs() < 1e-3, "{sampled}: {verdict:?}");
        assert!(count(&verdict, FaultKind::BladeAllowance) > 0, "{:#?}", shown(&verdict));
    }
}

#[test]
fn a_short_tool_runs_its_holder_into_the_part() {
    let mut made = made(0);
    made.tool.overhang = 15.0;
    let verdict = made.verdict(&made.program(&made.walls, |_| {}));
    assert!(count(&verdict, FaultKind::HolderCollision) > 0, "{:#?}", shown(&verdict));
}

#[test]
fn rapids_through_stock_are_found_and_those_through_cut_space_allowed() {
    let made = made(3);
    let passes: Vec<&Vec<Place>> = vec![&made.inner[1], &made.inner[1]];
    let rapid = |pass: usize| {
        made.program(passes.iter().copied(), |moves| {
            let length = moves.len() / 2;
            let k = pass * length + length / 2;
            moves[k].motion = Motion::Rapid;
            moves[k + 1].motion = Motion::Rapid;
        })
    };
    // The first pass still has stock; the second, along the same path, has none.
    let first = made.verdict(&rapid(0));
    assert!(count(&first, FaultKind::RapidInStock) > 0, "{:#?}", shown(&first));
    let second = made.verdict(&rapid(1));
    assert!(second.faults.is_empty(), "{:#?}", shown(&second));
    // A rapid straight down into uncut stock.
    let down = made.verdict(&made.program(passes.iter().copied().take(1), |moves| {
        let k = moves.len() / 2;
        let (tip, axis) = (moves[k].tip, moves[k].axis);
        let at = |motion, up: f64| Move { motion, tip: tip + axis * up, axis, tool: Some(0), line: 0 };
        let mut begun = vec![at(Motion::Rapid, 150.0), at(Motion::Rapid, 0.0)];
        begun.append(&mut moves.split_off(k));
        *moves = begun;
    }));
    assert!(count(&down, FaultKind::RapidInStock) > 0, "{:#?}", shown(&down));
    // A rapid across, too low.
    let low = made.verdict(&made.program(passes.iter().copied(), |moves| {
        let length = moves.len() / 2;
        let up = moves[length - 1].axis * 149.0;
        moves[length - 1].tip -= up;
    }));
    assert!(!low.faults.is_empty(), "flies across the blank at the height of the floor");
}

#[test]
fn a_check_reports_its_progress_and_can_be_cancelled() {
    let made = made(3);
    let program = made.program(made.walls.iter().chain(&made.inner), |_| {});
    let check = |monitor: &Monitor| verify_flank(&made.workpiece, &made.setup, &program, monitor);
    let monitor = Monitor::default();
    check(&monitor).expect("can be judged");
    assert!(monitor.progress() >= 0.85, "{} at its end", monitor.progress());
    let mut cancelled = 0;
    for share in [0.0, 0.1, 0.5] {
        let monitor = Monitor::default();
        let ended = std::thread::scope(|scope| {
            let work = scope.spawn(|| check(&monitor));
            while monitor.progress() < share && !work.is_finished() {
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            monitor.cancel();
            work.join().expect("no panic")
        });
        match ended {
            Err(error) => assert_eq!(error, VerifyError::Cancelled(Cancelled)),
            // It was judged before the cancel came.
            Ok(_) => continue,
        }
        cancelled += 1;
    }
    assert!(cancelled > 1, "{cancelled} checks were cancelled");
}

#[test]
fn programs_after_others_are_judged_as_by_themselves() {
    let mut made = made(3);
    // The holder of a short cutter meets stock.
    made.tool.overhang = 25.0;
    // A quarter of each pass: walls first, then what lies between them.
    let middle = |pass: &Vec<Place>| pass[3 * pass.len() / 8..5 * pass.len() / 8].to_vec();
    let passes: Vec<Vec<Place>> = made.walls.iter().chain(&made.inner).map(middle).collect();
    // The first move of the pass between the walls that comes last in the first program, and of the one after
    // it.
    let starts = [2, 3].map(|count: usize| passes[..count].iter().map(|pass| pass.len() + 2).sum::<usize>());
    let program = |count: usize, change: &dyn Fn(&mut Vec<Move>)| made.program(&passes[..count], change);
    let programs = [
        program(3, &|_| {}),
        // Goes on where the first one ends.
        program(4, &|_| {}),
        program(4, &|moves| {
            moves[starts[0] + 30].motion = Motion::Rapid;
            moves.drain(starts[1] + 20..starts[1] + 30);
        }),
    ];
    let mut verifier = FlankVerifier::new(&made.workpiece, &made.setup);
    for program in &programs {
        let alone =
            verify_flank(&made.workpiece, &made.setup, program, &Monitor::default()).expect("can be judged");
        let after = verifier.verdict(program, &Monitor::default()).expect("can be judged");
        assert!(count(&alone, FaultKind::HolderInStock) > 0, "{:#?}", shown(&alone));
        assert_eq!(format!("{after:#?}"), format!("{alone:#?}"));
    }
}
