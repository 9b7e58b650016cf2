//! A world in a block of memory.

mod assets;
mod bodies;
mod checksum;
mod commands;
mod compounds;
mod contacts;
mod debug;
mod events;
mod fields;
mod forces;
mod height_fields;
mod joints;
mod load;
mod materials;
mod queries;
mod ring;
mod shapes;
mod sleep;
mod snapshot;

use crate::arena::{LINE, Line};
use crate::cells::{Cellular, Scheduler};
use crate::config::{Settings, SettingsRow};
use crate::error::Error;
use crate::executor::Executor;
use crate::observe::Observer;
use crate::pipeline::{self, Regions};
use crate::report::StepReport;
use crate::state::{
    AssetTables, Assets, AssetsLayout, Cache, CacheHeader, CacheLayout, Header, Scratch, ScratchLayout,
    State, StateLayout,
};
use bytemuck::Zeroable;

pub use checksum::hash as xxh64;
pub use compounds::CompoundChild;
pub use contacts::{Contact, ContactPoint, WorldManifold};
pub use height_fields::HeightFieldDef;
pub use ring::SnapshotRing;
pub use snapshot::{SnapshotHeader, SnapshotSection};

/// How much a world can hold. Part of the behaviour: what does not fit is dropped by rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacities {
    /// Bodies, at most 2^22.
    pub bodies: u32,
    /// Shapes of all bodies, at most 2^22.
    pub shapes: u32,
    /// Pairs of shapes whose boxes overlap, at most 2^24.
    pub pairs: u32,
    /// Contacts (manifolds), at most 2^24.
    pub contacts: u32,
    /// Joints, at most 2^22, with four limits, drives and frictions each on average.
    pub joints: u32,
    /// Convex hulls among the assets, at most 2^16.
    pub hulls: u32,
    /// Meshes among the assets, at most 2^16.
    pub meshes: u32,
    /// Vertices of all meshes, at most 2^24.
    pub mesh_vertices: u32,
    /// Triangles of all meshes, at most 2^24.
    pub mesh_triangles: u32,
    /// Height fields among the assets, at most 2^16.
    pub height_fields: u32,
    /// Samples of all height fields, at most 2^24.
    pub height_samples: u32,
    /// Compounds among the assets, at most 2^16.
    pub compounds: u32,
    /// Children of all compounds, at most 2^20.
    pub compound_children: u32,
    /// Surfaces of all meshes and height fields, at most 2^20.
    pub surfaces: u32,
    /// Distinct [`MaterialTraits`](crate::MaterialTraits) of shapes, at most 65535.
    pub materials: u32,
    /// Pairs of shapes with a material of their own and pairs of bodies that ignore each other, at most 2^20.
    pub pair_rules: u32,
    /// Events of a step, at most 2^20; 0 for none: see [`World::events`].
    pub events: u32,
    /// Shapes in sensors, each counted once for each sensor, at most 2^20; 0 for a world without sensors.
    pub sensor_visits: u32,
}

impl Capacities {
    /// Room for `bodies` bodies of one shape each with 8 pairs and 5 contacts each, no joints and no assets.
    pub const fn for_bodies(bodies: u32) -> Self {
        Self {
            bodies,
            shapes: bodies,
            pairs: 64 + 8 * bodies,
            contacts: 32 + 5 * bodies,
            joints: 0,
            hulls: 0,
            meshes: 0,
            mesh_vertices: 0,
            mesh_triangles: 0,
            height_fields: 0,
            height_samples: 0,
            compounds: 0,
            compound_children: 0,
            surfaces: 0,
            materials: 0,
            pair_rules: 0,
            events: 0,
            sensor_visits: 0,
        }
    }

    /// Lines of memory that a world with these capacities needs.
    pub const fn lines(&self) -> usize {
        Layout::new(self).bytes / LINE
    }

