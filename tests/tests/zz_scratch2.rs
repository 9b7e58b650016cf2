//! scratch
use cellstep::Serial;
use cellstep::scene::Limits;
use cellstep::scene::Scene;
use std::path::Path;
fn go(name: &str, json: &str, steps: usize, every: usize) {
    let scene = Scene::from_json(json.as_bytes(), &Limits::default()).unwrap();
    let mut b = scene.build(Path::new("")).unwrap();
    println!("== {name}");
    for s in 0..=steps {
        if s % every == 0 {
            let mut e = 0.0;
            print!("{s}:");
            for (i, &h) in b.bodies.iter().enumerate() {
                if scene.bodies[i].kind == cellstep::scene::format::KindDoc::Static {
                    continue;
                }
                let v = b.world.linear_velocity(h).unwrap();
                let w = b.world.angular_velocity(h).unwrap();
                e += 0.5 * v.length_squared();
                print!(" {:.3},{:.3} w{:.2}", v.x, v.z, w.length());
            }
            println!(" E {e:.4}");
        }
        b.world.step(&mut Serial);
    }
}
#[test]
fn line() {
    for (name, fr) in [("frictionless", 0.0), ("friction", 0.4)] {
        for k in [1, 2] {
            let mut bodies = String::new();
            for i in 0..7 {
                let moving = i >= 7 - k;
                let gap = if moving { 0.01 } else { 0.0 };
                bodies += &format!(
                    "{}{{\"position\":[{},0,0],\"linear_velocity\":[{},0,0],\"shapes\":[{{\"geometry\":{{\"sphere\":{{\"radius\":0.02}}}},\"material\":\"m\"}}]}}",
                    if i == 0 { "" } else { "," },
                    i as f64 * 0.04 + gap,
                    if moving { -0.64 } else { 0.0 }
                );
            }
            let j = format!(
                "{{\"gravity\":[0,0,0],\"settings\":{{\"dt\":0.0001,\"substeps\":1}},\"materials\":{{\"m\":{{\"friction\":{fr},\"restitution\":1,\"density\":8000}}}},\"bodies\":[{bodies}]}}"
            );
            go(&format!("{name} {k}"), &j, 400, 40);
        }
    }
    // two balls on ropes meeting one
    let mut bodies = String::from("{\"kind\":\"static\"}");
    let mut joints = String::new();
    for i in 0..2 {
        let vx = if i == 1 { -0.64 } else { 0.0 };
        let x = if i == 1 { 0.041 } else { 0.0 };
        bodies += &format!(
            ",{{\"position\":[{x},0,0.04],\"linear_velocity\":[{vx},0,0],\"shapes\":[{{\"geometry\":{{\"sphere\":{{\"radius\":0.02}}}},\"material\":\"m\"}}]}}"
        );
        for y in [-1.0, 1.0] {
            joints += &format!(
                "{}{{\"kind\":\"distance\",\"bodies\":[0,{}],\"frames\":[{{\"position\":[{x},{},0.2]}},{{\"position\":[0,{},0.018]}}],\"axes\":{{\"x\":{{\"motion\":{{\"limited\":{{\"lower\":0,\"upper\":0.146}}}}}}}}}}",
                if joints.is_empty() { "" } else { "," },
                i + 1,
                y * 0.04,
                y * 0.008
            );
        }
    }
    for fr in [0.0, 0.4] {
        let j = format!(
            "{{\"settings\":{{\"dt\":0.0001,\"substeps\":1}},\"materials\":{{\"m\":{{\"friction\":{fr},\"restitution\":1,\"density\":8000}}}},\"bodies\":[{bodies}],\"joints\":[{joints}]}}"
        );
        go(&format!("ropes friction {fr}"), &j, 400, 20);
    }
}
