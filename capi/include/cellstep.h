/* cellstep for C: deterministic rigid bodies in three dimensions.

   Made from the crate cellstep-capi by cbindgen; do not edit. Metres, kilograms, seconds, radians; z is up.
   Link with -lcellstep_c, and for the static library with -lpthread -ldl -lm.

   What you promise: a pointer is null, or points to as many valid, aligned things of its type as its function says,
   which nobody else uses during the call. Memory that is read is initialised, also that handed over for worlds,
   rings and snapshots (calloc, memset and static memory are). A world, a ring or a pool is used by one thread at a
   time. Null where it is not allowed gives CS_RESULT_NULL_POINTER.

   What you get: a code, and after an error a message. A call that fails changes nothing. Worlds and rings lie in
   memory that you own, and the engine takes no other but for pools, for assets while they are registered and for
   queries with room for more than 64 things. */

#ifndef CELLSTEP_H
#define CELLSTEP_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

// A body that never moves.
#define CS_STATIC 0

// A body that moves as told; pushes, is not pushed.
#define CS_KINEMATIC 1

// A body that moves by forces and contacts.
#define CS_DYNAMIC 2

// Static bodies, in sets of kinds.
#define CS_STATIC_BIT 1

// Kinematic bodies, in sets of kinds.
#define CS_KINEMATIC_BIT 2

// Dynamic bodies, in sets of kinds.
#define CS_DYNAMIC_BIT 4

// All kinds of bodies.
#define CS_ALL_BITS 7

// Contacts are damped springs.
#define CS_CONTACT_SOFT 0

// Contacts have no softness.
#define CS_CONTACT_RIGID 1

// Contacts that carry rigidly, and whose overlap is moved away.
#define CS_CONTACT_SPLIT 2

// Friction is that of the patch of a contact.
#define CS_FRICTION_PATCH 0

// Each point of a contact has a cone of friction.
#define CS_FRICTION_POINTS 1

// The dial between speed and accuracy: for what is looked at from afar.
#define CS_PRESET_FAST 0

// The default.
#define CS_PRESET_BALANCED 1

// Twice the substeps: everything sinks a quarter as far, and heavier bodies stand on light ones.
#define CS_PRESET_ACCURATE 2

// For reference and for the tallest stacks.
#define CS_PRESET_EXACT 3

// `size` x: radius.
#define CS_SPHERE 0

// `size` x: radius, y: half the height of the segment along z.
#define CS_CAPSULE 1

// `size`: half of each edge.
#define CS_BOX 2

// `asset`: a hull.
#define CS_HULL 3

// Everything below the plane z = 0.
#define CS_HALF_SPACE 4

// `asset`: a mesh.
#define CS_MESH 5

// `size` x: radius, y: half the height along z.
#define CS_CYLINDER 6

// `size` x: radius of the base, y: half the height along z.
#define CS_CONE 7

// `asset`: a hull; `size` x: the radius by which it is larger.
#define CS_ROUNDED_HULL 8

// `asset`: a height field.
#define CS_HEIGHT_FIELD 9

// `asset`: a compound.
#define CS_COMPOUND 10

// What the other shape says; else the geometric mean of frictions and the greater restitution.
#define CS_MIX_UNSET 0

// The root of the product.
#define CS_MIX_GEOMETRIC_MEAN 1

// Half the sum.
#define CS_MIX_MEAN 2

// The lesser one.
#define CS_MIX_MIN 3

// The product.
#define CS_MIX_MULTIPLY 4

// The greater one.
#define CS_MIX_MAX 5

// Contacts of the shape that begin or end are told.
#define CS_WANTS_CONTACTS 1

// Hits of the shape are told.
#define CS_WANTS_HITS 2

// No spring.
#define CS_SPRING_NONE 0

// `first`: Hz, `second`: damping ratio.
#define CS_SPRING_FREQUENCY 1

// `first`: stiffness, N/m or N m/rad, `second`: damping, N s/m or N m s/rad.
#define CS_SPRING_STIFFNESS 2

// An axis that goes anywhere.
#define CS_AXIS_FREE 0

// An axis that does not move.
#define CS_AXIS_LOCKED 1

// An axis that moves between `lower` and `upper`.
#define CS_AXIS_LIMITED 2

// The six coordinates are where B's frame stands in A's: shifts along A's x, y, z and turns about B's x, the axis
// between, A's z.
#define CS_COUPLING_FRAMES 0

// Axis 0 is the distance of the frames' origins; no other is used.
#define CS_COUPLING_DISTANCE 1

// A's turn about its frame's x plus `ratio` times B's stays as it is.
#define CS_COUPLING_GEAR 2

// `ratio` times A's turn about its frame's x goes with B's shift along its frame's x.
#define CS_COUPLING_RACK 3

// Contacts that began or ended, in `CsSettings::events`.
#define CS_TELL_CONTACTS 1

// Hits.
#define CS_TELL_HITS 2

// Visits to sensors.
#define CS_TELL_SENSORS 4

// Joints that broke.
#define CS_TELL_JOINTS 8

// Bodies that fell asleep or woke.
#define CS_TELL_SLEEP 16

// Bodies that were quarantined.
#define CS_TELL_QUARANTINE 32

