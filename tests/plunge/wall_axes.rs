//! Axes beside a wall that bulges over the channel.

use vanecut::geometry::{Point, wrap_angle};
use vanecut::part::{BladeDescription, Impeller, Workpiece};
use vanecut::plunge::lane::Lane;
use vanecut::setup::Setup;

use super::disc::{cutter, disc};

/// Half the height of the blades, and how far they bulge there, mm.
const MIDDLE: f64 = 17.5;
const BULGE: f64 = 6.0;

/// A flat disc with radial blades that bulge over the channel half way up.
fn bulging_disc() -> Impeller {
    let side = |y: f64| {
        let section = |k: i32| {
            let z = -5.0 + 5.0 * f64::from(k);
            let bulge = BULGE * (1.0 - ((z - MIDDLE) / MIDDLE).powi(2)).max(-1.0);
            (0..=20).map(|k| Point::new(60.0 + 4.5 * f64::from(k), y + bulge, z)).collect()
        };
        (0..=9).map(section).collect()
    };
    let blade = BladeDescription::Sections { suction: side(1.5), pressure: side(-1.5), line: 0 };
    disc((35.0, 30.0), 8, blade, Vec::new())
}

#[test]
fn an_axis_turned_off_a_bulging_wall_gets_nearer_to_its_foot() {
    let part = bulging_disc();
    let stock = Setup::default().allowances;
    let workpiece = stock.workpiece_of(part);
    let Workpiece { part, channel, finished, .. } = &workpiece;
    let tool = cutter(10.0, 3.0);
    let lane = Lane::new(&workpiece, &channel.full, &tool, &stock);
    for s in [0.4, 0.6, 0.8] {
        let own = lane.wall_axis(0, s, s, None).expect("an axis along the wall");
        let off = lane.distance_from_plain(0, &own);
        assert!(off > 0.3 * tool.radius(), "the bulge keeps the cutter off: {off} mm at s = {s}");
        let [foot, _] = channel.full.wall_angles(part, s, 0.0).expect("walls");
        let radius = part.hub.point(s).r;
        let turn = lane.inward_sign(0) * 8.0 / part.shroud.point(s).r;
        let turned = lane.turned_wall_axis(0, (s, s), turn).expect("an axis turned off the wall");
        let from_foot = |theta: f64| wrap_angle(theta - foot).abs() * radius;
        let (before, after) = (from_foot(own.theta_hub), from_foot(turned.theta_hub));
        assert!(after < before - 1.0, "{after} mm from the foot, {before} mm along the wall, s = {s}");
        let (tip, axis) = lane.line(&turned);
        assert!(finished.clears(&tool.placed(tip, axis), stock.blade_allowance - 1e-6), "s = {s}");
    }
}
