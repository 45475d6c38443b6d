/* Jobs with inputs and outputs by name: `measure` takes two clouds through the same machinery as
 * any job, and hands out a document. */
#include "core/engine.h"
#include "proto/codec.h"
#include "proto/json/json.h"
#include "server/work/artefacts.h"
#include "server/work/job_service.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_dir.h"

#include <signal.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const struct vt_daemon_options one_runner = {.jobs = 1};

/* A request to measure a cloud, and two clouds of a sphere. */
struct pair {
    struct vor_spec spec;
    struct vor_cloud cloud, reference;
    struct vt_input inputs[3]; /* both */
};

static void pair_make(struct pair *pair)
{
    vor_spec_preset(&pair->spec, vor_process_find("measure"));
    vt_cloud_sphere(&pair->cloud, 1, 400);
    vt_cloud_sphere(&pair->reference, 2, 900);
    pair->inputs[0] = (struct vt_input){"cloud", &pair->cloud};
    pair->inputs[1] = (struct vt_input){"reference", &pair->reference};
    pair->inputs[2] = (struct vt_input){NULL, NULL};
}

static void pair_free(struct pair *pair)
{
    vor_cloud_free(&pair->cloud);
    vor_cloud_free(&pair->reference);
}

static struct vor_uuid submit(struct vt_daemon *daemon, const struct pair *pair)
{
    struct vor_uuid id;

    ck_assert_int_eq(vt_daemon_submit_inputs(daemon, pair->inputs, &pair->spec, &id), VOR_DONE);
    return id;
}

static void expect_successful(const struct vor_job_view *view)
{
    ck_assert_msg(view->status == VOR_JOB_SUCCESSFUL, "%s", view->message);
}

/* --- what comes out --------------------------------------------------------------------------- */

static void copy_into(struct vor_artefacts *set, const char *name, const struct vor_cloud *cloud)
{
    struct vor_cloud copy;

    vor_cloud_init(&copy, &vt_memory);
    vt_assert_ok(vor_cloud_resize(&copy, cloud->n, &vt_err));
    memcpy(copy.xyz, cloud->xyz, 3 * cloud->n * sizeof *cloud->xyz);
    vor_artefacts_put_cloud(set, name, &copy);
}

/* The document that the engine hands out for the first `count` inputs of a pair, as JSON. */
static void direct(const struct pair *pair, unsigned count, struct vor_text *json)
{
    struct vor_run run = {.memory = &vt_memory};
    struct vor_artefacts in, out;

    vor_artefacts_init(&in, &vt_memory);
    vor_artefacts_init(&out, &vt_memory);
    for (unsigned i = 0; i < count; i++)
        copy_into(&in, pair->inputs[i].name, pair->inputs[i].cloud);
    vt_assert_ok(vor_pool_create(&run.pool, 2, &vt_err));
    vt_assert_ok(vor_engine_run(&out, &in, &pair->spec, &run, &vt_err));
    vor_text_init(json, 0);
    vor_json_document(json, &vor_artefacts_find(&out, "measure")->document);
    vt_assert_ok(vor_text_status(json, &vt_err));
    vor_pool_destroy(run.pool);
    vor_artefacts_free(&in);
    vor_artefacts_free(&out);
}

/* The document of a job, as its blob and its row have it. */
static void expect_document(struct vt_daemon *daemon, const struct vor_uuid *id,
                            const struct vor_text *wanted)
{
    struct vor_job_view view = vt_daemon_get(daemon, id);
    size_t size;
    uint8_t *bytes = vt_daemon_output(daemon, id, "measure", &size);

    ck_assert_str_eq((char *)bytes, wanted->data);
    ck_assert_uint_eq(view.output[0].bytes, size);
    ck_assert_uint_eq(view.output[0].points, 0);
    ck_assert_uint_eq(strlen(view.output[0].sha256), VOR_DIGEST_SIZE - 1);
    free(bytes);
}

