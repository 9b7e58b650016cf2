/* A game loop in C: a player's ball among boxes and a door on a hinge, on memory of this program.

   Every frame is saved into a ring. The other player's inputs come late: the game goes back, gives them in their
   frame, and takes the frames again. In the end the world goes to somebody who joins late, and both go on alike.

   cc -std=c11 -Iinclude examples/game.c -lcellstep_c -lpthread -ldl -lm */

#include "cellstep.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { FRAMES = 240, DEPTH = 16, LATE = 7, EVENTS = 256 };

/* Ends the program with the engine's own words when a call fails. */
static void check(CsResult result, const char *what) {
    if (result != CS_RESULT_OK) {
        fprintf(stderr, "%s: code %d: %s\n", what, (int)result, cs_error_message());
        exit(1);
    }
}

static void require(bool holds, const char *what) {
    if (!holds) {
        fprintf(stderr, "this must hold: %s\n", what);
        exit(1);
    }
}

/* Zeroed memory on a border of 64 bytes. */
static void *memory_of(size_t bytes) {
    require(bytes > 0, "the capacities are in range");
    void *memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    require(memory != NULL, "there is memory");
    memset(memory, 0, bytes);
    return memory;
}

static CsVec3 vec(float x, float y, float z) {
    CsVec3 v = {x, y, z};
    return v;
}

static CsBody add(CsWorld *world, uint32_t kind, CsVec3 place, CsGeometry geometry, uint32_t wants) {
    CsBodyDef body_def = cs_body_def(kind, place);
    CsShapeDef shape_def = cs_shape_def(geometry);
    CsBody body;
    CsShape shape;
    shape_def.events = wants;
    check(cs_body_create(world, &body_def, &body), "body");
    check(cs_shape_create(world, body, &shape_def, &shape), "shape");
    return body;
}

typedef struct Game {
    void *memory;
    CsWorld *world;
    CsBody player;
    CsBody door;
    CsJoint hinge;
} Game;

static CsCapacities capacities(void) {
    CsCapacities c = cs_capacities(40);
    c.joints = 4;
    c.events = EVENTS;
    c.hulls = 1;
    return c;
}

/* Everybody who plays makes the same world, asset by asset and body by body. */
static Game start(void) {
    CsCapacities room = capacities();
    size_t bytes = cs_world_bytes(&room);
    Game game;
    memset(&game, 0, sizeof game);
    game.memory = memory_of(bytes);
    check(cs_world_create(&room, game.memory, bytes, &game.world), "world");

    CsSettings settings = cs_settings_default();
    check(cs_settings_apply_preset(&settings, CS_PRESET_ACCURATE), "preset");
    settings.sleep_time = 0.5f;
    settings.moved_list = 1;
    check(cs_world_set_settings(game.world, &settings), "settings");

    CsVec3 wedge[5] = {{-0.5f, -0.5f, 0}, {0.5f, -0.5f, 0}, {0.5f, 0.5f, 0}, {-0.5f, 0.5f, 0}, {0, 0, 0.8f}};
    uint32_t hull;
    check(cs_add_hull(game.world, wedge, 5, &hull), "hull");

    CsBody ground = add(game.world, CS_STATIC, vec(0, 0, 0), cs_half_space(), 0);
    for (int row = 0; row < 5; row++) {
        for (int i = 0; i < 5 - row; i++) {
            CsVec3 place = vec(3, (float)i + 0.5f * (float)row - 2, 0.5f + (float)row);
            add(game.world, CS_DYNAMIC, place, cs_box(vec(0.5f, 0.5f, 0.5f)), CS_WANTS_HITS);
        }
    }
    add(game.world, CS_DYNAMIC, vec(-3, 3, 0.3f), cs_asset(CS_HULL, hull), 0);
    game.player = add(game.world, CS_DYNAMIC, vec(-4, 0, 0.6f), cs_sphere(0.6f), CS_WANTS_CONTACTS | CS_WANTS_HITS);
    game.door = add(game.world, CS_DYNAMIC, vec(0, 4, 1.1f), cs_box(vec(0.5f, 0.05f, 1)), 0);

    /* A hinge turns about the x axis of its frames: a quarter turn about y brings that upright. */
    CsRotation up = {0, -sqrtf(0.5f), 0, sqrtf(0.5f)};
    CsPose on_ground = {{-0.5f, 4, 1.1f}, up}, on_door = {{-0.5f, 0, 0}, up};
    CsJointDef def = cs_joint_hinge(ground, game.door, on_ground, on_door);
    def.axes[3].motion = CS_AXIS_LIMITED;
    def.axes[3].lower = -1.5f;
    def.axes[3].upper = 1.5f;
    check(cs_joint_create(game.world, &def, &game.hinge), "hinge");
    return game;
}

/* What a player does in a frame; `is_known` is 0 for the guess that the other player does nothing. */
static void play(Game *game, uint64_t frame, int is_known) {
    check(cs_body_apply_force(game->world, game->player, vec(60, 0, 0)), "own input");
    if (is_known && frame % 50 == 10) {
        check(cs_body_apply_impulse(game->world, game->player, vec(900, 150, 1200)), "other input");
        check(cs_body_set_angular_velocity(game->world, game->door, vec(0, 0, 2)), "push the door");
    }
    if (is_known && frame == 100) {
        add(game->world, CS_DYNAMIC, vec(3, 0, 9), cs_capsule(0.5f, 0.3f), 0);
    }
}

