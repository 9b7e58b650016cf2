//! Taking state from bytes of unknown origin: accepted exactly, or refused.

mod events;
mod joints;
mod materials;
mod sleep;

use super::World;
use super::snapshot::{Done, Section, check_content, parts};
use crate::arena::Line;
use crate::body::{self, BodyKind, BodyRow, Motion};
use crate::cells::CELLULAR_PHASES_MAX;
use crate::config::{SECTOR_MAX, SECTOR_REACH, SUBSTEPS_MAX};
use crate::error::{Error, SnapshotError};
use crate::event::{BodyNews, EventRow, Tenant, Visit};
use crate::joint::{AxisRow, JointRow};
use crate::material::{MaterialRow, PairRule};
use crate::math::{Rotation, Vec3};
use crate::pipeline::meeting;
use crate::pool::{Marks, words};
use crate::shape::{self, BOX_STALE, FRESH, Geometry, MATERIAL_SHIFT, ShapeRow};
use crate::state::{AssetTables, ContactRow, Header, Pair};
use crate::validate;
use bytemuck::{AnyBitPattern, Zeroable};

/// Steps and versions only rise: from below this no game reaches the end of a `u64`.
const COUNTER_MAX: u64 = 1 << 63;

/// Rows of a section in bytes of any alignment.
pub(super) struct Rows<'a, T> {
    bytes: &'a [u8],
    kind: core::marker::PhantomData<T>,
}

impl<'a, T: AnyBitPattern> Rows<'a, T> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, kind: core::marker::PhantomData }
    }

    /// True when these are the rows, bit by bit.
    pub(super) fn are(&self, rows: &[T]) -> bool
    where
        T: bytemuck::NoUninit,
    {
        self.bytes == bytemuck::cast_slice::<T, u8>(rows)
    }

    pub(super) fn len(&self) -> u32 {
        (self.bytes.len() / size_of::<T>()) as u32
    }

    pub(super) fn get(&self, index: u32) -> T {
        let start = index as usize * size_of::<T>();
        bytemuck::pod_read_unaligned(&self.bytes[start..start + size_of::<T>()])
    }

    fn iter(&self) -> impl Iterator<Item = T> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }
}

/// The sections of a snapshot.
struct Parts<'a> {
    header: Header,
    motions: Rows<'a, Motion>,
    bodies: Rows<'a, BodyRow>,
    body_generations: Rows<'a, u32>,
    body_used: Rows<'a, u64>,
    shapes: Rows<'a, ShapeRow>,
    shape_generations: Rows<'a, u32>,
    shape_used: Rows<'a, u64>,
    pairs: Rows<'a, Pair>,
    contacts: Rows<'a, ContactRow>,
    asleep_pairs: Rows<'a, Pair>,
    asleep_contacts: Rows<'a, ContactRow>,
    dirt: Rows<'a, u8>,
    refined: Rows<'a, u64>,
    loaded: Rows<'a, u64>,
    joints: Rows<'a, JointRow>,
    joint_axes: Rows<'a, [AxisRow; 6]>,
    joint_generations: Rows<'a, u32>,
    joint_used: Rows<'a, u64>,
    first_joints: Rows<'a, u32>,
    materials: Rows<'a, MaterialRow>,
    pair_rules: Rows<'a, PairRule>,
    events: Rows<'a, EventRow>,
    tenants: Rows<'a, Tenant>,
    visits: Rows<'a, Visit>,
    news: Rows<'a, BodyNews>,
}

/// What rows may refer to.
struct Limits<'a> {
    bodies: u32,
    shapes: u32,
    joints: u32,
    hulls: u32,
    meshes: u32,
    height_fields: u32,
    compounds: u32,
    /// The assets, by which settled contacts are checked.
    tables: AssetTables<'a>,
}

type Checked = Result<(), SnapshotError>;

