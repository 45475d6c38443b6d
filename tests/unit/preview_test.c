/* Points as they move: picked, put into shared memory, shown. */
#include "server/jobs/preview.h"
#include "server/work/wire.h"
#include "tests/support/vt.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

enum { MOST = VOR_PREVIEW_POINTS_MAX, SEAT = 3 };

static struct vor_board *new_board(void)
{
    struct vor_board *board = NULL;
    int fd = -1;

    vt_assert_ok(vor_board_create(&board, &fd, &vt_err));
    (void)close(fd);
    return board;
}

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

VT_TEST(a_board_shows_what_was_written_last_and_once)
{
    struct vor_board *board = new_board();
    float *in = room(2 * MOST), *out = room(MOST);
    struct vor_shown shown = frame(in, 2 * MOST, 1.5F, 7), seen;
    unsigned sequence = 0;

    ck_assert(!vor_board_look(board, SEAT, &sequence, &seen, out));
    shown.polish = 9;
    shown.origin[1] = 4849000.5;
    in[3 * 2] = 8; /* the third point is the second of those picked */
    vor_board_show(board, SEAT, &shown);
    ck_assert(!vor_board_look(board, SEAT + 1, &(unsigned){0}, &seen, out));
    ck_assert(vor_board_look(board, SEAT, &sequence, &seen, out));
    ck_assert_ptr_eq(seen.moving.xyz, out);
    ck_assert_uint_eq(seen.moving.n, MOST);
    ck_assert_uint_eq(seen.iteration, 7);
    ck_assert_uint_eq(seen.polish, 9);
    ck_assert_double_eq(seen.origin[1], 4849000.5);
    ck_assert_float_eq(out[0], 1.5F);
    ck_assert_float_eq(out[3], 8);
    ck_assert_float_eq(out[3 * MOST - 1], 1.5F);
    ck_assert(!vor_board_look(board, SEAT, &sequence, &seen, out));
    free(out);
    free(in);
    vor_board_unmap(board);
}

VT_TEST(a_count_that_makes_no_sense_reads_nothing_beyond)
{
    struct vor_board *board = new_board();
    float *out = room(MOST);
    struct vor_shown seen;
    unsigned sequence = 0;

    atomic_store(&board->showing[SEAT].count, 4000000000U);
    atomic_store(&board->showing[SEAT].sequence, 2);
    ck_assert(vor_board_look(board, SEAT, &sequence, &seen, out));
    ck_assert_uint_eq(seen.moving.n, MOST);
    atomic_store(&board->showing[SEAT].sequence, 3); /* the process that writes is killed */
    ck_assert(!vor_board_look(board, SEAT, &sequence, &seen, out));
    free(out);
    vor_board_unmap(board);
}

VT_TEST(what_nobody_looks_at_any_more_takes_no_memory)
{
    struct vor_board *board = new_board();
    float *in = room(MOST);
    struct vor_shown shown = frame(in, MOST, 1, 1);

    vor_board_show(board, SEAT, &shown);
    atomic_store(&board->showing[SEAT].is_looked_at, 1);
    vor_board_look_away(board, SEAT);
    ck_assert_int_eq(atomic_load(&board->showing[SEAT].is_looked_at), 0);
    if (sysconf(_SC_PAGESIZE) == 4096) /* pages given back read as zero */
        ck_assert_uint_eq(atomic_load(&board->shown[SEAT][3 * MOST - 1]), 0);
    free(in);
    vor_board_unmap(board);
}

struct writer {
    struct vor_board *board;
    atomic_int is_over;
};

static void *write_frames(void *arg)
{
    struct writer *writer = arg;
    const struct timespec pause = {0, 100000};
    float *in = room(5000);

    for (uint32_t i = 1; !atomic_load(&writer->is_over); i++) {
        struct vor_shown shown = frame(in, 5000, (float)i, i);

        vor_board_show(writer->board, SEAT, &shown);
        (void)nanosleep(&pause, NULL);
    }
    free(in);
    return NULL;
}

VT_TEST(a_frame_that_is_read_is_whole)
{
    struct writer writer = {.board = new_board()};
    float *out = room(MOST);
    struct vor_shown seen;
    unsigned sequence = 0, whole = 0;
    pthread_t thread;

    atomic_init(&writer.is_over, 0);
    ck_assert_int_eq(pthread_create(&thread, NULL, write_frames, &writer), 0);
    while (whole < 400) {
        if (!vor_board_look(writer.board, SEAT, &sequence, &seen, out))
            continue;
        whole++;
        for (size_t i = 0; i < 3 * seen.moving.n; i++)
            ck_assert_msg(out[i] == (float)seen.iteration, "point %zu is of another frame", i / 3);
    }
    atomic_store(&writer.is_over, 1);
    ck_assert_int_eq(pthread_join(thread, NULL), 0);
    free(out);
    vor_board_unmap(writer.board);
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
