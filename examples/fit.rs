use std::path::Path;
use vanecut::{formats::part_file::read_part, part::*, plunge::{lane::Lane, sections::resolve}};
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let part = Impeller::build(&read_part(Path::new(&path)).unwrap()).unwrap();
    let channel = Channel::of(&part);
    let setup = resolve(&Setup::default(), &part, &channel).unwrap();
    let w = vanecut::plunge::sections::passage_widths(&part,&channel);
    for (k,sec) in setup.plunge.sections.iter().enumerate() {
        let lane = Lane::new(&part, &channel.full, &setup.tools[k], 0.5, 0.5);
        for i in 0..=10 { let s = sec.from + (sec.to-sec.from)*i as f64/10.0;
            let a = lane.wall_axis(0,s,s,None); let b = lane.wall_axis(1,s,s,None);
            println!("D{} s {s:.3} width {:.2} a {:?} b {:?}", setup.tools[k].diameter, w[(s*50.0) as usize], a.map(|e| (e.theta_hub.to_degrees(), e.theta_shroud.to_degrees())), b.map(|e| (e.theta_hub.to_degrees(), e.theta_shroud.to_degrees())));
        }
    }
}
