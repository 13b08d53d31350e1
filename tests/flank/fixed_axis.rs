//! Fixed axes of inner passes, compared with brute force on real parts.

use vanecut::cutting::drop_cutter::DepthSurface;
use vanecut::flank::fixed_axis::{
    AxisObstacle, FixedAxes, FixedAxisLimits, FixedAxisSearch, LayerContact, Unreachable,
};
use vanecut::geometry::{Circle, CutterSolid, Meridional, Vector};
use vanecut::part::{Channel, Impeller, Passage, SideProbe, Workpiece};
use vanecut::setup::{ClearanceSetup, Setup, Tool};

use super::parts::{cutter, part_at};

const LIMITS: FixedAxisLimits = FixedAxisLimits {
    hub_allowance: 0.5,
    blade_allowance: 0.5,
    stock_height: 3.0,
    max_tilt_rad: 60.0 * std::f64::consts::PI / 180.0,
    clearances: ClearanceSetup { shank: 1.0, holder: 1.0 },
};

/// Contacts `height` mm above the hub's allowance where the corner of the tool clears the walls: `count`
/// stations with up to `across` contacts each.
fn stations(
    part: &Impeller,
    channel: &Channel,
    passage: &Passage,
    tool: &Tool,
    height: f64,
    (s_from, s_to, count): (f64, f64, usize),
    across: usize,
) -> Vec<Vec<LayerContact>> {
    let sides: Vec<SideProbe> = channel.sides.iter().map(|side| SideProbe::new(side, 0.0, 1.0)).collect();
    (0..count)
        .map(|i| {
            let s = s_from + (s_to - s_from) * i as f64 / (count - 1) as f64;
            let hub = part.hub.at(s);
            let up = LIMITS.hub_allowance + height;
            let on_layer =
                Meridional { r: hub.point.r + up * hub.normal.r, z: hub.point.z + up * hub.normal.z };
            let walls = passage.wall_angles(part, s, 0.1).expect("walls");
            let contact = |j: usize| {
                let theta = walls[0] + (walls[1] - walls[0]) * (j as f64 + 0.5) / across as f64;
                LayerContact { point: on_layer.at_angle(theta), normal: hub.normal.direction_at_angle(theta) }
            };
            let free = |c: &LayerContact| {
                let centre = c.point + c.normal * tool.corner_radius;
                let reach = tool.radius() + LIMITS.blade_allowance + 0.3;
                sides.iter().all(|side| side.nearest_to_point(&centre).distance > reach)
            };
            (0..across).map(contact).filter(free).collect()
        })
        .collect()
}

/// Whether a cutter and a holder of twice its diameter clear blades, hub and stock, by exact distances.
fn is_free(workpiece: &Workpiece, tool: &Tool, contact: &LayerContact, cutter: &CutterSolid) -> bool {
    let Workpiece { part, blank, finished, .. } = workpiece;
    let hub = part.hub.curve();
    let off_hub = |up: f64, radius: f64| {
        let (t, d) = hub.project(Meridional::from_point(&(cutter.tip + cutter.axis * up)));
        d.abs() >= radius && (d > 0.0 || t <= 0.0 || t >= hub.length())
    };
    let holder = CutterSolid {
        tip: cutter.tip + cutter.axis * tool.overhang,
        radius: tool.diameter,
        corner_radius: 0.0,
        ..*cutter
    };
    // Samples the end face of the holder in rings against the stock of the current layer and below.
    let top = hub.project(Meridional::from_point(&contact.point)).1 + LIMITS.stock_height;
    let in_stock = |ring: usize, k: usize| {
        let circle = Circle::new(&holder.tip, &holder.axis, holder.radius * ring as f64 / 3.0);
        let at = Meridional::from_point(
            &circle.point_and_derivative((std::f64::consts::TAU * k as f64 / 36.0).sin_cos()).0,
        );
        blank.clearance(at, &mut None) < 0.0 && hub.project(at).1 < top
    };
    finished.clears(cutter, LIMITS.blade_allowance)
        && finished.clears(&holder, LIMITS.blade_allowance)
        && !(0..=3).any(|ring| (0..36).any(|k| in_stock(ring, k)))
        && (8..=24)
            .all(|k| off_hub(0.25 * f64::from(k) * tool.radius(), tool.radius() + LIMITS.hub_allowance))
        && off_hub(tool.overhang, tool.diameter)
        && finished.hub_clearance(cutter) >= LIMITS.hub_allowance - 1e-4
}

