#include "server/cli/interrupt.h"

#include <signal.h>
#include <stdatomic.h>
#include <string.h>

static atomic_int caught; /* the first signal; lock-free, so that a handler may set it */

static void on_signal(int signal)
{
    int none = 0;

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

int vor_interrupt_seen(void)
{
    return atomic_load_explicit(&caught, memory_order_relaxed);
}

vor_status vor_interrupt_fail(struct vor_error *err)
{
    return vor_fail(err, VOR_E_CANCELLED, "cancelled");
}
