//! Model to scene document.
//!
//! Mass properties are written out for every body, so that densities play no part. Geoms that collide with nothing
//! are left out: nothing of what they do is lost.
//!
//! The armature of joints, the inertia of rotors that turn with them, goes to the body that they move: that of a
//! hinge as a moment of inertia about its axis, that of a ball about all axes, that of a slide as mass without
//! weight. So it resists the motion of the body where MuJoCo resists that of the joint; they are the same where the
//! body around it does not move. Where a moment then exceeds the sum of the others, which no solid has and a scene
//! refuses, the others are raised.

mod axes;
mod links;

use super::math::{Placement, Turn, Vector, add, length, scaled};
use super::mesh;
use super::model::{Body, BodyKind, Form, Geom, Joint, Mass, Model, Motion};
use super::warning::{Effect, Warning};
use crate::scene::format::{
    BodyDoc, FilterDoc, GeometryDoc, HullDoc, KindDoc, MassDoc, MaterialDoc, MixDoc, RotationDoc,
    SHAPES_PER_BODY_MAX, SettingsDoc, ShapeDoc,
};
use crate::scene::{Problem, Scene, SceneError};
use std::collections::{BTreeMap, BTreeSet};

/// Least substeps where something bounces: of a blow on a row of balls that touch, half the energy stays with one,
/// nine tenths with two.
const BOUNCE_SUBSTEPS: f64 = 2.0;
/// Steps of gravity whose speed is no impact.
const STEPS_OF_REST: f64 = 4.0;
/// Seconds of rest after which imported bodies sleep.
const SLEEP_TIME: f32 = 0.5;
/// Sweeps that take back what position correction leaves in the velocities of bodies that lie on their joints: a
/// hundred humanoids are asleep after 14 s with one, after 6 s with two, and with more no sooner.
const RELAX_SWEEPS: u32 = 2;
/// Substeps of a scene take about as long as the engine's own default, 1/240 s.
const SUBSTEPS_PER_SECOND: f64 = 240.0;
/// Bits of a filter.
const FILTERS_MAX: usize = 32;
/// Most pairs of contact bits that are compared.
const BITS_MAX: usize = 1 << 10;

/// A scene, and what of the model is not in it.
#[derive(Clone, Debug)]
pub struct Conversion {
    /// The scene. Its first body is the world where geoms of the world collide; the others are the model's, in
    /// their order.
    pub scene: Scene,
    /// The model's warnings and those of the conversion.
    pub warnings: Vec<Warning>,
}

impl Model {
    /// Makes a scene of a model.
    ///
    /// # Errors
    /// [`Problem::Invalid`] for more than 32 kinds of contact bits that differ in what they collide with.
    pub fn to_scene(&self) -> Result<Conversion, SceneError> {
        let mut making = Making {
            model: self,
            scene: Scene::default(),
            filters: self.filters()?,
            joints: self.joints.iter().map(|joint| (joint.child, joint)).collect(),
            places: Vec::new(),
            names: BTreeSet::new(),
            losses: Vec::new(),
            uneven: self.is_uneven(),
        };
        making.scene.description.clone_from(&self.name);
        making.scene.gravity = self.options.gravity.map(|x| x as f32);
        let threshold = self.restitution_threshold();
        let least = if threshold.is_some() { BOUNCE_SUBSTEPS } else { 1.0 };
        let substeps = (self.options.timestep * SUBSTEPS_PER_SECOND).ceil().clamp(least, 256.0) as u32;
        making.scene.settings = SettingsDoc {
            dt: Some(self.options.timestep as f32),
            substeps: Some(substeps),
            sleep_time: Some(SLEEP_TIME),
            restitution_threshold: threshold,
            relax_sweeps: (!self.joints.is_empty()).then_some(RELAX_SWEEPS),
            ..SettingsDoc::default()
        };
        for (index, body) in self.bodies.iter().enumerate() {
            making.body(index, body);
        }
        making.links();
        let mut warnings = self.warnings.clone();
        warnings.extend(self.losses());
        warnings.extend(making.losses.iter().map(|&(what, count)| lost(what, count)));
        Ok(Conversion { scene: making.scene, warnings })
    }

