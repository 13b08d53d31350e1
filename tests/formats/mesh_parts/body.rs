//! Wheels in one mesh without inner walls, as solid modellers export them: hub between the blades, rim,
//! sides, tips and trailing edges share corners. Fillets at the blade feet and a cover over the channels are
//! optional.

use std::f64::consts::TAU;

use vanecut::geometry::{Meridional, MeridionalCurve, Point, Vector, rotate_z};
use vanecut::mesh::TriangleMesh;
use vanecut::part::{BladeSide, Impeller};

/// Shape and fineness of a body.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Triangles along the blades.
    pub along: usize,
    /// Triangles across the channel.
    pub across: usize,
    /// Triangles from hub to tip.
    pub high: usize,
    /// Extent of the fillets along hub and blade, mm; 0: none.
    pub fillet: f64,
    /// Whether a cover joins the tips.
    pub cover: bool,
}

impl Default for Body {
    fn default() -> Self {
        Self { along: 120, across: 16, high: 16, fillet: 0.0, cover: false }
    }
}

/// Triangles along the arc of a fillet.
const ARC: usize = 8;

/// The patches of a body.
pub struct Patches {
    hub: TriangleMesh,
    cover: TriangleMesh,
    fillets: TriangleMesh,
    blades: TriangleMesh,
}

impl Patches {
    /// All patches in one mesh.
    pub fn whole(&self) -> TriangleMesh {
        let mut whole = self.hub.clone();
        [&self.cover, &self.fillets, &self.blades].into_iter().for_each(|mesh| whole.append(mesh));
        whole
    }

    /// Hub and blades separately; the fillets belong to the blades or to the hub.
    pub fn separate(&self, with_blades: bool) -> (TriangleMesh, Vec<TriangleMesh>) {
        let (mut hub, mut blades) = (self.hub.clone(), self.blades.clone());
        if with_blades { &mut blades } else { &mut hub }.append(&self.fillets);
        (hub, vec![blades])
    }

    /// Goes on upstream of the hub: along it, round an edge of `radius` mm, and towards the axis.
    pub fn add_collar(&mut self, part: &Impeller, body: &Body, radius: f64) {
        let curve = part.hub.curve();
        let foot = |side: &BladeSide| {
            let p = side.point(0.0, 0.0);
            (curve.project(Meridional::from_point(&p)).0, p.y.atan2(p.x))
        };
        let ((t, from), (_, to)) = (foot(&part.main.suction), foot(&part.main.pressure));
        let begin = curve.point(0.5 * t);
        let next = curve.point(0.5 * t + 1e-4);
        let (dr, dz) = ((begin.r - next.r) * 1e4, (begin.z - next.z) * 1e4);
        // Upstream, and from there towards the axis.
        let inwards = (-dz.abs(), dr * dz.signum());
        let length = 6.0 * radius;
        let row = |i: usize| -> Meridional {
            let (ahead, down) = match i {
                0..=8 => (length * i as f64 / 8.0, 0.0),
                9..=20 => {
                    let a = (i - 8) as f64 / 12.0 * std::f64::consts::FRAC_PI_2;
                    (length + radius * a.sin(), radius * (1.0 - a.cos()))
                }
                _ => (length + radius, radius + 0.1 * begin.r * (i - 20) as f64),
            };
            let r = begin.r + ahead * dr + down * inwards.0;
            Meridional { r, z: begin.z + ahead * dz + down * inwards.1 }
        };
        let width = (to - from + part.pitch()).rem_euclid(TAU.copysign(part.pitch()));
        let width = if part.pitch() < 0.0 && width > 0.0 { width - TAU } else { width };
        for k in 0..part.blade_count {
            let at = |j: usize| from + width * j as f64 / body.across as f64 + part.pitch() * k as f64;
            patch(&mut self.hub, 24, body.across, |i, j| row(24 - i).at_angle(at(j)));
        }
    }

