#include "server/jobs/eta.h"

#include "core/cloud/faces.h"

#include <math.h>

/* What the parts of a run cost: microseconds a point on one thread of an AMD EPYC. Measured on 14
 * runs, one thread, by CPU: bunny 36,000 to 10,000, 40,000 and 144,000; igea 30,000 to 60,000 and
 * 120,000, 134,000 to 30,000 and 60,000, 655,000 to 100,000 and with noise to 50,000; cow 110,000
 * to 30,000, 80,000 and 110,000, 20,000 to 80,000; armadillo 43,000 to 130,000. Of the input
 * ("in"): a point of it, else of the result. Each is beside its range, without the noisy one. */
#define INDEX_IN                                                                                   \
    2.0            /* until the first points are placed; in: 0.3 to 4, 31 where sheets lie close */
#define START 10.0 /* placing them: 6.9 to 12.7 */
#define FIRST 5.0  /* the first iteration, which makes the lists: 4.6 to 5.5 */
#define ITERATION 2.5   /* the others: 1.9 to 4.4 with the first */
#define JOIN 45.0       /* of isotropic, before its first iteration: 41 to 50 */
#define REMESH 9.0      /* an iteration of it: 8 to 11 */
#define POLISH_STEP 1.2 /* 0.6 to 2.0 */
#define END 5.5         /* comparing, attributes, normals: 4.2 to 7.2 */

/* Input points for each of the result from which on the last steps of the polish, on the whole of
 * an input that was thinned (seeds/repel.c), cost more than the others: 2.3 to 3.4 times as much in
 * five runs at 22 to 100, not at 13. */
#define DENSE 20.0
#define WHOLE_STEP (2.8 * POLISH_STEP)
enum { WHOLE_STEPS = 40 };

/* Iterations after which delta usually reaches its plateau, where the request gives no number and
 * no polish follows: 38, 41 and 43 in these runs. */
enum { USUAL_ITERATIONS = 41, MORE_ITERATIONS = 3 };

/* Of wlop and ear, likewise: fandisk with noise and igea, 30,000 points to 15,000, 30,000 and
 * 60,000, 3 and 39 steps, polish 0 and 20, by differences. INSERT_POINT is for each point inserted,
 * one after the other whatever the threads. */
#define WLOP_IN 15.0        /* of the input, until points are projected */
#define EAR_IN 80.0         /* likewise: 55 to 125 */
#define PROJECT_STEP 2.5    /* a step of a sample: 2.1 to 3.1 */
#define INSERT_POINT 15.0   /* 10 to 20 */
#define EAR_POLISH_STEP 3.3 /* with edges 2.8, without 4 */

/* Share of the input's points that ear projects where the request does not say how many, as
 * core/lop/lop.c has it. */
#define SAMPLES_SHARE 0.5

/* Share of a second thread and each after it that a run gains: 0.8 to 0.95 with two. */
#define THREAD_GAIN 0.9

/* Whether a record says how many steps its stage takes. One that did not begin needs none. */
static int is_known(const struct vor_record *record)
{
    return record->of > 0 || record->step == 0;
}

static int work_is_known(const struct vor_eta_work *work)
{
    return work->points_out > 0;
}

static int projects(const struct vor_eta_work *work)
{
    return work->method == VOR_METHOD_WLOP || work->method == VOR_METHOD_EAR;
}

/* Threads, by what they gain. */
static double threads_of(const struct vor_eta_work *work)
{
    return work->threads > 1 ? 1 + THREAD_GAIN * (work->threads - 1) : 1;
}

/* Seconds of a cost for each point of the result; without their number, of one point. */
static double seconds_of(const struct vor_eta_work *work, double cost)
{
    return 1e-6 * cost * fmax(work->points_out, 1) / threads_of(work);
}

/* What comes before the first iteration, for each point of the result. */
static double cost_before(const struct vor_eta_work *work)
{
    double each = INDEX_IN;

    if (projects(work))
        each = work->method == VOR_METHOD_EAR ? EAR_IN : WLOP_IN;
    return (projects(work) ? 0 : START) + (work->method == VOR_METHOD_ISOTROPIC ? JOIN : 0) +
           each * work->points_in / work->points_out;
}

/* What steps of a polish of `of` steps cost, after `from` up to `to`. */
static double cost_of_polish(const struct vor_eta_work *work, double from, double to, double of)
{
    double whole = fmax(fmin(to, of) - fmax(from, of - WHOLE_STEPS), 0);

    if (work->method == VOR_METHOD_EAR)
        return EAR_POLISH_STEP * (to - from);
    if (work->points_in < DENSE * work->points_out || !work_is_known(work))
        whole = 0;
    return POLISH_STEP * (to - from - whole) + WHOLE_STEP * whole;
}

