#![allow(clippy::all, clippy::disallowed_methods)]
//! lab
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::*;
use cellstep_tests::worlds::*;

fn dynamic(w: &mut OwnedWorld, p: Vec3, q: Rotation, mass: MassProperties) -> BodyHandle {
    let mut d = BodyDef::new(BodyKind::Dynamic, p);
    d.rotation = q;
    d.mass = Some(mass);
    w.create_body(&d).unwrap()
}
fn caps(b: u32, j: u32) -> Capacities {
    Capacities { joints: j, ..Capacities::for_bodies(b) }
}
fn rod(l: f32, m: f32) -> MassProperties {
    let i = m * l * l / 12.0;
    MassProperties {
        mass: m,
        center: Vec3::ZERO,
        inertia: Vec3::new(0.01 * i, i, i),
        axes: Rotation::IDENTITY,
    }
}
fn ball_mass(m: f32, r: f32) -> MassProperties {
    MassProperties {
        mass: m,
        center: Vec3::ZERO,
        inertia: Vec3::splat(0.4 * m * r * r),
        axes: Rotation::IDENTITY,
    }
}
fn at(p: Vec3) -> Pose {
    Pose::new(p, Rotation::IDENTITY)
}

fn pendulum(deg: f32, expected: f64, n: u32, hinge: bool) {
    let mut w = world_with(caps(4, 4));
    w.set_settings(&Settings { substeps: n, ..w.settings() }).unwrap();
    let g = w.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).unwrap();
    let a = deg.to_radians();
    // rod along x in the body frame; hangs: direction (sin a, 0, -cos a)
    let dir = Vec3::new(a.sin(), 0.0, -a.cos());
    let q = Rotation::between(Vec3::X, dir);
    let b = dynamic(&mut w, dir * 0.5, q, rod(1.0, 1.0));
    let y = Rotation::from_axis_angle(Vec3::Z, std::f32::consts::FRAC_PI_2); // frame x axis = world y
    let def = if hinge {
        JointDef::hinge(
            [g, b],
            [Pose::new(Vec3::ZERO, y), Pose::new(Vec3::new(-0.5, 0.0, 0.0), q.inverse().after(y))],
        )
    } else {
        JointDef::ball([g, b], [at(Vec3::ZERO), at(Vec3::new(-0.5, 0.0, 0.0))])
    };
    let j = w.create_joint(&def).unwrap();
    let (mut cross, mut last, mut t_last) = (0, f64::NAN, 0.0);
    let mut first = 0.0;
    let mut gap = 0.0_f32;
    let e0 = 9.81 * 0.5 * (-(a as f64)).cos() * -1.0;
    let mut emax: f64 = 0.0;
    let mut e_end = 0.0;
    for s in 0..(60.0 * 60.0) as u32 {
        w.step(&mut Serial);
        let p = w.center(b).unwrap().to_f64();
        let v = w.linear_velocity(b).unwrap();
        let o = w.angular_velocity(b).unwrap();
        let e = 9.81 * p[2] + 0.5 * v.dot(v) as f64 + 0.5 * (1.0 / 12.0) * o.dot(o) as f64;
        e_end = e - e0;
        emax = emax.max((e - e0).abs());
        let c = w.joint_coordinates(j).unwrap();
        gap = gap.max((c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt());
        let t = (s + 1) as f64 / 60.0;
        if last < 0.0 && p[0] >= 0.0 {
            let tc = t_last + (t - t_last) * (-last) / (p[0] - last);
            if cross == 0 {
                first = tc;
            }
            cross += 1;
            if cross > 1 && cross == 6 {
                print!(
                    " T {:.6} ({:+.4} %)",
                    (tc - first) / (cross - 1) as f64,
                    ((tc - first) / (cross - 1) as f64 / expected - 1.0) * 100.0
                );
            }
        }
        last = p[0];
        t_last = t;
    }
    println!(
        "  pendulum {deg} N={n} hinge={hinge}: gap {:.2e} m, dE max {:.3e} end {:.3e} of {:.2}",
        gap, emax, e_end, 9.81
    );
}

