//! Lines about what was derived from meshes, or is left of them.

use super::sides::{SideCurve, SpanSection};
use crate::geometry::{Meridional, MeridionalCurve, Point};
use crate::part::{Blade, Impeller, Rotation, SideProbe};

/// Smallest wrap of a blade from which the sense of rotation is derived without a note, rad.
const CLEAR_WRAP: f64 = 0.1;
/// Smallest width of a ring of the hub past the trailing edge that is noted, as a share of its radius: a rim
/// may be chamfered or rounded.
const RING: f64 = 0.02;

/// Length by which a splitter begins ahead of the main blades for a note, as a share of that of the hub.
const AHEAD: f64 = 0.05;

/// Heights in the channel, as shares of its own, between which corners of a mesh are held against the sides:
/// beyond are fillets and rounded tips.
const BESIDE: std::ops::Range<f64> = 0.2..0.9;
/// Places along the sides between their edges, which coarse meshes tell less exactly.
const ALONG: std::ops::Range<f64> = 0.1..0.9;
/// Most corners that are.
const CORNERS: usize = 400;
/// Distance of a corner from both sides that is noted, as a share of the diameter.
const OFF: f64 = 1e-3;
/// The same of one at leading or trailing edge.
const OFF_AT_EDGE: f64 = 3e-3;
/// Heights at which the face of a blunt trailing edge is held against a corner, about the height of its
/// nearest place, and their distance.
const TAIL_HEIGHTS: i32 = 20;
const TAIL_STEP: f64 = 0.01;

/// The sense of rotation derived from a blade's wrap, with a note where the wrap is small.
pub fn sense_from_wrap(sections: &[SpanSection], inlet_up: bool) -> (Rotation, Option<String>) {
    let sides = || sections.iter().flat_map(|s| &s.sides);
    let wrap = sides().map(SideCurve::wrap_rad).sum::<f64>() / sides().count().max(1) as f64;
    let rotation = Rotation::about_z(-wrap, inlet_up);
    let note = (wrap.abs() < CLEAR_WRAP).then(|| {
        format!(
            "the blades wrap by only {:.1}°, so that the suction side is uncertain: assumed to turn \
             {rotation}, seen from the inlet; if that is wrong, give --rotation {}",
            wrap.abs().to_degrees(),
            rotation.reversed().name()
        )
    });
    (rotation, note)
}

/// A line about the ring that is left of a hub past the trailing edge of its blades.
pub fn ring_note(sections: &[SpanSection], hub: &MeridionalCurve) -> Option<String> {
    let ends = sections.first()?.sides.each_ref().map(|side| Meridional::from_point(&side.point(1.0)));
    let last = ends.map(|p| hub.project(p).0).into_iter().fold(0.0, f64::max);
    let (width, rim) = (hub.length() - last, hub.point(hub.length()).r);
    (width > RING * rim).then(|| {
        format!(
            "the hub goes on {width:.1} mm past the trailing edge, to r = {rim:.1} mm: this ring is not planned, \
             and the blank ends at the trailing edge; if it is larger, give it as a file"
        )
    })
}

/// A line about splitters that begin ahead of the main blades, hub and tip: the roles may be exchanged.
pub fn splitter_note(part: &Impeller) -> Option<String> {
    let hub = part.hub.curve();
    let (begins, least) = (|blade: &Blade, v: f64| blade.leading_edge_on(hub, v), AHEAD * hub.length());
    let is_ahead =
        |splitter: &Blade| [0.0, 1.0].iter().all(|&v| begins(splitter, v) < begins(&part.main, v) - least);
    part.splitters.iter().any(is_ahead).then(|| {
        "the splitters begin ahead of the main blades, where nothing is planned: check which of them are the \
         main blades, and give their roles"
            .to_owned()
    })
}

/// A line about sides of the main blade of `part` that leave the `corners` of its mesh: its sections were
/// misread somewhere.
pub fn sides_note(part: &Impeller, corners: &[Point]) -> Option<String> {
    let probes = [&part.main.suction, &part.main.pressure].map(|side| SideProbe::new(side, 0.0, 1.0));
    let is_beside = |p: &&Point| {
        let place = Meridional::from_point(p);
        let [low, high] = [&part.hub, &part.shroud].map(|path| path.curve().project(place).1.abs());
        BESIDE.contains(&(low / (low + high).max(1e-300)))
    };
    let stride = corners.len().div_ceil(CORNERS).max(1);
    let beside = corners.iter().step_by(stride).filter(is_beside);
    let size = 2.0 * part.rim_radius();
    let distances = beside.filter_map(|p| {
        let nearest = probes.each_ref().map(|probe| probe.nearest_to_point(p));
        let nearest = nearest.into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let (off, limit) = match nearest.u {
            u if ALONG.contains(&u) => (nearest.distance, OFF),
            u if u < ALONG.start => (nearest.distance, OFF_AT_EDGE),
            _ => (nearest.distance.min(off_tail(&part.main, nearest.v, p)), OFF_AT_EDGE),
        };
        (off > limit * size).then_some((off, p))
    });
    let (off, at) = distances.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let at = Meridional::from_point(at);
    Some(format!(
        "the sides of the main blade were not understood everywhere: they are {off:.2} mm off the file's surfaces \
         at z = {:.1}, r = {:.1} mm; do not cut this part before it is compared with the CAD model",
        at.z, at.r
    ))
}

