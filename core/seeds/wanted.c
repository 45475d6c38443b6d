#include "core/seeds/wanted.h"

enum { BLOCK = 256 }; /* seeds of one task */

vor_status vor_wanted_init(struct vor_wanted *out, const struct vor_field *field, size_t n,
                           struct vor_memory *memory, struct vor_error *err)
{
    struct vor_wanted wanted = {.field = field, .n = n};

    if (!vor_field_is(field))
        return VOR_OK;
    if (VOR_MAKE_ALL(memory, err, n, VOR_ZEROED(wanted.near, n, 1), VOR_ARRAY(wanted.value, n, 1),
                     VOR_ARRAY(wanted.scratch, n, 1)) != VOR_OK) {
        vor_wanted_free(&wanted, memory);
        return VOR_E_NOMEM;
    }
    *out = wanted;
    return VOR_OK;
}

void vor_wanted_free(struct vor_wanted *wanted, struct vor_memory *memory)
{
    VOR_FREE_ALL(memory, wanted->scratch, wanted->value, wanted->near);
    memset(wanted, 0, sizeof *wanted);
}

struct renew {
    struct vor_wanted *wanted;
    const float *xyz;
};

static void renew_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct renew *renew = ctx;
    struct vor_wanted *wanted = renew->wanted;
    struct vor_field_near *near = &wanted->near[i];
    const float *x = &renew->xyz[3 * i];
    double reach = (double)near->reach;

    if (near->value == 0 || vor_distance2f(near->at, x) > reach * reach)
        vor_field_find(near, wanted->field, x);
    wanted->value[i] = (float)vor_field_value(near, x);
}

vor_status vor_wanted_renew(struct vor_wanted *wanted, const float *xyz, const struct vor_run *run,
                            struct vor_error *err)
{
    struct renew renew = {wanted, xyz};

    if (wanted->value == NULL)
        return VOR_OK;
    return vor_run_rows(run, wanted->n, BLOCK, renew_row, &renew, err);
}

void vor_wanted_uniformity(struct vor_uniformity *out, const struct vor_wanted *wanted,
                           const float *nearest, const float *xyz)
{
    for (size_t i = 0; i < wanted->n; i++)
        wanted->scratch[i] =
            (float)((double)nearest[i] / vor_field_value(&wanted->near[i], &xyz[3 * i]));
    vor_uniformity_from(out, wanted->scratch, wanted->n);
}
