#include "server/cli/interrupt.h"

#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

/* Lock-free, so that a handler may set them. */
static atomic_int caught; /* the first signal that cancels */
static atomic_int keeps, stops;

static void on_signal(int signal)
{
    static const char said[] = "voronoid: stopping; the best result so far is written. Press "
                               "^C again to cancel the run\n";
    int none = 0;

    if (signal == SIGINT && atomic_load(&keeps) && !atomic_exchange(&stops, 1)) {
        int error = errno;

        if (write(STDERR_FILENO, said, sizeof said - 1) < 0)
            errno = 0; /* nobody listens */
        errno = error;
        return;
    }
    (void)atomic_compare_exchange_strong(&caught, &none, signal);
}

void vor_interrupt_catch(void)
{
    struct sigaction action;

    memset(&action, 0, sizeof action);
    sigemptyset(&action.sa_mask);
    action.sa_handler = on_signal;
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
}

void vor_interrupt_keep_best(void)
{
    atomic_store(&keeps, 1);
}

int vor_interrupt_stops(void)
{
    return atomic_load_explicit(&stops, memory_order_relaxed);
}

int vor_interrupt_seen(void)
{
    return atomic_load_explicit(&caught, memory_order_relaxed);
}

vor_status vor_interrupt_fail(struct vor_error *err)
{
    return vor_fail(err, VOR_E_CANCELLED, "cancelled");
}
