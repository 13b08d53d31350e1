//! The faces at an end of a slice: a leading edge that is blunt, or chamfered, between sharp edges.
//!
//! They lie between the two corners of the slice over which it turns back, whichever of their points is
//! furthest upstream: blunt edges are as good as at right angles to the channel, so that this point jumps
//! from one of their corners to the other from height to height.

use super::sections::{SlicePoint, knots_of};
use crate::geometry::Vector;
use crate::geometry::cubic::Cubic;

/// Distance from the end within which corners are looked for, and largest length of the faces of an end, as
/// shares of the length of the slice: those of the sides are further away.
const REACH: f64 = 0.15;
/// Distance from the end within which the faces are whatever their length, as a share of the length.
const NEAR: f64 = 0.01;
/// Largest cosine between the directions of the slice before and behind an end.
const BACK: f64 = -0.4;
/// The faces that turn the slice back as far as any but for this are enough.
const AS_FAR: f64 = 0.04;
/// The directions are taken over this share of the length of the faces, and of the slice at least.
const ARM: (f64, f64) = (0.25, 0.005);

/// A nose ends where the cosine between its direction and that at the foremost point falls below this.
const NOSE_TURN: f64 = 0.5;
/// The same for all of a nose, up to where its direction is that of the sides.
const WHOLE_NOSE_TURN: f64 = 0.1;
/// A seam within this many times the distance of another one from the foremost point is that of a nose with a
/// face of its own.
const NEAR_SEAM: f64 = 4.0;

/// Faces of an end of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndFaces {
    /// Index of the point at which they begin.
    pub from: usize,
    /// Index of the point at which they end; the same where there is only a sharp corner.
    pub to: usize,
}

impl EndFaces {
    /// The faces of the end at the point `at`. `step` gives the index of the next point, forward or not.
    pub fn find(
        points: &[SlicePoint],
        step: &impl Fn(usize, bool) -> Option<usize>,
        at: usize,
    ) -> Option<Self> {
        let between = |a: usize, b: usize| (points[b].point - points[a].point).norm();
        let whole: f64 = (0..points.len()).filter_map(|i| Some(between(i, step(i, true)?))).sum();
        // Corners with their distance along the slice from `at`, which is negative behind it.
        let mut corners: Vec<(f64, usize)> = Vec::new();
        for (forward, sign) in [(false, -1.0), (true, 1.0)] {
            let (mut here, mut way) = (at, 0.0);
            while way < REACH * whole {
                if points[here].edge {
                    corners.push((sign * way, here));
                }
                let Some(next) = step(here, forward) else { break };
                way += between(here, next);
                here = next;
            }
        }
        corners.sort_by(|a, b| a.0.total_cmp(&b.0));
        corners.dedup_by_key(|b| b.1);
        let direction = |from: usize, forward: bool, arm: f64| -> Option<Vector> {
            let (mut here, mut way) = (from, 0.0);
            while way < arm {
                let next = step(here, forward)?;
                way += between(here, next);
                here = next;
            }
            (points[here].point - points[from].point).try_normalize(1e-12)
        };
        let mut found: Vec<(f64, f64, Self)> = Vec::new();
        for (k, &(a, from)) in corners.iter().enumerate() {
            for &(b, to) in &corners[k..] {
                let length = b - a;
                let away = a.max(-b).max(0.0);
                if length > REACH * whole || away > length.max(NEAR * whole) {
                    continue;
                }
                let arm = (ARM.0 * length).max(ARM.1 * whole);
                if let (Some(before), Some(behind)) = (direction(from, false, arm), direction(to, true, arm))
                {
                    // Both lead away from the end: they are alike where the slice turns back.
                    found.push((-before.dot(&behind), length, Self { from, to }));
                }
            }
        }
        let furthest = found.iter().map(|f| f.0).fold(f64::INFINITY, f64::min);
        let enough = found.into_iter().filter(|f| f.0 < BACK && f.0 < furthest + AS_FAR);
        enough.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(.., faces)| faces)
    }

    /// The point half way along the faces, and the indices of the points behind it and before it.
    pub fn middle(
        &self,
        points: &[SlicePoint],
        step: &impl Fn(usize, bool) -> Option<usize>,
    ) -> Option<(SlicePoint, [usize; 2])> {
        let mut run = vec![self.from];
        while *run.last()? != self.to {
            run.push(step(*run.last()?, true)?);
        }
        if run.len() == 1 {
            return Some((points[self.from], [self.from; 2]));
        }
        let values: Vec<[f64; 4]> = run.iter().map(|&i| points[i].values()).collect();
        let knots = knots_of(&values)?;
        let corners: Vec<usize> = (1..run.len() - 1).filter(|&k| points[run[k]].edge).collect();
        let half = 0.5 * knots[knots.len() - 1];
        let middle = Cubic::interpolate_with_corners(&knots, &values, &corners).point(half);
        let behind = knots.partition_point(|k| *k <= half).min(run.len() - 1);
        let before = knots.partition_point(|k| *k < half).max(1) - 1;
        Some((SlicePoint::from_values(middle), [run[behind], run[before]]))
    }
}

