/* A place in the queue that is kept for a job while its inputs are decoded. */
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

/* A daemon whose one runner works on a job without an end, and whose queue has one place. */
struct scene {
    struct vt_daemon daemon;
    const char *dir;
    struct vor_cloud cloud;
};

static void open_scene(struct scene *scene)
{
    struct vt_daemon_options options = {.jobs = 1, .queue = 1};
    struct vor_spec endless = vt_request(50, 10000);
    struct vor_uuid id;

    scene->dir = vt_dir_make();
    vt_daemon_start(&scene->daemon, scene->dir, &options);
    vt_cloud_sphere(&scene->cloud, 1, 200);
    ck_assert_int_eq(vt_daemon_submit(&scene->daemon, &scene->cloud, &endless, &id), VOR_DONE);
    while (vor_job_service_room(scene->daemon.service, NULL, 0, NULL) != VOR_DONE)
        ;
}

static void close_scene(struct scene *scene)
{
    vor_cloud_free(&scene->cloud);
    vt_daemon_stop(&scene->daemon);
}

/* Submits for a place that is booked. */
static enum vor_job_outcome submit_booked(struct scene *scene, unsigned points)
{
    const struct vor_job_label label = {.booked = 1};
    struct vor_admitted admitted = {.count = 0};
    struct vor_spec spec = vt_request(points, 1);

    vt_admit(&admitted, scene->daemon.blobs, "cloud", &scene->cloud);
    return vor_job_service_submit(scene->daemon.service, &admitted, &spec, &label, NULL, &vt_err);
}

VT_TEST(a_booked_place_is_that_of_who_booked_it)
{
    struct vor_spec spec = vt_request(50, 1);
    struct vor_uuid id;
    struct scene scene;

    open_scene(&scene);
    ck_assert_int_eq(vor_job_service_book(scene.daemon.service), VOR_DONE);
    ck_assert_int_eq(vor_job_service_book(scene.daemon.service), VOR_FULL);
    ck_assert_int_eq(vor_job_service_room(scene.daemon.service, NULL, 0, NULL), VOR_FULL);
    ck_assert_int_eq(vt_daemon_submit(&scene.daemon, &scene.cloud, &spec, &id), VOR_FULL);
    ck_assert_int_eq(submit_booked(&scene, 50), VOR_DONE);
    ck_assert_int_eq(vor_job_service_book(scene.daemon.service), VOR_FULL);
    close_scene(&scene);
}

VT_TEST(a_place_is_given_back_by_who_has_no_use_for_it)
{
    struct scene scene;

    open_scene(&scene);
    ck_assert_int_eq(vor_job_service_book(scene.daemon.service), VOR_DONE);
    vor_job_service_unbook(scene.daemon.service);
    ck_assert_int_eq(vor_job_service_room(scene.daemon.service, NULL, 0, NULL), VOR_DONE);
    ck_assert_int_eq(vor_job_service_book(scene.daemon.service), VOR_DONE);
    ck_assert_int_eq(submit_booked(&scene, 5000), VOR_FAILED); /* 16 for each point at most */
    ck_assert_int_eq(vt_err.status, VOR_E_TARGET);
    ck_assert_int_eq(vor_job_service_room(scene.daemon.service, NULL, 0, NULL), VOR_DONE);
    close_scene(&scene);
}

VT_LOG(VOR_LOG_ERROR)
