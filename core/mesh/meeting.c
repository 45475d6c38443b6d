#include "core/mesh/meeting.h"

#include "core/base/linalg.h"
#include "core/geom/twofold.h"
#include "core/input/adjacency.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 64, /* points of one task, each of which searches */
    FEWEST = 4, /* of the VOR_ADJACENT nearest that no lists lead to from the seed's root */
    AROUND = VOR_TWOFOLD_USUAL
};

/* The squared spacing of one of two sheets with AROUND points on a disc of radius 1. Beside a rim
 * the points fill half of it: the spacing is taken for up to 1.4 times what it is, at a corner
 * twice. */
#define SPACING2 (2 * 3.14159265358979 / AROUND)

/* Most that neighbours may be on one side alike, from -1 to 1: over one sheet that two are fitted
 * to, sides are those of its bumps, over two they come at random. Of points of arma2_120k that are
 * taken to meet, on two sheets / one, at .3 / .4 / .5 / none: 591, 76 / 705, 164 / 769, 312 / 850,
 * 1,465. */
#define ALIKE 0.4

/* What workers share. */
struct meeting {
    const struct vor_sheet *sheet;
    unsigned char *meets; /* n: whether two sheets meet at the point */
};

/* Points around a place, over two sheets fitted to them. */
struct over {
    struct vor_twofold two;
    double at[AROUND][2]; /* u, v */
    double half[AROUND];  /* of the distance of the sheets there */
    double spacing;       /* of one sheet */
};

/* Whether points of another sheet are near seed i: those that are not related with its root. */
static int has_other(const struct vor_sheet *sheet, size_t i, const uint32_t index[AROUND],
                     int (*are_related)(const struct vor_graph *, uint32_t, uint32_t))
{
    uint32_t root = sheet->root[i];
    int other = 0;

    for (int e = 0; e < VOR_ADJACENT && other < FEWEST; e++)
        other += index[e] != root && !are_related(sheet->graph, root, index[e]);
    return other == FEWEST;
}

static int fit(struct over *out, const float near[3 * AROUND], const double x[3])
{
    if (!vor_twofold_fit(&out->two, near, AROUND, x))
        return 0;
    for (size_t e = 0; e < AROUND; e++) {
        double p[3], d[3];

        for (size_t c = 0; c < 3; c++) {
            p[c] = (double)near[3 * e + c];
            d[c] = p[c] - x[c];
        }
        for (int a = 0; a < 2; a++)
            out->at[e][a] = vor_dot(d, out->two.axis[a]);
        (void)vor_twofold_above(&out->two, p, &out->half[e]);
        out->half[e] = fabs(out->half[e]);
    }
    out->spacing = sqrt(SPACING2) * out->two.radius;
    return 1;
}

/* How much each point and its nearest, seen along the normal, are on one side: -1 .. 1. Those count
 * more where the sheets are farther apart. */
static double alike(const struct over *over)
{
    double sum = 0, most = 0;

    for (int e = 0; e < AROUND; e++) {
        double best = INFINITY, weight;
        int near = e;

        for (int f = 0; f < AROUND; f++) {
            double u = over->at[e][0] - over->at[f][0], v = over->at[e][1] - over->at[f][1];

            if (f != e && u * u + v * v < best) {
                best = u * u + v * v;
                near = f;
            }
        }
        weight = fmin(over->half[e], over->half[near]);
        sum += weight * over->two.side[e] * over->two.side[near];
        most += weight;
    }
    return most > 0 ? sum / most : 1;
}

static int meet_at(const struct vor_sheet *sheet, size_t i, struct vor_knn_last *last)
{
    const struct vor_domain *domain = sheet->seeds->domain;
    uint32_t index[AROUND];
    float distance2[AROUND], near[3 * AROUND];
    struct over over;
    double x[3], half;

    vor_knn_search_next(domain->knn, last, &sheet->seeds->xyz[3 * i], AROUND, index, distance2);
    if (!has_other(sheet, i, index, vor_graph_joins))
        return 0;
    vor_gather(near, domain->xyz, index, AROUND);
    vor_seeds_position(sheet->seeds, i, x);
    if (!fit(&over, near, x))
        return 0;
    (void)vor_twofold_above(&over.two, x, &half);
    return 2 * fabs(half) < VOR_MEETING_NEAR * over.spacing && alike(&over) < ALIKE &&
           has_other(sheet, i, index, vor_graph_leads);
}

static void meet_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct meeting *meeting = ctx;
    const struct vor_sheet *sheet = meeting->sheet;
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++)
        meeting->meets[i] = sheet->seeds->last_fit[i].layered && meet_at(sheet, i, &last);
}

vor_status vor_meeting_drop(struct vor_complex *complex, const struct vor_sheet *sheet,
                            const struct vor_run *run, struct vor_error *err)
{
    const struct vor_seeds *seeds = sheet->seeds;
    struct meeting meeting = {.sheet = sheet};
    vor_status status;

    if (seeds->domain->n < AROUND)
        return VOR_OK;
    meeting.meets = vor_malloc(run->memory, seeds->n, 1);
    if (meeting.meets == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    status = vor_run_for(run, seeds->n, BLOCK, meet_block, &meeting, err);
    if (status == VOR_OK) {
        /* Drops the triangles at points marked, and all but the largest fan of each point. */
        for (size_t t = 0; t < complex->count; t++) {
            const uint32_t *corner = &complex->triangle[3 * t];

            if (corner[0] != VOR_COMPLEX_GONE &&
                (meeting.meets[corner[0]] || meeting.meets[corner[1]] || meeting.meets[corner[2]]))
                vor_complex_remove(complex, (uint32_t)t);
        }
        vor_complex_prune(complex);
    }
    vor_free(run->memory, meeting.meets);
    return status;
}