// `bodies[0]` woke.
#define CS_EVENT_WOKE 1

// Two shapes have no contact any more.
#define CS_EVENT_CONTACT_ENDED 2

// Two shapes have a contact.
#define CS_EVENT_CONTACT_BEGAN 3

// Two shapes met fast.
#define CS_EVENT_CONTACT_HIT 4

// `joint` broke.
#define CS_EVENT_JOINT_BROKEN 5

// `bodies[0]` was no longer finite and was stopped for good.
#define CS_EVENT_QUARANTINED 6

// `shapes[1]` left the sensor `shapes[0]`.
#define CS_EVENT_SENSOR_ENDED 7

// `shapes[1]` came into the sensor `shapes[0]`.
#define CS_EVENT_SENSOR_BEGAN 8

// `bodies[0]` fell asleep.
#define CS_EVENT_SLEPT 9

// What came of a call. After anything but `CS_RESULT_OK` the world is unchanged, and `cs_error_message` says more.
typedef enum {
  // Done.
  CS_RESULT_OK = 0,
  // A pointer that must not be null is null.
  CS_RESULT_NULL_POINTER = 1,
  // Memory does not start where its type must: 64 bytes for worlds and rings.
  CS_RESULT_MISALIGNED = 2,
  // The memory is too small.
  CS_RESULT_MEMORY_TOO_SMALL = 3,
  // A capacity, or the depth of a ring, is out of its range.
  CS_RESULT_CAPACITY_OUT_OF_RANGE = 4,
  // A pool is full.
  CS_RESULT_FULL = 5,
  // A number is not finite.
  CS_RESULT_NOT_FINITE = 6,
  // A number is out of its range.
  CS_RESULT_OUT_OF_RANGE = 7,
  // A rotation is not a unit quaternion within 1e-3.
  CS_RESULT_NOT_A_ROTATION = 8,
  // A handle names nothing that exists now.
  CS_RESULT_STALE = 9,
  // The body's kind does not allow this.
  CS_RESULT_WRONG_KIND = 10,
  // A query takes shapes with an inside only.
  CS_RESULT_NOT_CONVEX = 11,
  // An array or a buffer has another length than is needed.
  CS_RESULT_WRONG_LENGTH = 12,
  // Assets are registered before the first step only.
  CS_RESULT_ASSETS_SEALED = 13,
  // Points, triangles, heights or children make no asset.
  CS_RESULT_BAD_ASSET = 14,
  // A kind is none of its constants.
  CS_RESULT_UNKNOWN_KIND = 15,
  // The buffer is too small for the snapshot.
  CS_RESULT_BUFFER_TOO_SMALL = 16,
  // The bytes are no snapshot.
  CS_RESULT_NOT_A_SNAPSHOT = 17,
  // The snapshot is of another behaviour version.
  CS_RESULT_OTHER_VERSION = 18,
  // The snapshot is of a world with other capacities.
  CS_RESULT_OTHER_CAPACITIES = 19,
  // The snapshot is of a world with other assets.
  CS_RESULT_OTHER_ASSETS = 20,
  // The snapshot is damaged, or a row of it breaks a rule.
  CS_RESULT_DAMAGED = 21,
  // The ring has no snapshot of this step.
  CS_RESULT_NOT_KEPT = 22,
  // The system gives no threads.
  CS_RESULT_SYSTEM = 23,
  // A bug of the engine. The world is not to be used any more.
  CS_RESULT_PANICKED = 24,
  // Another error: see the message.
  CS_RESULT_OTHER = 25,
} CsResult;

// Threads that share the work of a step.
typedef struct CsPool CsPool;

// The last snapshots of a world. It lies at the start of the memory that was handed over.
typedef struct CsRing CsRing;

// A world. It lies at the start of the memory that was handed over: there is nothing to destroy, the memory is
// given back when the world is not used any more.
typedef struct CsWorld CsWorld;

// How much a world can hold; part of its behaviour.
typedef struct {
  // Bodies.
  uint32_t bodies;
  // Shapes of all bodies.
  uint32_t shapes;
  // Pairs of shapes whose boxes overlap.
  uint32_t pairs;
  // Contacts.
  uint32_t contacts;
  // Joints.
  uint32_t joints;
  // Convex hulls.
  uint32_t hulls;
  // Triangle meshes.
  uint32_t meshes;
  // Vertices of all meshes.
  uint32_t mesh_vertices;
  // Triangles of all meshes.
  uint32_t mesh_triangles;
  // Height fields.
  uint32_t height_fields;
  // Samples of all height fields.
  uint32_t height_samples;
  // Compounds.
  uint32_t compounds;
  // Children of all compounds.
  uint32_t compound_children;
  // Surfaces of all meshes and height fields.
  uint32_t surfaces;
  // Distinct traits of materials.
  uint32_t materials;
  // Pairs with a rule of their own.
  uint32_t pair_rules;
  // Events of a step; 0 for none.
  uint32_t events;
  // Shapes in sensors, each counted once for each sensor; 0 for a world without sensors.
  uint32_t sensor_visits;
} CsCapacities;

