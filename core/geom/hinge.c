#include "core/geom/hinge.h"

#include "core/base/linalg.h"
#include "core/base/union.h"
#include "core/geom/flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK = 256,                     /* points of one task */
    PLACES = VOR_WINDING_PLACES / 2, /* at which two faces see each other */
    SEEN = VOR_NEIGHBORS_MAX / 2     /* points around one that are seen from it */
};

/* An edge from a point of face a to one of face b. */
struct edge {
    uint32_t a, b, i, j;
};

/* All edges between two faces. */
struct seam {
    size_t first, count; /* in `edge` */
    double agree;        /* above 0: signs are consistent; 0: they tell nothing */
};

struct hinge {
    const struct vor_hinge *on;
    unsigned char *between; /* n: 1 where a point belongs to no face by itself */
    unsigned char *apart;   /* n: 1 where a point is in no face, likewise, for good */
    int64_t *rough;         /* components: thrice their points in no face, less the others */
    uint32_t *up;           /* n: way to the first point of a set, */
    unsigned char *differs; /* n: and whether the sign is another than there */
    uint32_t *face;         /* n: the number of the face, */
    unsigned char *sign;    /* n: and the sign in it */
    uint32_t *points;       /* n: face by face */
    size_t *first;          /* faces + 1: in `points` */
    unsigned char *turned;  /* faces: 1 where most points have other signs now than in it */
    unsigned char *mixed;   /* faces: 1 where both signs are in it */
    size_t faces;
    struct edge *edge;
    size_t edges;
    struct seam *seam;
    size_t seams;
};

/* The first point of a set, and whether the sign of i differs from its. */
static uint32_t root_of(struct hinge *hinge, uint32_t i, unsigned *differs)
{
    return vor_union_root_odd(hinge->up, hinge->differs, i, differs);
}

/* Joins the sets of i and j; says whether their signs differ. */
static void join(struct hinge *hinge, uint32_t i, uint32_t j, int differ)
{
    unsigned x, y;
    uint32_t a = root_of(hinge, i, &x), b = root_of(hinge, j, &y);

    if (a == b)
        return;
    hinge->differs[a < b ? b : a] = (unsigned char)(x ^ y ^ (unsigned)differ);
    hinge->up[a < b ? b : a] = a < b ? a : b;
}

/* How far points i and j are from lying in one plane. */
static double bend(const struct hinge *hinge, size_t i, size_t j)
{
    const struct vor_winding_points *points = hinge->on->points;
    const float *m = &points->normal[3 * i], *n = &points->normal[3 * j];
    float to[3];
    double a, b;

    for (size_t c = 0; c < 3; c++)
        to[c] = points->xyz[3 * j + c] - points->xyz[3 * i + c];
    a = vor_dotf(m, to);
    b = vor_dotf(n, to);
    return 1 - fabs(vor_dotf(m, n)) + fmax(a * a, b * b) / fmax(vor_dotf(to, to), 1e-300);
}

/* Whether the normals of two points of a face lead to different sides. */
static int against(const struct hinge *hinge, size_t i, size_t j)
{
    const float *normal = hinge->on->points->normal;

    return vor_dotf(&normal[3 * i], &normal[3 * j]) < 0;
}

static void between_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct hinge *hinge = ctx;
    const struct vor_graph *graph = hinge->on->graph;

    for (size_t i = begin; i < end; i++)
        for (unsigned a = 0; a < graph->count[i] / VOR_FLIP_REACH && !hinge->between[i]; a++)
            hinge->between[i] = bend(hinge, i, graph->list[i * graph->most + a]) >= hinge->on->bend;
}

/* Makes faces of the points that are not between them. */
static void join_flat(struct hinge *hinge)
{
    const struct vor_graph *graph = hinge->on->graph;

    for (size_t i = 0; i < graph->n; i++)
        hinge->up[i] = (uint32_t)i;
    for (size_t i = 0; i < graph->n; i++)
        for (unsigned a = 0; a < graph->count[i] / VOR_FLIP_REACH && !hinge->between[i]; a++) {
            uint32_t j = graph->list[i * graph->most + a];

            if (!hinge->between[j])
                join(hinge, (uint32_t)i, j, against(hinge, i, j));
        }
}