/// The minimum number of runs with axes of a grid of directions `step`, rad, apart, by brute force.
fn fewest_runs(workpiece: &Workpiece, tool: &Tool, stations: &[Vec<LayerContact>], step: f64) -> usize {
    let mut axes = Vec::new();
    let rings = (std::f64::consts::PI / step) as usize;
    for i in 0..=rings {
        let (sin, cos) = (std::f64::consts::PI * i as f64 / rings as f64).sin_cos();
        let around = ((std::f64::consts::TAU * sin / step).ceil() as usize).max(1);
        for j in 0..around {
            let (s, c) = (std::f64::consts::TAU * j as f64 / around as f64).sin_cos();
            axes.push(Vector::new(sin * c, sin * s, cos));
        }
    }
    let free = |contact: &LayerContact, axis: &Vector| {
        let tip = tool.tip_at_contact(&contact.point, &contact.normal, axis);
        axis.angle(&contact.normal) <= LIMITS.max_tilt_rad
            && is_free(workpiece, tool, contact, &tool.placed(tip, *axis))
    };
    let mut runs = 1;
    let mut left = axes.clone();
    for station in stations {
        let suits = |axis: &&Vector| station.iter().all(|contact| free(contact, axis));
        let next: Vec<Vector> = left.iter().filter(suits).copied().collect();
        left = if next.is_empty() {
            runs += 1;
            axes.iter().filter(suits).copied().collect()
        } else {
            next
        };
        assert!(!left.is_empty(), "the case has an axis everywhere");
    }
    runs
}

/// Checks that every contact is in exactly one run or reported, and that every cutter of every run is free.
fn check(
    workpiece: &Workpiece,
    tool: &Tool,
    layer: &DepthSurface,
    stations: &[Vec<LayerContact>],
) -> FixedAxes {
    let search = FixedAxisSearch::new(workpiece, tool, &LIMITS);
    let found = search.runs(stations, layer);
    for (k, station) in stations.iter().enumerate() {
        let named: Vec<usize> =
            found.unreachable.iter().filter(|u| u.station == k).flat_map(|u| u.contacts.clone()).collect();
        let runs: Vec<_> = found.runs.iter().filter(|r| (r.from..=r.to).contains(&k)).collect();
        assert!(runs.len() <= 1, "station {k} is in {} runs", runs.len());
        for (j, contact) in station.iter().enumerate() {
            if named.contains(&j) {
                continue;
            }
            let run = runs.first().unwrap_or_else(|| panic!("contact {j} of station {k} is left out"));
            assert!(run.axis.angle(&contact.normal) <= LIMITS.max_tilt_rad + 1e-9);
            let cutter = tool.placed(search.tip(contact, &run.axis, layer), run.axis);
            assert!(
                is_free(workpiece, tool, contact, &cutter),
                "station {k}, contact {j}: {cutter:?} meets something"
            );
            assert!(
                workpiece.finished.blade_clearance(&cutter) >= run.clearance - 1e-6,
                "run {run:?}, station {k}"
            );
        }
    }
    found
}

