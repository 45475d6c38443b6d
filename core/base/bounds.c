#include "core/base/bounds.h"

/* Points of one task: three passes over them stay in the cache. */
enum { BLOCK = 1 << 15 };

struct boxes {
    const float *xyz;
    struct vor_box *box; /* one a block */
};

/* One coordinate at a time, so that its two bounds stay in registers. */
static void bound_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct boxes *boxes = ctx;
    struct vor_box *box = &boxes->box[begin / BLOCK];

    for (size_t c = 0; c < 3; c++) {
        float low = boxes->xyz[3 * begin + c], high = low;

        for (size_t i = begin + 1; i < end; i++) {
            float x = boxes->xyz[3 * i + c];

            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        box->low[c] = low;
        box->high[c] = high;
    }
}

vor_status vor_bounds(struct vor_box *out, const float *xyz, size_t n, const struct vor_run *run,
                      struct vor_error *err)
{
    size_t blocks = (n + BLOCK - 1) / BLOCK;
    struct boxes boxes = {xyz, vor_malloc(run->memory, blocks, sizeof *boxes.box)};
    vor_status status;

    if (boxes.box == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_run_for(run, n, BLOCK, bound_block, &boxes, err);
    if (status == VOR_OK) {
        *out = boxes.box[0];
        for (size_t i = 1; i < blocks; i++)
            for (int c = 0; c < 3; c++) {
                out->low[c] = boxes.box[i].low[c] < out->low[c] ? boxes.box[i].low[c] : out->low[c];
                out->high[c] =
                    boxes.box[i].high[c] > out->high[c] ? boxes.box[i].high[c] : out->high[c];
            }
    }
    vor_free(run->memory, boxes.box);
    return status;
}
