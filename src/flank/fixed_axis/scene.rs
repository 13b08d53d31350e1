//! Fast approximate distances from the blades for the fixed-axis search, by points of these, on the safe side
//! by a few hundredths of a millimetre.

use crate::geometry::{Point, Vector};
use crate::part::BladeSide;
use crate::setup::{ClearanceSetup, Tool};

/// Points sampled on the blades, at most [`SPACING`] apart along u.
#[derive(Debug)]
pub(super) struct BladePoints {
    points: Vec<Point>,
    /// A ball around each [`CHUNK`] consecutive points: centre and radius, mm.
    balls: Vec<(Point, f64)>,
    /// A cylinder is nearer to a blade side than to its points by at most this, mm.
    pub(super) slack: f64,
}

/// A cone of axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    pub(super) axis: Vector,
    /// rad.
    pub(super) angle: f64,
}

/// Points that a tool with an axis of a cone could collide with, relative to the centre of the tool's corner.
#[derive(Debug, Default)]
pub(super) struct NearPoints {
    column: PointTree,
    holder: PointTree,
}

/// Points in blocks, and blocks in groups: most groups are ruled out by their balls alone.
#[derive(Debug, Default)]
struct PointTree {
    blocks: Vec<PointBlock>,
    /// By groups, the balls around their blocks: side by side they are ruled out together.
    inner: Vec<Balls>,
    /// Balls around each [`GROUP`] consecutive blocks.
    groups: Vec<Balls>,
}

/// Balls processed together (SIMD).
#[derive(Clone, Copy, Debug)]
struct Balls {
    x: LaneValues,
    y: LaneValues,
    z: LaneValues,
    radius: LaneValues,
}

/// Number of points of a blade that a ball rules out together.
const CHUNK: usize = 32;
/// Number of blocks of a group.
const GROUP: usize = 6;

/// Points processed together (SIMD): neighbours on a line of a side.
const LANES: usize = 8;
type LaneValues = [f32; LANES];

#[derive(Clone, Copy, Debug)]
struct PointBlock {
    x: LaneValues,
    y: LaneValues,
    z: LaneValues,
    /// A ball around the points.
    centre: [f32; 3],
    radius: f32,
}

/// Dimensions of a cutter with what is wider above it, mm.
#[derive(Clone, Debug)]
pub(super) struct ToolShape {
    pub(super) radius: f64,
    pub(super) corner: f64,
    /// Shank and holder with their clearances, from bottom to top: heights above the centre of the corner,
    /// and radii; see [`Tool::assembly_steps`].
    pub(super) holder: Vec<(f64, f64)>,
}

/// Minimum distances of a cutter and its holder from points, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct MinDistances {
    pub(super) cutter: f64,
    pub(super) holder: f64,
}

/// Maximum spacing of neighbouring points along u, mm, and numbers of lines of constant v.
const SPACING: f64 = 2.0;
const RULED_LINES: usize = 6;
const BOWED_LINES: usize = 10;
/// Coordinate of padding points that no tool comes near to.
const FAR: f32 = -1e6;
/// Margin of the balls of blocks for rounding in single precision, mm.
const BALL_MARGIN: f32 = 0.01;

impl BladePoints {
    /// The points of `sides`, for a cutter whose axis keeps `reach` mm from them.
    pub(super) fn new(sides: &[BladeSide], reach: f64) -> Self {
        let mut points = Vec::new();
        let mut widest = 0.0f64;
        for side in sides {
            let lines = if side.is_ruled() { RULED_LINES } else { BOWED_LINES };
            let along = |v: f64, k: u32| {
                let u = f64::from(k) / 20.0;
                (side.point(u + 0.05, v) - side.point(u, v)).norm()
            };
            let longest = (0..20).map(|k| along(0.0, k).max(along(1.0, k))).fold(0.0, f64::max);
            let count = ((20.0 * longest / SPACING).ceil() as usize).clamp(20, 400);
            widest = widest.max(20.0 * longest / count as f64);
            for j in 0..lines {
                let v = j as f64 / (lines - 1) as f64;
                points.extend((0..=count).map(|i| side.point(i as f64 / count as f64, v)));
            }
        }
        Self::from_points(points, widest * widest / (8.0 * reach))
    }

