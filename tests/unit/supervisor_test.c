/* The worker process as the front sees it: runs that end well, that crash, that do not listen, that
 * talk nonsense; and what becomes of those beside them. Runs follow a script here; of real ones
 * there is worker_main_runs. */
#include "server/base/log.h"
#include "server/work/ipc_codec.h"
#include "server/work/worker_main.h"
#include "tests/support/vt.h"
#include "tests/support/vt_front.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
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

static struct vor_shared_state *script_state;

/* Shared with the workers: those that start wait as long as it is closed. */
static struct {
    atomic_int is_closed, started;
} * gate;

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
        .has_report = 1, .report.delta = script_state->threads, .message = "as the script says"};
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

static void act(enum script script, unsigned slot, int channel)
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
        _exit(VOR_WORKER_NO_MEMORY);
    else if (script == STOPS)
        (void)raise(SIGSTOP);
    while (script == ABORTS) {
        (void)signal(SIGABRT, SIG_DFL);
        (void)raise(SIGABRT);
    }
    while (script == OBEYS && atomic_load(&script_state->asked[slot]) != VOR_CANCEL)
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
    unsigned slot;
    int channel;
};

static void *play(void *arg)
{
    struct part *part = arg;
    struct vor_order order;

    if (vor_order_receive(&order, part->channel, 20, NULL) == VOR_OK)
        act((enum script)order.memory, part->slot, part->channel);
    vor_order_close(&order);
    close(part->channel);
    free(part);
    return NULL;
}

