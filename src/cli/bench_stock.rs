//! Benchmarks of the stock as a solid.

use std::sync::Arc;

use rayon::prelude::*;

use super::Failure;
use super::bench_measure::{build, build_sample, describe, median, print_row};
use super::stdout::print_stdout;
use crate::geometry::{Point, Vector};
use crate::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use crate::monitor::Monitor;
use crate::part::{Blank, Workpiece};
use crate::setup::{Setup, Tool};
use crate::stock::excess::Excess;
use crate::stock::solid::{
    FINE_RAYS, SolidBlank, SolidError, SolidMove, SolidProgram, SolidStock, SolidTool, SpanEnd, StockPlayer,
    StockSurface, ToolPose, TurnedOutline,
};
use crate::toolpath::ClProgram;

/// Outlet diameter of the wheel, mm, and spacing of the rays, mm.
const DIAMETER: f64 = 300.0;
const SPACING: f64 = 0.25;
/// Numbers of plunges for the growth.
const PLUNGES: [u32; 3] = [250, 500, 1000];
/// Moves of the flank program.
const FLANK_MOVES: usize = 15_000;
/// Rays across the wheel where a timeline is scrubbed, and where the memory is measured.
const SCRUB_RAYS: f64 = 500.0;
const FULL_RAYS: f64 = 800.0;
/// Jumps of the timeline.
const JUMPS: usize = 40;

/// Measures on the largest sample wheel, scaled.
///
/// # Errors
/// [`Failure::work`] when the sample is not valid, or its stock too large.
pub fn run() -> Result<(), Failure> {
    let wheel = describe("impeller532.toml", include_bytes!("../../assets/parts/impeller532.toml"))?;
    let part = build(&wheel)?;
    let scale = DIAMETER / (2.0 * part.rim_radius());
    let outline = TurnedOutline::of_blank(&part, &Blank::from_part(&part, 0.0)).scaled(scale);
    let blank = SolidBlank::Turned(outline);
    let whole = SolidStock::new(&blank, SPACING).map_err(Failure::of_work)?;
    print_row(
        "solid stock: blank of D 300 at 0.25 mm",
        median(|| {
            std::hint::black_box(SolidStock::new(&blank, SPACING).is_ok());
        }),
    )?;
    let tool = Tool {
        number: 1,
        diameter: 20.0,
        corner_radius: 0.0,
        insert_width: 7.0,
        overhang: 120.0,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: Default::default(),
    };
    let tools = [SolidTool::from_tool(&tool)];
    let mut last = None;
    for count in PLUNGES {
        let moves: Vec<SolidMove> = (0..count).map(|k| plunge(k, count, &part, scale)).collect();
        let mut seconds: Vec<f64> = Vec::new();
        for _ in 0..3 {
            let mut stock = whole.clone();
            let started = std::time::Instant::now();
            stock.make_moves(&tools, &moves, &Monitor::default()).map_err(Failure::of_work)?;
            seconds.push(started.elapsed().as_secs_f64());
            last = Some(stock);
        }
        seconds.sort_by(f64::total_cmp);
        print_row(&format!("  {count} plunges of D 20 into one pitch"), seconds[1])?;
    }
    let Some(stock) = last else { return Ok(()) };
    print_surface(&stock)?;
    print_memory("  memory of its rays", &stock)?;

    let (flank, workpiece) = flank_program()?;
    let flank_blank = SolidBlank::from_part(&workpiece.part, &workpiece.blank);
    let count = flank.count;
    let mut cut = SolidStock::new(&flank_blank, SPACING).map_err(Failure::of_work)?;
    let started = std::time::Instant::now();
    cut.make_moves(&flank.tools, &flank.moves, &Monitor::default()).map_err(Failure::of_work)?;
    print_row(&format!("  {count} moves of a flank plan of D 300"), started.elapsed().as_secs_f64())?;
    print_distances(&flank, &workpiece, &flank_blank)?;

    let at = |blank: &SolidBlank| SolidStock::new(blank, DIAMETER / SCRUB_RAYS).map_err(Failure::of_work);
    let coarse = [at(&blank)?, at(&flank_blank)?];
    let plunges = SolidProgram {
        tools: tools.to_vec(),
        moves: (0..1000).map(|k| plunge(k, 1000, &part, scale)).collect(),
        count: 1000,
    };
    for ((what, program), coarse) in
        [("1000 plunges", plunges), ("the flank program", flank)].into_iter().zip(coarse)
    {
        print_jumps(what, StockPlayer::new(program, coarse)).map_err(Failure::of_work)??;
    }

    let mut full = SolidStock::new(&blank, DIAMETER / FULL_RAYS).map_err(Failure::of_work)?;
    let moves: Vec<SolidMove> = (0..1000).map(|k| plunge(k, 1000, &part, scale)).collect();
    full.make_moves(&tools, &moves, &Monitor::default()).map_err(Failure::of_work)?;
    print_memory("  memory of the rays of the whole wheel at D/800", &full)
}

