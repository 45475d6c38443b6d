/* A worker process has a life: from its start until it ends, by itself or by us. A run has a seat,
 * which belongs to one life; when that ends, how is noted at each of its seats, and whoever waits
 * there finds its channel closed and reads the note. */
#include "server/work/supervisor.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/work/station.h"
#include "server/work/wire.h"

#include <assert.h>
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const double look_seconds = 0.02;  /* between two questions to a listener */
static const double watch_seconds = 0.25; /* between two looks at the beats */
static const double start_seconds = 30;   /* for a worker, to be ready */
static const double end_seconds = 10;     /* for one that was killed, to be gone */

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

struct vor_supervisor {
    struct vor_executor base;
    struct vor_supervisor_config config;
    struct vor_board *board;
    int board_fd;
    pthread_mutex_t mutex;  /* everything below */
    pthread_cond_t changed; /* closing; on the monotonic clock */
    int closing;
    int is_up;
    struct vor_child child; /* while it is up */
    uint64_t life;          /* number of the last one started */
    struct vor_supervisor_counts counts;
    unsigned beats; /* when they were last looked at */
    double beat;    /* when they had changed */
    struct seat seat[VOR_SEATS];
    int has_watcher;
    pthread_t watcher;
};

/* --- a life; the mutex is held ---------------------------------------------------------------- */

