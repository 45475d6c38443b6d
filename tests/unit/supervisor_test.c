/* The worker process as the front sees it: runs that end well, that crash, that do not listen, that
 * talk nonsense; and what becomes of those beside them. Runs follow a script here, except where
 * the real ones are compared with runs in this process. */
#include "proto/dump.h"
#include "server/base/log.h"
#include "server/base/metrics.h"
#include "server/work/codec_child.h"
#include "server/work/execute.h"
#include "server/work/station.h"
#include "server/work/supervisor.h"
#include "server/work/wire.h"
#include "tests/support/vt.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* --- a worker that follows a script ----------------------------------------------------------- */

/* What a run does, in the member `memory` of its order. */
enum script {
    SAYS_ALL,     /* a stage, a record, what is kept in two parts, a result */
    SAYS_FAILURE, /* an error */
    OBEYS,        /* tells a stage and waits until it is told to cancel */
    IS_DEAF,      /* tells a stage and never ends */
    ABORTS,
    LEAVES, /* the process ends with 4, as of memory used up */
    STOPS,  /* the process stands still */
    SAYS_NONSENSE,
    ENDS_LATER /* a result, and the process ends a little later */
};

enum { KEPT_SIZE = VOR_KEPT_PART + 100 };

static struct vor_board *script_board;

static void nap(long ms)
{
    const struct timespec pause = {ms / 1000, ms % 1000 * 1000000};

    (void)nanosleep(&pause, NULL);
}

static int says(int channel, enum vor_said what, const void *of, size_t size)
{
    return vor_say(channel, what, of, size) == VOR_OK;
}

static int say_wait(int channel)
{
    struct vor_error error;

    (void)vor_fail(&error, VOR_E_IO, "full");
    return says(channel, VOR_SAID_WAITS, &error, sizeof error);
}

static int say_all(int channel)
{
    char kept[KEPT_SIZE];
    const struct vor_record record = {.iteration = 7, .delta = 0.25};
    const struct vor_run_result result = {
        .has_report = 1, .report.delta = 0.5, .message = "as the script says"};
    const enum vor_stage stage = VOR_STAGE_ENCODE;

    memset(kept, 'k', sizeof kept);
    if (!say_wait(channel))
        return 0;
    return says(channel, VOR_SAID_RECORD, &record, sizeof record) &&
           says(channel, VOR_SAID_STAGE, &stage, sizeof stage) &&
           says(channel, VOR_SAID_KEPT, kept, VOR_KEPT_PART) &&
           says(channel, VOR_SAID_KEPT, kept, KEPT_SIZE - VOR_KEPT_PART) &&
           says(channel, VOR_SAID_DONE, &result, sizeof result);
}

static int say_failure(int channel, vor_status status, const char *message)
{
    struct vor_error error;

    (void)vor_fail(&error, status, "%s", message);
    return says(channel, VOR_SAID_FAILED, &error, sizeof error);
}

static void act(enum script script, unsigned seat, int channel)
{
    const enum vor_stage stage = VOR_STAGE_ENCODE;
    int spoke = 1;

    if (script == OBEYS || script == IS_DEAF)
        spoke = says(channel, VOR_SAID_STAGE, &stage, sizeof stage);
    if (script == SAYS_ALL || script == ENDS_LATER)
        spoke = say_all(channel);
    else if (script == SAYS_FAILURE)
        spoke = say_failure(channel, VOR_E_TARGET, "no");
    else if (script == SAYS_NONSENSE)
        spoke = says(channel, VOR_SAID_KINDS, "?", 1);
    else if (script == LEAVES)
        _exit(VOR_STATION_NO_MEMORY);
    else if (script == STOPS)
        (void)raise(SIGSTOP);
    while (script == ABORTS) {
        (void)signal(SIGABRT, SIG_DFL);
        (void)raise(SIGABRT);
    }
    while (script == OBEYS && atomic_load(&script_board->asked[seat]) != VOR_CANCEL)
        nap(1);
    while (script == IS_DEAF)
        nap(1000);
    if (script == OBEYS)
        spoke = say_failure(channel, VOR_E_CANCELLED, "cancelled by the caller");
    if (!spoke || script == ENDS_LATER) {
        nap(20);
        _exit(1);
    }
}

