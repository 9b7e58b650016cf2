//! What refers to bodies, sites and joints by name: `<contact>`, `<equality>`, `<tendon>` and `<actuator>`.
//!
//! Of an attached model only what refers to attached things alone comes along, as in MuJoCo.

use super::math::{Placement, Turn, length, sub};
use super::model::{Actuator, Control, Equality, Exclude, Point, Rope, Transmission};
use super::names::{Kind, Thing, Unresolved};
use super::settings::ACTUATORS;
use super::tree::shortened;
use super::values::Values;
use super::walk::Walk;
use super::warning::Effect;
use crate::scene::SceneError;

/// Most links of each kind: more than bodies.
const LINKS_MAX: usize = 1 << 20;

/// A body and a frame in it.
type Framed = (usize, Placement);

/// Attributes of one element, and whether its model is an attached one.
struct Link<'a> {
    values: Values<'a>,
    attached: bool,
}

impl<'a> Walk<'a> {
    /// Reads all links of a source.
    pub(super) fn links(&mut self, source: usize, attached: bool) -> Result<(), SceneError> {
        let library = self.library;
        let tree = &library.sources[source].tree;
        for section in ["contact", "equality", "tendon", "actuator"] {
            for outer in tree.with_tag(0, section) {
                for &element in &tree.elements[outer].children {
                    self.visit(&self.values(&self.nowhere(source), element, None)?)?;
                    let tag = tree.elements[element].tag.as_str();
                    let kind = match (section, tag) {
                        ("contact", "exclude") => "exclude",
                        ("equality", "connect" | "weld") => "equality",
                        ("tendon", "spatial") => "tendon",
                        ("actuator", _) if ACTUATORS.contains(&tag) => "actuator",
                        _ => continue,
                    };
                    let values = self.values(&self.nowhere(source), element, Some(kind))?;
                    let link = Link { values, attached };
                    match kind {
                        "exclude" => self.exclude(&link)?,
                        "equality" => self.equality(&link)?,
                        "tendon" => self.tendon(&link, source)?,
                        _ => self.actuator(&link, source)?,
                    }
                }
            }
        }
        Ok(())
    }

    /// What attributes of `link` refer to, for each combination of copies.
    fn resolve(&mut self, link: &Link<'_>, names: &[(Kind, &str)]) -> Result<Vec<Vec<Thing>>, SceneError> {
        let values = &link.values;
        let mut references = Vec::new();
        // The world has no name in the files.
        let mut places = Vec::new();
        for &(kind, attribute) in names {
            let Some(name) = values.own().text(attribute) else {
                return Err(values.error(attribute, format!("no `{attribute}`, expected a name")));
            };
            let is_world = kind == Kind::Body && name == "world";
            places.push((!is_world).then_some(references.len()));
            if !is_world {
                references.push((kind, name));
            }
        }
        let total = |model: &super::model::Model| {
            model.excludes.len() + model.equalities.len() + model.ropes.len() + model.actuators.len()
        };
        match self.names.resolve(&references, &mut self.work) {
            Ok(all) if total(&self.model) + all.len() <= LINKS_MAX => {
                let thing =
                    |things: &[Thing], place: &Option<usize>| place.map_or(Thing::Body(0), |i| things[i]);
                let with_world =
                    |things: Vec<Thing>| places.iter().map(|place| thing(&things, place)).collect();
                Ok(all.into_iter().map(with_world).collect())
            }
            Ok(_) | Err(Unresolved::TooMany) => {
                Err(Self::too_large(values, "references to copies", LINKS_MAX as u64))
            }
            Err(Unresolved::Unknown(_)) if link.attached => Ok(Vec::new()),
            Err(Unresolved::Unknown(index)) => {
                let name = references[index].1;
                let attribute =
                    names.iter().find(|(_, attribute)| values.own().text(attribute) == Some(name));
                let attribute = attribute.map_or("", |found| found.1);
                let message = format!("nothing is named {:?}, expected something that is", shortened(name));
                Err(values.error(attribute, message))
            }
        }
    }

    /// The rigid body of a `<body>`, and its frame in it.
    fn rigid_of(&self, thing: Thing) -> Framed {
        let Thing::Body(part) = thing else { return (0, Placement::IDENTITY) };
        (self.parts[part].rigid, self.parts[part].frame)
    }

