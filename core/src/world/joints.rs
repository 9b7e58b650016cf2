//! Creating, changing and reading joints.

use super::World;
use super::sleep::wake_slot;
use crate::arena::Line;
use crate::body::turned_frame;
use crate::error::Error;
use crate::handle::{BodyHandle, JointHandle};
use crate::joint::{Axis, AxisRow, BROKEN, Coupling, Joint, JointDef, JointRow};
use crate::math::{Pose, Vec3, length};
use crate::pipeline::joints::turns_of;
use crate::pool;
use crate::shape::BOX_STALE;
use crate::state::{JOINT_BOUNDS, State, mark_shapes};
use bytemuck::Zeroable;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Joins two bodies.
    ///
    /// # Errors
    /// [`Error::Stale`] body; [`Error::Full`], also when the joints have more than four limits, drives and
    /// frictions each on average; [`Error::OutOfRange`] for a body with itself, or a number of the definition is
    /// refused; see [`JointDef`].
    pub fn create_joint(&mut self, def: &JointDef) -> Result<JointHandle, Error> {
        def.check()?;
        let slots = [self.body_slot(def.bodies[0])? as u32, self.body_slot(def.bodies[1])? as u32];
        if slots[0] == slots[1] {
            return Err(Error::OutOfRange { name: "bodies" });
        }
        let joint = Joint::new(slots, def);
        let mut state = self.state_view();
        let bounds = joint.signature().bound_rows() as u32;
        check_bounds(&state, 0, bounds)?;
        let marks = &mut state.header[0].joints;
        let slot = pool::acquire(marks, state.joint_used, state.joint_generations)
            .ok_or(Error::Full { name: "joints" })?;
        state.header[0].joint_bounds += bounds;
        put(&mut state, slot as usize, &joint);
        append(&mut state, slot);
        meet_again(&mut state, slots);
        let handle = JointHandle { index: slot, generation: state.joint_generations[slot as usize] };
        self.touch_trees();
        Ok(handle)
    }

    /// Removes a joint.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn remove_joint(&mut self, joint: JointHandle) -> Result<(), Error> {
        let slot = self.joint_slot(joint)?;
        remove(&mut self.state_view(), slot as u32);
        self.touch_trees();
        Ok(())
    }

    /// True when the handle names a joint that exists.
    pub fn contains_joint(&self, joint: JointHandle) -> bool {
        self.joint_slot(joint).is_ok()
    }

    /// Number of joints.
    pub fn joint_count(&self) -> u32 {
        self.header().joints.count
    }

    /// Handles of all joints, ascending by slot.
    pub fn joints(&self) -> impl Iterator<Item = JointHandle> + '_ {
        let generations = self.layout.state.joint_generations.of(self.state());
        pool::iterate(self.layout.state.joint_used.of(self.state()), self.header().joints.high)
            .map(|slot| JointHandle { index: slot, generation: generations[slot as usize] })
    }

    /// Handles of the joints of a body, in the order of their creation.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn joints_of(&self, body: BodyHandle) -> Result<impl Iterator<Item = JointHandle> + '_, Error> {
        let slot = self.body_slot(body)?;
        let rows = self.layout.state.joints.of(self.state());
        let generations = self.layout.state.joint_generations.of(self.state());
        let mut next = self.layout.state.first_joints.of(self.state()).get(slot).copied().unwrap_or(0);
        Ok(core::iter::from_fn(move || {
            let index = next.checked_sub(1)?;
            next = rows[index as usize].next_of(slot as u32);
            Some(JointHandle { index, generation: generations[index as usize] })
        }))
    }

    /// The joint as it is defined now.
    ///
    /// # Errors
    /// [`Error::Stale`], as for all accessors of a joint.
    pub fn joint(&self, joint: JointHandle) -> Result<JointDef, Error> {
        let slot = self.joint_slot(joint)?;
        let spans = &self.layout.state;
        let axes = spans.joint_axes.of(self.state())[slot];
        let row = Joint { row: spans.joints.of(self.state())[slot], axes };
        let generations = self.layout.state.body_generations.of(self.state());
        let bodies = row.bodies.map(|index| BodyHandle { index, generation: generations[index as usize] });
        Ok(row.read(bodies).expect("joints in the state are valid"))
    }

    /// Changes everything of a joint but its bodies: limits, drives, frames. What it pressed is forgotten where its
    /// rows are others than before.
    ///
    /// # Errors
    /// As [`World::create_joint`]; [`Error::WrongKind`] when the definition names other bodies.
    pub fn set_joint(&mut self, joint: JointHandle, def: &JointDef) -> Result<(), Error> {
        let slot = self.joint_slot(joint)?;
        def.check()?;
        if self.joint(joint)?.bodies != def.bodies {
            return Err(Error::WrongKind { needs: "a joint keeps its bodies; make another one" });
        }
        let mut state = self.state_view();
        let old = get(&state, slot);
        let mut row = Joint::new(old.bodies, def);
        let (before, after) = (old.signature(), row.signature());
        check_bounds(&state, before.bound_rows() as u32, after.bound_rows() as u32)?;
        state.header[0].joint_bounds += after.bound_rows() as u32;
        state.header[0].joint_bounds -= before.bound_rows() as u32;
        row.carry_over(&old);
        put(&mut state, slot, &row);
        meet_again(&mut state, old.bodies);
        self.touch_trees();
        Ok(())
    }

    /// Changes one axis of a joint: its limits, its drive. Cheaper than [`World::set_joint`]; for motors and the
    /// like.
    ///
    /// # Errors
    /// [`Error::Stale`], [`Error::Full`] as for [`World::create_joint`], or a number is refused; an index above 5
    /// is [`Error::OutOfRange`].
    pub fn set_joint_axis(&mut self, joint: JointHandle, index: usize, axis: &Axis) -> Result<(), Error> {
        let slot = self.joint_slot(joint)?;
        axis.check()?;
        if index > 5 {
            return Err(Error::OutOfRange { name: "index" });
        }
        let mut state = self.state_view();
        let mut row = get(&state, slot);
        let before = row.signature().bound_rows() as u32;
        row.define_axis(index, axis);
        let after = row.signature().bound_rows() as u32;
        check_bounds(&state, before, after)?;
        state.header[0].joint_bounds = state.header[0].joint_bounds - before + after;
        put(&mut state, slot, &row);
        row.bodies.iter().for_each(|&body| wake_slot(&mut state, body as usize));
        Ok(())
    }

    /// Yours.
    pub fn joint_user(&self, joint: JointHandle) -> Result<u64, Error> {
        Ok(self.joint_row(joint)?.user)
    }

    /// Sets your value.
    pub fn set_joint_user(&mut self, joint: JointHandle, user: u64) -> Result<(), Error> {
        let slot = self.joint_slot(joint)?;
        self.state_view().joints[slot].user = user;
        Ok(())
    }

    /// True when the joint broke under its load: it holds nothing any more, and waits to be removed.
    pub fn is_broken(&self, joint: JointHandle) -> Result<bool, Error> {
        Ok(self.joint_row(joint)?.has(BROKEN))
    }

    /// Force on body B in the last substep, N in the world; body A has the opposite.
    pub fn joint_force(&self, joint: JointHandle) -> Result<Vec3, Error> {
        Ok(self.joint_row(joint)?.force)
    }

    /// Torque on body B about the joint's point in the last substep, N m in the world.
    pub fn joint_torque(&self, joint: JointHandle) -> Result<Vec3, Error> {
        Ok(self.joint_row(joint)?.torque)
    }

    /// How B's frame stands in A's: shifts along A's axes, metres, then turns about x, y and z, radians in ±pi (y
    /// in ±pi/2). A distance joint has the distance first. See [`crate::joint`].
    pub fn joint_coordinates(&self, joint: JointHandle) -> Result<[f32; 6], Error> {
        let row = self.joint_row(joint)?;
        let [a, b] = self.joint_frames(row);
        let gap = b.position;
        if matches!(self.joint(joint)?.coupling, Coupling::Distance) {
            return Ok([length(gap), 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
        let (ma, mb) = (a.rotation.matrix(), b.rotation.matrix());
        let axes = (ma.x_axis, ma.y_axis, ma.z_axis);
        let turns = turns_of(axes, (mb.x_axis, mb.y_axis), row.signature().is_twist());
        let [x, y, z] = [axes.0, axes.1, axes.2].map(|axis| axis.dot(gap));
        Ok([x, y, z, turns[0], turns[1], turns[2]])
    }

    /// A joint's frames in world axes, from A's point.
    pub(super) fn joint_frames(&self, row: &JointRow) -> [Pose; 2] {
        let bodies = self.layout.state.bodies.of(self.state());
        let motions = self.layout.state.motions.of(self.state());
        let [a, b] = row.bodies.map(|slot| slot as usize);
        let frame = |slot: usize, local: &Pose| turned_frame(motions[slot].rotation, &bodies[slot], local);
        let (first, mut second) = (frame(a, &row.frames[0]), frame(b, &row.frames[1]));
        second.position += motions[b].center.minus(motions[a].center) - first.position;
        [Pose::new(Vec3::ZERO, first.rotation), second]
    }

    pub(super) fn joint_slot(&self, joint: JointHandle) -> Result<usize, Error> {
        let used = self.layout.state.joint_used.of(self.state());
        let generations = self.layout.state.joint_generations.of(self.state());
        let lives = pool::is_used(used, joint.index)
            && generations.get(joint.index as usize) == Some(&joint.generation);
        if lives { Ok(joint.index as usize) } else { Err(Error::Stale { what: "joint" }) }
    }

    fn joint_row(&self, joint: JointHandle) -> Result<&JointRow, Error> {
        let slot = self.joint_slot(joint)?;
        Ok(&self.layout.state.joints.of(self.state())[slot])
    }
}

fn get(state: &State<'_>, slot: usize) -> Joint {
    Joint { row: state.joints[slot], axes: state.joint_axes[slot] }
}

fn put(state: &mut State<'_>, slot: usize, joint: &Joint) {
    (state.joints[slot], state.joint_axes[slot]) = (joint.row, joint.axes);
}

/// Refuses a joint for whose limits, drives and frictions there is no room.
fn check_bounds(state: &State<'_>, before: u32, after: u32) -> Result<(), Error> {
    let total = state.header[0].joint_bounds - before + after;
    if total as usize > JOINT_BOUNDS * state.joints.len() {
        return Err(Error::Full { name: "joints" });
    }
    Ok(())
}

/// Pairs of the shapes of two bodies are looked for again: whether they meet may have changed.
fn meet_again(state: &mut State<'_>, bodies: [u32; 2]) {
    for body in bodies {
        mark_shapes(state, body as usize, BOX_STALE);
        wake_slot(state, body as usize);
    }
}

/// Puts a joint at the end of its bodies' lists.
fn append(state: &mut State<'_>, joint: u32) {
    for body in state.joints[joint as usize].bodies {
        let mut last = state.first_joints[body as usize];
        if last == 0 {
            state.first_joints[body as usize] = joint + 1;
            continue;
        }
        loop {
            let next = state.joints[last as usize - 1].next_of_mut(body);
            if *next == 0 {
                *next = joint + 1;
                break;
            }
            last = *next;
        }
    }
}

/// Takes a joint out of its bodies' lists, and zeroes it.
fn remove(state: &mut State<'_>, joint: u32) {
    let row = state.joints[joint as usize];
    for body in row.bodies {
        let after = row.next_of(body);
        let mut at = state.first_joints[body as usize];
        if at == joint + 1 {
            state.first_joints[body as usize] = after;
            continue;
        }
        while at != 0 {
            let next = state.joints[at as usize - 1].next_of_mut(body);
            if *next == joint + 1 {
                *next = after;
                break;
            }
            at = *next;
        }
    }
    meet_again(state, row.bodies);
    state.joints[joint as usize] = JointRow::zeroed();
    state.joint_axes[joint as usize].fill(AxisRow::zeroed());
    let header = &mut state.header[0];
    header.joint_bounds -= row.signature().bound_rows() as u32;
    header.joints_stale = 1;
    pool::release(&mut header.joints, state.joint_used, joint);
}

/// Removes all joints of a body.
pub(super) fn remove_joints_of(state: &mut State<'_>, body: u32) {
    while let Some(joint) = state.first_joints.get(body as usize).and_then(|first| first.checked_sub(1)) {
        remove(state, joint);
    }
}
