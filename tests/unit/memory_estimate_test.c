/* The memory that a job is let in with beside what its run takes, and what becomes of jobs that do
 * not fit. */
#include "server/jobs/memory_estimate.h"
#include "server/work/job_service.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_engine.h"

#include <stdio.h>
#include <string.h>

enum { DOUBLES = 2, NOISY = 3, FLAT = 4 };

/* A request, the shape and size of its input, and the estimate over the peak at most; it covers
 * what noise takes, and so is more than enough for clean inputs. */
struct need_case {
    const char *process;
    int noise; /* or DOUBLES, NOISY or FLAT */
    size_t points;
    const char *query;
    double most;
};

static const struct need_case cases[] = {
    {"resample", 0, 5000, "points=5000", 2.6},
    {"resample", 0, 2000, "points=6000", 2.6},
    {"resample", 0, 20000, "points=2000", 3.1},
    {"resample", 1, 10000, "points=1000", 2.6},
    {"resample", 0, 2000, "points=4000 neighbors=60", 1.5},
    {"resample", FLAT, 2000, "points=150 neighbors=20", 1.5},
    {"resample", 0, 5000, "points=5000 method=kmeans", 1.5},
    {"resample", 0, 5000, "points=5000 method=isotropic iterations=1", 2.6},
    {"resample", 0, 3000, "points=3000 method=wlop rounds=1", 2.6},
    {"resample", 0, 2000, "points=8000 method=ear rounds=1", 2.6},
    {"resample", 0, 5000, "points=5000 method=wlop rounds=1 steps=1", 2.6},
    {"resample", 0, 5000, "points=5000 method=ear rounds=1 steps=1 samples=5000", 2.6},
    {"resample", 0, 5000, "points=1000 method=wlop rounds=1", 2.6},
    {"resample", 0, 5000, "points=1000 method=ear rounds=1", 2.6},
    {"resample", 0, 3000, "points=3000 metric=anisotropic", 2.6},
    {"resample", 0, 3000, "points=3000 density=curvature", 2.6},
    {"resample", 0, 3000, "points=3000 metric=lp", 2.6},
    {"resample", NOISY, 10000, "ratio=1", 1.5},
    {"resample", NOISY, 10000, "ratio=0.3", 1.5},
    {"upsample", NOISY, 5000, "", 1.5},
    {"simplify", 0, 10000, "ratio=0.5", 2.6},
    {"mesh", 0, 3000, "ratio=1", 2.6},
    {"denoise", 0, 10000, "filters=mls,outliers", 2.6},
    {"convert", 0, 100000, "", 1.5},
    {"restore", 0, 100000, "", 2.0},
    {"convert", DOUBLES, 100000, "", 1.5},
    {"denoise", DOUBLES, 10000, "filters=outliers", 2.6},
    {"denoise", NOISY, 20000, "ratio=1", 1.5},
    {"denoise", 0, 20000, "ratio=1", 2.6},
    {"inspect", NOISY, 20000, "", 1.5},
    {"inspect", 0, 20000, "", 2.6},
};

static void noise_cloud(struct vor_cloud *cloud, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < 3 * n; i++)
        cloud->xyz[i] = (float)vt_unit(3, i);
}

/* Has a cloud keep its coordinates as doubles that are not quite its positions. */
static void keep_doubles(struct vor_cloud *cloud)
{
    double *xyz = vor_malloc(cloud->memory, cloud->n, 3 * sizeof *xyz);

    ck_assert_ptr_nonnull(xyz);
    for (size_t i = 0; i < 3 * cloud->n; i++)
        xyz[i] = (double)cloud->xyz[i] + 1e-12;
    vor_cloud_keep_double(cloud, &xyz);
    ck_assert_ptr_null(xyz);
}

/* Sets "a=1 b=2", with as few steps as the request takes. */
static void set_all(struct vor_spec *spec, const struct need_case *of)
{
    char text[128], *rest = text, *pair;

    vor_spec_preset(spec, vor_process_find(of->process));
    (void)snprintf(text, sizeof text, "%s", of->query);
    for (pair = strtok_r(text, " ", &rest); pair != NULL; pair = strtok_r(NULL, " ", &rest)) {
        char *value = strchr(pair, '=');

        *value = '\0';
        vt_assert_ok(vor_spec_set(spec, pair, value + 1, &vt_err));
    }
    if (spec->process->methods != 0)
        vt_assert_ok(vor_spec_set_number(spec, "iterations", 1, &vt_err));
    if (spec->process->methods != 0)
        vt_assert_ok(vor_spec_set_number(spec, "polish", 0, &vt_err));
    vt_assert_ok(vor_spec_complete(spec, &vt_err));
}