/* With a reference, the inputs in either order; and without. */
VT_TEST_LOOP(a_document_is_what_the_engine_gives, 3)
{
    struct vt_input backwards[3], *given;
    struct vor_text wanted;
    struct vor_job_view view;
    struct vt_daemon daemon;
    struct vor_uuid id;
    struct pair pair;
    char message[64], *report;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    pair_make(&pair);
    if (_i == 2)
        pair.inputs[1].name = NULL;
    else
        vt_assert_ok(vor_spec_set(&pair.spec, "peak", "2.5", &vt_err));
    memcpy(backwards, pair.inputs, sizeof backwards);
    backwards[0] = pair.inputs[1];
    backwards[1] = pair.inputs[0];
    given = _i == 1 ? backwards : pair.inputs;
    direct(&pair, _i == 2 ? 1 : 2, &wanted);
    ck_assert_int_eq(vt_daemon_submit_inputs(&daemon, given, &pair.spec, &id), VOR_DONE);
    (void)vt_daemon_wait_over(&daemon, &id);
    vt_daemon_wait_idle(&daemon);
    view = vt_daemon_get(&daemon, &id);
    expect_successful(&view);
    expect_document(&daemon, &id, &wanted);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 1);
    (void)snprintf(message, sizeof message, "measure is ready, %zu bytes", wanted.size);
    ck_assert_str_eq(view.message, message);
    ck_assert_int_eq(view.progress, 100);
    ck_assert(!view.has_record);
    ck_assert_uint_eq(view.inputs, _i == 2 ? 1 : 3);
    ck_assert_uint_eq(view.input[0].points, 400);
    ck_assert_uint_eq(view.input[1].points, _i == 2 ? 0 : 900);
    vt_assert_ok(vor_store_report(daemon.store, &id, &report, &vt_err));
    ck_assert_ptr_null(report);
    vor_text_free(&wanted);
    pair_free(&pair);
    vt_daemon_stop(&daemon);
}

VT_TEST(a_job_without_records_tells_its_stages_and_its_end)
{
    struct vt_daemon daemon;
    struct vor_job_view view;
    struct vor_event events[8];
    struct vor_uuid blocker, id;
    struct pair pair;

    vt_daemon_start(&daemon, vt_dir_make(), &one_runner);
    pair_make(&pair);
    blocker = vt_daemon_submit_endless(&daemon);
    id = submit(&daemon, &pair);
    view = vt_daemon_get(&daemon, &id);
    ck_assert_str_eq(view.message, "Waiting for its turn");
    ck_assert_int_eq(view.queue_position, 0);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &blocker, "off you go", &vt_err),
                     VOR_DONE);
    view = vt_daemon_wait_over(&daemon, &id);
    expect_successful(&view);
    ck_assert_uint_eq(vt_daemon_events(&daemon, &id, events, 8),
                      4); /* it waits, prepares, encodes */
    ck_assert_int_eq(events[3].kind, VOR_EVENT_END);
    ck_assert_int_eq(events[3].status, VOR_JOB_SUCCESSFUL);
    pair_free(&pair);
    vt_daemon_stop(&daemon);
}