#[test]
fn no_finer_grid_does_with_fewer_runs() {
    let cases = [
        ("assets/parts/impeller532.toml", 6.0, (0.05, 1.0, 14), 0.0, 3),
        ("assets/parts/impeller9x9.toml", 4.0, (0.0, 0.3, 8), 3.0, 1),
    ];
    for (name, diameter, along, height, least) in cases {
        let workpiece = Setup::default().allowances.workpiece_of(part_at(name));
        let Workpiece { part, channel, .. } = &workpiece;
        let tool = cutter(diameter, 0.5 * diameter, 6.0 * diameter);
        let layer = DepthSurface::new(part.hub.curve(), LIMITS.hub_allowance + height + tool.corner_radius);
        let stations = stations(part, channel, &channel.full, &tool, height, along, 3);
        assert!(stations.iter().all(|s| !s.is_empty()), "contacts at every station");
        let found = check(&workpiece, &tool, &layer, &stations);
        assert!(found.unreachable.is_empty(), "{name}: {:?}", found.unreachable);
        let fewest = fewest_runs(&workpiece, &tool, &stations, 3f64.to_radians());
        assert!(found.runs.len() <= fewest, "{name}: {} runs, a fine grid needs {fewest}", found.runs.len());
        assert!(found.runs.len() >= least, "{name}: a case with {} runs tells nothing", found.runs.len());
    }
}

#[test]
fn runs_beside_a_splitter_are_free_with_cutters_of_all_shapes() {
    let workpiece = Setup::default().allowances.workpiece_of(part_at("assets/parts/impeller9x9.toml"));
    let Workpiece { part, channel, .. } = &workpiece;
    for (corner, height) in [(3.0, 0.0), (3.0, 6.0), (1.0, 3.0), (0.0, 3.0)] {
        let tool = cutter(6.0, corner, 40.0);
        let layer = DepthSurface::new(part.hub.curve(), LIMITS.hub_allowance + height + corner);
        for passage in &channel.beside_splitter {
            let stations = stations(part, channel, passage, &tool, height, (0.4, 1.0, 30), 6);
            let found = check(&workpiece, &tool, &layer, &stations);
            assert!(!found.runs.is_empty() && found.runs.len() < 6, "{:?}", found.runs);
            let lost: usize = found.unreachable.iter().map(|u| u.contacts.len()).sum();
            let all: usize = stations.iter().map(Vec::len).sum();
            assert!(
                4 * lost < all,
                "corner {corner}: {lost} of {all} contacts without axis: {:?}",
                found.unreachable
            );
        }
    }
}

#[test]
fn lifted_bottoms_stay_above_the_layer() {
    let workpiece = Setup::default().allowances.workpiece_of(part_at("assets/parts/impeller9x9.toml"));
    let Workpiece { part, channel, .. } = &workpiece;
    for corner in [0.0, 1.0, 3.0] {
        let tool = cutter(6.0, corner, 40.0);
        let layer = DepthSurface::new(part.hub.curve(), LIMITS.hub_allowance + 3.0 + corner);
        let search = FixedAxisSearch::new(&workpiece, &tool, &LIMITS);
        for station in stations(part, channel, &channel.full, &tool, 3.0, (0.1, 0.9, 9), 3) {
            for contact in station {
                for tilt in [0.0, 0.2, 0.5] {
                    let axis = (contact.normal + Vector::new(tilt, 0.0, 0.5 * tilt)).normalize();
                    let tip = search.tip(&contact, &axis, &layer);
                    let clearance = workpiece.finished.hub_clearance(&tool.placed(tip, axis));
                    assert!(clearance > LIMITS.hub_allowance + 3.0 - 1e-4, "corner {corner}: {clearance}");
                    let touching = tool.placed(tip, axis).distance(&contact.point);
                    assert!(
                        touching > -1e-6 && touching < 1.5,
                        "corner {corner}: {touching} from the contact"
                    );
                }
            }
        }
    }
}

