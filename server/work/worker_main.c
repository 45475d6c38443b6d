#include "server/work/worker_main.h"

#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/work/execute.h"
#include "server/work/ipc_codec.h"
#include "server/work/self_test.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

/* An order follows its request at once. */
static const double order_seconds = 30;

/* The kernel, out of memory, ends this process before others. */
enum { OOM_SCORE = 500 };

struct worker {
    struct vor_shared_state *state;
    struct vor_zygote zygote; /* our parent */
    struct vor_run_means means;
    struct rlimit memory; /* RLIMIT_DATA; infinite where there is none */
};

/* A run: a thread of its own. */
struct run {
    struct worker *worker;
    unsigned slot;
    int channel;
    int file; /* for a checkpoint; -1: none */
};

/* --- memory ----------------------------------------------------------------------------------- */

/* Libraries, stacks and what the allocator keeps besides what runs are charged with. */
enum { MARGIN_BYTES = 256 << 20, STACK_BYTES = 8 << 20 };

/* Whether memory is refused because the whole process has none left, which no run that stays within
 * its own can bring about. */
static int is_exhausted(const struct worker *worker)
{
    FILE *file = fopen("/proc/self/statm", "re");
    unsigned long long pages = 0; /* that count against RLIMIT_DATA; 0 where that cannot be told */

    if (file == NULL)
        return 0;
    if (fscanf(file, "%*u %*u %*u %*u %*u %llu", &pages) != 1)
        pages = 0;
    (void)fclose(file);
    return worker->memory.rlim_cur != RLIM_INFINITY &&
           (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) >
               worker->memory.rlim_cur - MARGIN_BYTES / 2;
}

/* --- a run ------------------------------------------------------------------------------------ */

static enum vor_answer asked(void *ctx)
{
    const struct run *run = ctx;

    return (enum vor_answer)atomic_load_explicit(&run->worker->state->asked[run->slot],
                                                 memory_order_relaxed);
}

/* Says something; without a front there is nobody to work for. */
static void say(const struct run *run, enum vor_said what, const void *of, size_t size)
{
    if (vor_say(run->channel, what, of, size) != VOR_OK)
        _exit(EXIT_SUCCESS);
}

static void take(void *ctx, enum vor_said what, const void *of)
{
    struct run *run = ctx;

    if (what == VOR_SAID_CHECKPOINT) {
        (void)close(run->file);
        run->file = -1;
    }
    say(run, what, of, vor_said_size(what));
}

static int is_looked_at(void *ctx)
{
    const struct run *run = ctx;

    return atomic_load_explicit(&run->worker->state->is_looked_at[run->slot], memory_order_relaxed);
}

static int file_of(void *ctx)
{
    struct run *run = ctx;

    if (run->file < 0)
        run->file = vor_offer_receive(run->channel);
    return run->file;
}

static vor_status run_order(struct run *run, const struct vor_order *order, struct vor_error *err)
{
    const struct vor_listener listener = {
        .ctx = run, .asked = asked, .said = take, .is_looked_at = is_looked_at, .file = file_of};
    struct vor_run_result result;
    struct vor_text kept;
    vor_status status;

    vor_text_init(&kept, VOR_KEPT_MAX);
    status = vor_execute(&result, &kept, order, &run->worker->means, &listener, err);
    if (status == VOR_E_NOMEM && is_exhausted(run->worker))
        _exit(VOR_WORKER_NO_MEMORY);
    for (size_t at = 0; status == VOR_OK && at < kept.size; at += VOR_KEPT_PART) {
        size_t left = kept.size - at;

        say(run, VOR_SAID_KEPT, kept.data + at, left < VOR_KEPT_PART ? left : VOR_KEPT_PART);
    }
    if (status == VOR_OK)
        say(run, VOR_SAID_DONE, &result, sizeof result);
    vor_text_free(&kept);
    return status;
}