/* Of a process that does not take a format, in that of the main input. */
VT_TEST_LOOP(a_cloud_beside_the_main_output_is_saved_under_its_name, 2)
{
    const struct vor_format *format;
    struct vor_job_output saved = {.points = 1};
    struct vor_result_facts facts = {.spacing = 0};
    struct vt_daemon daemon = {.dir = vt_dir_make()};
    struct vor_artefact artefact = {.name = "mesh", .kind = VOR_ARTEFACT_CLOUD};
    struct vor_order order = {.format = (unsigned)_i};
    const struct vor_codec_place here = {.zygote = NULL};
    const struct vor_writing writing = {&order, &facts, &here};
    struct vor_job_view row = vt_row(10);
    struct vor_blob_writer *writer;
    struct vor_cloud back;
    uint8_t *bytes;
    size_t size;

    daemon.blobs = vt_dir_blobs(daemon.dir);
    vt_cloud_sphere(&artefact.cloud, 1, 70);
    vor_extent_measure(&facts.input, &artefact.cloud);
    vor_spec_preset(&order.spec, vor_process_find("measure"));
    vt_assert_ok(vor_blob_create(daemon.blobs, &writer, &vt_err));
    order.output[1] = vor_blob_fd(writer);
    vt_assert_ok(vor_artefact_write(&saved, &writing, 1, &artefact, &vt_err));
    vt_assert_ok(vor_blob_adopt(writer, saved.bytes, saved.sha256, &vt_err));
    vt_assert_ok(vor_blob_commit(writer, &row.id, "mesh", &vt_err));
    bytes = vt_daemon_output(&daemon, &row.id, "mesh", &size);
    ck_assert_uint_eq(saved.format, (unsigned)_i);
    ck_assert_uint_eq(saved.points, 70);
    ck_assert_int_eq(saved.has_origin, _i == VOR_FORMAT_DRC);
    ck_assert_uint_eq(saved.bytes, size);
    ck_assert_uint_eq(strlen(saved.sha256), VOR_DIGEST_SIZE - 1);
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_codec_read(&back, &format, bytes, size, &(struct vor_limits)VOR_LIMITS_DEFAULT,
                                &vt_err));
    ck_assert_ptr_eq(format, vor_format((unsigned)_i));
    ck_assert_uint_eq(back.n, 70);
    free(bytes);
    vor_cloud_free(&back);
    vor_cloud_free(&artefact.cloud);
    vor_blobs_close(daemon.blobs);
}

VT_TEST(an_output_of_an_unknown_format_is_not_written)
{
    struct vor_job_output saved = {.points = 77};
    struct vor_result_facts facts = {.spacing = 0};
    struct vor_artefact artefact = {.name = "mesh", .kind = VOR_ARTEFACT_CLOUD};
    struct vor_order order = {.format = 99}; /* as a newer version may have noted it */
    const struct vor_codec_place here = {.zygote = NULL};
    const struct vor_writing writing = {&order, &facts, &here};
    FILE *file = tmpfile();

    order.output[0] = fileno(file);
    vt_cloud_sphere(&artefact.cloud, 1, 70);
    vor_spec_preset(&order.spec, vor_process_find("measure"));
    vt_assert_fails(VOR_E_INTERNAL, vor_artefact_write(&saved, &writing, 0, &artefact, &vt_err));
    ck_assert_str_eq(vt_err.message, "this version cannot write format 99");
    ck_assert_uint_eq(saved.points, 77);
    ck_assert_int_eq(lseek(order.output[0], 0, SEEK_END), 0);
    (void)fclose(file);
    vor_cloud_free(&artefact.cloud);
}

/* What another process says that it has written is compared with what is there. */
VT_TEST(a_result_of_another_size_than_told_is_not_taken)
{
    static const char sha256[VOR_DIGEST_SIZE] = "00";
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *writer;

    vt_assert_ok(vor_blob_create(blobs, &writer, &vt_err));
    ck_assert_int_eq(write(vor_blob_fd(writer), "abc", 3), 3);
    vt_assert_fails(VOR_E_INTERNAL, vor_blob_adopt(writer, 4, sha256, &vt_err));
    ck_assert_str_eq(vt_err.message, "a result has 3 bytes instead of 4");
    vor_blob_discard(writer);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_blobs_close(blobs);
}

/* --- refusals --------------------------------------------------------------------------------- */

