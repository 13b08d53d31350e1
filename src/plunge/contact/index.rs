//! Where plunges are: a tree of places over their tips, so that a search looks at those around it alone, however many
//! there are.

use std::collections::HashMap;

use crate::geometry::{CutterSolid, Point, Vector};

/// Edge of the smallest places, in cutter radii, and by how much those of the next size are wider.
const EDGE_RADII: f64 = 3.0;
/// See [`EDGE_RADII`].
const WIDER: i32 = 4;
/// Sizes of places.
const LEVELS: usize = 4;
/// Width of the cells that axes are sorted into at the smallest places, by component.
const AXIS_CELL: f64 = 0.125;
/// Stretches of an axis over which distances to other axes are bounded, and the furthest they go, mm.
const STRETCHES: usize = 4;
/// See [`STRETCHES`].
const FURTHEST: f64 = 1e4;

/// What is asked about: all that lies within `reach` mm of an axis, from its tip to `top` mm above.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    pub tip: Point,
    pub axis: Vector,
    pub reach: f64,
    pub top: f64,
}

/// What holds all plunges of a place.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// First tip and first axis.
    tip: Point,
    axis: Vector,
    /// Largest distance of a tip from the first one, of an axis from the first one, and largest radius.
    aside: f64,
    turned: f64,
    radius: f64,
}

impl Bounds {
    fn of(cutter: &CutterSolid) -> Self {
        Self { tip: cutter.tip, axis: cutter.axis, aside: 0.0, turned: 0.0, radius: cutter.radius }
    }

    fn add(&mut self, cutter: &CutterSolid) {
        self.aside = self.aside.max((cutter.tip - self.tip).norm());
        self.turned = self.turned.max((cutter.axis - self.axis).norm());
        self.radius = self.radius.max(cutter.radius);
    }

    /// Whether a plunge of the place may come into what is asked about.
    fn is_near(&self, around: &Around) -> bool {
        // Distances between straight axes change evenly.
        let slope = around.axis.cross(&self.axis).norm();
        let half = 0.5 * around.top.min(FURTHEST) / STRETCHES as f64;
        (0..STRETCHES).any(|i| {
            let d = around.tip + around.axis * (half * (2 * i + 1) as f64) - self.tip;
            let flat = (d - self.axis * d.dot(&self.axis)).norm();
            // How far off the first tip this is bounds how far the axes of the place have parted there.
            let parted = self.aside + self.turned * (d.norm() + half + self.aside);
            flat - slope * half < around.reach + self.radius + parted
        })
    }
}

#[derive(Clone, Debug)]
struct Place {
    bounds: Bounds,
    /// The place of the next size that holds it.
    parent: u32,
    /// Numbers of plunges, ascending, or of places of the size below.
    members: Vec<u32>,
}

/// Radius of the cutters of a place, its cell, and the cell of their axes.
type Key = (u64, [i32; 3], [i32; 3]);

/// Plunges by where they are.
#[derive(Clone, Debug, Default)]
pub struct Index {
    /// By size, the smallest first.
    places: [Vec<Place>; LEVELS],
    numbers: [HashMap<Key, u32>; LEVELS],
    /// Of each plunge its smallest place.
    of_plunge: Vec<u32>,
}

impl Index {
    /// Adds the next plunge.
    pub fn push(&mut self, cutter: &CutterSolid) {
        let edge = EDGE_RADII * cutter.radius.max(1e-3);
        let cells = |v: Vector, edge: f64| [v.x, v.y, v.z].map(|x| (x / edge).floor() as i32);
        let key = (cutter.radius.to_bits(), cells(cutter.tip.coords, edge), cells(cutter.axis, AXIS_CELL));
        let number = self.of_plunge.len() as u32;
        let leaf = self.place(0, key, cutter);
        let place = &mut self.places[0][leaf as usize];
        if place.members.is_empty() {
            place.bounds = Bounds::of(cutter);
        }
        place.members.push(number);
        self.of_plunge.push(leaf);
        let mut at = leaf;
        for places in &mut self.places {
            let place = &mut places[at as usize];
            place.bounds.add(cutter);
            at = place.parent;
        }
    }

    /// The place of size `level` at `key`, made for `cutter` where there is none.
    fn place(&mut self, level: usize, key: Key, cutter: &CutterSolid) -> u32 {
        if let Some(&number) = self.numbers[level].get(&key) {
            return number;
        }
        let number = self.places[level].len() as u32;
        let mut parent = 0;
        if level + 1 < LEVELS {
            let (radius, cell, _) = key;
            parent = self.place(level + 1, (radius, cell.map(|x| x.div_euclid(WIDER)), [0; 3]), cutter);
            self.places[level + 1][parent as usize].members.push(number);
        }
        self.places[level].push(Place { bounds: Bounds::of(cutter), parent, members: Vec::new() });
        self.numbers[level].insert(key, number);
        number
    }

    /// Forgets all but the first `count`.
    pub fn truncate(&mut self, count: usize) {
        for leaf in self.of_plunge.drain(count.min(self.of_plunge.len())..).rev() {
            self.places[0][leaf as usize].members.pop();
        }
    }

    /// Numbers below `count` of those that may come into what is asked about, in any order. Some that do not are among them.
    pub fn near(&self, around: &Around, count: usize) -> Vec<u32> {
        let mut found = Vec::new();
        for place in &self.places[LEVELS - 1] {
            self.gather(LEVELS - 1, place, around, count as u32, &mut found);
        }
        found
    }

    fn gather(&self, level: usize, place: &Place, around: &Around, count: u32, found: &mut Vec<u32>) {
        if level == 0 && place.members.first().is_none_or(|&first| first >= count)
            || !place.bounds.is_near(around)
        {
            return;
        }
        let members = place.members.iter();
        match level.checked_sub(1) {
            None => found.extend(members.take_while(|&&number| number < count)),
            Some(below) => {
                for &number in members {
                    self.gather(below, &self.places[below][number as usize], around, count, found);
                }
            }
        }
    }
}