struct part {
    unsigned seat;
    int channel;
};

static void *play(void *arg)
{
    struct part *part = arg;
    struct vor_order order;

    if (vor_order_receive(&order, part->channel, 20, NULL) == VOR_OK)
        act((enum script)order.memory, part->seat, part->channel);
    vor_order_close(&order);
    close(part->channel);
    free(part);
    return NULL;
}

static int scripted(int channel, const int *fds, unsigned fd_count)
{
    struct vor_summons summons;
    struct vor_message message = {.bytes = &summons, .capacity = sizeof summons};

    if (fd_count != 1 || vor_channel_send(channel, "", 1, NULL, 0, NULL) != VOR_OK)
        return 1;
    script_board = vor_board_map(fds[0]);
    while (vor_channel_receive(channel, &message, -1) == VOR_CHANNEL_MESSAGE) {
        struct part *part = malloc(sizeof *part);
        pthread_t thread;

        *part = (struct part){summons.seat, message.fds[0]};
        if (pthread_create(&thread, NULL, play, part) != 0)
            return 1;
        pthread_detach(thread);
    }
    return 0;
}

/* A process that gives up before it is ready. */
static int unready(int channel, const int *fds, unsigned fd_count)
{
    (void)channel;
    (void)fds;
    (void)fd_count;
    return VOR_STATION_NO_POOL;
}

/* A process whose engine does not work. */
static int unfit(int channel, const int *fds, unsigned fd_count)
{
    struct vor_error err;

    (void)fds;
    (void)fd_count;
    (void)vor_fail(&err, VOR_E_INTERNAL, "a uniformity of 0.5, at most 0.1 is right");
    return vor_channel_send(channel, &err, sizeof err, NULL, 0, NULL) == VOR_OK ? 0 : 1;
}

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

enum { SCRIPTED, STATION, UNREADY, UNFIT, CODEC, CRASHING_CODEC, SLEEPING_CODEC, KINDS };

static const struct vor_child_kind kinds[KINDS] = {
    [SCRIPTED] = {"t-scripted", scripted},    [STATION] = {"t-station", vor_station_run},
    [UNREADY] = {"t-unready", unready},       [UNFIT] = {"t-unfit", unfit},
    [CODEC] = {"t-codec", vor_codec_child},   [CRASHING_CODEC] = {"t-crash", crash},
    [SLEEPING_CODEC] = {"t-sleep", sleep_on},
};

/* --- the front -------------------------------------------------------------------------------- */

struct front {
    struct vor_zygote *zygote; /* malloc */
    struct vor_supervisor *supervisor;
};

static struct front front_of(struct vor_supervisor_config config)
{
    struct front front = {.zygote = malloc(sizeof *front.zygote)};

    config.zygote = front.zygote;
    if (config.codec.kind != 0)
        config.codec.zygote = front.zygote;
    config.threads = 2;
    config.memory = (size_t)1 << 28;
    vt_assert_ok(vor_zygote_start(front.zygote, kinds, KINDS, &vt_err));
    vt_assert_ok(vor_supervisor_create(&front.supervisor, &config, &vt_err));
    return front;
}

static struct front front_start(unsigned kind, double cancel_seconds, double stall_seconds)
{
    return front_of((struct vor_supervisor_config){
        .kind = kind, .cancel_seconds = cancel_seconds, .stall_seconds = stall_seconds});
}

/* Whose worker has results encoded by children of that kind. */
static struct front front_with_codec(unsigned codec)
{
    struct vor_error why;

    return front_of((struct vor_supervisor_config){
        .kind = STATION,
        .cancel_seconds = 10,
        .codec = {.kind = codec, .sandbox = vor_sandbox_probe(&why)}});
}

