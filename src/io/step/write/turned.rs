//! Hub body and shroud.

use super::instances::{ClampedKnots, Edge, EdgeUse, Instances};
use super::spline::generatrix;
use crate::geometry::{Meridional, MeridionalCurve};
use crate::io::step::surface::ON_AXIS;
use crate::part::body::body_outline;
use crate::part::{Blade, Flowpath, Impeller};

/// Number of intervals along a blade between the places that are looked at to find where its feet and tips
/// end, and share of the curve by which their surface goes on past them.
const FLOOR_PLACES: i32 = 200;
const BEYOND: f64 = 0.01;

/// A surface of revolution about Z, from inlet to outlet.
pub struct RevolvedSurface {
    /// Number of its instance.
    pub id: u32,
    /// Number of its curve, which lies in the half plane y = 0, x ≥ 0.
    curve: u32,
    /// First and last point of the curve.
    ends: [Meridional; 2],
    /// Their arc lengths, mm.
    extent: (f64, f64),
}

fn revolved(out: &mut Instances, curve: &MeridionalCurve, from: f64, to: f64) -> RevolvedSurface {
    let (knots, control) = generatrix(curve, from, to);
    let end = |p: Option<&[f64; 3]>| p.map_or_else(Meridional::default, |p| Meridional { r: p[0], z: p[2] });
    let ends = [end(control.first()), end(control.last())];
    let curve = out.curve(3, &control, &ClampedKnots { values: &knots, inner: 1 });
    let (origin, z) = (out.point([0.0; 3]), out.direction([0.0, 0.0, 1.0]));
    let axis = out.add(&format!("AXIS1_PLACEMENT('',#{origin},#{z})"));
    let id = out.add(&format!("SURFACE_OF_REVOLUTION('',#{curve},#{axis})"));
    RevolvedSurface { id, curve, ends, extent: (from, to) }
}

/// The surface of the hub, from its nose to the rim: on straight below the feet of `blades` that begin ahead
/// of its curve.
pub fn hub_surface(out: &mut Instances, part: &Impeller, blades: &[&Blade]) -> RevolvedSurface {
    let hub = &part.hub;
    let (first, _) = floor_extent(hub, blades, 0.0);
    revolved(out, hub.curve(), first, hub.arc_at(1.0))
}

/// The surface of the shroud.
pub fn shroud_surface(out: &mut Instances, part: &Impeller) -> RevolvedSurface {
    let shroud = &part.shroud;
    revolved(out, shroud.curve(), shroud.arc_at(shroud.wheel_from()), shroud.arc_at(1.0))
}

/// Arc lengths between which the surface below feet (`v` = 0) or above tips (`v` = 1) of `blades` goes: the
/// ends of the curve, or some way past those that blades go on past, mm.
fn floor_extent(path: &Flowpath, blades: &[&Blade], v: f64) -> (f64, f64) {
    let curve = path.curve();
    let (from, to) = (path.arc_at(path.wheel_from()), path.arc_at(1.0));
    let sides = blades.iter().flat_map(|blade| [&blade.suction, &blade.pressure]);
    let places = sides.flat_map(|side| {
        let place =
            move |k: i32| Meridional::from_point(&side.point(f64::from(k) / f64::from(FLOOR_PLACES), v));
        (0..=FLOOR_PLACES).map(move |k| curve.project_past_ends(place(k)).0)
    });
    let (first, last) = places.fold((from, to), |(a, b), t| (a.min(t), b.max(t)));
    let margin = BEYOND * (to - from);
    (
        if from - first < ON_AXIS { from } else { first - margin },
        if last - to < ON_AXIS { to } else { last + margin },
    )
}

/// The surface that the feet (`v` = 0) or tips (`v` = 1) of `blades` lie on: `own`, that of `path`, or where
/// they go on past its ends one that goes on straight there, too.
pub fn floor_surface(
    out: &mut Instances,
    (path, own): (&Flowpath, &RevolvedSurface),
    blades: &[&Blade],
    v: f64,
) -> u32 {
    let (first, last) = floor_extent(path, blades, v);
    if (first, last) == own.extent {
        return own.id;
    }
    revolved(out, path.curve(), first, last).id
}

/// A corner of an outline: its vertex, and its circle where it is off the axis.
#[derive(Clone, Copy)]
struct Corner {
    at: Meridional,
    vertex: u32,
    circle: Option<Edge>,
}