// A vector.
typedef struct {
  // Along x.
  float x;
  // Along y.
  float y;
  // Along z.
  float z;
} CsVec3;

// Everything that a step needs beside bodies and shapes.
typedef struct {
  // Length of a step, seconds, 0..=0.25.
  float dt;
  // m/s2.
  CsVec3 gravity;
  // 1..=256.
  uint32_t substeps;
  // Sweeps with position correction per substep, 1..=1024. With a tolerance the least number.
  uint32_t sweeps;
  // Residual at which the sweeps of a substep end, m/s; 0 for as many as `sweeps` says.
  float tolerance;
  // Most sweeps where there is a tolerance, 1..=1024.
  uint32_t sweeps_max;
  // Sweeps without, 0..=1024.
  uint32_t relax_sweeps;
  // Visits of each block in a sweep, 1..=64.
  uint32_t inner_sweeps;
  // 1 to hold joints that hang together at once, 0 to visit each by itself.
  uint32_t direct_joints;
  // `CS_CONTACT_SOFT`, `CS_CONTACT_RIGID` or `CS_CONTACT_SPLIT`.
  uint32_t contact_model;
  // `CS_FRICTION_PATCH` or `CS_FRICTION_POINTS`.
  uint32_t friction_model;
  // How far boxes and hulls may move against each other until their points of contact are found anew, metres,
  // 0..=0.005; 0 for in each step.
  float manifold_drift;
  // Hz; 0 follows the substep rate.
  float contact_frequency;
  // 0..=1000.
  float contact_damping_ratio;
  // Fastest push-out of overlap, m/s.
  float push_speed;
  // How many times the substeps small islands under great load get, 1..=64; 1 for no island.
  uint32_t refine;
  // Most dynamic bodies of such an island, 0..=65535.
  uint32_t refine_bodies;
  // Sink of a soft contact from which on its island is refined, metres.
  float refine_sink;
  // Approach speed below which nothing bounces, m/s.
  float restitution_threshold;
  // Target number of links of a block, 8..=4096.
  uint32_t block_links;
  // Seconds of quiet until an island falls asleep; 0 for never.
  float sleep_time;
  // m/s.
  float sleep_speed;
  // 1 to stop fast bodies at what they would pass.
  uint32_t continuous;
  // Kinds of events that are told, `CS_TELL_*`.
  uint32_t events;
  // Approach speed from which on a contact is a hit, m/s.
  float hit_speed;
  // 1 for steps that note which bodies moved.
  uint32_t moved_list;
  // 1 for steps that measure their residuals.
  uint32_t residual;
} CsSettings;

// The greatest residual of rows, by kind, m/s.
typedef struct {
  // Points of contacts along their normals.
  float normal;
  // Friction of contacts.
  float friction;
  // Joints.
  float joint;
} CsResidual;

// What a step tells.
typedef struct {
  // Steps taken so far.
  uint64_t step;
  // Bodies in the world.
  uint32_t bodies;
  // Bodies that were solved.
  uint32_t active;
  // Of these, bodies that were refined.
  uint32_t refined;
  // Bodies that sleep.
  uint32_t asleep;
  // Pairs of shapes whose boxes overlap.
  uint32_t pairs;
  // Contacts, each of 1 to 4 points.
  uint32_t contacts;
  // Joints in the world.
  uint32_t joints;
  // Pairs and contacts that found no room.
  uint32_t dropped;
  // Bodies that were no longer finite and were stopped for good.
  uint32_t quarantined;
  // Bodies whose speed or spin was capped.
  uint32_t capped;
  // Fast bodies that were stopped on their way.
  uint32_t cut;
  // Joints that broke.
  uint32_t broken;
  // Events of this step.
  uint32_t events;
  // Events that found no room.
  uint32_t dropped_events;
  // Biased sweeps of all substeps.
  uint32_t sweeps;
  // Substeps that ended with more than the tolerance.
  uint32_t unsettled;
  // Residual after the last biased sweep; 0 unless the settings ask for it.
  CsResidual biased;
  // Residual after the last sweep of all.
  CsResidual last;
} CsReport;

// A place in the world: a sector of 64 m and metres from its middle. A zero sector is around the origin; offsets
// beyond 33 m are brought to their sector.
typedef struct {
  // Sector along x, y and z.
  int32_t sector[3];
  // Metres from the middle of the sector.
  CsVec3 offset;
} CsPosition;

// A rotation as a unit quaternion; `w` is the real part.
typedef struct {
  // First imaginary part.
  float x;
  // Second imaginary part.
  float y;
  // Third imaginary part.
  float z;
  // The real part.
  float w;
} CsRotation;

// Mass, center and inertia of a body.
typedef struct {
  // kg.
  float mass;
  // Center of mass in the body's frame, metres.
  CsVec3 center;
  // Principal moments of inertia, kg m2.
  CsVec3 inertia;
  // The frame of the principal axes in the body's frame.
  CsRotation axes;
} CsMassProperties;

