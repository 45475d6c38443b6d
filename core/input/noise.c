#include "core/input/noise.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/geom/surface.h"
#include "core/input/neighbors.h"

#include <math.h>
#include <string.h>

enum {
    PLACES = VOR_NOISE_PLACES,
    BLOCK = 16, /* places of one task */
    STEPS = VOR_LADDER_STEPS,
    FEW = VOR_NEIGHBORS_FEWEST, /* that are to show a surface, the first of the ladder */
    MOST = VOR_LADDER_LAST,
    POOL = VOR_NEIGHBORS_POOL,
    THIRD = POOL / 3, /* of a pool: the place, by deviation, that speaks for it */
};

/* Where t would be if deviations were infinite, and above which t says nothing. */
#define BALL 0.38
#define THICK 0.28
/* Factor between a region and the median, below which they are taken for the same. With / without,
 * rms off the surface in spacings: a gear and a wedge with noise of three spacings 0.199, 0.804 /
 * 0.222, 0.864; thin parts, a screw and a turned piece within 2 %. */
#define ALIKE 1.5
/* Deviation over the reach of FEW neighbours from which noise is wide whatever the number that fits
 * take. On a plane 0.36 is a noise of one spacing, 0.55 of 1.6. At 0.24 / 0.45, rms off the surface
 * over that of the input, of a torus with noise of 0.9 spacings: 0.19 / 0.15. */
#define WIDE 0.45

static const unsigned ladder[STEPS] = VOR_LADDER;

/* What is found at the places. */
struct survey {
    const struct vor_halves *halves;
    const struct vor_neighbors *neighbors;
    struct vor_noise *out;
    unsigned level, from, to;        /* of the halves; the steps that are fitted there now */
    double deviation[STEPS][PLACES]; /* the least of any level */
    double few[PLACES];              /* reach of FEW neighbours */
};

/* The deviation of noise about a quadric through k points. */
static double deviation_of(const struct vor_surface *surface, unsigned k)
{
    double t = sqrt(surface->off2 * k / (k - VOR_QUADRIC_TERMS)) / surface->reach;

    if (surface->kind == VOR_SURFACE_NONE || !(t < THICK))
        return INFINITY;
    return surface->reach * t / (1 - vor_power(t / BALL, 5));
}

static void fit_place(void *ctx, size_t place, VOR_UNUSED unsigned worker)
{
    struct survey *survey = ctx;
    const float *x = &survey->out->xyz[3 * place], *xyz = survey->halves->level[survey->level].xyz;
    float near[3 * MOST] = {0}, distance2[MOST];
    uint32_t index[MOST];

    vor_knn_search(survey->halves->level[survey->level].knn, x, 1, ladder[survey->to - 1], index,
                   distance2);
    vor_gather(near, xyz, index, ladder[survey->to - 1]);
    if (survey->level == 0) {
        survey->out->reach[place] = sqrt((double)distance2[ladder[survey->to - 1] - 1]);
        survey->few[place] = sqrt((double)distance2[FEW - 1]);
    }
    for (unsigned step = survey->from; step < survey->to; step++) {
        struct vor_surface surface;

        vor_surface_fit(&surface, near, ladder[step]);
        survey->deviation[step][place] =
            fmin(survey->deviation[step][place], deviation_of(&surface, ladder[step]));
    }
}

/* The value of the pool's place number `rank` by size. */
static double ranked(const double values[PLACES], const uint16_t pool[POOL], size_t rank)
{
    double sorted[POOL];

    for (size_t i = 0; i < POOL; i++)
        sorted[i] = values[pool[i]];
    vor_sort_doubles(sorted, POOL);
    return sorted[rank];
}

/* Sets the deviations from what the places say; *few is the usual reach of FEW around each. */
static void ask(struct survey *survey, double few[PLACES])
{
    struct vor_noise *out = survey->out;

    for (size_t place = 0; place < PLACES; place++) {
        uint16_t pool[POOL] = {0};

        vor_neighbors_pool(pool, out->xyz, place);
        out->deviation[place] = INFINITY;
        for (unsigned step = 0; step < survey->to; step++)
            out->deviation[place] =
                fmin(out->deviation[place], ranked(survey->deviation[step], pool, THIRD));
        few[place] = ranked(survey->few, pool, POOL / 2);
    }
}

/* Puts deviations that are like the median to it. */
static void agree(struct vor_noise *out)
{
    double sorted[PLACES], usual;

    memcpy(sorted, out->deviation, sizeof sorted);
    vor_sort_doubles(sorted, PLACES);
    usual = sorted[PLACES / 2];
    for (size_t place = 0; place < PLACES; place++)
        if (out->deviation[place] > usual / ALIKE && out->deviation[place] < usual * ALIKE)
            out->deviation[place] = usual;
}

