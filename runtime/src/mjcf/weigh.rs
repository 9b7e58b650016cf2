//! What bodies weigh: `<inertial>`, or their geoms, by the rules of their files.

use super::math::Turn;
use super::model::{BodyKind, Mass};
use super::settings::InertiaFrom;
use super::tree::shortened;
use super::values::Values;
use super::walk::{Place, Walk};
use crate::scene::SceneError;

/// Least mass of what moves, and least moment of inertia: MuJoCo's.
const MASS_MIN: f64 = 1.0e-15;

impl Walk<'_> {
    /// Reads `<inertial>` of a body.
    pub(super) fn inertial(&mut self, place: &Place, body: usize) -> Result<(), SceneError> {
        let all = self.inner(place, body, &["inertial"])?;
        let Some((element, frame, _)) = all.first() else { return Ok(()) };
        let values = self.values(place, *element, None)?;
        let mut placement = self.source(place).compiler.placement(values)?;
        for name in ["pos", "mass"] {
            if !values.has(name) {
                return Err(values.error(name, format!("no `{name}`, expected one")));
            }
        }
        let mass = values.positive("mass")?.unwrap_or(0.0);
        let given = match (values.numbers::<3>("diaginertia")?, values.numbers::<6>("fullinertia")?) {
            (Some(inertia), None) => Mass::at(&placement, mass, inertia),
            (None, Some([xx, yy, zz, xy, xz, yz])) => {
                if placement.turn != Turn::IDENTITY {
                    return Err(values.error("fullinertia", "an orientation besides, expected none"));
                }
                placement.turn = Turn::IDENTITY;
                Mass::of_tensor(mass, placement.position, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            }
            _ => return Err(values.error("diaginertia", "expected one of `diaginertia` and `fullinertia`")),
        };
        if given.inertia.iter().any(|&moment| moment < 0.0) {
            let message = format!("found the moments {:?}, expected none below 0", given.inertia);
            return Err(values.error("diaginertia", message));
        }
        let given = given.moved(&place.frame.after(frame));
        self.parts[place.part].inertial = Some(given);
        Ok(())
    }

    /// The mass of one `<body>`, by the rules of its file, goes to its rigid body.
    pub(super) fn weigh_part(&mut self, values: &Values<'_>, place: &Place) -> Result<(), SceneError> {
        let compiler = &self.source(place).compiler;
        let part = &mut self.parts[place.part];
        let geoms = std::mem::take(&mut part.masses);
        let mass = match (compiler.inertia, part.inertial) {
            (InertiaFrom::Given, given) => given,
            (InertiaFrom::Either, Some(given)) => Some(given),
            _ => Mass::sum(&geoms),
        };
        let (least, least_moment) = (compiler.bound_mass, compiler.bound_inertia);
        let bounded = least > 0.0 || least_moment > 0.0;
        let nothing = Mass::at(&place.frame, 0.0, [0.0; 3]);
        let Some(mut mass) = mass.or(bounded.then_some(nothing)) else { return Ok(()) };
        mass.mass = mass.mass.max(least);
        mass.inertia = mass.inertia.map(|moment| moment.max(least_moment));
        if !mass.is_possible() {
            if !compiler.balance {
                let message = format!(
                    "found the moments of inertia {:?}, expected none above the sum of the others: mend them, or \
                     set `balanceinertia` of <compiler>",
                    mass.inertia
                );
                return Err(values.error("", message));
            }
            mass.inertia = [(mass.inertia[0] + mass.inertia[1] + mass.inertia[2]) / 3.0; 3];
        }
        self.masses[self.parts[place.part].rigid].push(mass);
        Ok(())
    }

    /// Masses of rigid bodies.
    pub(super) fn weigh(&mut self) -> Result<(), SceneError> {
        let masses = self.masses.iter().map(|masses| Mass::sum(masses));
        let mut masses: Vec<Option<Mass>> = masses.collect();
        let source = &self.library.sources[0];
        if let Some(total) = source.compiler.total_mass {
            let sum = masses.iter().flatten().fold(0.0, |sum, mass| sum + mass.mass);
            for mass in masses.iter_mut().flatten().filter(|_| sum > 0.0) {
                *mass = mass.with(mass.mass * total / sum);
            }
        }
        for ((body, mass), origin) in self.model.bodies.iter_mut().zip(masses).zip(&self.origins).skip(1) {
            let enough = |m: &Mass| m.mass >= MASS_MIN && m.inertia.iter().all(|&moment| moment >= MASS_MIN);
            if body.kind != BodyKind::Mocap && !mass.as_ref().is_some_and(enough) {
                let name = shortened(&body.name);
                let message = format!(
                    "the moving body {name:?} has no mass or no inertia, expected at least {MASS_MIN:e}: give it a \
                     geom or an <inertial>"
                );
                let (tree, files) = (&self.library.sources[origin.0].tree, &self.library.files);
                return Err(Values { files, tree, element: origin.1, defaults: None }.error("", message));
            }
            body.mass = mass;
        }
        Ok(())
    }
}
