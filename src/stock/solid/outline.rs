//! Outlines of the slices of a tool.

/// Outline of a slice of a body of revolution over heights 0 to `length` above its lower end. With x, y
/// across the axis and z along it, its inside is x² + y² + α z² + 2 β z + γ ≤ 0: a cylinder, a cone or a
/// ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    pub(super) alpha: f64,
    pub(super) beta: f64,
    pub(super) gamma: f64,
    /// Height, mm.
    pub length: f64,
    /// Largest radius, mm.
    pub radius: f64,
    /// (ρ, c) where the lower end is a rounded corner of radius c about a flat disc of radius ρ. The quadric
    /// is then the cylinder around it.
    pub(super) corner: Option<(f64, f64)>,
}

impl Outline {
    /// A cylinder, or a cone between two radii.
    pub fn cone(lower: f64, upper: f64, length: f64) -> Self {
        let slope = if length > 0.0 { (upper - lower) / length } else { 0.0 };
        Self {
            alpha: -slope * slope,
            beta: -slope * lower,
            gamma: -lower * lower,
            length,
            radius: lower.max(upper),
            corner: None,
        }
    }

    /// The part of a ball of `radius` up to `length` above its lowest point.
    pub fn ball(radius: f64, length: f64) -> Self {
        let widest = if length >= radius { radius } else { (length * (2.0 * radius - length)).sqrt() };
        Self { alpha: 1.0, beta: -radius, gamma: 0.0, length, radius: widest, corner: None }
    }

    /// A flat disc of radius `flat` with a rounded corner of radius `corner` around it, up to `length`. It
    /// can stand still only.
    pub fn rounded(flat: f64, corner: f64, length: f64) -> Self {
        let up = (corner - length).max(0.0);
        let widest = flat + (corner * corner - up * up).max(0.0).sqrt();
        Self { corner: Some((flat, corner)), ..Self::cone(widest, widest, length) }
    }

    /// The radius of a ball; `None` for other outlines.
    pub fn ball_radius(&self) -> Option<f64> {
        (self.alpha > 0.0).then_some(-self.beta)
    }

    /// Radius at a height, mm.
    pub fn radius_at(&self, height: f64) -> f64 {
        match self.corner {
            Some((flat, corner)) => {
                let up = (corner - height).clamp(0.0, corner);
                flat + (corner * corner - up * up).max(0.0).sqrt()
            }
            None => (-(self.alpha * height * height + 2.0 * self.beta * height + self.gamma)).max(0.0).sqrt(),
        }
    }
}
