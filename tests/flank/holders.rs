//! The quick test whether a holder enters the blank.

use proptest::prelude::*;
use std::sync::LazyLock;

use vanecut::cutting::retract::{bottom_clearance, bottom_is_inside};
use vanecut::geometry::{CutterSolid, Point, Vector};
use vanecut::part::{Blank, BlankShape};

use crate::parts::part_at;

/// The blanks of the samples: between the edges of their blades, prolonged at the inlet, and turned.
static BLANKS: LazyLock<Vec<Blank>> = LazyLock::new(|| {
    let parts =
        ["pump6", "impeller9x9", "impeller532"].map(|name| part_at(&format!("assets/parts/{name}.toml")));
    let blanks = parts.iter().flat_map(|part| {
        let shapes = [(0.0, BlankShape::Edges), (5.0, BlankShape::Edges), (0.0, BlankShape::Turned)];
        shapes.map(|(extension, shape)| Blank::shaped(part, extension, &shape))
    });
    blanks.collect()
});

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// It answers as the distance of the bottom does, within and around the blank, and from below.
    #[test]
    fn a_holder_is_inside_where_its_bottom_has_no_distance(
        number in 0..9_usize,
        place in (0.0..1.4_f64, 0.0..6.3_f64, -0.4..1.6_f64),
        axis in (-1.0..1.0_f64, -1.0..1.0_f64, -0.2..1.0_f64),
        size in (0.5..40.0_f64, prop_oneof![Just(0.0), Just(0.5), Just(1.0)]),
    ) {
        let blank = &BLANKS[number];
        let (r_max, z) = blank.extent();
        let axis = Vector::new(axis.0, axis.1, axis.2).try_normalize(1e-3).unwrap_or(Vector::z());
        let r = place.0 * r_max;
        let tip = Point::new(r * place.1.cos(), r * place.1.sin(), z.0 + place.2 * (z.1 - z.0));
        let holder = CutterSolid { tip, axis, radius: size.0, corner_radius: size.0 * size.1 };
        prop_assert_eq!(bottom_is_inside(&holder, blank), bottom_clearance(&holder, blank) < 0.0);
    }
}
