use std::path::Path;
use vanecut::{formats::part_file::read_part, geometry::CutterSolid, part::*, plunge::{lane::Lane, sections::resolve}};
fn main() {
    let part = Impeller::build(&read_part(Path::new("assets/parts/impeller532.toml")).unwrap()).unwrap();
    let channel = Channel::of(&part);
    let setup = resolve(&Setup::default(), &part, &channel).unwrap();
    let lane = Lane::new(&part, &channel.full, &setup.tools[1], 0.5, 0.5);
    let side = channel.full.walls[1].side();
    let probe = SideProbe::new(side, side.u_knots()[0]-0.3, 1.35);
    println!("u0 {}", side.u_knots()[0]);
    for s in [0.38,0.356,0.332] { let b = lane.wall_axis(1,s,s,None).unwrap(); let (m,a)=lane.line(&b);
      let c = CutterSolid{tip:m,axis:a,radius:8.0,corner_radius:0.0};
      let n = probe.nearest(&c,0.0,0.33); println!("s {s} nearest {} u {:.4} v {:.4}", n.distance,n.u,n.v);
      for j in 0..=12 { let v=j as f64*0.33/12.0; let mut best=(1e9,0.0); for i in 0..20000 { let u=-0.3+1.65*i as f64/20000.0; let d=c.distance(&side.point(u,v)); if d<best.0 {best=(d,u);} } println!("   v {v:.3} d {:.5} u {:.4}", best.0,best.1); }
    }
}
#[allow(dead_code)] fn x(){}
