//! cellstep as an entrant: each preset, and a sweep of each knob around `balanced`.

use crate::engine::{Config, Engine};
use crate::scene::{JointKind, Kind, Mass, Seen, Setup, Shape};
use cellstep::config::MANIFOLD_DRIFT;
use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, ContactModel, FrictionModel, Geometry, JointDef,
    MassProperties, Position, Preset, Serial, Settings, ShapeDef, ShapeHandle,
};
use cellstep_tests::oracles;
use cellstep_tests::worlds::{OwnedWorld, world_with};

/// Name of the engine in tables.
pub const NAME: &str = "cellstep";

/// A world of a scene and its handles.
pub struct Filled {
    pub world: OwnedWorld,
    pub bodies: Vec<BodyHandle>,
    /// `None` for bodies without shape.
    pub shapes: Vec<Option<ShapeHandle>>,
}

impl Filled {
    pub fn new(setup: &Setup, dial: &Settings) -> Self {
        let hulls = u32::from(!setup.hull.is_empty());
        let joints = setup.joints.len() as u32;
        let bodies = setup.bodies.len() as u32;
        // Boxes of small bodies meet with many neighbours.
        let (pairs, contacts) = (64 + 32 * bodies, 32 + 16 * bodies);
        let capacities = Capacities { joints, hulls, pairs, contacts, ..Capacities::for_bodies(bodies) };
        let mut world = world_with(capacities);
        let settings = Settings { dt: setup.dt, gravity: setup.gravity, sleep_time: 0.0, ..*dial };
        world.set_settings(&settings).expect("numbers in range");
        let hull = (hulls > 0).then(|| world.add_hull(&setup.hull).expect("the points span a hull"));
        let (mut bodies, mut shapes) = (Vec::new(), Vec::new());
        for body in &setup.bodies {
            let def = BodyDef {
                position: Position::from_f64(body.position),
                rotation: body.rotation,
                linear_velocity: body.velocity,
                angular_velocity: body.spin,
                mass: match body.mass {
                    Mass::Given(mass, inertia) if body.moves => {
                        Some(MassProperties { mass, inertia, center: Vec3::ZERO, axes: Rotation::IDENTITY })
                    }
                    _ => None,
                },
                ..BodyDef::new(if body.moves { BodyKind::Dynamic } else { BodyKind::Static }, Vec3::ZERO)
            };
            let handle = world.create_body(&def).expect("room");
            let geometry = body.shape.map(|shape| match shape {
                Shape::Sphere(radius) => Geometry::Sphere { radius },
                Shape::Box(half_extents) => Geometry::Box { half_extents },
                Shape::Capsule { half_height, radius } => Geometry::Capsule { half_height, radius },
                Shape::Hull => Geometry::Hull(hull.expect("the world has a hull")),
            });
            shapes.push(geometry.map(|geometry| {
                let density = if let Mass::Density(density) = body.mass { density } else { 0.0 };
                let (friction, restitution) = (body.friction, body.restitution);
                let def = ShapeDef { density, friction, restitution, ..ShapeDef::new(geometry) };
                world.create_shape(handle, &def).expect("room")
            }));
            bodies.push(handle);
        }
        for joint in &setup.joints {
            let (ends, frames) = (joint.bodies.map(|body| bodies[body]), joint.frames);
            let def = match joint.kind {
                JointKind::Ball => JointDef::ball(ends, frames),
                JointKind::Hinge => JointDef::hinge(ends, frames),
                JointKind::Slider => JointDef::slider(ends, frames),
            };
            world.create_joint(&def).expect("room");
        }
        Self { world, bodies, shapes }
    }
}

impl Engine for Filled {
    fn step(&mut self) {
        let report = self.world.step(&mut Serial);
        assert_eq!(report.dropped, 0, "the capacities hold the scene");
    }

    fn read(&self, seen: &mut Vec<Seen>) {
        seen.clear();
        seen.extend(self.bodies.iter().map(|&body| Seen {
            position: oracles::center(&self.world, body),
            rotation: self.world.rotation(body).expect("it is there"),
            velocity: oracles::velocity(&self.world, body),
            spin: oracles::spin(&self.world, body),
        }));
    }
}

/// All settings of the dial in a line.
pub fn describe(s: &Settings) -> String {
    let inner = if s.inner_sweeps > 1 { format!(" x {} inner", s.inner_sweeps) } else { String::new() };
    let sweeps = format!("{} x ({}{inner} + {})", s.substeps, s.sweeps, s.relax_sweeps);
    let contacts = match s.contact_model {
        ContactModel::Soft => {
            let frequency = match s.contact_frequency {
                0.0 => format!("{}/h", cellstep::config::CONTACT_COUPLING),
                hertz => format!("{hertz} Hz"),
            };
            format!("soft {frequency}, damping {}", s.contact_damping_ratio)
        }
        ContactModel::Rigid => "rigid".to_string(),
        ContactModel::Split => "split".to_string(),
    };
    let refined = match s.refine {
        1 => "not refined".to_string(),
        times => {
            format!("up to {} bodies that sink {} m refined by {times}", s.refine_bodies, s.refine_sink)
        }
    };
    let continuous = if s.continuous { "" } else { ", not continuous" };
    let friction = match s.friction_model {
        FrictionModel::Patch => "",
        FrictionModel::Points => ", friction by points",
    };
    let manifolds = match s.manifold_drift {
        MANIFOLD_DRIFT => String::new(),
        0.0 => ", manifolds anew".to_string(),
        drift => format!(", manifolds kept for {drift} m"),
    };
    let joints = if s.direct_joints { "" } else { ", joints one by one" };
    format!("{sweeps}, {contacts}, {refined}{friction}{manifolds}{continuous}{joints}")
}

