/* A thread that waits for a run also watches the run's worker. Without such a thread nothing runs,
 * so there is nothing to watch.
 *
 * Runs share a worker. A suspect has a worker of its own: a crash there is the suspect's own doing,
 * and neither does the suspect wait until nothing else runs, nor do other runs wait for its end.
 * That could take long, as a run that never ends is as likely a suspect as the run that crashed. */
#include "server/work/supervisor.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/base/metrics.h"
#include "server/work/ipc_codec.h"
#include "server/work/worker_main.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const double look_seconds = 0.02; /* between two questions to a listener */

/* Time for a cancelled run to end: before its caller is let go, and before its process is ended.
 * Between two polls of a run of 1 M points there were 0.19 s at most, on two busy cores; ten times
 * the points may take ten times that. Where nothing else runs there is nothing to lose. */
static const double let_go_seconds = 0.3, cancel_seconds = 5, cancel_alone_share = 0.2;

/* Without a beat, of which there should be ten a second: a machine that is short of memory or cores
 * may hold a process up for seconds. */
static const double stall_seconds = 10;

static const double start_seconds = 30; /* for a process, to be ready */

enum { STARTS = 3 }; /* tries to start a worker for a run */

enum { NOBODY = -1 };

/* A slot belongs to one life of its worker. When that ends, its runs find their channels closed,
 * and here how it ended. */
struct slot {
    int taken;
    uint64_t life;
    int is_innocent; /* it was ended because of another run */
    int is_only;     /* no other ran at its end */
    char how[64];    /* "signal 11" */
};

/* A worker process, and a slot for each run there. It has lives: from its start until it ends, by
 * itself or by us. */
struct worker {
    struct vor_shared_state *state;
    int state_fd;
    int is_up;
    int is_changing;        /* it is being started or ended */
    struct vor_child child; /* while it is up */
    uint64_t life;          /* number of the last one, from 1 */
    unsigned beats;         /* when they were last looked at */
    double beat;            /* when they had changed */
    struct slot slot[VOR_RUN_SLOTS];
};

struct vor_supervisor {
    struct vor_run_executor base;
    struct vor_supervisor_config config;
    pthread_mutex_t mutex;  /* everything below */
    pthread_cond_t changed; /* left_over, and a worker's is_changing */
    unsigned suspects;      /* that have a worker of their own */
    unsigned left_over;     /* cancelled runs whose callers do not wait for them */
    struct worker shared;
};

/* --- workers ---------------------------------------------------------------------------------- */

static vor_status init_worker(const struct vor_supervisor *supervisor, struct worker *worker,
                              unsigned threads, struct vor_error *err)
{
    const struct vor_supervisor_config *config = &supervisor->config;

    worker->state = vor_share(&worker->state_fd, sizeof *worker->state, PROT_READ | PROT_WRITE, 0);
    if (worker->state == NULL)
        return vor_fail_errno(err, errno, "creating memory that two processes share");
    worker->state->threads = threads;
    worker->state->memory = config->memory;
    worker->state->has_codec = config->codec.zygote != NULL;
    worker->state->codec_kind = config->codec.kind;
    worker->state->sandbox = config->codec.sandbox;
    return VOR_OK;
}

/* Ends its process, if there is one. service may be NULL, or all zero. */
static void free_worker(struct worker *worker)
{
    if (worker == NULL || worker->state == NULL)
        return;
    if (worker->is_up)
        vor_child_free(&worker->child);
    (void)munmap(worker->state, sizeof *worker->state);
    (void)close(worker->state_fd);
}

/* Runs of the life at hand. */
static unsigned runs_of(const struct worker *worker)
{
    unsigned count = 0;

    for (unsigned i = 0; i < VOR_RUN_SLOTS; i++)
        count += worker->slot[i].taken && worker->slot[i].life == worker->life;
    return count;
}

static void describe_end(char out[64], const struct vor_child_end *end)
{
    if (end->signal != 0)
        (void)snprintf(out, 64, "signal %d", end->signal);
    else if (end->status == VOR_WORKER_NO_MEMORY)
        (void)snprintf(out, 64, "memory ran out");
    else
        (void)snprintf(out, 64, "exit status %d", end->status);
}

