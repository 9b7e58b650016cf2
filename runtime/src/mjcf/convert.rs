//! Model to scene document.
//!
//! Mass properties are written out for every body, so that densities play no part. Geoms that collide with nothing
//! are left out: nothing of what they do is lost.

use super::math::{Placement, Turn};
use super::mesh;
use super::model::{Body, BodyKind, Form, Geom, Mass, Model};
use super::warning::{Effect, Warning};
use crate::scene::format::{
    BodyDoc, FilterDoc, GeometryDoc, HullDoc, KindDoc, MassDoc, MaterialDoc, RotationDoc,
    SHAPES_PER_BODY_MAX, SettingsDoc, ShapeDoc,
};
use crate::scene::{Problem, Scene, SceneError};
use std::collections::BTreeMap;

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
    /// Makes a scene of a model whose bodies are fixed, free, or moved from outside.
    ///
    /// # Errors
    /// [`Problem::Invalid`] for a model with joints, equalities in force or ropes, which scenes do not have, and
    /// for more than 32 kinds of contact bits that differ in what they collide with.
    pub fn to_scene(&self) -> Result<Conversion, SceneError> {
        self.check_links()?;
        let mut making = Making { model: self, scene: Scene::default(), filters: self.filters()? };
        making.scene.description.clone_from(&self.name);
        making.scene.gravity = self.options.gravity.map(|x| x as f32);
        let substeps = (self.options.timestep * SUBSTEPS_PER_SECOND).ceil().clamp(1.0, 256.0) as u32;
        making.scene.settings = SettingsDoc {
            dt: Some(self.options.timestep as f32),
            substeps: Some(substeps),
            ..SettingsDoc::default()
        };
        for body in &self.bodies {
            making.body(body);
        }
        let mut warnings = self.warnings.clone();
        warnings.extend(self.losses());
        Ok(Conversion { scene: making.scene, warnings })
    }

    /// Refuses what scenes cannot hold together.
    fn check_links(&self) -> Result<(), SceneError> {
        let equalities = self.equalities.iter().filter(|equality| equality.active).count();
        let found = [("joints", self.joints.len()), ("equalities", equalities), ("ropes", self.ropes.len())];
        let found: Vec<String> = found
            .into_iter()
            .filter(|found| found.1 > 0)
            .map(|(what, count)| format!("{count} {what}"))
            .collect();
        if found.is_empty() {
            return Ok(());
        }
        let found = format!("found {}", found.join(", "));
        let expected = "a model whose bodies are free or fixed: scenes have no joints";
        let problem = Problem::Invalid { found, expected: expected.to_string() };
        Err(SceneError { file: None, at: None, path: String::new(), problem })
    }

    /// What a scene says otherwise than the model.
    fn losses(&self) -> Vec<Warning> {
        let colliding = || self.bodies.iter().flat_map(|body| &body.geoms).filter(|geom| self.collides(geom));
        let first = colliding().next().map_or([0.0; 3], |geom| geom.friction);
        let count = |is: &dyn Fn(&Geom) -> bool| colliding().filter(|geom| is(geom)).count();
        let losses = [
            (
                "geom/friction: of two geoms the geometric mean, not the larger",
                count(&|g| g.friction[0] != first[0]),
            ),
            ("geom/condim other than 3", count(&|g| g.condim != 3)),
            ("ellipsoid as a hull of 58 points", count(&|g| matches!(g.form, Form::Ellipsoid { .. }))),
            ("contact/exclude", self.excludes.len()),
            ("actuator", self.actuators.len()),
        ];
        let found = losses.into_iter().filter(|loss| loss.1 > 0);
        let warning = |(what, count): (&str, usize)| Warning {
            effect: Effect::Motion,
            what: what.to_string(),
            count,
            file: None,
            at: None,
        };
        found.map(warning).collect()
    }

    /// True for a geom that collides with some geom of the model, were it in reach.
    fn collides(&self, geom: &Geom) -> bool {
        geom.contype != 0 || geom.conaffinity != 0
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

struct Making<'a> {
    model: &'a Model,
    scene: Scene,
    filters: BTreeMap<(u32, u32), Option<FilterDoc>>,
}

impl Making<'_> {
    fn body(&mut self, body: &Body) {
        let shapes: Vec<ShapeDoc> = body.geoms.iter().filter_map(|geom| self.shape(geom)).collect();
        let doc = BodyDoc {
            kind: match body.kind {
                BodyKind::Fixed => KindDoc::Static,
                BodyKind::Mocap => KindDoc::Kinematic,
                BodyKind::Free | BodyKind::Jointed => KindDoc::Dynamic,
            },
            position: body.placement.position,
            rotation: rotation(body.placement.turn),
            gravity_scale: (1.0 - body.gravity_compensation) as f32,
            mass: body.mass.filter(|_| body.kind == BodyKind::Free).as_ref().map(mass),
            ..BodyDoc::default()
        };
        if body.kind != BodyKind::Fixed {
            self.scene.bodies.push(BodyDoc { shapes, ..doc });
            return;
        }
        for shapes in shapes.chunks(SHAPES_PER_BODY_MAX) {
            self.scene.bodies.push(BodyDoc { shapes: shapes.to_vec(), ..doc.clone() });
        }
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

    /// The name of the material of a geom's surface.
    fn material(&mut self, geom: &Geom) -> String {
        let surface = MaterialDoc {
            friction: geom.friction[0] as f32,
            restitution: geom.restitution as f32,
            ..MaterialDoc::default()
        };
        // Other numbers give other names.
        let name = format!("friction {} restitution {}", surface.friction, surface.restitution);
        self.scene.materials.entry(name.clone()).or_insert(surface);
        name
    }
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