static void front_stop(struct front *front)
{
    vor_supervisor_destroy(front->supervisor);
    vor_zygote_stop(front->zygote);
    free(front->zygote);
}

static struct vor_supervisor_counts counts_of(const struct front *front)
{
    struct vor_supervisor_counts counts;

    vor_supervisor_counts(front->supervisor, &counts);
    return counts;
}

/* A run and what it told. */
struct heard {
    const struct front *front;
    enum script script;
    int is_suspect, file; /* file: of the order, 0 for none */
    atomic_int asked;     /* enum vor_answer */
    atomic_int is_over;
    atomic_int stages;
    int records, waits;
    struct vor_record record;
    struct vor_run_result result;
    struct vor_text kept;
    struct vor_error err;
    enum vor_run_end end;
    pthread_t thread;
};

static enum vor_answer answer(void *ctx)
{
    return (enum vor_answer)atomic_load(&((struct heard *)ctx)->asked);
}

static void hear_record(void *ctx, const struct vor_record *record)
{
    struct heard *heard = ctx;

    heard->records++;
    heard->record = *record;
}

static void hear_stage(void *ctx, enum vor_stage stage)
{
    struct heard *heard = ctx;

    if (stage == VOR_STAGE_ENCODE)
        atomic_fetch_add(&heard->stages, 1);
}

static void hear_wait(void *ctx, const struct vor_error *why)
{
    (void)why;
    ((struct heard *)ctx)->waits++;
}

static struct vor_order order_of(size_t memory)
{
    struct vor_order order = {.memory = memory};

    vor_spec_init(&order.spec);
    for (int i = 0; i < VOR_INPUTS_MAX; i++)
        order.input[i] = -1;
    for (int i = 0; i < VOR_OUTPUTS_MAX; i++)
        order.output[i] = -1;
    return order;
}

static void run_at(struct heard *heard, struct vor_run_executor *executor,
                   const struct vor_order *order)
{
    const struct vor_listener listener = {.ctx = heard,
                                          .asked = answer,
                                          .progress = hear_record,
                                          .stage = hear_stage,
                                          .waits = hear_wait};

    vor_text_init(&heard->kept, 0);
    heard->end =
        executor->run(executor, order, &listener, &heard->result, &heard->kept, &heard->err);
}

static void *run_script(void *arg)
{
    struct heard *heard = arg;
    struct vor_order order = order_of((size_t)heard->script);

    order.is_suspect = heard->is_suspect;
    if (heard->file > 0)
        order.output[0] = heard->file;
    run_at(heard, vor_supervisor_executor(heard->front->supervisor), &order);
    atomic_store(&heard->is_over, 1);
    return NULL;
}

static void begin_as(struct heard *heard, const struct front *front, enum script script,
                     int is_suspect)
{
    memset(heard, 0, sizeof *heard);
    heard->front = front;
    heard->script = script;
    heard->is_suspect = is_suspect;
    ck_assert_int_eq(pthread_create(&heard->thread, NULL, run_script, heard), 0);
}

/* Begins a run that follows a script. */
static void begin(struct heard *heard, const struct front *front, enum script script)
{
    begin_as(heard, front, script, 0);
}

static void wait_seated(struct heard *heard)
{
    while (atomic_load(&heard->stages) == 0)
        nap(1);
}

static enum vor_run_end end_of(struct heard *heard)
{
    pthread_join(heard->thread, NULL);
    vor_text_free(&heard->kept);
    return heard->end;
}

static enum vor_run_end end_of_script(struct heard *heard, const struct front *front,
                                      enum script script)
{
    begin(heard, front, script);
    return end_of(heard);
}

/* --- what a run tells ------------------------------------------------------------------------- */