// What a new body is like; start from `cs_body_def`.
typedef struct {
  // `CS_STATIC`, `CS_KINEMATIC` or `CS_DYNAMIC`.
  uint32_t kind;
  // Where its origin is.
  CsPosition position;
  // How it is turned; a unit quaternion within 1e-3.
  CsRotation rotation;
  // Of the center of mass, m/s.
  CsVec3 linear_velocity;
  // In the world, rad/s.
  CsVec3 angular_velocity;
  // 1/s.
  float linear_damping;
  // 1/s.
  float angular_damping;
  // Factor on gravity.
  float gravity_scale;
  // World axes along which it does not move (1, 2, 4) or turn (8, 16, 32).
  uint32_t locks;
  // 1 to take `mass`, 0 for that of the shapes' densities.
  uint32_t has_mass;
  // Taken with `has_mass`.
  CsMassProperties mass;
  // 0 for a body that never falls asleep.
  uint32_t can_sleep;
  // 1 for a body that does not pass through dynamic bodies either, fast as it may be.
  uint32_t bullet;
  // Yours; part of the state.
  uint64_t user;
} CsBodyDef;

// Names a body. Goes stale when the body is removed; exact again after a restore to a time when it existed.
typedef struct {
  // Slot in the pool.
  uint32_t index;
  // Which tenant of the slot; 0 is never one.
  uint32_t generation;
} CsBody;

// A geometry in its own frame, metres.
typedef struct {
  // `CS_SPHERE` to `CS_COMPOUND`.
  uint32_t kind;
  // By kind; what is not used is left alone.
  CsVec3 size;
  // Number of the asset, as its function told.
  uint32_t asset;
} CsGeometry;

// Where one frame stands in another.
typedef struct {
  // Where the origin is, metres.
  CsVec3 position;
  // How the frame is turned.
  CsRotation rotation;
} CsPose;

// What a surface does beyond friction and restitution. All zero for nothing.
typedef struct {
  // `CS_MIX_*`.
  uint32_t friction_mix;
  // `CS_MIX_*`.
  uint32_t restitution_mix;
  // Length of the resistance to rolling, metres.
  float rolling;
  // Length of the resistance to spinning, metres.
  float spinning;
  // Velocity of the surface in the shape's frame, m/s.
  CsVec3 surface_velocity;
  // Direction in the shape's frame to which it is solid; zero for all.
  CsVec3 one_way;
} CsTraits;

// Which shapes meet: those of the same positive group always, of the same negative one never, others when each
// one's category is in the other's mask.
typedef struct {
  // Bits of what this shape is.
  uint32_t category;
  // Bits of what it meets.
  uint32_t mask;
  // See the type.
  int32_t group;
} CsFilter;

// What a new shape is like; start from `cs_shape_def`.
typedef struct {
  // Its geometry.
  CsGeometry geometry;
  // Where it stands in the body's frame.
  CsPose pose;
  // kg/m3; 0 adds no mass.
  float density;
  // Coefficient of friction.
  float friction;
  // Share of the approach speed that comes back, 0..=1.
  float restitution;
  // What its surface does beside.
  CsTraits traits;
  // Which shapes it meets.
  CsFilter filter;
  // For a sensor the kinds of bodies that it detects, `CS_*_BIT`; 0 for a shape that makes contacts.
  uint32_t sensor;
  // `CS_WANTS_*`.
  uint32_t events;
  // Yours; part of the state.
  uint64_t user;
} CsShapeDef;

// Names a shape of a body.
typedef struct {
  // Slot in the pool.
  uint32_t index;
  // Which tenant of the slot; 0 is never one.
  uint32_t generation;
} CsShape;

// A part of a compound.
typedef struct {
  // Its geometry.
  CsGeometry geometry;
  // Where it stands in the compound's frame.
  CsPose pose;
} CsChild;

// A spring with its damper, or none.
typedef struct {
  // `CS_SPRING_*`.
  uint32_t kind;
  // By `kind`.
  float first;
  // By `kind`.
  float second;
} CsSpring;

// One coordinate of a joint: a shift in metres or a turn in radians. All zero for a free one.
typedef struct {
  // `CS_AXIS_*`.
  uint32_t motion;
  // Least, metres or radians; `-INFINITY` for no limit on that side.
  float lower;
  // Greatest, metres or radians; `INFINITY` for no limit on that side.
  float upper;
  // How a limit gives.
  CsSpring limit_spring;
  // 1 when it is driven.
  uint32_t has_drive;
  // Where the drive's spring rests.
  float target;
  // Speed that the drive wants.
  float velocity;
  // Without one the drive holds the velocity.
  CsSpring drive_spring;
  // Greatest force or torque of the drive, N or N m; `INFINITY` for no bound.
  float max_force;
  // Force or torque of dry friction.
  float friction;
} CsAxis;

// What a new joint is like; start from `cs_joint_ball`, `cs_joint_hinge` and their like.
typedef struct {
  // A and B.
  CsBody bodies[2];
  // The joint's frame on each body.
  CsPose frames[2];
  // `CS_COUPLING_*`.
  uint32_t coupling;
  // Of a gear or a rack.
  float ratio;
  // Shifts along x, y, z and turns about x, y, z.
  CsAxis axes[6];
  // Greatest angle between the x axes of the frames, radians; 0 for any.
  float cone;
  // How locked axes give; none for a rigid joint.
  CsSpring spring;
  // N; `INFINITY` for never.
  float break_force;
  // N m; `INFINITY` for never.
  float break_torque;
  // 1 when shapes of the two bodies meet all the same.
  uint32_t bodies_collide;
  // Yours; part of the state.
  uint64_t user;
} CsJointDef;

