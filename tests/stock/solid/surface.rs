//! The surface: closed, on the solid, sharp.

use super::*;

/// Signed distance from what is left of the disc, by brute force; negative in stock.
fn distance_from_rest(p: &Point, cutter: &Tool, moves: &[SolidMove]) -> f64 {
    let r = p.x.hypot(p.y);
    let blank = (r - 40.0).max(-p.z).max(p.z - 30.0);
    let cuts = moves.iter().map(|m| -cutter.placed(m.to.tip, m.to.axis).distance(p));
    cuts.fold(blank, f64::max)
}

/// Central differences of `f`.
fn gradient(f: impl Fn(&Point) -> f64, at: &Point) -> Vector {
    const STEP: f64 = 1e-4;
    let along = |unit: Vector| (f(&(at + unit * STEP)) - f(&(at - unit * STEP))) / (2.0 * STEP);
    Vector::new(along(Vector::x()), along(Vector::y()), along(Vector::z()))
}

#[test]
fn the_surface_is_closed_and_on_the_solid() {
    let spacing = 0.8;
    for (cutter, count) in [(tool(12.0, 2.0), 25), (tool(9.0, 0.0), 60), (tool(10.0, 5.0), 30)] {
        let moves = many_plunges(count);
        let (stock, _) = cut(&disc(), spacing, &cutter, &moves);
        let surface = StockSurface::from_stock(&stock);
        assert!(surface.triangles.len() > 10_000);
        assert_closed(&surface);
        assert_near("enclosed volume", surface.volume(), stock.volume(), 2e-2);
        let (mut worst, mut mean) = (0.0f64, 0.0);
        for p in &surface.points {
            let off = distance_from_rest(p, &cutter, &moves).abs();
            worst = worst.max(off);
            mean += off / surface.points.len() as f64;
        }
        assert!(worst <= 0.5 * spacing, "a vertex is {worst} mm off");
        assert!(mean <= 0.02 * spacing, "vertices are {mean} mm off in the mean");
        let smooth = |k: &usize| surface.normals[*k].norm() > 0.5 && surface.cut_by[*k] != SpanEnd::BLANK;
        let mut seen = 0;
        for k in (0..surface.points.len()).filter(smooth) {
            let (p, n) = (surface.points[k], surface.normals[k]);
            let to = moves[surface.cut_by[k] as usize].to;
            // A vertex between two cuts has the mean normal. Where the cutter has an edge, differences of its
            // distance give no unit vector.
            let distance = |p: &Point| cutter.placed(to.tip, to.axis).distance(p);
            let out = gradient(distance, &p);
            if distance(&p).abs() < 1e-6 && (out.norm() - 1.0).abs() < 1e-4 {
                assert!(n.angle(&-out) < 2f64.to_radians(), "{n:?} at {p:?}, {out:?}");
                seen += 1;
            }
        }
        assert!(seen > 5000, "{seen} normals");
    }
}

#[test]
fn edges_of_the_surface_stay_sharp() {
    // Without sharp vertices the rim of the disc would be cut off by up to a third of the spacing.
    let surface = StockSurface::from_stock(&SolidStock::new(&disc(), 1.0).expect("it fits"));
    let near_rim = |p: &&Point| (p.x.hypot(p.y) - 40.0).abs() < 0.02 && (p.z - 30.0).abs() < 0.02;
    let sharp = surface.points.iter().filter(near_rim).count();
    assert!(sharp > 200, "{sharp} vertices on the rim");
    assert_near("volume", surface.volume(), PI * 1600.0 * 30.0, 1e-3);
}

#[test]
fn normals_on_smooth_parts_are_those_of_the_cutter() {
    let to = pose([3.0, -2.0, 10.0], [0.3, 0.1, 1.0]);
    let cutter = tool(14.0, 0.0);
    let (stock, _) = cut(&disc(), 0.8, &cutter, &[plunge(7, to)]);
    let surface = StockSurface::from_stock(&stock);
    let mut seen = 0;
    for ((p, n), by) in surface.points.iter().zip(&surface.normals).zip(&surface.cut_by) {
        let d = p - to.tip;
        let height = d.dot(&to.axis);
        let across = d - to.axis * height;
        if *by == 7 && height > 1.0 && (across.norm() - 7.0).abs() < 1e-6 && n.norm() > 0.5 {
            assert!(n.angle(&-across) < 2f64.to_radians(), "{n:?} at {p:?}");
            seen += 1;
        }
    }
    assert!(seen > 500, "{seen}");
}
