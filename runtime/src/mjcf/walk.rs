//! The kinematic tree: every `<body>` with all copies, in document order, put together into rigid bodies.

use super::library::{Library, Source};
use super::math::Placement;
use super::model::{Body, BodyKind, Mass, Model};
use super::names::{Kind, Level, Names, Thing, WORK_MAX};
use super::settings::Classes;
use super::text::DEPTH_MAX;
use super::tree::{Spot, shortened};
use super::values::Values;
use super::warning::{Effect, Warning, Warnings};
use crate::scene::{Problem, SceneError};
use std::collections::{BTreeMap, BTreeSet};

/// Most elements within each other, over attached models.
const WALK_DEPTH_MAX: usize = DEPTH_MAX + 50;
/// Elements that are looked at, copies included and some twice, for each body and each geom that is allowed.
const VISITS_EACH: u64 = 16;
/// Fewest and most elements that are looked at, whatever is allowed.
const VISITS: [u64; 2] = [1 << 12, 1 << 22];
/// Most replicates within each other.
const LEVELS_MAX: usize = 8;
/// Most characters of a separator, and of a prefix.
const AFFIX_MAX: usize = 64;

/// Where an element is.
#[derive(Clone)]
pub(super) struct Place {
    /// The file's index among the sources.
    pub source: usize,
    /// The element `<body>` around it.
    pub part: usize,
    /// The frame around it, in the rigid body's.
    pub frame: Placement,
    /// The default class of what names none.
    pub class: String,
    /// Whether it is within a `<body>` of its own, so that there may be joints.
    pub in_body: bool,
}

/// An element `<body>`.
pub(super) struct Part {
    /// The rigid body that it belongs to.
    pub rigid: usize,
    /// Its frame in that one's.
    pub frame: Placement,
    /// Masses of its geoms, in the rigid body's frame.
    pub masses: Vec<Mass>,
    /// What `<inertial>` says.
    pub inertial: Option<Mass>,
}

/// What is being put together.
pub(super) struct Walk<'a> {
    pub library: &'a Library,
    pub model: Model,
    /// All elements `<body>`; the first is the world.
    pub parts: Vec<Part>,
    /// Masses of rigid bodies' parts.
    pub masses: Vec<Vec<Mass>>,
    /// Source and element of each rigid body.
    pub origins: Vec<(usize, usize)>,
    /// Body and frame of each site.
    pub sites: Vec<(usize, Placement)>,
    /// Meshes that are loaded, by source and element.
    pub meshes: BTreeMap<(usize, usize), usize>,
    /// Points of all meshes so far.
    pub mesh_points: usize,
    /// Names of the model that is being read.
    pub names: Names,
    /// Copies that are being read, the outermost first.
    levels: Vec<Level>,
    /// What comes before and after names.
    affixes: (String, String),
    visits: u64,
    visits_max: u64,
    depth: usize,
    pub geoms: usize,
    /// Choices that references may still look at.
    pub work: usize,
    warnings: Warnings,
    warned: BTreeSet<(String, Spot)>,
    /// Names of meshes that are loaded.
    pub mesh_names: BTreeSet<String>,
}

