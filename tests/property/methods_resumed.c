/* Every process and every method that is broken off and goes on from one of its checkpoints, at
 * another number of threads, has the bytes of the run that was not; one that is damaged or of
 * another request is not used. */
#include "tests/support/vt_methods.h"

#include <string.h>

enum { MOST = 64, SIZE = 1 << 18 };

/* The checkpoints of a run. */
struct kept {
    unsigned count, resumed;
    struct vor_part block[MOST];
    char bytes[MOST][SIZE];
};

static void keep(void *ctx, const struct vor_part *part, unsigned parts)
{
    struct kept *kept = ctx;
    size_t size = 0;

    kept->resumed |= parts == 0;
    if (kept->count == MOST || parts == 0)
        return;
    for (unsigned i = 0; i < parts; size += part[i++].size) {
        ck_assert_uint_le(size + part[i].size, SIZE);
        if (part[i].size > 0)
            memcpy(&kept->bytes[kept->count][size], part[i].bytes, part[i].size);
    }
    kept->block[kept->count] = (struct vor_part){kept->bytes[kept->count], size};
    kept->count++;
}

/* Hashes what a request makes, after a checkpoint if there is one. */
static uint64_t run(struct kept *kept, const struct vor_cloud *in, const char *options,
                    unsigned threads, const struct vor_part *saved)
{
    const struct vor_watch watch = {.ctx = kept, .checkpoint = keep};
    static struct vt_engine engine;
    static struct vt_call call;

    kept->count = kept->resumed = 0;
    vt_engine_open(&engine, threads);
    engine.run.watch = &watch;
    engine.run.every = strchr(options, '=') != NULL ? 1 : 3000; /* short runs: at each step */
    if (saved != NULL)
        engine.run.saved = *saved;
    call = (struct vt_call){.in = in, .run = &engine.run, .options = options};
    vt_assert_ok(vt_call_request(&call));
    vt_engine_close(&engine);
    return call.hash;
}

static struct kept whole, other;

VT_TEST_LOOP(a_run_that_goes_on_has_the_same_bytes, vt_methods_count())
{
    const struct vt_row *row = &vt_methods[_i];
    struct vor_cloud in;
    uint64_t hash;

    row->make(&in, 1, row->many);
    hash = run(&whole, &in, row->options, 3, NULL);
    for (unsigned i = 0; i < whole.count; i += 1 + whole.count / 2) {
        ck_assert_msg(run(&other, &in, row->options, 1 + 2 * (i % 2), &whole.block[i]) == hash,
                      "%s: checkpoint %u of %u", row->name, i, whole.count);
        ck_assert_uint_eq(other.resumed, 1);
    }
    vor_cloud_free(&in);
}

/* _i: a bit turned here or there, bytes taken off, another request, another input. The comparison
 * can tell: another seed gives other bytes. */
VT_TEST_LOOP(a_checkpoint_that_is_not_of_this_run_is_not_used, 20)
{
    const char *options = _i == 18 ? "resample points=100 seed=2" : "resample points=100";
    struct vor_part last;
    struct vor_cloud in;
    uint64_t hash, first;

    vt_cloud_dome(&in, 1, 1000);
    first = run(&whole, &in, "resample points=100", 2, NULL);
    last = whole.block[whole.count - 1];
    if (_i < 14)
        ((char *)last.bytes)[last.size * (size_t)(_i * _i * _i) / (14 * 14 * 14)] ^= 16;
    else if (_i < 18)
        last.size -= (size_t[]){1, 1000, last.size - 1, last.size - 8000}[_i - 14];
    in.xyz[0] += _i == 19;
    hash = run(&other, &in, options, 2, &last);
    ck_assert_uint_eq(other.resumed, 0);
    ck_assert(run(&whole, &in, options, 2, NULL) == hash && (hash == first) == (_i < 18));
    vor_cloud_free(&in);
}
