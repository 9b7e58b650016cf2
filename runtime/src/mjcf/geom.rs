//! `<geom>`: form, place, mass and surface.

use super::mass::volume;
use super::math::{Placement, Turn, direction, length, scaled, sub};
use super::mesh;
use super::model::{Form, Geom, Mass};
use super::tree::{Spot, shortened};
use super::values::Values;
use super::walk::{Place, Walk};
use super::warning::Effect;
use crate::scene::SceneError;
use crate::scene::format::MESH_PARTS_MAX;
use std::f64::consts::PI;

/// Density of a geom that names none, kg/m3.
const DENSITY: f64 = 1000.0;
/// Coefficients of friction of a geom that names none.
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];
const TYPES: [&str; 9] =
    ["sphere", "plane", "capsule", "cylinder", "box", "ellipsoid", "mesh", "hfield", "sdf"];

/// `fromto`: the middle of the segment with z along it, and half its length.
pub(super) fn ends(values: &Values<'_>) -> Result<Option<(Placement, f64)>, SceneError> {
    let Some([a, b, c, d, e, f]) = values.numbers::<6>("fromto")? else { return Ok(None) };
    if values.numbers::<3>("pos")?.is_some_and(|position| position != [0.0; 3]) {
        return Err(values.error("fromto", "and `pos` besides, expected one of them"));
    }
    let (from, to) = ([a, b, c], [d, e, f]);
    // As in MuJoCo, z points from the second end to the first.
    let along = sub(from, to);
    let Some(turn) = direction(along).and_then(Turn::z_to) else {
        return Err(values.error("fromto", "two ends at one place, expected them apart"));
    };
    let middle = scaled([from[0] + to[0], from[1] + to[1], from[2] + to[2]], 0.5);
    Ok(Some((Placement::new(middle, turn), length(along) * 0.5)))
}

/// The share of the approach speed with which a body leaves a damped spring: of a spring with the damping ratio
/// `z`, `exp(-pi z / sqrt(1 - z^2))`, and nothing from 1 on. `solref` gives the ratio as its second number, or,
/// where both are not positive, stiffness and damping of a unit mass with a minus.
fn restitution(values: &Values<'_>) -> Result<f64, SceneError> {
    let Some(list) = values.list("solref", 1, 2)? else { return Ok(0.0) };
    let (first, second) = (list[0], list.get(1).copied().unwrap_or(1.0));
    let ratio = if first > 0.0 {
        second
    } else if first < 0.0 && second <= 0.0 {
        -second / (2.0 * (-first).sqrt())
    } else {
        1.0
    };
    let bounces = (0.0..1.0).contains(&ratio);
    Ok(if bounces { libm::exp(-PI * ratio / (1.0 - ratio * ratio).sqrt()) } else { 0.0 })
}