/// Puts a model together.
pub(super) fn walk(library: &Library) -> Result<Model, SceneError> {
    let source = &library.sources[0];
    let name = source.tree.elements[0].text("model").unwrap_or_default();
    let world = Body {
        name: String::new(),
        kind: BodyKind::Fixed,
        placement: Placement::IDENTITY,
        parent: 0,
        mass: None,
        gravity_compensation: 0.0,
        geoms: Vec::new(),
        parts: 1,
    };
    let model = Model {
        name: shortened(name),
        options: source.options.clone(),
        bodies: vec![world],
        ..Model::default()
    };
    let limits = &library.limits;
    let visits_max = limits.bodies.saturating_add(limits.shapes).saturating_mul(VISITS_EACH);
    let mut walk = Walk {
        library,
        model,
        parts: vec![Part { rigid: 0, frame: Placement::IDENTITY, masses: Vec::new(), inertial: None }],
        masses: vec![Vec::new()],
        origins: vec![(0, 0)],
        sites: Vec::new(),
        meshes: BTreeMap::new(),
        mesh_points: 0,
        names: Names::default(),
        levels: Vec::new(),
        affixes: (String::new(), String::new()),
        visits: 0,
        visits_max: visits_max.clamp(VISITS[0], VISITS[1]),
        depth: 0,
        geoms: 0,
        work: WORK_MAX,
        warnings: library.warnings.clone(),
        warned: BTreeSet::new(),
        mesh_names: BTreeSet::new(),
    };
    walk.world(&walk.outermost(0, 0, Placement::IDENTITY))?;
    walk.links(0, false)?;
    walk.weigh()?;
    walk.apply_flags();
    walk.model.warnings = walk.warnings.list;
    Ok(walk.model)
}

