//! tmp
use cellstep::*; use cellstep_tests::simulator::*;
fn main(){
    let (mut s, mut w)=Simulator::new(160, CAPACITIES);
    for i in 0..30 {
        for (c,o) in s.play(&mut w) { println!("{i}: {c:?} -> {o:?}"); }
        let before=snapshot(&w);
        w.step(&mut Serial);
        println!("{i} settings {:?}", w.settings());
        for b in w.bodies() { let v=w.linear_velocity(b).unwrap().length(); let a=w.angular_velocity(b).unwrap().length(); if v>30.0||a>100.0 { println!("step {i} body {} v {v} w {a} pos {:?} rep", b.index, w.center(b).unwrap()); } }
        for c in w.contacts() { if c.bodies[0].index==4||c.bodies[1].index==4 { println!("   {:?} p{} imp {:?} fr {:?} tw {} ", c.bodies, c.points, c.impulses, c.friction, c.twist);
          w.manifolds(c.shapes[0], c.shapes[1], |m| println!("      n {:?} {:?}", m.normal, m.points)); } }
        if i==29 { 
           let b=w.bodies().find(|b|b.index==4).unwrap();
           w.restore(&before).unwrap();
           println!("before: v {:?} w {:?} rot {:?} c {:?} kind {:?}", w.linear_velocity(b), w.angular_velocity(b), w.rotation(b), w.center(b), w.kind(b));
           for s in w.shapes_of(b).unwrap() {println!("{:?}", w.shape(s));}
        }
    }
}