static int scripted(int channel, const int *fds, unsigned fd_count)
{
    struct vor_run_request request;
    struct vor_message message = {.bytes = &request, .capacity = sizeof request};

    for (atomic_fetch_add(&gate->started, 1); atomic_load(&gate->is_closed);)
        nap(1);
    if (fd_count != 1 || vor_channel_send(channel, "", 1, NULL, 0, NULL) != VOR_OK)
        return 1;
    script_state = vor_shared_state_map(fds[0]);
    while (vor_channel_receive(channel, &message, -1) == VOR_CHANNEL_MESSAGE) {
        struct part *part = malloc(sizeof *part);
        pthread_t thread;

        *part = (struct part){request.slot, message.fds[0]};
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
    return VOR_WORKER_NO_POOL;
}

/* A process whose engine does not work. */
static int unfit(int channel, const int *fds, unsigned fd_count)
{
    struct vor_error err;

    (void)fds;
    (void)fd_count;
    (void)vor_fail(&err, VOR_E_INTERNAL, "delta of the result is 0.5, want at most 0.1");
    return vor_channel_send(channel, &err, sizeof err, NULL, 0, NULL) == VOR_OK ? 0 : 1;
}

enum { SCRIPTED, UNREADY, UNFIT, KINDS };

static const struct vor_child_kind kinds[KINDS] = {
    [SCRIPTED] = {"t-scripted", scripted},
    [UNREADY] = {"t-unready", unready},
    [UNFIT] = {"t-unfit", unfit},
};

/* --- the front -------------------------------------------------------------------------------- */

static struct vt_front front_start(double cancel_seconds, double stall_seconds)
{
    gate = mmap(NULL, sizeof *gate, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    ck_assert_ptr_ne(gate, MAP_FAILED);
    return vt_front_start(kinds, KINDS,
                          (struct vor_supervisor_config){.kind = SCRIPTED,
                                                         .cancel_seconds = cancel_seconds,
                                                         .stall_seconds = stall_seconds});
}

static void *run_script(void *arg)
{
    struct vt_heard *heard = arg;
    struct vor_order order = vt_order_of((size_t)heard->script);

    order.is_suspect = heard->is_suspect;
    if (heard->file > 0)
        order.output[0] = heard->file;
    vt_heard_run(heard, vor_supervisor_executor(heard->front->supervisor), &order);
    atomic_store(&heard->is_over, 1);
    return NULL;
}

static void begin_as(struct vt_heard *heard, const struct vt_front *front, enum script script,
                     int is_suspect)
{
    memset(heard, 0, sizeof *heard);
    heard->front = front;
    heard->script = script;
    heard->is_suspect = is_suspect;
    ck_assert_int_eq(pthread_create(&heard->thread, NULL, run_script, heard), 0);
}

/* Begins a run that follows a script. */
static void begin(struct vt_heard *heard, const struct vt_front *front, enum script script)
{
    begin_as(heard, front, script, 0);
}

static void wait_started(struct vt_heard *heard)
{
    while (atomic_load(&heard->stages) == 0)
        nap(1);
}

static enum vor_run_end end_of(struct vt_heard *heard)
{
    pthread_join(heard->thread, NULL);
    vor_text_free(&heard->kept);
    return heard->end;
}

static enum vor_run_end end_of_script(struct vt_heard *heard, const struct vt_front *front,
                                      enum script script)
{
    begin(heard, front, script);
    return end_of(heard);
}

/* --- what a run tells ------------------------------------------------------------------------- */

VT_TEST(a_run_tells_its_records_its_stage_and_its_result)
{
    struct vt_front front = front_start(0, 0);
    struct vt_heard heard;

    begin(&heard, &front, SAYS_ALL);
    pthread_join(heard.thread, NULL);
    ck_assert_int_eq(heard.end, VOR_RUN_DONE);
    ck_assert_int_eq(heard.records, 1);
    ck_assert_int_eq(heard.stages, 1);
    ck_assert_int_eq(heard.waits, 1);
    ck_assert_uint_eq(heard.record.iteration, 7);
    ck_assert_double_eq(heard.record.delta, 0.25);
    ck_assert_double_eq(heard.result.report.delta, 2); /* threads */
    ck_assert_str_eq(heard.result.message, "as the script says");
    ck_assert_uint_eq(heard.kept.size, KEPT_SIZE);
    ck_assert_uint_eq(strspn(heard.kept.data, "k"), KEPT_SIZE);
    vor_text_free(&heard.kept);
    ck_assert_int_eq(end_of_script(&heard, &front, SAYS_FAILURE), VOR_RUN_FAILED);
    ck_assert_int_eq(heard.err.status, VOR_E_TARGET);
    ck_assert_str_eq(heard.err.message, "no");
    ck_assert_uint_eq(vt_front_crashes(), 0);
    vt_front_stop(&front);
}

VT_TEST(what_a_listener_answers_reaches_its_run_and_no_other)
{
    struct vt_front front = front_start(0, 0);
    struct vt_heard obeys, other;

    begin(&other, &front, OBEYS);
    begin(&obeys, &front, OBEYS);
    wait_started(&other);
    wait_started(&obeys);
    atomic_store(&obeys.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&obeys), VOR_RUN_FAILED);
    ck_assert_int_eq(obeys.err.status, VOR_E_CANCELLED);
    nap(50);
    ck_assert(!atomic_load(&other.is_over));
    atomic_store(&other.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&other), VOR_RUN_FAILED);
    ck_assert_uint_eq(vt_front_crashes(), 0);
    vt_front_stop(&front);
}

/* --- crashes ---------------------------------------------------------------------------------- */

VT_TEST_LOOP(a_crash_with_nothing_beside_it_is_told_as_such_and_the_next_run_has_a_new_worker, 3)
{
    static const struct {
        enum script script;
        const char *says;
    } cases[] = {
        {ABORTS, "the worker crashed (signal 6)"},
        {LEAVES, "the worker crashed (memory ran out)"},
        {SAYS_NONSENSE, "the worker crashed (signal 9)"},
    };
    struct vt_front front = front_start(0, 0);
    struct vt_heard heard;

    ck_assert_int_eq(end_of_script(&heard, &front, cases[_i].script), VOR_RUN_CRASHED_ALONE);
    ck_assert_str_eq(heard.err.message, cases[_i].says);
    ck_assert_int_eq(end_of_script(&heard, &front, SAYS_ALL), VOR_RUN_DONE);
    ck_assert_uint_eq(vt_front_crashes(), 1);
    ck_assert_int_eq(atomic_load(&gate->started), 2);
    vt_front_stop(&front);
}

