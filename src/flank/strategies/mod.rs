//! Strategies: how a layer is filled with pass curves.

mod balanced;
mod isoparametric;
mod pass_curve;
mod regions;

pub use balanced::balanced;
pub use isoparametric::{isoparametric, isoparametric_by_region};
pub use pass_curve::{PassCurve, PassRole};
pub use regions::regions;
