use cellstep::Serial;
use cellstep::mjcf::Model;
use cellstep::scene::Limits;
use std::path::Path;
fn load(file: &str) -> (Model, cellstep::scene::Build) {
    let model = Model::read(&Path::new("/work/shared/data/mjcf").join(file), &Limits::default()).unwrap();
    let scene = model.to_scene().unwrap().scene;
    let b = scene.build(Path::new("")).unwrap();
    (model, b)
}
#[test]
fn humanoids() {
    let (m, mut b) = load("100_humanoids.xml");
    let n = b.bodies.len();
    for step in 1..=6000 {
        let r = b.world.step(&mut Serial);
        assert_eq!((r.dropped, r.quarantined), (0, 0));
        if step % 200 == 0 {
            let awake: Vec<usize> = (1..n).filter(|&i| !b.world.is_asleep(b.bodies[i]).unwrap()).collect();
            let speed = |i: usize| b.world.linear_velocity(b.bodies[i]).unwrap().length();
            let mut fast: Vec<(f32, usize)> = awake.iter().map(|&i| (speed(i), i)).collect();
            fast.sort_by(|a, b| b.0.total_cmp(&a.0));
            let dolls: std::collections::BTreeSet<usize> = awake.iter().map(|&i| (i - 1) / 13).collect();
            print!("t {:.1} awake {} dolls {} :", step as f64 * 0.005, awake.len(), dolls.len());
            for (v, i) in fast.iter().take(4) {
                print!(
                    " {}({i}) {:.3} w {:.3};",
                    m.bodies[*i].name,
                    v,
                    b.world.angular_velocity(b.bodies[*i]).unwrap().length()
                );
            }
            println!();
        }
    }
}
#[test]
fn cradle() {
    let (_m, mut b) = load("newton_cradle.xml");
    for step in 0..=30000 {
        if step % 500 == 0 {
            let mut e = 0.0;
            print!("t {:.2}:", step as f64 * 1e-4);
            for i in 1..8 {
                let p = b.world.position(b.bodies[i]).unwrap().to_f64();
                let v = b.world.linear_velocity(b.bodies[i]).unwrap();
                e += 0.268 * (9.81 * p[2] + 0.5 * v.length_squared() as f64);
                print!(" {:.3},{:.2}", p[0], v.x);
            }
            println!(" E {:.5}", e - 0.268 * 9.81 * 0.04 * 7.0);
        }
        let r = b.world.step(&mut Serial);
        assert_eq!((r.dropped, r.quarantined), (0, 0));
    }
}
#[test]
fn crank() {
    let (_m, mut b) = load("slider_crank.xml");
    for step in 0..=5000 {
        if step % 250 == 0 {
            print!("t {:.2}:", step as f64 * 2e-3);
            for j in 0..3 {
                print!(" {:.4}", b.world.joint_coordinates(b.joints[j]).unwrap()[3]);
            }
            for j in 3..6 {
                print!(" d {:.4}", b.world.joint_coordinates(b.joints[j]).unwrap()[0]);
            }
            println!();
        }
        b.world.step(&mut Serial);
    }
}