    fn site_of(&self, thing: Thing) -> Framed {
        let Thing::Site(site) = thing else { return (0, Placement::IDENTITY) };
        self.sites[site]
    }

    fn point_of(&self, thing: Thing) -> Point {
        let (body, placement) = self.site_of(thing);
        Point { body, position: placement.position }
    }

    /// A place in a body, in the world.
    fn in_world(&self, (body, placement): Framed) -> Placement {
        self.model.bodies[body].placement.after(&placement)
    }

    fn exclude(&mut self, link: &Link<'_>) -> Result<(), SceneError> {
        for things in self.resolve(link, &[(Kind::Body, "body1"), (Kind::Body, "body2")])? {
            let part = |thing| if let Thing::Body(part) = thing { part } else { 0 };
            let parts = [part(things[0]), part(things[1])];
            let bodies = parts.map(|part| self.parts[part].rigid);
            if bodies[0] != bodies[1] {
                self.model.excludes.push(Exclude { bodies, parts });
            }
        }
        Ok(())
    }

    fn equality(&mut self, link: &Link<'_>) -> Result<(), SceneError> {
        let values = link.values;
        let weld = values.tree.elements[values.element].tag == "weld";
        let active = values.truth("active")?.unwrap_or(true);
        let name = self.full_name(values.name()?);
        let by_sites = values.own().has("site1") || values.own().has("site2");
        let names = match (by_sites, values.own().has("body2")) {
            (true, _) => &[(Kind::Site, "site1"), (Kind::Site, "site2")][..],
            (_, true) => &[(Kind::Body, "body1"), (Kind::Body, "body2")],
            _ => &[(Kind::Body, "body1")],
        };
        for things in self.resolve(link, names)? {
            let (a, b) = if by_sites {
                (self.site_of(things[0]), self.site_of(things[1]))
            } else {
                let second = things.get(1).copied().unwrap_or(Thing::Body(0));
                self.frames(&values, weld, [things[0], second])?
            };
            if a.0 != b.0 {
                self.model.equalities.push(Equality { name: name.clone(), weld, a, b, active });
            }
        }
        Ok(())
    }

    /// The frames of a constraint between two bodies.
    fn frames(
        &self,
        values: &Values<'_>,
        weld: bool,
        things: [Thing; 2],
    ) -> Result<(Framed, Framed), SceneError> {
        let [first, second] = things.map(|thing| self.rigid_of(thing));
        let anchor = values.own().numbers::<3>("anchor")?;
        let at = |position| Placement::new(position, Turn::IDENTITY);
        // The other frame is where the first is in the beginning.
        let meet = |frame: Framed, other: usize| {
            (other, self.model.bodies[other].placement.inverse().after(&self.in_world(frame)))
        };
        if !weld {
            let Some(anchor) = anchor else {
                return Err(values.error("anchor", "no `anchor`, expected a point of the first body"));
            };
            let a = (first.0, first.1.after(&at(anchor)));
            return Ok((a, meet(a, second.0)));
        }
        let b = (second.0, second.1.after(&at(anchor.unwrap_or([0.0; 3]))));
        let pose = values.own().numbers::<7>("relpose")?;
        let given = pose.and_then(|[x, y, z, rotation @ ..]| Some(([x, y, z], Turn::from_wxyz(rotation)?)));
        Ok(match given {
            // The pose of the second body in the first.
            Some((position, turn)) => {
                let second = Placement::new(position, turn).after(&at(anchor.unwrap_or([0.0; 3])));
                ((first.0, first.1.after(&second)), b)
            }
            None => (meet(b, first.0), b),
        })
    }

