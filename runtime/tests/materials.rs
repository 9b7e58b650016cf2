//! Materials of scene documents in the worlds that are made from them.
#![cfg(feature = "scene")]

use cellstep::math::Vec3;
use cellstep::scene::format::CapacitiesDoc;
use cellstep::scene::{Limits, Scene};
use cellstep::{MaterialTraits, Mix};
use std::path::Path;

/// What a document says of materials is what the shapes of its world have; alike ones share their room.
#[test]
fn materials_come_to_their_shapes() {
    let text = br#"{
        "materials": {
            "plain": { "friction": 0.3 },
            "belt": { "surface_velocity": [1, 0, 0], "friction_mix": "max" },
            "also": { "friction": 0.9, "surface_velocity": [1, 0, 0], "friction_mix": "max" },
            "soft": { "rolling": 0.01, "spinning": 0.02, "restitution_mix": "min", "one_way": [0, 0, 2] }
        },
        "bodies": [{ "shapes": [
            { "geometry": { "sphere": { "radius": 1 } }, "material": "plain" },
            { "geometry": { "sphere": { "radius": 1 } }, "material": "belt" },
            { "geometry": { "sphere": { "radius": 1 } }, "material": "also" },
            { "geometry": { "sphere": { "radius": 1 } }, "material": "soft" }
        ] }]
    }"#;
    let scene = Scene::from_json(text, &Limits::default()).expect("a scene");
    let built = scene.build(Path::new(".")).expect("it can be built");
    assert_eq!(built.world.capacities().materials, 3);
    let shapes: Vec<_> = built
        .world
        .shapes_of(built.bodies[0])
        .expect("it exists")
        .map(|shape| built.world.shape(shape).expect("it exists").traits)
        .collect();
    let belt =
        MaterialTraits { surface_velocity: Vec3::X, friction_mix: Mix::Max, ..MaterialTraits::default() };
    let soft = MaterialTraits {
        rolling: 0.01,
        spinning: 0.02,
        restitution_mix: Mix::Min,
        one_way: Some(Vec3::Z),
        ..MaterialTraits::default()
    };
    assert_eq!(shapes, [MaterialTraits::default(), belt, belt, soft]);
    // Two of the three are one material: a world with room for two will do.
    let capacities = CapacitiesDoc { materials: Some(2), ..CapacitiesDoc::default() };
    assert!(Scene { capacities, ..scene.clone() }.build(Path::new(".")).is_ok());
    let capacities = CapacitiesDoc { materials: Some(1), ..CapacitiesDoc::default() };
    let Err(error) = Scene { capacities, ..scene }.build(Path::new(".")) else { panic!("no room") };
    assert!(error.to_string().contains("bodies[0].shapes[3]"), "{error}");
    assert!(error.to_string().contains("`materials`"), "{error}");
}
