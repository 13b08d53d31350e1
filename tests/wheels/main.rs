//! Wheels that nobody has looked at: they open and are measured.

mod make;

use vanecut::assess::Assessment;
use vanecut::assess::passage::Place;
use vanecut::assess::reach::ReachLimits;
use vanecut::formats::part_file::read_part_bytes;
use vanecut::formats::write_native;
use vanecut::part::{Channel, Impeller};

use make::Wheel;

/// The part of a wheel, by way of its file.
fn open(wheel: &Wheel) -> Impeller {
    let name = &wheel.description.name;
    let text = write_native(&wheel.description);
    let description = read_part_bytes(&format!("{name}.toml"), text.as_bytes(), "toml")
        .expect("what is written is readable");
    Impeller::build(&description).unwrap_or_else(|e| panic!("{name} ({}): {e}", wheel.remarks))
}

#[test]
fn the_same_seed_makes_the_same_wheels() {
    for index in [2, 18] {
        let text = |seed: u64| write_native(&make::wheel(seed, index).description);
        assert_eq!(text(5), text(5));
        assert_ne!(text(5), text(6));
    }
}

#[test]
fn every_kind_of_wheel_opens() {
    for seed in 1..=4 {
        for index in 0..20 {
            open(&make::wheel(seed, index));
        }
    }
}

#[test]
fn no_cutter_is_wider_than_the_passage_it_stands_in() {
    let limits = ReachLimits { hub_allowance: 0.1, blade_allowance: 0.1, max_tilt: 0.5 };
    for index in 0..20 {
        let wheel = make::wheel(1, index);
        let (name, part) = (&wheel.description.name, open(&wheel));
        let channel = Channel::of(&part);
        let found = Assessment::of(&part, &channel, &[], &limits);
        let largest = found.largest_cutter();
        assert!(largest > 0.0 && largest.is_finite(), "{name}: largest cutter {largest}");
        for passage in &found.passages {
            let between = match passage.place {
                Place::Full => &channel.full,
                Place::BesideSuction => &channel.beside_splitter[0],
                Place::BesidePressure => &channel.beside_splitter[1],
            };
            let walls = |s: f64| between.wall_angles(&part, s, 0.0);
            for cutter in &passage.cutters {
                let place = format!("{name}, {:?} at s = {:.2}", passage.place, cutter.s);
                assert!(
                    cutter.diameter <= cutter.section_width + 1e-6,
                    "{place}: D {} in a passage {} wide",
                    cutter.diameter,
                    cutter.section_width
                );
                let [low, high] = walls(cutter.s).expect("walls where a cutter stands");
                let around = (high - low).abs() * part.hub.point(cutter.s).r;
                assert!(
                    cutter.section_width <= around + 1e-6,
                    "{place}: further apart than along the circumference"
                );
            }
        }
        let flat = name.ends_with("cylindrical");
        let turn = found.blades[0].shape.turn.to_degrees();
        assert!(!flat || turn < 3.0, "{name}: cylindrical blades turn by {turn}°");
    }
}
