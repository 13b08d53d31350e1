//! Isoparametric strategy: each curve is at a constant fraction between the walls; the widest station sets
//! their number.

use super::pass_curve::{PassCurve, PassRole};
use crate::flank::layer::{LayerPoint, LayerSurface};
use crate::flank::layer_regions::RegionStretch;
use crate::flank::layer_walls::{LayerWalls, y_at};
use crate::flank::region::Region;

/// Spacing of the points of a curve, mm.
const STEP: f64 = 2.0;

/// The baseline [flank paper, fig. 4]: the widest station of each passage at the outlet sets the number of
/// curves, and each runs through the whole channel. First and last curve keep `clear` mm from the walls.
/// Lead-in and lead-out are `beyond` mm long.
pub fn isoparametric(
    layer: &LayerSurface,
    borders: &LayerWalls,
    clear: f64,
    stepover: f64,
    beyond: f64,
) -> Vec<PassCurve> {
    let passages = LayerPassage::all(layer, borders, clear);
    let begin = |passage: &LayerPassage| match passage.region {
        Region::INLET => layer.from - beyond,
        _ => passage.from,
    };
    let mut curves = Vec::new();
    for passage in passages.iter().filter(|passage| borders.divider(passage.region).is_none()) {
        for share in passage.shares(stepover) {
            let mut curve = passage.curve(share, begin(passage), layer.to + beyond);
            // Upstream of a splitter the curve keeps the fraction of the undivided passage at which it passes
            // the nose.
            let (mut at, mut fraction) = (passage, share);
            while let Some(before) = passages.iter().rfind(|before| before.divides_into(at)) {
                let nose = at.from;
                (fraction, at) = (before.fraction(nose, at.y(fraction, nose)), before);
                if at.from < nose {
                    let mut upstream = at.curve(fraction, begin(at), nose).points;
                    upstream.pop();
                    curve.points.splice(0..0, upstream);
                }
            }
            curves.push(curve);
        }
    }
    curves
}

/// The same in each region by itself: the widest station of the region sets the number of curves [flank
/// paper, fig. 7].
pub fn isoparametric_by_region(
    layer: &LayerSurface,
    borders: &LayerWalls,
    clear: f64,
    stepover: f64,
    beyond: f64,
) -> Vec<PassCurve> {
    let passages = LayerPassage::all(layer, borders, clear);
    let mut curves = Vec::new();
    for passage in &passages {
        if passage.from >= passage.to {
            continue;
        }
        let from = if passage.from <= layer.from { layer.from - beyond } else { passage.from };
        let to = if passage.to >= layer.to { layer.to + beyond } else { passage.to };
        curves.extend(passage.shares(stepover).map(|share| passage.curve(share, from, to)));
    }
    curves
}

/// A region with the lines of its walls.
struct LayerPassage<'a> {
    layer: &'a LayerSurface,
    low: &'a [LayerPoint],
    high: &'a [LayerPoint],
    clear: f64,
    /// x at which it begins and ends.
    from: f64,
    to: f64,
    region: Region,
}

impl<'a> LayerPassage<'a> {
    /// The channel up to the first nose, and the passages into which splitters divide it.
    fn all(layer: &'a LayerSurface, borders: &'a LayerWalls, clear: f64) -> Vec<Self> {
        let passage = |RegionStretch { region, from, to }| {
            let [low, high] = borders.lines_beside(region);
            Self { layer, low, high, clear, from, to, region }
        };
        borders.regions(layer.from, layer.to).into_iter().map(passage).collect()
    }

    /// Whether `other` is beside the splitter that divides this passage, or in such a one that is divided at
    /// the same place.
    fn divides_into(&self, other: &Self) -> bool {
        self.to == other.from && self.region.contains(other.region) && self.region != other.region
    }

    /// y of the first and the last curve at `x`, and the cosine of their mean slope.
    fn ends(&self, x: f64) -> ([f64; 2], f64) {
        let r = self.layer.radius(x).0.max(1e-6);
        let d = 0.25;
        let cos = |line: &[LayerPoint]| {
            let slope = r * (y_at(line, x + d) - y_at(line, x - d)) / (2.0 * d);
            1.0 / (1.0 + slope * slope).sqrt()
        };
        let (a, b) = (cos(self.low), cos(self.high));
        let reach = |cos: f64| self.clear / (r * cos.max(0.1));
        ([y_at(self.low, x) + reach(a), y_at(self.high, x) - reach(b)], 0.5 * (a + b))
    }

    /// y at the fraction `share` from the first curve to the last.
    fn y(&self, share: f64, x: f64) -> f64 {
        let [a, b] = self.ends(x).0;
        a + share * (b - a)
    }

    /// The fraction at which `y` is.
    fn fraction(&self, x: f64, y: f64) -> f64 {
        let [a, b] = self.ends(x).0;
        (y - a) / (b - a)
    }

    /// Fractions of the curves, by the widest station; one in the middle where only that fits.
    fn shares(&self, stepover: f64) -> impl Iterator<Item = f64> + use<> {
        let width = |x: f64| {
            let ([a, b], cos) = self.ends(x);
            self.layer.radius(x).0 * (b - a) * cos
        };
        let widest = stations(self.from, self.to).map(width).fold(0.0, f64::max);
        let count = (widest / stepover).ceil() as usize;
        (0..=count).map(move |k| if count > 0 { k as f64 / count as f64 } else { 0.5 })
    }

    fn curve(&self, share: f64, from: f64, to: f64) -> PassCurve {
        let points = stations(from, to).map(|x| LayerPoint { x, y: self.y(share, x) }).collect();
        let role = match share {
            0.0 => PassRole::Wall(self.region.low),
            1.0 => PassRole::Wall(self.region.high),
            _ => PassRole::Inner,
        };
        PassCurve { role, region: self.region, points }
    }
}

/// x of the points of a curve.
fn stations(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let count = ((to - from) / STEP).ceil().max(1.0) as usize;
    (0..=count).map(move |i| from + (to - from) * i as f64 / count as f64)
}
