//! Roles of the bodies of a CAD model. The blades tell the wheel: they are the largest row of bodies that are
//! not of revolution, the hub is the body of revolution on which they stand, the cover the one over their
//! tips. Other bodies, such as shaft, nut and housing, are left out with a line. Names go before shapes.

use super::Role;
use super::TriangleMesh;
use super::meridional_area::{MeridionalArea, Neighbourhood};
use super::round::{SECTORS, is_round, radii, sectors_met};
use super::surface::MeshSurface;
use super::weld::NONE;
use crate::geometry::{Meridional, Point, Vector, norm2};

/// Shares of a blade's area and volume below which a body is a sliver.
const SLIVER: (f64, f64) = (0.12, 0.02);
/// Bodies of one row have areas that differ by this share at most, and centres that are apart in the
/// meridional plane by this share of their distance from the axis and of their size.
const ALIKE: (f64, f64) = (0.1, 0.02);
/// Share of the corners of a blade that lie where the largest blades are: splitters, and blades that differ.
const AMONG_BLADES: f64 = 0.6;
/// Share of the largest contact with blades from which on a body is part of hub or cover.
const STANDS_ON: f64 = 0.25;
/// Length beside the blades, as a share of that of the hub, from which on a body is a casing over them.
const OVER_TIPS: f64 = 0.4;
/// Share of the area of the largest body from which on a row of bodies are blades beside it: where that body
/// goes round the axis, and where it does not.
const BESIDE_ROUND: f64 = 0.05;
const BESIDE_OTHER: f64 = 0.25;
/// Number of [`SECTORS`] in which a body has corners that goes round the axis.
const ALL_ROUND: usize = SECTORS - 2;
/// Number of bodies that are named in a line: with their area, and without.
const NAMED: (usize, usize) = (4, 8);

/// A body of a CAD model.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Its surface, about Z.
    pub surface: MeshSurface,
    /// Its role, where its name or the user says it.
    pub role: Option<Role>,
    /// Whether the user says it.
    pub given: bool,
}

/// The bodies of a wheel.
pub struct WheelBodies {
    /// The hub.
    pub hub: MeshSurface,
    /// The cover, or a casing.
    pub shroud: Option<MeshSurface>,
    /// Blades with their roles.
    pub blades: Vec<(Role, MeshSurface)>,
}

/// What the bodies of a model are.
pub enum SortedBodies {
    /// Hub and blades are bodies of their own.
    Separate(WheelBodies),
    /// One of several bodies is hub and blades; with a line about the others.
    InOne(Body, String),
    /// No roles were found.
    Unknown,
}

struct MeasuredBody {
    body: Body,
    area: f64,
    volume: f64,
    /// Centre of its area: distance from the axis and height.
    centre: Meridional,
    turned: bool,
    goes_round: bool,
}

impl MeasuredBody {
    fn from_body(body: Body) -> Self {
        let s = &body.surface;
        let (mut area, mut centre) = (0.0, Vector::zeros());
        for t in 0..s.triangles.len() {
            area += s.area(t);
            centre += s.centre(t).coords * s.area(t);
        }
        // An open surface has no volume.
        let volume = s.signed_volume().map_or(f64::INFINITY, f64::abs);
        let centre = Meridional::from_point(&Point::from(centre / f64::max(area, 1e-300)));
        let (turned, goes_round) = (is_round(s), sectors_met(s, 0.0) >= ALL_ROUND);
        Self { area, volume, centre, turned, goes_round, body }
    }

    fn is_alike(&self, other: &Self) -> bool {
        let apart = norm2(self.centre.r - other.centre.r, self.centre.z - other.centre.z);
        (self.area - other.area).abs() <= ALIKE.0 * self.area
            && apart <= ALIKE.1 * (self.centre.r + self.area.sqrt())
    }

    fn is_blade_by_name(&self) -> bool {
        matches!(self.body.role, Some(Role::Blade | Role::Splitter))
    }