VT_TEST(what_a_process_cannot_work_on_is_refused_and_leaves_nothing)
{
    static const struct {
        const char *process, *peak;
        unsigned inputs; /* bit 0: cloud, bit 1: reference */
        const char *parameter, *says;
    } cases[] = {
        {"measure", NULL, 0, "cloud", "measure needs a cloud, but the request has none"},
        {"measure", NULL, 2, "cloud", "measure needs a cloud, but the request has none"},
        {"measure", "2", 1, "peak",
         "the parameter peak is 2, which needs a reference cloud, but the request has none"},
        {"resample", NULL, 3, "reference", "the process resample has no input reference"},
        {"resample", NULL, 2, "reference", "the process resample has no input reference"},
        {"resample", NULL, 0, "cloud", "resample needs a cloud, but the request has none"},
    };
    struct vt_daemon daemon;
    struct vor_uuid id;
    struct pair pair;

    vt_daemon_start(&daemon, vt_dir_make(), NULL);
    pair_make(&pair);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        struct vt_input given[3] = {{NULL, NULL}};
        unsigned count = 0;

        vor_spec_preset(&pair.spec, vor_process_find(cases[k].process));
        if (vor_process_takes(pair.spec.process, VOR_PARAM_POINTS))
            vt_assert_ok(vor_spec_set(&pair.spec, "points", "50", &vt_err));
        if (cases[k].peak != NULL)
            vt_assert_ok(vor_spec_set(&pair.spec, "peak", cases[k].peak, &vt_err));
        for (unsigned i = 0; i < 2; i++)
            if (cases[k].inputs >> i & 1)
                given[count++] = pair.inputs[i];
        ck_assert_int_eq(vt_daemon_submit_inputs(&daemon, given, &pair.spec, &id), VOR_FAILED);
        ck_assert_int_eq(vt_err.status, VOR_E_PARAM);
        ck_assert_str_eq(vt_err.parameter, cases[k].parameter);
        ck_assert_str_eq(vt_err.message, cases[k].says);
        ck_assert_int_eq(vt_daemon_kept(&daemon), 0);
    }
    pair_free(&pair);
    vt_daemon_stop(&daemon);
}

/* --- crashes ---------------------------------------------------------------------------------- */

struct crash {
    const char *dir;
    const struct pair *pair;
    int fd;           /* told the id */
    uint32_t instant; /* die while this event of the job is published */
};

static void die_at_instant(void *ctx, enum vor_event_kind kind)
{
    struct crash *crash = ctx;

    (void)kind;
    if (--crash->instant == 1) /* the first event came before the subscriber */
        raise(SIGKILL);
}

/* Submits behind a job that never ends, tells the id, lets it run. */
static void run_and_die(void *ctx)
{
    struct crash *crash = ctx;
    struct vor_subscriber subscriber = {.wake = die_at_instant, .ctx = crash};
    struct vor_uuid blocker, id;
    struct vt_daemon daemon;
    struct vor_followed followed;

    vt_daemon_start(&daemon, crash->dir, &one_runner);
    blocker = vt_daemon_submit_endless(&daemon);
    id = submit(&daemon, crash->pair);
    (void)!write(crash->fd, &id, sizeof id);
    if (crash->instant == 1)
        raise(SIGKILL);
    ck_assert_int_eq(vor_job_service_follow(daemon.service, &id, NULL, &followed, &vt_err),
                     VOR_DONE);
    vor_job_subscribe(followed.job, &subscriber);
    ck_assert_int_eq(vor_job_service_cancel(daemon.service, &blocker, "off you go", &vt_err),
                     VOR_DONE);
    for (;;)
        pause();
}

/* Killed while it waits, when it was claimed, before its document is written, and with its last row
 * just written: the next life has both clouds, and the same document. */
VT_TEST_LOOP(both_inputs_survive_kill_9, VT_ONCE(4))
{
    struct crash crash = {.instant = (uint32_t)_i + 1};
    struct vor_text wanted;
    struct vor_job_view view;
    struct vt_daemon daemon;
    struct vor_uuid id;
    struct pair pair;
    const char *dir;
    int ends[2];

    pair_make(&pair);
    direct(&pair, 2, &wanted);
    dir = vt_dir_make();
    ck_assert_int_eq(pipe(ends), 0);
    crash.dir = dir;
    crash.pair = &pair;
    crash.fd = ends[1];
    vt_killed(run_and_die, &crash);
    ck_assert_int_eq(read(ends[0], &id, sizeof id), sizeof id);
    vt_daemon_start(&daemon, dir, NULL);
    view = vt_daemon_wait_over(&daemon, &id);
    expect_successful(&view);
    ck_assert_uint_eq(view.inputs, 3);
    ck_assert_uint_eq(view.input[1].points, 900);
    ck_assert_uint_eq(strlen(view.input[1].sha256), VOR_DIGEST_SIZE - 1);
    ck_assert_uint_eq(view.attempt, _i == 1 || _i == 2 ? 2 : 1);
    expect_document(&daemon, &id, &wanted);
    vor_text_free(&wanted);
    pair_free(&pair);
    vt_daemon_stop(&daemon);
}