/* Waits until a worker says that it is ready. */
static vor_status wait_ready(struct vor_child *child, struct vor_error *err)
{
    struct vor_child_end end;
    struct vor_error why;
    char how[64];
    struct vor_message message = {.bytes = &why, .capacity = sizeof why};

    if (vor_channel_receive(child->channel, &message, start_seconds) == VOR_CHANNEL_MESSAGE) {
        vor_message_close(&message);
        if (message.size != sizeof why)
            return VOR_OK;
    }
    (void)vor_child_reap(child, &end, 0);
    if (message.size > 0)
        return vor_fail(err, VOR_E_INTERNAL, "the engine fails its self-test: %.*s",
                        (int)sizeof why.message, why.message);
    if (end.status == VOR_WORKER_NO_POOL)
        return vor_fail(err, VOR_E_NOMEM,
                        "cannot start the threads of the worker: too little memory, or a limit on "
                        "the number of processes");
    describe_end(how, &end);
    return vor_fail(err, VOR_E_IO, "the worker process cannot be started: %s", how);
}

/* Starts a worker, or ends one. The mutex is held, but not while the process is waited for: that
 * may take half a minute, and other runs are looked after meanwhile. Who needs this worker waits
 * for the change (settle). */
static void begin_change(struct vor_supervisor *supervisor, struct worker *worker)
{
    worker->is_changing = 1;
    pthread_mutex_unlock(&supervisor->mutex);
}

static void end_change(struct vor_supervisor *supervisor, struct worker *worker)
{
    worker->is_changing = 0;
    pthread_cond_broadcast(&supervisor->changed);
}

static void settle(struct vor_supervisor *supervisor, const struct worker *worker)
{
    while (worker->is_changing)
        pthread_cond_wait(&supervisor->changed, &supervisor->mutex);
}

static vor_status begin_worker(struct vor_supervisor *supervisor, struct worker *worker,
                               struct vor_error *err)
{
    struct vor_zygote *zygote = supervisor->config.zygote;
    const int fds[] = {worker->state_fd, zygote->socket};
    struct vor_child child;
    vor_status status;

    begin_change(supervisor, worker);
    status = vor_zygote_spawn(&child, zygote, supervisor->config.kind, fds,
                              worker->state->has_codec ? 2 : 1, err);
    if (status == VOR_OK) {
        status = wait_ready(&child, err);
        if (status != VOR_OK)
            vor_child_free(&child);
    }
    pthread_mutex_lock(&supervisor->mutex);
    if (status == VOR_OK) {
        worker->child = child;
        worker->is_up = 1;
        worker->life++;
        worker->beats = atomic_load(&worker->state->beats);
        worker->beat = vor_clock_seconds();
        vor_log(VOR_LOG_INFO, "worker started", VOR_COUNT("pid", child.pid));
    }
    end_change(supervisor, worker);
    return status;
}

/* why: we end it; NULL where it has ended by itself, or nearly so. blamed: the slot because of
 * which we do, or NOBODY. */
static void end_worker(struct vor_supervisor *supervisor, struct worker *worker, const char *why,
                       int blamed)
{
    struct vor_child_end end;
    char how[64] = "it does not end";
    unsigned runs;

    if (!worker->is_up || worker->is_changing)
        return;
    begin_change(supervisor, worker);
    if (vor_child_reap(&worker->child, &end, 0) != VOR_CHILD_STUCK)
        describe_end(how, &end);
    if (why != NULL)
        (void)snprintf(how, sizeof how, "%s", why);
    pthread_mutex_lock(&supervisor->mutex);
    vor_metric_add(VOR_METRIC_WORKER_RESTARTS, 1, NULL);
    vor_child_free(&worker->child);
    worker->is_up = 0;
    runs = runs_of(worker);
    for (unsigned i = 0; i < VOR_RUN_SLOTS; i++) {
        struct slot *slot = &worker->slot[i];

        if (!slot->taken || slot->life != worker->life)
            continue;
        slot->is_only = runs == 1;
        slot->is_innocent = blamed != NOBODY && blamed != (int)i;
        memcpy(slot->how, how, sizeof slot->how);
    }
    vor_log(VOR_LOG_ERROR, "worker ended", VOR_TEXT("how", how),
            VOR_COUNT("pid", worker->child.pid), VOR_COUNT("jobs", runs),
            VOR_REAL("cpu_s", end.cpu_seconds), VOR_COUNT("peak", end.peak));
    end_change(supervisor, worker);
}

static void leave_worker(struct vor_supervisor *supervisor, struct worker *worker)
{
    if (worker == &supervisor->shared)
        return;
    free_worker(worker);
    free(worker);
    pthread_mutex_lock(&supervisor->mutex);
    supervisor->suspects--;
    pthread_mutex_unlock(&supervisor->mutex);
}

