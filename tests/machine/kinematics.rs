//! The general solver against closed forms of LinuxCNC's kinematics modules (`xyzac-trt-kins`,
//! `xyzbc-trt-kins`, `5axiskins`, `maxkins`), rewritten from their formulas; and its own inverse.

use vanecut::geometry::{Point, Vector, wrap_angle};
use vanecut::machine::{AxisSide, MachineTool, RotaryAxis};

use super::programs::{MACHINES, machine};

/// Deterministic numbers in [-1, 1) (a linear congruential generator, Knuth's MMIX).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1u64 << 52) as f64) - 1.0
    }
}

/// Joints from tip, tilt and C, both rad.
type ClosedForm = fn([f64; 3], f64, f64) -> [f64; 3];

const ROT: [f64; 3] = [3.0, -4.0, 7.0];
const OFFSET: f64 = 20.0;
const HEIGHT: f64 = 130.0;
const PIVOT: f64 = 250.0;

fn xyzac([x, y, z]: [f64; 3], a: f64, c: f64) -> [f64; 3] {
    let ([x, y, z], (sa, ca), (sc, cc)) = ([x - ROT[0], y - ROT[1], z - ROT[2]], a.sin_cos(), c.sin_cos());
    [
        cc * x - sc * y + ROT[0],
        sc * ca * x + cc * ca * y - sa * z - ca * OFFSET + sa * HEIGHT + OFFSET + ROT[1],
        sc * sa * x + cc * sa * y + ca * z - sa * OFFSET - ca * HEIGHT + HEIGHT + ROT[2],
    ]
}

fn xyzbc([x, y, z]: [f64; 3], b: f64, c: f64) -> [f64; 3] {
    let ([x, y, z], (sb, cb), (sc, cc)) = ([x - ROT[0], y - ROT[1], z - ROT[2]], b.sin_cos(), c.sin_cos());
    [
        cc * cb * x - sc * cb * y + sb * z - cb * OFFSET - sb * HEIGHT + OFFSET + ROT[0],
        sc * x + cc * y + ROT[1],
        -cc * sb * x + sc * sb * y + cb * z + sb * OFFSET - cb * HEIGHT + HEIGHT + ROT[2],
    ]
}

fn bc_head([x, y, z]: [f64; 3], b: f64, c: f64) -> [f64; 3] {
    [x - PIVOT * b.sin() * c.cos(), y - PIVOT * b.sin() * c.sin(), z - PIVOT + PIVOT * b.cos()]
}

fn b_head_c_table([x, y, z]: [f64; 3], b: f64, c: f64) -> [f64; 3] {
    let (r, theta) = (x.hypot(y), y.atan2(x) - c);
    [r * theta.cos() - PIVOT * b.sin(), r * theta.sin(), z - PIVOT + PIVOT * b.cos()]
}

fn rotary(letter: char, side: AxisSide, direction: [f64; 3], point: [f64; 3]) -> RotaryAxis {
    let mut axis = machine("ac-trunnion").rotary[0].clone();
    axis.letter = letter;
    axis.side = side;
    axis.direction = Vector::from(direction);
    axis.point = Point::from(Vector::from(point));
    axis.limits = None;
    axis
}

/// A machine of two rotary axes whose gauge point is the tip, part at machine zero.
fn of_axes(first: RotaryAxis, second: RotaryAxis) -> MachineTool {
    let mut machine = machine("ac-trunnion");
    machine.rotary = [first, second];
    machine.part.origin = Point::origin();
    machine
}

