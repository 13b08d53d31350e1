//! Boxes around the edges of a meridional outline: a tree, each box with its edges or with smaller ones.

use crate::geometry::Meridional;

/// Points closer together than this are merged, mm; edges nearer to the axis than this do not bound the body.
pub(super) const SAME: f64 = 1e-6;
/// Edges in a leaf of the tree.
const LEAF: usize = 4;

/// A box around consecutive edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeBox {
    pub(super) low: Meridional,
    pub(super) high: Meridional,
    /// The edges of a leaf; empty for other boxes.
    pub(super) edges: (u32, u32),
    /// The next box that is not in this one.
    pub(super) next: u32,
}

/// Adds the box around edges `from` to `to`, and those in it.
pub(super) fn add_boxes(
    edges: &[(Meridional, Meridional)],
    from: usize,
    to: usize,
    boxes: &mut Vec<EdgeBox>,
) {
    if from >= to {
        return;
    }
    let infinite = Meridional { r: f64::INFINITY, z: f64::INFINITY };
    let (mut low, mut high) = (infinite, Meridional { r: -infinite.r, z: -infinite.z });
    for p in edges[from..to].iter().flat_map(|(a, b)| [a, b]) {
        low = Meridional { r: low.r.min(p.r), z: low.z.min(p.z) };
        high = Meridional { r: high.r.max(p.r), z: high.z.max(p.z) };
    }
    let index = boxes.len();
    let is_leaf = to - from <= LEAF;
    let own = if is_leaf { (from as u32, to as u32) } else { (0, 0) };
    boxes.push(EdgeBox { low, high, edges: own, next: 0 });
    if !is_leaf {
        let middle = from.midpoint(to);
        add_boxes(edges, from, middle, boxes);
        add_boxes(edges, middle, to, boxes);
    }
    boxes[index].next = boxes.len() as u32;
}
