/* How long results are kept: by room, and by time whatever happens to the clock. */
#define _GNU_SOURCE /* syscall */

#include "server/base/clock.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

/* The wall clock of this process is so many seconds ahead of the machine's. */
static atomic_long ahead;

int clock_gettime(clockid_t clock, struct timespec *out)
{
    int result = (int)syscall(SYS_clock_gettime, clock, out);

    if (clock == CLOCK_REALTIME)
        out->tv_sec += atomic_load(&ahead);
    return result;
}

enum { HOUR = 3600, DAY = 24 * HOUR };

static struct vor_uuid finish_job(struct vt_daemon *daemon)
{
    struct vor_spec spec = vt_request(20, 1);
    struct vor_uuid id = vt_daemon_submit_sphere(daemon, 100, &spec);

    ck_assert_int_eq(vt_daemon_wait_over(daemon, &id).status, VOR_JOB_SUCCESSFUL);
    return id;
}

/* --- the clock -------------------------------------------------------------------------------- */

/* Waits until the row of a job ends elsewhere than it did; the time that it then has left, in
 * seconds. */
static double left_after_jump(struct vt_daemon *daemon, const struct vor_uuid *id, int64_t before)
{
    struct vor_job_view view;

    do {
        vt_nap();
        view = vt_daemon_get(daemon, id);
    } while (view.expires == before);
    return (double)(view.expires - vor_clock_wall_ms()) / 1000;
}

/* Regression: +25 h expired every result at the next sweep. */
VT_TEST_LOOP(a_result_keeps_the_time_it_had_left_when_the_clock_jumps, 2)
{
    static const long jumps[] = {25 * HOUR, -25 * HOUR};
    struct vt_daemon_options options = {.ttl_seconds = DAY};
    const char *dir = vt_dir_make();
    struct vor_job_view view;
    struct vt_daemon daemon;
    struct vor_uuid id;
    double left;

    vt_daemon_start(&daemon, dir, &options);
    id = finish_job(&daemon);
    view = vt_daemon_get(&daemon, &id);
    atomic_store(&ahead, jumps[_i]);
    left = left_after_jump(&daemon, &id, view.expires);
    ck_assert_double_ge(left, DAY - 60);
    ck_assert_double_le(left, DAY + 60);
    vt_assert_ok(vor_job_service_sweep(daemon.service, &vt_err));
    ck_assert(!vt_daemon_get(&daemon, &id).expired);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 1);
    vt_daemon_stop(&daemon);
}

static struct vor_uuid finish_kept_for(struct vt_daemon *daemon, const char *dir, double seconds)
{
    struct vt_daemon_options options = {.ttl_seconds = seconds};
    struct vor_uuid id;

    vt_daemon_start(daemon, dir, &options);
    id = finish_job(daemon);
    return id;
}

/* The clock is wrong when the daemon starts, and is put right while it runs. A sweeper looks once
 * before it ends, however soon; that it looked again is seen by the job whose time is over then. */
VT_TEST_LOOP(a_start_with_a_clock_that_does_not_fit_expires_nothing_until_it_does, 2)
{
    static const long wrong[] = {30L * DAY, -30L * DAY};
    const char *dir = vt_dir_make();
    struct vor_job_view view;
    struct vt_daemon daemon;
    struct vor_uuid brief, id;

    brief = finish_kept_for(&daemon, dir, 1800);
    vt_daemon_stop(&daemon);
    id = finish_kept_for(&daemon, dir, DAY);
    view = vt_daemon_get(&daemon, &id);
    vt_daemon_stop(&daemon);
    atomic_store(&ahead, wrong[_i]);
    vt_daemon_start(&daemon, dir, NULL);
    vt_daemon_stop(&daemon);
    vt_daemon_start(&daemon, dir, NULL);
    ck_assert(!vt_daemon_get(&daemon, &brief).expired && !vt_daemon_get(&daemon, &id).expired);
    atomic_store(&ahead, 2000);
    while (!vt_daemon_get(&daemon, &brief).expired)
        vt_nap();
    ck_assert_int_eq(vt_daemon_get(&daemon, &id).expires, view.expires);
    vt_daemon_stop(&daemon);
}

VT_TEST(time_that_the_daemon_was_down_counts)
{
    struct vt_daemon_options options = {.ttl_seconds = 1800};
    const char *dir = vt_dir_make();
    struct vt_daemon daemon;
    struct vor_uuid id;

    vt_daemon_start(&daemon, dir, &options);
    id = finish_job(&daemon);
    vt_daemon_stop(&daemon);
    atomic_store(&ahead, 2000);
    vt_daemon_start(&daemon, dir, &options);
    while (!vt_daemon_get(&daemon, &id).expired)
        vt_nap();
    vt_daemon_stop(&daemon);
}

/* --- room ------------------------------------------------------------------------------------- */

VT_TEST(results_beyond_their_room_go_in_the_order_in_which_they_ended)
{
    enum { JOBS = 5 };
    const char *dir = vt_dir_make();
    struct vt_daemon_options options = {.jobs = 1};
    struct vor_uuid id[JOBS];
    struct vt_daemon daemon;
    uint64_t bytes;

    vt_daemon_start(&daemon, dir, &options);
    id[0] = finish_job(&daemon);
    bytes = vt_daemon_get(&daemon, &id[0]).output[0].bytes;
    vt_daemon_stop(&daemon);
    options.results = 2 * bytes + 10;
    vt_daemon_start(&daemon, dir, &options);
    for (int i = 1; i < JOBS; i++)
        id[i] = finish_job(&daemon);
    while (vt_dir_count(dir, "blobs/keep") > 2)
        vt_nap();
    for (int i = 0; i < JOBS; i++)
        ck_assert_int_eq(vt_daemon_get(&daemon, &id[i]).expired, i < JOBS - 2);
    vt_daemon_stop(&daemon);
    options.results = 1; /* the last one stays: its caller may be about to fetch it */
    vt_daemon_start(&daemon, dir, &options);
    while (vt_dir_count(dir, "blobs/keep") > 1)
        vt_nap();
    ck_assert(!vt_daemon_get(&daemon, &id[JOBS - 1]).expired);
    vt_daemon_stop(&daemon);
}

VT_LOG(VOR_LOG_OFF)