static unsigned runs_of(const struct vor_supervisor *supervisor, uint64_t life)
{
    unsigned count = 0;

    for (unsigned i = 0; i < VOR_SEATS; i++)
        count += supervisor->seat[i].taken && supervisor->seat[i].life == life;
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
static void note_end(struct vor_supervisor *supervisor, const char *how, int blamed)
{
    int is_only = runs_of(supervisor, supervisor->life) == 1;

    for (unsigned i = 0; i < VOR_SEATS; i++) {
        struct seat *seat = &supervisor->seat[i];

        if (!seat->taken || seat->life != supervisor->life)
            continue;
        seat->is_only = is_only;
        seat->is_innocent = blamed != NOBODY && blamed != (int)i;
        (void)snprintf(seat->how, sizeof seat->how, "%s", how);
    }
}

/* Ends the worker if it has not ended yet.
 *
 * why: NULL when it has ended by itself. blamed: the seat of the run because of which it is ended.
 */
static void end_life(struct vor_supervisor *supervisor, const char *why, int blamed)
{
    struct vor_child_end end = {.signal = 0};
    char how[64];

    if (!supervisor->is_up)
        return;
    vor_child_kill(&supervisor->child);
    if (vor_child_wait(&supervisor->child, &end, end_seconds) && why == NULL)
        describe_end(how, &end);
    else
        (void)snprintf(how, sizeof how, "%s", why != NULL ? why : "it does not end");
    vor_child_free(&supervisor->child);
    supervisor->is_up = 0;
    supervisor->counts.crashed++;
    note_end(supervisor, how, blamed);
    vor_log(VOR_LOG_ERROR, "worker ended", VOR_TEXT("how", how),
            VOR_COUNT("pid", supervisor->child.pid),
            VOR_COUNT("jobs", runs_of(supervisor, supervisor->life)),
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

static vor_status begin_life(struct vor_supervisor *supervisor, struct vor_error *err)
{
    const struct vor_supervisor_config *config = &supervisor->config;
    struct vor_child child;
    vor_status status =
        vor_zygote_spawn(&child, config->zygote, config->kind, &supervisor->board_fd, 1, err);

    if (status != VOR_OK)
        return status;
    status = wait_ready(&child, err);
    if (status != VOR_OK) {
        vor_child_free(&child);
        return status;
    }
    supervisor->child = child;
    supervisor->is_up = 1;
    supervisor->life++;
    supervisor->counts.started++;
    supervisor->beats = atomic_load(&supervisor->board->beats);
    supervisor->beat = vor_clock_seconds();
    vor_log(VOR_LOG_INFO, "worker started", VOR_COUNT("pid", child.pid));
    return VOR_OK;
}

/* --- the watcher ------------------------------------------------------------------------------ */

/* Ends a worker whose ticker stands still; the mutex is held. */
static void check_beats(struct vor_supervisor *supervisor)
{
    unsigned beats = atomic_load(&supervisor->board->beats);
    double now = vor_clock_seconds();

    if (beats != supervisor->beats) {
        supervisor->beats = beats;
        supervisor->beat = now;
    } else if (supervisor->is_up && now - supervisor->beat > supervisor->config.stall_seconds) {
        end_life(supervisor, "no sign of life", NOBODY);
    }
}

static void *watch(void *arg)
{
    struct vor_supervisor *supervisor = arg;

    pthread_mutex_lock(&supervisor->mutex);
    while (!supervisor->closing) {
        double until = vor_clock_seconds() + watch_seconds;
        struct timespec at = {.tv_sec = (time_t)until};

        at.tv_nsec = (long)((until - (double)at.tv_sec) * 1e9);
        (void)pthread_cond_timedwait(&supervisor->changed, &supervisor->mutex, &at);
        check_beats(supervisor);
    }
    pthread_mutex_unlock(&supervisor->mutex);
    return NULL;
}

/* --- a run ------------------------------------------------------------------------------------ */

struct sitting {
    struct vor_supervisor *supervisor;
    const struct vor_listener *listener;
    int seat, channel;
    uint64_t life;
    double cancelled; /* when the listener was first seen to cancel; 0 for not yet */
};

/* Takes a free seat at the worker, which is up; the mutex is held. */
static vor_status take_seat(struct sitting *sitting, struct vor_error *err)
{
    struct vor_supervisor *supervisor = sitting->supervisor;
    int i = 0;

    while (i < VOR_SEATS && supervisor->seat[i].taken)
        i++;
    if (i == VOR_SEATS)
        return vor_fail(err, VOR_E_INTERNAL, "more than %d runs at a time", VOR_SEATS);
    supervisor->seat[i] = (struct seat){.taken = 1, .life = supervisor->life};
    atomic_store(&supervisor->board->asked[i], VOR_CONTINUE);
    sitting->seat = i;
    sitting->life = supervisor->life;
    return VOR_OK;
}

static void leave_seat(struct sitting *sitting)
{
    struct vor_supervisor *supervisor = sitting->supervisor;

    (void)close(sitting->channel);
    pthread_mutex_lock(&supervisor->mutex);
    supervisor->seat[sitting->seat].taken = 0;
    pthread_mutex_unlock(&supervisor->mutex);
}

/* Sends the worker a channel for the run; the mutex is held. */
static vor_status summon(struct sitting *sitting, struct vor_error *err)
{
    struct vor_summons summons = {.seat = (unsigned)sitting->seat};
    int ends[2];
    vor_status status = vor_channel_pair(ends, err);

    if (status != VOR_OK)
        return status;
    status = vor_channel_send(sitting->supervisor->child.channel, &summons, sizeof summons,
                              &ends[1], 1, err);
    (void)close(ends[1]);
    if (status == VOR_OK)
        sitting->channel = ends[0];
    else
        (void)close(ends[0]);
    return status;
}

/* Begins a run at a worker, which is started where there is none. A worker that has died since its
 * last run shows when it is spoken to. */
static vor_status sit_down(struct sitting *sitting, struct vor_error *err)
{
    struct vor_supervisor *supervisor = sitting->supervisor;
    vor_status status = VOR_E_IO;

    pthread_mutex_lock(&supervisor->mutex);
    for (int i = 0; i < STARTS && status == VOR_E_IO; i++) {
        status = supervisor->is_up ? VOR_OK : begin_life(supervisor, err);
        if (status == VOR_OK)
            status = take_seat(sitting, err);
        if (status != VOR_OK)
            break;
        status = summon(sitting, err);
        if (status == VOR_OK)
            break;
        supervisor->seat[sitting->seat].taken = 0;
        end_life(supervisor, NULL, NOBODY);
    }
    pthread_mutex_unlock(&supervisor->mutex);
    return status;
}

/* Ends the worker because of this run, once it is cancelled for too long. */
static void press(struct sitting *sitting)
{
    struct vor_supervisor *supervisor = sitting->supervisor;
    double since = vor_clock_seconds() - sitting->cancelled;

    if (since < cancel_alone_share * supervisor->config.cancel_seconds)
        return;
    pthread_mutex_lock(&supervisor->mutex);
    if (supervisor->life == sitting->life &&
        (since >= supervisor->config.cancel_seconds || runs_of(supervisor, sitting->life) == 1))
        end_life(supervisor, "a cancelled run did not end", sitting->seat);
    pthread_mutex_unlock(&supervisor->mutex);
}

/* Tells the run what is asked of it. */
static void pass_on(struct sitting *sitting)
{
    enum vor_answer answer = sitting->listener->asked(sitting->listener->ctx);

    atomic_store(&sitting->supervisor->board->asked[sitting->seat], (int)answer);
    if (answer != VOR_CANCEL)
        return;
    if (sitting->cancelled == 0)
        sitting->cancelled = vor_clock_seconds();
    press(sitting);
}

/* The run's worker has ended, or does not speak sense. */
static enum vor_run_end lose(struct sitting *sitting, struct vor_error *err)
{
    struct vor_supervisor *supervisor = sitting->supervisor;
    const struct seat *seat = &supervisor->seat[sitting->seat];
    enum vor_run_end end;

    pthread_mutex_lock(&supervisor->mutex);
    if (supervisor->life == sitting->life)
        end_life(supervisor, NULL, NOBODY);
    end = seat->is_innocent ? VOR_RUN_DISTURBED
          : seat->is_only   ? VOR_RUN_CRASHED_ALONE
                            : VOR_RUN_CRASHED;
    (void)vor_fail(err, VOR_E_INTERNAL, "the worker crashed (%s)", seat->how);
    pthread_mutex_unlock(&supervisor->mutex);
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
        pass_on(sitting);
    }
}

static enum vor_run_end run_there(struct vor_executor *executor, const struct vor_order *order,
                                  const struct vor_listener *listener,
                                  struct vor_run_result *result, struct vor_text *kept,
                                  struct vor_error *err)
{
    struct sitting sitting = {.supervisor = (struct vor_supervisor *)executor,
                              .listener = listener};
    struct handed handed = {result, kept, err};
    enum vor_run_end end;

    if (sit_down(&sitting, err) != VOR_OK)
        return VOR_RUN_DISTURBED;
    if (vor_order_send(sitting.channel, order, err) == VOR_OK)
        end = listen_to(&sitting, &handed);
    else
        end = lose(&sitting, err);
    leave_seat(&sitting);
    return end;
}

/* --- from start to end ------------------------------------------------------------------------ */

static void init_locks(struct vor_supervisor *supervisor)
{
    pthread_condattr_t monotonic;

    pthread_mutex_init(&supervisor->mutex, NULL);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&supervisor->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

static vor_status start(struct vor_supervisor *supervisor, struct vor_error *err)
{
    vor_status status = vor_board_create(&supervisor->board, &supervisor->board_fd, err);

    if (status != VOR_OK)
        return status;
    supervisor->board->threads = supervisor->config.threads;
    supervisor->board->memory = supervisor->config.memory;
    status = begin_life(supervisor, err);
    if (status != VOR_OK)
        return status;
    if (pthread_create(&supervisor->watcher, NULL, watch, supervisor) != 0)
        return vor_fail(err, VOR_E_NOMEM, "cannot start the thread that watches the worker");
    supervisor->has_watcher = 1;
    return VOR_OK;
}

vor_status vor_supervisor_create(struct vor_supervisor **out,
                                 const struct vor_supervisor_config *config, struct vor_error *err)
{
    struct vor_supervisor *supervisor = calloc(1, sizeof *supervisor);
    vor_status status;

    if (supervisor == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the worker process");
    supervisor->base.run = run_there;
    supervisor->config = *config;
    if (config->cancel_seconds == 0)
        supervisor->config.cancel_seconds = cancel_seconds;
    if (config->stall_seconds == 0)
        supervisor->config.stall_seconds = stall_seconds;
    supervisor->board_fd = -1;
    init_locks(supervisor);
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
    pthread_mutex_lock(&supervisor->mutex);
    supervisor->closing = 1;
    pthread_cond_broadcast(&supervisor->changed);
    pthread_mutex_unlock(&supervisor->mutex);
    if (supervisor->has_watcher)
        pthread_join(supervisor->watcher, NULL);
    if (supervisor->is_up)
        vor_child_free(&supervisor->child); /* which ends it */
    vor_board_unmap(supervisor->board);
    if (supervisor->board_fd >= 0)
        (void)close(supervisor->board_fd);
    pthread_cond_destroy(&supervisor->changed);
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