VT_TEST_LOOP(the_estimate_is_near_the_peak, sizeof cases / sizeof cases[0])
{
    const struct need_case *of = &cases[_i];
    struct vor_memory memory;
    struct vt_engine engine;
    struct vor_artefacts in, out;
    struct vor_cloud cloud;
    struct vor_job_view row = vt_row(10);
    double ratio;

    vor_memory_init(&memory, SIZE_MAX);
    vt_engine_open(&engine, 2);
    set_all(&row.spec, of);
    if (of->noise == 1)
        noise_cloud(&cloud, of->points);
    else if (of->noise == FLAT)
        vt_cloud_box(&cloud, 5, of->points);
    else
        vt_cloud_sphere(&cloud, 5, of->points);
    for (size_t i = 0; of->noise == FLAT && i < cloud.n; i++)
        cloud.xyz[3 * i + 2] *= 0.05F;
    if (of->noise == DOUBLES)
        keep_doubles(&cloud);
    for (size_t i = 0; of->noise == NOISY && i < 3 * cloud.n; i++)
        cloud.xyz[i] += 0.05F * (float)(vt_unit(3, i) - 0.5);
    row.input[0].points = of->points;
    row.input[0].bytes = (of->noise == DOUBLES ? 24 : 12) * of->points;
    vor_artefacts_init(&in, &vt_memory);
    vor_artefacts_init(&out, &memory);
    vor_artefacts_put_cloud(&in, "cloud", &cloud);
    engine.run.memory = &memory;
    vt_assert_ok(vor_engine_run(&out, &in, &row.spec, &engine.run, &vt_err));
    ratio =
        (double)vor_memory_estimate(&row.spec, row.inputs, row.input, VOR_FIT_NOISY) /
        ((double)atomic_load(&memory.peak) + (of->noise == DOUBLES ? 36 : 12) * (double)of->points);
    ck_assert_msg(ratio >= 1 && ratio <= of->most, "%s of %zu, %s: %.2f of the peak", of->process,
                  of->points, of->query, ratio);
    vor_artefacts_free(&out);
    vor_artefacts_free(&in);
    vt_engine_close(&engine);
}

/* What a job of that request is let in with, and what it needs to be let in. */
static uint64_t need_of(const struct vor_spec *spec, enum vor_fit_neighbors neighbors)
{
    struct vor_job_view row = vt_row(10);

    row.spec = *spec;
    row.input[0].points = 1500;
    row.input[0].bytes = 1500 * 12;
    return vor_memory_estimate(&row.spec, row.inputs, row.input, neighbors);
}

VT_TEST(jobs_that_fit_alone_but_not_together_wait_for_each_other)
{
    struct vor_spec endless = vt_request(1000, 10000), quick = vt_request(1000, 3);
    struct vt_daemon_options options = {.jobs = 4,
                                        .budget = need_of(&endless, VOR_FIT_NOISY) * 3 / 2};
    struct vt_daemon daemon;
    const char *dir = vt_dir_make();
    struct vor_job_service_load load;
    struct vor_uuid runs, waits;

    vt_daemon_start(&daemon, dir, &options);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 1500, &endless, &runs), VOR_DONE);
    (void)vt_daemon_wait_iteration(&daemon, &runs, 0);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 1500, &quick, &waits), VOR_DONE);
    (void)vt_daemon_wait_iteration(&daemon, &runs,
                                   vt_daemon_get(&daemon, &runs).record.iteration + 5);
    vor_job_service_load(daemon.service, &load);
    ck_assert_uint_eq(load.running, 1);
    ck_assert_uint_eq(load.waiting, 1);
    ck_assert_uint_ge(load.reserved, need_of(&endless, VOR_FIT_NOISY));
    ck_assert_uint_le(load.reserved, load.budget);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &runs, "enough", &vt_err), VOR_DONE);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &waits).status, VOR_JOB_SUCCESSFUL);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_job_that_fits_unless_its_input_is_noisy_runs)
{
    struct vor_spec spec = vt_request(1000, 3);
    struct vt_daemon_options options = {.budget = need_of(&spec, VOR_FIT_CLEAN) * 11 / 10};
    struct vt_daemon daemon;
    struct vor_uuid id;

    ck_assert_uint_lt(options.budget, need_of(&spec, VOR_FIT_NOISY));
    vt_daemon_start(&daemon, vt_dir_make(), &options);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 1500, &spec, &id), VOR_DONE);
    ck_assert_int_eq(vt_daemon_wait_over(&daemon, &id).status, VOR_JOB_SUCCESSFUL);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_job_larger_than_all_memory_is_refused_with_the_numbers)
{
    struct vor_spec spec = vt_request(1000, 3);
    struct vt_daemon_options options = {.budget = 1 << 20};
    struct vt_daemon daemon;
    const char *dir = vt_dir_make();
    struct vor_uuid id;

    vt_daemon_start(&daemon, dir, &options);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 1500, &spec, &id), VOR_FAILED);
    ck_assert_int_eq(vt_err.status, VOR_E_NOMEM);
    ck_assert_uint_eq(vt_err.limit, 1 << 20);
    ck_assert_uint_ge(vt_err.got, need_of(&spec, VOR_FIT_CLEAN));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "1048576"));
    vt_daemon_stop(&daemon);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 0);
}

VT_LOG(VOR_LOG_ERROR)
