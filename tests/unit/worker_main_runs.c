/* Real runs in a worker process: what they give beside runs in this process, and what becomes of
 * them when their encoder or their input fails. */
#include "proto/dump.h"
#include "server/base/log.h"
#include "server/work/codec_child.h"
#include "server/work/execute.h"
#include "server/work/worker_main.h"
#include "tests/support/vt.h"
#include "tests/support/vt_daemon.h"
#include "tests/support/vt_front.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Codec children that do not encode. */
static int crash(int channel, const int *fds, unsigned fd_count)
{
    (void)channel;
    (void)fds;
    (void)fd_count;
    (void)signal(SIGABRT, SIG_DFL);
    return raise(SIGABRT);
}

static int sleep_on(int channel, const int *fds, unsigned fd_count)
{
    (void)channel;
    (void)fds;
    (void)fd_count;
    return pause();
}

enum { STATION, CODEC, CRASHING_CODEC, SLEEPING_CODEC, KINDS };

static const struct vor_child_kind kinds[KINDS] = {
    [STATION] = {"t-worker", vor_worker_main},
    [CODEC] = {"t-codec", vor_codec_child},
    [CRASHING_CODEC] = {"t-crash", crash},
    [SLEEPING_CODEC] = {"t-sleep", sleep_on},
};

/* A worker whose results are encoded by children of that kind; 0: by itself. */
static struct vt_front front_with_codec(unsigned codec)
{
    struct vor_supervisor_config config = {.kind = STATION, .cancel_seconds = 10};
    struct vor_error why;

    if (codec != 0)
        config.codec = (struct vor_codec_place){.kind = codec, .sandbox = vor_sandbox_probe(&why)};
    return vt_front_start(kinds, KINDS, config);
}

/* A file with the dump of a sphere, as the input of a job. */
static FILE *dump_sphere(size_t n)
{
    FILE *file = tmpfile();
    struct vor_blob_writer *writer = vor_blob_borrow(fileno(file));
    const struct vor_sink sink = vor_blob_sink(writer);
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, 3, n);
    vt_assert_ok(vor_dump_write(&sink, &cloud, &vt_err));
    vor_cloud_free(&cloud);
    vt_assert_ok(vor_blob_seal(writer, &vt_err));
    vor_blob_discard(writer);
    return file;
}

struct files {
    FILE *in, *out;
};

static struct vor_order real_order(struct files *files)
{
    struct vor_order order = vt_order_of((size_t)1 << 28);

    vt_assert_ok(vor_spec_set_number(&order.spec, "points", 300, &vt_err));
    vt_assert_ok(vor_spec_set_number(&order.spec, "polish", 5, &vt_err));
    files->in = dump_sphere(2000);
    files->out = tmpfile();
    order.input[0] = fileno(files->in);
    order.output[0] = fileno(files->out);
    return order;
}

/* The bytes that a run writes; their number in *size. */
static char *written(struct files *files, size_t *size)
{
    char *bytes;

    *size = (size_t)lseek(fileno(files->out), 0, SEEK_END);
    bytes = malloc(*size + 1);
    ck_assert_int_eq(pread(fileno(files->out), bytes, *size, 0), (ssize_t)*size);
    (void)fclose(files->in);
    (void)fclose(files->out);
    return bytes;
}

/* Everything up to the seconds, which differ. */
static size_t before_seconds(const struct vor_text *kept)
{
    const char *at = strstr(kept->data, "\"seconds\"");

    ck_assert_ptr_nonnull(at);
    return (size_t)(at - kept->data);
}

/* _i: the format, with and without children that encode. The one there goes on from a checkpoint of
 * the one here without them, and with them it is the other way round. */
VT_TEST_LOOP(a_run_in_another_process_gives_what_one_in_this_gives, 4)
{
    struct vt_front front = _i / 2 == 0 ? front_with_codec(0) : front_with_codec(CODEC);
    struct vt_run_here here;
    struct vt_heard heard[2] = {{.front = &front, .offered = tmpfile()},
                                {.front = &front, .offered = tmpfile()}};
    struct files files[2];
    char *got[2];
    size_t size[2];
    struct vor_pool *pool;

    vt_assert_ok(vor_pool_create(&pool, 2, &vt_err));
    vt_run_here_init(&here, pool);
    for (int i = 0; i < 2; i++) {
        struct vor_order order = real_order(&files[i]);

        vt_assert_ok(vor_spec_set_number(&order.spec, "iterations", 300, &vt_err));
        order.format = (unsigned)_i % 2;
        order.every = 1;
        order.saved = i == 0 ? -1 : fileno(heard[0].offered);
        vt_heard_run(&heard[i],
                     i == _i / 2 ? &here.base : vor_supervisor_executor(front.supervisor), &order);
        ck_assert_int_eq(heard[i].end, VOR_RUN_DONE);
        ck_assert_int_eq(heard[i].resumed, i);
        ck_assert_uint_gt(heard[i].saved, 0);
        got[i] = written(&files[i], &size[i]);
        ck_assert_uint_eq(heard[i].result.output[0].bytes, size[i]);
        ck_assert_int_eq(heard[i].stages, 1);
    }
    ck_assert_uint_eq(size[0], size[1]);
    ck_assert_mem_eq(got[0], got[1], size[0]);
    ck_assert_str_eq(heard[0].result.output[0].sha256, heard[1].result.output[0].sha256);
    ck_assert_str_eq(heard[0].result.message, heard[1].result.message);
    ck_assert_int_ge(heard[0].records, heard[1].records);
    ck_assert_uint_eq(before_seconds(&heard[0].kept), before_seconds(&heard[1].kept));
    ck_assert_mem_eq(heard[0].kept.data, heard[1].kept.data, before_seconds(&heard[0].kept));
    for (int i = 0; i < 2; i++) {
        free(got[i]);
        (void)fclose(heard[i].offered);
        vor_text_free(&heard[i].kept);
    }
    vor_pool_destroy(pool);
    vt_front_stop(&front);
}