    /// What a scene says otherwise than the model.
    fn losses(&self) -> Vec<Warning> {
        let count = |is: &dyn Fn(&Geom) -> bool| self.colliding().filter(|geom| is(geom)).count();
        // The least coefficient among the geoms whose contacts have it.
        let least = |index: usize, condim: i32| {
            let rough = self.colliding().filter(|geom| geom.condim >= condim);
            rough.map(|geom| geom.friction[index]).fold(f64::INFINITY, f64::min)
        };
        let least = [least(0, 2), least(1, 4), least(2, 6)];
        let hides =
            |g: &Geom, index: usize, condim: i32| g.condim < condim && g.friction[index] > least[index];
        let losses = [
            ("ellipsoid as a hull of 58 points", count(&|g| matches!(g.form, Form::Ellipsoid { .. }))),
            ("geom/friction of a geom of condim 1 on a smoother one", count(&|g| hides(g, 0, 2))),
            (
                "geom/friction beyond sliding of a geom of less condim",
                count(&|g| hides(g, 1, 4) || hides(g, 2, 6)),
            ),
        ];
        losses.into_iter().filter(|loss| loss.1 > 0).map(|(what, count)| lost(what, count)).collect()
    }

    /// MuJoCo's contacts bounce at any speed. What gravity gives in a few steps would make a body at rest jump;
    /// above it all that bounces does.
    fn restitution_threshold(&self) -> Option<f32> {
        let bounces = self.colliding().any(|geom| geom.restitution > 0.0);
        let gravity = length(self.options.gravity);
        let least = (STEPS_OF_REST * gravity * self.options.timestep) as f32;
        let usual = cellstep_core::config::RESTITUTION_THRESHOLD;
        bounces.then_some(if least < usual { least } else { usual })
    }

    /// Whether geoms that collide have unlike sliding friction.
    fn is_uneven(&self) -> bool {
        let sliding = |geom: &Geom| if geom.condim < 2 { 0.0 } else { geom.friction[0] };
        let mut all = self.colliding().map(sliding);
        let first = all.next().unwrap_or(0.0);
        all.any(|friction| friction != first)
    }

    /// Geoms that collide with some geom, were it in reach.
    fn colliding(&self) -> impl Iterator<Item = &Geom> {
        let geoms = self.bodies.iter().flat_map(|body| &body.geoms);
        geoms.filter(|geom| geom.contype != 0 || geom.conaffinity != 0)
    }

    /// The filter of each pair of contact bits; none for what collides with nothing.
    ///
    /// MuJoCo asks for one of two directions, cellstep for both. So each class of geoms that collide with the same
    /// classes gets a category of its own, and the categories of those as its mask.
    fn filters(&self) -> Result<BTreeMap<(u32, u32), Option<FilterDoc>>, SceneError> {
        let geoms = self.bodies.iter().flat_map(|body| &body.geoms);
        let kinds: BTreeMap<(u32, u32), &Geom> =
            geoms.map(|geom| ((geom.contype, geom.conaffinity), geom)).collect();
        let mut classes: Vec<Vec<bool>> = Vec::new();
        let mut class_of = BTreeMap::new();
        if kinds.len() <= BITS_MAX {
            for (bits, geom) in &kinds {
                let row: Vec<bool> = kinds.values().map(|other| geom.meets(other)).collect();
                let class = classes.iter().position(|known| *known == row);
                class_of.insert(*bits, class.unwrap_or(classes.len()));
                if class.is_none() {
                    classes.push(row);
                }
            }
        }
        if classes.len() > FILTERS_MAX || kinds.len() > BITS_MAX {
            let found = format!("found {} pairs of `contype` and `conaffinity`", kinds.len());
            let expected = format!("at most {FILTERS_MAX} kinds of geoms that collide with others");
            let problem = Problem::Invalid { found, expected };
            return Err(SceneError { file: None, at: None, path: String::new(), problem });
        }
        let filter = |class: usize| {
            let meets = kinds.keys().zip(&classes[class]).filter(|met| *met.1);
            let mask = meets.fold(0, |mask, (bits, _)| mask | 1u32 << class_of[bits]);
            let alone = classes.len() == 1 && mask != 0;
            let own = FilterDoc { category: 1 << class, mask, group: 0 };
            (mask != 0).then_some(if alone { FilterDoc::default() } else { own })
        };
        Ok(class_of.iter().map(|(bits, &class)| (*bits, filter(class))).collect())
    }
}

