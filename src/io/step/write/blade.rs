//! Blades: both sides as their own B-spline surfaces, tip and foot on shroud and hub, a blunt trailing edge
//! straight between the sides.

use super::instances::{ClampedKnots, Edge, EdgeUse, Instances};
use super::spline::control_points;
use crate::geometry::{Meridional, Point};
use crate::part::{Blade, BladeSide, Impeller};

/// Both sides meet at the trailing edge where they are nowhere further apart than this, mm.
const MEETING: f64 = 1e-4;

/// Control net of a side by rows along the blade, and its knots.
struct Net {
    degree_across: usize,
    rows: Vec<Vec<[f64; 3]>>,
    along: Vec<f64>,
    across: Vec<f64>,
}

impl Net {
    /// The side is a C2 cubic along the blade, and linear or a C1 cubic across it: its control curves across
    /// are those of Bézier pieces without the inner end points, which double knots imply.
    fn from_side(side: &BladeSide) -> Self {
        let along = side.u_knots().to_vec();
        let across = side.stations().to_vec();
        let ruled = side.is_ruled();
        let mut curves: Vec<Vec<[f64; 3]>> = Vec::new();
        let mut curve = |v: f64, reach: f64| {
            curves.push(control_points(&along, |u| {
                let (p, _, slope) = side.derivatives(u, v);
                (p + slope * (reach / 3.0)).into()
            }));
        };
        let last = across.len() - 1;
        curve(across[0], 0.0);
        if !ruled {
            for k in 0..last {
                let h = across[k + 1] - across[k];
                curve(across[k], h);
                curve(across[k + 1], -h);
            }
        }
        curve(across[last], 0.0);
        let rows = (0..along.len() + 2).map(|i| curves.iter().map(|c| c[i]).collect()).collect();
        Self { degree_across: if ruled { 1 } else { 3 }, rows, along, across }
    }

    fn along(&self) -> ClampedKnots<'_> {
        ClampedKnots { values: &self.along, inner: 1 }
    }

    fn across(&self) -> ClampedKnots<'_> {
        ClampedKnots { values: &self.across, inner: 2 }
    }

    /// Control points across the blade at its leading (0) or trailing edge (1).
    fn end(&self, trailing: bool) -> &[[f64; 3]] {
        self.rows.get(if trailing { self.rows.len() - 1 } else { 0 }).map_or(&[], Vec::as_slice)
    }

    fn surface(&self, out: &mut Instances) -> u32 {
        out.surface([3, self.degree_across], &self.rows, [&self.along(), &self.across()])
    }

    /// The edge on foot or tip.
    fn long_edge(&self, out: &mut Instances, tip: bool, from: u32, to: u32) -> Edge {
        let line: Vec<[f64; 3]> =
            self.rows.iter().filter_map(|row| if tip { row.last() } else { row.first() }).copied().collect();
        let curve = out.curve(3, &line, &self.along());
        out.edge(from, to, curve)
    }

    /// The edge at leading or trailing edge, foot to tip.
    fn short_edge(&self, out: &mut Instances, trailing: bool, from: u32, to: u32) -> Edge {
        let curve = out.curve(self.degree_across, self.end(trailing), &self.across());
        out.edge(from, to, curve)
    }
}

