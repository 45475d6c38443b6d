#include "core/input/holes.h"

#include "core/base/bounds.h"
#include "core/base/linalg.h"
#include "core/input/fill.h"
#include "core/input/loops.h"

#include <math.h>
#include <string.h>

static vor_status mark_named(unsigned char *chosen, const struct vor_loops *loops,
                             const struct vor_spec *spec, struct vor_error *err)
{
    double id;

    for (unsigned i = 0; vor_spec_count_at(spec, VOR_PARAM_HOLES, i, &id); i++) {
        if (loops->count == 0)
            return vor_fail_param(
                err, VOR_E_HOLES, "holes",
                "the parameter holes contains %.0f, but the input has no border loops", id);
        if (id > (double)loops->count)
            return vor_fail_param(
                err, VOR_E_HOLES, "holes",
                "the parameter holes contains %.0f, but the border loops are numbered from 1 to "
                "%zu; run inspect to list them",
                id, loops->count);
        chosen[(size_t)id - 1] = 1;
    }
    return VOR_OK;
}

/* Length below which holes are filled, in normalised units. By itself the diagonal of the box
 * around the input: a hole as long is a third of it across, and rather part of the shape than one
 * of the sampling. Bunny's have 0.06 to 0.37 of it; ends of tubes and bowls are no holes, whatever
 * their length. */
static vor_status longest_hole(double *out, const struct vor_domain *seen,
                               const struct vor_spec *spec, const struct vor_run *run,
                               struct vor_error *err)
{
    double given = spec->value[VOR_PARAM_HOLE_MAX];
    struct vor_box box;
    vor_status status = vor_bounds(&box, seen->xyz, seen->n, run, err);

    if (status == VOR_OK)
        *out = given != VOR_UNSET ? given / seen->unit : sqrt(vor_distance2f(box.low, box.high));
    return status;
}

static enum vor_hole_outcome outcome_of(const struct vor_loop *loop, double longest)
{
    if (!(loop->turns >= VOR_LOOPS_HOLE_TURNS))
        return VOR_HOLE_RIM;
    return loop->length < longest ? VOR_HOLE_FILLED : VOR_HOLE_TOO_LONG;
}

/* Decides what is to become of each loop: outcome is as long as there are loops, and all zero. */
static vor_status decide(unsigned char *outcome, const struct vor_loops *loops,
                         const struct vor_domain *seen, const struct vor_spec *spec,
                         const struct vor_run *run, struct vor_error *err)
{
    double longest = 0;
    int named = spec->value[VOR_PARAM_HOLES] != VOR_UNSET;
    vor_status status = named ? mark_named(outcome, loops, spec, err)
                              : longest_hole(&longest, seen, spec, run, err);

    for (size_t i = 0; status == VOR_OK && i < loops->count; i++)
        if (named)
            outcome[i] = outcome[i] ? VOR_HOLE_FILLED : VOR_HOLE_NOT_CHOSEN;
        else
            outcome[i] = (unsigned char)outcome_of(&loops->loop[i], longest);
    return status;
}

/* What is told of a loop. */

/* Adds a loop to those that are told; of very many, those that were not closed, and the first. */
static void tell(struct vor_holes *holes, const struct vor_hole_told *told)
{
    unsigned at = holes->told_count;

    if (at == VOR_HOLES_TOLD) {
        if (told->outcome != VOR_HOLE_NOT_CLOSED)
            return;
        do
            at--;
        while (at > 0 && holes->told[at].outcome == VOR_HOLE_NOT_CLOSED);
        if (holes->told[at].outcome == VOR_HOLE_NOT_CLOSED)
            return; /* as all are: the longest come first */
        memmove(&holes->told[at], &holes->told[at + 1],
                (VOR_HOLES_TOLD - 1 - at) * sizeof *holes->told);
        at = VOR_HOLES_TOLD - 1;
    }
    holes->told[at] = *told;
    holes->told_count = at + 1;
}

/* Fills the holes that are to be, and notes what became of every one. */
static vor_status fill_all(struct vor_holes *holes, struct vor_filling *filling,
                           const unsigned char *outcome, const double origin[3],
                           const struct vor_run *run, struct vor_error *err)
{
    for (size_t i = 0; i < filling->loops->count; i++) {
        const struct vor_loop *loop = &filling->loops->loop[i];
        const struct vor_domain *seen = filling->domain;
        struct vor_hole_told told = {.length = loop->length * seen->unit};
        size_t before = filling->n;

        told.kind = loop->turns >= VOR_LOOPS_HOLE_TURNS ? VOR_LOOP_HOLE : VOR_LOOP_RIM;
        for (int c = 0; c < 3; c++)
            told.centre[c] = origin[c] + (loop->centre[c] * seen->unit + seen->shift[c]);

        told.id = (uint32_t)i + 1;
        told.outcome = (enum vor_hole_outcome)outcome[i];
        if (told.outcome == VOR_HOLE_FILLED) {
            int closed = 0;
            vor_status status = vor_fill_hole(filling, &closed, i, run, err);

            if (status != VOR_OK)
                return status;
            told.outcome = closed ? VOR_HOLE_FILLED : VOR_HOLE_NOT_CLOSED;
            told.points = filling->n - before;
            holes->filled += (size_t)closed;
            holes->not_closed += (size_t)!closed;
        }
        tell(holes, &told);
    }
    holes->loops = filling->loops->count;
    holes->points = filling->n;
    holes->asked = 1;
    return VOR_OK;
}

/* Fills the holes of the loops that were found, and puts the points into the domain. */
static vor_status fill_loops(struct vor_domain *domain, struct vor_filling *filling,
                             const double origin[3], const struct vor_spec *spec,
                             const struct vor_run *run, struct vor_error *err)
{
    size_t count = filling->loops->count;
    unsigned char *outcome = vor_calloc(run->memory, count, sizeof *outcome);
    vor_status status;

    if (outcome == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu holes", count);
    status = decide(outcome, filling->loops, filling->domain, spec, run, err);
    VOR_THEN(status, fill_all(&domain->known.holes, filling, outcome, origin, run, err));
    if (status == VOR_OK && filling->n > 0)
        status = vor_domain_add(domain, filling->xyz, filling->source, filling->n, run, err);
    vor_free(run->memory, outcome);
    return status;
}

vor_status vor_holes_fill(struct vor_domain *domain, const struct vor_domain *seen,
                          const double origin[3], const struct vor_spec *spec,
                          const struct vor_run *run, struct vor_error *err)
{
    struct vor_filling filling = {.n = 0};
    struct vor_loops loops;
    vor_status status = vor_loops_find(&loops, seen, run, err);

    if (status != VOR_OK)
        return status;
    status = vor_filling_init(&filling, seen, &loops, err);
    VOR_THEN(status, fill_loops(domain, &filling, origin, spec, run, err));
    vor_filling_free(&filling);
    vor_loops_free(&loops);
    return status;
}
