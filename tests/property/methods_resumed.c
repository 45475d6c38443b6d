/* Every process and every method that is broken off and goes on from one of its checkpoints, at
 * another number of threads, has the bytes of the run that was not; one that is damaged or of
 * another request is not used. */
#include "core/engine.h"
#include "tests/support/vt_methods.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 64 };

/* The checkpoints of a run. */
struct kept {
    struct vor_part block[MOST];
    unsigned count, records;
};

static void keep(void *ctx, const struct vor_part *part, unsigned parts)
{
    struct kept *kept = ctx;
    struct vor_part *block = &kept->block[kept->count];

    if (kept->count == MOST)
        return;
    for (unsigned i = 0; i < parts; i++) {
        block->bytes = realloc(block->bytes, block->size + part[i].size + 1);
        ck_assert_ptr_nonnull(block->bytes);
        if (part[i].size > 0)
            memcpy((char *)block->bytes + block->size, part[i].bytes, part[i].size);
        block->size += part[i].size;
    }
    kept->count++;
}

static enum vor_answer count_record(void *ctx, const struct vor_record *record)
{
    struct kept *kept = ctx;

    (void)record;
    kept->records++;
    return VOR_CONTINUE;
}

static void drop(struct kept *kept)
{
    for (unsigned i = 0; i < MOST; i++)
        free(kept->block[i].bytes);
    memset(kept, 0, sizeof *kept);
}

/* Runs a request, on from a checkpoint if there is one; how many records it told. */
static unsigned run(struct vt_call *call, struct kept *kept, unsigned threads,
                    const struct vor_part *saved)
{
    uint64_t every = strstr(call->options, "=") != NULL ? 1 : 3000; /* short runs: at each step */
    const struct vor_watch watch = {.ctx = kept, .progress = count_record, .checkpoint = keep};
    static struct vt_engine engine;

    drop(kept);
    vt_engine_open(&engine, threads);
    engine.run.watch = &watch;
    engine.run.every = every;
    if (saved != NULL)
        engine.run.saved = *saved;
    call->run = &engine.run;
    call->hash = 0;
    vt_assert_ok(vt_call_request(call));
    vt_engine_close(&engine);
    return kept->records;
}

VT_TEST_LOOP(a_run_that_goes_on_has_the_same_bytes, vt_methods_count())
{
    const struct vt_row *row = &vt_methods[_i];
    static struct vt_call call;
    static struct kept whole, other;
    unsigned records;
    struct vor_cloud in;
    uint64_t hash;

    row->make(&in, 1, row->many);
    call.in = &in;
    call.options = row->options;
    records = run(&call, &whole, 3, NULL);
    hash = call.hash;
    ck_assert(run(&call, &other, 1, NULL) == records && call.hash == hash);
    ck_assert_uint_eq(other.count, whole.count);
    for (unsigned i = 0; i < whole.count; i += 1 + whole.count / 2) {
        unsigned left = run(&call, &other, i % 2 ? 3 : 1, &whole.block[i]);

        ck_assert_msg(call.hash == hash, "%s: checkpoint %u of %u", row->name, i, whole.count);
        ck_assert_msg(left <= records, "%s: checkpoint %u was not used", row->name, i);
    }
    drop(&whole);
    drop(&other);
    vor_cloud_free(&in);
}

/* What is done to a checkpoint of `size` bytes before it is given to a run. */
static const struct damage {
    const char *options; /* of that run, NULL: the same */
    double flip;         /* where a bit is turned, of 0 .. 1; below 0: nowhere */
    long cut;            /* bytes that are taken off, or that follow where it is below 0 */
} damages[] = {
    {NULL, 0, 0},
    {NULL, 0.0005, 0},
    {NULL, 0.001, 0},
    {NULL, 0.01, 0},
    {NULL, 0.3, 0},
    {NULL, 0.5, 0},
    {NULL, 0.9, 0},
    {NULL, 0.9999, 0},
    {NULL, -1, 1},
    {NULL, -1, 4},
    {NULL, -1, 1000},
    {NULL, -1, 8000},
    {NULL, -1, -1},
    {NULL, -1, -1000},
    {"resample points=100 seed=2", -1, 0},
    {"resample points=101", -1, 0},
    {"denoise points=100", -1, 0},
};

VT_TEST_LOOP(a_checkpoint_that_is_not_of_this_run_is_not_used, sizeof damages / sizeof damages[0])
{
    const struct damage *damage = &damages[_i];
    static struct vt_call call;
    static struct kept whole, other;
    struct vor_cloud in;
    struct vor_part last;
    unsigned records, left;
    uint64_t hash;

    vt_cloud_dome(&in, 1, 1000);
    call.in = &in;
    call.options = damage->options != NULL ? damage->options : "resample points=100";
    records = run(&call, &other, 2, NULL);
    hash = call.hash;
    call.options = "resample points=100";
    run(&call, &whole, 2, NULL);
    last = whole.block[whole.count - 1];
    left = run(&call, &other, 2, &last);
    ck_assert(left < records); /* it would be */
    last.bytes = calloc(1, last.size + 1000);
    memcpy(last.bytes, whole.block[whole.count - 1].bytes, last.size);
    if (damage->flip >= 0)
        ((unsigned char *)last.bytes)[(size_t)(damage->flip * (double)last.size)] ^= 16;
    last.size -= (size_t)damage->cut;
    call.options = damage->options != NULL ? damage->options : call.options;
    ck_assert_uint_eq(run(&call, &other, 2, &last), records);
    ck_assert(call.hash == hash);
    free(last.bytes);
    drop(&whole);
    drop(&other);
    vor_cloud_free(&in);
}