    fn from_points(points: Vec<Point>, slack: f64) -> Self {
        let ball = |points: &[Point]| {
            let centre = points[points.len() / 2];
            (centre, points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max))
        };
        let balls = points.chunks(CHUNK).map(ball).collect();
        Self { points, balls, slack }
    }

    /// The points to which a tool whose corner is centred at `centre` could be nearer than `margin` mm with
    /// an axis of `cone`.
    pub(super) fn near(&self, centre: &Point, cone: &Cone, shape: &ToolShape, margin: f64) -> NearPoints {
        let (sin, cos) = cone.angle.sin_cos();
        let rim = shape.rim();
        let widest = shape.holder.iter().map(|(_, radius)| *radius).fold(0.0, f64::max);
        let lowest = shape.holder.iter().map(|(from, _)| *from).fold(f64::INFINITY, f64::min);
        let (column, holder) = (shape.radius + rim + margin, widest + rim + margin);
        let from = (lowest - rim).max(0.0).powi(2);
        let (mut beside_column, mut beside_holder) = (BlockMaker::default(), BlockMaker::default());
        // Squared distance from the centre, and a lower bound on the distance from the axes of the cone.
        let seen = |d: &Vector| {
            let squared = d.norm_squared();
            let along = d.dot(&cone.axis);
            let across = (squared - along * along).max(0.0).sqrt();
            (squared, if cone.angle < 1.5 { across * cos - along * sin } else { 0.0 })
        };
        let may_be_near = |(middle, radius): &(Point, f64)| {
            let (squared, off) = seen(&(middle - centre));
            off - radius < column.max(holder) || squared.sqrt() - radius < column
        };
        let near = self.balls.iter().zip(self.points.chunks(CHUNK)).filter(|(ball, _)| may_be_near(ball));
        for point in near.flat_map(|(_, points)| points) {
            let d = point - centre;
            let (squared, off) = seen(&d);
            if off < column || squared < column * column {
                beside_column.push(&d);
            }
            if squared > from && off < holder {
                beside_holder.push(&d);
            }
        }
        NearPoints { column: beside_column.into_tree(), holder: beside_holder.into_tree() }
    }
}

/// Collects points into blocks.
#[derive(Default)]
struct BlockMaker {
    points: Vec<[f32; 3]>,
}

impl BlockMaker {
    fn push(&mut self, d: &Vector) {
        self.points.push([d.x as f32, d.y as f32, d.z as f32]);
    }

    fn into_tree(self) -> PointTree {
        let blocks: Vec<PointBlock> = self.points.chunks(LANES).map(PointBlock::from_points).collect();
        let around: Vec<([f32; 3], f32)> = blocks.chunks(GROUP).map(ball_around).collect();
        let balls =
            |group: &[PointBlock]| Balls::from_balls(group.iter().map(|block| (block.centre, block.radius)));
        let inner = blocks.chunks(GROUP).map(balls).collect();
        let groups = around.chunks(LANES).map(|balls| Balls::from_balls(balls.iter().copied())).collect();
        PointTree { blocks, inner, groups }
    }
}

/// A ball around blocks: its centre, that of the block in the middle, and its radius.
fn ball_around(blocks: &[PointBlock]) -> ([f32; 3], f32) {
    let centre = blocks[blocks.len() / 2].centre;
    let reach = |block: &PointBlock| {
        let [dx, dy, dz]: [f32; 3] = std::array::from_fn(|k| block.centre[k] - centre[k]);
        (dx * dx + dy * dy + dz * dz).sqrt() + block.radius
    };
    (centre, blocks.iter().map(reach).fold(0.0, f32::max) + BALL_MARGIN)
}