/* The worker for an order: the shared one, or for a suspect one of its own. Of many suspects, as
 * after a crash beside many runs, each has fewer threads: else they would have the cores many times
 * over. NULL when there is none to be had. */
static struct worker *worker_for(struct vor_supervisor *supervisor, const struct vor_order *order,
                                 struct vor_error *err)
{
    struct worker *own;
    unsigned threads;

    if (!order->is_suspect)
        return &supervisor->shared;
    pthread_mutex_lock(&supervisor->mutex);
    threads = supervisor->config.threads / (++supervisor->suspects + 1);
    pthread_mutex_unlock(&supervisor->mutex);
    own = calloc(1, sizeof *own);
    if (own != NULL && init_worker(supervisor, own, threads > 0 ? threads : 1, err) == VOR_OK)
        return own;
    if (own == NULL)
        (void)vor_fail(err, VOR_E_NOMEM, "a worker");
    leave_worker(supervisor, own);
    return NULL;
}

/* --- a run ------------------------------------------------------------------------------------ */

struct run {
    struct vor_supervisor *supervisor;
    struct worker *worker;
    const struct vor_listener *listener;
    int slot, channel;
    uint64_t life;
    float *xyz;                    /* room for them; NULL as long as nobody has looked */
    double cancelled;              /* when the listener was first seen to cancel; 0 for not yet */
    int is_left_over;              /* nobody waits for it */
    struct vor_run_result *result; /* what the run hands out, as the next two */
    struct vor_text *kept;
    struct vor_error *err;
};

static void leave_slot(struct run *run)
{
    (void)close(run->channel);
    free(run->xyz);
    pthread_mutex_lock(&run->supervisor->mutex);
    run->worker->slot[run->slot].taken = 0;
    pthread_mutex_unlock(&run->supervisor->mutex);
}

/* Whether an error of sending says that the other side has gone, and not that we have no means. */
static int is_gone(const struct vor_error *err)
{
    return err->got == EPIPE || err->got == ECONNRESET;
}

/* Begins a run at the worker, which is started where it is not up: takes a free slot and sends the
 * worker a channel for it. The mutex is held. */
static vor_status try_to_sit(struct run *run, struct vor_error *err)
{
    struct worker *worker = run->worker;
    struct vor_run_request request = {.slot = 0};
    vor_status status = VOR_OK;
    int ends[2];

    settle(run->supervisor, worker);
    if (!worker->is_up)
        status = begin_worker(run->supervisor, worker, err);
    while (request.slot < VOR_RUN_SLOTS && worker->slot[request.slot].taken)
        request.slot++;
    if (status == VOR_OK && request.slot == VOR_RUN_SLOTS)
        status = vor_fail(err, VOR_E_IO, "more than %d jobs are running at the same time",
                          VOR_RUN_SLOTS);
    VOR_THEN(status, vor_channel_pair(ends, err));
    if (status != VOR_OK)
        return status;
    worker->slot[request.slot] = (struct slot){.taken = 1, .life = worker->life};
    atomic_store(&worker->state->asked[request.slot], VOR_CONTINUE);
    run->slot = (int)request.slot;
    run->life = worker->life;
    run->channel = ends[0];
    status = vor_channel_send(worker->child.channel, &request, sizeof request, &ends[1], 1, err);
    (void)close(ends[1]);
    if (status == VOR_OK)
        return VOR_OK;
    (void)close(ends[0]);
    worker->slot[run->slot].taken = 0;
    if (is_gone(err))
        end_worker(run->supervisor, worker, NULL, NOBODY);
    return status;
}

