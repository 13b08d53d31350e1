//! The stock as a solid, for drawing.

use rayon::prelude::*;

use crate::gpu::mesh::{Mesh, Paint, Vertex};
use crate::monitor::{Cancelled, Monitor};
use crate::palette;
use crate::stock::excess::Excess;
use crate::stock::solid::{SpanEnd, StockSurface};

/// Depth below the finished surface from which stock is drawn as a gouge, mm and spacings: the vertices of a
/// surface are as exact as the rays, those on sharp edges less.
const GOUGE: (f64, f64) = (0.02, 0.1);
/// Vertices between two checks of the monitor.
const CHUNK: usize = 1 << 14;

/// The triangles of `surface`, on rays at `spacing` mm. `paint` gives the colour of what a move has cut, by
/// its number; with `excess` the vertices carry the distance to the finished part, mm, and gouges their own
/// colour.
///
/// # Errors
/// When `monitor` is cancelled.
pub fn solid_mesh(
    surface: &StockSurface,
    spacing: f64,
    excess: Option<&Excess>,
    paint: impl Fn(u32) -> Paint + Sync,
    monitor: &Monitor,
) -> Result<Mesh, Cancelled> {
    let gouge = GOUGE.0.max(GOUGE.1 * spacing);
    let vertex = |k: usize| {
        let (point, normal, cut_by) = (&surface.points[k], &surface.normals[k], surface.cut_by[k]);
        let is_sharp = normal.norm_squared() < 0.25;
        let mut paint = paint(cut_by);
        let mut value = 0.0;
        if let Some(excess) = excess.filter(|_| cut_by != SpanEnd::BLANK || is_sharp) {
            value = excess.at(point);
            if value < -gouge && !is_sharp {
                paint = Paint::colour(palette::INTERFERING);
            }
        }
        Vertex::painted(
            [point.x as f32, point.y as f32, point.z as f32],
            [normal.x as f32, normal.y as f32, normal.z as f32],
            value as f32,
            paint,
        )
    };
    let mut vertices = Vec::with_capacity(surface.points.len());
    for first in (0..surface.points.len()).step_by(CHUNK) {
        monitor.check()?;
        let until = (first + CHUNK).min(surface.points.len());
        vertices.par_extend((first..until).into_par_iter().map(vertex));
    }
    // A triangle has the colour of its first corner. Corners on sharp edges belong to two surfaces.
    let smooth = |i: u32| surface.normals[i as usize].norm_squared() > 0.25;
    let indices = surface.triangles.iter().flat_map(|&[a, b, c]| match (smooth(a), smooth(b)) {
        (true, _) => [a, b, c],
        (false, true) => [b, c, a],
        (false, false) => [c, a, b],
    });
    Ok(Mesh { indices: indices.collect(), vertices })
}
