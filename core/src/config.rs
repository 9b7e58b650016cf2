//! Settings of a world, and the named constants behind its defaults.

mod preset;

use crate::error::Error;
use crate::event::EventKinds;
use crate::math::{Vec3, sqrt};
use crate::pipeline::layout::TIERS;
use crate::state::{Field, fields};
use crate::validate;
use bytemuck::{Pod, Zeroable};

pub use preset::Preset;

/// Version of the bits: changes whenever the same snapshot and commands would give other states.
pub const BEHAVIOUR_VERSION: u32 = 4;

/// Edge of a sector, metres. A power of two, so that moving by whole sectors changes no bit; 64 keeps the
/// offset's last bit at 4 micrometres.
pub const SECTOR_SIZE: f32 = 64.0;
/// A body changes its sector when its offset exceeds this, metres: half a sector and a little more, so that a
/// body that rests on the border does not flip between two sectors.
pub const SECTOR_REACH: f32 = 33.0;
/// Greatest sector coordinate: 3.4e10 m from the origin. Bodies that leave are quarantined.
pub const SECTOR_MAX: i32 = 1 << 29;

/// Contacts are found up to this distance, metres, so that a body is stopped at a surface and not behind it.
/// Four times the slop of the peers: a resting contact must not vanish by jitter.
pub const SPECULATIVE_DISTANCE: f32 = 0.02;
/// How far points of a contact may drift until they are found anew, metres: a quarter of the speculative distance.
/// Points that are kept were looked for so much farther, so this is also the greatest setting.
pub const MANIFOLD_DRIFT: f32 = SPECULATIVE_DISTANCE / 4.0;
/// Boxes in the broadphase are larger than their shapes by this, metres, so that most steps move none.
pub const BOX_MARGIN: f32 = 0.05;
/// Contact frequency times substep length: 36 Hz at four substeps of 1/60 s. From 0.175 on walls whose bricks touch
/// side by side ring, with 26 mm of creep in a minute; at 0.125, which is common, stacks sink 1.4 times as far.
pub const CONTACT_COUPLING: f32 = 0.15;
/// Damping ratio of soft contacts: far over critical, since a contact must not swing.
pub const CONTACT_DAMPING_RATIO: f32 = 10.0;
/// Contacts with immovable bodies are stiffer by this factor in frequency: there the load is highest. With 2, which
/// is common, what slides on the ground hops at first.
pub const STATIC_STIFFNESS: f32 = 1.6;
/// Fastest push-out of overlap, metres per second: deep overlap must not become an explosion.
pub const PUSH_SPEED: f32 = 3.0;
/// Approach below which nothing bounces, metres per second: about the speed that gravity gives in a few steps.
pub const RESTITUTION_THRESHOLD: f32 = 0.5;
/// Most sweeps of a substep that a tolerance asks for: from rest, stacks of twenty come to 1 mm/s in about as many.
pub const SWEEPS_MAX: u32 = 64;
/// Share of the overlap that a rigid contact (no softness) removes per substep.
pub const RIGID_PUSH: f32 = 0.2;
/// Share of the overlap that a split contact takes back per substep.
pub const SPLIT_PUSH: f32 = 0.2;
/// Overlap that a split contact leaves, metres: without it contacts would end and begin again by jitter.
pub const SPLIT_SLOP: f32 = 2.0e-4;
/// Most substeps of a step.
pub const SUBSTEPS_MAX: u32 = 256;
/// How many times the substeps islands get that are refined: 16 of them hold what the default's four let sink.
pub const REFINE: u32 = 4;
/// Most bodies of an island that is refined.
pub const REFINE_BODIES: u32 = 128;
/// Sink from which on an island is refined, metres: a stack of six.
pub const REFINE_SINK: f32 = 1.0e-3;
/// Steps from one look at the loads to the next.
pub const REFINE_STEPS: u64 = 4;
/// With so many contacts or fewer they are looked at in each step, before a heavy body has sunk.
pub const REFINE_CONTACTS: usize = 1024;
/// Steps from one time that islands are let go to the next: longer, since what becomes stiffer springs up first,
/// and carries nothing for some steps.
pub const COARSEN_STEPS: u64 = 64;
/// Fastest linear motion, metres per second: capped and reported.
pub const LINEAR_SPEED_MAX: f32 = 1.0e6;
/// Largest rotation of a body in one substep, radians: 256 splits of 0.3; faster spin is capped and reported.
pub const TURN_MAX: f32 = 76.8;
/// Speed below which a body is quiet, m/s: a few times what resting contacts jitter.
pub const SLEEP_SPEED: f32 = 0.03;
/// Approach from which on a contact is a hit, metres per second.
pub const HIT_SPEED: f32 = 1.0;
/// Target number of links of a block. With fewer the last phases percolate, with more there are fewer blocks
/// than lanes.
pub const BLOCK_LINKS: u32 = 64;

