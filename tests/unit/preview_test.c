/* Points as they move: picked, told by another process, shown. */
#include "server/jobs/preview.h"
#include "server/work/ipc_codec.h"
#include "tests/support/vt.h"

#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>

enum { MOST = VOR_PREVIEW_POINTS_MAX };

static float *room(size_t points)
{
    float *xyz = malloc(3 * points * sizeof *xyz);

    ck_assert_ptr_nonnull(xyz);
    return xyz;
}

/* n points, each coordinate of which is `value`. */
static struct vor_shown frame(float *xyz, size_t n, float value, uint32_t iteration)
{
    for (size_t i = 0; i < 3 * n; i++)
        xyz[i] = value;
    return (struct vor_shown){.moving = {.xyz = xyz, .n = n, .unit = 1}, .iteration = iteration};
}

VT_TEST(points_are_picked_evenly_and_put_into_their_frame)
{
    float xyz[3 * 10], out[3];
    struct vor_moving moving = {.xyz = xyz, .n = 10, .unit = 2, .shift = {100, 0, -1}};

    for (int i = 0; i < 30; i++)
        xyz[i] = (float)(i / 3);
    for (size_t i = 0; i < 5; i++) {
        vor_shown_point(&moving, i, 5, out);
        ck_assert_float_eq(out[0], (float)(100 + 4 * i));
        ck_assert_float_eq(out[1], (float)(4 * i));
        ck_assert_float_eq(out[2], (float)(4 * i) - 1);
    }
    vor_shown_point(&moving, 9, 10, out);
    ck_assert_float_eq(out[1], 18);
    ck_assert_uint_eq(vor_shown_count(7, 10), 7);
    ck_assert_uint_eq(vor_shown_count(10000000, MOST), MOST);
}

VT_TEST(points_travel_in_a_file_picked_or_not_at_all)
{
    float *in = room(2 * MOST), *out = room(MOST);
    struct vor_shown shown = frame(in, 2 * MOST, 1.5F, 7), none = {.moving.n = MOST + 1};
    struct vor_message_said said;
    size_t size;
    int ends[2];

    vt_assert_ok(vor_channel_pair(ends, &vt_err));
    shown.origin[1] = 4849000.5;
    in[3 * 2] = 8; /* the third point is the second of those picked */
    vt_assert_ok(vor_say(ends[0], VOR_SAID_POINTS, &shown, sizeof shown));
    ck_assert_int_eq(vor_hear(&said, &size, out, ends[1], 1), VOR_CHANNEL_MESSAGE);
    ck_assert_ptr_eq(said.of.shown.moving.xyz, out);
    ck_assert_uint_eq(said.of.shown.moving.n, MOST);
    ck_assert_uint_eq(said.of.shown.iteration, 7);
    ck_assert_double_eq(said.of.shown.origin[1], 4849000.5);
    ck_assert_float_eq(out[0], 1.5F);
    ck_assert_float_eq(out[3], 8);
    ck_assert_float_eq(out[3 * MOST - 1], 1.5F);
    vt_assert_ok(vor_say(ends[0], VOR_SAID_POINTS, &shown, sizeof shown));
    ck_assert_int_eq(vor_hear(&said, &size, NULL, ends[1], 1), VOR_CHANNEL_LATE);
    said = (struct vor_message_said){.what = VOR_SAID_POINTS, .of.shown = none};
    size = offsetof(struct vor_message_said, of) + sizeof none;
    vt_assert_ok(vor_channel_send(ends[0], &said, size, NULL, 0, &vt_err));
    ck_assert_int_eq(vor_hear(&said, &size, out, ends[1], 1), VOR_CHANNEL_GONE);
    said = (struct vor_message_said){.what = VOR_SAID_POINTS, .of.shown = none};
    said.of.shown.moving.n = 1; /* and no file */
    size = offsetof(struct vor_message_said, of) + sizeof none;
    vt_assert_ok(vor_channel_send(ends[0], &said, size, NULL, 0, &vt_err));
    ck_assert_int_eq(vor_hear(&said, &size, out, ends[1], 1), VOR_CHANNEL_LATE);
    close(ends[0]);
    close(ends[1]);
    free(out);
    free(in);
}

/* The cloud of a preview. */
static vor_status cloud_of(struct vor_preview *preview, size_t most, struct vor_cloud *cloud,
                           struct vor_preview_info *info)
{
    vor_cloud_init(cloud, &vt_memory);
    return vor_preview_cloud(preview, most, cloud, info, &vt_err);
}

VT_TEST(a_preview_shows_the_last_frame_that_was_put)
{
    struct vor_preview *preview = vor_preview_create();
    struct vor_preview_info info;
    struct vor_cloud cloud;
    float *in = room(100);
    struct vor_shown shown = frame(in, 100, 3, 4);

    ck_assert(!vor_preview_is_looked_at(preview));
    vor_preview_look(preview);
    vor_preview_look(preview);
    vor_preview_look_away(preview);
    ck_assert(vor_preview_is_looked_at(preview));
    vt_assert_fails(VOR_E_EMPTY, cloud_of(preview, 10, &cloud, &info));
    vor_preview_put(preview, &shown);
    shown = frame(in, 100, 5, 6);
    shown.origin[0] = 1e6;
    vor_preview_put(preview, &shown);
    vt_assert_ok(cloud_of(preview, 10, &cloud, &info));
    ck_assert_uint_eq(cloud.n, 10);
    ck_assert_float_eq(cloud.xyz[29], 5);
    ck_assert_double_eq(cloud.origin[0], 1e6);
    ck_assert_int_eq(cloud.position_type, VOR_FLOAT64);
    ck_assert_uint_eq(info.version, 2);
    ck_assert_uint_eq(info.iteration, 6);
    ck_assert_uint_eq(info.points, 100);
    vor_cloud_free(&cloud);
    vor_preview_look_away(preview);
    ck_assert(!vor_preview_is_looked_at(preview));
    free(in);
    vor_preview_destroy(preview);
}