    fn is_sliver_beside(&self, blade: &Self) -> bool {
        let solid = blade.volume.is_finite();
        self.area < SLIVER.0 * blade.area || (solid && self.volume < SLIVER.1 * blade.volume)
    }
}

/// The row of the largest blades: bodies alike about the axis. Those with the role of a blade go first.
fn largest_row(bodies: &[MeasuredBody]) -> Vec<usize> {
    let named = bodies.iter().any(|b| b.body.role == Some(Role::Blade));
    let may_be = |b: &MeasuredBody| match named {
        true => b.body.role == Some(Role::Blade),
        false => b.is_blade_by_name() || (b.body.role.is_none() && !b.turned),
    };
    let mut rows: Vec<Vec<usize>> = Vec::new();
    for k in (0..bodies.len()).filter(|&k| may_be(&bodies[k])) {
        match rows.iter_mut().find(|row| bodies[k].is_alike(&bodies[row[0]])) {
            Some(row) => row.push(k),
            None => rows.push(vec![k]),
        }
    }
    let weight = |row: &[usize]| row.iter().map(|&k| bodies[k].area).sum::<f64>();
    rows.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    let Some(first) = rows.first() else { return Vec::new() };
    let is_row_beside = |row: &&Vec<usize>| {
        // A single body round the axis is a volute, or a wheel in one body beside bolts; another one a
        // bracket, or the only blade in the file.
        let (least, share) = if bodies[first[0]].goes_round { (2, BESIDE_ROUND) } else { (3, BESIDE_OTHER) };
        row.len() >= least && weight(row) > share * weight(first)
    };
    let beside = rows.iter().find(is_row_beside).filter(|_| first.len() == 1);
    beside.unwrap_or(first).clone()
}

/// Names of bodies for a line, the first few of them.
fn listed_names<'a>(names: impl Iterator<Item = &'a MeasuredBody>, measure: bool) -> String {
    let names: Vec<String> = names
        .map(|b| match measure {
            true => format!("`{}` ({:.2} mm² of surface)", b.body.name, b.area),
            false => format!("`{}`", b.body.name),
        })
        .collect();
    let count = names.len().min(if measure { NAMED.0 } else { NAMED.1 });
    let more = if names.len() > count { format!(" and {} more", names.len() - count) } else { String::new() };
    format!("{}{more}", names[..count].join(", "))
}

/// Bodies that may be whole wheels, although most of their surface is of revolution, as that of a wide wheel
/// with low blades is: those beside which the largest `row` of other bodies is small. The largest comes
/// first.
fn wheels_in_one(bodies: &[MeasuredBody], row: &[usize]) -> Vec<usize> {
    let row: f64 = row.iter().map(|&k| bodies[k].area).sum();
    let may_be = |k: &usize| {
        let b = &bodies[*k];
        b.turned && b.goes_round && b.body.role.is_none() && row < BESIDE_ROUND * b.area
    };
    let mut wheels: Vec<usize> = (0..bodies.len()).filter(may_be).collect();
    wheels.sort_by(|a, b| bodies[*b].area.total_cmp(&bodies[*a].area));
    wheels
}

/// A line about the bodies that are left out beside a wheel.
fn line_about_others(bodies: &[MeasuredBody], wheel: usize) -> String {
    let others = bodies.iter().enumerate().filter(|(k, _)| *k != wheel).map(|(_, b)| b);
    format!("left out beside `{}`: {}", bodies[wheel].body.name, listed_names(others, false))
}