/// Everything that a step needs beside bodies and shapes. Part of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Length of a step, seconds, in `0..=0.25`. 0 makes steps that change nothing but the step count.
    pub dt: f32,
    /// Acceleration of all dynamic bodies, m/s2; each component at most 1e6 in size.
    pub gravity: Vec3,
    /// Parts of a step that are solved and integrated one after the other, `1..=256`.
    pub substeps: u32,
    /// Sweeps with position correction per substep, `1..=1024`. With a tolerance the least number.
    pub sweeps: u32,
    /// Residual with which the sweeps of a substep may end, m/s, `0..=1e6`: more sweeps follow until the greatest
    /// [`Residual`](crate::Residual) is no more than this, up to `sweeps_max`. 0 for as many as `sweeps` says. The
    /// same on every run and number of workers. Rounding leaves about 1e-7 of the fastest speed.
    pub tolerance: f32,
    /// Most sweeps with position correction per substep where there is a tolerance, `1..=1024`.
    pub sweeps_max: u32,
    /// Sweeps without position correction per substep, `0..=1024`: they take back the velocity that the
    /// correction left.
    pub relax_sweeps: u32,
    /// How often a sweep visits each block before the barrier, `1..=64`: convergence within blocks without more
    /// barriers. The last sweep of a substep visits once, since the seams between blocks come last.
    pub inner_sweeps: u32,
    /// True to hold joints that hang together at once, by one direct solve in each visit: a chain then does not
    /// stretch, however light its links are. False to visit each joint by itself, like a contact: cheaper, and
    /// chains and linkages lag behind by what a sweep leaves, the more the longer they are and the greater their
    /// loads. A joint that hangs alone is the same either way, but for rounding.
    pub direct_joints: bool,
    /// Soft contacts, rigid ones (plain projected Gauss-Seidel), or split ones.
    pub contact_model: ContactModel,
    /// Whether friction is that of the patch of a contact, or of each of its points.
    pub friction_model: FrictionModel,
    /// How far two boxes or hulls may move against each other until their points of contact are found anew, metres,
    /// `0..=`[`MANIFOLD_DRIFT`], and at most a 64th of the smaller one's radius; in a step at most a quarter of it.
    /// Until then the points go with the shapes, and arms with the bodies as they stood, so that what leans by less
    /// than a hundredth of a radian does not feel it: tall stacks need that. 0 finds the points of all contacts
    /// anew in each step.
    pub manifold_drift: f32,
    /// Contact frequency, Hz, in `0..=1e5`; 0 follows the substep rate as [`CONTACT_COUPLING`] per substep.
    pub contact_frequency: f32,
    /// Damping ratio of soft contacts, `0..=1000`.
    pub contact_damping_ratio: f32,
    /// Fastest push-out of overlap, m/s, `0..=1e4`.
    pub push_speed: f32,
    /// Small islands under great load get so many times the substeps, `1..=64`, at most [`SUBSTEPS_MAX`] in all; 1
    /// for no island. What a load is: see `refine_sink`.
    pub refine: u32,
    /// Most dynamic bodies of an island that is refined, `0..=65535`: for what a scene may have many of, the
    /// substeps of all are the dial.
    pub refine_bodies: u32,
    /// An island is refined while it has a contact that soft contacts would let sink by more than this, metres, in
    /// `0..=1e4`; it is let go when all are below half of that. Looked at every [`REFINE_STEPS`] steps (each
    /// step in a world of few contacts), and let go every [`COARSEN_STEPS`].
    pub refine_sink: f32,
    /// Approach speed below which nothing bounces, m/s, `0..=1e4`.
    pub restitution_threshold: f32,
    /// Target number of links of a block, `8..=4096`.
    pub block_links: u32,
    /// Seconds for which all bodies of an island have to be quiet until it falls asleep, `0..=3600`; 0 for never.
    /// Rounded up to whole steps, at most 65535.
    pub sleep_time: f32,
    /// A body is quiet while its mean point, which turns at the radius of gyration, is slower than this, m/s,
    /// `0..=1e4`.
    pub sleep_speed: f32,
    /// True to stop fast bodies at the first surface on their way that contacts may not stop them at, so that they
    /// do not pass through it: dynamic bodies at static and kinematic ones, and those with
    /// [`BodyDef::bullet`](crate::body::BodyDef::bullet) at dynamic ones too. What is slow costs nothing.
    pub continuous: bool,
    /// Which events are told, as far as there is room for them; see [`EventKind`](crate::EventKind).
    pub events: EventKinds,
    /// Approach speed from which on a contact is a hit, m/s, `0..=1e6`.
    pub hit_speed: f32,
    /// Whether steps note which bodies moved: see [`World::moved_bodies`](crate::World::moved_bodies).
    pub moved_list: bool,
    /// Whether steps measure how far their solve is from the answer: see
    /// [`StepReport::residuals`](crate::StepReport::residuals). Costs less than two sweeps for each step, and
    /// changes no bit of the motion.
    pub residual: bool,
}

