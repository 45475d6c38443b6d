/* A worker process has a life: from its start until it ends, by itself or by us. A run has a seat,
 * which belongs to one life; when that ends, how is noted at each of its seats, and whoever waits
 * there finds its channel closed and reads the note. Whoever waits also looks after the worker;
 * where nobody does, nothing runs, and nothing is lost.
 *
 * Runs share a worker. A suspect has one of its own: what crashes there is its own doing, and it
 * need not wait until nothing else runs, nor others for it, which may be long: a run that never
 * ends is as likely a suspect as the one that crashed. */
#include "server/work/supervisor.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/work/station.h"
#include "server/work/wire.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static const double look_seconds = 0.02; /* between two questions to a listener */
static const double start_seconds = 30;  /* for a worker, to be ready */
static const double end_seconds = 10;    /* for one that was killed, to be gone */

/* For a cancelled run to end: the longest that was seen between two polls of the engine is the
 * index of 10 M points, 4 s. Alone there is nothing to lose. */
static const double cancel_seconds = 5, cancel_alone_share = 0.2;

/* Without a beat, of which there should be ten a second: a machine that is short of memory or cores
 * may hold a process up for seconds. */
static const double stall_seconds = 10;

enum { STARTS = 3, NOBODY = -1 }; /* tries to start one for a run */

struct seat {
    int taken;
    uint64_t life;   /* of the worker that the run is at */
    int is_innocent; /* the life was ended because of another run */
    int is_only;     /* no other ran at its end */
    char how[64];    /* "signal 11": how it ended */
};

/* A worker process: the one that runs share, or that of a suspect. The mutex of the supervisor is
 * held where it is used, but for the board. */
struct worker {
    struct vor_board *board;
    int board_fd;
    int is_up;
    struct vor_child child; /* while it is up */
    uint64_t life;          /* number of the last one started */
    unsigned beats;         /* when they were last looked at */
    double beat;            /* when they had changed */
    struct seat seat[VOR_SEATS];
};

struct vor_supervisor {
    struct vor_executor base;
    struct vor_supervisor_config config;
    pthread_mutex_t mutex; /* everything below */
    struct vor_supervisor_counts counts;
    struct worker shared;
};

/* --- a life; the mutex is held ---------------------------------------------------------------- */

/* Runs of the life at hand. */
static unsigned runs_at(const struct worker *worker)
{
    unsigned count = 0;

    for (unsigned i = 0; i < VOR_SEATS; i++)
        count += worker->seat[i].taken && worker->seat[i].life == worker->life;
    return count;
}

static void describe_end(char out[64], const struct vor_child_end *end)
{
    if (end->signal != 0)
        (void)snprintf(out, 64, "signal %d", end->signal);
    else if (end->status == VOR_STATION_NO_MEMORY)
        (void)snprintf(out, 64, "memory used up");
    else
        (void)snprintf(out, 64, "exit status %d", end->status);
}

/* Notes at the seats of the life that ends how it does. */
static void note_end(struct worker *worker, const char *how, int blamed)
{
    int is_only = runs_at(worker) == 1;

    for (unsigned i = 0; i < VOR_SEATS; i++) {
        struct seat *seat = &worker->seat[i];

        if (!seat->taken || seat->life != worker->life)
            continue;
        seat->is_only = is_only;
        seat->is_innocent = blamed != NOBODY && blamed != (int)i;
        (void)snprintf(seat->how, sizeof seat->how, "%s", how);
    }
}

/* Ends a worker if it has not ended yet.
 *
 * why: NULL when it has ended by itself. blamed: the seat of the run because of which it is ended.
 */
static void end_life(struct vor_supervisor *supervisor, struct worker *worker, const char *why,
                     int blamed)
{
    struct vor_child_end end = {.signal = 0};
    char how[64];

    if (!worker->is_up)
        return;
    vor_child_kill(&worker->child);
    if (vor_child_wait(&worker->child, &end, end_seconds) && why == NULL)
        describe_end(how, &end);
    else
        (void)snprintf(how, sizeof how, "%s", why != NULL ? why : "it does not end");
    vor_child_free(&worker->child);
    worker->is_up = 0;
    supervisor->counts.crashed++;
    note_end(worker, how, blamed);
    vor_log(VOR_LOG_ERROR, "worker ended", VOR_TEXT("how", how),
            VOR_COUNT("pid", worker->child.pid), VOR_COUNT("jobs", runs_at(worker)),
            VOR_REAL("cpu_s", end.cpu_seconds), VOR_COUNT("peak", end.peak));
}