    fn tendon(&mut self, link: &Link<'_>, source: usize) -> Result<(), SceneError> {
        let values = link.values;
        let ends = &values.tree.elements[values.element].children;
        let sites = ends.iter().filter(|&&end| values.tree.elements[end].tag == "site");
        let sites: Vec<&str> =
            sites.map(|&end| values.tree.elements[end].text("site").unwrap_or("")).collect();
        let (&[a, b], 2) = (&sites[..], ends.len()) else {
            // Told of with the words of its file.
            return Ok(());
        };
        let end = |index: usize| Link { values: Values { element: ends[index], ..values }, ..*link };
        let references = [(Kind::Site, a), (Kind::Site, b)];
        let all = match self.names.resolve(&references, &mut self.work) {
            Ok(all) => all,
            Err(Unresolved::Unknown(_)) if link.attached => return Ok(()),
            // Says which end it is.
            Err(Unresolved::Unknown(index)) => self.resolve(&end(index), &[(Kind::Site, "site")])?,
            Err(Unresolved::TooMany) => {
                return Err(Self::too_large(&values, "references to copies", LINKS_MAX as u64));
            }
        };
        let compiler = &self.library.sources[source].compiler;
        let range = values.limits(["limited", "range"], compiler.autolimits)?;
        let stiffness = self.first(&values, "stiffness")?;
        let damping = self.first(&values, "damping")?;
        let friction_loss = values.positive("frictionloss")?.unwrap_or(0.0);
        let rest = values.list("springlength", 1, 2)?;
        let name = self.full_name(values.name()?);
        for things in all {
            let now = length(sub(
                self.in_world(self.site_of(things[0])).position,
                self.in_world(self.site_of(things[1])).position,
            ));
            let rest = rest.as_ref().map_or([now; 2], |rest| [rest[0], rest[rest.len() - 1]]);
            let rest = if rest[0] < 0.0 { [now; 2] } else { rest };
            let (a, b) = (self.point_of(things[0]), self.point_of(things[1]));
            let name = name.clone();
            let rope = Rope { name, a, b, range, stiffness, damping, rest, friction_loss };
            let acts = range.is_some() || stiffness + damping + friction_loss > 0.0;
            if acts && a.body != b.body {
                self.model.ropes.push(rope);
            }
        }
        Ok(())
    }

    fn actuator(&mut self, link: &Link<'_>, source: usize) -> Result<(), SceneError> {
        let values = link.values;
        let by_joint = values.own().has("joint");
        let names = if by_joint {
            &[(Kind::Joint, "joint")][..]
        } else if values.own().has("cranksite") {
            &[(Kind::Site, "cranksite"), (Kind::Site, "slidersite")]
        } else {
            // Its attribute was told of.
            return Ok(());
        };
        let control = self.control(&link.values, source)?;
        let gear = values.list("gear", 1, 6)?.unwrap_or(vec![1.0]);
        let automatic = self.library.sources[source].compiler.autolimits;
        let control_range = values.limits(["ctrllimited", "ctrlrange"], automatic)?;
        let force_range = values.limits(["forcelimited", "forcerange"], automatic)?;
        let rod = values.positive("cranklength")?.unwrap_or(0.0);
        let name = self.full_name(values.name()?);
        for things in self.resolve(link, names)? {
            let transmission = match things[..] {
                [Thing::Joint(joint, part)] if self.moves_along(joint, part) => {
                    Transmission::Joint(joint, part)
                }
                [Thing::Site(_), Thing::Site(_)] => {
                    let (body, slider) = self.site_of(things[1]);
                    Transmission::SliderCrank { crank: self.point_of(things[0]), body, slider, rod }
                }
                _ => {
                    let spot = values.tree.elements[values.element].spot;
                    self.warn(Effect::Motion, "actuator of a free or ball joint", spot);
                    continue;
                }
            };
            let name = name.clone();
            let gear = gear[0];
            let actuator = Actuator { name, control, transmission, gear, control_range, force_range };
            self.model.actuators.push(actuator);
        }
        Ok(())
    }

    /// True for a hinge or a slide.
    fn moves_along(&self, joint: usize, part: usize) -> bool {
        self.model.joints[joint].parts[part].motion != super::model::Motion::Ball
    }

    fn control(&self, values: &Values<'_>, source: usize) -> Result<Control, SceneError> {
        let tag = values.tree.elements[values.element].tag.as_str();
        let place = self.nowhere(source);
        let own = self.values(&place, values.element, Some(tag))?;
        Ok(match tag {
            "position" => Control::Position {
                kp: own.positive("kp")?.unwrap_or(1.0),
                kv: own.positive("kv")?.unwrap_or(0.0),
            },
            "velocity" => Control::Velocity { kv: own.positive("kv")?.unwrap_or(1.0) },
            _ => Control::Motor,
        })
    }
}
