//! The regions of a layer: where a splitter begins, the passage that it stands in is divided.

use super::layer::LayerPoint;
use super::layer_walls::{LayerSplitter, LayerWall, LayerWalls, y_at};
use super::region::{Region, WallName};

/// A region on a layer with its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionStretch {
    /// The region.
    pub region: Region,
    /// x at which it begins: at an end of the layer or at the nose of a splitter, mm.
    pub from: f64,
    /// x at which it ends or is divided, mm.
    pub to: f64,
}

impl LayerSplitter {
    /// Its name.
    pub fn name(&self) -> WallName {
        WallName::Splitter(self.number)
    }

    /// Whether it begins upstream of `x` (mm), or there.
    fn has_begun(&self, x: f64) -> bool {
        self.nose.x <= x
    }

    /// y of its two sides at `x`.
    fn sides_at(&self, x: f64) -> [f64; 2] {
        [0, 1].map(|side: usize| y_at(&self.sides[side], x))
    }
}

impl LayerWalls {
    /// All walls: of the main blades, then of the splitters in order.
    pub fn all(&self) -> impl Iterator<Item = (WallName, &LayerWall)> {
        let splitters = self.splitters.iter().map(|splitter| (splitter.name(), &splitter.border));
        [(WallName::Low, &self.low), (WallName::High, &self.high)].into_iter().chain(splitters)
    }

    /// A splitter by its name; `None` for a main blade, and where the splitter is not on the layer.
    pub fn splitter(&self, wall: WallName) -> Option<&LayerSplitter> {
        self.splitters.iter().find(|splitter| splitter.name() == wall)
    }

    /// The splitters that begin downstream of `x` (mm).
    pub fn ahead_of(&self, x: f64) -> impl Iterator<Item = &LayerSplitter> {
        self.splitters.iter().filter(move |splitter| !splitter.has_begun(x))
    }

    /// The lines of the walls that bound `region`, first and second, x growing.
    pub fn lines_beside(&self, region: Region) -> [&[LayerPoint]; 2] {
        let low = self.splitter(region.low).map_or(&self.low.points, |splitter| &splitter.sides[1]);
        let high = self.splitter(region.high).map_or(&self.high.points, |splitter| &splitter.sides[0]);
        [low, high]
    }

    /// The region beside a main blade downstream of all noses. Without a splitter it has the name that it
    /// would have with one.
    pub fn region_at_outlet(&self, main: WallName) -> Region {
        let name = |splitter: Option<&LayerSplitter>| splitter.map(LayerSplitter::name);
        let (first, last) = (name(self.splitters.first()), name(self.splitters.last()));
        match main {
            WallName::High => Region { low: last.unwrap_or(Region::HIGH_SIDE.low), high: main },
            _ => Region { low: main, high: first.unwrap_or(Region::LOW_SIDE.high) },
        }
    }

    /// Region of a point: between the nearest walls that have begun. `None` inside a splitter.
    pub fn region(&self, p: LayerPoint) -> Option<Region> {
        let (region, is_inside) = self.locate(p);
        (!is_inside).then_some(region)
    }

    /// Region of a point; inside a splitter the region beside its nearer side.
    pub fn nearest_region(&self, p: LayerPoint) -> Region {
        self.locate(p).0
    }

    /// [`Self::nearest_region`] of a point, and whether it is inside a splitter.
    fn locate(&self, p: LayerPoint) -> (Region, bool) {
        let (mut region, mut is_inside) = (Region::INLET, false);
        for splitter in self.splitters.iter().filter(|splitter| splitter.has_begun(p.x)) {
            let [low, high] = splitter.sides_at(p.x);
            let is_in_this = (low..=high).contains(&p.y);
            is_inside |= is_in_this;
            if p.y < low || is_in_this && 2.0 * p.y < low + high {
                region.high = splitter.name();
                break;
            }
            region.low = splitter.name();
        }
        (region, is_inside)
    }

    /// The splitter that divides `region`: of those between its walls the one that begins first.
    pub fn divider(&self, region: Region) -> Option<&LayerSplitter> {
        let inside = self.splitters.iter().filter(|s| region.low < s.name() && s.name() < region.high);
        inside.min_by(|a, b| a.nose.x.total_cmp(&b.nose.x))
    }

    /// The regions between `from` and `to` (x, mm), in their order.
    pub fn regions(&self, from: f64, to: f64) -> Vec<RegionStretch> {
        let mut found = Vec::with_capacity(1 + 2 * self.splitters.len());
        let mut open = vec![RegionStretch { region: Region::INLET, from, to }];
        while let Some(whole) = open.pop() {
            let RegionStretch { region, from, .. } = whole;
            let Some(splitter) = self.divider(region) else {
                found.push(whole);
                continue;
            };
            let (nose, name) = (splitter.nose.x.max(from), splitter.name());
            found.push(RegionStretch { to: nose, ..whole });
            let beside = [Region { low: name, ..region }, Region { high: name, ..region }];
            open.extend(beside.map(|region| RegionStretch { region, from: nose, to }));
        }
        found
    }
}