#[test]
fn what_has_no_axis_is_named_with_its_reason() {
    let workpiece = Setup::default().allowances.workpiece_of(part_at("assets/parts/impeller9x9.toml"));
    let Workpiece { part, channel, .. } = &workpiece;
    // The holder is wider than the passage and begins far below the blade tips.
    let tool = Tool { overhang: 9.0, ..cutter(8.0, 4.0, 0.0) };
    let layer = DepthSurface::new(part.hub.curve(), LIMITS.hub_allowance + tool.corner_radius);
    let passage = &channel.beside_splitter[0];
    let stations = stations(part, channel, passage, &tool, 0.0, (0.4, 0.6, 6), 6);
    let found = check(&workpiece, &tool, &layer, &stations);
    assert!(!found.unreachable.is_empty(), "a holder in the passage");
    let holder = |u: &Unreachable| matches!(u.why, AxisObstacle::Holder | AxisObstacle::Stock);
    assert!(found.unreachable.iter().any(holder), "{:?}", found.unreachable);
}

/// Where only the holder is in the way an overhang is named, and 1 mm less does not do.
#[test]
fn the_overhang_that_frees_an_axis_is_the_least() {
    let part = part_at("assets/parts/pump6.toml");
    let workpiece = Setup::default().allowances.workpiece_of(part.clone());
    let mut short = cutter(6.0, 3.0, 14.0);
    short.assembly.holder = vec![[36.0, 44.0, 40.0]];
    let channel = Channel::from_part(&part);
    let passage = &channel.full;
    let contacts: Vec<LayerContact> =
        stations(&part, &channel, passage, &short, 0.0, (0.3, 0.8, 3), 1).into_iter().flatten().collect();
    let surface = DepthSurface::new(part.hub.curve(), LIMITS.hub_allowance + short.corner_radius);
    let search = FixedAxisSearch::new(&workpiece, &short, &LIMITS);
    let blocked: Vec<LayerContact> = contacts
        .into_iter()
        .filter(|contact| {
            search.blocked(contact, &surface).is_some_and(|why| why.is_freed_by_overhang(&short))
        })
        .collect();
    assert!(!blocked.is_empty(), "14 mm are too short");
    let is_free = |search: &FixedAxisSearch| blocked.iter().all(|c| search.blocked(c, &surface).is_none());
    let least = FixedAxisSearch::min_overhang(&workpiece, &short, &LIMITS, is_free).expect("a length");
    for (overhang, wanted) in [(least, true), (least - 1.0, false)] {
        let longer = Tool { overhang, ..short.clone() };
        assert_eq!(is_free(&FixedAxisSearch::new(&workpiece, &longer, &LIMITS)), wanted, "{overhang} mm");
    }
    let never = |_: &FixedAxisSearch| false;
    assert_eq!(FixedAxisSearch::min_overhang(&workpiece, &short, &LIMITS, never), None);
}

/// A thick shank above short flutes is named, not the holder far above it.
#[test]
fn a_shank_in_the_way_of_axes_is_named() {
    let part = part_at("assets/parts/pump6.toml");
    let workpiece = Setup::default().allowances.workpiece_of(part.clone());
    let mut thick = cutter(6.0, 3.0, 90.0);
    thick.assembly.flute_length = Some(7.0);
    thick.assembly.shank = vec![[26.0, 83.0]];
    thick.assembly.holder = vec![[30.0, 30.0, 40.0]];
    let channel = Channel::from_part(&part);
    let passage = &channel.full;
    let contacts = stations(&part, &channel, passage, &thick, 0.0, (0.3, 0.8, 3), 1);
    let surface = DepthSurface::new(part.hub.curve(), LIMITS.hub_allowance + thick.corner_radius);
    let search = FixedAxisSearch::new(&workpiece, &thick, &LIMITS);
    let named: Vec<AxisObstacle> =
        contacts.iter().flatten().filter_map(|contact| search.blocked(contact, &surface)).collect();
    let of_shank =
        named.iter().filter(|why| matches!(why, AxisObstacle::Shank | AxisObstacle::ShankInStock)).count();
    assert!(of_shank > 0, "{named:?}");
    assert!(!named.iter().any(|why| matches!(why, AxisObstacle::Holder | AxisObstacle::Stock)), "{named:?}");
    assert!(named.iter().all(|why| !why.is_freed_by_overhang(&thick)));
}