/// Leaves out settings that came before, but for presets.
fn leave_out_twins(named: &mut Vec<(String, Settings, Option<Preset>)>) {
    let mut known: Vec<Settings> = Vec::new();
    named.retain(|(_, settings, preset)| {
        let is_new = preset.is_some() || !known.contains(settings);
        known.push(*settings);
        is_new
    });
}

/// The knobs of contacts.
fn sweep_contacts((balanced, plain): (Settings, Settings), add: &mut impl FnMut(String, Settings)) {
    for contact_frequency in [15.0, 30.0, 60.0] {
        add(format!("{contact_frequency} Hz"), Settings { contact_frequency, ..balanced });
    }
    for contact_damping_ratio in [2.0, 20.0] {
        add(format!("damping {contact_damping_ratio}"), Settings { contact_damping_ratio, ..balanced });
    }
    let calm = Settings { substeps: 64, contact_damping_ratio: 20.0, ..plain };
    add("64 substeps, damping 20".to_string(), calm);
    add("rigid".to_string(), Settings { contact_model: ContactModel::Rigid, ..balanced });
    add("not refined".to_string(), plain);
    add("per-point friction".to_string(), Settings { friction_model: FrictionModel::Points, ..balanced });
    add("manifolds anew".to_string(), Settings { manifold_drift: 0.0, ..balanced });
    for refine in [2, 8] {
        add(format!("refined by {refine}"), Settings { refine, ..balanced });
    }
    // The peers' stiffness, as cheap as can be.
    let stiff = Settings { contact_frequency: 30.0, continuous: false, ..plain };
    add("2 substeps, 30 Hz, not continuous".to_string(), Settings { substeps: 2, ..stiff });
    let stiff_and_calm = Settings { substeps: 4, contact_damping_ratio: 20.0, ..stiff };
    add("4 substeps, 30 Hz, damping 20, not continuous".to_string(), stiff_and_calm);
    for substeps in [1, 2, 4, 6, 12, 32] {
        let settings = Settings { substeps, contact_model: ContactModel::Split, ..plain };
        add(format!("split, {substeps} substeps"), settings);
    }
}

/// The presets, then what differs from `balanced` in one setting, then split contacts at more and fewer substeps
/// without refinement.
/// What is the same as one before is left out, and so is what cannot matter in the scene.
pub fn configs(kind: Kind) -> Vec<Config> {
    let balanced = Settings::from(Preset::Balanced);
    let mut named: Vec<(String, Settings, Option<Preset>)> = Preset::ALL
        .into_iter()
        .map(|preset| (preset.name().to_string(), Settings::from(preset), Some(preset)))
        .collect();
    let mut add = |name: String, settings: Settings| named.push((name, settings, None));
    for substeps in [1, 2, 3, 6, 8] {
        add(format!("{substeps} substeps"), Settings { substeps, ..balanced });
    }
    // As the peers at their cheapest: what is fast may pass through a wall, and all bodies have the same substeps.
    let least = Settings { substeps: 1, continuous: false, refine: 1, ..balanced };
    add("1 substep, not continuous, 0 relax sweeps".to_string(), Settings { relax_sweeps: 0, ..least });
    add("1 substep, not continuous".to_string(), least);
    for substeps in [2, 4, 6, 8] {
        add(format!("{substeps} substeps, not continuous"), Settings { substeps, ..least });
    }
    // With so many substeps nothing needs refinement.
    let plain = Settings { refine: 1, ..balanced };
    for substeps in [16, 32, 64] {
        add(format!("{substeps} substeps"), Settings { substeps, ..plain });
    }
    if kind != Kind::Free {
        for sweeps in [2, 4] {
            add(format!("{sweeps} sweeps"), Settings { sweeps, ..balanced });
        }
        for inner_sweeps in [2, 4] {
            add(format!("{inner_sweeps} inner sweeps"), Settings { inner_sweeps, ..balanced });
        }
        for relax_sweeps in [0, 2] {
            add(format!("{relax_sweeps} relax sweeps"), Settings { relax_sweeps, ..balanced });
        }
    }
    if kind.has_joints() {
        let loose = Settings { direct_joints: false, ..plain };
        add("1 substeps, 0 relax sweeps".to_string(), Settings { substeps: 1, relax_sweeps: 0, ..plain });
        for (substeps, relax_sweeps) in [(1, 0), (1, 1), (2, 1), (4, 1), (8, 1)] {
            let swept = if relax_sweeps == 0 { ", 0 relax sweeps" } else { "" };
            let name = format!("{substeps} substeps, iterative joints{swept}");
            add(name, Settings { substeps, relax_sweeps, ..loose });
        }
    }
    if kind.has_contacts() {
        sweep_contacts((balanced, plain), &mut add);
    }
    leave_out_twins(&mut named);
    let config = |(name, settings, preset): (String, Settings, Option<Preset>)| Config {
        engine: NAME,
        name,
        settings: describe(&settings),
        substeps: settings.substeps,
        preset,
        is_default: preset == Some(Preset::default()),
        make: Box::new(move |setup| Box::new(Filled::new(setup, &settings))),
    };
    named.into_iter().map(config).collect()
}
