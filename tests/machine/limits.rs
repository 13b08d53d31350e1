//! Positions beyond the limits of the axes and near the pole, against scans of all positions of the axes.

use vanecut::geometry::{Point, Vector, wrap_angle};
use vanecut::machine::{LimitFault, MachineTool, NEAR_POLE_RAD};

use super::programs::{MACHINES, machine};

/// A direction `tilt` from Z, at `around` about it, rad.
fn direction(tilt: f64, around: f64) -> Vector {
    Vector::new(tilt.sin() * around.cos(), tilt.sin() * around.sin(), tilt.cos())
}

/// Whether some rotary positions within the limits, on a fine grid, hold the tool within `close` of `axis`.
fn scan_reaches(machine: &MachineTool, axis: &Vector, close: f64) -> bool {
    let step = close / 2.0;
    let values = |i: usize| {
        let (low, high) = machine.rotary[i].limits.unwrap_or((0.0, std::f64::consts::TAU));
        let count = ((high - low) / step).ceil() as usize;
        (0..=count).map(move |k| low + (high - low) * k as f64 / count as f64)
    };
    values(1).any(|b| values(0).any(|a| machine.tool_axis(&[a, b]).angle(axis) < close))
}

#[test]
fn a_direction_is_at_fault_where_no_positions_within_the_limits_hold_it() {
    for name in MACHINES {
        let mut machine = machine(name);
        machine.rotary[1].limits = Some((-0.4, 0.7));
        let (mut within, mut beyond) = (0, 0);
        for k in 0..60 {
            let axis = direction(0.02 + 0.045 * f64::from(k), 2.4 * f64::from(k));
            match machine.limit_fault(&axis, &[], 200.0) {
                None => {
                    assert!(scan_reaches(&machine, &axis, 0.03), "{name}: {axis:?} is not reached");
                    within += 1;
                }
                Some(fault) => {
                    // What lies within the grid's spacing of the limit may be found by the scan.
                    if fault.excess().is_none_or(|excess| excess > 0.1) {
                        assert!(!scan_reaches(&machine, &axis, 0.02), "{name}: {axis:?} is reached; {fault}");
                        beyond += 1;
                    }
                }
            }
        }
        assert!(within > 5 && beyond > 5, "{name}: {within} within, {beyond} beyond");
    }
}

#[test]
fn the_excess_is_what_the_limit_lacks() {
    let mut ac = machine("ac-trunnion");
    ac.rotary[1].limits = Some((-0.1, 0.3));
    let fault = ac.limit_fault(&direction(0.5, 1.0), &[], 200.0).expect("beyond");
    assert!((fault.excess().unwrap() - 0.2).abs() < 1e-9, "{fault}");
    assert!(fault.to_string().starts_with("A would have to be 28.65°, 11.46° beyond"), "{fault}");
    ac.rotary[1].limits = Some((-0.1, 0.5 + 1e-9));
    assert_eq!(ac.limit_fault(&direction(0.5, 1.0), &[], 200.0), None);

    let tips = [Point::new(10.0, 20.0, 30.0), Point::new(10.0, 20.0, 90.0)];
    let axis = direction(0.4, 1.0);
    let angles = {
        let (solutions, _) = ac.solve(&axis);
        solutions.iter().map(|s| [s.first.unwrap(), s.second]).find(|a| ac.rotary[1].allows(a[1])).unwrap()
    };
    let highest = tips.map(|tip| ac.joints(&tip, &angles, 200.0)[2]).into_iter().fold(0.0, f64::max);
    ac.linear[2].limits.1 = highest - 7.0;
    let fault = ac.limit_fault(&axis, &tips, 200.0).expect("beyond");
    assert!(matches!(fault, LimitFault::Beyond { letter: 'Z', is_rotary: false, .. }), "{fault:?}");
    assert!((fault.excess().unwrap() - 7.0).abs() < 1e-6, "{fault}");
    assert_eq!(
        machine("nutating-table").limit_fault(&direction(2.0, 0.3), &[], 200.0).unwrap().excess(),
        None
    );
}

#[test]
fn near_the_pole_the_first_axis_turns_ten_times_as_much_as_the_tool() {
    for name in MACHINES {
        let machine = machine(name);
        for (share, is_near) in [(0.5, true), (0.98, true), (1.05, false), (4.0, false)] {
            let tilt = share * NEAR_POLE_RAD;
            let (a, b) = (direction(tilt, 1.0), direction(tilt, 1.001));
            assert!((machine.pole_angle(&a) - tilt).abs() < 1e-9, "{name}");
            let first = |axis: &Vector| machine.solve(axis).0[0].first.unwrap();
            let ratio = wrap_angle(first(&b) - first(&a)).abs() / a.angle(&b);
            assert_eq!(ratio > 10.0, is_near, "{name}: {ratio} at {:.2}°", tilt.to_degrees());
        }
    }
}
