//! How high stock stands in a cylinder: both bounds against points of a fine raster.

use vanecut::cutting::contact::{BlankTop, Columns, PlungeColumn, standing_height};
use vanecut::geometry::{CutterSolid, Meridional, Point, Vector, frame_about};
use vanecut::part::{Blank, BlankShape, Impeller};

/// Highest stock by points of a fine raster of the cylinder.
fn by_points(bottom: &CutterSolid, plunges: &[CutterSolid], blank: &Blank) -> f64 {
    let (u, v) = frame_about(&bottom.axis);
    let mut highest = 0.0f64;
    for (i, j) in (-30..=30).flat_map(|i| (-30..=30).map(move |j| (i, j))) {
        let (x, y) = (f64::from(i) / 30.0 * bottom.radius, f64::from(j) / 30.0 * bottom.radius);
        if x.hypot(y) > bottom.radius {
            continue;
        }
        let is_stock = |h: f64| {
            let p = bottom.tip + u * x + v * y + bottom.axis * h;
            plunges.iter().all(|plunge| plunge.distance(&p) > 0.0)
                && blank.is_solid(Meridional::from_point(&p), &mut None)
        };
        let steps = (0..400).rev().map(|k| 0.25 * f64::from(k));
        let found = steps.take_while(|h| *h > highest).find(|h| is_stock(*h));
        highest = found.unwrap_or(highest);
    }
    highest
}

#[test]
fn both_bounds_enclose_the_stock_of_a_fine_raster() {
    let part = vanecut::io::part_file::read_part("assets/parts/pump6.toml".as_ref()).expect("a sample");
    let part = Impeller::build(&part).expect("it can be built");
    let blank = Blank::shaped(&part, 0.0, &BlankShape::Turned);
    let top = BlankTop::new(&blank);
    let up = part.out_of_inlet();
    let middle = part.hub.point(0.6);
    let at = |x: f64, y: f64, down: f64, lean: f64| CutterSolid {
        tip: Point::new(middle.r + x, y, middle.z) + up * (30.0 - down),
        axis: (up + Vector::new(0.0, lean, 0.0)).normalize(),
        radius: 8.0,
        corner_radius: 0.8,
    };
    // A field of leaning plunges that overlap, with slivers between some of them.
    let field = (0..36).map(|k| {
        let (i, j) = (f64::from(k % 6) - 2.5, f64::from(k / 6) - 2.5);
        at(11.0 * i, 11.6 * j, 4.0 * (i * 1.7 + j).sin(), 0.05 * (i - j))
    });
    let plunges: Vec<CutterSolid> = field.collect();
    let columns: Columns =
        plunges.iter().map(|plunge| PlungeColumn::new(*plunge, plunge.radius, &top)).collect();
    let mut heights = Vec::new();
    for (x, y, radius) in [(0.0, 0.0, 8.0), (5.0, 3.0, 6.0), (-9.0, 7.0, 10.0), (60.0, 0.0, 8.0)] {
        let bottom = CutterSolid { radius, corner_radius: 0.0, ..at(x, y, 25.0, 0.1) };
        let found = standing_height(&bottom, columns.all(), &blank, &top, f64::INFINITY);
        let raster = by_points(&bottom, &plunges, &blank);
        assert!(found.at_most >= raster, "{found:?}, {raster} by points");
        assert!(found.at_least <= raster + 1.5, "{found:?}, {raster} by points");
        assert!(found.at_most - found.at_least < 1.0, "{found:?}");
        heights.push(found.at_most);
    }
    assert!(heights.iter().any(|h| (heights[0] - h).abs() > 2.0), "different heights: {heights:?}");
}