impl<'a> Walk<'a> {
    pub(super) fn source(&self, place: &Place) -> &'a Source {
        let library = self.library;
        &library.sources[place.source]
    }

    /// The attributes of an element with those of its class for `kind`, or without a class.
    pub(super) fn values(
        &self,
        place: &Place,
        element: usize,
        kind: Option<&str>,
    ) -> Result<Values<'a>, SceneError> {
        let source = self.source(place);
        let values = Values { files: &self.library.files, tree: &source.tree, element, defaults: None };
        let Some(kind) = kind else { return Ok(values) };
        let class = source.classes.of(values, &place.class, "class")?;
        Ok(Values { defaults: source.classes.defaults(&class, kind), ..values })
    }

    /// Adds a warning, once for each place in the files.
    pub(super) fn warn(&mut self, effect: Effect, what: impl ToString, spot: Spot) {
        if !self.warned.insert((what.to_string(), spot)) {
            return;
        }
        let file = self.library.files.shown(spot.file);
        self.warnings.add(Warning { effect, what: what.to_string(), count: 1, file, at: Some(spot.at) });
    }

    pub(super) fn too_large(values: &Values<'_>, what: &'static str, limit: u64) -> SceneError {
        let problem = Problem::TooLarge { what, asked: limit + 1, limit };
        values.files.error(values.tree, values.element, None, problem)
    }

    /// A name with all prefixes and suffixes; nothing stays nothing.
    pub(super) fn full_name(&self, name: &str) -> String {
        let (prefix, suffix) = &self.affixes;
        if name.is_empty() { String::new() } else { format!("{prefix}{name}{suffix}") }
    }

    /// Makes a thing known by its element's name.
    pub(super) fn name(&mut self, kind: Kind, values: &Values<'_>, thing: Thing) -> Result<(), SceneError> {
        let name = values.name()?;
        if name.is_empty() || self.names.add(kind, name, &self.levels, thing) {
            return Ok(());
        }
        let message =
            format!("the name {:?} is used twice, expected each once", shortened(&self.full_name(name)));
        Err(values.error("name", message))
    }

    fn outermost(&self, source: usize, part: usize, frame: Placement) -> Place {
        Place { source, part, frame, class: Classes::outermost(), in_body: false }
    }

    /// All `<worldbody>` of a source.
    fn world(&mut self, place: &Place) -> Result<(), SceneError> {
        let tree = &self.source(place).tree;
        tree.with_tag(0, "worldbody").try_for_each(|section| self.children(place, section))
    }

    fn children(&mut self, place: &Place, element: usize) -> Result<(), SceneError> {
        let values = self.values(place, element, None)?;
        if self.depth >= WALK_DEPTH_MAX {
            let message = format!("elements nested more than {WALK_DEPTH_MAX} deep, expected fewer");
            return Err(values.error("", message));
        }
        self.depth += 1;
        for &child in &values.tree.elements[element].children {
            self.visit(&values)?;
            let tag = values.tree.elements[child].tag.as_str();
            match tag {
                "body" => self.body(place, child)?,
                "frame" => self.frame(place, child)?,
                "replicate" => self.replicate(place, child)?,
                "attach" => self.attach(place, child)?,
                "geom" => self.geom(place, child)?,
                "site" => self.site(place, child)?,
                "joint" | "freejoint" | "inertial" if !place.in_body => {
                    let values = self.values(place, child, None)?;
                    return Err(
                        values.error("", format!("a `{tag}` outside of a body, expected it within one"))
                    );
                }
                // Read with their body, or told of already.
                _ => {}
            }
        }
        self.depth -= 1;
        Ok(())
    }

    pub(super) fn visit(&mut self, values: &Values<'_>) -> Result<(), SceneError> {
        self.visits += 1;
        if self.visits > self.visits_max {
            return Err(Self::too_large(values, "elements and copies", self.visits_max));
        }
        Ok(())
    }

    fn frame(&mut self, place: &Place, element: usize) -> Result<(), SceneError> {
        let values = self.values(place, element, None)?;
        let source = self.source(place);
        let inner = Place {
            frame: place.frame.after(&source.compiler.placement(values)?),
            class: source.classes.of(values, &place.class, "childclass")?,
            ..place.clone()
        };
        self.children(&inner, element)
    }

    fn replicate(&mut self, place: &Place, element: usize) -> Result<(), SceneError> {
        let values = self.values(place, element, None)?;
        let source = self.source(place);
        let count = match values.integer("count")? {
            Some(count) if count >= 0 => count as usize,
            Some(count) => return Err(values.error("count", format!("found {count}, expected 0 or more"))),
            None => return Err(values.error("count", "no `count`, expected the number of copies")),
        };
        if count as u64 > self.visits_max {
            return Err(Self::too_large(&values, "copies", self.visits_max));
        }
        if self.levels.len() >= LEVELS_MAX {
            return Err(
                values.error("count", format!("expected at most {LEVELS_MAX} replicates within each other"))
            );
        }
        let offset = values.numbers::<3>("offset")?.unwrap_or([0.0; 3]);
        let euler = values.numbers::<3>("euler")?.unwrap_or([0.0; 3]);
        let separator = affix(&values, "sep")?;
        let class = source.classes.of(values, &place.class, "childclass")?;
        let digits = count.to_string().len();
        let mut copy = Placement::IDENTITY;
        for index in 0..count {
            self.visit(&values)?;
            // The angle is a multiple, so that rounding does not add up.
            copy.turn = source.compiler.euler(euler.map(|angle| angle * index as f64));
            let inner = Place {
                frame: place.frame.after(&copy),
                class: class.clone(),
                in_body: false,
                ..place.clone()
            };
            let suffix = format!("{separator}{index:0digits$}");
            let outer_suffix = self.affixes.1.clone();
            self.affixes.1 = format!("{suffix}{outer_suffix}");
            self.levels.push(Level { copied: (element, index), suffix });
            self.children(&inner, element)?;
            self.levels.pop();
            self.affixes.1 = outer_suffix;
            copy.position = copy.transform(offset);
        }
        Ok(())
    }

    fn attach(&mut self, place: &Place, element: usize) -> Result<(), SceneError> {
        let values = self.values(place, element, None)?;
        let prefix = affix(&values, "prefix")?;
        let source = match values.text("model") {
            None => place.source,
            Some(name) => *self.source(place).models.get(name).ok_or_else(|| {
                let message =
                    format!("no <model> of <asset> is named {:?}, expected one that is", shortened(name));
                values.error("model", message)
            })?,
        };
        let mut inner = self.outermost(source, place.part, place.frame);
        let root = self.root(&values, &mut inner)?;
        let outer_prefix = self.affixes.0.clone();
        if outer_prefix.len() > 16 * AFFIX_MAX {
            return Err(values.error("prefix", "models attached within each other too deep"));
        }
        self.affixes.0 += prefix;
        let levels = std::mem::take(&mut self.levels);
        let names = std::mem::take(&mut self.names);
        match root {
            None => self.world(&inner)?,
            Some((root, "body")) => self.body(&inner, root)?,
            Some((root, _)) => self.frame(&inner, root)?,
        }
        self.links(source, true)?;
        let attached = std::mem::replace(&mut self.names, names);
        self.levels = levels;
        self.affixes.0 = outer_prefix;
        self.names.attach(attached, prefix, &self.levels).map_err(|name| {
            values
                .error("prefix", format!("the name {:?} is used twice, expected each once", shortened(&name)))
        })
    }

    /// What `<attach>` names: an element of `inner`'s source and its tag, or all of it. Sets the class.
    fn root(
        &self,
        values: &Values<'_>,
        inner: &mut Place,
    ) -> Result<Option<(usize, &'static str)>, SceneError> {
        let named = ["body", "frame"].into_iter().find_map(|tag| Some((tag, values.text(tag)?)));
        let Some((tag, name)) = named else {
            if values.has("model") {
                return Ok(None);
            }
            return Err(
                values.error("body", "neither `model` nor `body` nor `frame`, expected what to attach")
            );
        };
        let tree = &self.source(inner).tree;
        let Some(&root) = self.source(inner).named.get(&(tag, name.to_string())) else {
            let message =
                format!("no {tag} of the model is named {:?}, expected one that is", shortened(name));
            return Err(values.error(tag, message));
        };
        let mut up = tree.elements[root].parent;
        while tree.elements[up].parent != up {
            if let Some(class) = tree.elements[up].text("childclass") {
                inner.class = class.to_string();
                break;
            }
            up = tree.elements[up].parent;
        }
        Ok(Some((root, tag)))
    }

    fn site(&mut self, place: &Place, element: usize) -> Result<(), SceneError> {
        let values = self.values(place, element, Some("site"))?;
        let placement = match super::geom::ends(&values)? {
            Some((placement, _)) => placement,
            None => self.source(place).compiler.placement(values)?,
        };
        let rigid = self.parts[place.part].rigid;
        self.sites.push((rigid, place.frame.after(&placement)));
        self.name(Kind::Site, &values, Thing::Site(self.sites.len() - 1))
    }

    fn body(&mut self, place: &Place, element: usize) -> Result<(), SceneError> {
        let values = self.values(place, element, None)?;
        let source = self.source(place);
        let own = place.frame.after(&source.compiler.placement(values)?);
        let joints = self.inner(place, element, &["joint", "freejoint"])?;
        let mocap = values.truth("mocap")?.unwrap_or(false);
        let compensation = values.number("gravcomp")?.unwrap_or(0.0);
        let outer = self.parts[place.part].rigid;
        let (rigid, frame) = if joints.is_empty() && !mocap {
            (outer, own)
        } else {
            if mocap && (place.part != 0 || !joints.is_empty()) {
                let message = "a mocap body within a body or with joints, expected neither";
                return Err(values.error("mocap", message));
            }
            (self.rigid(&values, place, own)?, Placement::IDENTITY)
        };
        let part = self.parts.len();
        if part >= self.library.limits.bodies as usize {
            return Err(Self::too_large(&values, "bodies", self.library.limits.bodies));
        }
        self.parts.push(Part { rigid, frame, masses: Vec::new(), inertial: None });
        self.model.bodies[rigid].parts += 1;
        self.name(Kind::Body, &values, Thing::Body(part))?;
        if rigid != outer {
            let body = &mut self.model.bodies[rigid];
            body.kind = BodyKind::Mocap;
            body.gravity_compensation = compensation;
        } else if compensation != self.model.bodies[rigid].gravity_compensation && rigid != 0 {
            let spot = Spot {
                file: values.tree.elements[element].spot.file,
                at: values.tree.elements[element].spot.at,
            };
            self.warn(Effect::Motion, "body/gravcomp of a part of a rigid body", spot);
        }
        let inner = Place {
            part,
            frame,
            class: source.classes.of(values, &place.class, "childclass")?,
            in_body: true,
            ..place.clone()
        };
        self.joints(&inner, place.part, &joints)?;
        self.inertial(&inner, element)?;
        self.children(&inner, element)?;
        self.weigh_part(&values, &inner)
    }

    /// Adds a rigid body at `own` in the frame of the rigid body around it.
    fn rigid(&mut self, values: &Values<'_>, place: &Place, own: Placement) -> Result<usize, SceneError> {
        let rigid = self.model.bodies.len();
        let outer = self.parts[place.part].rigid;
        self.origins.push((place.source, values.element));
        self.model.bodies.push(Body {
            name: self.full_name(values.name()?),
            kind: BodyKind::Mocap,
            placement: self.model.bodies[outer].placement.after(&own),
            parent: outer,
            mass: None,
            gravity_compensation: 0.0,
            geoms: Vec::new(),
            parts: 0,
        });
        self.masses.push(Vec::new());
        Ok(rigid)
    }

    /// Elements with one of the tags in a body, also in frames of it, each with its frame in the body's and its
    /// class.
    pub(super) fn inner(
        &mut self,
        place: &Place,
        body: usize,
        tags: &[&str],
    ) -> Result<Vec<(usize, Placement, String)>, SceneError> {
        let source = self.source(place);
        let values = self.values(place, body, None)?;
        let class = source.classes.of(values, &place.class, "childclass")?;
        let mut found = Vec::new();
        let mut stack = vec![(body, Placement::IDENTITY, class)];
        while let Some((outer, frame, class)) = stack.pop() {
            for &child in &source.tree.elements[outer].children {
                self.visit(&values)?;
                let tag = source.tree.elements[child].tag.as_str();
                if tags.contains(&tag) {
                    found.push((child, frame, class.clone()));
                } else if tag == "frame" {
                    let values = self.values(place, child, None)?;
                    let frame = frame.after(&source.compiler.placement(values)?);
                    let class = source.classes.of(values, &class, "childclass")?;
                    stack.push((child, frame, class));
                }
            }
        }
        // In document order.
        found.sort_by_key(|found| found.0);
        Ok(found)
    }

    /// Takes away what flags of `<option>` disable.
    fn apply_flags(&mut self) {
        let options = self.model.options.clone();
        if !options.enables("contact") {
            for geom in self.model.bodies.iter_mut().flat_map(|body| &mut body.geoms) {
                (geom.contype, geom.conaffinity) = (0, 0);
            }
        }
        for joint in &mut self.model.joints {
            joint.collide |= !options.enables("filterparent");
            for part in &mut joint.parts {
                part.range = part.range.filter(|_| options.enables("limit"));
                part.stiffness *= f64::from(u8::from(options.enables("spring")));
                part.damping *= f64::from(u8::from(options.enables("damper")));
                part.friction_loss *= f64::from(u8::from(options.enables("frictionloss")));
            }
        }
        for rope in &mut self.model.ropes {
            rope.range = rope.range.filter(|_| options.enables("limit"));
            rope.stiffness *= f64::from(u8::from(options.enables("spring")));
            rope.damping *= f64::from(u8::from(options.enables("damper")));
            rope.friction_loss *= f64::from(u8::from(options.enables("frictionloss")));
        }
        if !options.enables("equality") {
            self.model.equalities.clear();
        }
        if !options.enables("actuation") {
            self.model.actuators.clear();
        }
    }
}

/// A short text that is added to names.
fn affix<'a>(values: &Values<'a>, name: &str) -> Result<&'a str, SceneError> {
    let text = values.text(name).unwrap_or_default();
    if text.len() <= AFFIX_MAX {
        return Ok(text);
    }
    Err(values.error(name, format!("found {} bytes, expected at most {AFFIX_MAX}", text.len())))
}
