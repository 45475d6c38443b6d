#include "core/process.h"

#include <stdlib.h>

/* The words of venom. */
enum { FAULT, ABORT, SPIN, LEAK };

static void spin(void *ctx, size_t begin, size_t end, unsigned worker)
{
    volatile unsigned turns = 0;

    (void)ctx;
    (void)worker;
    for (; end > begin; turns++)
        continue;
}

/* Takes memory that nobody counts until there is none, and gives none back. */
static vor_status leak(struct vor_error *err)
{
    const size_t size = (size_t)1 << 20;
    volatile char *bytes;

    while ((bytes = malloc(size)) != NULL)
        bytes[0] = bytes[size - 1] = 1;
    return vor_fail(err, VOR_E_NOMEM, "the poison has all memory");
}

vor_status vor_toy_poison(struct vor_artefacts *out, const struct vor_artefacts *in,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    volatile int *volatile nowhere = NULL;
    int venom = (int)spec->value[VOR_PARAM_VENOM];

    (void)out;
    (void)in;
    if (venom == ABORT)
        abort();
    if (venom == SPIN && vor_parallel_for(run->pool, NULL, 1, 1, spin, NULL) != VOR_CONTINUE)
        return vor_fail(err, VOR_E_INTERNAL, "the poison was stopped");
    if (venom == LEAK)
        return leak(err);
    if (venom == FAULT)
        *nowhere = 1;
    return vor_fail(err, VOR_E_INTERNAL, "the poison does not work");
}