/* Whether fits at a place do not reach VOR_NOISE_REACH deviations. */
static int is_short(const struct survey *survey, const double few[PLACES], size_t place)
{
    double reach = VOR_NOISE_REACH * survey->out->deviation[place] / few[place];

    return !isinf(survey->out->deviation[place]) &&
           FEW * reach * reach > vor_neighbors_at(survey->neighbors, &survey->out->xyz[3 * place]);
}

/* Leaves only the deviations of wide noise; where no number of neighbours shows a surface there is
 * none to move points to. Without noise fits are short at a few places, between parts. */
static void keep_wide(struct survey *survey, const double few[PLACES])
{
    struct vor_noise *out = survey->out;
    unsigned count = 0;

    for (size_t place = 0; place < PLACES; place++)
        count += is_short(survey, few, place) != 0;
    for (size_t place = 0; place < PLACES; place++) {
        double deviation = out->deviation[place];

        if (!(deviation > WIDE * few[place] ||
              (count > VOR_NOISE_HIDDEN && is_short(survey, few, place))) ||
            isinf(deviation))
            out->deviation[place] = 0;
        out->wide |= out->deviation[place] > 0;
    }
}

/* Whether the first step shows that nothing is wide, and nothing hidden: the others can only lower
 * a deviation, and the median that it may be put to is less than ALIKE times as large. */
static int is_narrow(const struct survey *survey, const double few[PLACES])
{
    double *deviation = survey->out->deviation;
    unsigned count = 0;

    for (size_t place = 0; place < PLACES; place++) {
        deviation[place] *= ALIKE;
        if (!(deviation[place] <= WIDE * few[place]))
            return 0;
        count += is_short(survey, few, place) != 0;
    }
    return count <= VOR_NOISE_HIDDEN;
}

/* Fits at the places, at first to the domain, then to fewer of its points. */
static vor_status look(struct survey *survey, struct vor_halves *halves, const struct vor_run *run,
                       struct vor_error *err)
{
    double few[PLACES] = {0};
    vor_status status;

    for (size_t place = 0; place < PLACES; place++)
        for (unsigned step = 0; step < STEPS; step++)
            survey->deviation[step][place] = INFINITY;
    survey->to = 1;
    status = vor_run_rows(run, PLACES, BLOCK, fit_place, survey, err);
    if (status != VOR_OK)
        return status;
    ask(survey, few);
    if (is_narrow(survey, few)) {
        memset(survey->out->deviation, 0, sizeof survey->out->deviation);
        return VOR_OK;
    }
    survey->from = 1;
    survey->to = STEPS;
    for (;;) {
        status = vor_run_rows(run, PLACES, BLOCK, fit_place, survey, err);
        if (status != VOR_OK)
            return status;
        ask(survey, few);
        agree(survey->out);
        survey->out->hidden = 0; /* places that show nothing but balls */
        for (size_t place = 0; place < PLACES; place++)
            survey->out->hidden += isinf(survey->out->deviation[place]) != 0;
        if (survey->out->hidden <= VOR_NOISE_HIDDEN)
            survey->out->hidden = 0;
        if (survey->out->hidden == 0)
            break;
        survey->from = STEPS - 2; /* fewer were tried among twice as many points */
        if (++survey->level == halves->levels)
            status = vor_halves_add(halves, VOR_NOISE_LEAST, run, err);
        if (status != VOR_OK || survey->level == halves->levels)
            break;
    }
    if (status == VOR_OK)
        keep_wide(survey, few);
    return status;
}

vor_status vor_noise_find(struct vor_noise *out, struct vor_halves *halves,
                          const struct vor_neighbors *neighbors, const struct vor_run *run,
                          struct vor_error *err)
{
    size_t n = halves->level[0].n;
    struct survey *survey;
    vor_status status;

    out->wide = 0;
    out->hidden = 0;
    memset(out->deviation, 0, sizeof out->deviation);
    if (n < VOR_NOISE_LEAST)
        return VOR_OK;
    survey = vor_calloc(run->memory, 1, sizeof *survey);
    if (survey == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    survey->halves = halves;
    survey->neighbors = neighbors;
    survey->out = out;
    for (size_t place = 0; place < PLACES; place++) {
        size_t at = (size_t)(((double)place + 0.5) / PLACES * (double)n);

        memcpy(&out->xyz[3 * place], &halves->level[0].xyz[3 * at], 3 * sizeof *out->xyz);
    }
    status = look(survey, halves, run, err);
    vor_free(run->memory, survey);
    return status;
}

size_t vor_noise_place(const struct vor_noise *noise, const float x[3])
{
    double least = INFINITY;
    size_t place = 0;

    for (size_t i = 0; i < PLACES; i++) {
        double distance2 = vor_distance2f(&noise->xyz[3 * i], x);

        place = distance2 < least ? i : place;
        least = distance2 < least ? distance2 : least;
    }
    return place;
}