/* Lets point i between faces join the one beside it, with the sign it has, if there is one. */
static int join_near(struct hinge *hinge, uint32_t i)
{
    const struct vor_graph *graph = hinge->on->graph;
    const unsigned char *odd = hinge->on->span->odd;

    for (unsigned a = 0; a < graph->count[i] && hinge->between[i]; a++) {
        uint32_t j = graph->list[(size_t)i * graph->most + a];

        if (hinge->between[j])
            continue;
        join(hinge, i, j, odd[i] ^ odd[j]);
        hinge->between[i] = 0;
    }
    return !hinge->between[i];
}

/* Lets points between faces join those beside them, and then those that are in their lists. */
static void join_beside(struct hinge *hinge)
{
    const struct vor_graph *graph = hinge->on->graph;
    uint32_t *joined = hinge->points;
    size_t count = 0;

    for (uint32_t i = 0; i < graph->n; i++)
        if (hinge->between[i] && join_near(hinge, i))
            joined[count++] = i;
    for (size_t at = 0; at < count; at++)
        for (unsigned a = 0; a < graph->count[joined[at]]; a++) {
            uint32_t j = graph->list[(size_t)joined[at] * graph->most + a];

            if (hinge->between[j] && join_near(hinge, j))
                joined[count++] = j;
        }
}

/* Numbers the faces in the order of their first points, and lists the points of each. */
static vor_status sort_points(struct hinge *hinge, const struct vor_run *run, struct vor_error *err)
{
    size_t n = hinge->on->graph->n;
    vor_status status;

    for (size_t i = 0; i < n; i++) {
        unsigned differs;
        uint32_t root = root_of(hinge, (uint32_t)i, &differs);

        hinge->face[i] = root == i ? (uint32_t)hinge->faces++ : hinge->face[root];
        hinge->sign[i] = (unsigned char)differs;
    }
    status = VOR_MAKE_ALL(run->memory, err, n, VOR_ZEROED(hinge->first, hinge->faces + 2, 1),
                          VOR_ZEROED(hinge->turned, hinge->faces, 1),
                          VOR_ARRAY(hinge->mixed, hinge->faces, 1));
    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < n; i++)
        hinge->first[hinge->face[i] + 2]++;
    for (size_t f = 0; f < hinge->faces; f++)
        hinge->first[f + 2] += hinge->first[f + 1];
    for (size_t i = 0; i < n; i++)
        hinge->points[hinge->first[hinge->face[i] + 1]++] = (uint32_t)i;
    for (size_t f = 0; f < hinge->faces; f++) {
        size_t turned = 0;

        for (size_t k = hinge->first[f]; k < hinge->first[f + 1]; k++)
            turned += hinge->on->span->odd[hinge->points[k]] ^ hinge->sign[hinge->points[k]];
        hinge->turned[f] = 2 * turned > hinge->first[f + 1] - hinge->first[f];
        /* Both signs in one face. */
        hinge->mixed[f] =
            turned >= hinge->on->points->least &&
            hinge->first[f + 1] - hinge->first[f] - turned >= hinge->on->points->least;
    }
    return VOR_OK;
}

static int by_faces(const void *x, const void *y)
{
    const struct edge *p = x, *q = y;

    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    if (p->b != q->b)
        return p->b < q->b ? -1 : 1;
    if (p->i != q->i)
        return p->i < q->i ? -1 : 1;
    return (p->j > q->j) - (p->j < q->j);
}

/* Lists the edges between faces, or counts them. */
static size_t list_edges(struct edge *out, const struct hinge *hinge)
{
    const struct vor_graph *graph = hinge->on->graph;
    size_t count = 0;

    for (uint32_t i = 0; i < graph->n; i++)
        for (unsigned k = 0; k < graph->count[i]; k++) {
            uint32_t j = graph->list[(size_t)i * graph->most + k];
            uint32_t a = hinge->face[i], b = hinge->face[j];

            if (a == b)
                continue;
            if (out != NULL)
                out[count] = a < b ? (struct edge){a, b, i, j} : (struct edge){b, a, j, i};
            count++;
        }
    return count;
}