fn require(holds: bool, section: &'static str, index: u32) -> Checked {
    if holds { Ok(()) } else { Err(SnapshotError::Invalid { section, index }) }
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Takes a snapshot from anywhere. Every row is checked; the state becomes exactly the snapshot's, or stays.
    ///
    /// A state that is accepted steps without panic. It need not be one that a game can reach.
    ///
    /// # Errors
    /// A [`SnapshotError`]; the world is unchanged.
    pub fn load(&mut self, snapshot: &[u8]) -> Result<(), Error> {
        let header = self.check_header(snapshot)?;
        check_content(snapshot)?;
        let sections: [Section; _] = self.sections_for(&header);
        let [
            _,
            motions,
            bodies,
            body_generations,
            body_used,
            shapes,
            shape_generations,
            shape_used,
            pairs,
            contacts,
            asleep_pairs,
            asleep_contacts,
            _,
            dirt,
            refined,
            loaded,
            joints,
            joint_axes,
            joint_generations,
            joint_used,
            first_joints,
            materials,
            pair_rules,
            events,
            tenants,
            visits,
            news,
        ] = parts(snapshot, &sections);
        let parts = Parts {
            header,
            motions: Rows::new(motions),
            bodies: Rows::new(bodies),
            body_generations: Rows::new(body_generations),
            body_used: Rows::new(body_used),
            shapes: Rows::new(shapes),
            shape_generations: Rows::new(shape_generations),
            shape_used: Rows::new(shape_used),
            pairs: Rows::new(pairs),
            contacts: Rows::new(contacts),
            asleep_pairs: Rows::new(asleep_pairs),
            asleep_contacts: Rows::new(asleep_contacts),
            dirt: Rows::new(dirt),
            refined: Rows::new(refined),
            loaded: Rows::new(loaded),
            joints: Rows::new(joints),
            joint_axes: Rows::new(joint_axes),
            joint_generations: Rows::new(joint_generations),
            joint_used: Rows::new(joint_used),
            first_joints: Rows::new(first_joints),
            materials: Rows::new(materials),
            pair_rules: Rows::new(pair_rules),
            events: Rows::new(events),
            tenants: Rows::new(tenants),
            visits: Rows::new(visits),
            news: Rows::new(news),
        };
        let assets = self.layout.assets.header.of(self.bytes())[0];
        let limits = Limits {
            bodies: self.capacities.bodies,
            shapes: self.capacities.shapes,
            joints: self.capacities.joints,
            hulls: assets.hulls,
            meshes: assets.meshes,
            height_fields: assets.height_fields,
            compounds: assets.compounds,
            tables: self.asset_tables(),
        };
        parts.check(&limits)?;
        self.copy_in(snapshot, &header, &Done::NONE);
        self.drop_caches();
        Ok(())
    }
}