/// Finds the roles of bodies; `is_wheel` tries whether one is a whole wheel. Lines about those left out, and
/// about names that cannot be meant, are added to `notes`.
pub fn sort_bodies(
    bodies: Vec<Body>,
    is_wheel: impl Fn(&Body) -> bool,
    notes: &mut Vec<String>,
) -> SortedBodies {
    let bodies: Vec<MeasuredBody> = bodies.into_iter().map(MeasuredBody::from_body).collect();
    let row = largest_row(&bodies);
    let mut wheel = wheels_in_one(&bodies, &row).into_iter().find(|&k| is_wheel(&bodies[k].body));
    if let [alone] = row[..]
        && bodies[alone].goes_round
        && !bodies[alone].is_blade_by_name()
    {
        wheel = wheel.or(Some(alone));
    }
    if let Some(wheel) = wheel {
        let note = line_about_others(&bodies, wheel);
        let one = bodies.into_iter().nth(wheel);
        return one.map_or(SortedBodies::Unknown, |one| SortedBodies::InOne(one.body, note));
    }
    let Some(&first) = row.first() else { return SortedBodies::Unknown };
    let Some(area) = MeridionalArea::from_blade(&bodies[first].body.surface) else {
        return SortedBodies::Unknown;
    };
    let median = {
        let mut by_area = row.clone();
        by_area.sort_by(|a, b| bodies[*a].area.total_cmp(&bodies[*b].area));
        by_area[by_area.len() / 2]
    };
    let is_unnamed_part = |b: &MeasuredBody| b.body.role.is_none() && !b.turned;
    let is_sliver = |b: &MeasuredBody| is_unnamed_part(b) && b.is_sliver_beside(&bodies[median]);
    let is_blade = |(k, b): (usize, &MeasuredBody)| {
        row.contains(&k)
            || b.is_blade_by_name()
            || (is_unnamed_part(b) && !is_sliver(b) && area.share_of(&b.body.surface) >= AMONG_BLADES)
    };
    let blades: Vec<bool> = bodies.iter().enumerate().map(is_blade).collect();
    let Some((hub, cover)) = hub_and_cover(&bodies, &blades, &area, notes) else {
        return SortedBodies::Unknown;
    };

    let slivers: Vec<&MeasuredBody> =
        bodies.iter().zip(&blades).filter(|(b, blade)| !**blade && is_sliver(b)).map(|(b, _)| b).collect();
    if !slivers.is_empty() {
        notes.push(format!(
            "left out as too small for a blade: {}",
            listed_names(slivers.iter().copied(), true)
        ));
    }
    let mut beside = (0..bodies.len())
        .filter(|k| !blades[*k] && !hub.contains(k) && !cover.contains(k) && !is_sliver(&bodies[*k]))
        .map(|k| &bodies[k])
        .peekable();
    if beside.peek().is_some() {
        notes.push(format!(
            "left out, as no blade stands on them and they are not between or over the blades: {}",
            listed_names(beside, false)
        ));
    }
    let joined = |of: &[usize]| joined(of.iter().map(|&k| &bodies[k].body.surface));
    let (hub, shroud) = (joined(&hub), (!cover.is_empty()).then(|| joined(&cover)));
    let role = |b: &Body| if b.role == Some(Role::Splitter) { Role::Splitter } else { Role::Blade };
    let blades = bodies
        .into_iter()
        .zip(blades)
        .filter(|(_, blade)| *blade)
        .map(|(b, _)| (role(&b.body), b.body.surface))
        .collect();
    SortedBodies::Separate(WheelBodies { hub, shroud, blades })
}

