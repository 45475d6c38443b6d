#include "server/jobs/time_estimate.h"

#include "server/jobs/eta.h"

#include <math.h>
#include <stdio.h>

/* What eta.c does not reckon with, in seconds on one thread, measured on spheres. A fit to k
 * neighbours more than usual, for each point and step: k = 150 takes 15 us an iteration, 500 takes
 * 50. */
#define A_NEIGHBOR 1e-7
#define USUAL_NEIGHBORS 20.0

/* Where the neighbourhood is a large part of the input, the question whether a point lies in a hole
 * takes a time that grows with the cube of k, a point 0.9 ms at 500 of 1,000 points and less than
 * 0.1 ms of 20,000 after the iterations, and 0.4 of that at each step of the polish. */
#define A_HOLE 1e-3
#define HOLE_NEIGHBORS 500.0
#define HOLES_A_STEP 0.4

/* An iteration that minimises an energy, over a usual one: 25 us against 2.5. */
#define DESCENT 10.0

/* A metric makes every step so many times as long: 1.5 to 2. */
#define METRIC 2.0

/* Placing a point, and its figures in the report, the fastest way (core/base/budget.h): 1,600,000
 * on 100,000 took 11 s on one thread. */
#define A_POINT 7e-6

static double neighbors_of(const struct vor_spec *spec)
{
    return fmax(spec->value[VOR_PARAM_NEIGHBORS], USUAL_NEIGHBORS);
}

/* For each point of the result, what wide fits take besides. */
static double wide_fits(const struct vor_spec *spec, double in)
{
    double k = neighbors_of(spec), cube = pow(k / HOLE_NEIGHBORS, 3);
    double hole = A_HOLE * cube * fmin(2 * k / fmax(in, 1), 1);
    double steps = vor_spec_iterations(spec) + vor_spec_polish(spec);

    if (spec->value[VOR_PARAM_BOUNDARY] == VOR_BOUNDARY_FREE)
        hole = 0;
    return A_NEIGHBOR * (k - USUAL_NEIGHBORS) * steps +
           hole * (1 + HOLES_A_STEP * vor_spec_polish(spec));
}

double vor_time_estimate(const struct vor_spec *spec, uint64_t points, unsigned threads)
{
    struct vor_eta eta = {.work = vor_eta_work_of(spec, points, threads)};
    double usual = vor_eta_left(&eta, spec), seconds = usual;

    if (!(usual >= 0) || !(eta.work.points_out > 0))
        return 0;
    if (vor_spec_descends(spec))
        seconds *= DESCENT;
    if (spec->value[VOR_PARAM_METRIC] != VOR_METRIC_ISOTROPIC)
        seconds *= METRIC;
    seconds += wide_fits(spec, (double)points) * eta.work.points_out / fmax(threads, 1);
    if (vor_spec_given(spec, VOR_PARAM_SECONDS))
        seconds = fmin(seconds, spec->value[VOR_PARAM_SECONDS]);
    return seconds;
}

/* Refuses a request whose own time is far too short for its points. */
static vor_status check_own_time(const struct vor_spec *spec, double points, unsigned threads,
                                 struct vor_error *err)
{
    double least = A_POINT * points / fmax(threads, 1), own = spec->value[VOR_PARAM_SECONDS];

    if (!vor_spec_given(spec, VOR_PARAM_SECONDS) ||
        !(least > VOR_TIME_ESTIMATE_FAR * own + VOR_TIME_ESTIMATE_SPARE))
        return VOR_OK;
    (void)vor_fail(err, VOR_E_WORK,
                   "seconds is %g, but placing %.0f points takes about %.0f seconds: request "
                   "at least %.0f seconds, or fewer points",
                   own, points, least,
                   ceil((least - VOR_TIME_ESTIMATE_SPARE) / VOR_TIME_ESTIMATE_FAR));
    return vor_fail_over(err, VOR_E_WORK, (uint64_t)own, (uint64_t)least);
}

vor_status vor_time_estimate_check(const struct vor_spec *spec, uint64_t points, unsigned threads,
                                   double limit, struct vor_error *err)
{
    double seconds = vor_time_estimate(spec, points, threads);
    double method = spec->value[VOR_PARAM_METHOD];
    int projects = method == VOR_METHOD_WLOP || method == VOR_METHOD_EAR;
    char fits[64] = "";

    if (check_own_time(spec, vor_spec_target(spec, points), threads, err) != VOR_OK)
        return VOR_E_WORK;
    if (!(limit > 0) || seconds <= VOR_TIME_ESTIMATE_FAR * limit)
        return VOR_OK;
    if (neighbors_of(spec) > USUAL_NEIGHBORS)
        (void)snprintf(fits, sizeof fits, ", with local surfaces fitted to %.0f points each",
                       neighbors_of(spec));
    (void)vor_fail(
        err, VOR_E_WORK,
        "the job would take about %.0f seconds, %.0f times the limit of %.0f, because "
        "it has up to %u %ss and %u polish steps of %.0f points%s",
        seconds, seconds / limit, limit, vor_spec_iterations(spec),
        vor_run_stage_info(projects ? VOR_RUN_STAGE_PROJECT : VOR_RUN_STAGE_ITERATE)->step,
        vor_spec_polish(spec), vor_spec_target(spec, points), fits);
    return vor_fail_over(err, VOR_E_WORK, (uint64_t)limit, (uint64_t)seconds);
}
