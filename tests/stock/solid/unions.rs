//! Volumes of random unions against integrals over exact chords, which know no lattice.

use rayon::prelude::*;

use super::*;

/// Lines of the integral.
const LINES: usize = 150_000;
/// Unions.
const COUNT: u64 = 50;
/// Radius and height of [`disc`], mm.
const RADIUS: f64 = 40.0;
const HEIGHT: f64 = 30.0;

/// A plunge of a flat (`is_ball` false) or a ball cutter.
#[derive(Clone, Copy, Debug)]
struct Swept {
    to: ToolPose,
    radius: f64,
    is_ball: bool,
}

impl Swept {
    /// Heights z from … to at which the vertical line through (x, y) is inside what the plunge sweeps: the
    /// half-infinite cylinder above its bottom, and for a ball the ball below that.
    fn chords(&self, x: f64, y: f64) -> [Option<(f64, f64)>; 2] {
        let (a, r) = (self.to.axis, self.radius);
        let from = Point::new(x, y, 0.0) - self.to.tip;
        let bottom = if self.is_ball { r } else { 0.0 };
        // |p − (p·a) a|² ≤ r² with p = from + z e₃.
        let across = from - a * from.dot(&a);
        let rise = Vector::z() - a * a.z;
        let column = quadratic(rise.dot(&rise), across.dot(&rise), across.dot(&across) - r * r);
        // (from + z e₃)·a ≥ bottom; all axes point up.
        let above = (bottom - from.dot(&a)) / a.z;
        let column = column.map(|(low, high)| (low.max(above), high)).filter(|(low, high)| low < high);
        let centre = from - a * r;
        let ball = quadratic(1.0, centre.z, centre.dot(&centre) - r * r).filter(|_| self.is_ball);
        [column, ball]
    }
}

/// Where a z² + 2 b z + c ≤ 0; `None` where it is nowhere. A line along the axis of a column is all inside.
fn quadratic(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    if a < 1e-12 {
        return (c <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let root = b * b - a * c;
    (root > 0.0).then(|| ((-b - root.sqrt()) / a, (-b + root.sqrt()) / a))
}

/// Volume of the disc inside any of `swept`, mm³: the mean over lines through evenly spread points.
fn exact(swept: &[Swept]) -> f64 {
    // Golden angle: successive points fill the disc evenly.
    let golden = PI * (3.0 - 5f64.sqrt());
    let mut chords: Vec<(f64, f64)> = Vec::new();
    let length = |k: usize| {
        let r = RADIUS * ((k as f64 + 0.5) / LINES as f64).sqrt();
        let (sin, cos) = (golden * k as f64).sin_cos();
        chords.clear();
        let all = swept.iter().flat_map(|swept| swept.chords(r * cos, r * sin)).flatten();
        let inside = all.map(|(low, high)| (low.max(0.0), high.min(HEIGHT)));
        chords.extend(inside.filter(|(low, high)| low < high));
        chords.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut covered, mut top) = (0.0, 0.0f64);
        for (low, high) in &chords {
            covered += (high - low.max(top)).max(0.0);
            top = top.max(*high);
        }
        covered
    };
    let mean = (0..LINES).map(length).sum::<f64>() / LINES as f64;
    mean * PI * RADIUS * RADIUS
}

/// Numbers from 0 to 1, the same on every machine.
struct Dice(u64);

impl Dice {
    fn between(&mut self, from: f64, to: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn random_unions_have_the_volume_of_the_exact_solids() {
    // D/200; the volume is to be right within 0.1 % at D/800.
    let spacing = 2.0 * RADIUS / 200.0;
    let whole = disc().volume();
    let tried: Vec<(u64, f64)> = (0..COUNT)
        .into_par_iter()
        .map(|seed| {
            let mut dice = Dice(seed);
            let is_ball = dice.between(0.0, 1.0) < 0.5;
            let radius = dice.between(3.0, 10.0);
            let count = dice.between(2.0, 9.0) as usize;
            let swept: Vec<Swept> = (0..count)
                .map(|_| {
                    let tip = [dice.between(-35.0, 35.0), dice.between(-35.0, 35.0), dice.between(2.0, 25.0)];
                    let axis = [dice.between(-0.6, 0.6), dice.between(-0.6, 0.6), 1.0];
                    Swept { to: pose(tip, axis), radius, is_ball }
                })
                .collect();
            let moves: Vec<SolidMove> = swept.iter().zip(0..).map(|(s, k)| plunge(k, s.to)).collect();
            let cutter = tool(2.0 * radius, if is_ball { radius } else { 0.0 });
            let left = StockSurface::from_stock(&cut(&disc(), spacing, &cutter, &moves).0).volume();
            (seed, (left - (whole - exact(&swept))) / whole)
        })
        .collect();
    let (seed, worst) = tried.into_iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).expect("some");
    println!("worst: {worst:.2e} of the whole, seed {seed}");
    assert!(worst.abs() <= 2e-4, "seed {seed}: {worst} of the whole");
}