#[test]
fn joints_agree_with_linuxcnc() {
    let table = |letter, direction, point| rotary(letter, AxisSide::Table, direction, point);
    let head = |letter, direction| rotary(letter, AxisSide::Head, direction, [0.0, 0.0, PIVOT]);
    let beside = |offset: [f64; 3]| [ROT[0] + offset[0], ROT[1] + offset[1], ROT[2] + offset[2]];
    let c_table = || table('C', [0.0, 0.0, 1.0], ROT);
    let cases: [(MachineTool, ClosedForm, &str); 4] = [
        (
            of_axes(c_table(), table('A', [1.0, 0.0, 0.0], beside([0.0, OFFSET, HEIGHT]))),
            xyzac,
            "xyzac-trt-kins",
        ),
        (
            of_axes(c_table(), table('B', [0.0, 1.0, 0.0], beside([OFFSET, 0.0, HEIGHT]))),
            xyzbc,
            "xyzbc-trt-kins",
        ),
        (of_axes(head('C', [0.0, 0.0, 1.0]), head('B', [0.0, -1.0, 0.0])), bc_head, "5axiskins"),
        (
            of_axes(table('C', [0.0, 0.0, -1.0], [0.0; 3]), head('B', [0.0, -1.0, 0.0])),
            b_head_c_table,
            "maxkins",
        ),
    ];
    for (machine, closed_form, name) in cases {
        let mut numbers = Numbers(7);
        for _ in 0..10_000 {
            let tip = [0; 3].map(|_| 100.0 * numbers.next());
            let (c, tilt) = ((179.0 * numbers.next()).to_radians(), (110.0 * numbers.next()).to_radians());
            let got = machine.joints(&Point::from(Vector::from(tip)), &[c, tilt], 0.0);
            let expected = closed_form(tip, tilt, c);
            let error = (Vector::from(got) - Vector::from(expected)).norm();
            assert!(error <= 1e-9, "{name}: {error} mm at {tip:?}, C {c}, tilt {tilt}");
            let back = machine.tip(&got, &[c, tilt], 0.0);
            assert!((back.coords - Vector::from(tip)).norm() <= 1e-9, "{name}");
        }
    }
}

/// Moving up the tool by the linear axes moves the tip along the axis: an independent way to the direction.
#[test]
fn the_tool_points_where_its_length_goes() {
    let mut numbers = Numbers(3);
    for name in MACHINES {
        let machine = machine(name);
        for _ in 0..200 {
            let angles = [3.0 * numbers.next(), 1.8 * numbers.next()];
            let joints = [100.0, -50.0, 300.0];
            let (long, short) = (machine.tip(&joints, &angles, 151.0), machine.tip(&joints, &angles, 150.0));
            assert!((short - long - machine.tool_axis(&angles)).norm() < 1e-9, "{name}");
        }
    }
}

#[test]
fn solutions_lead_to_their_direction() {
    let mut numbers = Numbers(11);
    for name in MACHINES {
        let machine = machine(name);
        let mut reached = 0;
        for _ in 0..10_000 {
            let axis = Vector::new(numbers.next(), numbers.next(), numbers.next());
            let Some(axis) = axis.try_normalize(0.05) else { continue };
            let (solutions, count) = machine.solve(&axis);
            // A nutating table reaches the half-sphere above the table, the others everything.
            assert_eq!(count > 0, name != "nutating-table" || axis.z >= 0.0, "{name} {axis}");
            reached += count;
            for solution in solutions.iter().take(count) {
                let back = machine.tool_axis(&[solution.first.unwrap(), solution.second]);
                assert!((back - axis).norm() < 1e-9, "{name}: {axis} {back}");
            }
            if count == 2 {
                let [a, b] = solutions.map(|s| [s.first.unwrap(), s.second]);
                let apart = wrap_angle(a[0] - b[0]).abs().max(wrap_angle(a[1] - b[1]).abs());
                assert!(apart > 1e-9, "{name}: both solutions of {axis} are one");
            }
        }
        assert!(reached > 9_000, "{name}");
    }
}

#[test]
fn poles_and_the_edge_of_the_reach() {
    for name in MACHINES {
        let machine = machine(name);
        let (solutions, count) = machine.solve(&Vector::z());
        assert_eq!((count, solutions[0].first), (1, None), "{name}: any C does at the pole");
        assert!(solutions[0].second.abs() < 1e-7, "{name}");
        // Just beside the pole both solutions are there again.
        let beside = Vector::new(1e-5, 0.0, 1.0).normalize();
        assert_eq!(machine.solve(&beside).1, 2, "{name}");
    }
    let nutating = machine("nutating-table");
    let flat = nutating.solve(&Vector::x());
    assert!(flat.1 >= 1 && (flat.0[0].second.abs().to_degrees() - 180.0).abs() < 1e-4, "{flat:?}");
    assert_eq!(nutating.solve(&Vector::new(1.0, 0.0, -0.01).normalize()).1, 0);
}

#[test]
fn machines_reach_as_far_as_their_second_axis_goes() {
    for (name, degrees) in [
        ("ac-trunnion", 120.0),
        ("bc-trunnion", 120.0),
        ("b-head-c-table", 110.0),
        ("bc-head", 110.0),
        ("nutating-table", 90.0),
    ] {
        let mut machine = machine(name);
        let found = machine.max_axis_tilt_rad().to_degrees();
        assert!((found - degrees).abs() < 1e-3, "{name}: {found}");
        // Upside down the tool would have to come through the table.
        machine.part.inlet_up = false;
        assert_eq!(machine.max_axis_tilt_rad(), 0.0, "{name}");
    }
}
