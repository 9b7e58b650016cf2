//! `<joint>` and `<freejoint>`: what a body may do with respect to the one around it.

use super::geom::spot;
use super::math::{Placement, direction};
use super::model::{BodyKind, Joint, JointPart, Motion};
use super::names::{Kind, Thing};
use super::settings::Classes;
use super::values::Values;
use super::walk::{Place, Walk};
use super::warning::Effect;
use crate::scene::SceneError;

/// Degrees of freedom of a body.
const FREEDOMS_MAX: usize = 6;
const TYPES: [&str; 4] = ["hinge", "slide", "ball", "free"];

impl<'a> Walk<'a> {
    /// Reads the joints of a body, each with its frame in the body's and its class. `outer` is the `<body>`
    /// around it.
    pub(super) fn joints(
        &mut self,
        place: &Place,
        outer: usize,
        joints: &[(usize, Placement, String)],
    ) -> Result<(), SceneError> {
        let child = self.parts[place.part].rigid;
        let parent = self.parts[outer].rigid;
        let index = self.model.joints.len();
        let mut parts: Vec<JointPart> = Vec::new();
        let mut freedoms = 0;
        for (element, frame, class) in joints {
            let bare = self.values(place, *element, None)?;
            let is_free = bare.tree.elements[*element].tag == "freejoint";
            // A free joint of its own tag has no defaults.
            let values = if is_free { bare } else { self.classed(place, *element, class)? };
            let kind = if is_free { 3 } else { values.keyword("type", &TYPES)?.unwrap_or(0) };
            if kind == 3 {
                if outer != 0 || joints.len() > 1 {
                    let message = "a free joint within a body or beside another joint, expected it alone on a body \
                                   of the world";
                    return Err(values.error("type", message));
                }
                self.check_free(&values)?;
                self.model.bodies[child].kind = BodyKind::Free;
                return self.name(Kind::Joint, &values, Thing::FreeJoint);
            }
            freedoms += [1, 1, 3][kind];
            if freedoms > FREEDOMS_MAX {
                let message =
                    format!("more than {FREEDOMS_MAX} degrees of freedom of a body, expected fewer");
                return Err(values.error("type", message));
            }
            let motion = [Motion::Hinge, Motion::Slide, Motion::Ball][kind];
            let part = self.part(place, &values, motion, frame)?;
            self.name(Kind::Joint, &values, Thing::Joint(index, parts.len()))?;
            parts.push(part);
        }
        if !parts.is_empty() {
            self.model.bodies[child].kind = BodyKind::Jointed;
            self.model.joints.push(Joint { parent, child, parts, collide: parent == 0 });
        }
        Ok(())
    }

    /// The attributes of an element in a frame of `place`, whose class is `class` unless it has its own.
    fn classed(&self, place: &Place, element: usize, class: &str) -> Result<Values<'a>, SceneError> {
        self.values(&Place { class: class.to_string(), ..place.clone() }, element, Some("joint"))
    }

    /// Springs and friction of a free joint hold a body in the air: nothing here does.
    fn check_free(&mut self, values: &Values<'_>) -> Result<(), SceneError> {
        for name in ["stiffness", "damping", "frictionloss", "armature"] {
            let list = values.list(name, 1, 3)?.unwrap_or_default();
            if values.tree.elements[values.element].tag == "joint" && list.iter().any(|&x| x != 0.0) {
                self.warn(Effect::Motion, format!("joint/{name} of a free joint"), spot(values));
            }
        }
        Ok(())
    }

    fn part(
        &mut self,
        place: &Place,
        values: &Values<'_>,
        motion: Motion,
        frame: &Placement,
    ) -> Result<JointPart, SceneError> {
        let compiler = &self.source(place).compiler;
        let unit = if motion == Motion::Slide { 1.0 } else { compiler.unit };
        let axis = values.numbers::<3>("axis")?.filter(|_| motion != Motion::Ball).unwrap_or([0.0, 0.0, 1.0]);
        let axis =
            direction(axis).ok_or_else(|| values.error("axis", "nearly zero, expected a direction"))?;
        let reference = values.number("ref")?.unwrap_or(0.0) * unit;
        let rest = values.number("springref")?.unwrap_or(0.0) * unit;
        let range = values.limits(["limited", "range"], compiler.autolimits)?;
        let mut range = range.map(|range| range.map(|x| x * unit));
        let is_ball = motion == Motion::Ball;
        if is_ball && range.is_some_and(|range| range[0] != 0.0) {
            return Err(values.error("range", "expected 0 as the first number for a ball"));
        }
        let (reference, rest) = if is_ball { (0.0, 0.0) } else { (reference, rest) };
        range = range.map(|range| range.map(|x| x - reference));
        let body = self.model.bodies[self.parts[place.part].rigid].placement;
        let own = Placement { position: values.numbers("pos")?.unwrap_or([0.0; 3]), ..Placement::IDENTITY };
        let anchor = frame.after(&own).position;
        let axis = frame.turn.rotate(axis);
        let name = self.full_name(values.name()?);
        let stiffness = self.first(values, "stiffness")?;
        let damping = self.first(values, "damping")?;
        Ok(JointPart {
            name,
            motion,
            anchor,
            axis,
            world_anchor: body.transform(anchor),
            world_axis: body.turn.rotate(axis),
            range,
            stiffness,
            spring_rest: rest - reference,
            damping,
            friction_loss: values.positive("frictionloss")?.unwrap_or(0.0),
            armature: values.positive("armature")?.unwrap_or(0.0),
            reference,
        })
    }

    /// A coefficient that may be a polynomial, of which the first is read.
    pub(super) fn first(&mut self, values: &Values<'_>, name: &str) -> Result<f64, SceneError> {
        let list = values.list(name, 1, 3)?.unwrap_or_default();
        if list.iter().skip(1).any(|&x| x != 0.0) {
            let tag = values.tree.elements[values.element].tag.as_str();
            self.warn(Effect::Motion, format!("{tag}/{name} beyond its first number"), spot(values));
        }
        match list.first() {
            Some(x) if *x < 0.0 => Err(values.error(name, format!("found {x}, expected none below 0"))),
            first => Ok(first.copied().unwrap_or(0.0)),
        }
    }

    /// The place of what is outside of all bodies.
    pub(super) fn nowhere(&self, source: usize) -> Place {
        Place { source, part: 0, frame: Placement::IDENTITY, class: Classes::outermost(), in_body: false }
    }
}