/* Waits until a worker says that it is ready. */
static vor_status wait_ready(struct vor_child *child, struct vor_error *err)
{
    struct vor_child_end end = {.signal = 0};
    char byte, how[64];
    struct vor_message message = {.bytes = &byte, .capacity = sizeof byte};

    if (vor_channel_receive(child->channel, &message, start_seconds) == VOR_CHANNEL_MESSAGE) {
        vor_message_close(&message);
        return VOR_OK;
    }
    vor_child_kill(child);
    (void)vor_child_wait(child, &end, end_seconds);
    if (end.status == VOR_STATION_NO_POOL)
        return vor_fail(err, VOR_E_NOMEM, "the threads of the worker cannot be started");
    describe_end(how, &end);
    return vor_fail(err, VOR_E_IO, "the worker does not start: %s", how);
}

static vor_status begin_life(struct vor_supervisor *supervisor, struct worker *worker,
                             struct vor_error *err)
{
    const struct vor_supervisor_config *config = &supervisor->config;
    struct vor_child child;
    vor_status status =
        vor_zygote_spawn(&child, config->zygote, config->kind, &worker->board_fd, 1, err);

    if (status != VOR_OK)
        return status;
    status = wait_ready(&child, err);
    if (status != VOR_OK) {
        vor_child_free(&child);
        return status;
    }
    worker->child = child;
    worker->is_up = 1;
    worker->life++;
    supervisor->counts.started++;
    worker->beats = atomic_load(&worker->board->beats);
    worker->beat = vor_clock_seconds();
    vor_log(VOR_LOG_INFO, "worker started", VOR_COUNT("pid", child.pid));
    return VOR_OK;
}

/* --- workers ---------------------------------------------------------------------------------- */

/* Gives a worker its board; it is started by begin_life. */
static vor_status init_worker(struct worker *worker, const struct vor_supervisor_config *config,
                              struct vor_error *err)
{
    vor_status status = vor_board_create(&worker->board, &worker->board_fd, err);

    if (status != VOR_OK)
        return status;
    worker->board->threads = config->threads;
    worker->board->memory = config->memory;
    return VOR_OK;
}

/* Ends a worker at which nothing runs. */
static void free_worker(struct worker *worker)
{
    if (worker->is_up)
        vor_child_free(&worker->child); /* which ends it */
    if (worker->board == NULL)
        return;
    vor_board_unmap(worker->board);
    (void)close(worker->board_fd);
}

/* The worker for an order: the shared one, or for a suspect one of its own. NULL when there is none
 * to be had. */
static struct worker *worker_for(struct vor_supervisor *supervisor, const struct vor_order *order,
                                 struct vor_error *err)
{
    struct worker *own;

    if (!order->is_suspect)
        return &supervisor->shared;
    own = calloc(1, sizeof *own);
    if (own == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "a worker");
        return NULL;
    }
    if (init_worker(own, &supervisor->config, err) == VOR_OK)
        return own;
    free(own);
    return NULL;
}

static void leave_worker(struct vor_supervisor *supervisor, struct worker *worker)
{
    if (worker == &supervisor->shared)
        return;
    free_worker(worker);
    free(worker);
}

/* --- a run ------------------------------------------------------------------------------------ */

struct sitting {
    struct vor_supervisor *supervisor;
    struct worker *worker;
    const struct vor_listener *listener;
    int seat, channel;
    uint64_t life;
    double cancelled; /* when the listener was first seen to cancel; 0 for not yet */
};

/* Takes a free seat at the worker, which is up; the mutex is held. */
static vor_status take_seat(struct sitting *sitting, struct vor_error *err)
{
    struct worker *worker = sitting->worker;
    int i = 0;

    while (i < VOR_SEATS && worker->seat[i].taken)
        i++;
    if (i == VOR_SEATS)
        return vor_fail(err, VOR_E_INTERNAL, "more than %d runs at a time", VOR_SEATS);
    worker->seat[i] = (struct seat){.taken = 1, .life = worker->life};
    atomic_store(&worker->board->asked[i], VOR_CONTINUE);
    sitting->seat = i;
    sitting->life = worker->life;
    return VOR_OK;
}

static void leave_seat(struct sitting *sitting)
{
    (void)close(sitting->channel);
    pthread_mutex_lock(&sitting->supervisor->mutex);
    sitting->worker->seat[sitting->seat].taken = 0;
    pthread_mutex_unlock(&sitting->supervisor->mutex);
}

