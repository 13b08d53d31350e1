//! Normal, height and depth at a point where a ray meets a piece.

use super::{PieceOnRays, TINY};
use crate::geometry::{Vector, norm2};

impl PieceOnRays<'_> {
    /// Unit normal out of the swept body at the point `t` of the ray, reached at `share`.
    pub fn normal(&self, origin: &[f64; 3], t: f64, share: f64) -> Vector {
        let outline = &self.piece.outline;
        let at: [f64; 3] = std::array::from_fn(|k| origin[k] + t * self.ray[k] - share * self.travel[k]);
        let radial = norm2(at[0], at[1]);
        let (side, end) = match outline.corner {
            Some((flat, corner)) => {
                let (out, down) = ((radial - flat).max(0.0), (corner - at[2]).max(0.0));
                let out = out / radial.max(TINY);
                ([at[0] * out, at[1] * out, -down], None)
            }
            None => {
                let up = outline.alpha * at[2] + outline.beta;
                let height = at[2].min(outline.length - at[2]);
                let end = [0.0, 0.0, if at[2] < 0.5 * outline.length { -1.0 } else { 1.0 }];
                let off = (outline.radius_at(at[2].clamp(0.0, outline.length)) - radial).abs();
                let tolerance = 1e-6 * (1.0 + outline.radius);
                let side = [at[0], at[1], up];
                match (off < tolerance, height < tolerance) {
                    (true, true) => (side, Some(end)),
                    (false, true) => (end, None),
                    (false, false) if height < off => (end, None),
                    _ => (side, None),
                }
            }
        };
        let unit = |v: [f64; 3]| Vector::from(v).try_normalize(1e-300).unwrap_or_else(Vector::z);
        let mut local = unit(side);
        if let Some(end) = end.filter(|_| self.moves && share > 0.0 && share < 1.0) {
            // The moving edge sweeps a surface that contains the travel: the normal across it, between those
            // of both faces.
            let (end, travel) = (Vector::from(end), Vector::from(self.travel));
            let across = local * end.dot(&travel) - end * local.dot(&travel);
            let outwards = if across.dot(&(local + end)) < 0.0 { -across } else { across };
            local = outwards.try_normalize(1e-12).unwrap_or(local);
        }
        self.frame[0] * local.x + self.frame[1] * local.y + self.frame[2] * local.z
    }

    /// Height above the lower end of the whole part at the point `t` of a ray, mm.
    pub fn height(&self, origin: &[f64; 3], t: f64) -> f64 {
        self.piece.above + origin[2] + t * self.ray[2]
    }

    /// How deep the points `low` to `high` of a ray get into the piece on its way, mm, and where.
    pub fn depth(&self, origin: &[f64; 3], low: f64, high: f64) -> (f64, f64) {
        /// Points tried along ray and travel.
        const TRIED: u32 = 8;
        let outline = &self.piece.outline;
        let mut deepest = (0.0, 0.5 * (low + high));
        for i in 0..=TRIED {
            let t = low + (high - low) * f64::from(i) / f64::from(TRIED);
            for j in 0..=if self.moves { TRIED } else { 0 } {
                let share = f64::from(j) / f64::from(TRIED);
                let at: [f64; 3] =
                    std::array::from_fn(|k| origin[k] + t * self.ray[k] - share * self.travel[k]);
                if (0.0..=outline.length).contains(&at[2]) {
                    let in_side = outline.radius_at(at[2]) - norm2(at[0], at[1]);
                    let depth = in_side.min(self.piece.above + at[2]);
                    if depth > deepest.0 {
                        deepest = (depth, t);
                    }
                }
            }
        }
        deepest
    }
}
