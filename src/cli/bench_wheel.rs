//! Scaled wheels for the growth benchmark.

use crate::geometry::{Meridional, Point, wrap_angle};
use crate::part::description::{BladeDescription, CurveDescription};
use crate::part::{Blade, BladeSide, Impeller, PartDescription};

/// Number of points of a meridional curve, and of span sections of a blade.
const CURVE_POINTS: usize = 160;
const SECTIONS: usize = 5;

/// A wheel like `part` whose hub is `factor` times as long and as wide, with channels of the same depth and
/// blades of the same thickness and lean, so that the cutters for `part` suit it.
pub fn scaled_wheel(part: &Impeller, factor: f64) -> PartDescription {
    let (hub, shroud) = (part.hub.s_range(), part.shroud.s_range());
    let (from, to) = (hub.0.max(shroud.0), hub.1.min(shroud.1));
    let s = |i: usize| from + (to - from) * i as f64 / (CURVE_POINTS - 1) as f64;
    let spread = |p: Meridional, foot: Meridional| Meridional {
        r: factor * foot.r + (p.r - foot.r),
        z: factor * foot.z + (p.z - foot.z),
    };
    let curve = |point: &dyn Fn(f64) -> Meridional| {
        CurveDescription::Points(
            (0..CURVE_POINTS).map(|i| spread(point(s(i)), part.hub.point(s(i)))).collect(),
        )
    };
    let moved = |p: &Point, (foot, theta): (Meridional, f64)| {
        let (here, aside) = (Meridional::from_point(p), wrap_angle(p.y.atan2(p.x) - theta));
        let there = spread(here, foot);
        there.at_angle(theta + aside * here.r / there.r)
    };
    let blade = |blade: &Blade| {
        let section = |side: &BladeSide, v: f64| -> Vec<Point> {
            side.u_knots().iter().map(|&u| moved(&side.point(u, v), camber_foot(blade, u))).collect()
        };
        let sections = |side: &BladeSide| -> Vec<Vec<Point>> {
            (0..SECTIONS).map(|j| section(side, j as f64 / (SECTIONS - 1) as f64)).collect()
        };
        let [suction, pressure] = [&blade.suction, &blade.pressure].map(sections);
        BladeDescription::Sections { suction, pressure, line: 0 }
    };
    PartDescription {
        name: part.name.clone(),
        hub: curve(&|s| part.hub.point(s)),
        shroud: curve(&|s| part.shroud.point(s)),
        blade_count: part.blade_count,
        main: blade(&part.main),
        splitters: part.splitters.iter().map(blade).collect(),
        hub_line: 0,
        shroud_line: 0,
        count_line: 0,
        notes: Vec::new(),
        roles_by_shape: false,
    }
}

/// The point midway between both sides of a blade at the hub, and its angle about Z (rad).
fn camber_foot(blade: &Blade, u: f64) -> (Meridional, f64) {
    let [a, b] = [&blade.suction, &blade.pressure].map(|side| side.point(u, 0.0));
    let (low, high) = (a.y.atan2(a.x), b.y.atan2(b.x));
    (Meridional::from_point(&a).lerp(Meridional::from_point(&b), 0.5), low + 0.5 * wrap_angle(high - low))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::part_file::read_part_bytes;
    use crate::part::Channel;

    fn wheel() -> Impeller {
        let text = include_bytes!("../../assets/parts/impeller532.toml");
        Impeller::build(&read_part_bytes("impeller532.toml", text, "toml").expect("readable"))
            .expect("an impeller")
    }

    #[test]
    fn a_spread_wheel_is_larger_and_its_channels_are_as_deep() {
        let part = wheel();
        for factor in [1.0, 2.5, 8.0] {
            let grown = Impeller::build(&scaled_wheel(&part, factor)).expect("an impeller");
            assert!(
                (grown.rim_radius() / part.rim_radius() / factor - 1.0).abs() < 0.02,
                "{}",
                grown.rim_radius()
            );
            Channel::from_part(&grown);
            for s in [0.1, 0.5, 0.9] {
                let depth = |part: &Impeller| part.hub.point(s).distance(part.shroud.point(s));
                assert!((depth(&grown) / depth(&part) - 1.0).abs() < 0.05, "{factor}: {}", depth(&grown));
                // Thickness and lean of the blades are unchanged.
                let side =
                    |part: &Impeller, v: f64| part.main.suction.point(s, v) - part.main.pressure.point(s, v);
                for v in [0.0, 1.0] {
                    let thick = side(&grown, v).norm() / side(&part, v).norm();
                    assert!((thick - 1.0).abs() < 0.1, "{factor}, {s}, {v}: {thick}");
                }
            }
        }
    }
}