// Names a joint.
typedef struct {
  // Slot in the pool.
  uint32_t index;
  // Which tenant of the slot; 0 is never one.
  uint32_t generation;
} CsJoint;

// The coordinates of a joint: shifts along x, y, z, metres, and turns about x, y, z, radians.
typedef struct {
  // By axis.
  float values[6];
} CsCoordinates;

// What a query looks for; start from `cs_query_filter`.
typedef struct {
  // 1 to find only shapes whose filter meets `meets`.
  uint32_t has_meets;
  // Taken with `has_meets`.
  CsFilter meets;
  // The shapes of this body are not found; zeros for none.
  CsBody skip;
  // Shapes of bodies of these kinds, `CS_*_BIT`.
  uint32_t kinds;
  // 1 to find sensors, too.
  uint32_t sensors;
} CsQueryFilter;

// Where a ray or a moving shape meets a shape.
typedef struct {
  // The shape.
  CsShape shape;
  // The body.
  CsBody body;
  // The triangle of a mesh, the child of a compound; 0 else.
  uint32_t child;
  // How far the query came, metres.
  float distance;
  // The same as a share of its way.
  float fraction;
  // Where they meet; the start when it starts inside.
  CsPosition point;
  // Unit normal of the shape there.
  CsVec3 normal;
} CsHit;

// How much a query found.
typedef struct {
  // Entries at the front of the buffer, in order.
  size_t count;
  // What found no room: all of it comes after the last entry.
  size_t dropped;
} CsFound;

// A shape with an inside, somewhere.
typedef struct {
  // Its geometry.
  CsGeometry geometry;
  // Where its origin is.
  CsPosition position;
  // How it is turned; a unit quaternion within 1e-3.
  CsRotation rotation;
} CsQueryShape;

// A shape that overlaps a region.
typedef struct {
  // The shape.
  CsShape shape;
  // The body.
  CsBody body;
  // The triangle of a mesh, the child of a compound; 0 else.
  uint32_t child;
} CsOverlap;

// The point of a shape that is closest to a place.
typedef struct {
  // The shape.
  CsShape shape;
  // The body.
  CsBody body;
  // The triangle of a mesh, the child of a compound; 0 else.
  uint32_t child;
  // Metres; 0 inside.
  float distance;
  // The point; the place itself inside.
  CsPosition point;
  // Unit vector from there to the place; zero inside.
  CsVec3 normal;
} CsClosest;

// Something that happened in a step. What its kind does not name is zero.
typedef struct {
  // What `cs_world_steps` was after it.
  uint64_t step;
  // `CS_EVENT_*`; 0 for one that this version does not know.
  uint32_t kind;
  // The shapes.
  CsShape shapes[2];
  // The bodies.
  CsBody bodies[2];
  // The joint that broke.
  CsJoint joint;
  // Of a hit: the point that approached fastest.
  CsPosition point;
  // Of a hit: from the first shape to the second.
  CsVec3 normal;
  // Of a hit: m/s.
  float speed;
  // Of a hit: normal impulse in the whole step, N s.
  float impulse;
  // That the broken joint carried, N.
  float force;
  // That the broken joint carried, N m.
  float torque;
} CsEvent;

// A body that moved in the last step.
typedef struct {
  // The body.
  CsBody body;
  // Where its origin is now.
  CsPosition position;
  // How it is turned now.
  CsRotation rotation;
  // 1 when it fell asleep in this step.
  uint32_t fell_asleep;
} CsMoved;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Why the last call of this thread that failed has failed, in English. Ends in a zero byte, and stays until
// another call of this thread fails. Empty when none has.
const char *cs_error_message(void);

// Room for so many bodies of one shape each with 8 pairs and 5 contacts each, no joints, assets and events.
CsCapacities cs_capacities(uint32_t bodies);

// Bytes of memory that `cs_world_create` needs; 0 for capacities that are out of range.
size_t cs_world_bytes(const CsCapacities *capacities);

// Makes an empty world with default settings in `bytes` bytes of memory that start on a border of 64 and are
// initialised, with whatever (`calloc` and static memory are; of a large zeroed block only what is used takes
// room). They belong to the world until it is not used any more.
//
// # Safety
// See the top of the header, and the memory is left alone as long as the world is used.
CsResult cs_world_create(const CsCapacities *capacities, void *memory, size_t bytes, CsWorld **out);

// The settings of a new world.
CsSettings cs_settings_default(void);

// Turns the dial of some settings to a preset, `CS_PRESET_*`: substeps, sweeps and the model of contacts. Fields
// that trade no speed for accuracy (time step, gravity, sleep, events and others) stay. On an error none changes.
CsResult cs_settings_apply_preset(CsSettings *settings,
                                  uint32_t preset);

// The settings.
CsResult cs_world_settings(const CsWorld *world, CsSettings *out);

// Changes the settings. Other gravity wakes all bodies.
CsResult cs_world_set_settings(CsWorld *world, const CsSettings *settings);