    /// Refuses capacities out of the documented ranges. On 32-bit machines the limits are 1/64 of those.
    pub fn check(&self) -> Result<(), Error> {
        let shift = if usize::BITS < 64 { 6 } else { 0 };
        let limits = [
            ("bodies", self.bodies, 1 << 22),
            ("shapes", self.shapes, 1 << 22),
            ("pairs", self.pairs, 1 << 24),
            ("contacts", self.contacts, 1 << 24),
            ("joints", self.joints, 1 << 22),
            ("hulls", self.hulls, 1 << 16),
            ("meshes", self.meshes, 1 << 16),
            ("mesh_vertices", self.mesh_vertices, 1 << 24),
            ("mesh_triangles", self.mesh_triangles, 1_u32 << 24),
            ("height_fields", self.height_fields, 1 << 16),
            ("height_samples", self.height_samples, 1 << 24),
            ("compounds", self.compounds, 1 << 16),
            ("compound_children", self.compound_children, 1 << 20),
            ("surfaces", self.surfaces, 1 << 20),
            ("materials", self.materials, 0xffff << shift),
            ("pair_rules", self.pair_rules, 1 << 20),
            ("events", self.events, 1 << 20),
            ("sensor_visits", self.sensor_visits, 1 << 20),
        ];
        for (name, value, limit) in limits {
            if value > limit >> shift {
                return Err(Error::CapacityOutOfRange { name });
            }
        }
        Ok(())
    }
}

/// Where the regions lie in a world's memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    pub assets: AssetsLayout,
    pub state: StateLayout,
    pub cache: CacheLayout,
    pub scratch: ScratchLayout,
    pub bytes: usize,
}

impl Layout {
    const fn new(c: &Capacities) -> Self {
        let assets = AssetsLayout::new(c);
        let state = StateLayout::new(c);
        let cache = CacheLayout::new(c);
        let scratch = ScratchLayout::new(c);
        let bytes = assets.bytes + state.bytes + cache.bytes + scratch.bytes;
        Self { assets, state, cache, scratch, bytes }
    }
}

/// Bodies, shapes and contacts, in memory that was handed over.
///
/// `M` is anything that gives a slice of [`Line`]s: a `Vec<Line>`, a borrowed `&mut [Line]`, a static behind a safe
/// cell.
#[derive(Debug)]
pub struct World<M> {
    memory: M,
    layout: Layout,
    capacities: Capacities,
    layout_hash: u64,
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// An empty world with default settings.
    ///
    /// # Errors
    /// [`Error::CapacityOutOfRange`], or [`Error::MemoryTooSmall`] when `memory` has fewer lines than
    /// [`Capacities::lines`].
    pub fn new(memory: M, capacities: Capacities) -> Result<Self, Error> {
        capacities.check()?;
        let layout = Layout::new(&capacities);
        let needed = layout.bytes / LINE;
        let mut memory = memory;
        let given = memory.as_mut().len();
        if given < needed {
            return Err(Error::MemoryTooSmall { needed, given });
        }
        let kept = layout.assets.bytes + layout.state.bytes;
        memory.as_mut()[..kept / LINE].fill(Line::ZERO);
        let mut world = Self { memory, layout, capacities, layout_hash: capacities.layout_hash() };
        world.header_mut().settings = SettingsRow::from(&Settings::default());
        world.drop_caches();
        Ok(world)
    }

    /// What the world can hold.
    pub fn capacities(&self) -> &Capacities {
        &self.capacities
    }

    /// The memory back.
    pub fn into_memory(self) -> M {
        self.memory
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.header().step
    }

    /// The settings.
    pub fn settings(&self) -> Settings {
        self.header().settings.read().expect("settings in the state are valid")
    }

    /// Changes the settings. Other gravity wakes all bodies.
    ///
    /// # Errors
    /// A number is not finite or out of the range in [`Settings`]; the world is unchanged.
    pub fn set_settings(&mut self, settings: &Settings) -> Result<(), Error> {
        settings.check()?;
        let pulls = self.settings().gravity != settings.gravity;
        if !settings.moved_list {
            events::forget_moved(&mut self.state_view());
        }
        self.header_mut().settings = SettingsRow::from(settings);
        if pulls {
            sleep::wake_all(&mut self.state_view());
        }
        Ok(())
    }

    /// Takes one step of [`Settings::dt`] seconds. Cannot fail; what could not be done is counted in the report.
    pub fn step(&mut self, executor: &mut impl Executor) -> StepReport {
        self.step_with((executor, &mut ()), None::<&mut Cellular>)
    }

