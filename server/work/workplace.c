#include "server/work/workplace.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/work/station.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const double start_seconds = 30; /* for a process, to be ready */
static const double end_seconds = 10;   /* for one that was killed, to be gone */

vor_status vor_workplace_init(struct vor_workplace *workplace, unsigned threads, size_t memory,
                              struct vor_error *err)
{
    vor_status status = vor_board_create(&workplace->board, &workplace->board_fd, err);

    if (status != VOR_OK)
        return status;
    workplace->board->threads = threads;
    workplace->board->memory = memory;
    return VOR_OK;
}

void vor_workplace_free(struct vor_workplace *workplace)
{
    if (workplace->is_up)
        vor_child_free(&workplace->child); /* which ends it */
    if (workplace->board == NULL)
        return;
    vor_board_unmap(workplace->board);
    (void)close(workplace->board_fd);
}

unsigned vor_workplace_runs(const struct vor_workplace *workplace)
{
    unsigned count = 0;

    for (unsigned i = 0; i < VOR_SEATS; i++)
        count += workplace->seat[i].taken && workplace->seat[i].life == workplace->life;
    return count;
}

static void describe_end(char out[64], const struct vor_child_end *end)
{
    if (end->signal != 0)
        (void)snprintf(out, 64, "signal %d", end->signal);
    else if (end->status == VOR_STATION_NO_MEMORY)
        (void)snprintf(out, 64, "memory ran out");
    else
        (void)snprintf(out, 64, "exit status %d", end->status);
}

void vor_workplace_reap(struct vor_workplace_end *out, struct vor_child *child, const char *why)
{
    *out = (struct vor_workplace_end){.end = {.signal = 0}};
    vor_child_kill(child);
    if (vor_child_wait(child, &out->end, end_seconds) && why == NULL)
        describe_end(out->how, &out->end);
    else
        (void)snprintf(out->how, sizeof out->how, "%s", why != NULL ? why : "it does not end");
}

void vor_workplace_end(struct vor_workplace *workplace, const struct vor_workplace_end *end,
                       int blamed)
{
    int is_only = vor_workplace_runs(workplace) == 1;

    vor_child_free(&workplace->child);
    workplace->is_up = 0;
    for (unsigned i = 0; i < VOR_SEATS; i++) {
        struct vor_seat *seat = &workplace->seat[i];

        if (!seat->taken || seat->life != workplace->life)
            continue;
        seat->is_only = is_only;
        seat->is_innocent = blamed != VOR_NOBODY && blamed != (int)i;
        memcpy(seat->how, end->how, sizeof seat->how);
    }
    vor_log(VOR_LOG_ERROR, "worker ended", VOR_TEXT("how", end->how),
            VOR_COUNT("pid", workplace->child.pid),
            VOR_COUNT("jobs", vor_workplace_runs(workplace)),
            VOR_REAL("cpu_s", end->end.cpu_seconds), VOR_COUNT("peak", end->end.peak));
}

/* Waits until a worker says that it is ready. */
static vor_status wait_ready(struct vor_child *child, struct vor_error *err)
{
    struct vor_child_end end = {.signal = 0};
    struct vor_error why;
    char how[64];
    struct vor_message message = {.bytes = &why, .capacity = sizeof why};

    if (vor_channel_receive(child->channel, &message, start_seconds) == VOR_CHANNEL_MESSAGE) {
        vor_message_close(&message);
        if (message.size != sizeof why)
            return VOR_OK;
        vor_child_kill(child);
        (void)vor_child_wait(child, &end, end_seconds);
        return vor_fail(err, VOR_E_INTERNAL, "the engine fails its self-test: %.*s",
                        (int)sizeof why.message, why.message);
    }
    vor_child_kill(child);
    (void)vor_child_wait(child, &end, end_seconds);
    if (end.status == VOR_STATION_NO_POOL)
        return vor_fail(err, VOR_E_NOMEM,
                        "cannot start the threads of the worker: too little memory, or a limit on "
                        "the number of processes");
    describe_end(how, &end);
    return vor_fail(err, VOR_E_IO, "the worker process cannot be started: %s", how);
}

vor_status vor_workplace_spawn(struct vor_child *child, const struct vor_workplace *workplace,
                               struct vor_zygote *zygote, unsigned kind, struct vor_error *err)
{
    const int fds[] = {workplace->board_fd, zygote->socket};
    vor_status status =
        vor_zygote_spawn(child, zygote, kind, fds, workplace->board->has_codec ? 2 : 1, err);

    if (status != VOR_OK)
        return status;
    status = wait_ready(child, err);
    if (status != VOR_OK)
        vor_child_free(child);
    return status;
}

void vor_workplace_begin(struct vor_workplace *workplace, const struct vor_child *child)
{
    workplace->child = *child;
    workplace->is_up = 1;
    workplace->life++;
    workplace->beats = atomic_load(&workplace->board->beats);
    workplace->beat = vor_clock_seconds();
    vor_log(VOR_LOG_INFO, "worker started", VOR_COUNT("pid", child->pid));
}

/* --- runs that nobody listens to ---------------------------------------------------------------
 */

static enum vor_answer answer_cancel(void *ctx)
{
    (void)ctx;
    return VOR_CANCEL;
}

static void ignore(void *ctx, enum vor_said what, const void *of)
{
    (void)ctx;
    (void)what;
    (void)of;
}

const struct vor_listener vor_nobody = {.asked = answer_cancel, .said = ignore};