/* What it costs to insert so many points. */
static double cost_of_insertions(const struct vor_eta_work *work, double points)
{
    return INSERT_POINT * points / work->points_out * threads_of(work);
}

/* What the steps of the stage of a record cost after `from` up to `to`; those of a stage that is
 * not listed above as much as iterations. */
static double cost_of_steps(const struct vor_eta_work *work, const struct vor_record *record,
                            double from, double to)
{
    if (!(to > from))
        return 0;
    if (record->stage == VOR_RUN_STAGE_POLISH)
        return cost_of_polish(work, from, to, record->of);
    if (record->stage == VOR_RUN_STAGE_ITERATE && work->method == VOR_METHOD_ISOTROPIC)
        return REMESH * (to - from);
    if (record->stage == VOR_RUN_STAGE_ITERATE && from < 1)
        return FIRST + ITERATION * (to - 1);
    if (projects(work) && record->stage == VOR_RUN_STAGE_PROJECT)
        return PROJECT_STEP * (to - from) * work->samples / work->points_out;
    if (projects(work) && record->stage == VOR_RUN_STAGE_INSERT)
        return cost_of_insertions(work, to - from);
    return ITERATION * (to - from);
}

static int is_listed(const struct vor_eta_work *work, enum vor_run_stage stage)
{
    return stage == VOR_RUN_STAGE_ITERATE || stage == VOR_RUN_STAGE_POLISH ||
           (projects(work) && (stage == VOR_RUN_STAGE_PROJECT || stage == VOR_RUN_STAGE_INSERT));
}

/* What the steps of the stages ahead cost. */
static double cost_ahead(const struct vor_eta_work *work, const struct vor_record *record)
{
    double ahead = record->ahead, inserted = 0;

    if (!is_listed(work, record->stage))
        return ITERATION * ahead;
    if (record->stage == VOR_RUN_STAGE_POLISH)
        return POLISH_STEP * ahead;
    if (record->stage == VOR_RUN_STAGE_PROJECT)
        inserted = fmin(fmax(work->points_out - work->samples, 0), ahead);
    return (inserted > 0 ? cost_of_insertions(work, inserted) : 0) +
           cost_of_polish(work, 0, ahead - inserted, ahead - inserted);
}

/* What follows the steps of the stage of a record: those of the stages ahead, and the end of the
 * run. Of stages that are not listed above no end is known. */
static double cost_after(const struct vor_eta_work *work, const struct vor_record *record)
{
    return cost_ahead(work, record) + (is_listed(work, record->stage) ? END : 0);
}

/* Steps from one of the stage of a record on, and those of the stages ahead, as vor_eta_done
 * counts them. */
static double steps_from(const struct vor_eta_work *work, const struct vor_record *record,
                         uint32_t from)
{
    if (projects(work))
        return cost_of_steps(work, record, from, record->of) + cost_ahead(work, record);
    return fmax((double)record->of - from, 0) + record->ahead;
}

/* Steps that the stage of a record takes, as far as one can say. */
static double usual_steps(const struct vor_record *record, const struct vor_spec *spec)
{
    double usual = fmax(USUAL_ITERATIONS, (double)record->step + MORE_ITERATIONS);

    if (record->stage != VOR_RUN_STAGE_ITERATE || vor_spec_given(spec, VOR_PARAM_ITERATIONS))
        return record->of;
    return fmin(usual, record->of);
}

/* How slow other parts of a run are, by how slow one is. That is half the machine and half the
 * input: noise makes iterations ten times as slow, steps of the polish twice. With a power of 0.5 /
 * 0.6 / 0.7, 51 / 49 / 49 of 56 estimates in runs of 5 s and more are right within a factor 2; if
 * the machine were four times slower, 59 / 63 / 67 of 96 in runs of any length. */
static double slowness_of_others(const struct vor_eta *eta, double slowness)
{
    return work_is_known(&eta->work) ? sqrt(slowness) : slowness;
}

/* How many times longer than usual the stage at hand takes; 0 where it has done no step. */
static double slowness(const struct vor_eta *eta)
{
    const struct vor_record *from = &eta->origin, *to = &eta->last;
    double first = from->stage == to->stage ? from->step : 0;
    double cost = cost_of_steps(&eta->work, to, first, to->step);

    return cost > 0 ? (to->seconds - from->seconds) / seconds_of(&eta->work, cost) : 0;
}

struct vor_eta_work vor_eta_work_of(const struct vor_spec *spec, uint64_t points, unsigned threads)
{
    double target = vor_spec_target(spec, points);
    struct vor_eta_work work = {.threads = threads, .points_out = target, .samples = target};
    double share = SAMPLES_SHARE;