/// Distance of a corner from the straight face between both sides at the trailing edge, about the height `v`,
/// mm.
fn off_tail(blade: &Blade, v: f64, corner: &Point) -> f64 {
    let off = |k: i32| {
        let v = (v + TAIL_STEP * f64::from(k)).clamp(0.0, 1.0);
        let [from, to] = [&blade.suction, &blade.pressure].map(|side| side.point(1.0, v));
        let across = to - from;
        let share = ((corner - from).dot(&across) / across.norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (from + across * share - corner).norm()
    };
    (-TAIL_HEIGHTS..=TAIL_HEIGHTS).map(off).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::part::{BladeDescription, CamberSpan, CurveDescription, PartDescription};

    /// A wheel of 240 mm with blades that wrap, along quarters of ellipses.
    fn wheel() -> PartDescription {
        let quarter = |r: f64, z: f64, long: f64, high: f64| {
            let at = |i: i32| f64::from(i) / 40.0 * std::f64::consts::FRAC_PI_2;
            let point = |a: f64| Meridional { r: r + long * (1.0 - a.cos()), z: z + high * a.sin() };
            CurveDescription::Points((0..=40).map(|i| point(at(i))).collect())
        };
        let span = |span: f64, degrees: f64| CamberSpan {
            span,
            leading_edge: 0.0,
            theta_leading_edge: 0.0,
            angle: vec![(0.0, degrees.to_radians()), (1.0, 40.0_f64.to_radians())],
            thickness: vec![(0.0, 3.0), (1.0, 2.5)],
        };
        PartDescription {
            name: "wheel".to_owned(),
            hub: quarter(30.0, -80.0, 90.0, 80.0),
            shroud: quarter(70.0, -80.0, 50.0, 58.0),
            blade_count: 7,
            main: BladeDescription::Camber { spans: vec![span(0.0, 20.0), span(1.0, 50.0)], line: 0 },
            splitters: Vec::new(),
            hub_line: 0,
            shroud_line: 0,
            count_line: 0,
            notes: Vec::new(),
            roles_by_shape: false,
        }
    }

    #[test]
    fn sides_that_leave_the_mesh_are_noted() {
        let part = Impeller::build(&wheel()).expect("an impeller");
        let places = (2..=8).flat_map(|i| [0.4, 0.6, 0.9].map(|v| (0.1 * f64::from(i), v)));
        let corners: Vec<Point> = places.map(|(u, v)| part.main.suction.point(u, v)).collect();
        assert_eq!(sides_note(&part, &corners), None);
        let moved = |way_mm: f64| {
            let mut corners = corners.clone();
            let p = corners[9];
            corners[9] += way_mm * Vector::new(-p.y, p.x, 0.0).normalize();
            sides_note(&part, &corners)
        };
        assert_eq!(moved(0.05), None);
        // Beyond the other side.
        for way_mm in [-12.0, 12.0] {
            let note = moved(way_mm).expect("it is far off");
            assert!(note.contains(" mm off the file's surfaces at z = "), "{note}");
        }
    }

    #[test]
    fn corners_ahead_of_the_leading_edge_are_noted_and_those_of_a_blunt_trailing_edge_are_not() {
        let part = Impeller::build(&wheel()).expect("an impeller");
        let at = |u: f64, ahead_mm: f64| {
            let (p, along, _) = part.main.suction.derivatives(u, 0.5);
            p - along.normalize() * ahead_mm
        };
        assert_eq!(sides_note(&part, &[at(0.0, 0.1)]), None);
        assert!(sides_note(&part, &[at(0.0, 4.0)]).is_some());
        let [from, to] = [&part.main.suction, &part.main.pressure].map(|side| side.point(1.0, 0.5));
        let middle = from + (to - from) * 0.5;
        assert!((to - from).norm() > 2.0);
        assert_eq!(sides_note(&part, &[middle]), None);
    }
    #[test]
    fn splitters_ahead_of_the_main_blades_are_noted() {
        let with_splitter = |main_from: f64, splitter_from: f64| {
            let beginning = |from: f64| {
                let BladeDescription::Camber { mut spans, line } = wheel().main else { panic!("a camber") };
                spans.iter_mut().for_each(|span| span.leading_edge = from);
                BladeDescription::Camber { spans, line }
            };
            let found = PartDescription {
                main: beginning(main_from),
                splitters: vec![beginning(splitter_from)],
                ..wheel()
            };
            splitter_note(&Impeller::build(&found).expect("an impeller"))
        };
        assert_eq!(with_splitter(0.0, 0.3), None);
        assert_eq!(with_splitter(0.0, 0.0), None);
        assert!(with_splitter(0.3, 0.0).is_some_and(|note| note.contains("begin ahead")));
    }
}
