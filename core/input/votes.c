#include "core/input/votes.h"

#include "core/base/linalg.h"
#include "core/geom/surface.h"
#include "core/geom/twofold.h"

#include <assert.h>
#include <limits.h>
#include <math.h>
#include <string.h>

/* Points of one task. */
enum { BLOCK = 64 };

enum { MEMBERS = VOR_VOTES_MEMBERS, FITS = VOR_VOTES_FITS };

/* Nearest points that two sheets are fitted to. Of the triangles of arma2_120k to 40,000 lie on two
 * sheets with 70 / 70 and 45 / 70, 55 and 40 / 62, 48 and 36 points 1.97 / 1.70 / 1.65 / 1.49 %; of
 * shell60k to 20,000 165 / 142 / 143 / 118. Around every second point alone, 70 and 45: 1.90 %. */
static const unsigned fitted[FITS] = {VOR_TWOFOLD_USUAL, 48, 36};
enum { WIDEST = VOR_TWOFOLD_USUAL };

/* Steps in which the distance of the sheets over what points are off is kept, and how many say no
 * less than more of them: 10.4 times that. Measured by truth on arma2_120k: pairs whose lesser
 * distance is .5 / 2 / 4 / 8 / 12 times that are told right in 55 / 68 / 81 / 96 / 99 %. */
#define STEPS 12.0
enum { SUREST = 125 };
_Static_assert(SUREST <= SCHAR_MAX, "it is kept in a signed char");

/* The lesser of what is said of two points as log odds: the parabola goes through those shares. */
static double odds_of(int a, int b)
{
    int least = (a < 0 ? -a : a) < (b < 0 ? -b : b) ? (a < 0 ? -a : a) : (b < 0 ? -b : b);
    double x = least / STEPS, l = 0.25 * x + 0.025 * x * x;

    return (a < 0) == (b < 0) ? l : -l;
}

/* What workers share. */
struct voting {
    const struct vor_domain *domain;
    const struct vor_graph *graph;
    struct vor_votes_of *of;
};

static void vote(signed char says[MEMBERS], const float *near, unsigned n)
{
    double x[3] = {(double)near[0], (double)near[1], (double)near[2]};
    struct vor_twofold two;

    if (!vor_twofold_fit(&two, near, n, x))
        return;
    for (size_t e = 0; e < MEMBERS; e++) {
        double half, apart;

        vor_to_doubles(x, &near[3 * e]);
        (void)vor_twofold_above(&two, x, &half);
        /* what points are off so little, rounding says */
        apart = 2 * fabs(half) / fmax(two.off, VOR_NEGLIGIBLE * two.radius);
        says[e] = (signed char)(two.side[e] * (int)fmin(STEPS * apart + 0.5, SUREST));
    }
}

static void vote_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct voting *voting = ctx;
    const float *xyz = voting->domain->xyz;
    struct vor_knn_last last = {.k = 0};
    uint32_t index[WIDEST];
    float distance2[WIDEST], near[3 * WIDEST];

    for (size_t i = begin; i < end; i++) {
        struct vor_votes_of *of = &voting->of[i];

        memset(of, 0, sizeof *of);
        if (!voting->graph->own[i])
            continue;
        vor_knn_search_next(voting->domain->knn, &last, &xyz[3 * i], WIDEST, index, distance2);
        vor_gather(near, xyz, index, WIDEST);
        memcpy(of->member, index, sizeof of->member);
        for (int fit = 0; fit < FITS; fit++)
            vote(of->says[fit], near, fitted[fit]);
    }
}

vor_status vor_votes_make(struct vor_votes *out, const struct vor_domain *domain,
                          const struct vor_graph *graph, const struct vor_run *run,
                          struct vor_error *err)
{
    struct voting voting = {domain, graph, NULL};
    vor_status status;

    if (domain->n < WIDEST) {
        memset(out, 0, sizeof *out);
        return VOR_OK;
    }
    voting.of = vor_malloc(run->memory, domain->n, sizeof *voting.of);
    if (voting.of == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_for(run, domain->n, BLOCK, vote_block, &voting, err);
    if (status == VOR_OK)
        *out = (struct vor_votes){run->memory, voting.of};
    else
        vor_free(run->memory, voting.of);
    return status;
}

void vor_votes_free(struct vor_votes *votes)
{
    if (votes->of != NULL)
        vor_free(votes->memory, votes->of);
    memset(votes, 0, sizeof *votes);
}

/* Where each of a few points is in a list: a table by their numbers. */
enum { SLOTS = 128, NOWHERE = 255 };

static unsigned slot_of(uint32_t index)
{
    return (index * UINT32_C(2654435761)) >> 25;
}

static unsigned find_place(const unsigned char place[SLOTS], const uint32_t *index, uint32_t wanted)
{
    unsigned slot = slot_of(wanted);

    while (place[slot] != NOWHERE && index[place[slot]] != wanted)
        slot = (slot + 1) % SLOTS;
    return place[slot];
}

void vor_votes_hear(double *odds, const struct vor_votes *votes, uint32_t i, const uint32_t *index,
                    unsigned count)
{
    unsigned char place[SLOTS];

    assert(count <= VOR_VOTES_HEARD);
    memset(odds, 0, count * sizeof *odds);
    if (votes->of == NULL)
        return;
    memset(place, NOWHERE, SLOTS);
    for (unsigned e = 0; e < count; e++) {
        unsigned slot = slot_of(index[e]);

        while (place[slot] != NOWHERE)
            slot = (slot + 1) % SLOTS;
        place[slot] = (unsigned char)e;
    }
    for (unsigned e = 0; e < count; e++) {
        const struct vor_votes_of *of = &votes->of[index[e]];
        unsigned own = 0;

        while (own < MEMBERS && of->member[own] != i)
            own++;
        if (own == MEMBERS)
            continue;
        for (unsigned k = 0; k < MEMBERS; k++) {
            unsigned at = find_place(place, index, of->member[k]);

            for (int fit = 0; fit < FITS && at != NOWHERE; fit++)
                odds[at] += odds_of(of->says[fit][own], of->says[fit][k]);
        }
    }
}