START_TEST(a_run_tells_its_records_its_stage_and_its_result)
{
    struct front front = front_start(SCRIPTED, 0, 0);
    struct heard heard;

    begin(&heard, &front, SAYS_ALL);
    pthread_join(heard.thread, NULL);
    ck_assert_int_eq(heard.end, VOR_RUN_DONE);
    ck_assert_int_eq(heard.records, 1);
    ck_assert_int_eq(heard.stages, 1);
    ck_assert_int_eq(heard.waits, 1);
    ck_assert_uint_eq(heard.record.iteration, 7);
    ck_assert_double_eq(heard.record.delta, 0.25);
    ck_assert_double_eq(heard.result.report.delta, 0.5);
    ck_assert_str_eq(heard.result.message, "as the script says");
    ck_assert_uint_eq(heard.kept.size, KEPT_SIZE);
    ck_assert_uint_eq(strspn(heard.kept.data, "k"), KEPT_SIZE);
    vor_text_free(&heard.kept);
    ck_assert_int_eq(end_of_script(&heard, &front, SAYS_FAILURE), VOR_RUN_FAILED);
    ck_assert_int_eq(heard.err.status, VOR_E_TARGET);
    ck_assert_str_eq(heard.err.message, "no");
    ck_assert_uint_eq(counts_of(&front).crashed, 0);
    front_stop(&front);
}
END_TEST

START_TEST(what_a_listener_answers_reaches_its_run_and_no_other)
{
    struct front front = front_start(SCRIPTED, 0, 0);
    struct heard obeys, other;

    begin(&other, &front, OBEYS);
    begin(&obeys, &front, OBEYS);
    wait_seated(&other);
    wait_seated(&obeys);
    atomic_store(&obeys.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&obeys), VOR_RUN_FAILED);
    ck_assert_int_eq(obeys.err.status, VOR_E_CANCELLED);
    nap(50);
    ck_assert(!atomic_load(&other.is_over));
    atomic_store(&other.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&other), VOR_RUN_FAILED);
    ck_assert_uint_eq(counts_of(&front).crashed, 0);
    front_stop(&front);
}
END_TEST

/* --- crashes ---------------------------------------------------------------------------------- */

START_TEST(a_crash_with_nothing_beside_it_is_told_as_such_and_the_next_run_has_a_new_worker)
{
    static const struct {
        enum script script;
        const char *says;
    } cases[] = {
        {ABORTS, "the worker crashed (signal 6)"},
        {LEAVES, "the worker crashed (memory used up)"},
        {SAYS_NONSENSE, "the worker crashed (signal 9)"},
    };
    struct front front = front_start(SCRIPTED, 0, 0);
    struct heard heard;

    ck_assert_int_eq(end_of_script(&heard, &front, cases[_i].script), VOR_RUN_CRASHED_ALONE);
    ck_assert_str_eq(heard.err.message, cases[_i].says);
    ck_assert_int_eq(end_of_script(&heard, &front, SAYS_ALL), VOR_RUN_DONE);
    ck_assert_uint_eq(counts_of(&front).crashed, 1);
    ck_assert_uint_eq(counts_of(&front).started, 2);
    front_stop(&front);
}
END_TEST

START_TEST(a_crash_is_told_to_all_that_ran_there)
{
    struct front front = front_start(SCRIPTED, 0, 0);
    struct heard beside[3], heard;
    struct vor_text numbers;

    vor_metrics_reset();
    for (int i = 0; i < 3; i++)
        begin(&beside[i], &front, OBEYS);
    for (int i = 0; i < 3; i++)
        wait_seated(&beside[i]);
    ck_assert_int_eq(end_of_script(&heard, &front, ABORTS), VOR_RUN_CRASHED);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(end_of(&beside[i]), VOR_RUN_CRASHED);
    ck_assert_uint_eq(counts_of(&front).crashed, 1);
    vor_text_init(&numbers, 0);
    vor_metrics_write(&numbers);
    ck_assert_ptr_nonnull(strstr(numbers.data, "\nvoronoid_worker_restarts_total 1\n"));
    vor_text_free(&numbers);
    front_stop(&front);
}
END_TEST

