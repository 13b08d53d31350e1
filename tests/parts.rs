//! The sample parts have the dimensions they claim.

use std::path::Path;

use vanecut::formats::part_file::read_part;
use vanecut::part::{Channel, Impeller, SideProbe};

fn sample(name: &str) -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts").join(name);
    let description = read_part(&path).expect("sample parts are readable");
    Impeller::build(&description).expect("sample parts are impellers")
}

fn narrowest(part: &Impeller) -> f64 {
    let channel = Channel::of(part);
    let (a, b) = (&channel.sides[0], &channel.sides[3]);
    let probe = SideProbe::new(b, 0.0, 1.0);
    let mut least = f64::INFINITY;
    for i in 0..=100 {
        for j in 0..=10 {
            let p = a.point(f64::from(i) / 100.0, f64::from(j) / 10.0);
            least = least.min(probe.nearest_to_point(&p).distance);
        }
    }
    least
}

fn edges(part: &Impeller) -> (f64, f64) {
    let side = &part.main.suction;
    let along = |u: f64| (side.point(u, 1.0) - side.point(u, 0.0)).norm();
    (along(0.0), along(1.0))
}

#[test]
fn impeller532_is_paper_a_s() {
    let part = sample("impeller532.toml");
    assert_eq!(part.blade_count, 17);
    assert!((2.0 * part.rim_radius() - 532.0).abs() < 0.01, "diameter {}", 2.0 * part.rim_radius());
    let (_, te) = edges(&part);
    let height = part.shroud.point(1.0).distance(part.hub.point(1.0));
    println!("te {te} height {height} narrowest {}", narrowest(&part));
    for i in 0..=10 {
        let s = f64::from(i) / 10.0;
        let c = Channel::of(&part);
        let a = c.full.wall_angles(&part, s, 0.0).unwrap();
        let b = c.full.wall_angles(&part, s, 1.0).unwrap();
        let h = part.hub.point(s);
        let w = part.shroud.point(s);
        let m0 = h.at_angle(a[0]);
        let w0 = w.at_angle(b[0]);
        let d = (w0 - m0).normalize();
        let n = part.hub.normal(s).direction_at_angle(a[0]);
        println!(
            "s {s:.1} hub {:.1} {:.1} th {:.2} {:.2} width {:.1}  tip th {:.2} {:.2}  rul-normal {:.1} dist {:.1}",
            h.r,
            h.z,
            a[0].to_degrees(),
            a[1].to_degrees(),
            h.r * (a[1] - a[0]).abs(),
            b[0].to_degrees(),
            b[1].to_degrees(),
            d.angle(&n).to_degrees(),
            (w0 - m0).norm()
        );
    }
    assert!((height - 32.0).abs() < 0.01, "outlet height {height}");
    assert!((narrowest(&part) - 12.5).abs() < 0.1, "narrowest width {}", narrowest(&part));
}