/// How a contact removes overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactModel {
    /// A damped spring: sinks by the stiffness law, never explodes.
    Soft,
    /// No softness: a share [`RIGID_PUSH`] of the overlap per substep.
    Rigid,
    /// Loads are carried rigidly, so that nothing sinks under them: overlap beyond [`SPLIT_SLOP`] is taken back by
    /// motion that is no velocity, a share [`SPLIT_PUSH`] of it per substep. Only how the points of one contact
    /// share its load gives, like a soft contact. Ten times and more as exact as `Soft` at the same number of
    /// substeps, but it needs about a substep for every five bodies of the tallest stack: with fewer such a stack
    /// starts to rock.
    Split,
}

/// What bounds the friction of a contact of several points. That of one point is the same in both.
///
/// In both it is Coulomb's with a round cone, and friction that holds is the same where it is within its bounds:
/// the models differ in what a contact bears that turns about its normal, and in how loads that are not even count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrictionModel {
    /// All points together: the force along the tangents at their middle within a disc of the coefficient of
    /// friction times the load of all, and the torque about the normal within the same times the points' mean
    /// distance from the middle. Force and torque do not lessen each other, and it does not matter which point
    /// carries the load. The cheapest.
    #[default]
    Patch,
    /// A cone for each point: its force along the tangents is within a disc of the coefficient of friction times
    /// its own load. What turns while it slides is held less, and friction acts where the load is: a body whose
    /// load is at one edge turns about that.
    Points,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dt: 1.0 / 60.0,
            gravity: Vec3::new(0.0, 0.0, -9.81),
            substeps: 4,
            sweeps: 1,
            tolerance: 0.0,
            sweeps_max: SWEEPS_MAX,
            relax_sweeps: 1,
            inner_sweeps: 1,
            direct_joints: true,
            contact_model: ContactModel::Soft,
            friction_model: FrictionModel::Patch,
            manifold_drift: MANIFOLD_DRIFT,
            contact_frequency: 0.0,
            contact_damping_ratio: CONTACT_DAMPING_RATIO,
            push_speed: PUSH_SPEED,
            refine: REFINE,
            refine_bodies: REFINE_BODIES,
            refine_sink: REFINE_SINK,
            restitution_threshold: RESTITUTION_THRESHOLD,
            block_links: BLOCK_LINKS,
            sleep_time: 0.0,
            sleep_speed: SLEEP_SPEED,
            continuous: true,
            events: EventKinds::ALL,
            hit_speed: HIT_SPEED,
            moved_list: false,
            residual: false,
        }
    }
}