impl Balls {
    /// At most [`LANES`] balls.
    fn from_balls(balls: impl Iterator<Item = ([f32; 3], f32)>) -> Self {
        let mut all = Self { x: [0.0; LANES], y: [0.0; LANES], z: [FAR; LANES], radius: [0.0; LANES] };
        for (k, ([x, y, z], radius)) in balls.enumerate() {
            (all.x[k], all.y[k], all.z[k], all.radius[k]) = (x, y, z, radius);
        }
        all
    }
}

impl PointTree {
    /// Passes the blocks to `look`, those first that `bound` puts nearest to the tool, as they rule out most
    /// others: lower bounds on the distances of the points in balls, by the heights of their centres, the
    /// distances of these from the axis, and their radii. `look` gets the distance found so far, `nearest` at
    /// first, and returns the next; the search ends below `enough`.
    #[inline(always)]
    fn descend(
        &self,
        ray: &RelativeAxis,
        (nearest, enough): (f64, f64),
        bound: impl Fn(&LaneValues, &LaneValues, &LaneValues) -> LaneValues,
        mut look: impl FnMut(&PointBlock, f64) -> f64,
    ) -> f64 {
        let bounds = |balls: &Balls| {
            let (up, mut radial) = ray.seen(&balls.x, &balls.y, &balls.z);
            for k in 0..LANES {
                radial[k] = radial[k].sqrt();
            }
            bound(&up, &radial, &balls.radius)
        };
        let mut first = (f32::INFINITY, 0);
        for (row, balls) in self.groups.iter().enumerate() {
            for (k, &bound) in bounds(balls).iter().enumerate() {
                if bound < first.0 {
                    first = (bound, row * LANES + k);
                }
            }
        }
        let mut found = nearest;
        let mut group = |number: usize, found: f64| {
            let Some(balls) = self.inner.get(number) else { return found };
            let (blocks, bounds) = (&self.blocks[number * GROUP..], bounds(balls));
            blocks.iter().zip(&bounds[..GROUP]).fold(found, |found, (block, &bound)| {
                if f64::from(bound) < found { look(block, found) } else { found }
            })
        };
        if f64::from(first.0) < found {
            found = group(first.1, found);
        }
        for (row, balls) in self.groups.iter().enumerate() {
            for (k, &bound) in bounds(balls).iter().enumerate() {
                if found < enough {
                    return found;
                }
                let number = row * LANES + k;
                if f64::from(bound) < found && number != first.1 {
                    found = group(number, found);
                }
            }
        }
        found
    }
}

impl PointBlock {
    /// The block of at most [`LANES`] points.
    fn from_points(points: &[[f32; 3]]) -> Self {
        let centre = points[points.len() / 2];
        let mut block = Self { x: [0.0; LANES], y: [0.0; LANES], z: [FAR; LANES], centre, radius: 0.0 };
        for (k, &[x, y, z]) in points.iter().enumerate() {
            (block.x[k], block.y[k], block.z[k]) = (x, y, z);
            let (dx, dy, dz) = (x - centre[0], y - centre[1], z - centre[2]);
            block.radius = block.radius.max((dx * dx + dy * dy + dz * dz).sqrt() + BALL_MARGIN);
        }
        block
    }
}

impl ToolShape {
    pub(super) fn from_tool(tool: &Tool, clearances: &ClearanceSetup) -> Self {
        let above_corner = |(from, radius)| (from - tool.corner_radius, radius);
        Self {
            radius: tool.radius(),
            corner: tool.corner_radius,
            holder: tool.assembly_steps(clearances).into_iter().map(above_corner).collect(),
        }
    }

    /// Radius of the bottom without its corner, mm.
    pub(super) fn rim(&self) -> f64 {
        self.radius - self.corner
    }
}