/* Sends the worker a channel for the run; the mutex is held. */
static vor_status summon(struct sitting *sitting, struct vor_error *err)
{
    struct vor_summons summons = {.seat = (unsigned)sitting->seat};
    int ends[2];
    vor_status status = vor_channel_pair(ends, err);

    if (status != VOR_OK)
        return status;
    status = vor_channel_send(sitting->worker->child.channel, &summons, sizeof summons, &ends[1], 1,
                              err);
    (void)close(ends[1]);
    if (status == VOR_OK)
        sitting->channel = ends[0];
    else
        (void)close(ends[0]);
    return status;
}

/* Begins a run at the worker, which is started where it is not up. One that has died since its last
 * run shows when it is spoken to. */
static vor_status sit_down(struct sitting *sitting, struct vor_error *err)
{
    struct vor_supervisor *supervisor = sitting->supervisor;
    struct worker *worker = sitting->worker;
    vor_status status = VOR_E_IO;

    pthread_mutex_lock(&supervisor->mutex);
    for (int i = 0; i < STARTS && status == VOR_E_IO; i++) {
        status = worker->is_up ? VOR_OK : begin_life(supervisor, worker, err);
        if (status == VOR_OK)
            status = take_seat(sitting, err);
        if (status != VOR_OK)
            break;
        status = summon(sitting, err);
        if (status == VOR_OK)
            break;
        worker->seat[sitting->seat].taken = 0;
        end_life(supervisor, worker, NULL, NOBODY);
    }
    pthread_mutex_unlock(&supervisor->mutex);
    return status;
}

/* Ends the worker because of this run, once it is cancelled for too long; the mutex is held. */
static void check_patience(struct sitting *sitting)
{
    const struct vor_supervisor_config *config = &sitting->supervisor->config;
    double since = sitting->cancelled > 0 ? vor_clock_seconds() - sitting->cancelled : 0;
    double share = runs_at(sitting->worker) == 1 ? cancel_alone_share : 1;

    if (since > share * config->cancel_seconds)
        end_life(sitting->supervisor, sitting->worker, "a cancelled run did not end",
                 sitting->seat);
}

/* Ends a worker whose ticker stands still; the mutex is held. */
static void check_beats(struct sitting *sitting)
{
    struct worker *worker = sitting->worker;
    unsigned beats = atomic_load(&worker->board->beats);
    double now = vor_clock_seconds();

    if (beats != worker->beats) {
        worker->beats = beats;
        worker->beat = now;
    } else if (now - worker->beat > sitting->supervisor->config.stall_seconds) {
        end_life(sitting->supervisor, worker, "no sign of life", NOBODY);
    }
}

/* Tells the run what is asked of it, and looks whether it and its worker are in order. */
static void look_after(struct sitting *sitting)
{
    enum vor_answer answer = sitting->listener->asked(sitting->listener->ctx);

    atomic_store(&sitting->worker->board->asked[sitting->seat], (int)answer);
    if (answer == VOR_CANCEL && sitting->cancelled == 0)
        sitting->cancelled = vor_clock_seconds();
    pthread_mutex_lock(&sitting->supervisor->mutex);
    if (sitting->worker->life == sitting->life) {
        check_patience(sitting);
        check_beats(sitting);
    }
    pthread_mutex_unlock(&sitting->supervisor->mutex);
}

/* The run's worker has ended, or does not speak sense. */
static enum vor_run_end lose(struct sitting *sitting, struct vor_error *err)
{
    struct worker *worker = sitting->worker;
    const struct seat *seat = &worker->seat[sitting->seat];
    enum vor_run_end end;

    pthread_mutex_lock(&sitting->supervisor->mutex);
    if (worker->life == sitting->life)
        end_life(sitting->supervisor, worker, NULL, NOBODY);
    end = seat->is_innocent ? VOR_RUN_DISTURBED
          : seat->is_only   ? VOR_RUN_CRASHED_ALONE
                            : VOR_RUN_CRASHED;
    (void)vor_fail(err, VOR_E_INTERNAL, "the worker crashed (%s)", seat->how);
    pthread_mutex_unlock(&sitting->supervisor->mutex);
    if (sitting->listener->asked(sitting->listener->ctx) != VOR_CANCEL)
        return end;
    (void)vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
    return VOR_RUN_FAILED;
}

/* What the run hands out. */
struct handed {
    struct vor_run_result *result;
    struct vor_text *kept;
    struct vor_error *err;
};

