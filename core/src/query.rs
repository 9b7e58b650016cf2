//! Queries: what a ray, a moving shape, a region or a point meets in the world as it is now.
//!
//! ```text
//! World::queries -> Queries      boxes and trees brought to the shapes' poses, then a read-only view
//!   walk.rs    a query on the trees: candidates, filter, exact test (`collide/cast.rs`)
//!   found.rs   the nearest, or all in order as far as the caller's buffer holds
//!   batch.rs   many queries on an executor
//! ```
//! **Order.** What is found is ordered by distance, as it is reported, then by the shape's slot, then by the
//! part of a concave shape. The order is total, so the shape of a tree, the state of a cache and the executor
//! never reach a result.
//!
//! **Precision.** Poses are taken relative to the query's own position, in double precision: a query far from the
//! origin, or of something far away, is as exact as a near one, and a shift of everything by whole sectors changes
//! no bit but the sectors.
//!
//! **Conventions.** Shapes are closed sets: who starts in one, or touches it, meets it at distance 0 with the
//! normal turned against the motion. A half-space is solid below its surface. Meshes and height fields have no
//! inside and two sides: the normal is that of the side from which they are met. A ray in the plane of a triangle
//! passes; one along the face of a convex shape meets it.

mod batch;
mod found;
mod visits;
mod walk;

use crate::body::{BodyKind, BodyRow, Motion, Position};
use crate::collide::tree::Tree;
use crate::error::Error;
use crate::executor::Executor;
use crate::handle::{BodyHandle, ShapeHandle};
use crate::math::{Rotation, Vec3};
use crate::shape::{Filter, Geometry, ShapeRow};
use crate::state::AssetTables;
use crate::validate;

pub use found::Found;

/// Greatest component of a query's way, and greatest distance, metres.
const WAY_MAX: f32 = 1.0e7;

/// A set of kinds of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyKinds(pub u8);

impl BodyKinds {
    /// Static bodies.
    pub const STATIC: Self = Self(1);
    /// Kinematic bodies.
    pub const KINEMATIC: Self = Self(2);
    /// Dynamic bodies.
    pub const DYNAMIC: Self = Self(4);
    /// Kinematic and dynamic bodies.
    pub const MOVING: Self = Self(6);
    /// All bodies.
    pub const ALL: Self = Self(7);

    /// Kinds of both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// True when the kind is in the set.
    pub const fn has(self, kind: BodyKind) -> bool {
        self.0 >> kind as u8 & 1 == 1
    }
}

/// What a query looks for. The default is everything but sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueryFilter {
    /// Finds only shapes whose filter meets this one; `None` asks for no filter.
    pub meets: Option<Filter>,
    /// Does not find the shapes of this body: usually the one that asks. A stale handle names none.
    pub skip: Option<BodyHandle>,
    /// Finds shapes of bodies of these kinds.
    pub kinds: BodyKinds,
    /// Finds sensors, too.
    pub sensors: bool,
}

impl Default for QueryFilter {
    fn default() -> Self {
        Self::ALL
    }
}

impl QueryFilter {
    /// Finds everything but sensors.
    pub const ALL: Self = Self { meets: None, skip: None, kinds: BodyKinds::ALL, sensors: false };
}

/// A ray of some length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Position,
    /// Where it ends, from its origin, metres: not zero, each component at most 1e7 in size.
    pub translation: Vec3,
}

/// A shape with an inside, somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueryShape {
    /// Its geometry: any convex one, or a compound of them, which is asked for child by child.
    pub geometry: Geometry,
    /// Where the shape's origin is.
    pub position: Position,
    /// How it is turned; a unit quaternion within 1e-3.
    pub rotation: Rotation,
}

/// A shape that moves along a line without turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeCast {
    /// The shape where it starts.
    pub shape: QueryShape,
    /// Its way, metres: not zero, each component at most 1e7 in size.
    pub translation: Vec3,
}

/// What overlap is looked for with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// A point. It overlaps solid shapes, and a mesh or height field only where it lies exactly on a triangle.
    Point(Position),
    /// A box along the world's axes.
    Box {
        /// Its middle.
        center: Position,
        /// Half of each edge, metres, 1e-5..=1e5.
        half_extents: Vec3,
    },
    /// A shape.
    Shape(QueryShape),
}

/// A point whose closest points are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Where it is.
    pub position: Position,
    /// How far to look, metres, 0..=1e7.
    pub max_distance: f32,
}