VT_TEST(a_crash_is_told_to_all_that_ran_there)
{
    struct vt_front front = front_start(0, 0);
    struct vt_heard beside[3], heard;

    for (int i = 0; i < 3; i++)
        begin(&beside[i], &front, OBEYS);
    for (int i = 0; i < 3; i++)
        wait_started(&beside[i]);
    ck_assert_int_eq(end_of_script(&heard, &front, ABORTS), VOR_RUN_CRASHED);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(end_of(&beside[i]), VOR_RUN_CRASHED);
    ck_assert_uint_eq(vt_front_crashes(), 1);
    vt_front_stop(&front);
}

VT_TEST(a_suspect_runs_in_a_process_of_its_own)
{
    struct vt_front front = front_start(0, 0);
    struct vt_heard beside, suspects[2], heard;

    begin(&beside, &front, OBEYS);
    begin_as(&suspects[0], &front, OBEYS, 1);
    begin_as(&suspects[1], &front, ABORTS, 1);
    wait_started(&beside);
    wait_started(&suspects[0]);
    ck_assert_int_eq(end_of(&suspects[1]), VOR_RUN_CRASHED_ALONE);
    ck_assert_int_eq(end_of_script(&heard, &front, ABORTS), VOR_RUN_CRASHED);
    ck_assert_int_eq(end_of(&beside), VOR_RUN_CRASHED);
    ck_assert(!atomic_load(&suspects[0].is_over));
    atomic_store(&suspects[0].asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&suspects[0]), VOR_RUN_FAILED);
    ck_assert_int_eq(suspects[0].err.status, VOR_E_CANCELLED);
    begin_as(&heard, &front, SAYS_ALL, 1);
    ck_assert_int_eq(end_of(&heard), VOR_RUN_DONE);
    ck_assert_int_eq(atomic_load(&gate->started), 4);
    ck_assert_uint_eq(vt_front_crashes(), 2);
    vt_front_stop(&front);
}

/* Regression: cancellation and signs of life of all runs waited for a worker that started. */
VT_TEST(runs_are_looked_after_while_another_worker_starts)
{
    struct vt_front front = front_start(0, 0);
    struct vt_heard runs, suspect;

    begin(&runs, &front, OBEYS);
    wait_started(&runs);
    atomic_store(&gate->is_closed, 1);
    begin_as(&suspect, &front, SAYS_ALL, 1);
    while (atomic_load(&gate->started) < 2)
        nap(1);
    atomic_store(&runs.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&runs), VOR_RUN_FAILED);
    ck_assert_int_eq(runs.err.status, VOR_E_CANCELLED);
    atomic_store(&gate->is_closed, 0);
    ck_assert_int_eq(end_of(&suspect), VOR_RUN_DONE);
    ck_assert_double_eq(suspect.result.report.delta, 1); /* thread, of two */
    vt_front_stop(&front);
}

VT_TEST(a_worker_that_ended_between_two_runs_costs_neither)
{
    struct vt_front front = front_start(0, 0);
    struct vt_heard heard = {.front = &front, .script = ENDS_LATER};
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
    ck_assert_int_eq(atomic_load(&gate->started), 2);
    vt_front_stop(&front);
}

VT_TEST(a_worker_without_a_sign_of_life_is_ended)
{
    struct vt_front front = front_start(0, 0.4);
    struct vt_heard heard;

    ck_assert_int_eq(end_of_script(&heard, &front, STOPS), VOR_RUN_CRASHED_ALONE);
    ck_assert_str_eq(heard.err.message, "the worker crashed (it does not respond)");
    ck_assert_int_eq(end_of_script(&heard, &front, SAYS_ALL), VOR_RUN_DONE);
    vt_front_stop(&front);
}