// Takes one step, on the threads of a pool or, where `pool` is null, on this one: the result is the same. `report`
// may be null.
CsResult cs_world_step(CsWorld *world,
                       CsPool *pool,
                       CsReport *report);

// Steps taken.
CsResult cs_world_steps(const CsWorld *world, uint64_t *out);

// Hash of the whole state: equal for equal states, on every machine.
CsResult cs_world_checksum(const CsWorld *world, uint64_t *out);

// The deepest overlap of any contact, metres.
CsResult cs_world_penetration_max(CsWorld *world, float *out);

// Starts a pool of so many workers, this thread included. The one thing beside its threads that takes memory of
// its own; given back by `cs_pool_destroy`.
CsResult cs_pool_create(size_t workers,
                        CsPool **out);

// Ends the threads of a pool. Null is left alone.
//
// # Safety
// The pool is from `cs_pool_create`, and is not used any more.
CsResult cs_pool_destroy(CsPool *pool);

// A body of a kind at a place near the origin, metres, with the defaults of all else.
CsBodyDef cs_body_def(uint32_t kind, CsVec3 offset);

// Creates a body.
CsResult cs_body_create(CsWorld *world, const CsBodyDef *def, CsBody *out);

// Removes a body with its shapes and joints.
CsResult cs_body_remove(CsWorld *world, CsBody body);

// True when the handle names a body that exists.
bool cs_body_exists(const CsWorld *world, CsBody body);

// Where the body's origin is.
CsResult cs_body_position(const CsWorld *world, CsBody body, CsPosition *out);

// How the body is turned.
CsResult cs_body_rotation(const CsWorld *world, CsBody body, CsRotation *out);

// Velocity of the center of mass, m/s.
CsResult cs_body_linear_velocity(const CsWorld *world, CsBody body, CsVec3 *out);

// Angular velocity in the world, rad/s.
CsResult cs_body_angular_velocity(const CsWorld *world, CsBody body, CsVec3 *out);

// The number that the body was given.
CsResult cs_body_user(const CsWorld *world, CsBody body, uint64_t *out);

// 1 when the body sleeps, else 0.
CsResult cs_body_is_asleep(const CsWorld *world, CsBody body, uint32_t *out);

// Puts a body somewhere else.
CsResult cs_body_set_pose(CsWorld *world, CsBody body, CsPosition position, CsRotation rotation);

// Sets the velocity of the center of mass, m/s.
CsResult cs_body_set_linear_velocity(CsWorld *world, CsBody body, CsVec3 velocity);

// Sets the angular velocity in the world, rad/s.
CsResult cs_body_set_angular_velocity(CsWorld *world, CsBody body, CsVec3 velocity);

// Tells a kinematic body where to be at the end of the coming step.
CsResult cs_body_set_kinematic_target(CsWorld *world, CsBody body, CsPosition position, CsRotation rotation);

// Changes how a body moves: `CS_STATIC`, `CS_KINEMATIC` or `CS_DYNAMIC`.
CsResult cs_body_set_kind(CsWorld *world, CsBody body, uint32_t kind);

// Gives a body a mass, or with null that of its shapes.
CsResult cs_body_set_mass(CsWorld *world, CsBody body, const CsMassProperties *mass);

// Sets the rates of loss of velocity, 1/s.
CsResult cs_body_set_damping(CsWorld *world, CsBody body, float linear, float angular);

// Sets the factor on gravity.
CsResult cs_body_set_gravity_scale(CsWorld *world, CsBody body, float scale);

// Sets the world axes along which a body does not move (1, 2, 4) or turn (8, 16, 32).
CsResult cs_body_set_locks(CsWorld *world, CsBody body, uint32_t bits);

// Sets the number of a body.
CsResult cs_body_set_user(CsWorld *world, CsBody body, uint64_t user);

// Wakes a body.
CsResult cs_body_wake(CsWorld *world, CsBody body);

// Adds a force on the center of mass in the coming step, N.
CsResult cs_body_apply_force(CsWorld *world, CsBody body, CsVec3 force);

// Adds a force at a place in the coming step, N.
CsResult cs_body_apply_force_at(CsWorld *world, CsBody body, CsVec3 force, CsPosition place);

// Adds a torque in the coming step, N m.
CsResult cs_body_apply_torque(CsWorld *world, CsBody body, CsVec3 torque);

// Pushes the center of mass at once, N s.
CsResult cs_body_apply_impulse(CsWorld *world, CsBody body, CsVec3 impulse);

// Pushes at a place at once, N s.
CsResult cs_body_apply_impulse_at(CsWorld *world, CsBody body, CsVec3 impulse, CsPosition place);

// Turns at once, N m s.
CsResult cs_body_apply_angular_impulse(CsWorld *world, CsBody body, CsVec3 impulse);

// A shape at the body's origin: density 1000 kg/m3, friction 0.6, no restitution, meets everything.
CsShapeDef cs_shape_def(CsGeometry geometry);

// A ball.
CsGeometry cs_sphere(float radius);

// A capsule along z.
CsGeometry cs_capsule(float half_height, float radius);

// A box.
CsGeometry cs_box(CsVec3 half_extents);