    /// A ring of triangles from the tip of each blade to that of the next.
    pub fn join_blades(&mut self, part: &Impeller) {
        let points = self.blades.points.clone();
        let tip = |k: usize| {
            let wanted = rotate_z(&part.main.suction.point(0.5, 1.0), part.pitch() * k as f64);
            let nearest = points.iter().min_by(|a, b| (*a - wanted).norm().total_cmp(&(*b - wanted).norm()));
            *nearest.expect("a corner")
        };
        let mut ring = TriangleMesh::default();
        for k in 0..part.blade_count {
            let (from, to) = (tip(k), tip(k + 1));
            // Not a surface of revolution: the ring is inclined between the two tips.
            let between = rotate_z(&from, 0.5 * part.pitch()) + Vector::new(0.0, 0.0, 5.0);
            ring.triangles.push([0, 1, 2].map(|i| i + ring.points.len() as u32));
            ring.points.extend([from, to, between]);
        }
        self.blades.append(&ring);
    }
}

/// Adds a grid of (rows + 1) × (columns + 1) points.
fn patch(mesh: &mut TriangleMesh, rows: usize, columns: usize, at: impl Fn(usize, usize) -> Point) {
    // Each patch computes its own corners, which differ by rounding: the reader merges them.
    let first = mesh.points.len() as u32;
    for i in 0..=rows {
        mesh.points.extend((0..=columns).map(|j| at(i, j)));
    }
    let index = |i: usize, j: usize| first + (i * (columns + 1) + j) as u32;
    for i in 0..rows {
        for j in 0..columns {
            mesh.triangles.push([index(i, j), index(i + 1, j), index(i, j + 1)]);
            mesh.triangles.push([index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]);
        }
    }
}

/// A blade side at its hub or shroud end: where the surface there begins, and the fillet between them.
struct Foot<'a> {
    side: &'a BladeSide,
    curve: MeridionalCurve,
    /// v at this end and at the other end.
    ends: (f64, f64),
    /// Sign that makes du × n point out of the blade.
    outside: f64,
    fillet: f64,
}

impl<'a> Foot<'a> {
    fn new(side: &'a BladeSide, other: &BladeSide, curve: &MeridionalCurve, v: f64, fillet: f64) -> Self {
        let mut foot = Self { side, curve: curve.clone(), ends: (v, 1.0 - v), outside: 1.0, fillet };
        let apart = side.point(0.5, v) - other.point(0.5, v);
        foot.outside = foot.outwards(0.5).dot(&apart).signum();
        foot
    }

    fn place(&self, p: &Point) -> (f64, f64) {
        (self.curve.project(Meridional::from_point(p)).0, p.y.atan2(p.x))
    }

    /// Direction along hub or shroud away from the side; at the nose of a blade straight upstream.
    fn outwards(&self, u: f64) -> Vector {
        let (p, along, _) = self.side.derivatives(u, self.ends.0);
        let (t, angle) = self.place(&p);
        let tangent = self.curve.point(t + 1e-3).at_angle(angle) - self.curve.point(t - 1e-3).at_angle(angle);
        let round = Vector::new(-angle.sin(), angle.cos(), 0.0);
        if u == 0.0 {
            return -tangent.normalize();
        }
        let normal = tangent.cross(&round);
        along.cross(&normal).normalize() * self.outside
    }

    /// Point where the surface of hub or shroud begins beside the side.
    fn floor(&self, u: f64) -> Point {
        let p = self.side.point(u, self.ends.0);
        if self.fillet == 0.0 {
            return p;
        }
        let (t, angle) = self.place(&(p + self.outwards(u) * self.fillet));
        // The fillets end at the rim.
        let (rim, _) = self.place(&self.side.point(1.0, self.ends.0));
        self.curve.point(if u == 1.0 { rim } else { t.min(rim) }).at_angle(angle)
    }

    /// v at which the side itself begins.
    fn start(&self, u: f64) -> f64 {
        let (from, to) = self.ends;
        let length = (self.side.point(u, to) - self.side.point(u, from)).norm();
        from + (to - from) * self.fillet / length
    }

