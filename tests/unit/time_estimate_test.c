/* How long a job may run: what is estimated before it is accepted, and what ends it. */
#include "server/jobs/time_estimate.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <stdlib.h>
#include <string.h>

enum { LIMIT = 1800 };

static struct vor_spec request(const char *const pairs[][2])
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    for (int i = 0; pairs[i][0] != NULL; i++)
        vt_assert_ok(vor_spec_set(&spec, pairs[i][0], pairs[i][1], &vt_err));
    return spec;
}

#define REQUEST(...) request((const char *const[][2]){__VA_ARGS__, {NULL, NULL}})

VT_TEST(ten_million_points_as_usual_are_accepted)
{
    struct vor_spec spec = REQUEST({"points", "10000000"});

    ck_assert_double_gt(vor_time_estimate(&spec, 10000000, 2), 60);
    vt_assert_ok(vor_time_estimate_check(&spec, 10000000, 2, LIMIT, &vt_err));
}

VT_TEST(a_small_body_with_extreme_parameters_is_refused_with_estimate_and_limit)
{
    struct vor_spec spec = REQUEST({"points", "16000"}, {"neighbors", "500"},
                                   {"iterations", "10000"}, {"polish", "10000"});

    vt_assert_fails(VOR_E_WORK, vor_time_estimate_check(&spec, 1000, 2, LIMIT, &vt_err));
    ck_assert_uint_eq(vt_err.limit, LIMIT);
    ck_assert_uint_eq(vt_err.got, (uint64_t)vor_time_estimate(&spec, 1000, 2));
    ck_assert_double_gt((double)vt_err.got, VOR_TIME_ESTIMATE_FAR * LIMIT);
    ck_assert_ptr_nonnull(strstr(vt_err.message, "times the limit of 1800"));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "10000 polish steps of 16000 points"));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "500 points each"));
    vt_assert_ok(vor_time_estimate_check(&spec, 1000, 2, 0, &vt_err)); /* 0 is any */
}

VT_TEST(a_time_limit_of_its_own_makes_a_request_short)
{
    struct vor_spec spec = REQUEST({"points", "16000"}, {"neighbors", "500"},
                                   {"iterations", "10000"}, {"polish", "10000"}, {"seconds", "60"});

    ck_assert_double_le(vor_time_estimate(&spec, 1000, 2), 60);
    vt_assert_ok(vor_time_estimate_check(&spec, 1000, 2, LIMIT, &vt_err));
}

/* What the refusal wants is accepted, and a second less is not. */
VT_TEST(a_time_of_its_own_that_cannot_be_kept_is_refused_and_what_is_wanted_named)
{
    struct vor_spec spec = REQUEST({"points", "10000000"}, {"seconds", "1"});
    const char *wants;
    long seconds;

    vt_assert_fails(VOR_E_WORK, vor_time_estimate_check(&spec, 1000000, 2, 0, &vt_err));
    ck_assert_uint_eq(vt_err.limit, 1);
    ck_assert_double_gt((double)vt_err.got, VOR_TIME_ESTIMATE_FAR + VOR_TIME_ESTIMATE_SPARE);
    ck_assert_ptr_nonnull(strstr(vt_err.message, "seconds is 1, but placing 10000000 points"));
    wants = strstr(vt_err.message, "at least ");
    ck_assert_ptr_nonnull(wants);
    seconds = strtol(wants + strlen("at least "), NULL, 10);
    vt_assert_ok(vor_spec_set_number(&spec, "seconds", (double)seconds - 1, &vt_err));
    vt_assert_fails(VOR_E_WORK, vor_time_estimate_check(&spec, 1000000, 2, 0, &vt_err));
    vt_assert_ok(vor_spec_set_number(&spec, "seconds", (double)seconds, &vt_err));
    vt_assert_ok(vor_time_estimate_check(&spec, 1000000, 2, 0, &vt_err));
}

VT_TEST_LOOP(an_estimate_grows_with_what_is_asked_for, 6)
{
    static const char *const more[][2] = {{"points", "4000"},        {"iterations", "50"},
                                          {"polish", "500"},         {"neighbors", "300"},
                                          {"metric", "anisotropic"}, {"metric", "lp"}};
    struct vor_spec spec = REQUEST({"points", "2000"}, {"iterations", "10"}), longer = spec;

    vt_assert_ok(vor_spec_set(&longer, more[_i][0], more[_i][1], &vt_err));
    ck_assert_double_gt(vor_time_estimate(&longer, 3000, 2), vor_time_estimate(&spec, 3000, 2));
}

VT_TEST(a_job_that_runs_longer_than_it_may_fails_and_says_so)
{
    struct vt_daemon_options options = {.job_seconds = 0.2};
    struct vor_spec spec = vt_request(200, 5000);
    const char *dir = vt_dir_make();
    struct vt_daemon daemon;
    struct vor_job_view view;
    struct vor_uuid id;

    vt_daemon_start(&daemon, dir, &options);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 1500, &spec, &id),
                     VOR_FAILED); /* it is seen to be too long */
    ck_assert_int_eq(vt_err.status, VOR_E_WORK);
    vt_daemon_stop(&daemon);

    options.job_seconds = 0.4; /* a quarter of the estimate, 1.4 */
    vt_daemon_start(&daemon, dir, &options);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 1500, &spec, &id), VOR_DONE);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_FAILED);
    ck_assert_int_eq(view.problem.status, VOR_E_DEADLINE);
    ck_assert_str_eq(view.message, "the job ran for 0.4 seconds, the longest time that is allowed");
    vt_daemon_stop(&daemon);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 0);
}

/* It was asked for the time between two steps only, so that at least one was made, however long. */
VT_TEST(the_time_of_a_request_ends_a_step_under_way_and_the_report_says_so)
{
    struct vor_spec spec = vt_request(300, 10000);
    const char *dir = vt_dir_make();
    struct vt_daemon daemon;
    struct vor_job_view view;
    struct vor_uuid id;
    char *report;

    vt_assert_ok(vor_spec_set_number(&spec, "seconds", 1e-4, &vt_err));
    vt_daemon_start(&daemon, dir, NULL);
    ck_assert_int_eq(vt_daemon_try_sphere(&daemon, 1500, &spec, &id), VOR_DONE);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_SUCCESSFUL);
    ck_assert_uint_eq(view.output[0].points, 300);
    vt_assert_ok(vor_store_report(daemon.store, &id, &report, &vt_err));
    ck_assert_ptr_nonnull(strstr(report, "\"iterations\":0"));
    ck_assert_ptr_nonnull(strstr(report, "\"stopped\":\"seconds\""));
    free(report);
    vt_daemon_stop(&daemon);
}

VT_LOG(VOR_LOG_ERROR)
