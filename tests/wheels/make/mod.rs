//! Random wheels that can be built, with edges, blades and curves of all common kinds. The same seed and
//! index give the same wheel on every machine.

mod blade;
mod dice;
mod spec;
mod surface;

use std::f64::consts::TAU;

use vanecut::part::{BladeDescription, CurveDescription, Meridional, PartDescription};

use blade::BladeMaker;
use dice::Dice;
use spec::{Kind, Spec};
use surface::{CamberSurface, Wall, Walls};

/// A random wheel.
pub struct Wheel {
    pub description: PartDescription,
    /// Its main characteristics, one line.
    pub remarks: String,
}

/// Wheel `index` of `seed`; the kinds alternate.
pub fn wheel(seed: u64, index: usize) -> Wheel {
    let kind = Kind::ALL[index % Kind::ALL.len()];
    let mut dice = Dice::new(seed, index as u64);
    loop {
        if let Some(wheel) = sensible(Spec::draw(kind, &mut dice), &format!("{index:03}-{}", kind.name())) {
            return wheel;
        }
    }
}

/// Largest inclination of a blade from the straight line from hub to shroud, as a tangent.
const MAX_LEAN: f64 = 1.3;
/// Largest angle of a blade from the meridional direction, degrees.
const MAX_ANGLE: f64 = 88.0;
/// Largest wrap, rad.
const MAX_WRAP: f64 = 0.5 * TAU;

/// The wheel of a specification, limited to what can be built: twist, wrap, number of blades and thickness
/// are reduced until inclination and passage width are within what can be milled. `None` with fewer than four
/// blades.
fn sensible(mut spec: Spec, name: &str) -> Option<Wheel> {
    let walls = Walls::from_spec(&spec);
    let (mut twist, mut wrap) = (1.0, 1.0);
    for _ in 0..200 {
        let surface = CamberSurface { spec: &spec, walls: &walls, twist, wrap };
        let measures = Measures::from_surface(&surface);
        if measures.angle > MAX_ANGLE || measures.wrap > MAX_WRAP {
            wrap *= 0.96;
        } else if measures.lean > MAX_LEAN && twist > 0.05 {
            twist *= 0.8;
        } else if measures.lean > MAX_LEAN {
            spec.rake *= 0.7;
            spec.bow *= 0.9;
            spec.compound *= 0.9;
        } else if measures.gap_share < 1.0 {
            if spec.kind != Kind::Splitters && !spec.splitters.is_empty() && spec.blades < 10 {
                spec.splitters.clear();
            } else if spec.blades > 4 {
                spec.blades -= 1;
            } else if measures.angle > 60.0 {
                wrap *= 0.95;
            } else if spec.splitters.len() > 1 {
                return None;
            } else {
                spec.thickness = spec.thickness.map(|t| 0.9 * t);
            }
        } else {
            return (measures.chord > 12.0).then(|| made(&surface, &measures, name));
        }
    }
    None
}

/// Measures that decide whether a wheel can be built.
struct Measures {
    /// Largest blade angle, degrees.
    angle: f64,
    /// Largest wrap of the blade, rad.
    wrap: f64,
    lean: f64,
    /// Narrowest passage as a multiple of the required width.
    gap_share: f64,
    /// Shortest chord as a multiple of the thickness.
    chord: f64,
}