fn chain(links: u32, bob: f32, n: u32, sw: u32, rs: u32) {
    let mut w = world_with(caps(links + 4, links + 4));
    w.set_settings(&Settings { substeps: n, sweeps: sw, relax_sweeps: rs, ..w.settings() }).unwrap();
    let g = w.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).unwrap();
    let mut prev = g;
    let mut pf = Vec3::ZERO;
    let mut last = g;
    let mut js = vec![];
    for i in 0..links {
        let m = if i + 1 == links { ball_mass(bob, 0.5) } else { ball_mass(1.0, 0.3) };
        let b = dynamic(&mut w, Vec3::new(0.0, 0.0, -(i as f32) - 0.5), Rotation::IDENTITY, m);
        js.push(w.create_joint(&JointDef::ball([prev, b], [at(pf), at(Vec3::new(0.0, 0.0, 0.5))])).unwrap());
        prev = b;
        pf = Vec3::new(0.0, 0.0, -0.5);
        last = b;
    }
    let mut worst: f64 = 0.0;
    let mut gap: f32 = 0.0;
    for _ in 0..600 {
        let r = w.step(&mut Serial);
        let z = -w.center(last).unwrap().to_f64()[2] - (links as f64 - 0.5);
        worst = worst.max(z);
        for &j in &js {
            let c = w.joint_coordinates(j).unwrap();
            gap = gap.max(c[2].abs());
        }
        let _ = r;
    }
    let z = -w.center(last).unwrap().to_f64()[2] - (links as f64 - 0.5);
    println!(
        "chain {links} bob {bob} N={n}: stretch worst {:.5} m ({:.3} %), end {:.6}; gap max {:.2e}; top force {:?}",
        worst,
        worst / links as f64 * 100.0,
        z,
        gap,
        w.joint_force(js[0]).unwrap()
    );
}

