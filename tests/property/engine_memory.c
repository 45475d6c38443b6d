/* What a run allocates: so much for each point of the input and of the result, nothing more while
 * it iterates, and no more than its cap. */
#include "tests/support/vt_ask.h"

#include <string.h>

enum { RECORDS = 160, CALLS = 14 }; /* CALLS of the allocator for one index */

/* Bytes at the peak, the caller's clouds apart: for each input point its index and what is kept of
 * it; for each seed its surface and its lists, and again for those that a start by areas has of its
 * own, where the input is not ten times as many; or while iterating the candidates, the momentum
 * and a second index of them; a bench for each thread and set. */
#define EACH_IN(own) ((own) > 0 ? 70 : 62) /* the start keeps fits of its own */
#define EACH_SEED(k) (6 * (k) + 395)
#define EACH_ITERATED(k) (6 * (k) + 502)
#define EACH_THREAD (200 << 10)
#define ELSE (51 << 10)

static size_t bound_of(size_t in, size_t out, size_t k, size_t threads)
{
    size_t own = in / 10 >= out ? 0 : in < out ? in : out;
    size_t start = (out + own) * EACH_SEED(k), iterated = out * EACH_ITERATED(k);

    return in * EACH_IN(own) + (start > iterated ? start : iterated) + threads * EACH_THREAD + ELSE;
}

/* The allocator as each record finds it. */
struct log {
    struct vor_memory memory;
    struct vor_watch watch;
    unsigned count;
    struct vor_record record[RECORDS];
    size_t calls[RECORDS], used[RECORDS];
};

static enum vor_answer note(void *ctx, const struct vor_record *record)
{
    struct log *log = ctx;

    ck_assert_uint_lt(log->count, RECORDS);
    log->record[log->count] = *record;
    log->calls[log->count] = atomic_load(&log->memory.calls);
    log->used[log->count++] = atomic_load(&log->memory.used);
    return VOR_CONTINUE;
}

struct request {
    size_t in, out;
    unsigned threads;
    const char *neighbors, *iterations, *anderson, *polish, *order; /* NULL: not given */
};

static void set(struct vt_engine *engine, const char *name, const char *text)
{
    if (text != NULL)
        vt_engine_set(engine, name, text);
}

/* One run on a box; the number of times that the lists were made. */
static uint64_t run(struct log *log, const struct request *request)
{
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;

    memset(log, 0, sizeof *log);
    vor_memory_init(&log->memory, SIZE_MAX);
    log->watch = (struct vor_watch){.ctx = log, .progress = note};
    vt_engine_open(&engine, request->threads);
    engine.run.memory = &log->memory;
    engine.run.watch = &log->watch;
    vt_cloud_box(&in, 1, request->in);
    vt_engine_count(&engine, "points", request->out);
    set(&engine, "neighbors", request->neighbors);
    set(&engine, "iterations", request->iterations);
    set(&engine, "anderson", request->anderson);
    set(&engine, "polish", request->polish);
    set(&engine, "order", request->order);
    vt_engine_resample(&engine, &out, &report, &in);
    vor_cloud_free(&out);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
    ck_assert_uint_eq(atomic_load(&log->memory.used), 0);
    return report.list_rebuilds;
}

/* The sentence of core/engine.h on memory. */
VT_TEST_LOOP(a_run_needs_so_many_bytes_a_point, VT_FEWER(VT_SOAK_LOOPS(9, 10)))
{
    static const size_t points[10][2] = {
        {20000, 100},  {300, 300},     {80000, 100},  {80000, 7000}, {20000, 2000},
        {20000, 5000}, {10000, 10000}, {5000, 15000}, {1000, 16000}, {200000, 18000}};
    static struct log log;

    for (int k = 0; k < 2; k++) {
        size_t neighbors = k ? 40 : 20;
        struct request request = {
            points[_i][0], points[_i][1], k ? 3 : 1, k ? "40" : "20",
            "3",           NULL,          "2",       k ? "progressive" : NULL};

        (void)run(&log, &request);
        ck_assert_uint_le(atomic_load(&log.memory.peak),
                          bound_of(request.in, request.out, neighbors, request.threads));
    }
}

/* From the first iteration on, and from the first record of the polish on, no more is in use at
 * any record, but for what nodes of the points' index differ by (a byte a point), and the allocator
 * is asked only when that is made anew or a candidate gets one: in the first few iterations. */
VT_TEST_LOOP(after_the_first_iteration_nothing_is_allocated_but_indices, VT_FEWER(3))
{
    static const char *const anderson[3] = {NULL, "4", "0"};
    const struct request request = {6000, 1500, 2, "20", "40", anderson[_i], "100", NULL};
    static struct log log;
    uint64_t lists = run(&log, &request);
    unsigned asked = 0, polished = 0;

    ck_assert_uint_ge(log.count, 41 + 10);
    ck_assert_uint_le(log.count, 41 + 11); /* points that move after that have a record */
    for (unsigned i = 2; i <= 40; i++) {
        ck_assert_uint_le(log.used[i], log.used[1] + request.out);
        ck_assert_uint_le(log.calls[i] - log.calls[i - 1], CALLS);
        asked += log.calls[i] != log.calls[i - 1];
    }
    ck_assert_uint_le(log.calls[40] - log.calls[1], CALLS * lists);
    ck_assert_uint_le(asked, 12);
    for (unsigned i = 42; i < 41 + 10; i++) {
        ck_assert_uint_le(log.used[i], log.used[41] + request.out);
        polished += log.calls[i] - log.calls[i - 1] > 0;
    }
    ck_assert_uint_le(log.calls[50] - log.calls[41], CALLS * lists);
    ck_assert_uint_le(polished, 5);
}

VT_TEST(a_job_beyond_its_cap_is_refused_and_within_its_peak_it_runs)
{
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;
    struct vor_memory memory;
    size_t peak;

    vt_engine_open(&engine, 2);
    engine.run.memory = &memory;
    vt_cloud_sphere(&in, 1, 2000);
    vt_ask_set(&engine, "points=500 iterations=3 polish=3");
    vor_memory_init(&memory, SIZE_MAX);
    vt_engine_resample(&engine, &out, &report, &in);
    vor_cloud_free(&out);
    peak = atomic_load(&memory.peak);
    ck_assert_uint_eq(report.memory_peak_bytes, peak);
    for (size_t share = 0; share <= 8; share++) {
        vor_memory_init(&memory, share < 8 ? peak * share / 8 : peak);
        vor_cloud_init(&out, &memory);
        if (share < 8)
            vt_assert_fails(VOR_E_NOMEM,
                            vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err));
        else
            vt_assert_ok(vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err));
        ck_assert_uint_le(atomic_load(&memory.peak), memory.cap);
        vor_cloud_free(&out);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}