impl Walk<'_> {
    /// Reads a geom; what cellstep has no form for is left out with a warning.
    pub(super) fn geom(&mut self, place: &Place, element: usize) -> Result<(), SceneError> {
        let values = self.values(place, element, Some("geom"))?;
        self.geoms += 1;
        if self.geoms > self.library.limits.shapes as usize {
            return Err(Self::too_large(&values, "geoms", self.library.limits.shapes));
        }
        let kind = TYPES[values.keyword("type", &TYPES)?.unwrap_or(0)];
        let spot = values.tree.elements[element].spot;
        if matches!(kind, "hfield" | "sdf") || (kind != "mesh" && values.has("mesh")) {
            let what = if values.has("mesh") { "geom of a simple type, fitted to a mesh" } else { kind };
            self.warn(Effect::Motion, format!("geom ({what})"), spot);
            return Ok(());
        }
        let (form, own) = self.form(place, &values, kind)?;
        let rigid = self.parts[place.part].rigid;
        if form == Form::HalfSpace && rigid != 0 {
            let message = "a plane on a body that moves, expected it on a fixed one";
            return Err(values.error("type", message));
        }
        let placement = place.frame.after(&own);
        self.weigh_geom(place, &values, &form, &placement)?;
        let condim = values.integer("condim")?.unwrap_or(3);
        if ![1, 3, 4, 6].contains(&condim) {
            return Err(values.error("condim", format!("found {condim}, expected 1, 3, 4 or 6")));
        }
        let mut friction = FRICTION;
        let given = values.list("friction", 1, 3)?.unwrap_or_default();
        friction.iter_mut().zip(&given).for_each(|(to, from)| *to = *from);
        if friction.iter().any(|&x| x < 0.0) {
            return Err(values.error("friction", format!("found {friction:?}, expected none below 0")));
        }
        let geom = Geom {
            name: self.full_name(values.name()?),
            part: place.part,
            form,
            placement,
            friction,
            restitution: restitution(&values)?,
            condim,
            contype: values.integer("contype")?.unwrap_or(1) as u32,
            conaffinity: values.integer("conaffinity")?.unwrap_or(1) as u32,
        };
        self.model.bodies[rigid].geoms.push(geom);
        Ok(())
    }

    /// The form, and its frame in that around the geom.
    fn form(
        &mut self,
        place: &Place,
        values: &Values<'_>,
        kind: &str,
    ) -> Result<(Form, Placement), SceneError> {
        let ends = ends(values)?;
        let placement = match ends {
            Some((placement, _)) => placement,
            None => self.source(place).compiler.placement(*values)?,
        };
        if ends.is_some() && !matches!(kind, "capsule" | "cylinder" | "box" | "ellipsoid") {
            let message = format!("on a {kind}, expected it on a capsule, cylinder, box or ellipsoid");
            return Err(values.error("fromto", message));
        }
        let size = values.list("size", 1, 3)?.unwrap_or_default();
        let side = |index: usize| match size.get(index) {
            Some(&side) if side > 0.0 => Ok(side),
            Some(side) => Err(values.error("size", format!("found {side}, expected sizes greater than 0"))),
            None => {
                let message = format!("{} numbers for a {kind}, expected {}", size.len(), index + 1);
                Err(values.error("size", message))
            }
        };
        let half_height = || ends.map_or_else(|| side(1), |(_, half)| Ok(half));
        // A box between two ends is square unless it has two sizes; the third follows.
        let sides = || match ends {
            None => Ok([side(0)?, side(1)?, side(2)?]),
            Some((_, half)) => Ok([side(0)?, side(0)?, half]),
        };
        let form = match kind {
            "plane" => Form::HalfSpace,
            "sphere" => Form::Sphere { radius: side(0)? },
            "capsule" => Form::Capsule { half_height: half_height()?, radius: side(0)? },
            "cylinder" => Form::Cylinder { half_height: half_height()?, radius: side(0)? },
            "box" => Form::Box { half_extents: sides()? },
            "ellipsoid" => Form::Ellipsoid { half_axes: sides()? },
            _ => Form::Hull(self.mesh(place, values)?),
        };
        Ok((form, placement))
    }

    /// The index of the mesh that a geom names; it is loaded when it is named first.
    fn mesh(&mut self, place: &Place, values: &Values<'_>) -> Result<usize, SceneError> {
        let name = values.text("mesh").unwrap_or_default();
        let source = self.source(place);
        let Some(&element) = source.meshes.get(name) else {
            let message = format!("no mesh of <asset> is named {:?}, expected one that is", shortened(name));
            return Err(values.error("mesh", message));
        };
        if let Some(&known) = self.meshes.get(&(place.source, element)) {
            return Ok(known);
        }
        let outermost = Place { class: super::settings::Classes::outermost(), ..place.clone() };
        let values = self.values(&outermost, element, Some("mesh"))?;
        let loaded = mesh::load(values, source, &self.library.limits)?;
        self.mesh_points += loaded.points;
        if self.mesh_points > MESH_PARTS_MAX {
            return Err(Self::too_large(&values, "points of meshes", MESH_PARTS_MAX as u64));
        }
        if loaded.simplified {
            let spot = values.tree.elements[element].spot;
            self.warn(Effect::Motion, "corners of a mesh beyond 64", spot);
        }
        let mut mesh = loaded.mesh;
        // Files that are attached may use a name again.
        while !self.mesh_names.insert(mesh.name.clone()) {
            mesh.name = format!("{}#{}", mesh.name, self.model.meshes.len());
        }
        self.model.meshes.push(mesh);
        self.meshes.insert((place.source, element), self.model.meshes.len() - 1);
        Ok(self.model.meshes.len() - 1)
    }

    /// Adds the mass of a geom to its `<body>`.
    fn weigh_geom(
        &mut self,
        place: &Place,
        values: &Values<'_>,
        form: &Form,
        placement: &Placement,
    ) -> Result<(), SceneError> {
        let mass = values.positive("mass")?;
        let density = values.positive("density")?.unwrap_or(DENSITY);
        let group = values.integer("group")?.unwrap_or(0);
        let [first, last] = self.source(place).compiler.groups;
        let whole = match form {
            Form::Hull(mesh) => Some(self.model.meshes[*mesh].mass.moved(placement)),
            _ => volume(form).map(|(volume, inertia)| Mass::at(placement, volume, scaled(inertia, volume))),
        };
        if let Some(whole) = whole.filter(|_| place.part != 0 && (first..=last).contains(&group)) {
            let mass = whole.with(mass.unwrap_or(whole.mass * density));
            if mass.mass > 0.0 {
                self.parts[place.part].masses.push(mass);
            }
        }
        Ok(())
    }
}

/// Where an element begins.
pub(super) fn spot(values: &Values<'_>) -> Spot {
    values.tree.elements[values.element].spot
}