fn swing(links: u32, bob: f32, n: u32, closed: bool) {
    let mut w = world_with(caps(links + 4, links + 4));
    w.set_settings(&Settings { substeps: n, ..w.settings() }).unwrap();
    let g = w.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).unwrap();
    let mut prev = g;
    let mut pf = Vec3::ZERO;
    let mut js = vec![];
    let mut hs = vec![];
    for i in 0..links {
        let mid = i + 1 == links || (closed && i == links / 2);
        let m = if mid { ball_mass(bob, 0.5) } else { ball_mass(1.0, 0.3) };
        let b = dynamic(&mut w, Vec3::new(i as f32 + 0.5, 0.0, 0.0), Rotation::IDENTITY, m);
        js.push(w.create_joint(&JointDef::ball([prev, b], [at(pf), at(Vec3::new(-0.5, 0.0, 0.0))])).unwrap());
        prev = b;
        pf = Vec3::new(0.5, 0.0, 0.0);
        hs.push((b, if mid { bob } else { 1.0 }, if mid { 0.5 } else { 0.3 }));
    }
    if closed {
        js.push(
            w.create_joint(&JointDef::ball([prev, g], [at(pf), at(Vec3::new(links as f32 * 0.8, 0.0, 0.0))]))
                .unwrap(),
        );
    }
    let energy = |w: &OwnedWorld| {
        hs.iter()
            .map(|&(h, m, r)| {
                let (v, o) = (w.linear_velocity(h).unwrap(), w.angular_velocity(h).unwrap());
                let z = w.center(h).unwrap().to_f64()[2];
                m as f64 * (9.81 * z + 0.5 * v.dot(v) as f64 + 0.5 * 0.4 * (r * r) as f64 * o.dot(o) as f64)
            })
            .sum::<f64>()
    };
    let (mut gap, mut emax, mut emin) = (0.0f32, 0.0f64, 0.0f64);
    let mut late = 0.0f32;
    for s in 0..1200 {
        w.step(&mut Serial);
        for &j in &js {
            let c = w.joint_coordinates(j).unwrap();
            let d = (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt();
            gap = gap.max(d);
            if s > 900 {
                late = late.max(d);
            }
        }
        let e = energy(&w);
        if std::env::var("TR").is_ok() {
            let om = hs
                .iter()
                .map(|&(h, _, _)| {
                    let o = w.angular_velocity(h).unwrap();
                    o.dot(o).sqrt()
                })
                .enumerate()
                .fold((0, 0.0f32), |a, b| if b.1 > a.1 { b } else { a });
            let vm = hs
                .iter()
                .map(|&(h, _, _)| {
                    let o = w.linear_velocity(h).unwrap();
                    o.dot(o).sqrt()
                })
                .enumerate()
                .fold((0, 0.0f32), |a, b| if b.1 > a.1 { b } else { a });
            let f = js
                .iter()
                .map(|&j| {
                    let o = w.joint_force(j).unwrap();
                    o.dot(o).sqrt()
                })
                .enumerate()
                .fold((0, 0.0f32), |a, b| if b.1 > a.1 { b } else { a });
            let d = js
                .iter()
                .map(|&j| {
                    let c = w.joint_coordinates(j).unwrap();
                    (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt()
                })
                .enumerate()
                .fold((0, 0.0f32), |a, b| if b.1 > a.1 { b } else { a });
            println!("{s} E {e:.1} spin {om:?} speed {vm:?} force {f:?} gap {d:?}");
        }
        emax = emax.max(e);
        emin = emin.min(e);
    }
    println!(
        "swing {links} bob {bob} N={n} closed {closed}: gap max {gap:.2e} late {late:.2e}, energy {emin:.1}..{emax:.1} of {:.1}",
        9.81 * bob * links as f32
    );
}

fn fourbar(n: u32, sw: u32, rs: u32) {
    // crank 0.4, coupler 1, rocker 0.8, ground 1; Grashof: s+l=0.4+1<=... ok
    let mut w = world_with(caps(8, 8));
    w.set_settings(&Settings { substeps: n, sweeps: sw, relax_sweeps: rs, ..w.settings() }).unwrap();
    let g = w.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).unwrap();
    let (a, d) = (Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0));
    let b = Vec3::new(0.0, 0.0, 0.4);
    // C: |C-B|=1, |C-D|=0.8
    let bd = d - b;
    let dist = bd.dot(bd).sqrt();
    let x = (1.0 - 0.64 + dist * dist) / (2.0 * dist);
    let h = (1.0 - x * x).sqrt();
    let u = bd / dist;
    let nrm = Vec3::new(-u.z, 0.0, u.x);
    let c = b + u * x + nrm * h;
    let y = Rotation::from_axis_angle(Vec3::Z, std::f32::consts::FRAC_PI_2);
    let mut bar = |p: Vec3, q: Vec3| {
        let l = (q - p).dot(q - p).sqrt();
        let r = Rotation::between(Vec3::X, (q - p) / l);
        (dynamic(&mut w, (p + q) * 0.5, r, rod(l, l)), r, l)
    };
    let bars = [bar(a, b), bar(b, c), bar(c, d)];
    let mut js = vec![];
    let mut hinge = |p: (BodyHandle, Vec3, Rotation), q: (BodyHandle, Vec3, Rotation)| {
        js.push(
            w.create_joint(&JointDef::hinge(
                [p.0, q.0],
                [Pose::new(p.1, p.2.inverse().after(y)), Pose::new(q.1, q.2.inverse().after(y))],
            ))
            .unwrap(),
        );
    };
    let end = |k: usize, s: f32| (bars[k].0, Vec3::new(0.5 * s * bars[k].2, 0.0, 0.0), bars[k].1);
    hinge((g, a, Rotation::IDENTITY), end(0, -1.0));
    hinge(end(0, 1.0), end(1, -1.0));
    hinge(end(1, 1.0), end(2, -1.0));
    hinge(end(2, 1.0), (g, d, Rotation::IDENTITY));
    // spin the crank
    let energy = |w: &OwnedWorld| {
        bars.iter()
            .map(|&(h, _, l)| {
                let (v, o) = (w.linear_velocity(h).unwrap(), w.angular_velocity(h).unwrap());
                let z = w.center(h).unwrap().to_f64()[2];
                (l as f64)
                    * (9.81 * z + 0.5 * v.dot(v) as f64 + 0.5 * (l as f64).powi(2) / 12.0 * o.dot(o) as f64)
            })
            .sum::<f64>()
    };
    // initial velocity: consistent: let solver project from crank spin 8 rad/s
    w.set_angular_velocity(bars[0].0, Vec3::new(0.0, 12.0, 0.0)).unwrap();
    w.step(&mut Serial);
    let e0 = energy(&w);
    let floor = -9.81 * 0.5; // rough
    let (mut emax, mut gap): (f64, f32) = (0.0, 0.0);
    let mut e = e0;
    for _k in 0..3600 {
        w.step(&mut Serial);
        e = energy(&w);
        emax = emax.max((e - e0).abs());
        if std::env::var("TR").is_ok() && (_k < 40 || _k % 20 == 0) && _k < 600 {
            let c: Vec<[f32; 6]> = js.iter().map(|&j| w.joint_coordinates(j).unwrap()).collect();
            println!(
                "{_k} E {e:.4} {:?}",
                c.iter().map(|c| [c[0], c[1], c[2], c[4], c[5]]).collect::<Vec<_>>()
            );
        }
        for &j in &js {
            let c = w.joint_coordinates(j).unwrap();
            gap = gap.max((c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt());
        }
    }
    println!(
        "fourbar N={n}: gap {:.2e}, E0 {:.3}, dE max {:.3e} end {:.3e} ({:.3} %) {floor}",
        gap,
        e0,
        emax,
        e - e0,
        (e - e0) / e0 * 100.0
    );
}