// Everything below the plane z = 0 of the shape's frame.
CsGeometry cs_half_space(void);

// A shape of an asset: `kind` is `CS_HULL`, `CS_MESH`, `CS_HEIGHT_FIELD` or `CS_COMPOUND`.
CsGeometry cs_asset(uint32_t kind, uint32_t asset);

// Creates a shape on a body.
CsResult cs_shape_create(CsWorld *world, CsBody body, const CsShapeDef *def, CsShape *out);

// Removes a shape.
CsResult cs_shape_remove(CsWorld *world, CsShape shape);

// True when the handle names a shape that exists.
bool cs_shape_exists(const CsWorld *world, CsShape shape);

// The body of a shape.
CsResult cs_shape_body(const CsWorld *world, CsShape shape, CsBody *out);

// The number that the shape was given.
CsResult cs_shape_user(const CsWorld *world, CsShape shape, uint64_t *out);

// Gives a shape another geometry and place on its body.
CsResult cs_shape_set_geometry(CsWorld *world,
                               CsShape shape,
                               CsGeometry geometry,
                               CsVec3 position,
                               CsRotation rotation);

// Sets the density, kg/m3.
CsResult cs_shape_set_density(CsWorld *world, CsShape shape, float density);

// Sets friction and restitution.
CsResult cs_shape_set_material(CsWorld *world, CsShape shape, float friction, float restitution);

// Sets what the surface does beside.
CsResult cs_shape_set_traits(CsWorld *world, CsShape shape, CsTraits traits);

// Sets which shapes it meets.
CsResult cs_shape_set_filter(CsWorld *world, CsShape shape, CsFilter filter);

// Sets what is told of it, `CS_WANTS_*`.
CsResult cs_shape_set_events(CsWorld *world, CsShape shape, uint32_t events);

// Registers the convex hull of some points.
//
// # Safety
// See the top of the header.
CsResult cs_add_hull(CsWorld *world, const CsVec3 *points, size_t count, uint32_t *out);

// Registers a triangle mesh: three indices of vertices for each triangle.
//
// # Safety
// See the top of the header.
CsResult cs_add_mesh(CsWorld *world,
                     const CsVec3 *vertices,
                     size_t vertex_count,
                     const uint32_t *triangles,
                     size_t triangle_count,
                     uint32_t *out);

// Registers a height field of `columns` x `rows` samples, row by row, `spacing_x` and `spacing_y` metres apart.
// `cells` is null, or has a byte for each cell, row by row: 255 for a hole, else 0.
//
// # Safety
// See the top of the header.
CsResult cs_add_height_field(CsWorld *world,
                             const float *heights,
                             uint32_t columns,
                             uint32_t rows,
                             float spacing_x,
                             float spacing_y,
                             const uint8_t *cells,
                             uint32_t *out);

// Registers a compound of convex children.
//
// # Safety
// See the top of the header.
CsResult cs_add_compound(CsWorld *world, const CsChild *children, size_t count, uint32_t *out);

// All six coordinates are free.
CsJointDef cs_joint_six_axis(CsBody a, CsBody b, CsPose on_a, CsPose on_b);

// A point of one body stays on a point of the other.
CsJointDef cs_joint_ball(CsBody a, CsBody b, CsPose on_a, CsPose on_b);

// B turns about the x axis of the frames: limits and drives go on axis 3.
CsJointDef cs_joint_hinge(CsBody a, CsBody b, CsPose on_a, CsPose on_b);

// B slides along the x axis of A's frame: limits and drives go on axis 0.
CsJointDef cs_joint_slider(CsBody a, CsBody b, CsPose on_a, CsPose on_b);

// The two bodies move as one.
CsJointDef cs_joint_fixed(CsBody a, CsBody b, CsPose on_a, CsPose on_b);

// The frames' origins stay between `lower` and `upper` metres apart.
CsJointDef cs_joint_distance(CsBody a, CsBody b, CsPose on_a, CsPose on_b, float lower, float upper);

// A wheel B on a chassis A: it springs along the z axis of A's frame (axis 2), spins about x (axis 3), and steers
// about z where axis 5 is given another range.
CsJointDef cs_joint_wheel(CsBody a,
                          CsBody b,
                          CsPose on_a,
                          CsPose on_b,
                          CsSpring suspension);

// Creates a joint.
CsResult cs_joint_create(CsWorld *world, const CsJointDef *def, CsJoint *out);

// Removes a joint.
CsResult cs_joint_remove(CsWorld *world, CsJoint joint);

// Makes a joint like another def, with the same bodies.
CsResult cs_joint_set(CsWorld *world, CsJoint joint, const CsJointDef *def);

// Changes one axis, 0..=5.
CsResult cs_joint_set_axis(CsWorld *world, CsJoint joint, uint32_t index, const CsAxis *axis);

// 1 when the joint is broken, else 0.
CsResult cs_joint_is_broken(const CsWorld *world, CsJoint joint, uint32_t *out);

// Force of the joint on B in the last substep, N.
CsResult cs_joint_force(const CsWorld *world, CsJoint joint, CsVec3 *out);

// Torque of the joint on B in the last substep, N m.
CsResult cs_joint_torque(const CsWorld *world, CsJoint joint, CsVec3 *out);