    /// [`World::step`], with somebody who looks at the state after each stage. Steps of no length have no stages.
    pub fn step_observed(
        &mut self,
        executor: &mut impl Executor,
        observer: &mut impl Observer,
    ) -> StepReport {
        self.step_with((executor, observer), None::<&mut Cellular>)
    }

    /// Takes one step with another ordering of the links than the cellular one: for comparing orderings.
    ///
    /// # Panics
    /// When the scheduler breaks the contract of [`Schedule`](crate::cells::Schedule).
    pub fn step_scheduled(
        &mut self,
        executor: &mut impl Executor,
        scheduler: &mut impl Scheduler,
    ) -> StepReport {
        self.step_with((executor, &mut ()), Some(scheduler))
    }

    fn step_with(
        &mut self,
        (executor, observer): (&mut impl Executor, &mut impl Observer),
        scheduler: Option<&mut impl Scheduler>,
    ) -> StepReport {
        let settings = self.settings();
        if cfg!(debug_assertions) {
            // Nothing in the scratch may survive from the step before.
            self.scratch_mut().fill(0xff);
        }
        pipeline::step(&mut self.regions(), &settings, (executor, observer), scheduler)
    }

    /// Forgets everything that is derived from the state. Costs time in the next step, never changes a bit.
    pub fn drop_caches(&mut self) {
        *self.cache_header_mut() = Zeroable::zeroed();
    }

    fn cache_header_mut(&mut self) -> &mut CacheHeader {
        let (start, end) = self.cache_range();
        let span = self.layout.cache.header;
        &mut span.of_mut(&mut bytemuck::cast_slice_mut::<Line, u8>(self.memory.as_mut())[start..end])[0]
    }

    /// All bytes that determine the future, free rows (zeros) included. Equal worlds have equal bytes.
    pub fn state(&self) -> &[u8] {
        let start = self.layout.assets.bytes;
        &self.bytes()[start..start + self.layout.state.bytes]
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self.memory.as_ref())
    }

    fn state_mut(&mut self) -> &mut [u8] {
        let (start, length) = (self.layout.assets.bytes, self.layout.state.bytes);
        &mut bytemuck::cast_slice_mut(self.memory.as_mut())[start..start + length]
    }

    fn scratch_mut(&mut self) -> &mut [u8] {
        let (_, start) = self.cache_range();
        let length = self.layout.scratch.bytes;
        &mut bytemuck::cast_slice_mut(self.memory.as_mut())[start..start + length]
    }

    fn cache_range(&self) -> (usize, usize) {
        let start = self.layout.assets.bytes + self.layout.state.bytes;
        (start, start + self.layout.cache.bytes)
    }

    fn header(&self) -> &Header {
        &self.layout.state.header.of(self.state())[0]
    }

    fn header_mut(&mut self) -> &mut Header {
        let span = self.layout.state.header;
        &mut span.of_mut(self.state_mut())[0]
    }

    fn asset_tables(&self) -> AssetTables<'_> {
        AssetTables::new(&self.layout.assets, &self.bytes()[..self.layout.assets.bytes])
    }

    /// All regions at once; the assets read-only.
    #[inline(always)]
    fn regions(&mut self) -> Regions<'_> {
        let layout = &self.layout;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(self.memory.as_mut());
        let (assets, rest) = bytes.split_at_mut(layout.assets.bytes);
        let (state, rest) = rest.split_at_mut(layout.state.bytes);
        let (cache, rest) = rest.split_at_mut(layout.cache.bytes);
        let state: State<'_> = layout.state.view(state);
        let cache: Cache<'_> = layout.cache.view(cache);
        let scratch: Scratch<'_> = layout.scratch.view(&mut rest[..layout.scratch.bytes]);
        Regions { assets: AssetTables::new(&layout.assets, assets), state, cache, scratch }
    }

    /// The assets, to register more.
    fn assets_mut(&mut self) -> (Assets<'_>, &mut [u8]) {
        let layout = self.layout;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(self.memory.as_mut());
        let (assets, rest) = bytes.split_at_mut(layout.assets.bytes);
        let start = layout.state.bytes + layout.cache.bytes;
        (layout.assets.view(assets), &mut rest[start..start + layout.scratch.bytes])
    }

    /// The state's sections, to change.
    fn state_view(&mut self) -> State<'_> {
        let layout = self.layout.state;
        layout.view(self.state_mut())
    }
}