/* Takes in what the run says; true when it was its last word, and *end then says which. */
static int take_in(const struct sitting *sitting, const struct vor_message_said *said, size_t size,
                   struct handed *handed, enum vor_run_end *end)
{
    const struct vor_listener *listener = sitting->listener;

    switch (said->what) {
    case VOR_SAID_STAGE:
        listener->stage(listener->ctx, said->of.stage);
        return 0;
    case VOR_SAID_RECORD:
        listener->progress(listener->ctx, &said->of.record);
        return 0;
    case VOR_SAID_KEPT:
        vor_text_append(handed->kept, said->of.kept, size);
        return 0;
    case VOR_SAID_DONE:
        *handed->result = said->of.result;
        *end = vor_text_status(handed->kept, handed->err) == VOR_OK ? VOR_RUN_DONE : VOR_RUN_FAILED;
        return 1;
    default:
        *handed->err = said->of.error;
        *end = VOR_RUN_FAILED;
        return 1;
    }
}

/* Listens to a run until its end. */
static enum vor_run_end listen_to(struct sitting *sitting, struct handed *handed)
{
    struct vor_message_said said;
    enum vor_run_end end;
    size_t size = 0;

    for (;;) {
        switch (vor_hear(&said, &size, sitting->channel, look_seconds)) {
        case VOR_CHANNEL_MESSAGE:
            if (take_in(sitting, &said, size, handed, &end))
                return end;
            break;
        case VOR_CHANNEL_GONE:
            return lose(sitting, handed->err);
        case VOR_CHANNEL_LATE:
            break;
        }
        look_after(sitting);
    }
}

/* Runs an order at its worker. */
static enum vor_run_end run_at(struct sitting *sitting, const struct vor_order *order,
                               struct handed *handed)
{
    enum vor_run_end end;

    if (sit_down(sitting, handed->err) != VOR_OK)
        return VOR_RUN_DISTURBED;
    if (vor_order_send(sitting->channel, order, handed->err) == VOR_OK)
        end = listen_to(sitting, handed);
    else
        end = lose(sitting, handed->err);
    leave_seat(sitting);
    return end;
}

static enum vor_run_end run_there(struct vor_executor *executor, const struct vor_order *order,
                                  const struct vor_listener *listener,
                                  struct vor_run_result *result, struct vor_text *kept,
                                  struct vor_error *err)
{
    struct vor_supervisor *supervisor = (struct vor_supervisor *)executor;
    struct sitting sitting = {.supervisor = supervisor, .listener = listener};
    struct handed handed = {result, kept, err};
    enum vor_run_end end;

    sitting.worker = worker_for(supervisor, order, err);
    if (sitting.worker == NULL)
        return VOR_RUN_DISTURBED;
    end = run_at(&sitting, order, &handed);
    leave_worker(supervisor, sitting.worker);
    return end;
}

/* --- from start to end ------------------------------------------------------------------------ */

static vor_status start(struct vor_supervisor *supervisor, struct vor_error *err)
{
    vor_status status = init_worker(&supervisor->shared, &supervisor->config, err);

    return status == VOR_OK ? begin_life(supervisor, &supervisor->shared, err) : status;
}

vor_status vor_supervisor_create(struct vor_supervisor **out,
                                 const struct vor_supervisor_config *config, struct vor_error *err)
{
    struct vor_supervisor *supervisor = calloc(1, sizeof *supervisor);
    vor_status status;

    if (supervisor == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the worker process");
    supervisor->base =
        (struct vor_executor){.threads = config->threads, .is_apart = 1, .run = run_there};
    supervisor->config = *config;
    if (config->cancel_seconds == 0)
        supervisor->config.cancel_seconds = cancel_seconds;
    if (config->stall_seconds == 0)
        supervisor->config.stall_seconds = stall_seconds;
    pthread_mutex_init(&supervisor->mutex, NULL);
    status = start(supervisor, err);
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
    free_worker(&supervisor->shared);
    pthread_mutex_destroy(&supervisor->mutex);
    free(supervisor);
}

struct vor_executor *vor_supervisor_executor(struct vor_supervisor *supervisor)
{
    return &supervisor->base;
}

void vor_supervisor_counts(struct vor_supervisor *supervisor, struct vor_supervisor_counts *out)
{
    pthread_mutex_lock(&supervisor->mutex);
    *out = supervisor->counts;
    pthread_mutex_unlock(&supervisor->mutex);
}
