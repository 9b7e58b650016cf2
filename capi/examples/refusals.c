/* What the engine does with bad arguments: a code, a message, and nothing else. */

#include "cellstep.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

/* Expects a code, and a message with a word in it. */
static void expect(CsResult found, CsResult wanted, const char *word, int line) {
    if (found != wanted || (wanted != CS_RESULT_OK && strstr(cs_error_message(), word) == NULL)) {
        fprintf(stderr, "line %d: code %d instead of %d: %s\n", line, (int)found, (int)wanted, cs_error_message());
        failures++;
    }
}

#define EXPECT(call, code, word) expect((call), CS_RESULT_##code, (word), __LINE__)
#define OK(call) expect((call), CS_RESULT_OK, "", __LINE__)

int main(void) {
    CsCapacities room = cs_capacities(2), endless = cs_capacities(UINT32_MAX);
    size_t bytes = cs_world_bytes(&room);
    char *memory = aligned_alloc(64, bytes + 64);
    CsWorld *world = NULL;
    if (memory == NULL) return 1;
    memset(memory, 0xa5, bytes + 64);
    if (cs_error_message()[0] != 0) return 1;

    if (cs_world_bytes(&endless) != 0 || cs_world_bytes(NULL) != 0 || cs_ring_bytes(&endless, 1) != 0) failures++;
    EXPECT(cs_world_create(&endless, memory, bytes, &world), CAPACITY_OUT_OF_RANGE, "bodies");
    EXPECT(cs_world_create(NULL, memory, bytes, &world), NULL_POINTER, "capacities");
    EXPECT(cs_world_create(&room, NULL, bytes, &world), NULL_POINTER, "memory");
    EXPECT(cs_world_create(&room, memory, bytes, NULL), NULL_POINTER, "out");
    EXPECT(cs_world_create(&room, memory + 8, bytes, &world), MISALIGNED, "memory");
    EXPECT(cs_world_create(&room, memory, bytes - 1, &world), MEMORY_TOO_SMALL, "lines");
    OK(cs_world_create(&room, memory, bytes, &world));

    CsVec3 zero = {0, 0, 0};
    CsBody body, other, ghost = {7, 1};
    CsShape shape;
    CsBodyDef def = cs_body_def(CS_DYNAMIC, zero);
    EXPECT(cs_body_create(NULL, &def, &body), NULL_POINTER, "world");
    EXPECT(cs_body_create(world, NULL, &body), NULL_POINTER, "def");
    EXPECT(cs_body_create(world, &def, NULL), NULL_POINTER, "out");
    def.kind = 3;
    EXPECT(cs_body_create(world, &def, &body), UNKNOWN_KIND, "kind");
    def = cs_body_def(CS_DYNAMIC, zero);
    def.linear_velocity.x = NAN;
    EXPECT(cs_body_create(world, &def, &body), NOT_FINITE, "linear_velocity");
    def = cs_body_def(CS_DYNAMIC, zero);
    def.rotation.w = 3;
    EXPECT(cs_body_create(world, &def, &body), NOT_A_ROTATION, "rotation");
    def = cs_body_def(CS_DYNAMIC, zero);
    def.locks = 1000;
    EXPECT(cs_body_create(world, &def, &body), OUT_OF_RANGE, "locks");
    def.locks = 0;
    OK(cs_body_create(world, &def, &body));
    OK(cs_body_create(world, &def, &other));
    EXPECT(cs_body_create(world, &def, &ghost), FULL, "bodies");
    if (ghost.index != 7 || !cs_body_exists(world, body) || cs_body_exists(world, ghost)) failures++;
    EXPECT(cs_body_remove(world, ghost), STALE, "body");
    OK(cs_body_set_kind(world, other, CS_STATIC));
    EXPECT(cs_body_apply_impulse(world, other, zero), WRONG_KIND, "kind");

    CsShapeDef shape_def = cs_shape_def(cs_asset(99, 0));
    EXPECT(cs_shape_create(world, body, &shape_def, &shape), UNKNOWN_KIND, "geometry");
    shape_def = cs_shape_def(cs_asset(CS_HULL, 5));
    EXPECT(cs_shape_create(world, body, &shape_def, &shape), STALE, "hull");
    shape_def = cs_shape_def(cs_sphere(-1));
    EXPECT(cs_shape_create(world, body, &shape_def, &shape), OUT_OF_RANGE, "radius");
    shape_def = cs_shape_def(cs_sphere(1));
    shape_def.traits.friction_mix = 77;
    EXPECT(cs_shape_create(world, body, &shape_def, &shape), UNKNOWN_KIND, "mix");
    shape_def.traits.friction_mix = CS_MIX_UNSET;
    shape_def.sensor = 8;
    EXPECT(cs_shape_create(world, body, &shape_def, &shape), UNKNOWN_KIND, "kinds");
    shape_def.sensor = 0;
    OK(cs_shape_create(world, body, &shape_def, &shape));
    uint32_t asset;
    EXPECT(cs_add_hull(world, NULL, 4, &asset), NULL_POINTER, "points");
    EXPECT(cs_add_hull(world, &zero, 1, &asset), BAD_ASSET, "");
    EXPECT(cs_add_mesh(world, NULL, 0, NULL, 0, &asset), FULL, "meshes");
    EXPECT(cs_add_mesh(world, &zero, SIZE_MAX, NULL, 0, &asset), OUT_OF_RANGE, "vertices");

    CsPose frame = {{0, 0, 0}, {0, 0, 0, 1}};
    CsJointDef joint_def = cs_joint_ball(body, other, frame, frame);
    CsJoint joint;
    EXPECT(cs_joint_create(world, &joint_def, &joint), FULL, "joints");
    joint_def.coupling = 9;
    EXPECT(cs_joint_create(world, &joint_def, &joint), UNKNOWN_KIND, "coupling");

    CsSettings settings = cs_settings_default();
    settings.contact_model = 3;
    EXPECT(cs_world_set_settings(world, &settings), UNKNOWN_KIND, "contact_model");
    EXPECT(cs_settings_apply_preset(&settings, CS_PRESET_FAST), UNKNOWN_KIND, "contact_model");
    settings = cs_settings_default();
    settings.friction_model = 2;
    EXPECT(cs_world_set_settings(world, &settings), UNKNOWN_KIND, "friction_model");
    settings.friction_model = CS_FRICTION_POINTS;
    settings.manifold_drift = 0.006f;
    EXPECT(cs_world_set_settings(world, &settings), OUT_OF_RANGE, "manifold_drift");
    settings = cs_settings_default();
    EXPECT(cs_settings_apply_preset(&settings, 4), UNKNOWN_KIND, "preset");
    EXPECT(cs_settings_apply_preset(NULL, CS_PRESET_FAST), NULL_POINTER, "settings");
    OK(cs_settings_apply_preset(&settings, CS_PRESET_FAST));
    settings.dt = 10;
    EXPECT(cs_world_set_settings(world, &settings), OUT_OF_RANGE, "dt");

    CsPosition origin = {{0, 0, 0}, {0, 0, 0}};
    CsHit hit;
    CsFound found;
    uint32_t is_found;
    EXPECT(cs_cast_ray(world, origin, zero, NULL, &hit, &is_found), OUT_OF_RANGE, "translation");
    EXPECT(cs_cast_ray_all(world, origin, (CsVec3){1, 0, 0}, NULL, NULL, 3, &found), NULL_POINTER, "hits");
    OK(cs_cast_ray_all(world, origin, (CsVec3){1, 0, 0}, NULL, NULL, 0, &found));
    EXPECT(cs_cast_shape(world, NULL, zero, NULL, &hit, &is_found), NULL_POINTER, "shape");

    uint8_t snapshot[16384];
    size_t size;
    memset(snapshot, 0, sizeof snapshot);
    OK(cs_world_snapshot_bytes(world, &size));
    EXPECT(cs_world_save(world, snapshot, size - 1, NULL), BUFFER_TOO_SMALL, "bytes");
    OK(cs_world_save(world, snapshot, sizeof snapshot, NULL));
    EXPECT(cs_world_restore(world, snapshot, size - 1), WRONG_LENGTH, "bytes");
    snapshot[8]++;
    EXPECT(cs_world_restore(world, snapshot, size), OTHER_VERSION, "version");
    snapshot[0]++;
    EXPECT(cs_world_load(world, snapshot, size), NOT_A_SNAPSHOT, "no snapshot");
    EXPECT(cs_world_load(world, NULL, size), NULL_POINTER, "snapshot");
    EXPECT(cs_snapshot_seal(snapshot, 3), WRONG_LENGTH, "bytes");

    CsPool *pool;
    EXPECT(cs_pool_create(0, &pool), SYSTEM, "");
    OK(cs_pool_destroy(NULL));
    EXPECT(cs_world_step(NULL, NULL, NULL), NULL_POINTER, "world");
    OK(cs_world_step(world, NULL, NULL));
    EXPECT(cs_add_hull(world, &zero, 1, &asset), ASSETS_SEALED, "first step");
    free(memory);
    if (failures == 0) printf("all refused\n");
    return failures != 0;
}