START_TEST(a_suspect_runs_in_a_process_of_its_own)
{
    struct front front = front_start(SCRIPTED, 0, 0);
    struct heard beside, suspects[2], heard;

    begin(&beside, &front, OBEYS);
    begin_as(&suspects[0], &front, OBEYS, 1);
    begin_as(&suspects[1], &front, ABORTS, 1);
    wait_seated(&beside);
    wait_seated(&suspects[0]);
    ck_assert_int_eq(end_of(&suspects[1]), VOR_RUN_CRASHED_ALONE);
    ck_assert_int_eq(end_of_script(&heard, &front, ABORTS), VOR_RUN_CRASHED);
    ck_assert_int_eq(end_of(&beside), VOR_RUN_CRASHED);
    ck_assert(!atomic_load(&suspects[0].is_over));
    atomic_store(&suspects[0].asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&suspects[0]), VOR_RUN_FAILED);
    ck_assert_int_eq(suspects[0].err.status, VOR_E_CANCELLED);
    begin_as(&heard, &front, SAYS_ALL, 1);
    ck_assert_int_eq(end_of(&heard), VOR_RUN_DONE);
    ck_assert_uint_eq(counts_of(&front).started, 4);
    ck_assert_uint_eq(counts_of(&front).crashed, 2);
    front_stop(&front);
}
END_TEST

START_TEST(a_worker_that_ended_between_two_runs_costs_neither)
{
    struct front front = front_start(SCRIPTED, 0, 0);
    struct heard heard = {.front = &front, .script = ENDS_LATER};
    int ends[2];
    char byte;

    ck_assert_int_eq(pipe(ends), 0);
    heard.file = ends[1];
    (void)run_script(&heard);
    vor_text_free(&heard.kept);
    ck_assert_int_eq(heard.end, VOR_RUN_DONE);
    close(ends[1]);
    ck_assert_int_eq(read(ends[0], &byte, 1), 0); /* the kernel closes what it had */
    close(ends[0]);
    nap(50);
    ck_assert_int_eq(end_of_script(&heard, &front, SAYS_ALL), VOR_RUN_DONE);
    ck_assert_uint_eq(counts_of(&front).started, 2);
    front_stop(&front);
}
END_TEST

START_TEST(a_worker_without_a_sign_of_life_is_ended)
{
    struct front front = front_start(SCRIPTED, 0, 0.4);
    struct heard heard;

    ck_assert_int_eq(end_of_script(&heard, &front, STOPS), VOR_RUN_CRASHED_ALONE);
    ck_assert_str_eq(heard.err.message, "the worker crashed (no sign of life)");
    ck_assert_int_eq(end_of_script(&heard, &front, SAYS_ALL), VOR_RUN_DONE);
    front_stop(&front);
}
END_TEST

/* --- runs that do not listen ------------------------------------------------------------------ */

START_TEST(a_cancelled_run_that_does_not_end_is_ended_and_blamed_alone)
{
    struct front front = front_start(SCRIPTED, 1, 0);
    struct heard deaf, beside;

    begin(&beside, &front, OBEYS);
    begin(&deaf, &front, IS_DEAF);
    wait_seated(&beside);
    wait_seated(&deaf);
    atomic_store(&deaf.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&deaf), VOR_RUN_FAILED);
    ck_assert_int_eq(deaf.err.status, VOR_E_CANCELLED);
    ck_assert_int_eq(end_of(&beside), VOR_RUN_DISTURBED);
    ck_assert_str_eq(beside.err.message, "the worker crashed (a cancelled run did not end)");
    front_stop(&front);
}
END_TEST

START_TEST(a_deaf_run_is_ended_and_one_that_listens_is_not)
{
    struct front front = front_start(SCRIPTED, 2.5, 0);
    struct heard deaf, obeys;

    begin(&deaf, &front, IS_DEAF);
    wait_seated(&deaf);
    atomic_store(&deaf.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&deaf), VOR_RUN_FAILED);
    while (counts_of(&front).crashed == 0) /* nobody waits for it */
        nap(1);
    begin(&obeys, &front, OBEYS);
    wait_seated(&obeys);
    atomic_store(&obeys.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&obeys), VOR_RUN_FAILED);
    ck_assert_uint_eq(counts_of(&front).crashed, 1);
    front_stop(&front);
}
END_TEST

