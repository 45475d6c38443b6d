#include "core/process.h"
#include "tests/poison/rows.h"

#include <stdlib.h>

VT_POISON_RUN(fault)
{
    volatile int *volatile nowhere = NULL;

    (void)out, (void)in, (void)spec, (void)run;
    *nowhere = 1;
    return vor_fail(err, VOR_E_INTERNAL, "the poison does not work");
}

VT_POISON_RUN(abort)
{
    (void)out, (void)in, (void)spec, (void)run, (void)err;
    abort();
}

static void turn(void *ctx, size_t begin, size_t end, unsigned worker)
{
    volatile unsigned turns = 0;

    (void)ctx, (void)worker;
    for (; end > begin; turns++)
        continue;
}

VT_POISON_RUN(spin)
{
    (void)out, (void)in, (void)spec;
    if (vor_parallel_for(run->pool, NULL, 1, 1, turn, NULL) != VOR_CONTINUE)
        return vor_fail(err, VOR_E_INTERNAL, "the poison was stopped");
    return vor_fail(err, VOR_E_INTERNAL, "the poison does not work");
}

/* None of it is given back, and nothing counts it. */
VT_POISON_RUN(leak)
{
    const size_t size = (size_t)1 << 20;
    volatile char *bytes;

    (void)out, (void)in, (void)spec, (void)run;
    while ((bytes = malloc(size)) != NULL)
        bytes[0] = bytes[size - 1] = 1;
    return vor_fail(err, VOR_E_NOMEM, "the poison has all memory");
}