/// A tool axis relative to the points, in single precision.
struct RelativeAxis {
    axis: [f32; 3],
    offset: [f32; 3],
}

impl RelativeAxis {
    /// Heights of points along the axis, and their squared distances from it. Loops over arrays without
    /// branches become SIMD instructions; over points one by one they do not.
    #[inline(always)]
    fn seen(&self, x: &LaneValues, y: &LaneValues, z: &LaneValues) -> (LaneValues, LaneValues) {
        let [ax, ay, az] = self.axis;
        let [ox, oy, oz] = self.offset;
        let (mut up, mut squared) = ([0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let (x, y, z) = (x[k] - ox, y[k] - oy, z[k] - oz);
            let along = x * ax + y * ay + z * az;
            (up[k], squared[k]) = (along, greater(x * x + y * y + z * z - along * along, 0.0));
        }
        (up, squared)
    }
}

impl NearPoints {
    /// Minimum distances of a tool with unit `axis`, up to those of `most`. `offset` is the position of the
    /// centre of its bottom, a corner radius above the tip, relative to the origin of the points. Stops as
    /// soon as one distance is below `enough`.
    pub(super) fn min_distances(
        &self,
        shape: &ToolShape,
        axis: &Vector,
        offset: &Vector,
        enough: MinDistances,
        most: MinDistances,
    ) -> MinDistances {
        let single = |v: &Vector| [v.x as f32, v.y as f32, v.z as f32];
        let ray = RelativeAxis { axis: single(axis), offset: single(offset) };
        let cutter = if shape.rim() < 1e-6 {
            self.column_min::<true>(shape, &ray, (most.cutter, enough.cutter))
        } else {
            self.column_min::<false>(shape, &ray, (most.cutter, enough.cutter))
        };
        let holder = if cutter < enough.cutter {
            most.holder
        } else {
            self.holder_min(&shape.holder, &ray, (most.holder, enough.holder))
        };
        MinDistances { cutter, holder }
    }

    /// Minimum distance of the points from what is wider above the cutter, given by `steps` of
    /// [`ToolShape::holder`], up to `most`; any distance below `enough` will do.
    ///
    /// All steps are looked at together, as they pass over the same balls.
    fn holder_min(&self, steps: &[(f64, f64)], ray: &RelativeAxis, (most, enough): (f64, f64)) -> f64 {
        // The widest step that a ball may be beside is the highest one.
        let bound = |up: &LaneValues, radial: &LaneValues, ball: &LaneValues| {
            let mut widest = [f32::NEG_INFINITY; LANES];
            for &(from, radius) in steps {
                let (from, radius) = (from as f32, radius as f32);
                for k in 0..LANES {
                    widest[k] = if up[k] + ball[k] < from { widest[k] } else { radius };
                }
            }
            std::array::from_fn(|k| radial[k] - ball[k] - widest[k])
        };
        let look = |block: &PointBlock, mut found: f64| {
            let (up, squared) = ray.seen(&block.x, &block.y, &block.z);
            for &(from, radius) in steps {
                let from = from as f32;
                let mut least = [f32::MAX; LANES];
                for k in 0..LANES {
                    least[k] = if up[k] >= from { squared[k] } else { f32::MAX };
                }
                found = found.min(f64::from(lane_min(&least)).sqrt() - radius);
            }
            found
        };
        self.holder.descend(ray, (most, enough), bound, look)
    }

