#include "core/lop/edges.h"

#include "core/base/linalg.h"
#include "core/seeds/sites.h"

#include <stdlib.h>
#include <string.h>

/* Part of the turn between two sides that few normals may be from both: else the surface bends and
 * has no edge. */
#define BETWEEN 0.3
/* The points that may be, as one in so many: noise leaves some. */
#define BETWEEN_SHARE 8
/* Turn between the planes that are fitted to both sides, over that between the two normals that
 * they were seen by, at least, both as 1 - cosine: where a surface bends, planes around the place
 * where they meet turn less, and points that are put there are pushed to and fro. At 0 / 0.8 / 0.9
 * / 0.95: a screw's thread, 40,000 points with noise to 6,000, delta 0.134 / 0.072 / 0.062 / 0.057.
 * At wedges of 90 to 155 degrees and on fandisk's edges points lie as near, and as even, at all. */
#define TURNS 0.95

/* The nearest point around that is of another side: its place among those gathered, or -1. */
static int other_side(const struct vor_lop_gathered *near, const float *normal)
{
    int best = -1;

    for (unsigned k = 0; k < near->count; k++) {
        float n[3] = {near->normal[0][k], near->normal[1][k], near->normal[2][k]};
        double turned = vor_dotf(n, normal);

        if (turned > VOR_LOP_EDGE_COSINE || turned < -VOR_SAME_WAY)
            continue;
        if (best < 0 || near->distance2[k] < near->distance2[best] ||
            (near->distance2[k] <= near->distance2[best] && near->index[k] < near->index[best]))
            best = (int)k;
    }
    return best;
}

/* Whether many points around have a normal between those of the two sides. Turns are compared by
 * 1 - cosine, which grows as their square. */
static int bends(const struct vor_lop_gathered *near, const struct vor_lop_point end[2])
{
    double turn = 1 - vor_dotf(end[0].normal, end[1].normal), least = BETWEEN * BETWEEN * turn;
    unsigned between = 0;

    for (unsigned k = 0; k < near->count; k++) {
        float n[3] = {near->normal[0][k], near->normal[1][k], near->normal[2][k]};
        double a = 1 - vor_dotf(n, end[0].normal), b = 1 - vor_dotf(n, end[1].normal);

        between += a > least && b > least && a < turn && b < turn;
    }
    return between * BETWEEN_SHARE > near->count;
}

/* How far x is from the plane of the other side at the foot. */
static double beyond(const struct vor_lop_edge *edge, const float x[3])
{
    double off = 0;

    for (int c = 0; c < 3; c++)
        off += (double)edge->other[c] * ((double)x[c] - (double)edge->foot[c]);
    return off;
}

/* Whether a point lies past its edge: the points around of its own side are on the other side of
 * the other plane. */
static int lies_past(const struct vor_lop_edge *edge, const struct vor_lop_gathered *near,
                     const struct vor_lop_point *point)
{
    double own = beyond(edge, point->xyz), others = 0;
    unsigned count = 0;

    for (unsigned k = 0; k < near->count; k++) {
        float x[3] = {near->xyz[0][k], near->xyz[1][k], near->xyz[2][k]};
        float n[3] = {near->normal[0][k], near->normal[1][k], near->normal[2][k]};

        if (vor_dotf(n, point->normal) <= VOR_LOP_EDGE_COSINE)
            continue;
        others += beyond(edge, x);
        count++;
    }
    return count >= VOR_LOP_FEWEST && (own > 0) != (others - own > 0);
}

void vor_lop_edge_find(struct vor_lop_edge *out, const struct vor_lop_samples *samples, size_t i,
                       double spacing, const struct vor_lop_tree *tree,
                       const struct vor_lop_latent *latent)
{
    struct vor_lop_gathered near;
    struct vor_lop_point end[2];
    double met;
    int other;

    memset(end, 0, sizeof end); /* gcc's analyzer cannot see that the loops fill it */
    out->distance = INFINITY;
    out->past = 0;
    memcpy(end[0].xyz, &samples->xyz[3 * i], sizeof end[0].xyz);
    memcpy(end[0].normal, &samples->normal[3 * i], sizeof end[0].normal);
    vor_lop_tree_gather(&near, tree, end[0].xyz, VOR_LOP_EDGE_SEEN * spacing);
    other = other_side(&near, end[0].normal);
    if (other < 0)
        return;
    for (int c = 0; c < 3; c++) {
        end[1].xyz[c] = near.xyz[c][other];
        end[1].normal[c] = near.normal[c][other];
    }
    if (bends(&near, end) ||
        !vor_lop_latent_edge(out->foot, out->along, &met, latent, end[0].xyz, end) ||
        1 - met < TURNS * (1 - vor_dotf(end[0].normal, end[1].normal)))
        return;
    memcpy(out->other, end[1].normal, sizeof out->other);
    out->distance = (float)sqrt(vor_distance2f(end[0].xyz, out->foot));
    out->past = lies_past(out, &near, &end[0]);
}