/// Where a ray or a moving shape meets a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hit {
    /// The shape that is met.
    pub shape: ShapeHandle,
    /// Its body.
    pub body: BodyHandle,
    /// Part of a concave shape: the triangle, or the child of a compound; 0 else.
    pub child: u32,
    /// How far the query came, metres.
    pub distance: f32,
    /// The same as a share of its way, 0..=1.
    pub fraction: f32,
    /// The point of contact; the query's own position when it starts inside.
    pub point: Position,
    /// Unit normal of the shape there, against the motion; the direction turned round when it starts inside.
    pub normal: Vec3,
}

/// A shape that overlaps a region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlap {
    /// The shape.
    pub shape: ShapeHandle,
    /// Its body.
    pub body: BodyHandle,
    /// Least part of a concave shape that overlaps: the triangle, or the child of a compound; 0 else.
    pub child: u32,
}

/// The point of a shape that is closest to a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClosestPoint {
    /// The shape.
    pub shape: ShapeHandle,
    /// Its body.
    pub body: BodyHandle,
    /// Part of a concave shape: the triangle, or the child of a compound; 0 else.
    pub child: u32,
    /// Distance of the probe, metres; 0 inside.
    pub distance: f32,
    /// The point; the probe's own place inside.
    pub point: Position,
    /// Unit vector from there to the probe; zero inside.
    pub normal: Vec3,
}

/// A read-only view of a world that answers queries: see [`World::queries`](crate::World::queries).
///
/// The view is `Sync`: many threads can ask at once. Nothing is allocated.
#[derive(Clone, Copy)]
pub struct Queries<'a> {
    pub(crate) assets: AssetTables<'a>,
    pub(crate) motions: &'a [Motion],
    pub(crate) bodies: &'a [BodyRow],
    pub(crate) body_generations: &'a [u32],
    pub(crate) shapes: &'a [ShapeRow],
    pub(crate) shape_generations: &'a [u32],
    /// Of static shapes, and of the others.
    pub(crate) trees: [Tree<'a>; 2],
    /// The trees' sector.
    pub(crate) sector: [i32; 3],
}

impl core::fmt::Debug for Queries<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Queries({} shapes)", self.trees[0].order.len() + self.trees[1].order.len())
    }
}

