//! The stream surfaces of a wheel and the camber surface on them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use vanecut::part::Meridional;

use super::spec::{Kind, Spec};

/// Hub or shroud over s: s = 0 … 1 is uniform over its points, with straight extensions beyond.
pub struct Wall(Vec<Meridional>);

impl Wall {
    pub fn at(&self, s: f64) -> Meridional {
        let last = self.0.len() - 1;
        let x = s * last as f64;
        let i = (x.floor().max(0.0) as usize).min(last - 1);
        self.0[i].lerp(self.0[i + 1], x - i as f64)
    }

    /// Points at equal arc lengths on a cubic Bézier curve.
    fn bezier(control: [Meridional; 4]) -> Self {
        let point = |t: f64| {
            let [a, b, c, d] = control;
            let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
            ab.lerp(bc, t).lerp(bc.lerp(cd, t), t)
        };
        const FINE: usize = 4000;
        const POINTS: usize = 400;
        let fine: Vec<Meridional> = (0..=FINE).map(|i| point(i as f64 / FINE as f64)).collect();
        let mut length = vec![0.0];
        for pair in fine.windows(2) {
            length.push(length[length.len() - 1] + pair[0].distance(pair[1]));
        }
        let even = |i: usize| {
            let wanted = length[FINE] * i as f64 / POINTS as f64;
            let k = length.partition_point(|&l| l < wanted).clamp(1, FINE);
            fine[k - 1].lerp(fine[k], (wanted - length[k - 1]) / (length[k] - length[k - 1]))
        };
        Self((0..=POINTS).map(even).collect())
    }
}

/// Hub and shroud of a wheel with its inlet at z = 0 and its back towards +z, mm.
pub struct Walls {
    pub hub: Wall,
    pub shroud: Wall,
}

impl Walls {
    pub fn from_spec(spec: &Spec) -> Self {
        let Spec { rim, eye, tip, depth, outlet, .. } = *spec;
        let place = |r: f64, z: f64| Meridional { r: r * rim, z: z * rim };
        if spec.kind.is_flat() {
            // Both over the radius. The height at the inlet keeps the cross-section roughly constant.
            let inlet = outlet * (0.75 / eye).min(1.8);
            let by_radius = |z: &dyn Fn(f64) -> f64| {
                Wall(
                    (0..=200)
                        .map(|i| f64::from(i) / 200.0)
                        .map(|s| place(eye + (1.0 - eye) * s, z(s)))
                        .collect(),
                )
            };
            let back = |s: f64| depth * (1.0 - (1.0 - s).powi(2));
            let height = |s: f64| {
                let grown = match spec.kind {
                    // From zero at the leading edge to the full height at a quarter of the chord.
                    Kind::Meeting if s < 0.0 => 0.0,
                    Kind::Meeting if s < 0.25 => (FRAC_PI_2 * s / 0.25).sin(),
                    _ => 1.0,
                };
                (inlet + (outlet - inlet) * s) * grown
            };
            return Self { hub: by_radius(&back), shroud: by_radius(&|s| back(s) - height(s)) };
        }
        let incline = spec.incline.to_radians();
        let end = |z: f64, reach: f64| place(1.0 - reach * incline.cos(), z - reach * incline.sin());
        let hub =
            [place(eye, 0.0), place(eye, 0.58 * depth), end(depth, 0.55 * (1.0 - eye)), end(depth, 0.0)];
        let front = depth - outlet / incline.cos();
        let shroud =
            [place(tip, 0.0), place(tip, 0.6 * front), end(front, 0.55 * (1.0 - tip)), end(front, 0.0)];
        Self { hub: Wall::bezier(hub), shroud: Wall::bezier(shroud) }
    }

    pub fn at(&self, s: f64, eta: f64) -> Meridional {
        self.hub.at(s).lerp(self.shroud.at(s), eta)
    }

    pub fn height(&self, s: f64) -> f64 {
        self.hub.at(s).distance(self.shroud.at(s))
    }
}

/// Point of the camber line on a stream surface, in its conformal plane (m′, θ) with dm′ = dm / r, where
/// angles equal blade angles.
#[derive(Clone, Copy)]
pub struct Station {
    pub s: f64,
    pub m: f64,
    pub theta: f64,
    pub r: f64,
    /// Blade angle, rad.
    pub beta: f64,
    /// Arc length along the camber line, mm.
    pub length: f64,
}

/// A camber line as a table over s, from upstream of the inlet to beyond the rim.
pub struct Camber(Vec<Station>);

/// Range of s of the tables.
const RANGE: (f64, f64) = (-0.2, 1.2);
const STEPS: usize = 1400;

impl Camber {
    fn lookup(&self, of: impl Fn(&Station) -> f64, wanted: f64) -> Station {
        let k = self.0.partition_point(|station| of(station) < wanted).clamp(1, self.0.len() - 1);
        let (a, b) = (&self.0[k - 1], &self.0[k]);
        let x = (wanted - of(a)) / (of(b) - of(a));
        let mix = |of: fn(&Station) -> f64| of(a) + (of(b) - of(a)) * x;
        Station {
            s: mix(|p| p.s),
            m: mix(|p| p.m),
            theta: mix(|p| p.theta),
            r: mix(|p| p.r),
            beta: mix(|p| p.beta),
            length: mix(|p| p.length),
        }
    }