fn net(size: u32, steps: u32, n: u32) {
    let mut w = world_with(caps(size * size + 1, 2 * size * size));
    w.set_settings(&Settings { substeps: n, ..w.settings() }).unwrap();
    let mut hs = vec![];
    let mut js = vec![];
    for i in 0..size {
        for k in 0..size {
            let fixed = k == 0 && (i == 0 || i + 1 == size || i % 4 == 0);
            let mut d = BodyDef::new(
                if fixed { BodyKind::Static } else { BodyKind::Dynamic },
                Vec3::new(k as f32, i as f32, 0.0),
            );
            d.mass = Some(ball_mass(1.0, 0.4));
            let b = w.create_body(&d).unwrap();
            hs.push(b);
            if i > 0 {
                js.push(
                    w.create_joint(&JointDef::ball(
                        [hs[((i - 1) * size + k) as usize], b],
                        [at(Vec3::new(0.0, 0.5, 0.0)), at(Vec3::new(0.0, -0.5, 0.0))],
                    ))
                    .unwrap(),
                );
            }
            if k > 0 {
                js.push(
                    w.create_joint(&JointDef::ball(
                        [hs[(i * size + k - 1) as usize], b],
                        [at(Vec3::new(0.5, 0.0, 0.0)), at(Vec3::new(-0.5, 0.0, 0.0))],
                    ))
                    .unwrap(),
                );
            }
        }
    }
    let t = std::time::Instant::now();
    let mut rep = Default::default();
    for _ in 0..steps {
        rep = w.step(&mut Serial);
    }
    let ms = t.elapsed().as_secs_f64() * 1e3 / steps as f64;
    let mut gaps: Vec<f32> = js
        .iter()
        .map(|&j| {
            let c = w.joint_coordinates(j).unwrap();
            (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt()
        })
        .collect();
    gaps.sort_by(f32::total_cmp);
    println!(
        "net {size} N={n}: {ms:.3} ms/step, gap p50 {:.2e} p99 {:.2e} max {:.2e}; {rep:?}",
        gaps[gaps.len() / 2],
        gaps[gaps.len() * 99 / 100],
        gaps[gaps.len() - 1]
    );
}

fn main() {
    let which: Vec<String> = std::env::args().skip(1).collect();
    let has = |s: &str| which.is_empty() || which.iter().any(|w| w == s);
    if has("trace") {
        trace();
    }
    if has("tiny") {
        tiny();
    }
    if has("pend") {
        for n in [4, 8] {
            for (d, t) in [(10.0, 1.641070), (45.0, 1.703421), (90.0, 1.933335), (170.0, 3.995546)] {
                pendulum(d, t, n, false);
                pendulum(d, t, n, true);
            }
        }
    }
    if has("chain") {
        for (n, s, r) in [(8, 1, 1), (8, 4, 1), (8, 4, 4), (8, 16, 16), (8, 50, 50)] {
            chain(20, 1000.0, n, s, r);
            chain(50, 1000.0, n, s, r);
            chain(50, 1.0, n, s, r);
        }
    }
    if has("swing") {
        if std::env::var("TR").is_ok() {
            swing(50, 1.0, 8, false);
            return;
        }
        for n in [4, 8] {
            for (l, b) in [(10, 1.0), (50, 1.0), (50, 1e3), (20, 1e4), (20, 1e6), (200, 1.0), (200, 1000.0)] {
                swing(l, b, n, false);
                swing(l, b, n, true);
            }
        }
    }
    if has("four") {
        for (n, s, r) in
            [(4, 1, 1), (8, 1, 1), (8, 2, 1), (8, 1, 2), (8, 4, 4), (8, 16, 16), (16, 1, 1), (16, 4, 4)]
        {
            print!("{s} {r} ");
            fourbar(n, s, r);
        }
    }
    if has("net") {
        net(50, 200, 4);
        net(100, 200, 4);
    }
}
pub fn tiny() {
    for n in [1u32, 2, 3, 5] {
        let mut w = world_with(caps(8, 8));
        let g = w.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).unwrap();
        let mut prev = g;
        let mut pf = Vec3::ZERO;
        let mut hs = vec![];
        let mut js = vec![];
        for i in 0..n {
            let b = dynamic(
                &mut w,
                Vec3::new(0.0, 0.0, -(i as f32) - 0.5),
                Rotation::IDENTITY,
                ball_mass(1.0, 0.3),
            );
            js.push(
                w.create_joint(&JointDef::ball([prev, b], [at(pf), at(Vec3::new(0.0, 0.0, 0.5))])).unwrap(),
            );
            prev = b;
            pf = Vec3::new(0.0, 0.0, -0.5);
            hs.push(b);
        }
        for s in 0..6 {
            let r = w.step(&mut Serial);
            print!("n={n} s={s} ");
            for &h in &hs {
                print!("v {:?} ", w.linear_velocity(h).unwrap().z);
            }
            for &j in &js {
                print!("F {:?} ", w.joint_force(j).unwrap().z);
            }
            println!("{} {}", r.phases, r.blocks);
        }
    }
}
pub fn trace() {
    let mut w = world_with(caps(4, 4));
    let g = w.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).unwrap();
    let a = 45.0f32.to_radians();
    let dir = Vec3::new(a.sin(), 0.0, -a.cos());
    let q = Rotation::between(Vec3::X, dir);
    let b = dynamic(&mut w, dir * 0.5, q, rod(1.0, 1.0));
    let j = w.create_joint(&JointDef::ball([g, b], [at(Vec3::ZERO), at(Vec3::new(-0.5, 0.0, 0.0))])).unwrap();
    for s in 0..400 {
        w.step(&mut Serial);
        let o = w.angular_velocity(b).unwrap();
        let d = w.rotation(b).unwrap().rotate(Vec3::X);
        let c = w.joint_coordinates(j).unwrap();
        if s % 10 == 0 {
            println!(
                "{s} spin {:.5} o {:?} gap {:?} y {:?}",
                o.dot(d),
                o,
                &c[..3],
                w.center(b).unwrap().to_f64()[1]
            );
        }
        if !(o.dot(o) < 1e4) {
            break;
        }
    }
}