    /// Point on the fillet, a parabolic arc from the surface (0) to the side (1).
    fn arc(&self, u: f64, x: f64) -> Point {
        let (a, b, c) = (self.floor(u), self.side.point(u, self.ends.0), self.side.point(u, self.start(u)));
        let y = 1.0 - x;
        Point::from(a.coords * (y * y) + b.coords * (2.0 * x * y) + c.coords * (x * x))
    }
}

impl Body {
    /// The patches of a part's main blades and channels.
    pub fn built_on(&self, part: &Impeller) -> Patches {
        let Self { along, across, high, fillet, cover } = *self;
        let [mut hub, mut top, mut fillets, mut blades] = [(); 4].map(|()| TriangleMesh::default());
        let sides = [&part.main.suction, &part.main.pressure];
        let feet = |v: f64, curve: &MeridionalCurve, fillet: f64| {
            [0, 1].map(|k| Foot::new(sides[k], sides[1 - k], curve, v, fillet))
        };
        let lower = feet(0.0, part.hub.curve(), fillet);
        let upper = feet(1.0, part.shroud.curve(), if cover { fillet } else { 0.0 });
        let u = |i: usize| (i as f64 / along as f64).powi(2);
        // From the suction side of a blade to the pressure side of the next blade.
        let floor = |feet: &[Foot<'_>; 2], i: usize, j: usize| {
            let [(t0, a0), (t1, a1)] = [0, 1].map(|k| feet[k].place(&feet[k].floor(u(i))));
            let width = (a1 - a0 + part.pitch()).rem_euclid(TAU.copysign(part.pitch()));
            let width = if part.pitch() < 0.0 && width > 0.0 { width - TAU } else { width };
            let x = j as f64 / across as f64;
            feet[0].curve.point(t0 + (t1 - t0) * x).at_angle(a0 + width * x)
        };
        // Ahead of the blades.
        let nose = |feet: &[Foot<'_>; 2], i: usize, j: usize| {
            let p = floor(feet, 0, j);
            let (t, a) = feet[0].place(&p);
            if i == 8 { p } else { feet[0].curve.point(t * (0.5 + i as f64 / 16.0)).at_angle(a) }
        };
        for k in 0..part.blade_count {
            let turn = |p: Point| rotate_z(&p, part.pitch() * k as f64);
            patch(&mut hub, along, across, |i, j| turn(floor(&lower, i, j)));
            patch(&mut hub, 8, across, |i, j| turn(nose(&lower, i, j)));
            // Down the rim.
            patch(&mut hub, 2, across, |i, j| {
                let p = turn(floor(&lower, along, j));
                Point::new(p.x, p.y, p.z + 4.0 * i as f64)
            });
            let v = |side: usize, u: f64, j: usize| {
                let (from, to) = (lower[side].start(u), upper[side].start(u));
                from + (to - from) * j as f64 / high as f64
            };
            for (side, surface) in sides.into_iter().enumerate() {
                patch(&mut blades, along, high, |i, j| turn(surface.point(u(i), v(side, u(i), j))));
            }
            patch(&mut blades, 1, high, |i, j| turn(sides[i].point(1.0, v(i, 1.0, j))));
            if cover {
                patch(&mut top, along, across, |i, j| turn(floor(&upper, i, j)));
                patch(&mut top, 8, across, |i, j| turn(nose(&upper, i, j)));
            } else {
                patch(&mut blades, along, 1, |i, j| turn(sides[j].point(u(i), 1.0)));
            }
            for feet in [&lower, &upper].into_iter().filter(|feet| feet[0].fillet > 0.0) {
                for foot in feet {
                    let x = |j: usize| j as f64 / ARC as f64;
                    patch(&mut fillets, along, ARC, |i, j| turn(foot.arc(u(i), x(j))));
                }
                patch(&mut fillets, 1, ARC, |i, j| turn(feet[i].arc(1.0, j as f64 / ARC as f64)));
            }
        }
        Patches { hub, cover: top, fillets, blades }
    }
}
