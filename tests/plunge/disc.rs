//! Flat discs with radial blades, and the cutter for them.

use vanecut::geometry::Meridional;
use vanecut::part::{BladeDescription, CurveDescription, Impeller, PartDescription};
use vanecut::setup::Tool;

/// Radius of the rim, mm.
pub const RIM: f64 = 150.0;

/// A straight line of the meridional plane from (r, z) to (r, z), mm.
fn line(from: [f64; 2], to: [f64; 2]) -> CurveDescription {
    let point = |k: i32| {
        let x = f64::from(k) / 20.0;
        Meridional { r: from[0] + x * (to[0] - from[0]), z: from[1] + x * (to[1] - from[1]) }
    };
    CurveDescription::Points((0..=20).map(point).collect())
}

/// A disc with a flat hub from r = 40 to the rim and `count` main blades under a shroud that falls from
/// `heights.0` at r = 62 to `heights.1` at the rim, mm.
pub fn disc(
    heights: (f64, f64),
    count: usize,
    main: BladeDescription,
    splitters: Vec<BladeDescription>,
) -> Impeller {
    let description = PartDescription {
        name: "disc".to_owned(),
        hub: line([40.0, 0.0], [RIM, 0.0]),
        shroud: line([62.0, heights.0], [RIM, heights.1]),
        blade_count: count,
        main,
        splitters,
        hub_line: 0,
        shroud_line: 0,
        count_line: 0,
        notes: Vec::new(),
        roles_by_shape: false,
    };
    Impeller::build(&description).expect("an impeller")
}

/// A cutter with sharp corners, mm.
pub fn cutter(diameter: f64, insert_width: f64) -> Tool {
    Tool {
        number: 1,
        diameter,
        corner_radius: 0.0,
        insert_width,
        overhang: 80.0,
        plunge_feed: 400.0,
        spindle: 2000.0,
        assembly: Default::default(),
    }
}
