#include "tests/support/vt_daemon.h"

#include "server/work/execute.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <stdlib.h>
#include <unistd.h>

static enum vor_run_end run_here(struct vor_run_executor *executor, const struct vor_order *order,
                                 const struct vor_listener *listener, struct vor_run_result *result,
                                 struct vor_text *kept, struct vor_error *err)
{
    const struct vor_run_means means = {.pool = ((struct vt_run_here *)executor)->pool};

    return vor_execute(result, kept, order, &means, listener, err) == VOR_OK ? VOR_RUN_DONE
                                                                             : VOR_RUN_FAILED;
}

void vt_run_here_init(struct vt_run_here *here, struct vor_pool *pool)
{
    here->base = (struct vor_run_executor){.threads = vor_pool_threads(pool), .run = run_here};
    here->pool = pool;
}

void vt_daemon_start(struct vt_daemon *daemon, const char *dir,
                     const struct vt_daemon_options *options)
{
    static const struct vt_daemon_options defaults;
    struct vor_job_service_config config = {
        .faults_max = 3,
    };

    if (options == NULL)
        options = &defaults;
    *daemon = (struct vt_daemon){.dir = dir};
    daemon->blobs = vt_dir_blobs(dir);
    daemon->store = vt_dir_store(dir);
    if (options->prepare != NULL)
        options->prepare(daemon);
    vt_assert_ok(vor_pool_create(&daemon->pool, 2, &vt_err));
    config.store = daemon->store;
    config.blobs = daemon->blobs;
    vt_run_here_init(&daemon->here, daemon->pool);
    config.executor = &daemon->here.base;
    config.jobs = options->jobs > 0 ? options->jobs : 2;
    config.queue = options->queue > 0 ? options->queue : 16;
    config.queue_bytes = options->queue_bytes > 0 ? options->queue_bytes : (uint64_t)1 << 30;
    config.failed = options->failed;
    config.failed_ctx = options->failed_ctx;
    config.results = options->results > 0 ? options->results : (uint64_t)1 << 30;
    config.memory = options->memory > 0 ? options->memory : (size_t)1 << 30;
    config.ttl_seconds = options->ttl_seconds > 0 ? options->ttl_seconds : 3600;
    config.keep = options->keep;
    config.checkpoint_work = options->checkpoint_work;
    config.checkpoint_seconds = options->checkpoint_work > 0 ? 1e-9 : 0;
    config.tidy_seconds = options->tidies ? 1e-9 : 0;
    config.job_seconds = options->job_seconds;
    config.budget = options->budget;
    vt_assert_ok(vor_job_service_create(&daemon->service, &config, &vt_err));
}

void vt_daemon_stop(struct vt_daemon *daemon)
{
    vor_job_service_destroy(daemon->service);
    vor_pool_destroy(daemon->pool);
    vor_store_close(daemon->store);
    vor_blobs_close(daemon->blobs);
}

struct vor_spec vt_request(unsigned points, int iterations)
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    vt_assert_ok(vor_spec_set_number(&spec, "points", points, &vt_err));
    vt_assert_ok(vor_spec_set_number(&spec, "polish", 0, &vt_err));
    if (iterations >= 0)
        vt_assert_ok(vor_spec_set_number(&spec, "iterations", iterations, &vt_err));
    return spec;
}

void vt_admit(struct vor_admitted *admitted, struct vor_blobs *blobs, const char *name,
              const struct vor_cloud *cloud)
{
    struct vor_admit_limits limits = {.codec = VOR_LIMITS_DEFAULT, .memory = (size_t)1 << 30};
    struct vor_blob_writer *upload = vt_upload_cloud(blobs, cloud);

    vt_assert_ok(vor_admit_file(admitted, name, blobs, upload, &limits, &vt_err));
    vor_blob_discard(upload);
}

enum vor_job_outcome vt_daemon_submit_inputs(struct vt_daemon *daemon,
                                             const struct vt_input *inputs,
                                             const struct vor_spec *spec, struct vor_uuid *id)
{
    struct vor_admitted admitted = {.count = 0};

    for (; inputs->name != NULL; inputs++)
        vt_admit(&admitted, daemon->blobs, inputs->name, inputs->cloud);
    *id = admitted.id;
    return vor_job_service_submit(daemon->service, &admitted, spec, NULL, NULL, &vt_err);
}