/* --- real runs -------------------------------------------------------------------------------- */

static int sink_file(void *ctx, const void *bytes, size_t size)
{
    return fwrite(bytes, 1, size, ctx) == size ? 0 : -1;
}

/* A file with the dump of a sphere. */
static FILE *dump_sphere(size_t n)
{
    FILE *file = tmpfile();
    const struct vor_sink sink = {file, sink_file};
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, 3, n);
    vt_assert_ok(vor_dump_write(&sink, &cloud, &vt_err));
    vor_cloud_free(&cloud);
    ck_assert_int_eq(fflush(file), 0);
    return file;
}

struct files {
    FILE *in, *out;
};

static struct vor_order real_order(struct files *files)
{
    struct vor_order order = order_of((size_t)1 << 28);

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

/* _i: the format, with and without children that encode. */
START_TEST(a_run_in_another_process_gives_what_one_in_this_gives)
{
    struct front front = _i / 2 == 0 ? front_start(STATION, 0, 0) : front_with_codec(CODEC);
    struct vor_run_here here;
    struct heard there_heard = {.front = &front}, here_heard = {.front = &front};
    struct files there_files, here_files;
    struct vor_order order = real_order(&there_files);
    char *wanted, *got;
    size_t wanted_size, got_size;
    struct vor_pool *pool;

    order.format = (unsigned)_i % 2;
    run_at(&there_heard, vor_supervisor_executor(front.supervisor), &order);
    order = real_order(&here_files);
    order.format = (unsigned)_i % 2;
    vt_assert_ok(vor_pool_create(&pool, 2, &vt_err));
    vor_run_here_init(&here, pool);
    run_at(&here_heard, &here.base, &order);
    ck_assert_int_eq(there_heard.end, VOR_RUN_DONE);
    ck_assert_int_eq(here_heard.end, VOR_RUN_DONE);
    wanted = written(&here_files, &wanted_size);
    got = written(&there_files, &got_size);
    ck_assert_uint_eq(got_size, wanted_size);
    ck_assert_uint_eq(there_heard.result.output[0].bytes, got_size);
    ck_assert_mem_eq(got, wanted, got_size);
    ck_assert_str_eq(there_heard.result.output[0].sha256, here_heard.result.output[0].sha256);
    ck_assert_str_eq(there_heard.result.message, here_heard.result.message);
    ck_assert_int_eq(there_heard.records, here_heard.records);
    ck_assert_int_eq(there_heard.stages, 1);
    ck_assert_uint_eq(before_seconds(&there_heard.kept), before_seconds(&here_heard.kept));
    ck_assert_mem_eq(there_heard.kept.data, here_heard.kept.data, before_seconds(&here_heard.kept));
    free(wanted);
    free(got);
    vor_text_free(&there_heard.kept);
    vor_text_free(&here_heard.kept);
    vor_pool_destroy(pool);
    front_stop(&front);
}
END_TEST

static void *run_real(void *arg)
{
    struct heard *heard = arg;
    struct files files;
    struct vor_order order = real_order(&files);

    run_at(heard, vor_supervisor_executor(heard->front->supervisor), &order);
    (void)fclose(files.in);
    (void)fclose(files.out);
    return NULL;
}

/* Begins a real run. */
static void begin_real(struct heard *heard, const struct front *front)
{
    memset(heard, 0, sizeof *heard);
    heard->front = front;
    ck_assert_int_eq(pthread_create(&heard->thread, NULL, run_real, heard), 0);
}

START_TEST(an_encoder_that_crashes_fails_its_own_run_and_nothing_beside_it)
{
    struct front front = front_with_codec(CRASHING_CODEC);
    struct heard heard[3];

    for (int i = 0; i < 3; i++)
        begin_real(&heard[i], &front);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(end_of(&heard[i]), VOR_RUN_FAILED);
        ck_assert_int_eq(heard[i].err.status, VOR_E_INTERNAL);
        ck_assert_str_eq(heard[i].err.message,
                         "writing the result failed: it crashed (signal 6, exit status 0)");
    }
    ck_assert_uint_eq(counts_of(&front).started, 1);
    ck_assert_uint_eq(counts_of(&front).crashed, 0);
    front_stop(&front);
}
END_TEST

