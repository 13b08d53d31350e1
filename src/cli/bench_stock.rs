//! Benchmarks of the stock as a solid.

use super::bench::{build, describe, median, print_row};
use super::{Failure, print_stdout};
use crate::geometry::Vector;
use crate::monitor::Monitor;
use crate::part::Blank;
use crate::setup::Tool;
use crate::stock::solid::{
    SolidBlank, SolidMove, SolidStock, SolidTool, StockSurface, ToolPose, TurnedOutline,
};

/// Outlet diameter of the wheel, mm, and spacing of the rays, mm.
const DIAMETER: f64 = 300.0;
const SPACING: f64 = 0.25;
/// Numbers of plunges for the growth.
const PLUNGES: [u32; 3] = [250, 500, 1000];

/// Measures on the largest sample wheel, scaled.
///
/// # Errors
/// [`Failure::work`] when the sample is not valid, or its stock too large.
pub fn run() -> Result<(), Failure> {
    let wheel = describe("impeller532.toml", include_bytes!("../../assets/parts/impeller532.toml"))?;
    let part = build(&wheel)?;
    let scale = DIAMETER / (2.0 * part.rim_radius());
    let outline = TurnedOutline::of_blank(&part, &Blank::of(&part, 0.0)).scaled(scale);
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
    let tools = [SolidTool::of(&tool)];
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
    let mut triangles = 0;
    let seconds = median(|| triangles = StockSurface::of(&stock).triangles.len());
    print_row(&format!("  its surface: {triangles} triangles"), seconds)?;
    print_stdout(&format!(
        "{:<62} {:>7.1} MiB\n",
        "  memory of its rays",
        stock.bytes() as f64 / (1 << 20) as f64
    ))
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
    SolidMove { number: k, tool: 0, rapid: false, from: pose(80.0), to: pose(0.0) }
}