impl Parts<'_> {
    fn check(&self, limits: &Limits<'_>) -> Checked {
        let header = &self.header;
        let settings = header.settings.read().is_some();
        let counters = header.step < COUNTER_MAX && header.static_version < COUNTER_MAX;
        require(
            settings && counters && header.refine <= SUBSTEPS_MAX && header.pairs_stale <= 3,
            "header",
            0,
        )?;
        check_pool(&header.bodies, &self.body_used, &self.body_generations, limits.bodies, "body_used")?;
        check_pool(&header.shapes, &self.shape_used, &self.shape_generations, limits.shapes, "shape_used")?;
        for slot in 0..header.bodies.high {
            require(self.body_holds(slot), "bodies", slot)?;
        }
        for slot in 0..header.shapes.high {
            require(self.shape_holds(slot, limits), "shapes", slot)?;
        }
        self.check_refined()?;
        self.check_materials()?;
        self.check_lists()?;
        self.check_pairs()?;
        self.check_contacts(&limits.tables)?;
        self.check_sleep(&limits.tables)?;
        self.check_joints(limits)?;
        self.check_events()
    }

    /// Bits of bodies alone, and none where the header says that there are none. There may be none all the same:
    /// refined bodies were removed.
    fn check_refined(&self) -> Checked {
        let mut any = false;
        for word in 0..crate::pool::words(self.header.bodies.high as usize) as u32 {
            let bits = self.refined.get(word);
            require(bits & !self.body_used.get(word) == 0, "refined", word)?;
            require(self.loaded.get(word) & !self.body_used.get(word) == 0, "loaded", word)?;
            any |= bits != 0;
        }
        require(!any || self.header.refine != 0, "refined", 0)
    }

    fn body_is_used(&self, slot: u32) -> bool {
        slot < self.header.bodies.high && self.body_used.get(slot / 64) >> (slot % 64) & 1 == 1
    }

    fn shape_is_used(&self, slot: u32) -> bool {
        slot < self.header.shapes.high && self.shape_used.get(slot / 64) >> (slot % 64) & 1 == 1
    }

    fn body_holds(&self, slot: u32) -> bool {
        let (row, motion) = (self.bodies.get(slot), self.motions.get(slot));
        if !self.body_is_used(slot) {
            return is_zero(&row) && is_zero(&motion) && self.dirt.get(slot) == 0;
        }
        let is_static = row.kind() == BodyKind::Static;
        let still = motion.linear == Vec3::ZERO && motion.angular == Vec3::ZERO;
        let inside = |p: &crate::body::Position| {
            p.sector.iter().all(|s| s.unsigned_abs() <= SECTOR_MAX as u32)
                && validate::vector_within("", p.offset, SECTOR_REACH).is_ok()
        };
        // Every bit of the flags means something.
        row.flags & body::KIND_MASK <= BodyKind::Dynamic as u32
            && inside(&motion.center)
            && is_rotation(motion.rotation)
            // Speeds are capped when they are integrated, not when they are left: a light body may be left with
            // any.
            && motion.linear.is_finite()
            && motion.angular.is_finite()
            && (!is_static || still)
            && body::check_mass(&row.mass_properties()).is_ok()
            && Rotation::unpack(row.stance).is_some()
            && validate::in_range("", row.linear_damping, 0.0, 1.0e4).is_ok()
            && validate::in_range("", row.angular_damping, 0.0, 1.0e4).is_ok()
            && validate::in_range("", row.gravity_scale, -1.0e3, 1.0e3).is_ok()
            && validate::vector_within("", row.force, 1.0e15).is_ok()
            && validate::vector_within("", row.torque, 1.0e15).is_ok()
    }

    fn shape_holds(&self, slot: u32, limits: &Limits<'_>) -> bool {
        let row = self.shapes.get(slot);
        if !self.shape_is_used(slot) {
            return is_zero(&row);
        }
        let Some(geometry) = row.geometry() else { return false };
        let mut canonical = row;
        canonical.set_geometry(&geometry);
        let known = match geometry {
            Geometry::Hull(hull) => hull.0 < limits.hulls,
            Geometry::Mesh(mesh) => mesh.0 < limits.meshes,
            Geometry::RoundedHull { hull, .. } => hull.0 < limits.hulls,
            Geometry::HeightField(field) => field.0 < limits.height_fields,
            Geometry::Compound(compound) => compound.0 < limits.compounds,
            _ => true,
        };
        let dynamic = self.body_is_used(row.body) && self.bodies.get(row.body).is_dynamic();
        let boxed = row.fat_box.min.is_finite() && row.fat_box.max.is_finite();
        known
            && geometry.check().is_ok()
            && bytemuck::bytes_of(&canonical) == bytemuck::bytes_of(&row)
            && self.body_is_used(row.body)
            && !(row.is_surface() && dynamic)
            && validate::vector_within("", row.pose.position, validate::EXTENT_MAX).is_ok()
            && is_rotation(row.pose.rotation)
            && validate::in_range("", row.density, 0.0, 1.0e9).is_ok()
            && crate::shape::check_material(row.friction, row.restitution).is_ok()
            && row.flags & !shape::FLAGS_ALL & ((1 << MATERIAL_SHIFT) - 1) == 0
            && boxed
    }

    /// Every used shape is in the list of its own body, once.
    fn check_lists(&self) -> Checked {
        let mut listed = 0;
        for slot in 0..self.header.bodies.high {
            if !self.body_is_used(slot) {
                continue;
            }
            let mut next = self.bodies.get(slot).first_shape;
            while next != u32::MAX {
                // A list that runs in a circle, or into another, counts more shapes than there are.
                listed += 1;
                let holds = self.shape_is_used(next)
                    && self.shapes.get(next).body == slot
                    && listed <= self.header.shapes.count;
                require(holds, "bodies", slot)?;
                next = self.shapes.get(next).next;
            }
        }
        require(listed == self.header.shapes.count, "shapes", 0)
    }

    fn check_pairs(&self) -> Checked {
        let mut before = None;
        for (i, pair) in self.pairs.iter().enumerate() {
            let ascends = before.is_none_or(|before| before < pair);
            let known = pair.a < pair.b && pair.b < self.header.shapes.high;
            require(ascends && known && self.may_meet(pair), "pairs", i as u32)?;
            before = Some(pair);
        }
        Ok(())
    }

    /// A pair of shapes that live may have to be collided: it must be one that can be.
    fn may_meet(&self, pair: Pair) -> bool {
        if !self.shape_is_used(pair.a) || !self.shape_is_used(pair.b) {
            // The next step takes such pairs out before anything reads them, if it is told so.
            return self.header.pairs_stale != 0;
        }
        let (a, b) = (self.shapes.get(pair.a), self.shapes.get(pair.b));
        // Shapes that are looked for again are taken out of the pairs before anything reads them.
        let renewed = (a.flags | b.flags) & BOX_STALE != 0;
        renewed || self.can_meet(pair)
    }

    /// True when two shapes that live can make contacts at all.
    fn can_meet(&self, pair: Pair) -> bool {
        let (a, b) = (self.shapes.get(pair.a), self.shapes.get(pair.b));
        let dynamic = |s: &ShapeRow| self.bodies.get(s.body).is_dynamic();
        a.body != b.body
            && (dynamic(&a) || dynamic(&b))
            && !(a.is_surface() && b.is_surface())
            && !(a.is_sensor() || b.is_sensor())
    }

    fn check_contacts(&self, assets: &AssetTables<'_>) -> Checked {
        let mut before = None;
        for (i, row) in self.contacts.iter().enumerate() {
            let ascends = before.is_none_or(|before| before < row.key());
            require(ascends && self.contact_holds(&row, assets), "contacts", i as u32)?;
            before = Some(row.key());
        }
        Ok(())
    }

    fn contact_holds(&self, row: &ContactRow, assets: &AssetTables<'_>) -> bool {
        usize::from(row.tag.phase()) < CELLULAR_PHASES_MAX && self.contact_is_sound(row, assets)
    }

    /// The same for a contact with or without a phase.
    fn contact_is_sound(&self, row: &ContactRow, assets: &AssetTables<'_>) -> bool {
        let impulse = |x: f32| x.is_finite() && x >= 0.0 && x.to_bits() != (-0.0_f32).to_bits();
        let mut canonical = *row;
        if row.can_resist() && self.may_resist(row.pair) {
            canonical.set_resistance(Vec3::ZERO);
        }
        let unused = row.tag.points().min(4)..4;
        row.pair.a < row.pair.b
            && row.pair.b < self.header.shapes.high
            && (1..=4).contains(&row.tag.points())
            && canonical.impulses.iter().all(|&x| impulse(x))
            && canonical.impulses[unused].iter().all(|&x| x == 0.0)
            && self.memory_holds(&canonical, assets)
            && (!row.can_resist() || row.resistance().is_finite())
            && row.friction.is_finite()
            && row.twist.is_finite()
    }

    /// A settled contact has as many points as are found at its base; another one names the features of its points.
    fn memory_holds(&self, row: &ContactRow, assets: &AssetTables<'_>) -> bool {
        if !row.tag.is_settled() {
            return row.memory[row.tag.points()..].iter().all(|&x| x == 0);
        }
        let known = |slot: u32| self.shape_is_used(slot) && self.shapes.get(slot).flags & FRESH == 0;
        if row.tag.child() != 0 || meeting::unpack(&row.memory).is_none() {
            return false;
        }
        if !known(row.pair.a) || !known(row.pair.b) {
            return true;
        }
        let (a, b) = (self.shapes.get(row.pair.a), self.shapes.get(row.pair.b));
        let (a, b) = if meeting::are_in_order(&a, &b) { (a, b) } else { (b, a) };
        meeting::settling_radii((&a, &b), assets).is_some()
            && meeting::memo_again(row, (&a, &b), false, assets).is_some()
    }
}

fn is_zero<T: bytemuck::Pod + Zeroable>(row: &T) -> bool {
    bytemuck::bytes_of(row).iter().all(|&byte| byte == 0)
}

fn is_rotation(q: Rotation) -> bool {
    validate::rotation("", q).is_ok()
}

/// The marks, the occupancy bits and the generations agree.
fn check_pool(
    marks: &Marks,
    used: &Rows<'_, u64>,
    generations: &Rows<'_, u32>,
    capacity: u32,
    section: &'static str,
) -> Checked {
    let count: u32 = used.iter().map(u64::count_ones).sum();
    require(marks.count == count && marks.reserved == 0, section, 0)?;
    let mut first_free = marks.high;
    for slot in (0..words(marks.high as usize) as u32 * 64).rev() {
        let taken = used.get(slot / 64) >> (slot % 64) & 1 == 1;
        require(slot < marks.high || !taken, section, slot)?;
        if slot < marks.high {
            require(generations.get(slot) != 0, section, slot)?;
            first_free = if taken { first_free } else { slot };
        }
    }
    require(marks.high <= capacity && marks.first_free == first_free, section, 0)
}
