//! Springs, dampers, friction, rotors, ranges, actuators and equalities of small models, against closed forms.

use cellstep::Serial;
use cellstep::mjcf::{Effect, Model};
use cellstep::scene::{Build, Limits};
use std::path::Path;

/// Builds the world of a model with bodies of `body` in the world and what is `beside` it; 1/1000 s.
fn built(gravity: &str, body: &str, beside: &str) -> Build {
    let text = format!(
        "<mujoco><compiler angle='radian'/><option timestep='0.001' gravity='{gravity}'/>\
         <default><geom density='0'/></default><worldbody>{body}</worldbody>{beside}</mujoco>"
    );
    let model =
        Model::from_xml(text.as_bytes(), &Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    let scene = model.to_scene().expect("a scene").scene;
    scene.build(Path::new("")).unwrap_or_else(|error| panic!("{error}"))
}

/// A body of 2 kg and 0.3 kg m2 about its center, 0.5 m from its origin along x.
fn body(joints: &str) -> String {
    format!(
        "<body name='b' pos='0 0 1'>{joints}\
         <inertial pos='.5 0 0' mass='2' diaginertia='.3 .3 .3'/><site name='s' pos='.5 0 0'/></body>"
    )
}

fn steps(built: &mut Build, steps: u32) {
    for _ in 0..steps {
        built.world.step(&mut Serial);
    }
}

fn coordinate(built: &Build, axis: usize) -> f64 {
    f64::from(built.world.joint_coordinates(built.joints[0]).expect("it exists")[axis])
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    println!("{found:.6}, expected {expected:.6}");
    assert!((found - expected).abs() <= tolerance, "{found}, expected {expected}");
}

/// Moment of `body` about its origin.
const MOMENT: f64 = 0.3 + 2.0 * 0.25;

#[test]
fn a_spring_swings_with_its_damper_and_its_rotor() {
    let joint = "<joint axis='0 0 1' stiffness='8' springref='.3' damping='.4' armature='.2'/>";
    let mut built = built("0 0 0", &body(joint), "");
    let moment = MOMENT + 0.2;
    let (decay, free) = (0.4 / (2.0 * moment), 8.0 / moment);
    let rate = (free - decay * decay).sqrt();
    for tenth in 1..=20 {
        steps(&mut built, 100);
        let t = 0.1 * f64::from(tenth);
        let swing = (-decay * t).exp() * ((rate * t).cos() + decay / rate * (rate * t).sin());
        near(coordinate(&built, 3), 0.3 * (1.0 - swing), 2.0e-3);
    }
}

#[test]
fn a_slide_falls_against_friction_and_the_mass_of_its_rotor() {
    let joint = "<joint type='slide' axis='0 0 -1' frictionloss='4' armature='1'/>";
    let mut built = built("0 0 -10", &body(joint), "");
    steps(&mut built, 500);
    let acceleration = (2.0 * 10.0 - 4.0) / (2.0 + 1.0);
    near(coordinate(&built, 0), 0.5 * acceleration * 0.25, 5.0e-3);
}

#[test]
fn ranges_stop_in_both_ways() {
    // Of two hinges the weight turns the second, about y, by its range.
    let joints = "<joint axis='1 0 0' range='-.2 .1'/><joint axis='0 1 0' range='-.5 .7'/>";
    let mut model = built("0 0 -10", &body(joints), "");
    steps(&mut model, 1000);
    near(coordinate(&model, 3), 0.7, 2.0e-3);
    // A slide behind a hinge: seen from the other side, with its range turned round.
    let joints = "<joint axis='0 0 1' range='-.1 .1'/><joint type='slide' axis='0 0 -1' range='-.2 .6'/>";
    let mut slide = built("0 0 -10", &body(joints), "");
    steps(&mut slide, 1000);
    let z = slide.world.position(slide.bodies[1]).expect("it exists").to_f64()[2];
    near(z, 0.4, 2.0e-3);
}

#[test]
fn actuators_go_to_their_control() {
    let position = "<actuator><position joint='j' kp='50' kv='12' gear='2' ctrlrange='.4 1'/></actuator>";
    let mut servo = built("0 0 0", &body("<joint name='j' axis='0 1 0' ref='.1'/>"), position);
    steps(&mut servo, 5000);
    // The control is 0.4, the length twice MuJoCo's coordinate, which is 0.1 more than the value.
    near(coordinate(&servo, 3), 0.4 / 2.0 - 0.1, 1.0e-3);
    let velocity = "<actuator><velocity joint='j' kv='3' gear='2' ctrlrange='1 4'/></actuator>";
    let mut motor = built("0 0 0", &body("<joint name='j' axis='0 1 0' damping='4'/>"), velocity);
    steps(&mut motor, 2000);
    // 12 (0.5 - w) = 4 w.
    let w = f64::from(motor.world.angular_velocity(motor.bodies[1]).expect("it exists").y);
    near(w, 0.375, 1.0e-3);
    // With a bound on the force alone: 0.6 N m on the moment for 0.5 s.
    let bound =
        "<actuator><velocity joint='j' kv='100' gear='2' ctrlrange='9 9.5' forcerange='-.3 .3'/></actuator>";
    let mut weak = built("0 0 0", &body("<joint name='j' axis='0 1 0'/>"), bound);
    steps(&mut weak, 500);
    let w = f64::from(weak.world.angular_velocity(weak.bodies[1]).expect("it exists").y);
    near(w, 0.6 * 0.5 / MOMENT, 2.0e-3);
}

#[test]
fn ropes_hold_at_their_length_and_give_before() {
    let rope = "<tendon><spatial range='0 .8'><site site='s'/><site site='t'/></spatial></tendon>";
    let world = "<site name='t' pos='.5 0 1'/>";
    let mut model = built("0 0 -10", &format!("{}{world}", body("<freejoint/>")), rope);
    steps(&mut model, 300);
    let height = |model: &Build| model.world.center(model.bodies[1]).expect("it exists").to_f64()[2];
    near(height(&model), 1.0 - 0.5 * 10.0 * 0.09, 5.0e-3);
    steps(&mut model, 2000);
    near(height(&model), 0.2, 2.0e-3);
    // A spring between two lengths: slack up to 0.2 m, then 100 N/m: 20 N stretch it by 0.2 m.
    let spring = "<tendon><spatial stiffness='100' springlength='0 .2' damping='5'>\
                  <site site='s'/><site site='t'/></spatial></tendon>";
    let mut model = built("0 0 -10", &format!("{}{world}", body("<freejoint/>")), spring);
    steps(&mut model, 12_000);
    near(height(&model), 0.6, 5.0e-3);
}

#[test]
fn equalities_hold_and_excluded_bodies_pass() {
    // Welded to the world by a relative pose, and hung on a point.
    let weld = "<equality><weld body1='b'/></equality>";
    let mut model = built("0 0 -10", &body("<freejoint/>"), weld);
    steps(&mut model, 500);
    let place = model.world.position(model.bodies[1]).expect("it exists").to_f64();
    near(place[2], 1.0, 1.0e-4);
    let connect = "<equality><connect body1='b' anchor='0 0 0'/></equality>";
    let mut model = built("0 0 -10", &body("<freejoint/>"), connect);
    steps(&mut model, 500);
    let place = model.world.position(model.bodies[1]).expect("it exists").to_f64();
    near(place[0] * place[0] + place[2] - 1.0, 0.0, 1.0e-3);
    let down = model.world.center(model.bodies[1]).expect("it exists").to_f64()[2];
    assert!(down < 0.9, "it turns about the point: {down}");
    // Two balls that overlap are left alone, until the pair is one that meets.
    let ball = |name: &str, x: f64| {
        format!(
            "<body name='{name}' pos='{x} 0 0'><freejoint/><geom type='sphere' size='.1' mass='1'/></body>"
        )
    };
    let balls = format!("{}{}{}", ball("a", 0.0), ball("b", 0.1), ball("c", 0.2));
    let mut model = built("0 0 0", &balls, "<contact><exclude body1='a' body2='b'/></contact>");
    steps(&mut model, 200);
    let x: Vec<f64> =
        model.bodies.iter().map(|&body| model.world.position(body).expect("it exists").to_f64()[0]).collect();
    println!("{x:?}");
    assert!((x[0]).abs() < 1.0e-6, "the first touches nothing: {x:?}");
    assert!(x[2] - x[1] > 0.19, "the others push each other away: {x:?}");
}

#[test]
fn what_is_otherwise_is_told() {
    let text = "<mujoco><worldbody>\
        <body><joint type='ball' range='0 30' damping='1'/><geom size='1'/>\
          <body><joint axis='1 0 0'/><joint type='slide' axis='0 0 1'/><joint axis='0 1 0' pos='0 0 .5'/>\
            <geom size='1'/>\
            <body><joint axis='1 0 0' armature='1'/><joint axis='1 1 0'/><joint axis='0 0 1'/>\
              <geom size='1'/></body>\
          </body>\
        </body>\
        <body name='m' pos='0 0 5'><joint name='j' stiffness='1'/><geom size='1'/></body>\
        </worldbody><actuator><motor joint='j' ctrlrange='1 2'/>\
        <position joint='j' kp='2' forcerange='-1 2'/></actuator></mujoco>";
    let model =
        Model::from_xml(text.as_bytes(), &Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    let conversion = model.to_scene().expect("a scene");
    let told: Vec<String> = conversion.warnings.iter().map(ToString::to_string).collect();
    let expected = [
        "joint/armature: as inertia of the body, not of the joint: not modelled",
        "motor: its control is 0 in a scene: not modelled",
        "actuator/forcerange whose ends are not alike: not modelled",
        "actuator/forcerange beside another force on the joint: not modelled",
        "joint/range of a ball: as a cone and a twist of that angle: not modelled",
        "joint: forces of a ball by its three turns, each by itself: not modelled",
        "joint: slides between the hinges of a body, which go before them instead: not modelled",
        "joint/pos: axes of a body's hinges that do not meet, which turn about the point between them: \
         not modelled",
        "joint/axis: the second of three hinges not at right angles to the others: not modelled",
        "joint/range: the second of three hinges beyond 87 degrees, where the others turn as one: not modelled",
    ];
    assert_eq!(told, expected);
    assert!(conversion.warnings.iter().all(|warning| warning.effect == Effect::Motion));
}