static uint64_t checksum(const CsWorld *world) {
    uint64_t sum;
    check(cs_world_checksum(world, &sum), "checksum");
    return sum;
}

/* Plays all frames with every input at hand, on this thread or on the threads of a pool. */
static uint64_t play_straight(CsPool *pool) {
    Game game = start();
    for (uint64_t frame = 0; frame < FRAMES; frame++) {
        play(&game, frame, 1);
        check(cs_world_step(game.world, pool, NULL), "step");
    }
    uint64_t sum = checksum(game.world);
    free(game.memory);
    return sum;
}

/* Plays with inputs of the other player that come LATE frames late. */
static Game play_with_rollback(unsigned *hits) {
    Game game = start();
    CsCapacities room = capacities();
    size_t bytes = cs_ring_bytes(&room, DEPTH);
    void *memory = memory_of(bytes);
    CsRing *ring;
    check(cs_ring_create(&room, DEPTH, memory, bytes, &ring), "ring");
    for (uint64_t now = 0; now < FRAMES + LATE; now++) {
        uint64_t known = now < LATE ? 0 : now - LATE + 1;
        if (known > 0) {
            /* One more input is known: back to its frame, and all frames since again. */
            uint64_t step;
            check(cs_ring_restore(ring, game.world, known - 1), "restore");
            check(cs_world_steps(game.world, &step), "steps");
            require(step == known - 1, "the world is back at its frame");
        }
        for (uint64_t frame = known > 0 ? known - 1 : now; frame <= now && frame < FRAMES; frame++) {
            CsReport report;
            check(cs_ring_save(ring, game.world), "save");
            play(&game, frame, frame < known);
            check(cs_world_step(game.world, NULL, &report), "step");
            require(report.dropped == 0 && report.quarantined == 0, "the world has room and stays finite");
            if (frame < known) {
                CsEvent events[EVENTS];
                size_t count;
                check(cs_world_events(game.world, events, EVENTS, &count), "events");
                for (size_t i = 0; i < count; i++) {
                    *hits += events[i].kind == CS_EVENT_CONTACT_HIT && events[i].speed > 1;
                }
            }
        }
    }
    require(cs_ring_restore(ring, game.world, 0) == CS_RESULT_NOT_KEPT, "the first frame is long gone");
    free(memory);
    return game;
}

/* What lies under the player, in front of the player, and around. */
static void look_around(Game *game) {
    CsPosition place;
    CsHit hit;
    CsOverlap overlaps[4];
    CsFound found;
    CsClosest closest;
    uint32_t is_found;
    check(cs_body_position(game->world, game->player, &place), "position");
    CsQueryFilter others = cs_query_filter();
    others.skip = game->player;
    check(cs_cast_ray(game->world, place, vec(0, 0, -100), &others, &hit, &is_found), "ray");
    require(is_found && hit.normal.z > 0, "something is below");
    CsQueryShape ball = {cs_sphere(0.3f), place, {0, 0, 0, 1}};
    ball.position.offset.z += 20;
    check(cs_cast_shape(game->world, &ball, vec(0, 0, -100), NULL, &hit, &is_found), "cast");
    require(is_found && hit.distance < 25, "the ball falls on something");
    check(cs_overlap_box(game->world, place, vec(50, 50, 50), NULL, overlaps, 4, &found), "overlap");
    require(found.count == 4 && found.dropped > 10, "there is more than the buffer holds");
    check(cs_closest_point(game->world, place, 10, &others, &closest, &is_found), "closest");
    require(is_found && closest.distance < 10, "the ground is near");
    CsCoordinates door;
    check(cs_joint_coordinates(game->world, game->hinge, &door), "coordinates");
    require(fabsf(door.values[3]) < 1.6f, "the door stays within its limits");
}

/* Somebody joins: takes the sealed snapshot into a world that has the assets, and goes on like the others. */
static void join_late(Game *game) {
    size_t bytes, written;
    check(cs_world_snapshot_bytes(game->world, &bytes), "size");
    uint8_t *snapshot = memory_of(bytes);
    check(cs_world_save(game->world, snapshot, bytes, &written), "save");
    require(written == bytes, "a snapshot is as long as it was told");
    check(cs_snapshot_seal(snapshot, bytes), "seal");
    Game late = start();
    snapshot[bytes / 2] ^= 1;
    require(cs_world_load(late.world, snapshot, bytes) == CS_RESULT_DAMAGED, "damage is found");
    snapshot[bytes / 2] ^= 1;
    check(cs_world_load(late.world, snapshot, bytes), "load");
    for (int i = 0; i < 60; i++) {
        check(cs_world_step(game->world, NULL, NULL), "step");
        check(cs_world_step(late.world, NULL, NULL), "step");
    }
    require(checksum(game->world) == checksum(late.world), "both go on alike");
    free(late.memory);
    free(snapshot);
}

int main(void) {
    CsPool *pool;
    unsigned hits = 0;
    check(cs_pool_create(2, &pool), "pool");
    uint64_t alone = play_straight(NULL), shared = play_straight(pool);
    require(alone == shared, "one thread and two give the same bits");
    Game game = play_with_rollback(&hits);
    require(checksum(game.world) == alone, "rollback gives the same bits");
    require(hits > 0, "the player has hit something");
    printf("%d frames, each taken %d times: checksum %016llx, %u hits\n", FRAMES, LATE + 1,
           (unsigned long long)alone, hits);
    look_around(&game);
    join_late(&game);
    check(cs_pool_destroy(pool), "end of the pool");
    free(game.memory);
    return 0;
}