enum vor_job_outcome vt_daemon_submit(struct vt_daemon *daemon, const struct vor_cloud *cloud,
                                      const struct vor_spec *spec, struct vor_uuid *id)
{
    struct vt_input inputs[] = {{"cloud", cloud}, {NULL, NULL}};

    return vt_daemon_submit_inputs(daemon, inputs, spec, id);
}

struct vor_job_view vt_daemon_get(struct vt_daemon *daemon, const struct vor_uuid *id)
{
    struct vor_job_view view;

    ck_assert_int_eq(vor_job_service_get(daemon->service, id, NULL, &view, &vt_err), VOR_DONE);
    return view;
}

size_t vt_daemon_events(struct vt_daemon *daemon, const struct vor_uuid *id, struct vor_event *out,
                        size_t max)
{
    struct vor_event_batch batch = {.events = out, .max = max};
    struct vor_followed followed;

    ck_assert_int_eq(vor_job_service_follow(daemon->service, id, NULL, &followed, &vt_err),
                     VOR_DONE);
    if (followed.job == NULL || !vor_job_read(followed.job, &batch))
        vt_assert_ok(
            vor_job_service_stored_events(daemon->service, &followed.row, &batch, &vt_err));
    vor_job_release(followed.job);
    return batch.count;
}

struct vor_job_view vt_daemon_wait_over(struct vt_daemon *daemon, const struct vor_uuid *id)
{
    struct vor_job_view view = vt_daemon_get(daemon, id);

    for (; !vor_job_status_over(view.status); view = vt_daemon_get(daemon, id))
        vt_nap();
    return view;
}

struct vor_job_view vt_daemon_wait_iteration(struct vt_daemon *daemon, const struct vor_uuid *id,
                                             unsigned iteration)
{
    struct vor_job_view view = vt_daemon_get(daemon, id);

    for (; !view.has_record || view.record.iteration < iteration;
         view = vt_daemon_get(daemon, id)) {
        ck_assert_msg(!vor_job_status_over(view.status), "the job is over: %s", view.message);
        vt_nap();
    }
    return view;
}

void vt_daemon_wait_idle(struct vt_daemon *daemon)
{
    struct vor_job_service_load load;

    do {
        vt_nap();
        vor_job_service_load(daemon->service, &load);
    } while (load.running > 0 || load.waiting > 0);
}

enum vor_job_outcome vt_daemon_try_sphere(struct vt_daemon *daemon, size_t n,
                                          const struct vor_spec *spec, struct vor_uuid *id)
{
    enum vor_job_outcome outcome;
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, 1, n);
    outcome = vt_daemon_submit(daemon, &cloud, spec, id);
    vor_cloud_free(&cloud);
    return outcome;
}

struct vor_uuid vt_daemon_submit_sphere(struct vt_daemon *daemon, size_t n,
                                        const struct vor_spec *spec)
{
    struct vor_uuid id;

    ck_assert_int_eq(vt_daemon_try_sphere(daemon, n, spec, &id), VOR_DONE);
    return id;
}

struct vor_uuid vt_daemon_submit_endless(struct vt_daemon *daemon)
{
    const struct vor_spec endless = vt_request(300, 10000);
    struct vor_uuid id = vt_daemon_submit_sphere(daemon, 1000, &endless);

    (void)vt_daemon_wait_iteration(daemon, &id, 0);
    return id;
}

int vt_daemon_kept(const struct vt_daemon *daemon)
{
    return vt_dir_count(daemon->dir, "blobs/keep");
}

uint8_t *vt_daemon_output(struct vt_daemon *daemon, const struct vor_uuid *id, const char *name,
                          size_t *size)
{
    char blob[VOR_BLOB_NAME_MAX + 1];
    struct vor_job_brief row = {.attempt = 1};
    uint8_t *bytes;
    uint64_t length;
    int fd, found;

    if (daemon->store != NULL)
        vt_assert_ok(vor_store_brief(daemon->store, id, &row, &found, &vt_err));
    (void)vor_blob_of_output(name, row.attempt, blob);
    vt_assert_ok(vor_blob_get(daemon->blobs, id, blob, &fd, &length, &found, &vt_err));
    ck_assert(found);
    bytes = malloc(length + 1);
    ck_assert_int_eq(read(fd, bytes, length), (ssize_t)length);
    bytes[length] = '\0';
    close(fd);
    *size = length;
    return bytes;
}

uint8_t *vt_daemon_result(struct vt_daemon *daemon, const struct vor_uuid *id, size_t *size)
{
    return vt_daemon_output(daemon, id, "cloud", size);
}
