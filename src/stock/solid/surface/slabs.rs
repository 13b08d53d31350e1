//! Slabs of the surface, which are made each by itself, and their union.

use rayon::prelude::*;

use crate::geometry::{Point, Vector};

/// Marks the number of a vertex that the slab before has, too.
pub const SHARED: u32 = 1 << 31;

/// A side of a fan around a sharp vertex: its ends, and its triangle.
pub type FanSide = ((u32, u32), u32);

/// Vertices with their attributes.
#[derive(Default)]
pub struct Vertices {
    /// Positions, mm.
    pub points: Vec<Point>,
    /// Unit normals; zero on sharp edges.
    pub normals: Vec<Vector>,
    /// Numbers of the moves that cut them.
    pub cut_by: Vec<u32>,
}

impl Vertices {
    /// An empty list with room for `count` vertices.
    pub fn with_capacity(count: usize) -> Self {
        Self {
            points: Vec::with_capacity(count),
            normals: Vec::with_capacity(count),
            cut_by: Vec::with_capacity(count),
        }
    }

    /// Adds a vertex and returns its number.
    pub fn push(&mut self, point: Point, normal: Vector, cut_by: u32) -> u32 {
        self.points.push(point);
        self.normals.push(normal);
        self.cut_by.push(cut_by);
        self.points.len() as u32 - 1
    }
}

/// Triangles of some planes of cells.
#[derive(Default)]
pub struct Slab {
    /// Vertices that no slab before has.
    pub own: Vertices,
    /// Vertices in the first plane of nodes, which are those of the slab before; their numbers are
    /// [`SHARED`].
    pub shared: Vertices,
    /// Three numbers of vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices in the first plane of nodes, by the number of their edge in it.
    pub first: Vec<(u32, u32)>,
    /// Those in the last plane.
    pub last: Vec<(u32, u32)>,
    /// The sides of the fans around its sharp vertices.
    pub sides: Vec<FanSide>,
}

/// Slabs with the numbers of their vertices and triangles in the whole surface.
pub struct NumberedSlabs {
    slabs: Vec<Slab>,
    /// Number of the first vertex and of the first triangle of each slab, and of all.
    vertices: Vec<usize>,
    triangles: Vec<usize>,
    /// Numbers of the shared vertices of each slab.
    shared: Vec<Vec<u32>>,
}

impl NumberedSlabs {
    /// Numbers the vertices and triangles of `slabs`, which are in order.
    pub fn new(slabs: Vec<Slab>) -> Self {
        let sums = |count: &dyn Fn(&Slab) -> usize| -> Vec<usize> {
            let ends = slabs.iter().scan(0, |sum, slab| {
                *sum += count(slab);
                Some(*sum)
            });
            std::iter::once(0).chain(ends).collect()
        };
        let (vertices, triangles) = (sums(&|slab| slab.own.points.len()), sums(&|slab| slab.triangles.len()));
        let shared = (0..slabs.len())
            .into_par_iter()
            .map(|s| {
                let mut numbers = vec![0; slabs[s].shared.points.len()];
                if s > 0 {
                    let (mut ours, mut theirs) = (slabs[s].first.clone(), slabs[s - 1].last.clone());
                    ours.sort_unstable();
                    theirs.sort_unstable();
                    let mut theirs = theirs.into_iter().peekable();
                    for (edge, own) in ours {
                        while theirs.next_if(|(other, _)| *other < edge).is_some() {}
                        let same = theirs.next_if(|(other, _)| *other == edge);
                        debug_assert!(same.is_some(), "cells on both sides of a plane cross the same edges");
                        if let Some((_, there)) = same {
                            numbers[(own - SHARED) as usize] = vertices[s - 1] as u32 + there;
                        }
                    }
                }
                numbers
            })
            .collect();
        Self { slabs, vertices, triangles, shared }
    }

    /// The number in the whole surface of vertex `own` of slab `s`.
    fn vertex(&self, s: usize, own: u32) -> u32 {
        if own < SHARED { self.vertices[s] as u32 + own } else { self.shared[s][(own - SHARED) as usize] }
    }

    /// What all slabs have, in order: `item(s, k)` is item k of slab s; `ends` are as [`Self::vertices`].
    fn gather<T: Send>(ends: &[usize], item: impl Fn(usize, usize) -> T + Sync) -> Vec<T> {
        let count = ends[ends.len() - 1];
        (0..count)
            .into_par_iter()
            .map_init(
                || 0,
                |s, k| {
                    // Neighbours are mostly of the same slab.
                    if !(ends[*s]..ends[*s + 1]).contains(&k) {
                        *s = ends.partition_point(|end| *end <= k) - 1;
                    }
                    item(*s, k - ends[*s])
                },
            )
            .collect()
    }

    /// All vertices, all triangles, and the sides of the fans around the sharp vertices.
    pub fn joined(&self) -> (Vertices, Vec<[u32; 3]>, Vec<FanSide>) {
        let slabs = &self.slabs;
        let vertices = Vertices {
            points: Self::gather(&self.vertices, |s, k| slabs[s].own.points[k]),
            normals: Self::gather(&self.vertices, |s, k| slabs[s].own.normals[k]),
            cut_by: Self::gather(&self.vertices, |s, k| slabs[s].own.cut_by[k]),
        };
        let triangles =
            Self::gather(&self.triangles, |s, k| slabs[s].triangles[k].map(|own| self.vertex(s, own)));
        let mut sides: Vec<FanSide> = Vec::with_capacity(slabs.iter().map(|slab| slab.sides.len()).sum());
        for (s, slab) in slabs.iter().enumerate() {
            sides.extend(slab.sides.iter().map(|&((a, b), t)| {
                let (a, b) = (self.vertex(s, a), self.vertex(s, b));
                ((a.min(b), a.max(b)), t + self.triangles[s] as u32)
            }));
        }
        (vertices, triangles, sides)
    }
}
