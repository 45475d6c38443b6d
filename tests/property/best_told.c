/* best in the records of a run: what would be handed back now. The last record has what the report
 * says of the result, however the run ended. */
#include "tests/support/vt_engine.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

enum { RECORDS_MAX = 400, OUT = 150 };

/* A watch that notes the records, may stop the run, and has a clock that goes a second with every
 * reading by the thread of the run. */
struct spy {
    struct vor_record record[RECORDS_MAX];
    unsigned count, shown;
    unsigned at_record; /* answer at that record and after; 0: never */
    atomic_int asked;   /* questions so far */
    int at_question;    /* answer VOR_STOP from that question on; 0: never */
    enum vor_answer answer;
    pthread_t thread;       /* of the run */
    _Atomic double seconds; /* its readings of the clock; the pool's do not count */
};

static enum vor_answer progress(void *ctx, const struct vor_record *record)
{
    struct spy *spy = ctx;

    ck_assert_uint_lt(spy->count, RECORDS_MAX);
    spy->record[spy->count++] = *record;
    return spy->at_record > 0 && spy->count >= spy->at_record ? spy->answer : VOR_CONTINUE;
}

static void show(void *ctx, const struct vor_moving *points, const struct vor_record *record)
{
    struct spy *spy = ctx;

    (void)record;
    ck_assert_uint_gt(points->n, 0);
    spy->shown++;
}

static enum vor_answer poll(void *ctx)
{
    struct spy *spy = ctx;

    return atomic_fetch_add(&spy->asked, 1) + 1 >= spy->at_question && spy->at_question > 0
               ? VOR_STOP
               : VOR_CONTINUE;
}

static double tick(void *ctx)
{
    struct spy *spy = ctx;
    double now = atomic_load(&spy->seconds);

    if (pthread_equal(pthread_self(), spy->thread))
        atomic_store(&spy->seconds, now + 1);
    return now;
}

/* Inputs: a sphere, whose result has no point outside; a dome, where points are moved onto the
 * input at the end; a dense dome, iterated on a thinned copy; a dome with an island. */
enum { SPHERE, DOME, DENSE, ISLAND, INPUTS };

static void make(struct vor_cloud *cloud, int input, uint64_t seed)
{
    static const size_t sizes[INPUTS] = {600, 700, 3000, 700};

    if (input == SPHERE)
        vt_cloud_sphere(cloud, seed, sizes[input]);
    else
        vt_cloud_dome(cloud, seed, sizes[input]);
    for (size_t i = 0; input == ISLAND && i < 9; i++) {
        cloud->xyz[3 * i] = 5 + 0.05F * (float)(i % 3);
        cloud->xyz[3 * i + 1] = 0.05F * (float)(i / 3);
        cloud->xyz[3 * i + 2] = 0;
    }
}

/* One wish of a request, and how the run ends by it. */
struct ending {
    const char *name, *value;
    unsigned at_record;
    int at_question;
    enum vor_stopped stopped;
};

static const struct ending endings[] = {{"iterations", "9", 0, 0, VOR_STOPPED_ITERATIONS},
                                        {"delta", "0.2", 0, 0, VOR_STOPPED_DELTA},
                                        {"seconds", "30", 0, 0, VOR_STOPPED_SECONDS},
                                        {NULL, NULL, 1, 0, VOR_STOPPED_CALLER},
                                        {NULL, NULL, 5, 0, VOR_STOPPED_CALLER},
                                        {NULL, NULL, 15, 0, VOR_STOPPED_CALLER},
                                        {NULL, NULL, 0, 150, VOR_STOPPED_CALLER},
                                        {NULL, NULL, 0, 400, VOR_STOPPED_CALLER}};
enum { ENDINGS = sizeof endings / sizeof endings[0] };

static vor_status run(struct spy *spy, struct vor_report *report, const struct vor_cloud *in,
                      const struct ending *ending, const char *polish)
{
    struct vor_watch watch = {
        .ctx = spy, .progress = progress, .poll = poll, .clock = tick, .points = show};
    struct vt_engine engine;
    struct vor_cloud out;
    vor_status status;

    spy->thread = pthread_self();
    spy->at_record = spy->at_record > 0 ? spy->at_record : ending->at_record;
    spy->at_question = ending->at_question;
    vt_engine_open(&engine, 2);
    engine.run.watch = &watch;
    vt_engine_count(&engine, "points", OUT);
    vt_engine_set(&engine, "polish", polish);
    if (ending->name != NULL)
        vt_engine_set(&engine, ending->name, ending->value);
    status = vt_engine_try(&engine, &out, report, in);
    ck_assert_uint_eq(out.n, status == VOR_OK ? OUT : 0);
    vor_cloud_free(&out);
    vt_engine_close(&engine);
    return status;
}

/* What every record holds to: each but that of the result was shown, too; whether the last one was
 * told for the sake of the result. */
static int assert_best(const struct spy *spy, const struct vor_report *report)
{
    const struct vor_record *last = &spy->record[spy->count - 1];

    for (unsigned i = 0; i < spy->count; i++) {
        const struct vor_record *record = &spy->record[i];

        ck_assert_double_le(record->best_delta, record->delta);
        ck_assert_double_eq_tol(record->best_epsilon,
                                1 / sqrt(1 + record->best_delta * record->best_delta), 1e-12);
        ck_assert_uint_le(record->best_iteration, record->iteration);
        ck_assert_uint_le(record->best_polish, record->polish);
    }
    ck_assert_double_eq(last->best_delta, report->delta);
    ck_assert_double_eq(last->best_sigma, report->sigma);
    ck_assert_double_eq(last->best_epsilon, report->epsilon);
    ck_assert_uint_eq(last->iteration, report->iterations);
    ck_assert_uint_eq(last->polish, report->polish_steps);
    ck_assert_uint_eq(last->step, report->stages[report->stages_count - 1].steps);
    ck_assert_int_eq(last->stage, report->stages[report->stages_count - 1].stage);
    ck_assert_uint_ge(spy->shown + 1, spy->count);
    return spy->count > 1 && last[-1].iteration == last->iteration &&
           last[-1].polish == last->polish;
}

/* Input _i, with the polish and without. */
VT_TEST_LOOP(the_last_best_is_the_report_s, VT_ONCE(INPUTS))
{
    static const char *const polishes[] = {"0", "30"};
    unsigned of_result = 0, stopped[VOR_STOPPED_COUNT] = {0};
    struct vor_cloud in;

    make(&in, _i, (uint64_t)_i + 1);
    for (int e = 0; e < ENDINGS; e++)
        for (int p = 0; p < 2; p++) {
            static struct spy spy;
            struct vor_report report;

            memset(&spy, 0, sizeof spy);
            spy.answer = VOR_STOP;
            vt_assert_ok(run(&spy, &report, &in, &endings[e], polishes[p]));
            of_result += (unsigned)assert_best(&spy, &report);
            stopped[report.stopped] += report.stopped == endings[e].stopped;
        }
    ck_assert_uint_ge(stopped[VOR_STOPPED_ITERATIONS], 2);
    ck_assert_uint_ge(stopped[VOR_STOPPED_DELTA], 1);
    ck_assert_uint_ge(stopped[VOR_STOPPED_SECONDS], 1);
    ck_assert_uint_ge(stopped[VOR_STOPPED_CALLER], 8);
    if (_i == ISLAND)
        ck_assert_uint_eq(of_result, 2 * ENDINGS);
    vor_cloud_free(&in);
}
