//! The body of the wheel under the hub: rim, back, bore and nose.

use super::impeller::Impeller;
use crate::geometry::Meridional;

/// +1 when the inlet is towards +Z, else −1.
pub fn up_sign(part: &Impeller) -> f64 {
    part.out_of_inlet().z
}

/// The outline of the wheel without the hub: rim, back, bore and nose ring, from the rim of the hub back to
/// its nose, mm. Part files do not contain the back side of the wheel: it is assumed here, for solids, meshes
/// and the blank alike.
pub fn body_outline(part: &Impeller) -> [Meridional; 5] {
    let (nose, rim) = (inside(part.hub.point(part.hub.wheel_from())), part.hub.point(1.0));
    // At least 3 mm behind the rim; less where that would be a drum.
    let thickness = (0.03 * rim.r).max(3.0_f64.min(0.15 * rim.r));
    let back = rim.z - up_sign(part) * thickness;
    let bore = 0.45 * nose.r;
    [
        rim,
        Meridional { r: rim.r, z: back },
        Meridional { r: bore, z: back },
        Meridional { r: bore, z: nose.z },
        nose,
    ]
}

/// `p`, on the axis where it lies beyond it.
pub(crate) fn inside(p: Meridional) -> Meridional {
    Meridional { r: p.r.max(0.0), z: p.z }
}