fn lost(what: &str, count: usize) -> Warning {
    Warning { effect: Effect::Motion, what: what.to_string(), count, file: None, at: None }
}

struct Making<'a> {
    model: &'a Model,
    scene: Scene,
    filters: BTreeMap<(u32, u32), Option<FilterDoc>>,
    /// The joint that moves each body.
    joints: BTreeMap<usize, &'a Joint>,
    /// Where the bodies of the model are among those of the scene; the world may be at several places, or at none.
    places: Vec<std::ops::Range<u32>>,
    /// Names that are taken.
    names: BTreeSet<&'a str>,
    /// What is not as the model says, and how often.
    losses: Vec<(&'static str, usize)>,
    /// Whether geoms have unlike sliding friction, so that it matters how it is mixed.
    uneven: bool,
}

impl<'a> Making<'a> {
    /// Counts what is not as the model says.
    fn lose(&mut self, what: &'static str, count: usize) {
        match self.losses.iter_mut().find(|loss| loss.0 == what) {
            Some(loss) => loss.1 += count,
            None if count > 0 => self.losses.push((what, count)),
            None => {}
        }
    }

    /// True for a geom that is a shape of the scene.
    fn collides(&self, geom: &Geom) -> bool {
        self.filters[&(geom.contype, geom.conaffinity)].is_some()
    }

    /// The first place of a body in the scene.
    fn place_of(&self, body: usize) -> u32 {
        self.places[body].start
    }

    /// All places of a body in the scene.
    fn places_of(&self, body: usize) -> std::ops::Range<u32> {
        self.places[body].clone()
    }

    fn body(&mut self, index: usize, body: &'a Body) {
        let start = self.scene.bodies.len() as u32;
        self.add_body(index, body);
        self.places.push(start..self.scene.bodies.len() as u32);
    }

    fn add_body(&mut self, index: usize, body: &'a Body) {
        let (mass, weight) = self.mass(index, body);
        let named = !body.name.is_empty() && self.names.insert(&body.name);
        let shapes: Vec<ShapeDoc> = body.geoms.iter().filter_map(|geom| self.shape(geom)).collect();
        let doc = BodyDoc {
            name: named.then(|| body.name.clone()),
            kind: match body.kind {
                BodyKind::Fixed => KindDoc::Static,
                BodyKind::Mocap => KindDoc::Kinematic,
                BodyKind::Free | BodyKind::Jointed => KindDoc::Dynamic,
            },
            position: body.placement.position,
            rotation: rotation(body.placement.turn),
            gravity_scale: ((1.0 - body.gravity_compensation) * weight) as f32,
            mass: mass.as_ref().map(self::mass),
            ..BodyDoc::default()
        };
        if body.kind != BodyKind::Fixed {
            self.scene.bodies.push(BodyDoc { shapes, ..doc });
            return;
        }
        for shapes in shapes.chunks(SHAPES_PER_BODY_MAX) {
            self.scene.bodies.push(BodyDoc { shapes: shapes.to_vec(), ..doc.clone() });
        }
        if shapes.is_empty() && self.is_held(index) {
            self.scene.bodies.push(doc);
        }
    }

    /// True when something is joined to a body.
    fn is_held(&self, body: usize) -> bool {
        let model = self.model;
        model.joints.iter().any(|joint| joint.parent == body)
            || model.equalities.iter().any(|e| e.active && (e.a.0 == body || e.b.0 == body))
            || model.ropes.iter().any(|rope| rope.a.body == body || rope.b.body == body)
            || model.excludes.iter().any(|exclude| exclude.bodies.contains(&body))
            || !model.actuators.is_empty()
    }

    /// What a body weighs with the armature of its joint, and its share of gravity.
    fn mass(&mut self, index: usize, body: &Body) -> (Option<Mass>, f64) {
        let moves = matches!(body.kind, BodyKind::Free | BodyKind::Jointed);
        let Some(mut mass) = body.mass.filter(|_| moves) else { return (None, 1.0) };
        let own = mass.mass;
        let parts = self.joints.get(&index).map_or(&[][..], |joint| &joint.parts);
        let rotors = parts.iter().filter(|part| part.armature > 0.0);
        self.lose("joint/armature: as inertia of the body, not of the joint", rotors.clone().count());
        for part in rotors {
            match part.motion {
                Motion::Hinge => mass = with_moment(&mass, part.axis, part.armature),
                Motion::Ball => mass.inertia = mass.inertia.map(|moment| moment + part.armature),
                Motion::Slide => mass.mass += part.armature,
            }
        }
        (Some(possible(mass)), own / mass.mass)
    }