static int same_seam(const struct edge *edge)
{
    return edge[0].a == edge[-1].a && edge[0].b == edge[-1].b;
}

static vor_status find_seams(struct hinge *hinge, const struct vor_run *run, struct vor_error *err)
{
    size_t seams = 0;

    hinge->edges = list_edges(NULL, hinge);
    if (hinge->edges == 0)
        return VOR_OK;
    hinge->edge = vor_malloc(run->memory, hinge->edges, sizeof *hinge->edge);
    if (hinge->edge == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu edges", hinge->edges);
    (void)list_edges(hinge->edge, hinge);
    qsort(hinge->edge, hinge->edges, sizeof *hinge->edge, by_faces);
    for (size_t e = 0; e < hinge->edges; e++)
        seams += e == 0 || !same_seam(&hinge->edge[e]);
    hinge->seam = vor_calloc(run->memory, seams, sizeof *hinge->seam);
    if (hinge->seam == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu seams", seams);
    for (size_t e = 0; e < hinge->edges; e++) {
        if (e == 0 || !same_seam(&hinge->edge[e]))
            hinge->seam[hinge->seams++].first = e;
        hinge->seam[hinge->seams - 1].count++;
    }
    return VOR_OK;
}

/* A point of the face of point i, farther from its rim: twice the farthest of the neighbours that
 * are in it. */
static size_t inner_of(const struct hinge *hinge, size_t i)
{
    const struct vor_graph *graph = hinge->on->graph;

    for (int round = 0; round < 2; round++) {
        const uint32_t *list = &graph->list[i * graph->most];
        unsigned a = graph->count[i];

        while (a > 0 && (hinge->apart[list[a - 1]] || hinge->face[list[a - 1]] != hinge->face[i]))
            a--;
        if (a > 0)
            i = list[a - 1];
    }
    return i;
}

/* What is seen of a face from point p, in spheres: above 0 its back, with its own signs. Nothing
 * where it lies over p by less than a spacing, as another sheet does. */
static double seen(const struct hinge *hinge, uint32_t face, size_t p)
{
    const struct vor_winding_points *points = hinge->on->points;
    unsigned k = hinge->on->graph->n < SEEN ? (unsigned)hinge->on->graph->n : SEEN;
    uint32_t index[SEEN];
    float distance2[SEEN];
    double sum = 0;

    vor_knn_search(hinge->on->knn, &points->xyz[3 * p], 1, k, index, distance2);
    for (unsigned a = 0; a < k; a++) {
        size_t i = index[a];
        double area = (double)points->area[i], r2;
        float to[3];

        if (hinge->face[i] != face)
            continue;
        if ((double)distance2[a] < (double)points->area[p]) /* not across a crease: over it */
            return 0;
        for (size_t c = 0; c < 3; c++)
            to[c] = points->xyz[3 * i + c] - points->xyz[3 * p + c];
        r2 = fmax(fmax((double)distance2[a], (double)points->area[p]), 1e-200);
        sum += (hinge->sign[i] ? -area : area) * vor_dotf(to, &points->normal[3 * i]) /
               (r2 * sqrt(r2));
    }
    return sum / (4 * M_PI);
}

static void see_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct hinge *hinge = ctx;

    for (size_t s = begin; s < end; s++) {
        struct seam *seam = &hinge->seam[s];
        const struct edge *edge = &hinge->edge[seam->first];
        size_t places = seam->count < PLACES ? seam->count : PLACES;
        double sum = 0, size = 0;

        if (hinge->first[edge->a + 1] - hinge->first[edge->a] < hinge->on->points->least ||
            hinge->first[edge->b + 1] - hinge->first[edge->b] < hinge->on->points->least)
            continue;
        for (size_t k = 0; k < places; k++) {
            const struct edge *at = &edge[k * seam->count / places];
            double both = seen(hinge, at->a, inner_of(hinge, at->j)) *
                          seen(hinge, at->b, inner_of(hinge, at->i)) / (double)places;

            sum += both;
            size += fabs(both);
        }
        if (size >= hinge->on->seen * hinge->on->seen && fabs(sum) >= hinge->on->agree * size)
            seam->agree = sum;
    }
}

/* Those first that tell most, then the longest. */
static int by_size(const void *x, const void *y)
{
    const struct seam *p = x, *q = y;
    double a = fabs(p->agree), b = fabs(q->agree);

    if (a != b)
        return a > b ? -1 : 1;
    if (p->count != q->count)
        return p->count > q->count ? -1 : 1;
    return (p->first > q->first) - (p->first < q->first);
}

/* Joins the faces; notes in `between` the components in which signs are contradicted. */
static void join_faces(struct hinge *hinge)
{
    const struct vor_span *span = hinge->on->span;

    for (size_t s = 0; s < hinge->seams; s++) {
        const struct seam *seam = &hinge->seam[s];
        const struct edge *at = &hinge->edge[seam->first];
        unsigned was = hinge->turned[at->a] ^ hinge->turned[at->b];
        unsigned differ = seam->agree == 0 ? was : seam->agree < 0;

        if (differ != was || hinge->mixed[at->a] || hinge->mixed[at->b])
            hinge->between[span->component[at->i]] = 1;
        join(hinge, at->i, at->j, hinge->sign[at->i] ^ hinge->sign[at->j] ^ differ);
    }
}

static vor_status find(unsigned char *odd, struct hinge *hinge, const struct vor_run *run,
                       struct vor_error *err)
{
    const struct vor_span *span = hinge->on->span;
    int is_any = 0;
    vor_status status = vor_run_for(run, span->n, BLOCK, between_block, hinge, err);

    for (size_t i = 0; i < span->n; i++) {
        hinge->apart[i] = hinge->between[i];
        hinge->rough[span->component[i]] += hinge->apart[i] ? 3 : -1;
    }
    for (size_t c = 0; c < span->components; c++)
        is_any |= hinge->rough[c] <= 0;
    if (status != VOR_OK || !is_any)
        return status;
    join_flat(hinge);
    join_beside(hinge);
    status = sort_points(hinge, run, err);
    VOR_THEN(status, find_seams(hinge, run, err));
    VOR_THEN(status, vor_run_for(run, hinge->seams, 1, see_block, hinge, err));
    if (status != VOR_OK || hinge->seams == 0)
        return status;
    qsort(hinge->seam, hinge->seams, sizeof *hinge->seam, by_size);
    memset(hinge->between, 0, span->components);
    join_faces(hinge);
    for (uint32_t i = 0; i < span->n; i++) {
        unsigned differs;

        (void)root_of(hinge, i, &differs);
        if (hinge->between[span->component[i]] && hinge->rough[span->component[i]] <= 0)
            odd[i] = (unsigned char)differs;
    }
    return VOR_OK;
}

vor_status vor_hinge_find(unsigned char *odd, const struct vor_hinge *on, const struct vor_run *run,
                          struct vor_error *err)
{
    struct hinge hinge = {.on = on};
    size_t n = on->span->n;
    vor_status status = VOR_MAKE_ALL(run->memory, err, n, VOR_ZEROED(hinge.between, n, 1),
                                     VOR_ARRAY(hinge.apart, n, 1), VOR_ARRAY(hinge.up, n, 1),
                                     VOR_ZEROED(hinge.differs, n, 1), VOR_ARRAY(hinge.face, n, 1),
                                     VOR_ARRAY(hinge.sign, n, 1), VOR_ARRAY(hinge.points, n, 1),
                                     VOR_ZEROED(hinge.rough, on->span->components, 1));

    memcpy(odd, on->span->odd, n);
    VOR_THEN(status, find(odd, &hinge, run, err));
    VOR_FREE_ALL(run->memory, hinge.seam, hinge.edge, hinge.mixed, hinge.turned, hinge.first,
                 hinge.points, hinge.sign, hinge.face, hinge.differs, hinge.up, hinge.rough,
                 hinge.apart, hinge.between);
    return status;
}