impl Settings {
    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        validate::in_range("dt", self.dt, 0.0, 0.25)?;
        validate::vector_within("gravity", self.gravity, 1.0e6)?;
        validate::count_in_range("substeps", self.substeps, 1, SUBSTEPS_MAX)?;
        validate::count_in_range("sweeps", self.sweeps, 1, 1024)?;
        validate::in_range("tolerance", self.tolerance, 0.0, 1.0e6)?;
        validate::count_in_range("sweeps_max", self.sweeps_max, 1, 1024)?;
        validate::count_in_range("relax_sweeps", self.relax_sweeps, 0, 1024)?;
        validate::count_in_range("inner_sweeps", self.inner_sweeps, 1, 64)?;
        validate::in_range("manifold_drift", self.manifold_drift, 0.0, MANIFOLD_DRIFT)?;
        validate::in_range("contact_frequency", self.contact_frequency, 0.0, 1.0e5)?;
        validate::in_range("contact_damping_ratio", self.contact_damping_ratio, 0.0, 1.0e3)?;
        validate::in_range("push_speed", self.push_speed, 0.0, 1.0e4)?;
        validate::count_in_range("refine", self.refine, 1, 64)?;
        validate::count_in_range("refine_bodies", self.refine_bodies, 0, 65_535)?;
        validate::in_range("refine_sink", self.refine_sink, 0.0, 1.0e4)?;
        validate::in_range("restitution_threshold", self.restitution_threshold, 0.0, 1.0e4)?;
        validate::count_in_range("block_links", self.block_links, 8, 4096)?;
        validate::in_range("sleep_time", self.sleep_time, 0.0, 3600.0)?;
        validate::in_range("sleep_speed", self.sleep_speed, 0.0, 1.0e4)?;
        if !EventKinds::ALL.has(self.events) {
            return Err(Error::OutOfRange { name: "events" });
        }
        validate::in_range("hit_speed", self.hit_speed, 0.0, 1.0e6)
    }

    /// Quiet steps after which a body may sleep; `None` for never.
    pub(crate) fn sleep_steps(&self) -> Option<u32> {
        if self.sleep_time == 0.0 || self.dt == 0.0 {
            return None;
        }
        Some(libm::ceilf(crate::math::clamp(self.sleep_time / self.dt, 1.0, 65_535.0)) as u32)
    }

    /// The settings of a tier: bodies that are refined have more substeps, and contacts that are stiffer with them.
    pub(crate) fn of_tier(&self, tier: usize) -> Self {
        if tier == 0 {
            return *self;
        }
        let substeps = (self.substeps * self.refine).min(SUBSTEPS_MAX);
        let times = substeps as f32 / self.substeps as f32;
        // For four times the substeps what had sunk comes up twice as fast, not four times: else it is shot out.
        let contact_damping_ratio = self.contact_damping_ratio * sqrt(times);
        Self { substeps, contact_frequency: self.contact_frequency * times, contact_damping_ratio, ..*self }
    }

    /// The settings of all tiers.
    pub(crate) fn tiers(&self) -> [Self; TIERS] {
        core::array::from_fn(|tier| self.of_tier(tier))
    }

    /// Natural frequency of soft contacts between dynamic bodies, Hz.
    pub(crate) fn frequency(&self) -> f32 {
        if self.contact_frequency > 0.0 { self.contact_frequency } else { CONTACT_COUPLING / self.substep() }
    }

    /// Length of a substep, seconds.
    pub fn substep(&self) -> f32 {
        self.dt / self.substeps as f32
    }
}

/// Bit of the modes: bodies are not stopped on their way.
const NOT_CONTINUOUS: u32 = 1 << 8;
/// Bit of the modes: residuals are measured.
const RESIDUAL: u32 = 1 << 9;
/// Bit of the modes: each point has a cone of friction.
const POINTS: u32 = 1 << 10;
/// Bit of the modes: joints are visited one by one.
const LOOSE_JOINTS: u32 = 1 << 16;

/// [`Settings`] as bytes of the state.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct SettingsRow {
    dt: f32,
    gravity: Vec3,
    substeps: u32,
    sweeps: u32,
    tolerance: f32,
    sweeps_max: u32,
    relax_sweeps: u32,
    inner_sweeps: u32,
    /// The contact model, [`NOT_CONTINUOUS`], [`RESIDUAL`], [`POINTS`] and [`LOOSE_JOINTS`].
    modes: u32,
    manifold_drift: f32,
    contact_frequency: f32,
    contact_damping_ratio: f32,
    push_speed: f32,
    refine: u32,
    refine_bodies: u32,
    refine_sink: f32,
    restitution_threshold: f32,
    block_links: u32,
    sleep_time: f32,
    sleep_speed: f32,
    events: u32,
    hit_speed: f32,
    moved_list: u32,
}