    fn shape(&mut self, geom: &Geom) -> Option<ShapeDoc> {
        let filter = self.filters[&(geom.contype, geom.conaffinity)]?;
        let Placement { position, turn } = geom.placement;
        let geometry = match geom.form {
            Form::HalfSpace => GeometryDoc::HalfSpace,
            Form::Sphere { radius } => GeometryDoc::Sphere { radius: radius as f32 },
            Form::Capsule { half_height, radius } => {
                GeometryDoc::Capsule { half_height: half_height as f32, radius: radius as f32 }
            }
            Form::Box { half_extents } => GeometryDoc::Box { half_extents: half_extents.map(|x| x as f32) },
            Form::Cylinder { half_height, radius } => {
                GeometryDoc::Cylinder { half_height: half_height as f32, radius: radius as f32 }
            }
            Form::Ellipsoid { half_axes } => {
                let name = format!("ellipsoid {:?}", half_axes.map(|x| x as f32));
                self.hull(name, || mesh::ellipsoid(half_axes))
            }
            Form::Hull(index) => {
                let mesh = &self.model.meshes[index];
                self.hull(mesh.name.clone(), || mesh.points.clone())
            }
        };
        Some(ShapeDoc {
            material: Some(self.material(geom)),
            position: position.map(|x| x as f32),
            rotation: rotation(turn),
            filter,
            ..ShapeDoc::new(geometry)
        })
    }

    fn hull(&mut self, name: String, points: impl FnOnce() -> Vec<[f32; 3]>) -> GeometryDoc {
        self.scene.hulls.entry(name.clone()).or_insert_with(|| HullDoc { points: points() });
        GeometryDoc::Hull(name)
    }

    /// The name of the material of a geom's surface. What the geom's condim leaves out is 0: the other geom may
    /// have it, and the larger one counts.
    fn material(&mut self, geom: &Geom) -> String {
        let own =
            |index: usize, condim: i32| if geom.condim < condim { 0.0 } else { geom.friction[index] as f32 };
        let surface = MaterialDoc {
            friction: own(0, 2),
            restitution: geom.restitution as f32,
            friction_mix: if self.uneven { MixDoc::Max } else { MixDoc::Unset },
            spinning: own(1, 4),
            rolling: own(2, 6),
            ..MaterialDoc::default()
        };
        // Other numbers give other names.
        let mut name = format!("friction {} restitution {}", surface.friction, surface.restitution);
        for (word, value) in [("spinning", surface.spinning), ("rolling", surface.rolling)] {
            if value > 0.0 {
                name += &format!(" {word} {value}");
            }
        }
        self.scene.materials.entry(name.clone()).or_insert(surface);
        name
    }
}

/// With a moment of inertia about a unit axis, kg m2.
fn with_moment(mass: &Mass, axis: Vector, moment: f64) -> Mass {
    let mut tensor = mass.tensor();
    for (row, x) in tensor.iter_mut().zip(axis) {
        *row = add(*row, scaled(axis, moment * x));
    }
    Mass::of_tensor(mass.mass, mass.center, tensor)
}

/// With the two lesser moments raised alike until they reach the third.
fn possible(mut mass: Mass) -> Mass {
    let [x, y, z] = mass.inertia;
    for (index, excess) in [x - y - z, y - z - x, z - x - y].into_iter().enumerate() {
        if excess > 0.0 {
            mass.inertia[(index + 1) % 3] += 0.5 * excess;
            mass.inertia[(index + 2) % 3] += 0.5 * excess;
        }
    }
    mass
}

fn mass(mass: &Mass) -> MassDoc {
    MassDoc {
        mass: mass.mass as f32,
        center: mass.center.map(|x| x as f32),
        inertia: mass.inertia.map(|x| x as f32),
        axes: rotation(mass.axes),
    }
}

fn rotation(turn: Turn) -> RotationDoc {
    RotationDoc::Quaternion(turn.to_array().map(|x| x as f32))
}
