#include "server/store/postgres_hints.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/base/metrics.h"
#include "server/base/postgres_library.h"

#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

/* Between two NOTIFY; between two questions whether the server is there, and for an answer. */
static const double tell_seconds = 0.25, ping_seconds = 15, answer_seconds = 4;

/* Between two tries to connect. */
static const double first_pause = 1, longest_pause = 30;

struct vor_postgres_hints {
    const struct vor_pg *pg;
    char *where;
    void (*heard)(void *ctx);
    void *ctx;
    int wake; /* an eventfd */
    atomic_int is_wanted, is_closing;
    pthread_t thread;
    int is_started;
    PGconn *handle; /* the thread's, as all below; NULL while there is none */
    double asked, told;
};

static const char what[] = "the connection of --store-listen";

/* A commit of nothing but a NOTIFY need not wait for the disk. The channel is the schema's. */
#define CHANNEL "'voronoid_' || md5(current_schema())"
static const char listen_sql[] = "SET synchronous_commit = off;"
                                 " DO $$ BEGIN EXECUTE 'LISTEN ' || " CHANNEL "; END $$";
static const char tell_sql[] = "SELECT pg_notify(" CHANNEL ", '')";

static int is_open(void *ctx)
{
    return !atomic_load(&((struct vor_postgres_hints *)ctx)->is_closing);
}

static vor_status ask(struct vor_postgres_hints *hints, const char *sql, struct vor_error *err)
{
    const struct vor_pg_question question = {
        .what = what, .sql = sql, .seconds = answer_seconds, .is_wanted = is_open, .ctx = hints};
    PGresult *result = NULL;
    vor_status status = vor_pg_ask(&result, hints->handle, &question, err);

    hints->pg->clear(result);
    hints->asked = vor_clock_seconds();
    return status;
}

static void disconnect(struct vor_postgres_hints *hints)
{
    if (hints->handle != NULL)
        hints->pg->finish(hints->handle);
    hints->handle = NULL;
}

static vor_status connect_and_listen(struct vor_postgres_hints *hints, struct vor_error *err)
{
    struct vor_error why;
    vor_status status = VOR_OK;

    hints->handle = vor_pg_connect(hints->where, what, &why);
    status = hints->handle != NULL ? ask(hints, listen_sql, &why) : why.status;
    if (status == VOR_OK)
        return VOR_OK;
    disconnect(hints);
    *err = why;
    return status;
}

/* Waits until a hint arrives or is to be sent, at most so long. */
static void await(struct vor_postgres_hints *hints, double seconds)
{
    struct pollfd fds[] = {
        {.fd = hints->wake, .events = POLLIN},
        {.fd = hints->handle != NULL ? hints->pg->socket(hints->handle) : -1, .events = POLLIN}};
    uint64_t count;

    if (poll(fds, 2, seconds > 0 ? (int)(1000 * seconds) + 1 : 0) > 0 && fds[0].revents != 0)
        (void)!read(hints->wake, &count, sizeof count);
}

/* Sends a hint if one is due, reads what has arrived, and waits; VOR_E_IO if the connection has
 * broken. */
static vor_status exchange(struct vor_postgres_hints *hints, struct vor_error *err)
{
    const struct vor_pg *pg = hints->pg;
    double now = vor_clock_seconds(), until = hints->asked + ping_seconds;
    struct vor_pg_notify *said;
    vor_status status = VOR_OK;
    int has_heard = 0;

    if (atomic_load(&hints->is_wanted) && now >= hints->told + tell_seconds) {
        atomic_store(&hints->is_wanted, 0);
        hints->told = now;
        status = ask(hints, tell_sql, err);
        vor_metric_add(VOR_METRIC_STORE_HINTS, 1, VOR_LABELS("sent"));
    } else if (now >= until) {
        status = ask(hints, "SELECT 1", err);
    }
    if (status == VOR_OK && !pg->consumeInput(hints->handle))
        status = vor_fail(err, VOR_E_IO, "%s was closed", what);
    while ((said = pg->notifies(hints->handle)) != NULL) {
        has_heard |= said->from != pg->backendPID(hints->handle);
        pg->freemem(said);
    }
    if (has_heard)
        hints->heard(hints->ctx);
    if (status == VOR_OK) {
        until = atomic_load(&hints->is_wanted) ? hints->told + tell_seconds : until;
        await(hints, until - vor_clock_seconds());
    }
    return status;
}

static void *main_of(void *arg)
{
    struct vor_postgres_hints *hints = arg;
    double pause = first_pause;
    struct vor_error err;

    while (is_open(hints)) {
        if (hints->handle != NULL && exchange(hints, &err) != VOR_OK && is_open(hints)) {
            vor_log(VOR_LOG_WARN, "changes of other daemons are found by polling alone",
                    VOR_TEXT("error", err.message));
            disconnect(hints);
        }
        for (double until = vor_clock_seconds() + pause;
             hints->handle == NULL && is_open(hints) && vor_clock_seconds() < until;)
            await(hints, until - vor_clock_seconds());
        if (hints->handle != NULL || !is_open(hints))
            continue;
        if (connect_and_listen(hints, &err) != VOR_OK) {
            pause = 2 * pause < longest_pause ? 2 * pause : longest_pause;
            continue;
        }
        pause = first_pause;
        vor_log(VOR_LOG_INFO, "hints of other daemons arrive again");
        hints->heard(hints->ctx); /* hints may have been missed meanwhile */
    }
    return NULL;
}

vor_status vor_postgres_hints_open(struct vor_postgres_hints **out, const char *where,
                                   void (*heard)(void *ctx), void *ctx, struct vor_error *err)
{
    static const char scheme[] = "postgres:";
    struct vor_postgres_hints *hints = calloc(1, sizeof *hints);
    vor_status status;

    if (hints == NULL)
        return vor_fail(err, VOR_E_NOMEM, what);
    hints->heard = heard;
    hints->ctx = ctx;
    hints->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    hints->where = vor_pg_where(
        strncmp(where, scheme, sizeof scheme - 1) == 0 ? where + sizeof scheme - 1 : where);
    status = hints->where != NULL && hints->wake >= 0 ? vor_pg_load(&hints->pg, err)
                                                      : vor_fail(err, VOR_E_NOMEM, what);
    VOR_THEN(status, connect_and_listen(hints, err));
    if (status == VOR_OK) {
        hints->is_started = vor_machine_thread(&hints->thread, "vor-hints", main_of, hints) == 0;
        if (!hints->is_started)
            status = vor_fail(err, VOR_E_NOMEM, "cannot start the thread of --store-listen");
    }
    if (status != VOR_OK) {
        vor_postgres_hints_close(hints);
        return status;
    }
    *out = hints;
    return VOR_OK;
}

static void wake(struct vor_postgres_hints *hints)
{
    const uint64_t one = 1;

    (void)!write(hints->wake, &one, sizeof one);
}

void vor_postgres_hints_close(struct vor_postgres_hints *hints)
{
    if (hints == NULL)
        return;
    atomic_store(&hints->is_closing, 1);
    wake(hints);
    if (hints->is_started)
        (void)pthread_join(hints->thread, NULL);
    disconnect(hints);
    if (hints->wake >= 0)
        (void)close(hints->wake);
    free(hints->where);
    free(hints);
}

void vor_postgres_hints_tell(struct vor_postgres_hints *hints)
{
    if (!atomic_exchange(&hints->is_wanted, 1))
        wake(hints);
}
