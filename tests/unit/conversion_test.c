/* Conversions of results: one for all who ask at the same time, so many of each caller, none
 * left behind by a job that goes, and a full end of the daemon. */
#include "server/work/conversion.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

/* A daemon with a finished job or two, and a pool of two threads that tasks hold. */
struct scene {
    struct vt_daemon daemon;
    struct vor_thread_pool *pool;
    struct vor_conversions *conversions;
    struct vor_task task[2];
    atomic_int is_held, woken;
    struct vor_job_view job[2];
};

static void hold(void *ctx)
{
    struct scene *scene = ctx;

    while (atomic_load(&scene->is_held))
        vt_nap();
}

/* Of each caller `most` wait. */
static void begin(struct scene *scene, size_t most)
{
    struct vor_spec spec = vt_request(50, 1);
    struct vor_cloud cloud;

    vt_daemon_start(&scene->daemon, vt_dir_make(), NULL);
    vt_cloud_sphere(&cloud, 1, 400);
    for (int i = 0; i < 2; i++) {
        struct vor_uuid id;

        ck_assert_int_eq(vt_daemon_submit(&scene->daemon, &cloud, &spec, &id), VOR_DONE);
        scene->job[i] = vt_daemon_wait_over(&scene->daemon, &id);
        ck_assert_int_eq(scene->job[i].status, VOR_JOB_SUCCESSFUL);
    }
    vor_cloud_free(&cloud);
    atomic_init(&scene->is_held, 1);
    atomic_init(&scene->woken, 0);
    vt_assert_ok(vor_thread_pool_create(&scene->pool, 2, 16, &vt_err));
    vor_thread_pool_share(scene->pool, 1, most);
    vt_assert_ok(
        vor_conversions_create(&scene->conversions,
                               &(struct vor_conversions_config){.store = scene->daemon.store,
                                                                .blobs = scene->daemon.blobs,
                                                                .service = scene->daemon.service,
                                                                .pool = scene->pool,
                                                                .memory = (size_t)1 << 30},
                               &vt_err));
    for (int i = 0; i < 2; i++) {
        scene->task[i] =
            (struct vor_task){.run = hold, .ctx = scene, .caller = {{(char)('a' + i)}}};
        ck_assert_int_eq(vor_thread_pool_submit(scene->pool, &scene->task[i], NULL), VOR_DONE);
    }
}

static void end(struct scene *scene)
{
    vor_conversions_destroy(scene->conversions);
    vt_daemon_stop(&scene->daemon);
}

static void wake(void *ctx)
{
    atomic_fetch_add(&((struct scene *)ctx)->woken, 1);
}

/* A caller asks for job number `job` as Draco. */
static enum vor_job_outcome ask(struct scene *scene, char caller, int job)
{
    const struct vor_asker asker = {.wake = wake, .ctx = scene, .caller = {{caller}}};

    return vor_convert(scene->conversions, &scene->job[job], 0, VOR_FORMAT_DRC, &asker, &vt_err);
}

static void wait_woken(struct scene *scene, int count)
{
    atomic_store(&scene->is_held, 0);
    while (atomic_load(&scene->woken) < count)
        vt_nap();
}

static struct vor_converted converted(struct scene *scene, int job)
{
    struct vor_converted converted;

    vt_assert_ok(vor_converted_open(&converted, scene->daemon.blobs, &scene->job[job].id, "cloud",
                                    VOR_FORMAT_DRC, &vt_err));
    if (converted.fd >= 0)
        (void)close(converted.fd);
    return converted;
}

VT_TEST(those_who_ask_at_the_same_time_share_one_conversion)
{
    struct scene scene;

    begin(&scene, 1); /* a second one would be one too many */
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(ask(&scene, 'c', 0), VOR_DONE);
    ck_assert_int_lt(converted(&scene, 0).fd, 0);
    wait_woken(&scene, 3);
    ck_assert_uint_gt(converted(&scene, 0).size, 0);
    vor_thread_pool_destroy(scene.pool);
    end(&scene);
}

VT_TEST(no_caller_keeps_others_from_a_conversion)
{
    struct scene scene;

    begin(&scene, 1);
    ck_assert_int_eq(ask(&scene, 'c', 0), VOR_DONE);
    ck_assert_int_eq(ask(&scene, 'c', 1), VOR_FULL);
    ck_assert_int_eq(ask(&scene, 'd', 1), VOR_DONE);
    ck_assert_int_eq(ask(&scene, 'c', 1), VOR_DONE); /* joins */
    wait_woken(&scene, 3);
    for (int i = 0; i < 2; i++)
        ck_assert_int_ge(converted(&scene, i).fd, 0);
    vor_thread_pool_destroy(scene.pool);
    end(&scene);
}

/* The job goes while its result waits to be converted, and after it was. */
VT_TEST(a_job_that_goes_leaves_nothing_behind)
{
    struct scene scene;

    begin(&scene, 2);
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(ask(&scene, 'c', i), VOR_DONE);
    ck_assert_int_eq(
        vor_job_service_dismiss(scene.daemon.service, &scene.job[0].id, "gone", NULL, &vt_err),
        VOR_DONE);
    wait_woken(&scene, 2);
    ck_assert_int_eq(ask(&scene, 'c', 0), VOR_FAILED);
    ck_assert_int_eq(vt_err.status, VOR_E_INTERNAL);
    ck_assert_int_ge(converted(&scene, 1).fd, 0);
    ck_assert_int_eq(
        vor_job_service_dismiss(scene.daemon.service, &scene.job[1].id, "gone", NULL, &vt_err),
        VOR_DONE);
    for (int i = 0; i < 2; i++)
        ck_assert_int_lt(converted(&scene, i).fd, 0);
    vor_thread_pool_destroy(scene.pool);
    end(&scene);
}

static void *release_once_closing(void *ctx)
{
    struct scene *scene = ctx;

    while (!vor_thread_pool_is_closing(scene->pool))
        vt_nap();
    atomic_store(&scene->is_held, 0);
    return NULL;
}

VT_TEST(what_waits_when_the_daemon_ends_is_told_so)
{
    struct scene scene;
    pthread_t thread;

    begin(&scene, 2);
    ck_assert_int_eq(ask(&scene, 'c', 0), VOR_DONE);
    ck_assert_int_eq(pthread_create(&thread, NULL, release_once_closing, &scene), 0);
    vor_thread_pool_destroy(scene.pool); /* closes at once, and waits for the task that is held */
    pthread_join(thread, NULL);
    ck_assert_int_eq(atomic_load(&scene.woken), 1);
    ck_assert_int_eq(ask(&scene, 'c', 0), VOR_FAILED);
    ck_assert_int_eq(vt_err.status, VOR_E_CANCELLED);
    ck_assert_int_lt(converted(&scene, 0).fd, 0);
    end(&scene);
}

VT_LOG(VOR_LOG_OFF)