static void *serve_run(void *arg)
{
    struct run *run = arg;
    struct vor_order order;
    struct vor_error err;
    vor_status status = vor_order_receive(&order, run->channel, order_seconds, &err);

    VOR_THEN(status, run_order(run, &order, &err));
    vor_order_close(&order);
    if (status != VOR_OK)
        say(run, VOR_SAID_FAILED, &err, sizeof err);
    if (run->file >= 0)
        (void)close(run->file);
    (void)close(run->channel);
    free(run);
    return NULL;
}

/* --- the process ------------------------------------------------------------------------------ */

static void *tick(void *arg)
{
    struct worker *worker = arg;
    const struct timespec pause = {0, (long)(VOR_BEAT_SECONDS * 1e9)};

    for (;;) {
        (void)nanosleep(&pause, NULL);
        atomic_fetch_add(&worker->state->beats, 1);
    }
    return NULL;
}

/* A thread that nobody waits for: the process ends with whatever runs. */
static int start_thread(void *(*run)(void *), void *arg)
{
    pthread_t thread;

    if (pthread_create(&thread, NULL, run, arg) != 0)
        return 0;
    (void)pthread_detach(thread);
    return 1;
}

/* Begins runs until the front has gone. */
static void serve(struct worker *worker, int channel)
{
    struct vor_run_request request;
    struct vor_message message = {.bytes = &request, .capacity = sizeof request};

    while (vor_channel_receive(channel, &message, -1) == VOR_CHANNEL_MESSAGE) {
        struct run *run;

        if (message.size != sizeof request || message.fd_count != 1 ||
            request.slot >= VOR_RUN_SLOTS) {
            vor_message_close(&message);
            continue;
        }
        /* A worker that cannot begin a run is of no use to anybody. */
        run = malloc(sizeof *run);
        if (run == NULL)
            _exit(VOR_WORKER_NO_MEMORY);
        *run = (struct run){worker, request.slot, message.fds[0], -1};
        if (!start_thread(serve_run, run))
            _exit(VOR_WORKER_NO_MEMORY);
    }
}

int vor_worker_main(int channel, const int *fds, unsigned fd_count)
{
    struct worker worker = {.state = fd_count >= 1 ? vor_shared_state_map(fds[0]) : NULL};
    const struct rlimit no_core = {0, 0};
    struct vor_memory memory;
    struct vor_error err;
    int is_fit;

    if (worker.state == NULL || fd_count != (worker.state->has_codec ? 2 : 1))
        return EXIT_FAILURE;
    if (worker.state->has_codec) {
        worker.zygote = (struct vor_zygote){.socket = fds[1], .pid = getppid()};
        worker.means.codec = (struct vor_codec_place){.zygote = &worker.zygote,
                                                      .kind = worker.state->codec_kind,
                                                      .sandbox = worker.state->sandbox};
    }
    vor_log_set_level(VOR_LOG_OFF); /* the front logs; how a child ended is in the error */
    vor_machine_set_oom_score(OOM_SCORE);
    /* Bounds what the process may take: what leaks is then refused here, and not by the kernel's
     * choice of a process to kill. Sanitizers need address space of their own. */
    (void)setrlimit(RLIMIT_CORE, &no_core);
    worker.memory = (struct rlimit){RLIM_INFINITY, RLIM_INFINITY};
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    if (worker.state->memory > 0) {
        worker.memory.rlim_cur = worker.memory.rlim_max =
            worker.state->memory + MARGIN_BYTES +
            (rlim_t)STACK_BYTES * (worker.state->threads + VOR_RUN_SLOTS);
        (void)setrlimit(RLIMIT_DATA, &worker.memory);
    }
#endif
    if (vor_pool_create(&worker.means.pool, worker.state->threads, NULL) != VOR_OK ||
        !start_thread(tick, &worker))
        return VOR_WORKER_NO_POOL;
    /* Tells the front that the worker is ready, or why it is not. */
    vor_memory_init(&memory, SIZE_MAX);
    is_fit = vor_self_test(worker.means.pool, &memory, &err) == VOR_OK;
    if (vor_channel_send(channel, is_fit ? (const void *)"" : &err, is_fit ? 1 : sizeof err, NULL,
                         0, NULL) == VOR_OK &&
        is_fit)
        serve(&worker, channel);
    return EXIT_SUCCESS;
}