/* A point near an edge. */
struct candidate {
    float distance; /* in spacings */
    uint32_t point;
};

static int by_distance(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;

    if (x->distance < y->distance || x->distance > y->distance)
        return x->distance < y->distance ? -1 : 1;
    return x->point < y->point ? -1 : x->point > y->point;
}

/* Lists the points near edges, nearest first. */
static vor_status list(struct candidate **out, size_t *count, const struct vor_lop_edge *edge,
                       const unsigned char *on, const float *spacing,
                       const struct vor_lop_samples *samples, struct vor_error *err)
{
    struct candidate *candidate;

    *count = 0;
    for (size_t i = 0; i < samples->n; i++)
        *count += !on[i] && (double)edge[i].distance <= VOR_LOP_EDGE_NEAR * (double)spacing[i];
    candidate = vor_malloc(samples->memory, *count, sizeof *candidate);
    if (candidate == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", *count);
    *count = 0;
    for (size_t i = 0; i < samples->n; i++)
        if (!on[i] && (double)edge[i].distance <= VOR_LOP_EDGE_NEAR * (double)spacing[i]) {
            candidate[*count].distance = edge[i].distance / spacing[i];
            candidate[(*count)++].point = (uint32_t)i;
        }
    if (*count > 0)
        qsort(candidate, *count, sizeof *candidate, by_distance);
    *out = candidate;
    return VOR_OK;
}

/* Puts point i onto its edge unless another one is there. */
static vor_status put_one(struct vor_lop_tree *tree, struct vor_lop_samples *samples, uint32_t i,
                          const struct vor_lop_edge *edge, unsigned char *on, double spacing,
                          struct vor_error *err)
{
    struct vor_lop_gathered near;

    vor_lop_tree_gather(&near, tree, edge->foot, VOR_SITES_APART * spacing);
    if (near.count > 0)
        return VOR_OK;
    *on = 1;
    memcpy(&samples->xyz[3 * (size_t)i], edge->foot, sizeof edge->foot);
    return vor_lop_tree_add(tree, i, edge->foot, &samples->normal[3 * (size_t)i], err);
}

/* Lets point i, which is on an edge, stay there unless one before it is as near as
 * VOR_LOP_CLOSE: two edges that meet do not let their points go apart. */
static vor_status keep_one(struct vor_lop_tree *tree, const struct vor_lop_samples *samples,
                           uint32_t i, unsigned char *on, double spacing, struct vor_error *err)
{
    const float *x = &samples->xyz[3 * (size_t)i];
    struct vor_lop_gathered near;

    vor_lop_tree_gather(&near, tree, x, VOR_LOP_CLOSE * spacing);
    *on = near.count == 0;
    return *on ? vor_lop_tree_add(tree, i, x, &samples->normal[3 * (size_t)i], err) : VOR_OK;
}

vor_status vor_lop_edge_put(struct vor_lop_samples *samples, const struct vor_lop_edge *edge,
                            unsigned char *on, const float *spacing, struct vor_error *err)
{
    struct candidate *candidate = NULL;
    struct vor_lop_tree tree;
    size_t count;
    vor_status status = vor_lop_tree_init(&tree, samples->memory, err);

    for (size_t i = 0; i < samples->n && status == VOR_OK; i++)
        if (on[i])
            status = keep_one(&tree, samples, (uint32_t)i, &on[i], (double)spacing[i], err);
    VOR_THEN(status, list(&candidate, &count, edge, on, spacing, samples, err));
    for (size_t k = 0; candidate != NULL && status == VOR_OK && k < count; k++) {
        uint32_t i = candidate[k].point;

        status = put_one(&tree, samples, i, &edge[i], &on[i], (double)spacing[i], err);
    }
    vor_free(samples->memory, candidate);
    vor_lop_tree_free(&tree);
    return status;
}
