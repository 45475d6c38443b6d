/* The loop of a stage, driven by a toy: points that halve their way to the origin in each step. */
#include "core/seeds/stage.h"
#include "tests/support/vt_engine.h"

enum { N = 4, STEPS = 12, RECORDS_MAX = 40 };

struct toy {
    float xyz[3 * N];
    unsigned measured, records, stop, end, fail;
    struct vor_record last;
    double seconds;
};

static vor_status halve(struct vor_stage *stage, struct vor_error *err)
{
    struct toy *toy = stage->of;

    if (toy->fail > 0 && stage->record.step + 1 == toy->fail)
        return vor_fail(err, VOR_E_STOPPED, "stopped");
    stage->moved = (double)toy->xyz[0] / 2;
    for (int c = 0; c < 3 * N; c++)
        toy->xyz[c] /= 2;
    return VOR_OK;
}

static vor_status measure(struct vor_stage *stage, struct vor_error *err)
{
    struct toy *toy = stage->of;

    (void)err;
    toy->measured++;
    stage->record.delta = (double)toy->xyz[0];
    return VOR_OK;
}

static int ends(struct vor_stage *stage)
{
    return stage->record.step == ((struct toy *)stage->of)->end;
}

static enum vor_answer progress(void *ctx, const struct vor_record *record)
{
    struct toy *toy = ctx;

    toy->last = *record;
    return ++toy->records == toy->stop ? VOR_STOP : VOR_CONTINUE;
}

static double tick(void *ctx)
{
    return ((struct toy *)ctx)->seconds++;
}

/* How a stage ends: after how many steps, of which so many were measured, and by what. A stage that
 * follows another tells no record of 0 steps, and leaves its word where all its steps are made. */
static const struct {
    const char *name, *value;
    struct vor_stage how;
    struct toy toy;
    unsigned steps, measured, records;
    enum vor_stopped stopped;
} rows[] = {
    {"iterations", "9", {.measure_every = 1}, {.end = 0}, 12, 12, 13, VOR_STOPPED_ITERATIONS},
    {"delta", "0.3", {.measure_every = 1}, {.end = 0}, 2, 2, 3, VOR_STOPPED_DELTA},
    {"delta", "0.3", {.measure_every = 5}, {.end = 0}, 5, 1, 6, VOR_STOPPED_DELTA},
    {"delta",
     "0.3",
     {.measure_every = 1, .unfinished = 1},
     {.end = 0},
     12,
     12,
     13,
     VOR_STOPPED_ITERATIONS},
    {"moveStop", "0.1", {.measure_every = 1}, {.end = 0}, 4, 4, 5, VOR_STOPPED_MOVE},
    {"seconds", "8", {.measure_every = 5, .share = 0.5}, {.end = 0}, 3, 1, 4, VOR_STOPPED_SECONDS},
    {"iterations", "9", {.measure_every = 1}, {.end = 3}, 3, 3, 4, VOR_STOPPED_PLATEAU},
    {"iterations", "9", {.measure_every = 1}, {.stop = 4}, 3, 3, 4, VOR_STOPPED_CALLER},
    {"iterations", "9", {.measure_every = 1}, {.fail = 4}, 3, 3, 4, VOR_STOPPED_CALLER},
    {"iterations",
     "9",
     {.measure_every = 4, .measure_last = 3, .tell_every = 5, .follows = 1},
     {.end = 0},
     12,
     6,
     3,
     VOR_STOPPED_PLATEAU},
};

VT_TEST_LOOP(a_stage_ends_by_the_first_stop_and_tells_what_it_did,
             (int)(sizeof rows / sizeof rows[0]))
{
    struct toy toy = rows[_i].toy;
    struct vor_watch watch = {.ctx = &toy, .progress = progress, .clock = tick};
    struct vor_domain domain = {.unit = 2};
    struct vor_outcome told = {.stopped = VOR_STOPPED_PLATEAU};
    struct vor_stage stage = rows[_i].how;
    struct vt_engine engine;

    vt_engine_open(&engine, 1);
    vt_engine_set(&engine, rows[_i].name, rows[_i].value);
    engine.run.watch = &watch;
    stage.spec = &engine.spec;
    stage.run = &engine.run;
    stage.told = &told;
    stage.domain = &domain;
    stage.xyz = toy.xyz;
    stage.n = N;
    stage.of = &toy;
    stage.step = halve;
    stage.measure = measure;
    stage.ends = ends;
    stage.record.of = STEPS;
    stage.record.delta = toy.xyz[0] = 1;
    toy.end = toy.end > 0 ? toy.end : 2 * STEPS;
    vt_assert_ok(vor_stage_run(&stage, &vt_err));
    ck_assert_uint_eq(told.steps[VOR_RUN_STAGE_ITERATE], rows[_i].steps);
    ck_assert_uint_eq(toy.measured, rows[_i].measured);
    ck_assert_uint_eq(toy.records, rows[_i].records);
    ck_assert_int_eq(told.stopped, rows[_i].stopped);
    ck_assert_uint_eq(toy.last.step, rows[_i].steps);
    ck_assert_uint_eq(told.kept.iteration, rows[_i].steps);
    ck_assert_double_eq(toy.last.best_delta, told.kept.delta);
    vt_engine_close(&engine);
}
