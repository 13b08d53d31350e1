use std::path::Path;
use std::time::Instant;
use vanecut::{
    formats::part_file::read_part,
    monitor::Monitor,
    part::*,
    plunge::{sections::resolve, *},
};
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let t = Instant::now();
    let part = Impeller::build(&read_part(Path::new(&path)).unwrap()).unwrap();
    println!("open {:?}", t.elapsed());
    let channel = Channel::of(&part);
    let setup = resolve(&Setup::default(), &part, &channel).unwrap();
    println!("resolved {:?}", t.elapsed());
    for x in &setup.tools {
        println!("tool {} D{} w{}", x.number, x.diameter, x.insert_width);
    }
    for x in &setup.plunge.sections {
        println!("section {:?}", x);
    }
    let planner = Planner::new(&part, &channel, &setup);
    for policy in [AxisPolicy::Conventional, AxisPolicy::Monotone] {
        let t = Instant::now();
        let plan = planner.plan(policy, &Monitor::default()).unwrap();
        println!(
            "{policy:?} {:?} positions {} rounds {} settled {} dropped {}",
            t.elapsed(),
            plan.positions.len(),
            plan.rounds,
            plan.settled,
            plan.dropped.len()
        );
        for (i, s) in plan.sections.iter().enumerate() {
            let ps: Vec<_> = plan.positions.iter().filter(|p| p.section == i).collect();
            let n = ps.iter().filter(|p| p.contact.interferes()).count();
            let f = |g: &dyn Fn(&Position) -> f64| ps.iter().map(|p| g(p)).fold(f64::INFINITY, f64::min);
            println!(
                "  D{} {:.2}..{:.2} rows {} n {} interf {} maxdepth {:.3} blocked {} hub {:.6} blade {:.6} retract {:.4} alpha {:.1}..{:.1}",
                s.tool.diameter,
                s.from,
                s.to,
                s.rows,
                ps.len(),
                n,
                -f(&|p| -p.contact.depth),
                ps.iter().filter(|p| p.blocked.is_some()).count(),
                f(&|p| p.hub_clearance),
                f(&|p| p.blade_clearance),
                f(&|p| p.retract_clearance),
                f(&|p| p.alpha).to_degrees(),
                -f(&|p| -p.alpha).to_degrees()
            );
        }
        if std::env::args().nth(2).is_some() {
            for p in &plan.positions {
                println!(
                    "sec {} row {} s {:.3} al {:6.2} contact {:.3} {:.2} blk {:?} hub {:.4} blade {:.4}",
                    p.section,
                    p.row,
                    p.s,
                    p.alpha.to_degrees(),
                    p.contact.depth,
                    p.contact.area_share,
                    p.blocked,
                    p.hub_clearance,
                    p.blade_clearance
                );
            }
        }
    }
}