/// The bodies of the hub, and those of the cover; `None` where no body of revolution is a hub.
fn hub_and_cover(
    bodies: &[MeasuredBody],
    blades: &[bool],
    area: &MeridionalArea,
    notes: &mut Vec<String>,
) -> Option<(Vec<usize>, Vec<usize>)> {
    let may_be = |k: &usize| {
        let b = &bodies[*k];
        !blades[*k] && b.body.role.map_or(b.turned, |role| matches!(role, Role::Hub | Role::Shroud))
    };
    let round: Vec<usize> = (0..bodies.len()).filter(may_be).collect();
    let surfaces: Vec<&MeshSurface> = round.iter().map(|&k| &bodies[k].body.surface).collect();
    let beside: Vec<(usize, Neighbourhood)> =
        round.iter().copied().zip(area.neighbourhoods(&surfaces)).collect();

    // What names and the user say, as far as the blades allow it. The user is not doubted.
    let said = |role: Role, is_met: &dyn Fn(&Neighbourhood) -> bool, notes: &mut Vec<String>| {
        let named = || beside.iter().filter(|(k, _)| bodies[*k].body.role == Some(role));
        let doubted = named().find(|(k, n)| !bodies[*k].body.given && !is_met(n));
        let kept = named().filter(|(k, n)| bodies[*k].body.given || is_met(n)).map(|(k, _)| *k);
        let kept: Vec<usize> = kept.collect();
        if let Some((k, _)) = doubted.filter(|_| kept.is_empty()) {
            let what = if role == Role::Hub { "no blade stands on it" } else { "it is not over the blades" };
            notes.push(format!(
                "`{}` is not the {} that its name says: {what}",
                bodies[*k].body.name,
                role.name()
            ));
        }
        kept
    };
    let mut hub = said(Role::Hub, &|n| n.touching > 0, notes);
    let mut cover = said(Role::Shroud, &|n| n.beside > 0, notes);

    let most = beside.iter().map(|(_, n)| n.touching).max().unwrap_or(0);
    let is_said = |k: usize| hub.contains(&k) || cover.contains(&k);
    let stands = |n: &Neighbourhood| n.touching > 0 && n.touching as f64 >= STANDS_ON * most as f64;
    let mut touched: Vec<&(usize, Neighbourhood)> =
        beside.iter().filter(|(k, n)| stands(n) && !n.only_at_rim && !is_said(*k)).collect();
    // The hub is nearest to the axis.
    let inner = |k: usize| radii(&bodies[k].body.surface).0;
    touched.sort_by(|(a, _), (b, _)| inner(*a).total_cmp(&inner(*b)));
    if hub.is_empty() {
        match touched.first() {
            Some((k, _)) => hub.push(*k),
            // Blades over a gap: the bodies of revolution are hub and cover if there are no others.
            None if most == 0 && beside.len() <= 2 => {
                let mut all: Vec<usize> = beside.iter().map(|(k, _)| *k).filter(|k| !is_said(*k)).collect();
                all.sort_by(|a, b| inner(*a).total_cmp(&inner(*b)));
                let mut all = all.into_iter();
                hub.push(all.next()?);
                cover.extend(all.next());
            }
            None => return None,
        }
    }
    let length = |n: &Neighbourhood, k: usize| if hub.contains(&k) { 0 } else { n.beside };
    if cover.is_empty() {
        let of_hub = beside.iter().filter(|(k, _)| hub.contains(k)).map(|(_, n)| n.touching).max();
        let enough =
            |n: &Neighbourhood| stands(n) || n.beside as f64 >= OVER_TIPS * of_hub.unwrap_or(0).max(1) as f64;
        let over = beside.iter().filter(|(k, n)| !hub.contains(k) && !n.only_at_rim && enough(n));
        // What blades touch goes before what is over a gap.
        let over = over.max_by_key(|(k, n)| (stands(n), length(n, *k)));
        cover.extend(over.map(|(k, _)| *k));
    }
    Some((hub, cover))
}

/// Several surfaces as one; their faces stay distinct.
fn joined<'a>(surfaces: impl Iterator<Item = &'a MeshSurface>) -> MeshSurface {
    let surfaces: Vec<&MeshSurface> = surfaces.collect();
    if let [one] = surfaces[..] {
        return one.clone();
    }
    let (mut mesh, mut faces) = (TriangleMesh::default(), Vec::new());
    for surface in surfaces {
        let first = faces.iter().filter(|face| **face != NONE).max().map_or(0, |last: &u32| last + 1);
        let number = |face: &u32| if *face == NONE { NONE } else { face + first };
        faces.extend(surface.faces.iter().map(number));
        mesh.append(&TriangleMesh { points: surface.points.clone(), triangles: surface.triangles.clone() });
    }
    MeshSurface::of_faces(&mesh, faces)
}