fn corner(out: &mut Instances, at: Meridional) -> Corner {
    let vertex = out.vertex([at.r, 0.0, at.z]);
    let circle = (at.r > ON_AXIS).then(|| out.circle(vertex, at.r, at.z));
    Corner { at, vertex, circle }
}

/// The face between two corners with a seam; `natural`: it faces to the right of the way from `a` to `b`.
fn band(
    out: &mut Instances,
    [a, b]: [Corner; 2],
    seam: Edge,
    surface: u32,
    natural: bool,
    sense: bool,
) -> u32 {
    let mut edges: Vec<EdgeUse> = Vec::with_capacity(4);
    edges.extend(a.circle.map(|c| (c, true)));
    edges.push((seam, true));
    edges.extend(b.circle.map(|c| (c, false)));
    edges.push((seam, false));
    if !natural {
        edges = reversed(edges);
    }
    out.face(&[edges], surface, sense)
}

fn reversed(mut edges: Vec<EdgeUse>) -> Vec<EdgeUse> {
    edges.reverse();
    edges.iter_mut().for_each(|(_, forward)| *forward = !*forward);
    edges
}

/// The hub with rim, back, bore and nose ring: a solid.
pub fn hub_body(out: &mut Instances, part: &Impeller, hub: &RevolvedSurface) -> u32 {
    let [_, rim_back, bore_back, bore_nose, _] = body_outline(part);
    let [first, last] = hub.ends;
    let outline = [first, last, rim_back, bore_back, Meridional { r: bore_nose.r, z: first.z }];
    let area: f64 = (0..outline.len())
        .map(|k| {
            let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
            a.r * b.z - b.r * a.z
        })
        .sum();
    // The outside is to the right of the way round where that is counter-clockwise. The hub's curve does not
    // cross the rest of the outline, so that its chord has the same sense.
    let natural = area > 0.0;
    let corners: Vec<Corner> = outline.iter().map(|p| corner(out, *p)).collect();
    let seam = out.edge(corners[0].vertex, corners[1].vertex, hub.curve);
    let mut faces = vec![band(out, [corners[0], corners[1]], seam, hub.id, natural, natural)];
    for k in 1..corners.len() {
        let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
        let (dr, dz) = (b.at.r - a.at.r, b.at.z - a.at.z);
        if dr.abs().max(dz.abs()) < ON_AXIS || a.at.r.max(b.at.r) < ON_AXIS {
            continue;
        }
        let outwards = if natural { Meridional { r: dz, z: -dr } } else { Meridional { r: -dz, z: dr } };
        if dz.abs() > dr.abs() {
            let ends = [a, b].map(|c| (c.vertex, [c.at.r, 0.0, c.at.z].into()));
            let seam = out.straight_edge(ends[0], ends[1]);
            let frame = out.frame([0.0; 3], [0.0, 0.0, 1.0]);
            let radius = super::instances::real(a.at.r);
            let cylinder = out.add(&format!("CYLINDRICAL_SURFACE('',#{frame},{radius})"));
            faces.push(band(out, [a, b], seam, cylinder, natural, outwards.r > 0.0));
        } else {
            let frame = out.frame([0.0, 0.0, a.at.z], [0.0, 0.0, outwards.z.signum()]);
            let plane = out.add(&format!("PLANE('',#{frame})"));
            let uses = [(a, natural), (b, !natural)];
            // The outer circle comes first.
            let mut loops: Vec<(f64, Vec<EdgeUse>)> =
                uses.iter().filter_map(|(c, way)| Some((c.at.r, vec![(c.circle?, *way)]))).collect();
            loops.sort_by(|a, b| b.0.total_cmp(&a.0));
            let loops: Vec<Vec<EdgeUse>> = loops.into_iter().map(|(_, edges)| edges).collect();
            faces.push(out.face(&loops, plane, true));
        }
    }
    out.solid("hub", &faces)
}

/// The shroud as a sheet.
pub fn shroud_sheet(out: &mut Instances, shroud: &RevolvedSurface) -> u32 {
    let [a, b] = shroud.ends.map(|p| corner(out, p));
    let seam = out.edge(a.vertex, b.vertex, shroud.curve);
    let face = band(out, [a, b], seam, shroud.id, true, true);
    let shell = out.add(&format!("OPEN_SHELL('',(#{face}))"));
    out.add(&format!("SHELL_BASED_SURFACE_MODEL('shroud',(#{shell}))"))
}