impl Queries<'_> {
    /// The first thing that a ray meets.
    ///
    /// # Errors
    /// A number is refused; see [`Ray`].
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter) -> Result<Option<Hit>, Error> {
        self.first(ray, filter)
    }

    /// Everything that a ray meets, in order: every convex shape and every child of a compound once, where the ray
    /// enters it, and every triangle of a mesh or height field. What does not fit into `hits` is the farthest, and
    /// counted.
    ///
    /// # Errors
    /// As [`Queries::cast_ray`].
    pub fn cast_ray_all(&self, ray: &Ray, filter: &QueryFilter, hits: &mut [Hit]) -> Result<Found, Error> {
        self.all(ray, filter, hits)
    }

    /// [`Queries::cast_ray`] for many rays: `hits[i]` becomes what `rays[i]` meets, whatever the executor.
    ///
    /// # Errors
    /// [`Error::WrongLength`] when there are not as many hits as rays, or as [`Queries::cast_ray`] for any of them.
    /// Then nothing was written.
    pub fn cast_rays(
        &self,
        rays: &[Ray],
        filter: &QueryFilter,
        hits: &mut [Option<Hit>],
        executor: &mut impl Executor,
    ) -> Result<(), Error> {
        self.batch(rays, filter, hits, executor)
    }

    /// The first thing that a moving shape meets.
    ///
    /// # Errors
    /// A number is refused, see [`ShapeCast`]; [`Error::NotConvex`]; [`Error::Stale`] when the geometry names
    /// no asset.
    pub fn cast_shape(&self, cast: &ShapeCast, filter: &QueryFilter) -> Result<Option<Hit>, Error> {
        self.first(cast, filter)
    }

    /// Everything that a moving shape meets, in order, every shape once: concave ones where they are met first.
    /// What does not fit into `hits` is the farthest, and counted.
    ///
    /// # Errors
    /// As [`Queries::cast_shape`].
    pub fn cast_shape_all(
        &self,
        cast: &ShapeCast,
        filter: &QueryFilter,
        hits: &mut [Hit],
    ) -> Result<Found, Error> {
        self.all(cast, filter, hits)
    }

    /// [`Queries::cast_shape`] for many shapes: `hits[i]` becomes what `casts[i]` meets, whatever the executor.
    ///
    /// # Errors
    /// [`Error::WrongLength`] when there are not as many hits as casts, or as [`Queries::cast_shape`] for any
    /// of them. Then nothing was written.
    pub fn cast_shapes(
        &self,
        casts: &[ShapeCast],
        filter: &QueryFilter,
        hits: &mut [Option<Hit>],
        executor: &mut impl Executor,
    ) -> Result<(), Error> {
        self.batch(casts, filter, hits, executor)
    }

    /// The first shape, by slot, that overlaps a region. Shapes that touch overlap.
    ///
    /// # Errors
    /// A number is refused, see [`Region`]; [`Error::NotConvex`]; [`Error::Stale`] when the geometry names no
    /// asset.
    pub fn overlap(&self, region: &Region, filter: &QueryFilter) -> Result<Option<Overlap>, Error> {
        self.first(region, filter)
    }

    /// Every shape that overlaps a region, by slot. What does not fit into `overlaps` has the highest slots, and is
    /// counted.
    ///
    /// # Errors
    /// As [`Queries::overlap`].
    pub fn overlap_all(
        &self,
        region: &Region,
        filter: &QueryFilter,
        overlaps: &mut [Overlap],
    ) -> Result<Found, Error> {
        self.all(region, filter, overlaps)
    }

    /// [`Queries::overlap`] for many regions, whatever the executor.
    ///
    /// # Errors
    /// [`Error::WrongLength`] when there are not as many overlaps as regions, or as [`Queries::overlap`] for any of
    /// them. Then nothing was written.
    pub fn overlaps(
        &self,
        regions: &[Region],
        filter: &QueryFilter,
        overlaps: &mut [Option<Overlap>],
        executor: &mut impl Executor,
    ) -> Result<(), Error> {
        self.batch(regions, filter, overlaps, executor)
    }

    /// The closest point of any shape to a probe.
    ///
    /// # Errors
    /// A number is refused; see [`Probe`].
    pub fn closest_point(&self, probe: &Probe, filter: &QueryFilter) -> Result<Option<ClosestPoint>, Error> {
        self.first(probe, filter)
    }

    /// The closest point of every shape within the probe's distance, in order. What does not fit into `points`
    /// is the farthest, and counted.
    ///
    /// # Errors
    /// As [`Queries::closest_point`].
    pub fn closest_point_all(
        &self,
        probe: &Probe,
        filter: &QueryFilter,
        points: &mut [ClosestPoint],
    ) -> Result<Found, Error> {
        self.all(probe, filter, points)
    }

    /// [`Queries::closest_point`] for many probes, whatever the executor.
    ///
    /// # Errors
    /// [`Error::WrongLength`] when there are not as many points as probes, or as [`Queries::closest_point`] for
    /// any of them. Then nothing was written.
    pub fn closest_points(
        &self,
        probes: &[Probe],
        filter: &QueryFilter,
        points: &mut [Option<ClosestPoint>],
        executor: &mut impl Executor,
    ) -> Result<(), Error> {
        self.batch(probes, filter, points, executor)
    }
}

/// Refuses a way that is not finite, zero, or too long.
fn check_way(way: Vec3) -> Result<(), Error> {
    validate::vector_within("translation", way, WAY_MAX)?;
    if way == Vec3::ZERO { Err(Error::OutOfRange { name: "translation" }) } else { Ok(()) }
}

impl QueryShape {
    fn check(&self, assets: &AssetTables<'_>) -> Result<(), Error> {
        self.geometry.check()?;
        validate::position("position", &self.position)?;
        validate::rotation("rotation", self.rotation)?;
        if self.geometry.is_surface() {
            return Err(Error::NotConvex);
        }
        match self.geometry {
            Geometry::Hull(hull) | Geometry::RoundedHull { hull, .. } if !assets.has_hull(hull.0) => {
                Err(Error::Stale { what: "hull" })
            }
            Geometry::Compound(compound) if !assets.has_compound(compound.0) => {
                Err(Error::Stale { what: "compound" })
            }
            _ => Ok(()),
        }
    }

    /// As a shape in the state would hold the geometry.
    fn row(&self) -> ShapeRow {
        let mut row: ShapeRow = bytemuck::Zeroable::zeroed();
        row.set_geometry(&self.geometry);
        row
    }
}