impl SettingsRow {
    /// Names of the fields, for `state/fields.rs`.
    pub const FIELDS: &[Field] = fields!(SettingsRow {
        dt: F32 1,
        gravity: F32 3,
        substeps: U32 1,
        sweeps: U32 1,
        tolerance: F32 1,
        sweeps_max: U32 1,
        relax_sweeps: U32 1,
        inner_sweeps: U32 1,
        modes: U32 1,
        manifold_drift: F32 1,
        contact_frequency: F32 1,
        contact_damping_ratio: F32 1,
        push_speed: F32 1,
        refine: U32 1,
        refine_bodies: U32 1,
        refine_sink: F32 1,
        restitution_threshold: F32 1,
        block_links: U32 1,
        sleep_time: F32 1,
        sleep_speed: F32 1,
        events: U32 1,
        hit_speed: F32 1,
        moved_list: U32 1,
    });
}

impl From<&Settings> for SettingsRow {
    fn from(s: &Settings) -> Self {
        Self {
            dt: s.dt,
            gravity: s.gravity,
            substeps: s.substeps,
            sweeps: s.sweeps,
            tolerance: s.tolerance,
            sweeps_max: s.sweeps_max,
            relax_sweeps: s.relax_sweeps,
            inner_sweeps: s.inner_sweeps,
            modes: s.contact_model as u32
                | if s.continuous { 0 } else { NOT_CONTINUOUS }
                | if s.residual { RESIDUAL } else { 0 }
                | if s.friction_model == FrictionModel::Points { POINTS } else { 0 }
                | if s.direct_joints { 0 } else { LOOSE_JOINTS },
            manifold_drift: s.manifold_drift,
            contact_frequency: s.contact_frequency,
            contact_damping_ratio: s.contact_damping_ratio,
            push_speed: s.push_speed,
            refine: s.refine,
            refine_bodies: s.refine_bodies,
            refine_sink: s.refine_sink,
            restitution_threshold: s.restitution_threshold,
            block_links: s.block_links,
            sleep_time: s.sleep_time,
            sleep_speed: s.sleep_speed,
            events: s.events.0,
            hit_speed: s.hit_speed,
            moved_list: u32::from(s.moved_list),
        }
    }
}

impl SettingsRow {
    /// True when all of these events are told.
    pub(crate) fn tells(&self, kinds: EventKinds) -> bool {
        EventKinds(self.events).has(kinds)
    }

    /// True when each point has a cone of friction.
    pub(crate) fn has_cones(&self) -> bool {
        self.modes & POINTS != 0
    }

    /// True when steps note which bodies moved.
    pub(crate) fn notes_moved(&self) -> bool {
        self.moved_list != 0
    }

    /// The settings; `None` when the row was not made by [`SettingsRow::from`].
    pub(crate) fn read(&self) -> Option<Settings> {
        let contact_model = match self.modes & !(NOT_CONTINUOUS | RESIDUAL | POINTS | LOOSE_JOINTS) {
            0 => ContactModel::Soft,
            1 => ContactModel::Rigid,
            2 => ContactModel::Split,
            _ => return None,
        };
        if self.moved_list > 1 {
            return None;
        }
        let settings = Settings {
            dt: self.dt,
            gravity: self.gravity,
            substeps: self.substeps,
            sweeps: self.sweeps,
            tolerance: self.tolerance,
            sweeps_max: self.sweeps_max,
            relax_sweeps: self.relax_sweeps,
            inner_sweeps: self.inner_sweeps,
            direct_joints: self.modes & LOOSE_JOINTS == 0,
            contact_model,
            friction_model: if self.has_cones() { FrictionModel::Points } else { FrictionModel::Patch },
            manifold_drift: self.manifold_drift,
            contact_frequency: self.contact_frequency,
            contact_damping_ratio: self.contact_damping_ratio,
            push_speed: self.push_speed,
            refine: self.refine,
            refine_bodies: self.refine_bodies,
            refine_sink: self.refine_sink,
            restitution_threshold: self.restitution_threshold,
            block_links: self.block_links,
            sleep_time: self.sleep_time,
            sleep_speed: self.sleep_speed,
            continuous: self.modes & NOT_CONTINUOUS == 0,
            events: EventKinds(self.events),
            hit_speed: self.hit_speed,
            moved_list: self.moved_list != 0,
            residual: self.modes & RESIDUAL != 0,
        };
        settings.check().is_ok().then_some(settings)
    }
}