/* Tells the run what is asked of it, and looks whether it and its worker are in order. */
static void look_after(struct run *run)
{
    const struct vor_supervisor_config *config = &run->supervisor->config;
    const struct vor_listener *listener = run->listener;
    enum vor_answer answer = listener->asked(listener->ctx);
    int is_looked_at = listener->is_looked_at != NULL && listener->is_looked_at(listener->ctx);
    struct worker *worker = run->worker;
    unsigned beats = atomic_load(&worker->state->beats);
    double now = vor_clock_seconds(), share;

    if (is_looked_at && run->xyz == NULL)
        run->xyz = malloc((size_t)VOR_PREVIEW_POINTS_MAX * 3 * sizeof *run->xyz);
    atomic_store(&worker->state->is_looked_at[run->slot], is_looked_at && run->xyz != NULL);
    atomic_store(&worker->state->asked[run->slot], (int)answer);
    if (answer == VOR_CANCEL && run->cancelled == 0)
        run->cancelled = now;
    pthread_mutex_lock(&run->supervisor->mutex);
    if (worker->life == run->life) {
        share = runs_of(worker) == 1 ? cancel_alone_share : 1;
        if (run->cancelled > 0 && now - run->cancelled > share * config->cancel_seconds)
            end_worker(run->supervisor, worker, "a cancelled run did not end", run->slot);
        if (beats != worker->beats) {
            worker->beats = beats;
            worker->beat = now;
        } else if (now - worker->beat > config->stall_seconds) {
            end_worker(run->supervisor, worker, "it does not respond", NOBODY);
        }
    }
    pthread_mutex_unlock(&run->supervisor->mutex);
}

/* The run's worker has ended, or does not speak sense. */
static enum vor_run_end lose(struct run *run)
{
    struct worker *worker = run->worker;
    const struct slot *slot = &worker->slot[run->slot];
    enum vor_run_end end;

    pthread_mutex_lock(&run->supervisor->mutex);
    if (worker->life == run->life)
        end_worker(run->supervisor, worker, NULL, NOBODY);
    settle(run->supervisor, worker);
    end = slot->is_innocent ? VOR_RUN_DISTURBED
          : slot->is_only   ? VOR_RUN_CRASHED_ALONE
                            : VOR_RUN_CRASHED;
    (void)vor_fail(run->err, VOR_E_INTERNAL, "the worker crashed (%s)", slot->how);
    pthread_mutex_unlock(&run->supervisor->mutex);
    if (run->listener->asked(run->listener->ctx) != VOR_CANCEL)
        return end;
    (void)vor_fail(run->err, VOR_E_CANCELLED, "cancelled by the caller");
    return VOR_RUN_FAILED;
}

static int leave_over(struct run *run);

/* Takes in what the run says; true when it was its last word, and *end then says which. */
static int take_in(const struct run *run, const struct vor_message_said *said, size_t size,
                   enum vor_run_end *end)
{
    switch (said->what) {
    case VOR_SAID_KEPT:
        vor_text_append(run->kept, said->of.kept, size);
        return 0;
    case VOR_SAID_DONE:
        *run->result = said->of.result;
        *end = vor_text_status(run->kept, run->err) == VOR_OK ? VOR_RUN_DONE : VOR_RUN_FAILED;
        return 1;
    case VOR_SAID_FAILED:
        *run->err = said->of.error;
        *end = VOR_RUN_FAILED;
        return 1;
    default:
        if (!run->is_left_over)
            run->listener->said(run->listener->ctx, said->what, &said->of);
        return 0;
    }
}

/* Listens to a run until its end, or until it is overdue and was left over. */
static enum vor_run_end listen_to(struct run *run)
{
    struct vor_message_said said;
    enum vor_channel_event event;
    enum vor_run_end end;
    size_t size = 0;

    for (;;) {
        vor_offer_send(run->channel, run->listener);
        event = vor_hear(&said, &size, run->xyz, run->channel, look_seconds);
        if (event == VOR_CHANNEL_GONE)
            return lose(run);
        if (event == VOR_CHANNEL_MESSAGE && take_in(run, &said, size, &end))
            return end;
        look_after(run);
        if (!run->is_left_over && run->cancelled > 0 &&
            vor_clock_seconds() - run->cancelled > let_go_seconds && leave_over(run)) {
            (void)vor_fail(run->err, VOR_E_CANCELLED, "cancelled by the caller");
            return VOR_RUN_FAILED;
        }
    }
}

/* --- runs that are left over ------------------------------------------------------------------ */

static enum vor_answer answer_cancel(VOR_UNUSED void *ctx)
{
    return VOR_CANCEL;
}

static const struct vor_listener nobody = {.asked = answer_cancel};

/* Waits for the end of a run in nobody's name. */
static void *see_out(void *arg)
{
    struct run *run = arg;
    struct vor_supervisor *supervisor = run->supervisor;
    struct vor_run_result result;
    struct vor_error err;
    struct vor_text kept;

    vor_text_init(&kept, 0);
    run->result = &result;
    run->kept = &kept;
    run->err = &err;
    (void)listen_to(run);
    vor_text_free(&kept);
    leave_slot(run);
    leave_worker(supervisor, run->worker);
    free(run);
    pthread_mutex_lock(&supervisor->mutex);
    supervisor->left_over--;
    pthread_cond_broadcast(&supervisor->changed);
    pthread_mutex_unlock(&supervisor->mutex);
    return NULL;
}