impl Measures {
    fn from_surface(surface: &CamberSurface<'_>) -> Self {
        let (spec, walls) = (surface.spec, surface.walls);
        let cambers = [0.0, 0.5, 1.0].map(|eta| (eta, surface.on(eta)));
        let mut measures =
            Self { angle: 0.0, wrap: 0.0, lean: 0.0, gap_share: f64::INFINITY, chord: f64::INFINITY };
        for (eta, camber) in &cambers {
            let thickness = spec.rim * (spec.thickness[0] + (spec.thickness[1] - spec.thickness[0]) * eta);
            let (from, to) = (spec.leading.at(*eta), spec.trailing.at(*eta));
            let ends = [from, to].map(|s| camber.at_s(s));
            measures.wrap = measures.wrap.max((ends[1].theta - ends[0].theta).abs());
            let latest = spec.splitters.iter().map(|row| row.edge.at(*eta)).fold(from, f64::max);
            let chord = ends[1].length - camber.at_s(latest).length;
            measures.chord = measures.chord.min(chord / thickness);
            for i in 0..=60 {
                let s = from + (to - from) * f64::from(i) / 60.0;
                let here = camber.at_s(s);
                measures.angle = measures.angle.max(here.beta.to_degrees().abs());
                // Positions, relative to the pitch, of the blades that exist at this s.
                let mut places: Vec<f64> = spec
                    .splitters
                    .iter()
                    .filter(|row| row.edge.at(*eta) < s + 0.05)
                    .map(|row| row.place)
                    .collect();
                places.insert(0, 0.0);
                places.push(1.0);
                let narrowest = places.windows(2).map(|w| w[1] - w[0]).fold(1.0, f64::min);
                let gap = TAU / spec.blades as f64 * narrowest * here.r * here.beta.cos() - thickness;
                let share = if spec.kind == Kind::Wrapped { 0.02 } else { 0.03 };
                let asked = 0.8f64.max(share * spec.rim).max(walls.height(s) / 8.0);
                measures.gap_share = measures.gap_share.min(gap / asked);
            }
        }
        for i in 0..=40 {
            let s = f64::from(i) / 40.0;
            let [hub, middle, shroud] = [0, 1, 2].map(|k| cambers[k].1.at_s(s));
            let height = walls.height(s).max(0.02 * spec.rim);
            for (a, b) in [(hub, middle), (middle, shroud)] {
                measures.lean = measures.lean.max((b.theta - a.theta).abs() * middle.r / (0.5 * height));
            }
        }
        measures
    }
}

fn made(surface: &CamberSurface<'_>, measures: &Measures, name: &str) -> Wheel {
    let spec = surface.spec;
    let up = if spec.inlet_up { -1.0 } else { 1.0 };
    let curve = |wall: &Wall, runs_on: (f64, f64)| {
        const POINTS: usize = 80;
        let mut s: Vec<f64> = (0..=POINTS).map(|i| i as f64 / POINTS as f64).collect();
        for (on, end, sign) in [(runs_on.0, 0.0, -1.0), (runs_on.1, 1.0, 1.0)] {
            let steps = (on * POINTS as f64).round() as usize;
            s.extend((1..=steps).map(|i| end + sign * on * i as f64 / steps as f64));
        }
        s.sort_by(f64::total_cmp);
        let point = |s: f64| {
            let place = wall.at(s);
            Meridional { r: place.r, z: up * place.z }
        };
        CurveDescription::Points(s.into_iter().map(point).filter(|p| p.r > 0.0).collect())
    };
    let maker = BladeMaker { surface, up };
    let pitch = spec.turn * TAU / spec.blades as f64;
    let splitters: Vec<BladeDescription> =
        spec.splitters.iter().map(|row| maker.blade(&row.edge, row.place * pitch)).collect();
    // Hub and shroud that meet do so at the leading edge only, so neither extends upstream of it.
    let mut runs_on = spec.runs_on;
    if spec.kind == Kind::Meeting {
        runs_on = [(0.0, runs_on[0].1), (0.0, runs_on[1].1)];
    }
    let remarks = format!(
        "D {:.0}, {}+{} blades, wrap {:.0}°, angle {:.0}°, t {:.2}, \
         LE {:.2}/{:.2}, TE {:.2}/{:.2} {:?}, lean {:.0}°",
        2.0 * spec.rim,
        spec.blades,
        spec.blades * spec.splitters.len(),
        measures.wrap.to_degrees(),
        measures.angle,
        spec.rim * spec.thickness[0],
        spec.leading.hub,
        spec.leading.shroud,
        spec.trailing.hub,
        spec.trailing.shroud,
        spec.tail,
        measures.lean.atan().to_degrees(),
    );
    let description = PartDescription {
        name: name.to_string(),
        hub: curve(&surface.walls.hub, runs_on[0]),
        shroud: curve(&surface.walls.shroud, runs_on[1]),
        blade_count: spec.blades,
        main: maker.blade(&spec.leading, 0.0),
        splitters,
        hub_line: 0,
        shroud_line: 0,
        count_line: 0,
        notes: Vec::new(),
        roles_by_shape: false,
    };
    Wheel { description, remarks }
}