    pub fn at_s(&self, s: f64) -> Station {
        self.lookup(|p| p.s, s)
    }

    pub fn at_m(&self, m: f64) -> Station {
        self.lookup(|p| p.m, m)
    }

    pub fn at_length(&self, length: f64) -> Station {
        self.lookup(|p| p.length, length)
    }
}

/// The camber surface, with factors that reduce the random twist and wrap.
pub struct CamberSurface<'a> {
    pub spec: &'a Spec,
    pub walls: &'a Walls,
    /// Factor of the difference between a stream surface's camber line and the mean one.
    pub twist: f64,
    /// Factor of all θ.
    pub wrap: f64,
}

impl CamberSurface<'_> {
    /// The camber line on the stream surface `eta`.
    pub fn on(&self, eta: f64) -> Camber {
        let s_at = |i: usize| RANGE.0 + (RANGE.1 - RANGE.0) * i as f64 / STEPS as f64;
        let (own, mean) = (self.drawn(eta), self.drawn(0.5));
        let mut stations: Vec<Station> = Vec::with_capacity(STEPS + 1);
        let mut before = self.walls.at(s_at(0), eta);
        for i in 0..=STEPS {
            let s = s_at(i);
            let place = self.walls.at(s, eta);
            // Extensions may cross the rotation axis, where no blade is: the radius is clamped.
            let r = place.r.max(0.02 * self.spec.rim);
            let wrapped = self.wrap * (mean[i] + self.twist * (own[i] - mean[i]));
            let theta = wrapped + self.leaned(s, eta) / r;
            let (mut m, mut length) = (0.0, 0.0);
            if let Some(last) = stations.last() {
                let dm = place.distance(before);
                m = last.m + dm * 2.0 / (r + last.r);
                length = last.length + dm.hypot(0.5 * (r + last.r) * (theta - last.theta));
            }
            before = place;
            stations.push(Station { s, m, theta, r, beta: 0.0, length });
        }
        for i in 0..=STEPS {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(STEPS));
            stations[i].beta = (stations[b].theta - stations[a].theta).atan2(stations[b].m - stations[a].m);
        }
        Camber(stations)
    }

    /// Circumferential displacement of the blade by rake and bow, mm.
    fn leaned(&self, s: f64, eta: f64) -> f64 {
        let Spec { rake, bow, compound, .. } = *self.spec;
        let shape =
            rake.to_radians().tan() * (eta - 0.5) + bow * (PI * eta).sin() + compound * (TAU * eta).sin();
        shape * self.walls.height(s.clamp(0.0, 1.0))
    }

    /// θ, rad, of the random angles, 0 at the rim. The tangent of the angle is a quadratic Bézier curve in s,
    /// whose middle control value gives every stream surface the wrap of the mean one.
    fn drawn(&self, eta: f64) -> Vec<f64> {
        let share = eta.clamp(0.0, 1.0);
        let tangent = |degrees: f64| degrees.to_radians().tan();
        let [hub, shroud] = self.spec.inlet_angle.map(tangent);
        let last = tangent(self.spec.outlet_angle);
        let weights = |eta: f64| {
            let mut sums = [0.0; 3];
            for i in 0..400 {
                let s = (f64::from(i) + 0.5) / 400.0;
                let (a, b) = (self.walls.at(s - 0.00125, eta), self.walls.at(s + 0.00125, eta));
                let dm = a.distance(b) * 2.0 / (a.r + b.r);
                let basis = [(1.0 - s).powi(2), 2.0 * s * (1.0 - s), s * s];
                (0..3).for_each(|k| sums[k] += basis[k] * dm);
            }
            sums
        };
        let mean_first = 0.5 * (hub + shroud);
        let mean = weights(0.5);
        let wrap = mean[0] * mean_first + mean[1] * tangent(self.spec.middle_angle) + mean[2] * last;
        let own = weights(share);
        let first = hub + (shroud - hub) * share;
        let middle = ((wrap - own[0] * first - own[2] * last) / own[1]).clamp(-0.3, tangent(87.0));
        let mut theta = vec![0.0];
        for i in 0..STEPS {
            let step = (RANGE.1 - RANGE.0) / STEPS as f64;
            let s = RANGE.0 + step * (i as f64 + 0.5);
            let (a, b) = (self.walls.at(s - 0.5 * step, eta), self.walls.at(s + 0.5 * step, eta));
            let radius = (0.5 * (a.r + b.r)).max(0.02 * self.spec.rim);
            let t = s.clamp(0.0, 1.0);
            let angle = first * (1.0 - t).powi(2) + middle * 2.0 * t * (1.0 - t) + last * t * t;
            theta.push(theta[i] + angle * a.distance(b) / radius);
        }
        let at_rim = theta[((1.0 - RANGE.0) / (RANGE.1 - RANGE.0) * STEPS as f64).round() as usize];
        theta.iter().map(|t| t - at_rim).collect()
    }
}