    work.method = (enum vor_method_choice)spec->value[VOR_PARAM_METHOD];
    if (spec->process->methods == 0 || !(target >= 1) || work.method == VOR_METHOD_KMEANS ||
        work.method >= VOR_METHODS)
        return (struct vor_eta_work){0};
    if (spec->value[VOR_PARAM_SAMPLE] == VOR_SAMPLE_FACES)
        points = vor_faces_samples(target, (size_t)points);
    work.points_in = (double)points;
    if (spec->value[VOR_PARAM_PHASES] == VOR_PHASES_INSERT)
        share = 1;
    if (work.method == VOR_METHOD_EAR && spec->value[VOR_PARAM_PHASES] != VOR_PHASES_RESAMPLE)
        work.samples =
            fmin(target, spec->value[VOR_PARAM_SAMPLES] > 0 ? spec->value[VOR_PARAM_SAMPLES]
                                                            : share * work.points_in);
    return work;
}

void vor_eta_add(struct vor_eta *eta, const struct vor_record *record)
{
    if (!eta->began) {
        eta->origin = *record;
    } else if (record->stage != eta->last.stage) {
        double now = slowness(eta);

        eta->before = now > 0 ? slowness_of_others(eta, now) : eta->before;
        eta->origin = record->step > 0 ? eta->last : *record;
    }
    eta->began = 1;
    eta->all = fmax(eta->all, steps_from(&eta->work, record, 0));
    eta->last = *record;
}

double vor_eta_done(const struct vor_eta *eta, const struct vor_spec *spec)
{
    double budget = spec->value[VOR_PARAM_SECONDS], done = 0;

    if (eta->began && is_known(&eta->last))
        done = eta->all > 0
                   ? (eta->all - steps_from(&eta->work, &eta->last, eta->last.step)) / eta->all
                   : 1;
    if (vor_spec_given(spec, VOR_PARAM_SECONDS) && budget > 0)
        done = fmax(done, eta->last.seconds / budget);
    return fmax(fmin(done, 1), 0);
}

/* What a run of the request is before its first record. */
static struct vor_record unbegun(const struct vor_eta_work *work, const struct vor_spec *spec)
{
    double inserted = fmin(fmax(work->points_out - work->samples, 0), INT32_MAX);

    if (projects(work))
        return (struct vor_record){.stage = VOR_RUN_STAGE_PROJECT,
                                   .of = vor_spec_iterations(spec),
                                   .ahead = (uint32_t)inserted + vor_spec_polish(spec)};
    return (struct vor_record){.stage = VOR_RUN_STAGE_ITERATE,
                               .of = vor_spec_iterations(spec),
                               .ahead = vor_spec_polish(spec)};
}

/* Seconds left where no step was done: by what came before the first, if that is over. */
static double left_of_all(const struct vor_eta *eta, const struct vor_spec *spec)
{
    struct vor_record record = eta->began ? eta->last : unbegun(&eta->work, spec);
    double before = cost_before(&eta->work), usual = seconds_of(&eta->work, before);
    double cost = cost_of_steps(&eta->work, &record, 0, usual_steps(&record, spec)) +
                  cost_after(&eta->work, &record);

    if (!eta->began)
        return usual + seconds_of(&eta->work, cost);
    return slowness_of_others(eta, record.seconds / usual) * seconds_of(&eta->work, cost);
}

/* Seconds left by the steps of the stage at hand, or before its first one by the stage before. */
static double left_by_steps(const struct vor_eta *eta, const struct vor_spec *spec)
{
    const struct vor_record *last = &eta->last;
    double now = slowness(eta), others = now > 0 ? slowness_of_others(eta, now) : eta->before;
    double own = cost_of_steps(&eta->work, last, last->step, usual_steps(last, spec));
    double after = cost_after(&eta->work, last);

    if (last->stage != VOR_RUN_STAGE_ITERATE && now > 0)
        others = now;
    return seconds_of(&eta->work, (now > 0 ? now : others) * own + others * after);
}

double vor_eta_left(const struct vor_eta *eta, const struct vor_spec *spec)
{
    int has_steps = slowness(eta) > 0 || eta->before > 0;
    double left;

    if (!is_known(&eta->last) || (!has_steps && !work_is_known(&eta->work)))
        return -1;
    left = has_steps ? left_by_steps(eta, spec) : left_of_all(eta, spec);
    if (vor_spec_given(spec, VOR_PARAM_SECONDS))
        left = fmin(left, fmax(spec->value[VOR_PARAM_SECONDS] - eta->last.seconds, 0));
    return left;
}
