//! x
use cellstep::math::Vec3;
use cellstep::*;
use cellstep_tests::worlds::*;
fn main() {
    let base: u32 = std::env::args().nth(1).unwrap().parse().unwrap();
    let sub: u32 = std::env::args().nth(2).unwrap().parse().unwrap();
    let mut w = world(base * (base + 1) / 2 + 1);
    ground(&mut w, 0.6);
    w.set_settings(&Settings { substeps: sub, ..Settings::default() }).unwrap();
    for row in 0..base { for i in 0..base - row {
        let c = Vec3::new(i as f32 + 0.5 * row as f32 - 0.5 * base as f32, 0.0, 0.5 + row as f32);
        add(&mut w, &BodyDef::new(BodyKind::Dynamic, c), &ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) }));
    }}
    for k in 0..20 {
        for _ in 0..(if k < 8 {5} else {60}) { w.step(&mut Serial); }
        let mut worst = (0.0f32, String::new());
        let mut vmax = 0.0f32;
        for b in w.bodies() { vmax = vmax.max(w.linear_velocity(b).unwrap().length()); }
        for c in w.contacts() {
            w.manifolds(c.shapes[0], c.shapes[1], |m| for p in &m.points { if -p.separation > worst.0 {
                worst = (-p.separation, format!("{:?} n {:?} imp {:?} bodies {:?} {:?}", p.position.to_f64(), m.normal, c.normal_impulse(), c.bodies[0].index, c.bodies[1].index)); } });
        }
        println!("{} pen {:.2} mm vmax {:.4} {}", w.steps(), worst.0 * 1e3, vmax, worst.1);
    }
}