/* Cancels once the outputs are being written. */
static enum vor_answer cancel_at_end(void *ctx)
{
    return atomic_load(&((struct heard *)ctx)->stages) > 0 ? VOR_CANCEL : VOR_CONTINUE;
}

START_TEST(a_run_that_is_cancelled_does_not_wait_for_its_encoder)
{
    struct heard heard = {.script = SAYS_ALL};
    const struct vor_listener listener = {.ctx = &heard,
                                          .asked = cancel_at_end,
                                          .progress = hear_record,
                                          .stage = hear_stage,
                                          .waits = hear_wait};
    struct vor_zygote zygote;
    struct vor_run_means means = {.codec = {.zygote = &zygote, .kind = SLEEPING_CODEC}};
    struct files files;
    struct vor_order order = real_order(&files);

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
END_TEST

START_TEST(an_input_that_is_no_dump_fails_the_run_and_not_the_worker)
{
    struct front front = front_start(STATION, 0, 0);
    struct heard heard = {.front = &front};
    struct files files;
    struct vor_order order = real_order(&files);

    ck_assert_int_eq(ftruncate(order.input[0], 30), 0);
    run_at(&heard, vor_supervisor_executor(front.supervisor), &order);
    ck_assert_int_eq(heard.end, VOR_RUN_FAILED);
    ck_assert_int_ne(heard.err.status, VOR_OK);
    ck_assert_uint_eq(counts_of(&front).crashed, 0);
    (void)fclose(files.in);
    (void)fclose(files.out);
    vor_text_free(&heard.kept);
    front_stop(&front);
}
END_TEST

START_TEST(a_worker_whose_threads_do_not_start_is_an_error)
{
    struct vor_zygote zygote;
    struct vor_supervisor *supervisor;
    struct vor_supervisor_config config = {.zygote = &zygote, .kind = UNREADY, .threads = 2};

    vt_assert_ok(vor_zygote_start(&zygote, kinds, KINDS, &vt_err));
    vt_assert_fails(VOR_E_NOMEM, vor_supervisor_create(&supervisor, &config, &vt_err));
    ck_assert_str_eq(vt_err.message, "the threads of the worker cannot be started");
    config.kind = UNFIT;
    vt_assert_fails(VOR_E_INTERNAL, vor_supervisor_create(&supervisor, &config, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "the engine fails its test of itself: a uniformity of 0.5, at most 0.1 is right");
    vor_zygote_stop(&zygote);
}
END_TEST

/* --- what is said and makes no sense ---------------------------------------------------------- */

START_TEST(words_that_make_no_sense_break_the_channel)
{
    static const enum vor_stage no_stage = VOR_STAGES;
    static const struct vor_record no_record = {.stage = VOR_RUN_STAGE_COUNT};
    static const struct vor_run_result no_format = {.output[1].format = 99};
    static const struct vor_error no_status = {.status = VOR_STATUS_COUNT}, fine = {0};
    static const struct {
        enum vor_said what;
        const void *of;
        size_t size;
    } cases[] = {
        {VOR_SAID_KINDS, "", 0},
        {VOR_SAID_STAGE, &no_stage, sizeof no_stage},
        {VOR_SAID_STAGE, "x", 1},
        {VOR_SAID_RECORD, &no_record, sizeof no_record},
        {VOR_SAID_RECORD, &no_record, sizeof no_record - 1},
        {VOR_SAID_DONE, &no_format, sizeof no_format},
        {VOR_SAID_DONE, &no_format, 8},
        {VOR_SAID_FAILED, &no_status, sizeof no_status},
        {VOR_SAID_FAILED, &fine, sizeof fine}, /* a failure that is none */
    };
    struct vor_message_said said;
    size_t size;
    int ends[2];

    vt_assert_ok(vor_channel_pair(ends, &vt_err));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        vt_assert_ok(vor_say(ends[0], cases[i].what, cases[i].of, cases[i].size));
        ck_assert_msg(vor_hear(&said, &size, ends[1], 1) == VOR_CHANNEL_GONE, "case %zu", i);
    }
    vt_assert_ok(vor_channel_send(ends[0], "x", 1, NULL, 0, &vt_err));
    ck_assert_int_eq(vor_hear(&said, &size, ends[1], 1), VOR_CHANNEL_GONE);
    vt_assert_ok(vor_say(ends[0], VOR_SAID_KEPT, "kept", 4));
    ck_assert_int_eq(vor_hear(&said, &size, ends[1], 1), VOR_CHANNEL_MESSAGE);
    ck_assert_uint_eq(size, 4);
    close(ends[0]);
    close(ends[1]);
}
END_TEST

START_TEST(an_order_arrives_with_its_files_or_not_at_all)
{
    struct vor_order order = order_of(5), got;
    int ends[2];

    vt_assert_ok(vor_channel_pair(ends, &vt_err));
    order.input[2] = STDERR_FILENO;
    order.output[1] = STDERR_FILENO;
    vt_assert_ok(vor_order_send(ends[0], &order, &vt_err));
    vt_assert_ok(vor_order_receive(&got, ends[1], 1, &vt_err));
    ck_assert_ptr_eq(got.spec.process, order.spec.process);
    ck_assert_uint_eq(got.memory, 5);
    ck_assert_int_eq(got.input[0], -1);
    ck_assert_int_ge(got.input[2], 0);
    ck_assert_int_eq(got.output[0], -1);
    ck_assert_int_ge(got.output[1], 0);
    vor_order_close(&got);
    vt_assert_ok(vor_channel_send(ends[0], "no order", 8, ends, 1, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_order_receive(&got, ends[1], 1, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_order_receive(&got, ends[1], 0, &vt_err));
    vor_order_close(&got);
    close(ends[0]);
    close(ends[1]);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("supervisor");

    vor_log_open(STDERR_FILENO, VOR_LOG_OFF);

    vt_add(suite, a_run_tells_its_records_its_stage_and_its_result);
    vt_add(suite, what_a_listener_answers_reaches_its_run_and_no_other);
    vt_add_loop(
        suite, a_crash_with_nothing_beside_it_is_told_as_such_and_the_next_run_has_a_new_worker, 3);
    vt_add(suite, a_crash_is_told_to_all_that_ran_there);
    vt_add(suite, a_suspect_runs_in_a_process_of_its_own);
    vt_add(suite, a_worker_that_ended_between_two_runs_costs_neither);
    vt_add(suite, a_worker_without_a_sign_of_life_is_ended);
    vt_add(suite, a_cancelled_run_that_does_not_end_is_ended_and_blamed_alone);
    vt_add(suite, a_deaf_run_is_ended_and_one_that_listens_is_not);
    vt_add_loop(suite, a_run_in_another_process_gives_what_one_in_this_gives, 4);
    vt_add(suite, an_encoder_that_crashes_fails_its_own_run_and_nothing_beside_it);
    vt_add(suite, a_run_that_is_cancelled_does_not_wait_for_its_encoder);
    vt_add(suite, an_input_that_is_no_dump_fails_the_run_and_not_the_worker);
    vt_add(suite, a_worker_whose_threads_do_not_start_is_an_error);
    vt_add(suite, words_that_make_no_sense_break_the_channel);
    vt_add(suite, an_order_arrives_with_its_files_or_not_at_all);
    return vt_run(suite);
}