static void *run_real(void *arg)
{
    struct vt_heard *heard = arg;
    struct files files;
    struct vor_order order = real_order(&files);

    order.format = VOR_FORMAT_DRC; /* by a codec child */
    vt_heard_run(heard, vor_supervisor_executor(heard->front->supervisor), &order);
    (void)fclose(files.in);
    (void)fclose(files.out);
    return NULL;
}

/* Begins a real run. */
static void begin_real(struct vt_heard *heard, const struct vt_front *front)
{
    memset(heard, 0, sizeof *heard);
    heard->front = front;
    ck_assert_int_eq(pthread_create(&heard->thread, NULL, run_real, heard), 0);
}

VT_TEST(an_encoder_that_crashes_fails_its_own_run_and_nothing_beside_it)
{
    struct vt_front front = front_with_codec(CRASHING_CODEC);
    struct vt_heard heard[3];

    for (int i = 0; i < 3; i++)
        begin_real(&heard[i], &front);
    for (int i = 0; i < 3; i++) {
        pthread_join(heard[i].thread, NULL);
        vor_text_free(&heard[i].kept);
        ck_assert_int_eq(heard[i].end, VOR_RUN_FAILED);
        ck_assert_int_eq(heard[i].err.status, VOR_E_INTERNAL);
        ck_assert_str_eq(heard[i].err.message,
                         "writing the result failed: it crashed (signal 6, exit status 0)");
    }
    ck_assert_uint_eq(vt_front_crashes(), 0);
    vt_front_stop(&front);
}

/* Cancels once the outputs are being written. */
static enum vor_answer cancel_at_end(void *ctx)
{
    return atomic_load(&((struct vt_heard *)ctx)->stages) > 0 ? VOR_CANCEL : VOR_CONTINUE;
}

VT_TEST(a_run_that_is_cancelled_does_not_wait_for_its_encoder)
{
    struct vt_heard heard = {.script = 0};
    struct vor_listener listener = vt_listener_of(&heard);
    struct vor_zygote zygote;
    struct vor_run_means means = {.codec = {.zygote = &zygote, .kind = SLEEPING_CODEC}};
    struct files files;
    struct vor_order order = real_order(&files);

    listener.asked = cancel_at_end;
    order.format = VOR_FORMAT_DRC;
    vt_assert_ok(vor_zygote_start(&zygote, kinds, KINDS, &vt_err));
    vt_assert_ok(vor_pool_create(&means.pool, 1, &vt_err));
    vor_text_init(&heard.kept, 0);
    vt_assert_fails(VOR_E_CANCELLED,
                    vor_execute(&heard.result, &heard.kept, &order, &means, &listener, &vt_err));
    vor_text_free(&heard.kept);
    vor_pool_destroy(means.pool);
    vor_zygote_stop(&zygote);
    (void)fclose(files.in);
    (void)fclose(files.out);
}

VT_TEST(an_input_that_is_no_dump_fails_the_run_and_not_the_worker)
{
    struct vt_front front = front_with_codec(0);
    struct vt_heard heard = {.front = &front};
    struct files files;
    struct vor_order order = real_order(&files);

    ck_assert_int_eq(ftruncate(order.input[0], 30), 0);
    vt_heard_run(&heard, vor_supervisor_executor(front.supervisor), &order);
    ck_assert_int_eq(heard.end, VOR_RUN_FAILED);
    ck_assert_int_ne(heard.err.status, VOR_OK);
    ck_assert_uint_eq(vt_front_crashes(), 0);
    (void)fclose(files.in);
    (void)fclose(files.out);
    vor_text_free(&heard.kept);
    vt_front_stop(&front);
}

void vt_suite(Suite *suite VOR_UNUSED)
{
    vor_log_open(STDERR_FILENO, VOR_LOG_OFF);
}