/// The point on a round nose where the mesh's faces of both sides meet; `None` unless there is exactly one.
/// The division of a nose is arbitrary, but all measures along the sides start from it, so the file's own is
/// kept.
pub fn find_nose_seam(
    points: &[SlicePoint],
    step: &impl Fn(usize, bool) -> Option<usize>,
    lowest: usize,
) -> Option<usize> {
    find_one(points, step, lowest, |p| p.seam, NOSE_TURN)
}

/// As [`find_nose_seam`], of the points where two faces meet in a seam or a corner, and over all of the nose:
/// the line on which the sides meet leaves the foremost point where the blades wrap.
pub fn find_nose_line(
    points: &[SlicePoint],
    step: &impl Fn(usize, bool) -> Option<usize>,
    lowest: usize,
) -> Option<usize> {
    find_one(points, step, lowest, |p| p.seam || p.edge, WHOLE_NOSE_TURN)
}

/// The point of a nose for which `meets` holds, if there is exactly one where its direction has turned by
/// less than the angle with the cosine `turn`.
fn find_one(
    points: &[SlicePoint],
    step: &impl Fn(usize, bool) -> Option<usize>,
    lowest: usize,
    meets: impl Fn(&SlicePoint) -> bool,
    turn: f64,
) -> Option<usize> {
    let direction = |i: usize| {
        let (next, previous) = (step(i, true).unwrap_or(i), step(i, false).unwrap_or(i));
        (points[next].point - points[previous].point).try_normalize(1e-12)
    };
    let foremost = direction(lowest)?;
    let mut found = meets(&points[lowest]).then_some(lowest);
    for forward in [true, false] {
        let mut at = lowest;
        for _ in 0..points.len() / 2 {
            at = step(at, forward)?;
            if direction(at)?.dot(&foremost) < turn {
                break;
            }
            if meets(&points[at]) && found.replace(at).is_some() {
                return None;
            }
        }
    }
    // A nose may be a face of its own, of which one seam is on the nose and the other just behind it.
    let seam = found?;
    let from = points[lowest].point;
    let near = NEAR_SEAM * (points[seam].point - from).norm();
    for forward in [true, false] {
        let mut at = lowest;
        for _ in 0..points.len() / 2 {
            at = step(at, forward)?;
            if (points[at].point - from).norm() > near {
                break;
            }
            if meets(&points[at]) && at != seam {
                return None;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    /// A closed slice through points in a plane, of which those with `true` are corners.
    fn slice(outline: &[(f64, f64, bool)]) -> Vec<SlicePoint> {
        let point = |&(x, y, edge): &(f64, f64, bool)| SlicePoint {
            point: Point::new(x, y, 0.0),
            along: x,
            edge,
            seam: false,
            chord_offset_mm: 0.0,
        };
        outline.iter().map(point).collect()
    }

    /// A blade of 1 mm from x = 0, with a sharp trailing edge at x = 40, and the points of its leading edge.
    fn blade(leading: &[(f64, f64, bool)]) -> Vec<SlicePoint> {
        let side =
            |sign: f64| (1..40).map(move |k| (f64::from(k), sign * 0.5 * (1.0 - f64::from(k) / 40.0), false));
        let back = side(-1.0).collect::<Vec<_>>().into_iter().rev();
        let all: Vec<(f64, f64, bool)> =
            side(1.0).chain([(40.0, 0.0, true)]).chain(back).chain(leading.iter().copied()).collect();
        slice(&all)
    }

    fn ends(points: &[SlicePoint]) -> Option<(EndFaces, Point)> {
        let n = points.len();
        let step = |i: usize, forward: bool| Some(if forward { (i + 1) % n } else { (i + n - 1) % n });
        let lowest = (0..n).min_by(|&a, &b| points[a].along.total_cmp(&points[b].along))?;
        let faces = EndFaces::find(points, &step, lowest)?;
        Some((faces, faces.middle(points, &step)?.0.point))
    }

    #[test]
    fn a_blunt_end_has_its_middle_whichever_corner_is_upstream() {
        for lean in [-0.05, 0.0, 0.05] {
            let points = blade(&[(lean, -0.5, true), (0.0, 0.0, false), (-lean, 0.5, true)]);
            let (_, middle) = ends(&points).expect("it is blunt");
            assert!(middle.coords.norm() < 1e-9, "{middle} with {lean}");
        }
        let chamfered = [(0.3, -0.5, true), (0.0, -0.2, true), (0.001, 0.1, true), (0.4, 0.5, true)];
        let (faces, _) = ends(&blade(&chamfered)).expect("it is chamfered");
        assert_eq!([faces.from, faces.to].map(|i| blade(&chamfered)[i].point.y.abs()), [0.5, 0.5]);
    }

    #[test]
    fn a_sharp_end_is_its_corner_and_a_round_one_has_no_faces() {
        let wedge = [(0.8, -0.3, false), (0.0, 0.1, true), (0.8, 0.4, false)];
        let (faces, corner) = ends(&blade(&wedge)).expect("it is sharp");
        assert!(faces.from == faces.to && corner == Point::new(0.0, 0.1, 0.0), "{corner}");
        let arc = |k: i32| f64::from(k) * std::f64::consts::PI / 12.0;
        let nose: Vec<(f64, f64, bool)> =
            (0..=12).map(|k| (0.5 - 0.5 * arc(k).sin(), -0.5 * arc(k).cos(), false)).collect();
        assert_eq!(ends(&blade(&nose)), None);
    }
}