/* A job that waits in a directory whose daemon is down. */
static struct vor_uuid leave_waiting(const char *dir)
{
    struct vt_daemon daemon;
    struct vor_uuid blocker, id;
    struct pair pair;

    vt_daemon_start(&daemon, dir, &one_runner);
    pair_make(&pair);
    blocker = vt_daemon_submit_endless(&daemon);
    id = submit(&daemon, &pair);
    vor_job_service_drain(daemon.service, 0);
    ck_assert_int_eq(vor_job_service_dismiss(daemon.service, &blocker, "", NULL, &vt_err),
                     VOR_DONE);
    vt_daemon_stop(&daemon);
    pair_free(&pair);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), 2);
    return id;
}

VT_TEST_LOOP(a_job_that_lost_an_input_fails_and_names_it, 2)
{
    static const char *const inputs[] = {"cloud", "reference"};
    const char *dir = vt_dir_make();
    struct vor_uuid id = leave_waiting(dir);
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    char blob[VOR_BLOB_NAME_MAX + 1], says[64];
    struct vor_job_view view;
    struct vt_daemon daemon;

    vt_assert_ok(vor_blob_drop(blobs, &id, vor_blob_of_input(inputs[_i], blob), &vt_err));
    vor_blobs_close(blobs);
    vt_daemon_start(&daemon, dir, NULL);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_FAILED);
    (void)snprintf(says, sizeof says, "the job's input %s no longer exists", inputs[_i]);
    ck_assert_str_eq(view.message, says);
    while (vt_daemon_kept(&daemon) > 0) /* the other one: the sweeper's work */
        vt_nap();
    vt_daemon_stop(&daemon);
}

/* Else it would be run with defaults that nobody asked for: all of this process's are allowed. */
VT_TEST(a_job_whose_request_cannot_be_read_is_not_run)
{
    const char *dir = vt_dir_make();
    struct vor_uuid id = leave_waiting(dir);
    struct vor_job_view view;
    struct vt_daemon daemon;
    sqlite3 *db = NULL;
    char path[512];

    (void)snprintf(path, sizeof path, "%s/jobs.sqlite", dir);
    ck_assert_int_eq(sqlite3_open(path, &db), SQLITE_OK);
    ck_assert_int_eq(sqlite3_exec(db,
                                  "UPDATE job_text SET request = '{\"peak\":\"high\"}'"
                                  " WHERE seq IN (SELECT seq FROM job WHERE status = 'accepted')",
                                  NULL, NULL, NULL),
                     SQLITE_OK);
    ck_assert_int_eq(sqlite3_changes(db), 1);
    sqlite3_close(db);
    vt_daemon_start(&daemon, dir, NULL);
    view = vt_daemon_wait_over(&daemon, &id);
    ck_assert_int_eq(view.status, VOR_JOB_FAILED);
    ck_assert_str_eq(view.message, "the job's request cannot be read by this version");
    while (vt_daemon_kept(&daemon) > 0)
        vt_nap();
    vt_daemon_stop(&daemon);
}

/* --- what is left ----------------------------------------------------------------------------- */

static void keep(const char *dir, const struct vor_uuid *id, const char *name)
{
    struct vor_blobs *blobs = vt_dir_blobs(dir);

    vt_assert_ok(vor_blob_commit(vt_upload(blobs, "rubbish", 7), id, name, &vt_err));
    vor_blobs_close(blobs);
}

VT_TEST(a_start_removes_what_is_no_output_of_a_success)
{
    const char *dir = vt_dir_make();
    struct vt_daemon daemon;
    struct vor_job_view view;
    struct vor_uuid id;
    struct pair pair;
    size_t size;

    vt_daemon_start(&daemon, dir, NULL);
    pair_make(&pair);
    id = submit(&daemon, &pair);
    view = vt_daemon_wait_over(&daemon, &id);
    expect_successful(&view);
    vt_daemon_stop(&daemon);
    keep(dir, &id, "input");
    keep(dir, &id, "input-reference");
    keep(dir, &id, "cloud"); /* resample has one, measure has none */
    vt_daemon_start(&daemon, dir, NULL);
    while (vt_daemon_kept(&daemon) > 1)
        vt_nap();
    free(vt_daemon_output(&daemon, &id, "measure", &size));
    ck_assert_uint_eq(size, view.output[0].bytes);
    pair_free(&pair);
    vt_daemon_stop(&daemon);
}