/// A blade as a solid; `floors` are the instances of the surfaces of hub and shroud.
pub fn blade_body(out: &mut Instances, part: &Impeller, blade: &Blade, floors: [u32; 2], name: &str) -> u32 {
    let sides = [&blade.suction, &blade.pressure];
    let nets = sides.map(Net::from_side);
    let at = |which: usize, u: f64, v: f64| sides[which].point(u, v);
    let apart = |v: f64| (at(0, 1.0, v) - at(1, 1.0, v)).norm();
    let blunt = (0..=16).any(|k| apart(f64::from(k) / 16.0) > MEETING);
    // A blunt trailing edge may run out at foot or tip.
    let meets = [0.0, 1.0].map(|v| apart(v) <= MEETING);
    // Vertices: foot and tip, at the leading edge and at the trailing edge of either side.
    let mut vertex = |which: usize, u: f64, k: usize| out.vertex(at(which, u, k as f64).into());
    let leading = [0, 1].map(|k| vertex(0, 0.0, k));
    let suction_end = [0, 1].map(|k| vertex(0, 1.0, k));
    let pressure_end = [0, 1].map(|k| if meets[k] { suction_end[k] } else { vertex(1, 1.0, k) });
    let ends = [suction_end, pressure_end];
    let long: [[Edge; 2]; 2] = std::array::from_fn(|which| {
        [false, true].map(|tip| {
            let k = usize::from(tip);
            nets[which].long_edge(out, tip, leading[k], ends[which][k])
        })
    });
    let nose = nets[0].short_edge(out, false, leading[0], leading[1]);
    let suction_tail = nets[0].short_edge(out, true, ends[0][0], ends[0][1]);
    let pressure_tail =
        if blunt { nets[1].short_edge(out, true, ends[1][0], ends[1][1]) } else { suction_tail };
    let tails = [suction_tail, pressure_tail];

    let (middle, along, across) = blade.suction.derivatives(0.5, 0.5);
    let natural = along.cross(&across).dot(&(middle - nearest(&blade.pressure, &middle))) > 0.0;
    // The loops where the suction side's own normal points outwards; reversed otherwise.
    let face = |out: &mut Instances, mut edges: Vec<EdgeUse>, surface: u32, same_sense: bool| {
        if !natural {
            edges.reverse();
            edges.iter_mut().for_each(|(_, forward)| *forward = !*forward);
        }
        out.face(&[edges], surface, same_sense)
    };
    let mut faces = Vec::with_capacity(5);
    let suction = nets[0].surface(out);
    let pressure = nets[1].surface(out);
    let [[foot_s, tip_s], [foot_p, tip_p]] = long;
    faces.push(face(
        out,
        vec![(foot_s, true), (tails[0], true), (tip_s, false), (nose, false)],
        suction,
        natural,
    ));
    faces.push(face(
        out,
        vec![(nose, true), (tip_p, true), (tails[1], false), (foot_p, false)],
        pressure,
        !natural,
    ));
    let (mut tip, mut foot) = (vec![(tip_s, true), (tip_p, false)], vec![(foot_p, true), (foot_s, false)]);
    if blunt {
        let corner = |which: usize, k: usize| (ends[which][k], at(which, 1.0, k as f64));
        let [foot_edge, tip_edge] =
            [0, 1].map(|k| (!meets[k]).then(|| out.straight_edge(corner(0, k), corner(1, k))));
        tip.splice(1..1, tip_edge.map(|edge| (edge, true)));
        foot.splice(1..1, foot_edge.map(|edge| (edge, false)));
        let (surface, own) = tail_surface(out, sides, &nets);
        let outwards = own.dot(&blade.suction.derivatives(1.0, 0.5).1) > 0.0;
        let around = [
            Some((tails[0], false)),
            foot_edge.map(|edge| (edge, true)),
            Some((tails[1], true)),
            tip_edge.map(|edge| (edge, false)),
        ];
        faces.push(face(out, around.into_iter().flatten().collect(), surface, outwards));
    }
    let p = blade.suction.point(0.5, 0.5);
    let outwards = |path: &crate::part::Flowpath, away: f64| {
        let here = path.curve().at(path.curve().project(Meridional::from_point(&p)).0);
        // Normal of a surface of revolution: to the right of its curve.
        (here.tangent.z * here.normal.r - here.tangent.r * here.normal.z) * away > 0.0
    };
    faces.push(face(out, tip, floors[1], outwards(&part.shroud, 1.0)));
    faces.push(face(out, foot, floors[0], outwards(&part.hub, -1.0)));
    out.solid(name, &faces)
}

/// The ruled surface between the trailing edges of both sides, and its own normal in the middle.
fn tail_surface(
    out: &mut Instances,
    sides: [&BladeSide; 2],
    nets: &[Net; 2],
) -> (u32, crate::geometry::Vector) {
    let (a, _, across) = sides[0].derivatives(1.0, 0.5);
    let normal = (sides[1].point(1.0, 0.5) - a).cross(&across);
    let knots = ClampedKnots { values: &[0.0, 1.0], inner: 1 };
    let same = nets[0].across == nets[1].across && nets[0].degree_across == nets[1].degree_across;
    let rows: Vec<Vec<[f64; 3]>> = if same {
        nets.iter().map(|net| net.end(true).to_vec()).collect()
    } else {
        // Sides of different sections: a cubic through the trailing edge of the second at the stations of the
        // first.
        let other = |v: f64| <[f64; 3]>::from(sides[1].point(1.0, v));
        let stations = &nets[0].across;
        let net = if nets[0].degree_across == 1 {
            stations.iter().map(|v| other(*v)).collect()
        } else {
            bezier(stations, |v| {
                let (p, _, slope) = sides[1].derivatives(1.0, v);
                (p, slope)
            })
        };
        vec![nets[0].end(true).to_vec(), net]
    };
    (out.surface([1, nets[0].degree_across], &rows, [&knots, &nets[0].across()]), normal)
}

/// Control points of a C1 cubic by its points and slopes at `stations`, with double inner knots.
fn bezier(stations: &[f64], at: impl Fn(f64) -> (Point, crate::geometry::Vector)) -> Vec<[f64; 3]> {
    let (Some(&first), Some(&last)) = (stations.first(), stations.last()) else { return Vec::new() };
    let mut control: Vec<[f64; 3]> = vec![at(first).0.into()];
    for w in stations.windows(2) {
        let third = (w[1] - w[0]) / 3.0;
        let ((p, m), (q, n)) = (at(w[0]), at(w[1]));
        control.extend([(p + m * third).into(), (q - n * third).into()] as [[f64; 3]; 2]);
    }
    control.push(at(last).0.into());
    control
}

/// The point of a side at half its height that is nearest to `p`.
fn nearest(side: &BladeSide, p: &Point) -> Point {
    (0..=200)
        .map(|k| side.point(f64::from(k) / 200.0, 0.5))
        .min_by(|a, b| (a - p).norm_squared().total_cmp(&(b - p).norm_squared()))
        .unwrap_or(*p)
}