/* --- runs that do not listen ------------------------------------------------------------------ */

VT_TEST(a_cancelled_run_that_does_not_end_is_ended_and_blamed_alone)
{
    struct vt_front front = front_start(1, 0);
    struct vt_heard deaf, beside;

    begin(&beside, &front, OBEYS);
    begin(&deaf, &front, IS_DEAF);
    wait_started(&beside);
    wait_started(&deaf);
    atomic_store(&deaf.asked, VOR_CANCEL);
    ck_assert_int_eq(end_of(&deaf), VOR_RUN_FAILED);
    ck_assert_int_eq(deaf.err.status, VOR_E_CANCELLED);
    ck_assert_int_eq(end_of(&beside), VOR_RUN_DISTURBED);
    ck_assert_str_eq(beside.err.message, "the worker crashed (a cancelled run did not end)");
    vt_front_stop(&front);
}

VT_TEST(a_worker_whose_threads_do_not_start_is_an_error)
{
    struct vor_zygote zygote;
    struct vor_supervisor *supervisor;
    struct vor_supervisor_config config = {.zygote = &zygote, .kind = UNREADY, .threads = 2};

    vt_assert_ok(vor_zygote_start(&zygote, kinds, KINDS, &vt_err));
    vt_assert_fails(VOR_E_NOMEM, vor_supervisor_create(&supervisor, &config, &vt_err));
    ck_assert_str_eq(vt_err.message, "cannot start the threads of the worker: too little memory, "
                                     "or a limit on the number of processes");
    config.kind = UNFIT;
    vt_assert_fails(VOR_E_INTERNAL, vor_supervisor_create(&supervisor, &config, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "the engine fails its self-test: delta of the result is 0.5, want at most 0.1");
    vor_zygote_stop(&zygote);
}

/* --- what is said and makes no sense ---------------------------------------------------------- */

VT_TEST(words_that_make_no_sense_break_the_channel)
{
    static const enum vor_stage no_stage = VOR_STAGES;
    static const struct vor_record no_record = {.stage = VOR_RUN_STAGE_COUNT};
    static const struct vor_run_result no_format = {.output[1].format = 99};
    static const struct vor_error no_status = {.status = VOR_STATUS_COUNT}, fine = {0},
                                  lines = {.status = VOR_E_IO, .message = "two\nlines"};
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
        {VOR_SAID_FAILED, &lines, sizeof lines},
    };
    struct vor_message_said said;
    size_t size;
    int ends[2];

    vt_assert_ok(vor_channel_pair(ends, &vt_err));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        vt_assert_ok(vor_say(ends[0], cases[i].what, cases[i].of, cases[i].size));
        ck_assert_msg(vor_hear(&said, &size, NULL, ends[1], 1) == VOR_CHANNEL_GONE, "case %zu", i);
    }
    vt_assert_ok(vor_channel_send(ends[0], "x", 1, NULL, 0, &vt_err));
    ck_assert_int_eq(vor_hear(&said, &size, NULL, ends[1], 1), VOR_CHANNEL_GONE);
    vt_assert_ok(vor_say(ends[0], VOR_SAID_KEPT, "kept", 4));
    ck_assert_int_eq(vor_hear(&said, &size, NULL, ends[1], 1), VOR_CHANNEL_MESSAGE);
    ck_assert_uint_eq(size, 4);
    close(ends[0]);
    close(ends[1]);
}

VT_TEST(an_order_arrives_with_its_files_or_not_at_all)
{
    struct vor_order order = vt_order_of(5), got;
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

void vt_suite(Suite *suite VOR_UNUSED)
{
    vor_log_open(STDERR_FILENO, VOR_LOG_OFF);
}
