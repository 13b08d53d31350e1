//! Plans one section of a wheel with a tool of its own instead of the built-in library:
//! `cargo run --release --example own_tools -- PART.toml`.

use std::error::Error;
use std::path::Path;

use vanecut::io::part_file::read_part;
use vanecut::io::setup_file::read_setup_bytes;
use vanecut::job::{PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::AxisPolicy;

/// Lengths in mm, feed rates in mm/min, angles in degrees; all other keys keep their defaults.
const SETUP: &str = r"
[stock]
hub_allowance = 0.8
[[tool]]
number = 7
diameter = 16.0
corner_radius = 0.8
insert_width = 6.0
overhang = 120.0
plunge_feed = 250.0
spindle = 1500
[plunge]
step = 5.0
[[plunge.section]]
tool = 7
from = 1.0
to = 0.6
";

fn main() -> Result<(), Box<dyn Error>> {
    let part = std::env::args().nth(1).ok_or("usage: own_tools PART.toml")?;
    let part = Impeller::build(&read_part(Path::new(&part))?)?;
    let setup = read_setup_bytes("own_tools", SETUP.as_bytes())?;
    let request = PlanRequest {
        part: part.into(),
        setup,
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 256,
    };
    let outcome = run(&request, &Monitor::default())?;
    let plan = &outcome.after.plan;
    for (index, section) in plan.sections.iter().enumerate() {
        let count = plan.positions.iter().filter(|position| position.section == index).count();
        println!(
            "s {:.2} to {:.2}: {count} plunges with D {}",
            section.from, section.to, section.tool.diameter
        );
    }
    Ok(())
}