// The six coordinates of a joint.
CsResult cs_joint_coordinates(const CsWorld *world, CsJoint joint, CsCoordinates *out);

// Everything but sensors.
CsQueryFilter cs_query_filter(void);

// The first shape on a ray from `origin` to `origin + way`. `found` becomes 1 and `hit` is written, or `found`
// becomes 0. `filter` may be null.
CsResult cs_cast_ray(CsWorld *world,
                     CsPosition origin,
                     CsVec3 way,
                     const CsQueryFilter *filter,
                     CsHit *hit,
                     uint32_t *found);

// All shapes on a ray by distance, as far as `room_for` of them go.
//
// # Safety
// See the top of the header.
CsResult cs_cast_ray_all(CsWorld *world,
                         CsPosition origin,
                         CsVec3 way,
                         const CsQueryFilter *filter,
                         CsHit *hits,
                         size_t room_for,
                         CsFound *found);

// The first shape that a shape meets on its way, which it goes without turning.
CsResult cs_cast_shape(CsWorld *world,
                       const CsQueryShape *shape,
                       CsVec3 way,
                       const CsQueryFilter *filter,
                       CsHit *hit,
                       uint32_t *found);

// All shapes that a shape meets on its way by distance, as far as `room_for` of them go.
//
// # Safety
// See the top of the header.
CsResult cs_cast_shape_all(CsWorld *world,
                           const CsQueryShape *shape,
                           CsVec3 way,
                           const CsQueryFilter *filter,
                           CsHit *hits,
                           size_t room_for,
                           CsFound *found);

// All shapes that overlap a shape, by slot, as far as `room_for` of them go.
//
// # Safety
// See the top of the header.
CsResult cs_overlap_shape(CsWorld *world,
                          const CsQueryShape *shape,
                          const CsQueryFilter *filter,
                          CsOverlap *overlaps,
                          size_t room_for,
                          CsFound *found);

// All shapes that overlap a box along the world's axes, by slot, as far as `room_for` of them go.
//
// # Safety
// See the top of the header.
CsResult cs_overlap_box(CsWorld *world,
                        CsPosition center,
                        CsVec3 half_extents,
                        const CsQueryFilter *filter,
                        CsOverlap *overlaps,
                        size_t room_for,
                        CsFound *found);

// The point of any shape that is closest to a place, no farther than `max_distance` metres.
CsResult cs_closest_point(CsWorld *world,
                          CsPosition place,
                          float max_distance,
                          const CsQueryFilter *filter,
                          CsClosest *closest,
                          uint32_t *found);

// Writes the events of the last step, as far as `room_for` of them go, and tells how many there are in all.
//
// # Safety
// See the top of the header.
CsResult cs_world_events(const CsWorld *world, CsEvent *events, size_t room_for, size_t *count);

// Writes which bodies moved in the last step, if the settings ask for it, as far as `room_for` of them go, and
// tells how many there are in all.
//
// # Safety
// See the top of the header.
CsResult cs_world_moved(const CsWorld *world,
                        CsMoved *moved,
                        size_t room_for,
                        size_t *count);

// Bytes of a snapshot taken now.
CsResult cs_world_snapshot_bytes(const CsWorld *world, size_t *out);

// Bytes of the largest snapshot of a world with these capacities; 0 for capacities that are out of range.
size_t cs_snapshot_bytes_max(const CsCapacities *capacities);

// Copies the state to a buffer of `bytes` initialised bytes and tells how many were written; `written` may be
// null.
//
// # Safety
// See the top of the header.
CsResult cs_world_save(const CsWorld *world, uint8_t *buffer, size_t bytes, size_t *written);

// Writes the content hash into a snapshot that leaves the process, so that `cs_world_load` finds damage.
//
// # Safety
// See the top of the header.
CsResult cs_snapshot_seal(uint8_t *snapshot, size_t bytes);

// Goes back to a snapshot that this world, or one with the same capacities and assets, has saved. Trusts the
// bytes.
//
// # Safety
// See the top of the header.
CsResult cs_world_restore(CsWorld *world, const uint8_t *snapshot, size_t bytes);

// Takes a snapshot from anywhere: every row is checked.
//
// # Safety
// See the top of the header.
CsResult cs_world_load(CsWorld *world, const uint8_t *snapshot, size_t bytes);

// Bytes of memory for a ring of `depth` snapshots; 0 for capacities that are out of range.
size_t cs_ring_bytes(const CsCapacities *capacities, size_t depth);

// Makes an empty ring in memory as for `cs_world_create`.
//
// # Safety
// See the top of the header, and the memory is left alone as long as the ring is used.
CsResult cs_ring_create(const CsCapacities *capacities,
                        size_t depth,
                        void *memory,
                        size_t bytes,
                        CsRing **out);

// Saves the world at its step, in the place of the oldest snapshot if the ring is full. Snapshots of this step and
// of later ones are forgotten: they are of another future.
CsResult cs_ring_save(CsRing *ring,
                      const CsWorld *world);

// Goes back to the snapshot of a step.
CsResult cs_ring_restore(const CsRing *ring, CsWorld *world, uint64_t step);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CELLSTEP_H */
