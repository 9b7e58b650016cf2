//! tmp
use cellstep::*; use cellstep_tests::simulator::*; use cellstep_tests::commands::Command;
fn main(){
    let (mut s, mut w)=Simulator::new(160, CAPACITIES);
    for i in 0..30 {
        let ev=s.play(&mut w);
        for (c,_) in &ev { if format!("{c:?}").contains("index: 5,") {println!("{i} {c:?}");} }
        if i==29 { 
          for idx in [4,5] {
           let b=w.bodies().find(|b|b.index==idx).unwrap();
           println!("before: v {:?} w {:?} rot {:?} c {:?} kind {:?} mass {:?}", w.linear_velocity(b), w.angular_velocity(b), w.rotation(b), w.center(b), w.kind(b), w.mass_properties(b));
           for s in w.shapes_of(b).unwrap() {println!("{:?}", w.shape(s));}
           }
           let sh: Vec<_> = [4,5].iter().flat_map(|&i| { let b=w.bodies().find(|b|b.index==i).unwrap(); w.shapes_of(b).unwrap().collect::<Vec<_>>() }).collect();
           w.manifolds(sh[0], sh[1], |m| println!("{m:?}"));
        }
        let _ : Option<Command> = None;
        w.step(&mut Serial);
    }
}