enum ending { REMOVED, EXPIRED, DISMISSED_WAITING, DISMISSED_AT_ANY_TIME, REFUSED, ENDINGS };

static void end_job(struct vt_daemon *daemon, struct pair *pair, enum ending ending)
{
    struct timespec ttl = {.tv_nsec = 60000000};
    struct vor_uuid id = submit(daemon, pair);

    if (ending != DISMISSED_WAITING && ending != DISMISSED_AT_ANY_TIME) {
        (void)vt_daemon_wait_over(daemon, &id);
        vt_daemon_wait_idle(daemon);
        ck_assert_int_eq(vt_daemon_kept(daemon), ending == REFUSED ? 0 : 1);
    }
    if (ending == EXPIRED) {
        nanosleep(&ttl, NULL);
        vt_assert_ok(vor_job_service_sweep(daemon->service, &vt_err));
    } else if (ending != REFUSED) {
        ck_assert_int_eq(vor_job_service_dismiss(daemon->service, &id, "", NULL, &vt_err),
                         VOR_DONE);
    }
}

/* However a job ends, nothing of it is left once its results are not. */
VT_TEST_LOOP(the_bytes_of_a_job_all_go, VT_ONCE(ENDINGS))
{
    struct vt_daemon_options options = {.jobs = 1, .ttl_seconds = _i == EXPIRED ? 0.05 : 0};
    struct vt_daemon daemon;
    struct vor_uuid blocker;
    struct pair pair;

    vt_daemon_start(&daemon, vt_dir_make(), &options);
    pair_make(&pair);
    if (_i == REFUSED)
        memset(pair.reference.xyz, 0, 3 * pair.reference.n * sizeof(float));
    if (_i == DISMISSED_WAITING)
        blocker = vt_daemon_submit_endless(&daemon);
    for (int k = 0; k < (_i == DISMISSED_AT_ANY_TIME ? 12 : 1); k++)
        end_job(&daemon, &pair, (enum ending)_i);
    if (_i == DISMISSED_WAITING) {
        ck_assert_int_eq(vt_daemon_kept(&daemon), 1); /* the other one's input */
        ck_assert_int_eq(vor_job_service_cancel(daemon.service, &blocker, "enough", &vt_err),
                         VOR_DONE);
    }
    vt_daemon_wait_idle(&daemon);
    ck_assert_int_eq(vt_daemon_kept(&daemon), 0);
    ck_assert_int_eq(vt_dir_count(daemon.dir, "blobs/tmp"), 0);
    pair_free(&pair);
    vt_daemon_stop(&daemon);
}

/* --- names ------------------------------------------------------------------------------------ */

VT_TEST(no_two_artefacts_of_a_process_share_a_blob)
{
    const struct vor_process_info *process;
    char blob[VOR_BLOB_NAME_MAX + 1];

    ck_assert_str_eq(vor_blob_of_input("cloud", blob), "input");
    ck_assert_str_eq(vor_blob_of_input("reference", blob), "input-reference");
    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++) {
        for (unsigned k = 0; process->outputs[k].name != NULL; k++) {
            const char *name = process->outputs[k].name;

            ck_assert_msg(strcmp(name, "input") != 0 && strncmp(name, "input-", 6) != 0, "%s",
                          name);
            ck_assert_uint_le(strlen(name), VOR_BLOB_NAME_MAX);
        }
        for (unsigned k = 0; process->inputs[k].name != NULL; k++)
            ck_assert_uint_le(strlen(process->inputs[k].name), VOR_BLOB_NAME_MAX - 6);
    }
}

VT_LOG(VOR_LOG_OFF)