    /// Minimum distance of the cutter from the points, up to `most`; any distance below `enough` will do.
    fn column_min<const BALL: bool>(
        &self,
        shape: &ToolShape,
        ray: &RelativeAxis,
        (most, enough): (f64, f64),
    ) -> f64 {
        let rim = shape.rim() as f32;
        let (radius, corner) = (shape.radius as f32, shape.corner as f32);
        // No point of a ball is nearer than the ball, seen from the side or from below.
        let bound = |up: &LaneValues, radial: &LaneValues, ball: &LaneValues| {
            std::array::from_fn(|k| greater(radial[k] - radius, -up[k] - corner) - ball[k])
        };
        let look = |block: &PointBlock, found: f64| {
            let (up, squared) = ray.seen(&block.x, &block.y, &block.z);
            let (mut beside, mut under) = ([f32::MAX; LANES], [f32::MAX; LANES]);
            for k in 0..LANES {
                let beyond = if BALL {
                    squared[k]
                } else {
                    let beyond = greater(squared[k].sqrt() - rim, 0.0);
                    beyond * beyond
                };
                let below = beyond + up[k] * up[k];
                beside[k] = if up[k] >= 0.0 { squared[k] } else { f32::MAX };
                under[k] = if up[k] >= 0.0 { f32::MAX } else { below };
            }
            let side = f64::from(lane_min(&beside)).sqrt() - shape.radius;
            let bottom = f64::from(lane_min(&under)).sqrt() - shape.corner;
            found.min(side).min(bottom)
        };
        self.column.descend(ray, (most, enough), bound, look)
    }
}

/// The greater of two numbers, of which neither is NaN: one instruction, unlike [`f32::max`].
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lane_min(row: &LaneValues) -> f32 {
    let less = |a: f32, b: f32| if a < b { a } else { b };
    let four: [f32; LANES / 2] = std::array::from_fn(|k| less(row[k], row[k + LANES / 2]));
    less(less(four[0], four[2]), less(four[1], four[3]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::norm2;

    /// Deterministic pseudorandom numbers from −1 to 1.
    fn dice(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    #[test]
    fn blocks_that_are_passed_over_leave_the_distances_as_they_are() {
        let mut seed = 3;
        let lines = (0..24).flat_map(|k| {
            let (x, y) = (30.0 * dice(&mut seed), 30.0 * dice(&mut seed));
            (0..61).map(move |i| Point::new(x + 0.1 * f64::from(k), y, f64::from(i) - 20.0))
        });
        let blades = BladePoints::from_points(lines.collect(), 0.0);
        let cone = Cone { axis: Vector::z(), angle: std::f64::consts::PI };
        let none = MinDistances { cutter: f64::NEG_INFINITY, holder: f64::NEG_INFINITY };
        let far = MinDistances { cutter: f64::INFINITY, holder: f64::INFINITY };
        for (corner, case) in [4.0, 1.0, 0.0].into_iter().zip(0..) {
            let shape = ToolShape { radius: 4.0, corner, holder: vec![(25.0, 9.0), (40.0, 14.0)] };
            for _ in 0..60 {
                let mut random = || Vector::new(dice(&mut seed), dice(&mut seed), dice(&mut seed));
                let (centre, axis, offset) = (Point::from(random() * 20.0), random().normalize(), random());
                let near = blades.near(&centre, &cone, &shape, 1e3);
                let near = near.min_distances(&shape, &axis, &offset, none, far);
                let (mut cutter, mut holder) = (f64::INFINITY, f64::INFINITY);
                for point in &blades.points {
                    let d = point - centre - offset;
                    let up = d.dot(&axis);
                    let radial = (d - axis * up).norm();
                    let beyond = (radial - shape.rim()).max(0.0);
                    let bottom = norm2(beyond, up) - corner;
                    cutter = cutter.min(if up >= 0.0 { radial - shape.radius } else { bottom });
                    for (from, radius) in &shape.holder {
                        if up >= *from {
                            holder = holder.min(radial - radius);
                        }
                    }
                }
                assert!((near.cutter - cutter).abs() < 1e-3, "corner {case}: {} for {cutter}", near.cutter);
                let none = holder.is_infinite() && near.holder > 1e9;
                assert!(none || (near.holder - holder).abs() < 1e-3, "{} for {holder}", near.holder);
            }
        }
    }
}