/* Has another thread see a run out; false when there is none. */
static int leave_over(struct run *run)
{
    struct vor_supervisor *supervisor = run->supervisor;
    struct run *left = malloc(sizeof *left);
    pthread_t thread;

    if (left == NULL)
        return 0;
    run->is_left_over = 1;
    *left = *run;
    left->listener = &nobody;
    pthread_mutex_lock(&supervisor->mutex);
    if (vor_machine_thread(&thread, "vor-see-out", see_out, left) == 0) {
        (void)pthread_detach(thread);
        supervisor->left_over++;
    } else {
        run->is_left_over = 0;
        free(left);
    }
    pthread_mutex_unlock(&supervisor->mutex);
    return run->is_left_over;
}

static enum vor_run_end run_there(struct vor_run_executor *executor, const struct vor_order *order,
                                  const struct vor_listener *listener,
                                  struct vor_run_result *result, struct vor_text *kept,
                                  struct vor_error *err)
{
    struct vor_supervisor *supervisor = (struct vor_supervisor *)executor;
    struct run run = {
        .supervisor = supervisor, .listener = listener, .result = result, .kept = kept, .err = err};
    enum vor_run_end end;
    vor_status status = VOR_E_IO;

    run.worker = worker_for(supervisor, order, err);
    if (run.worker == NULL)
        return VOR_RUN_DISTURBED;
    /* A worker that has died since its last run shows when it is spoken to. */
    pthread_mutex_lock(&run.supervisor->mutex);
    for (int i = 0; i < STARTS && status != VOR_OK; i++) {
        status = try_to_sit(&run, err);
        if (status != VOR_OK && run.worker->is_up)
            break; /* it is not the worker */
    }
    pthread_mutex_unlock(&run.supervisor->mutex);
    if (status != VOR_OK) {
        leave_worker(supervisor, run.worker);
        return VOR_RUN_DISTURBED;
    }
    look_after(&run); /* a short run may end before the next time */
    if (vor_order_send(run.channel, order, err) == VOR_OK)
        end = listen_to(&run);
    else
        end = is_gone(err) ? lose(&run) : VOR_RUN_DISTURBED;
    if (!run.is_left_over) {
        leave_slot(&run);
        leave_worker(supervisor, run.worker);
    }
    return end;
}

/* --- from start to end ------------------------------------------------------------------------ */

vor_status vor_supervisor_create(struct vor_supervisor **out,
                                 const struct vor_supervisor_config *config, struct vor_error *err)
{
    struct vor_supervisor *supervisor = calloc(1, sizeof *supervisor);
    vor_status status;

    if (supervisor == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the worker process");
    supervisor->base =
        (struct vor_run_executor){.threads = config->threads, .is_apart = 1, .run = run_there};
    supervisor->config = *config;
    if (config->cancel_seconds == 0)
        supervisor->config.cancel_seconds = cancel_seconds;
    if (config->stall_seconds == 0)
        supervisor->config.stall_seconds = stall_seconds;
    pthread_mutex_init(&supervisor->mutex, NULL);
    pthread_cond_init(&supervisor->changed, NULL);
    status = init_worker(supervisor, &supervisor->shared, supervisor->config.threads, err);
    if (status == VOR_OK) {
        pthread_mutex_lock(&supervisor->mutex);
        status = begin_worker(supervisor, &supervisor->shared, err);
        pthread_mutex_unlock(&supervisor->mutex);
    }
    if (status != VOR_OK) {
        vor_supervisor_destroy(supervisor);
        return status;
    }
    *out = supervisor;
    return VOR_OK;
}

void vor_supervisor_destroy(struct vor_supervisor *supervisor)
{
    if (supervisor == NULL)
        return;
    pthread_mutex_lock(&supervisor->mutex);
    while (supervisor->left_over > 0) /* for cancel_seconds at most */
        pthread_cond_wait(&supervisor->changed, &supervisor->mutex);
    pthread_mutex_unlock(&supervisor->mutex);
    free_worker(&supervisor->shared);
    pthread_cond_destroy(&supervisor->changed);
    pthread_mutex_destroy(&supervisor->mutex);
    free(supervisor);
}

struct vor_run_executor *vor_supervisor_executor(struct vor_supervisor *supervisor)
{
    return &supervisor->base;
}
