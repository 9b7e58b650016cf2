//! Creating, changing and reading shapes.

use super::World;
use super::events::{count_shape, forget_shape};
use super::materials::{drop_material, drop_rules, find_room, take_material};
use super::sleep::wake_slot;
use crate::arena::Line;
use crate::body::BodyKind;
use crate::error::Error;
use crate::handle::{BodyHandle, ShapeHandle};
use crate::material::RULE_MATERIAL;
use crate::math::Pose;
use crate::pool;
use crate::shape::{BOX_STALE, FRESH, Filter, Geometry, ShapeDef, ShapeRow};
use crate::state::{PAIRS_REMOVED, mark_shapes};
use crate::validate;
use bytemuck::Zeroable;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Adds a shape to a body, and its mass to the body's unless that was given.
    ///
    /// # Errors
    /// [`Error::Stale`] body or asset, [`Error::Full`] (of `shapes`, of `materials`, or of `sensor_visits` for a
    /// sensor in a world without [`Capacities::sensor_visits`](crate::Capacities::sensor_visits)),
    /// [`Error::WrongKind`] for a half-space, a mesh or a height field on a dynamic body, or a number of the
    /// definition is refused; see [`ShapeDef`].
    pub fn create_shape(&mut self, body: BodyHandle, def: &ShapeDef) -> Result<ShapeHandle, Error> {
        def.check()?;
        let body_slot = self.body_slot(body)?;
        self.check_geometry(&def.geometry, self.kind(body)?)?;
        if def.sensor.is_some() && self.capacities.sensor_visits == 0 {
            return Err(Error::Full { name: "sensor_visits" });
        }
        let mut state = self.state_view();
        let material = find_room(&state, &def.traits)?;
        let marks = &mut state.header[0].shapes;
        let slot = pool::acquire(marks, state.shape_used, state.shape_generations)
            .ok_or(Error::Full { name: "shapes" })?;
        state.shapes[slot as usize] = ShapeRow::new(body_slot as u32, def);
        take_material(&mut state, slot, (&def.traits, material));
        count_shape(&mut state, slot as usize);
        append(&mut state, body_slot, slot);
        wake_slot(&mut state, body_slot);
        let handle = ShapeHandle { index: slot, generation: state.shape_generations[slot as usize] };
        self.touch_trees();
        self.update_mass(body_slot);
        Ok(handle)
    }

    /// Removes a shape, and its mass from the body's unless that was given.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn remove_shape(&mut self, shape: ShapeHandle) -> Result<(), Error> {
        let slot = self.shape_slot(shape)?;
        let mut state = self.state_view();
        let body = state.shapes[slot].body as usize;
        wake_slot(&mut state, body);
        unlink(&mut state, body, slot as u32);
        drop_material(&mut state, slot as u32);
        drop_rules(&mut state, RULE_MATERIAL, slot as u32);
        forget_shape(&mut state, slot);
        state.shapes[slot] = Zeroable::zeroed();
        pool::release(&mut state.header[0].shapes, state.shape_used, slot as u32);
        state.header[0].pairs_stale |= PAIRS_REMOVED;
        self.touch_trees();
        self.update_mass(body);
        Ok(())
    }

    /// True when the handle names a shape that exists.
    pub fn contains_shape(&self, shape: ShapeHandle) -> bool {
        self.shape_slot(shape).is_ok()
    }

    /// The shape as it would be defined.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn shape(&self, shape: ShapeHandle) -> Result<ShapeDef, Error> {
        let row = self.shape_row(shape)?;
        Ok(ShapeDef {
            geometry: row.geometry().expect("shapes in the state are valid"),
            pose: row.pose,
            density: row.density,
            friction: row.friction,
            restitution: row.restitution,
            traits: self.traits_of(row),
            filter: row.filter,
            sensor: row.sensor(),
            events: row.events(),
            user: row.user,
        })
    }

    /// The body that the shape belongs to.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn body_of(&self, shape: ShapeHandle) -> Result<BodyHandle, Error> {
        let index = self.shape_row(shape)?.body;
        let generation = self.layout.state.body_generations.of(self.state())[index as usize];
        Ok(BodyHandle { index, generation })
    }

    /// Yours.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn shape_user(&self, shape: ShapeHandle) -> Result<u64, Error> {
        Ok(self.shape_row(shape)?.user)
    }

    /// Sets your value.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn set_shape_user(&mut self, shape: ShapeHandle, user: u64) -> Result<(), Error> {
        let slot = self.shape_slot(shape)?;
        self.state_view().shapes[slot].user = user;
        Ok(())
    }

    /// Changes geometry and local pose. The body's mass follows unless it was given.
    ///
    /// # Errors
    /// As [`World::create_shape`].
    pub fn set_geometry(
        &mut self,
        shape: ShapeHandle,
        geometry: &Geometry,
        pose: &Pose,
    ) -> Result<(), Error> {
        let slot = self.shape_slot(shape)?;
        geometry.check()?;
        validate::pose("pose", pose)?;
        let body = self.body_of(shape)?;
        self.check_geometry(geometry, self.kind(body)?)?;
        let mut state = self.state_view();
        let row = &mut state.shapes[slot];
        row.set_geometry(geometry);
        row.pose = Pose::new(pose.position, pose.rotation.normalized());
        row.flags |= BOX_STALE | FRESH;
        wake_slot(&mut state, body.index as usize);
        self.touch_trees();
        self.update_mass(body.index as usize);
        Ok(())
    }

    /// Changes density, kg/m3, 0..=1e9. The body's mass follows unless it was given.
    ///
    /// # Errors
    /// [`Error::Stale`], or the number is refused.
    pub fn set_density(&mut self, shape: ShapeHandle, density: f32) -> Result<(), Error> {
        let slot = self.shape_slot(shape)?;
        validate::in_range("density", density, 0.0, 1.0e9)?;
        let state = self.state_view();
        state.shapes[slot].density = density;
        let body = state.shapes[slot].body as usize;
        self.cache_header_mut().queried = 0;
        self.update_mass(body);
        Ok(())
    }

    /// Changes which shapes it meets.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn set_filter(&mut self, shape: ShapeHandle, filter: Filter) -> Result<(), Error> {
        let slot = self.shape_slot(shape)?;
        let mut state = self.state_view();
        state.shapes[slot].filter = filter;
        let body = state.shapes[slot].body as usize;
        mark_shapes(&mut state, body, BOX_STALE);
        wake_slot(&mut state, body);
        self.touch_trees();
        Ok(())
    }

    /// Refuses geometry that names no asset, or that the body's kind does not allow.
    fn check_geometry(&self, geometry: &Geometry, kind: BodyKind) -> Result<(), Error> {
        let assets = &self.layout.assets.header.of(self.bytes())[0];
        match geometry {
            Geometry::Hull(hull) if hull.0 >= assets.hulls => return Err(Error::Stale { what: "hull" }),
            Geometry::Mesh(mesh) if mesh.0 >= assets.meshes => return Err(Error::Stale { what: "mesh" }),
            Geometry::RoundedHull { hull, .. } if hull.0 >= assets.hulls => {
                return Err(Error::Stale { what: "hull" });
            }
            Geometry::HeightField(field) if field.0 >= assets.height_fields => {
                return Err(Error::Stale { what: "height field" });
            }
            Geometry::Compound(compound) if compound.0 >= assets.compounds => {
                return Err(Error::Stale { what: "compound" });
            }
            _ => {}
        }
        if geometry.is_surface() && kind == BodyKind::Dynamic {
            return Err(Error::WrongKind {
                needs: "half-spaces, meshes and height fields are for static and kinematic bodies",
            });
        }
        Ok(())
    }

    pub(super) fn shape_slot(&self, shape: ShapeHandle) -> Result<usize, Error> {
        let used = self.layout.state.shape_used.of(self.state());
        let generations = self.layout.state.shape_generations.of(self.state());
        let lives = pool::is_used(used, shape.index)
            && generations.get(shape.index as usize) == Some(&shape.generation);
        if lives { Ok(shape.index as usize) } else { Err(Error::Stale { what: "shape" }) }
    }

    pub(super) fn shape_row(&self, shape: ShapeHandle) -> Result<&ShapeRow, Error> {
        let slot = self.shape_slot(shape)?;
        Ok(&self.layout.state.shapes.of(self.state())[slot])
    }
}

/// Puts a shape at the end of its body's list.
fn append(state: &mut crate::state::State<'_>, body: usize, shape: u32) {
    let mut next = state.bodies[body].first_shape;
    if next == u32::MAX {
        state.bodies[body].first_shape = shape;
        return;
    }
    loop {
        let row = &mut state.shapes[next as usize];
        if row.next == u32::MAX {
            row.next = shape;
            return;
        }
        next = row.next;
    }
}

/// Takes a shape out of its body's list.
fn unlink(state: &mut crate::state::State<'_>, body: usize, shape: u32) {
    let after = state.shapes[shape as usize].next;
    if state.bodies[body].first_shape == shape {
        state.bodies[body].first_shape = after;
        return;
    }
    let mut next = state.bodies[body].first_shape;
    while next != u32::MAX {
        let row = &mut state.shapes[next as usize];
        if row.next == shape {
            row.next = after;
            return;
        }
        next = row.next;
    }
}
