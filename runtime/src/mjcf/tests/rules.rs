//! What models mean.

use super::super::model::*;
use super::super::warning::Effect;
use super::{model, near, read};
use std::f64::consts::PI;

const BALL: &str = r#"<freejoint/><geom size="1"/>"#;

#[test]
fn orientations_agree() {
    // A quarter turn about z, in every spelling.
    for turn in
        [r#"quat="1 0 0 1""#, r#"axisangle="0 0 3 90""#, r#"euler="0 0 90""#, r#"xyaxes="0 2 0 -1 7 0""#]
    {
        let found = model(&format!(r#"<body {turn} pos="1 2 3">{BALL}</body>"#), "");
        let placement = found.bodies[1].placement;
        near(placement.transform([1.0, 0.0, 0.0]), [1.0, 3.0, 3.0]);
        near(placement.transform([0.0, 0.0, 1.0]), [1.0, 2.0, 4.0]);
    }
    let found = model(&format!(r#"<body zaxis="1 1 0">{BALL}</body>"#), "");
    let half = 0.5f64.sqrt();
    near(found.bodies[1].placement.turn.rotate([0.0, 0.0, 1.0]), [half, half, 0.0]);
}

#[test]
fn euler_sequences() {
    let turned = |compiler: &str, angles: &str| {
        let text = format!(
            r#"<mujoco><compiler {compiler}/><worldbody><body euler="{angles}">{BALL}</body></worldbody></mujoco>"#
        );
        read(&text).bodies[1].placement.turn.rotate([0.0, 1.0, 0.0])
    };
    // About x, then about the y axis that has turned along, and about the one that has not.
    near(turned(r#"eulerseq="xyz""#, "90 90 0"), [0.0, 0.0, 1.0]);
    near(turned(r#"eulerseq="XYZ""#, "90 90 0"), [1.0, 0.0, 0.0]);
    near(turned(r#"eulerseq="zXy" angle="radian""#, "0 1.5707963267948966 0"), [0.0, 0.0, 1.0]);
}

#[test]
fn compilers_and_options_add_up() {
    let found = read(
        r#"<mujoco model="m"><compiler angle="radian"/><option timestep="0.01"/><compiler autolimits="false"/>
           <option gravity="1 2 3"><flag contact="disable"/></option>
           <worldbody><body><joint range="-1 1" limited="true"/><geom size="1"/></body></worldbody></mujoco>"#,
    );
    assert_eq!(
        (found.name.as_str(), found.options.timestep, found.options.gravity),
        ("m", 0.01, [1.0, 2.0, 3.0])
    );
    assert_eq!(found.joints[0].parts[0].range, Some([-1.0, 1.0]));
    assert_eq!((found.bodies[1].geoms[0].contype, found.bodies[1].geoms[0].conaffinity), (0, 0));
    assert_eq!(read("<mujoco/>").options.gravity, [0.0, 0.0, -9.81]);
    assert_eq!(read("<mujoco/>").options.timestep, 0.002);
    let still = read(r#"<mujoco><option gravity="1 2 3"><flag gravity="disable"/></option></mujoco>"#);
    assert_eq!(still.options.gravity, [0.0; 3]);
}

#[test]
fn flags_disable() {
    let joint = r#"<body name="a"><joint name="j" range="-1 1" stiffness="1" damping="2" frictionloss="3"/>
                   <geom size="1"/></body>"#;
    let read = |flag: &str| {
        read(&format!(
            r#"<mujoco><option><flag {flag}="disable"/></option><worldbody>{joint}</worldbody>
               <equality><weld body1="a"/></equality><actuator><motor joint="j"/></actuator></mujoco>"#
        ))
    };
    let part = |flag: &str| read(flag).joints[0].parts[0].clone();
    assert_eq!((part("limit").range, part("constraint").range), (None, None));
    assert_eq!((part("spring").stiffness, part("damper").stiffness), (0.0, 1.0));
    assert_eq!((part("spring").damping, part("damper").damping), (2.0, 0.0));
    assert_eq!((part("frictionloss").friction_loss, part("limit").friction_loss), (0.0, 3.0));
    assert_eq!((read("equality").equalities.len(), read("limit").equalities.len()), (0, 1));
    assert_eq!((read("actuation").actuators.len(), read("limit").actuators.len()), (0, 1));
}

#[test]
fn classes_inherit() {
    let found = read(
        r#"<mujoco>
          <default><geom size=".1" density="2000"/>
            <default class="a"><geom type="capsule" size=".1 .2"/>
              <default class="b"><geom mass="4"/><joint type="slide" axis="0 1 0"/></default></default></default>
          <default><joint damping="2"/></default>
          <worldbody>
            <body childclass="a"><joint/><geom/><geom class="b"/>
              <body pos="1 0 0"><joint class="b"/><geom/>
                <frame childclass="b"><body pos="1 0 0"><joint/><geom type="sphere" mass="1"/></body></frame>
              </body></body>
            <body><freejoint/><geom/></body>
          </worldbody></mujoco>"#,
    );
    let capsule = Form::Capsule { half_height: 0.2, radius: 0.1 };
    let volume = PI * (0.01 * 0.4 + 4.0 / 3.0 * 0.001);
    let mass = |body: usize| found.bodies[body].mass.unwrap().mass;
    assert_eq!(found.bodies[1].geoms.iter().map(|geom| geom.form).collect::<Vec<_>>(), [capsule, capsule]);
    assert!((mass(1) - (2000.0 * volume + 4.0)).abs() < 1.0e-9);
    assert!((mass(2) - 2000.0 * volume).abs() < 1.0e-9);
    assert_eq!(mass(3), 1.0);
    assert_eq!(found.bodies[4].geoms[0].form, Form::Sphere { radius: 0.1 });
    let motions: Vec<Motion> = found.joints.iter().map(|joint| joint.parts[0].motion).collect();
    assert_eq!(motions, [Motion::Hinge, Motion::Slide, Motion::Slide]);
    // The second block of defaults came after `b` had taken what there was.
    let damping: Vec<f64> = found.joints.iter().map(|joint| joint.parts[0].damping).collect();
    assert_eq!(damping, [0.0, 0.0, 0.0]);
}

#[test]
fn bodies_without_joints_are_part_of_what_is_around_them() {
    let found = model(
        r#"<body name="fixed" pos="0 0 1"><geom size=".5"/>
             <body name="arm" pos="1 0 0" euler="0 0 90"><joint/><geom size=".5" density="1"/>
               <body name="hand" pos="2 0 0"><geom name="g" size=".5" pos="0 1 0" density="3"/></body></body>
           </body>"#,
        "",
    );
    assert_eq!(found.bodies.len(), 2);
    assert_eq!((found.bodies[0].parts, found.bodies[1].parts), (2, 2));
    assert_eq!((found.bodies[0].kind, found.bodies[1].kind), (BodyKind::Fixed, BodyKind::Jointed));
    assert_eq!((found.bodies[1].name.as_str(), found.bodies[1].parent), ("arm", 0));
    near(found.bodies[1].placement.position, [1.0, 0.0, 1.0]);
    near(found.bodies[0].geoms[0].placement.position, [0.0, 0.0, 1.0]);
    near(found.bodies[1].geoms[1].placement.position, [2.0, 1.0, 0.0]);
    assert_eq!((found.bodies[1].geoms[0].part, found.bodies[1].geoms[1].part), (2, 3));
    near(found.bodies[1].mass.unwrap().center, [1.5, 0.75, 0.0]);
    assert!(found.joints[0].collide, "the parent is the world");
}

#[test]
fn forms_and_sizes() {
    let found = model(
        r#"<geom type="plane" size="0 0 1"/><geom type="sphere" size=".1"/><geom type="capsule" size=".1 .2"/>
           <geom type="cylinder" size=".1 .2"/><geom type="box" size=".1 .2 .3"/>
           <geom type="ellipsoid" size=".1 .2 .3"/>
           <geom type="box" size=".1 .2 .3" fromto="0 0 0 1 0 0"/>
           <geom type="capsule" size=".1" fromto="1 0 0 1 0 4"/>"#,
        "",
    );
    let forms: Vec<Form> = found.bodies[0].geoms.iter().map(|geom| geom.form).collect();
    let expected = [
        Form::HalfSpace,
        Form::Sphere { radius: 0.1 },
        Form::Capsule { half_height: 0.2, radius: 0.1 },
        Form::Cylinder { half_height: 0.2, radius: 0.1 },
        Form::Box { half_extents: [0.1, 0.2, 0.3] },
        Form::Ellipsoid { half_axes: [0.1, 0.2, 0.3] },
        Form::Box { half_extents: [0.1, 0.1, 0.5] },
        Form::Capsule { half_height: 2.0, radius: 0.1 },
    ];
    assert_eq!(forms, expected);
    let ends = &found.bodies[0].geoms[6].placement;
    near(ends.transform([0.0, 0.0, 0.5]), [0.0, 0.0, 0.0]);
    near(ends.transform([0.0, 0.0, -0.5]), [1.0, 0.0, 0.0]);
    assert_eq!(found.bodies[0].mass, None);
}

#[test]
fn surfaces() {
    let found = model(
        r#"<geom size="1"/><geom size="1" friction=".5" condim="1" contype="2" conaffinity="4"/>
           <geom size="1" solref="-100 -0"/><geom size="1" solref=".02 .5"/><geom size="1" solref="-100 -10"/>"#,
        "",
    );
    let geoms = &found.bodies[0].geoms;
    assert_eq!((geoms[0].friction, geoms[0].condim), ([1.0, 0.005, 0.0001], 3));
    assert_eq!((geoms[1].friction, geoms[1].condim), ([0.5, 0.005, 0.0001], 1));
    assert!(!geoms[0].meets(&geoms[1]) && geoms[0].meets(&geoms[2]) && !geoms[1].meets(&geoms[1]));
    assert_eq!((geoms[0].restitution, geoms[2].restitution), (0.0, 1.0));
    // A damping ratio of a half, as such and as 10 / (2 sqrt 100).
    let half = (-PI / 3.0f64.sqrt()).exp();
    assert!((geoms[3].restitution - half).abs() < 1.0e-12 && (geoms[4].restitution - half).abs() < 1.0e-12);
}

#[test]
fn mass_comes_from_the_right_place() {
    let mass = |compiler: &str, inside: &str| {
        let text = format!(
            r#"<mujoco><compiler {compiler}/><worldbody><body><freejoint/>{inside}</body></worldbody></mujoco>"#
        );
        read(&text).bodies[1].mass.unwrap()
    };
    let both =
        r#"<inertial pos="1 2 3" mass="2" diaginertia="1 2 2.5" euler="0 0 90"/><geom size="1" mass="5"/>"#;
    let given = mass("", both);
    assert_eq!((given.mass, given.center, given.inertia), (2.0, [1.0, 2.0, 3.0], [1.0, 2.0, 2.5]));
    near(given.axes.rotate([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
    assert_eq!(mass(r#"inertiafromgeom="true""#, both).mass, 5.0);
    assert_eq!(mass(r#"inertiafromgeom="false""#, both).mass, 2.0);
    near(mass("", r#"<geom size="1" mass="5"/>"#).inertia, [2.0; 3]);
    let groups = r#"<geom size="1" mass="5" group="3"/><geom size="1" mass="1"/>"#;
    assert_eq!(mass(r#"inertiagrouprange="0 2""#, groups).mass, 1.0);
    assert_eq!(mass(r#"boundmass="7" boundinertia="3""#, groups).mass, 7.0);
    near(mass(r#"boundinertia="3""#, r#"<geom size="1" mass="1"/>"#).inertia, [3.0; 3]);
    assert_eq!(mass(r#"settotalmass="12""#, groups).mass, 12.0);
    let odd = r#"<inertial pos="0 0 0" mass="1" diaginertia="1 2 9"/>"#;
    near(mass(r#"balanceinertia="true""#, odd).inertia, [4.0; 3]);
    // In order xx yy zz xy xz yz, here a turn by 45 degrees about z.
    let full = mass("", r#"<inertial pos="0 0 0" mass="1" fullinertia="1.5 1.5 2 .5 0 0"/>"#);
    let mut moments = full.inertia;
    moments.sort_by(f64::total_cmp);
    near(moments, [1.0, 2.0, 2.0]);
    let framed =
        r#"<frame pos="1 0 0" euler="0 0 90"><inertial pos="1 0 0" mass="1" diaginertia="1 1 1"/></frame>"#;
    near(mass("", framed).center, [1.0, 1.0, 0.0]);
}

#[test]
fn joints_of_a_body_in_their_order() {
    let found = model(
        r#"<body name="a" pos="1 0 0" euler="0 0 90"><freejoint/><geom size="1"/>
             <body name="b" pos="1 0 0">
               <joint name="h" axis="2 0 0" pos="0 1 0" range="-90 180" ref="90" springref="45" stiffness="3"
                 damping="4" armature="5" frictionloss="6"/>
               <joint name="s" type="slide" axis="0 1 1" range="-1 2" ref=".5" springref="1"/>
               <frame pos="0 0 1" euler="90 0 0"><joint name="b" type="ball" pos="0 1 0" range="0 60"/></frame>
               <geom size="1"/></body></body>"#,
        "",
    );
    let joint = &found.joints[0];
    assert_eq!((joint.parent, joint.child, joint.collide, joint.parts.len()), (1, 2, false, 3));
    let [hinge, slide, ball] = &joint.parts[..] else { panic!("three") };
    assert_eq!((hinge.motion, slide.motion, ball.motion), (Motion::Hinge, Motion::Slide, Motion::Ball));
    near(hinge.axis, [1.0, 0.0, 0.0]);
    near(hinge.world_axis, [0.0, 1.0, 0.0]);
    near(hinge.anchor, [0.0, 1.0, 0.0]);
    near(hinge.world_anchor, [0.0, 1.0, 0.0]);
    let [low, high] = hinge.range.unwrap();
    near([low, high, hinge.spring_rest], [-PI, PI / 2.0, -PI / 4.0]);
    assert_eq!((hinge.stiffness, hinge.damping, hinge.armature, hinge.friction_loss), (3.0, 4.0, 5.0, 6.0));
    assert_eq!((slide.range, slide.spring_rest, slide.reference), (Some([-1.5, 1.5]), 0.5, 0.5));
    near(ball.anchor, [0.0, 0.0, 2.0]);
    assert!((ball.range.unwrap()[1] - PI / 3.0).abs() < 1.0e-12);
}

#[test]
fn free_and_mocap_bodies() {
    let found = model(
        r#"<body><joint type="free"/><geom size="1"/></body><body mocap="true" pos="0 0 9"><geom size="1"/></body>
           <frame pos="1 0 0"><body gravcomp=".25"><freejoint/><geom size="1"/></body></frame>"#,
        "",
    );
    let kinds: Vec<BodyKind> = found.bodies.iter().map(|body| body.kind).collect();
    assert_eq!(kinds, [BodyKind::Fixed, BodyKind::Free, BodyKind::Mocap, BodyKind::Free]);
    assert_eq!(found.bodies[3].gravity_compensation, 0.25);
    let scene = found.to_scene().unwrap().scene;
    // The world has no geoms and is left out.
    assert_eq!(scene.bodies.len(), 3);
    assert_eq!(scene.bodies[2].gravity_scale, 0.75);
}

#[test]
fn replicates_turn_and_move() {
    let found = model(
        r#"<replicate count="11" offset="1 0 0" euler="0 0 90" sep="-"><frame pos="0 2 0">
             <replicate count="2" offset="0 0 1"><body name="b"><freejoint/><geom name="g" size=".1"/></body>
             </replicate>           </frame></replicate>"#,
        "",
    );
    assert_eq!(found.bodies.len(), 23);
    let names: Vec<&str> = found.bodies[1..4].iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["b0-00", "b1-00", "b0-01"]);
    assert_eq!(found.bodies[22].geoms[0].name, "g1-10");
    // The offset is in the frame of the copy before: a square.
    near(found.bodies[1].placement.position, [0.0, 2.0, 0.0]);
    near(found.bodies[3].placement.position, [-1.0, 0.0, 0.0]);
    near(found.bodies[5].placement.position, [1.0, -1.0, 0.0]);
    near(found.bodies[7].placement.position, [2.0, 1.0, 0.0]);
    near(found.bodies[10].placement.position, [0.0, 2.0, 1.0]);
    let many = model(
        r#"<body><freejoint/><replicate count="3" offset="1 0 0"><geom size=".1"/></replicate></body>"#,
        "",
    );
    assert_eq!((many.bodies.len(), many.bodies[1].geoms.len()), (2, 3));
    assert_eq!(model(r#"<replicate count="0"><body/></replicate>"#, "").bodies.len(), 1);
}

#[test]
fn links_are_replicated() {
    let found = model(
        r#"<site name="top" pos="0 0 3"/>
           <replicate count="3" offset="2 0 0"><body name="b"><joint name="j"/><geom size=".1"/>
             <site name="s" pos="0 0 .1"/></body></replicate>"#,
        r#"<tendon><spatial range="0 3"><site site="top"/><site site="s"/></spatial></tendon>
           <contact><exclude body1="b" body2="b2"/></contact>
           <actuator><motor joint="j1"/><motor joint="j"/></actuator>"#,
    );
    let ends: Vec<(usize, usize)> = found.ropes.iter().map(|rope| (rope.a.body, rope.b.body)).collect();
    assert_eq!(ends, [(0, 1), (0, 2), (0, 3)]);
    // A body is not excluded from itself.
    let excluded: Vec<[usize; 2]> = found.excludes.iter().map(|exclude| exclude.bodies).collect();
    assert_eq!(excluded, [[1, 3], [2, 3]]);
    let driven: Vec<Transmission> = found.actuators.iter().map(|actuator| actuator.transmission).collect();
    assert_eq!(driven, [1, 0, 1, 2].map(|joint| Transmission::Joint(joint, 0)));
}

#[test]
fn equalities() {
    let found = model(
        r#"<body name="a" pos="1 2 3" euler="0 0 90"><freejoint/><geom size=".1"/>
             <body name="c" pos="1 0 0"><geom size=".1"/><site name="s" pos="0 1 0"/></body></body>
           <body name="b" pos="4 5 6"><freejoint/><geom size=".1"/><site name="t" pos="0 0 1"/></body>"#,
        r#"<equality><connect body1="c" body2="b" anchor="0 0 1"/><weld body1="a" body2="b"/>
             <weld name="w" active="false" body1="a" body2="b" relpose="1 0 0 1 0 0 1" anchor="1 0 0"/>
             <connect site1="s" site2="t"/><weld body1="b"/><weld body1="a" body2="c"/></equality>"#,
    );
    let [connect, weld, given, sites, world] = &found.equalities[..] else {
        panic!("{:?}", found.equalities)
    };
    let world_of =
        |(body, frame): (usize, super::super::Placement)| found.bodies[body].placement.after(&frame);
    assert_eq!((connect.weld, connect.a.0, connect.b.0), (false, 1, 2));
    near(connect.a.1.position, [1.0, 0.0, 1.0]);
    near(world_of(connect.b).position, [1.0, 3.0, 4.0]);
    // Without a pose, as they are.
    near(world_of(weld.a).position, [4.0, 5.0, 6.0]);
    near(world_of(weld.a).transform([1.0, 0.0, 0.0]), world_of(weld.b).transform([1.0, 0.0, 0.0]));
    // The second body at x = 1 of the first and turned; the frames at x = 1 of the second.
    assert!(given.weld && !given.active && given.name == "w");
    near(given.b.1.position, [1.0, 0.0, 0.0]);
    near(given.a.1.position, [1.0, 1.0, 0.0]);
    near(given.a.1.turn.rotate([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
    near(sites.a.1.position, [1.0, 1.0, 0.0]);
    near(sites.b.1.position, [0.0, 0.0, 1.0]);
    assert_eq!((world.a.0, world.b.0), (2, 0));
}

#[test]
fn ropes_and_actuators() {
    let found = model(
        r#"<site name="a"/><site name="c" fromto="0 0 0 0 0 2"/><body name="b" pos="0 0 -1"><joint name="j"/>
           <geom size=".1"/><site name="s"/></body>"#,
        r#"<default><motor ctrlrange="-1 1"/><position kp="30"/></default>
           <tendon><spatial name="r" limited="true" range="0 2" stiffness="5"><site site="a"/>
             <site site="s"/></spatial>
             <spatial><site site="a"/><site site="s"/></spatial>
             <spatial range="0 1"><site site="a"/><site site="c"/><site site="s"/></spatial></tendon>
           <actuator><motor joint="j" gear="3 1"/><position joint="j" kv="2" forcerange="-4 5"/>
             <velocity joint="j" kv="7"/>
             <position cranksite="s" slidersite="c" cranklength=".5"/></actuator>"#,
    );
    assert_eq!(found.ropes.len(), 1, "a tendon without effect, and one of three sites, are none");
    assert_eq!(
        (found.ropes[0].range, found.ropes[0].stiffness, found.ropes[0].rest),
        (Some([0.0, 2.0]), 5.0, [1.0; 2])
    );
    let controls: Vec<Control> = found.actuators.iter().map(|actuator| actuator.control).collect();
    let expected = [
        Control::Motor,
        Control::Position { kp: 30.0, kv: 2.0 },
        Control::Velocity { kv: 7.0 },
        Control::Position { kp: 30.0, kv: 0.0 },
    ];
    assert_eq!(controls, expected);
    assert_eq!((found.actuators[0].gear, found.actuators[1].force_range), (3.0, Some([-4.0, 5.0])));
    assert!(found.actuators.iter().all(|actuator| actuator.control_range == Some([-1.0, 1.0])));
    let Transmission::SliderCrank { crank, body, slider, rod } = found.actuators[3].transmission else {
        panic!()
    };
    assert_eq!((crank.body, body, rod), (1, 0, 0.5));
    near(slider.position, [0.0, 0.0, 1.0]);
}

#[test]
fn meshes_are_hulls() {
    let found = read(
        r#"<mujoco><asset><mesh name="m" scale="1 2 3" vertex="0 0 0 1 0 0 0 1 0 0 0 1 .2 .2 .2"/>
             <mesh name="n" refpos="1 0 0" refquat="1 0 0 1" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
           <worldbody><body><freejoint/><geom type="mesh" mesh="m"/></body><body><freejoint/>
             <geom type="mesh" mesh="n" mass="3"/><geom type="mesh" mesh="n" mass="3"/></body></worldbody>
           </mujoco>"#,
    );
    assert_eq!(found.meshes.len(), 2);
    assert_eq!(found.meshes[0].points.len(), 4, "the fifth lies within");
    let mass = found.bodies[1].mass.unwrap();
    assert!((mass.mass - 1000.0).abs() < 1.0e-3);
    assert!((mass.center[2] - 0.75).abs() < 1.0e-6);
    assert!((found.bodies[2].mass.unwrap().mass - 6.0).abs() < 1.0e-9);
    // Moved by -x, then turned back by a quarter about z.
    assert!(
        found.meshes[1].points.contains(&[0.0, 1.0, 0.0])
            || found.meshes[1].points.iter().any(|p| p[1] > 0.99)
    );
}

#[test]
fn rounder_meshes_keep_their_mass() {
    let mut vertices = String::new();
    for i in 0..40 {
        let angle = f64::from(i) * PI / 20.0;
        for z in [-1.0, 1.0] {
            vertices += &format!("{} {} {z} ", angle.cos(), angle.sin());
        }
    }
    let found = read(&format!(
        r#"<mujoco><asset><mesh name="m" vertex="{vertices}"/></asset>
           <worldbody><geom type="mesh" mesh="m"/></worldbody>
           </mujoco>"#
    ));
    assert!(found.meshes[0].points.len() <= 64);
    assert!(found.meshes[0].volume > 5.0 && found.meshes[0].volume < 2.0 * PI, "{}", found.meshes[0].volume);
    assert_eq!(found.warnings[0].effect, Effect::Motion);
}

#[test]
fn models_attach_to_themselves() {
    let found = model(
        r#"<body name="a" pos="0 0 1"><joint name="j"/><geom size="1"/>
             <body name="i"><joint/><geom size="1"/></body></body>
           <frame pos="5 0 0"><attach body="a" prefix="x_"/></frame>"#,
        r#"<contact><exclude body1="a" body2="i"/></contact><actuator><motor joint="j"/></actuator>"#,
    );
    assert_eq!(found.bodies.len(), 5);
    assert_eq!(found.bodies[3].name, "x_a");
    near(found.bodies[3].placement.position, [5.0, 0.0, 1.0]);
    assert_eq!((found.excludes.len(), found.actuators.len()), (2, 2));
}

#[test]
fn what_is_left_out_is_told_once() {
    let found = model(
        r#"<light/><light/><geom size="1" rgba="1 1 1 1" margin="1" siez="2"/><geom size="1" margin="1"/>
           <geom type="hfield" hfield="h"/><bdy/><composite type="cable"/>"#,
        r#"<option integrator="RK4"/><keyframe><key/></keyframe><actuator><muscle/></actuator><tendn/>"#,
    );
    let told: Vec<(Effect, &str, usize)> =
        found.warnings.iter().map(|warning| (warning.effect, warning.what.as_str(), warning.count)).collect();
    let expected = [
        (Effect::Nothing, "worldbody/light", 2),
        (Effect::Nothing, "geom/rgba", 1),
        (Effect::Motion, "geom/margin", 2),
        (Effect::Unknown, "geom/siez", 1),
        (Effect::Motion, "geom/hfield", 1),
        (Effect::Unknown, "worldbody/bdy", 1),
        (Effect::Motion, "worldbody/composite", 1),
        (Effect::Solver, "option/integrator", 1),
        (Effect::Nothing, "mujoco/keyframe", 1),
        (Effect::Motion, "actuator/muscle", 1),
        (Effect::Unknown, "mujoco/tendn", 1),
        (Effect::Motion, "geom (hfield)", 1),
    ];
    assert_eq!(told, expected);
    let shown = found.warnings[2].to_string();
    assert!(shown.starts_with("geom/margin: not modelled (2 times, first at line 1, column "), "{shown}");
}

#[test]
fn contact_bits_become_filters() {
    let found = model(
        r#"<geom type="plane" size="1 1 1" contype="1" conaffinity="0"/><body><freejoint/><geom size="1" contype="0"
           conaffinity="1"/></body><body><freejoint/><geom size="1" contype="2" conaffinity="1"/><geom size="1"
           contype="0" conaffinity="0"/></body>"#,
        "",
    );
    let scene = found.to_scene().unwrap().scene;
    assert_eq!(scene.bodies[2].shapes.len(), 1, "what collides with nothing is left out");
    let geoms = [&found.bodies[0].geoms[0], &found.bodies[1].geoms[0], &found.bodies[2].geoms[0]];
    let filters = [0, 1, 2].map(|body| scene.bodies[body].shapes[0].filter);
    for (i, a) in filters.iter().enumerate() {
        for (j, b) in filters.iter().enumerate() {
            let met = a.category & b.mask != 0 && b.category & a.mask != 0;
            assert_eq!(met, geoms[i].meets(geoms[j]), "{i} {j}");
        }
    }
}

#[test]
fn scenes_build_and_fall() {
    let found = model(
        r#"<geom type="plane" size="1 1 1"/>
           <body pos="0 0 1"><freejoint/><geom type="cylinder" size=".1 .2"/></body>
           <body pos="1 0 1"><freejoint/><geom type="ellipsoid" size=".1 .2 .3"/></body>
           <body pos="2 0 1"><freejoint/><geom type="capsule" size=".1 .2"/><geom size=".1" pos="0 0 .5"/></body>"#,
        r#"<option timestep=".005"/>"#,
    );
    let conversion = found.to_scene().unwrap();
    let told: Vec<&str> = conversion.warnings.iter().map(|warning| warning.what.as_str()).collect();
    assert!(told.iter().any(|what| what.starts_with("ellipsoid")), "{told:?}");
    assert_eq!((conversion.scene.settings.dt, conversion.scene.settings.substeps), (Some(0.005), Some(2)));
    let text = conversion.scene.to_json();
    let again = crate::scene::Scene::from_json(text.as_bytes(), &Default::default()).unwrap();
    assert_eq!(again, conversion.scene);
    let mut built = conversion.scene.build(std::path::Path::new("")).unwrap();
    for _ in 0..400 {
        built.world.step(&mut crate::Serial);
    }
    for &body in &built.bodies[1..] {
        let height = built.world.center(body).unwrap().to_f64()[2];
        assert!((0.05..0.5).contains(&height), "{height}");
    }
}

#[test]
fn too_many_kinds_of_contact_bits_are_refused() {
    let geoms: String =
        (0..40).map(|i| format!(r#"<geom size="1" contype="{}" conaffinity="{}"/>"#, i, i)).collect();
    let message = model(&geoms, "").to_scene().unwrap_err().to_string();
    assert!(message.contains("at most 32 kinds"), "{message}");
}