fn print_memory(what: &str, stock: &SolidStock) -> Result<(), Failure> {
    print_stdout(&format!("{what:<62} {:>7.1} MiB\n", stock.bytes() as f64 / (1 << 20) as f64))
}

fn print_surface(stock: &SolidStock) -> Result<(), Failure> {
    let mut triangles = 0;
    let seconds = median(|| triangles = StockSurface::from_stock(stock).triangles.len());
    print_row(&format!("  its surface: {triangles} triangles"), seconds)
}

/// Prints the time of jumps to places all over a program that was played once, and of the surface at its end.
fn print_jumps(what: &str, mut player: StockPlayer) -> Result<Result<(), Failure>, SolidError> {
    let monitor = Monitor::default();
    let count = player.program().count;
    player.at(count, &monitor)?;
    let mut seconds = Vec::with_capacity(JUMPS);
    for jump in 1..=JUMPS {
        // Multiples of the golden section visit all of the program, far from one jump to the next.
        let place = (jump as f64 * 0.618_033_988_749_895).fract();
        let started = std::time::Instant::now();
        player.at((place * count as f64) as usize, &monitor)?;
        seconds.push(started.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    let (stock, _) = player.at(count, &monitor)?;
    let rows = || {
        print_row(&format!("  a jump in {what} at D/500, median of {JUMPS}"), seconds[JUMPS / 2])?;
        print_row("    the slowest of them", seconds[JUMPS - 1])?;
        print_surface(stock)
    };
    Ok(rows())
}

/// Prints the time to colour the stock by its distance to the part, as the window does.
fn print_distances(flank: &SolidProgram, workpiece: &Workpiece, blank: &SolidBlank) -> Result<(), Failure> {
    let mut stock = SolidStock::new(blank, DIAMETER / FINE_RAYS).map_err(Failure::of_work)?;
    stock.make_moves(&flank.tools, &flank.moves, &Monitor::default()).map_err(Failure::of_work)?;
    let surface = StockSurface::from_stock(&stock);
    let excess = Excess::new(workpiece);
    let vertices = surface.points.iter().zip(&surface.cut_by);
    let cut: Vec<Point> = vertices.filter(|(_, by)| **by != SpanEnd::BLANK).map(|(p, _)| *p).collect();
    let seconds = median(|| {
        let distances: Vec<f64> = cut.par_iter().map(|point| excess.at(point)).collect();
        std::hint::black_box(distances);
    });
    print_row(&format!("  distance to the part of {} points of it at D/{FINE_RAYS}", cut.len()), seconds)
}

/// The first moves of the flank plan of the sample wheel with splitters, of D 300, with its workpiece.
fn flank_program() -> Result<(SolidProgram, Arc<Workpiece>), Failure> {
    let part = build_sample("impeller9x9.toml", include_bytes!("../../assets/parts/impeller9x9.toml"))?;
    let request = FlankRequest { part: part.clone(), setup: Setup::for_part(&part) };
    let planned = FlankJob::default().run(&request, &Monitor::default());
    let FlankOutcome { workpiece, setup, plan, .. } = planned.map_err(Failure::of_work)?;
    let program = ClProgram::of_flank(&part.name, &plan.tool, &plan.moves);
    let mut program = SolidProgram::new(&program, &setup).map_err(|fault| Failure::of_work(fault.error))?;
    program.moves.truncate(FLANK_MOVES);
    program.count = program.moves.len();
    Ok((program, workpiece))
}

/// Plunge `k` of `count`, spread over one pitch of the channel floor, inclined against it.
fn plunge(k: u32, count: u32, part: &crate::part::Impeller, scale: f64) -> SolidMove {
    let rows = f64::from(count).sqrt().ceil();
    let (row, column) = ((f64::from(k) / rows).floor() / rows, (f64::from(k) % rows) / rows);
    let s = 0.02 + 0.96 * row;
    let angle = part.pitch() * column;
    let floor = part.hub.point(s);
    let normal = part.hub.normal(s).direction_at_angle(angle);
    let across = Vector::new(-angle.sin(), angle.cos(), 0.0) * 0.3;
    let axis = (normal + across).normalize();
    let tip = floor.at_angle(angle) * scale + axis * 0.5;
    let pose = |up: f64| ToolPose { tip: tip + axis * up, axis };
    SolidMove { number: k, tool: 0, rapid: false, checks_core: true, from: pose(80.0), to: pose(0.0) }
}
