#include "core/input/edges.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/geom/crease.h"
#include "core/geom/plane.h"
#include "core/geom/surface.h"
#include "core/input/neighbors.h"

#include <math.h>
#include <string.h>

/* Figures below, in this order unless said otherwise: precision and recall on fandisk30k, the same
 * on fandisk30k_noise2, share of igea30k that is flagged, in %; at half the value, at it, and at
 * double (edges.h). */
enum {
    BLOCK = 256, /* points of one task */

    /* Points of a normal where fits take VOR_NEIGHBORS_FEWEST; more in proportion.
     * .996 .969 .912 .974 .08; .993 .974 .920 .964 .10; .992 .961 .921 .962 .06, and half as much
     * CPU again. */
    NORMAL = VOR_EDGES_NORMAL,
    /* Points of a crease, likewise: a ball of 2.8 spacings.
     * .989 .957 .867 .766 .40; .993 .974 .920 .964 .10; .979 .940 .947 .898 .03. */
    AROUND = 24
};

/* Variance across over that in all of the points of a normal, from which it is looked for an
 * edge: what costs least to ask. At (0.025)^2 / (0.05)^2 / (0.1)^2: recall on a wedge of 30 degrees
 * .99 / .99 / .61; CPU on igea30k 5.8 / 4.9 / 2.9 us. */
#define BENT 0.0025

/* Share of the normals' squares that lies across the edge, from which a crease is fitted. At 0.008
 * / 0.016 / 0.032: recall on a wedge of 30 degrees .99 / .99 / .91, CPU on fandisk30k_noise2 16 /
 * 14 / 13 us. */
#define ACROSS 0.016

/* Share in the third direction, from which all is a corner, and largest mean square that a crease
 * leaves there, in spacings^2. A third plane spoils the crease, and near a corner an edge is never
 * farther than a spacing and a half. .986 .980 .901 .965 .16; .993 .974 .920 .964 .10; .995 .922
 * .923 .964 .10. The bound at half and at double: fandisk30k_noise2 .923 .964 and .906 .978. */
#define CORNER 0.1
#define CORNER_OFF2 0.25

/* Sine of half of 25 degrees: edges from 30 on are asked for. At half of 20 / 25 / 28 degrees:
 * precision .986 / .993 / .996 on fandisk30k, whose creases fade out; recall is the same. */
#define LEAST_TURN 0.21643961393810288

/* Share of what the quadric leaves that the crease may leave. .996 .961 .920 .964 .00; .993 .974
 * .920 .964 .10; .991 .984 .919 .969 .53. */
#define LEFT 0.07

/* What the crease may leave on top, over the variance of noise at VOR_EDGES_NOISE_QUANTILE of all
 * places, which is .56 of the mean where there is nothing but noise. fandisk30k_noise2 .920 .885;
 * .920 .964; .919 .972. */
#define NOISE 5.3

/* By how many times what it leaves, over the number of points, the crease must be better than the
 * quadric: as the F test asks, whose 1 in 100 for one coefficient is 7. fandisk30k_noise2 .887
 * .987; .920 .964; .950 .844. */
#define BETTER 6.0

/* Spacings at that quantile that are no noise: an rms that the finest detail has as well. At half,
 * at it and at double, fandisk with noise of 0.17 spacings .938 .976; .937 .976; .937 .971. Without
 * it igea30k has 1.7 % flagged. */
#define DETAIL 0.0375

/* Spacings of rms that positions are exact to: float32 and meshed curves. .991 .974 .920 .964 .12;
 * .993 .974 .920 .964 .10; .996 .956 .920 .964 .07, and a wedge of 30 degrees is lost. */
#define EXACT 0.01

/* What the blocks of a loop leave. */
struct found {
    double length;
    size_t flagged;
};

struct find {
    const struct vor_domain *domain;
    struct vor_edges *edges;
    float *normal; /* n x 3 */
    float *off2;   /* per place: mean square that a quadric leaves, in spacings^2; < 0: none */
    size_t places;
    double noise2; /* spacings^2, at the quantile */
    struct found *block;
};

/* The points around one, nearest first. */
struct around {
    struct vor_knn_last last; /* of a row of them */
    unsigned k;
    double spacing; /* of a square lattice as dense */
    uint32_t index[VOR_NEIGHBORS_MAX];
    float near[3 * VOR_NEIGHBORS_MAX];
};

/* `few` points around x, or more where fits take more. */
static void search(struct around *out, const struct vor_domain *domain, const float *x,
                   unsigned few)
{
    unsigned fit = vor_neighbors_at(&domain->known.neighbors, x), k = few;
    float distance2[VOR_NEIGHBORS_MAX];

    if (fit > VOR_NEIGHBORS_FEWEST)
        k = few * fit / VOR_NEIGHBORS_FEWEST;
    if (k > VOR_NEIGHBORS_MAX)
        k = VOR_NEIGHBORS_MAX;
    if (k > domain->n)
        k = (unsigned)domain->n;
    vor_knn_search_next(domain->knn, &out->last, x, k, out->index, distance2);
    vor_gather(out->near, domain->xyz, out->index, k);
    out->k = k;
    out->spacing = sqrt(M_PI * (double)distance2[k - 1] / (k - 1));
}

/* Leaves in flag which points are bent. */
static void plane_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct find *find = ctx;
    struct vor_plane plane;
    struct around around;

    around.last.k = 0;
    for (size_t i = begin; i < end; i++) {
        search(&around, find->domain, &find->domain->xyz[3 * i], NORMAL);
        vor_plane_fit(&plane, find->domain->xyz, around.index, around.k);
        memcpy(&find->normal[3 * i], plane.normal, sizeof plane.normal);
        find->edges->flag[i] = (double)plane.flatness > BENT;
    }
}

static void noise_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct find *find = ctx;
    const struct vor_domain *domain = find->domain;
    struct around around;
    struct vor_surface surface;
    size_t at = (size_t)((double)i / (double)find->places * (double)domain->n);
    double unit2;

    around.last.k = 0;
    search(&around, domain, &domain->xyz[3 * at],
           domain->known.sheets ? VOR_NEIGHBORS_EXACT : AROUND);
    vor_surface_fit(&surface, around.near, around.k);
    unit2 = around.spacing * around.spacing * (around.k - VOR_QUADRIC_TERMS) / around.k;
    find->off2[i] = unit2 > 0 ? (float)(surface.off2 / unit2) : -1;
}

/* Sets the variance of the noise beyond what detail has. Where the input has sheets, what quadrics
 * leave is the gap between them: there the nearest few say how much noise there is. Of two squares
 * one or two spacings apart 0.4 and 0.2 % are flagged, as if there were no noise; of a vase of
 * 6,243 points with noise of 0.3 spacings and walls 2.9 apart, 472 of them beside its rim, 107, and
 * 11 if there were none. */
static vor_status measure_noise(struct find *find, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = vor_run_rows(run, find->places, BLOCK, noise_row, find, err);
    double low;

    if (status != VOR_OK)
        return status;
    vor_sort_floats(find->off2, find->places);
    low = (double)find->off2[vor_quantile_rank(VOR_EDGES_NOISE_QUANTILE, find->places)];
    find->noise2 = fmax(0, low - DETAIL * DETAIL);
    return VOR_OK;
}

/* Whether a crease of k points is an edge; all in spacings. */
static int is_edge(const struct vor_crease *crease, unsigned k, double noise2)
{
    double left2 = crease->crease2 + EXACT * EXACT, smooth2 = crease->smooth2 + EXACT * EXACT;

    return crease->turn > LEAST_TURN && crease->distance <= 1 &&
           left2 <= LEFT * smooth2 + NOISE * noise2 && k * (smooth2 - left2) >= BETTER * left2;
}

/* Sets what there is to know of point i, which is bent, by the points around. Returns whether it
 * lies on an edge. */
static int look_at(const struct find *find, size_t i, struct around *around)
{
    struct vor_crease crease;
    double values[3], axis[3][3];
    double m[6] = {0};

    search(around, find->domain, &find->domain->xyz[3 * i], AROUND);
    /* Axes and lengths of the sum of the normals' squares: along an edge, across it, and up. */
    for (unsigned j = 0; j < around->k; j++) {
        const float *n = &find->normal[3 * (size_t)around->index[j]];
        double d[3] = {(double)n[0], (double)n[1], (double)n[2]};

        vor_add_square(m, d);
    }
    vor_eigen3(values, axis, m);
    if (!(around->spacing > 0) || !(values[1] >= ACROSS * around->k))
        return 0;
    vor_crease_fit(&crease, around->near, around->k, axis, around->spacing);
    if (!(values[0] > CORNER * around->k && crease.crease2 < CORNER_OFF2) &&
        !is_edge(&crease, around->k, find->noise2))
        return 0;
    find->edges->strength[i] = (float)fmax(LEAST_TURN, crease.turn);
    for (size_t c = 0; c < 3; c++) {
        find->edges->direction[3 * i + c] = (float)crease.along[c];
        find->edges->foot[3 * i + c] =
            (float)((double)around->near[c] + around->spacing * crease.foot[c]);
    }
    return 1;
}

/* An edge is as long as the band of its points is large over how wide it is. */
static void edge_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct find *find = ctx;
    struct found found = {0};
    struct around around;

    around.last.k = 0;
    for (size_t i = begin; i < end; i++) {
        if (!find->edges->flag[i])
            continue;
        find->edges->flag[i] = (unsigned char)look_at(find, i, &around);
        if (!find->edges->flag[i])
            continue;
        found.length += around.spacing / 2;
        found.flagged++;
    }
    find->block[begin / BLOCK] = found;
}

/* Makes room, with nothing flagged. */
static vor_status make_room(struct find *find, struct vor_memory *memory, struct vor_error *err)
{
    struct vor_edges *edges = find->edges;
    size_t n = find->domain->n;

    edges->memory = memory;
    edges->n = n;
    return VOR_MAKE_ALL(memory, err, n, VOR_ZEROED(edges->flag, n, 1),
                        VOR_ZEROED(edges->strength, n, 1), VOR_ZEROED(edges->direction, n, 3),
                        VOR_ZEROED(edges->foot, n, 3), VOR_ARRAY(find->normal, n, 3),
                        VOR_ARRAY(find->off2, find->places, 1),
                        VOR_ARRAY(find->block, vor_blocks_of(n, BLOCK), 1));
}

static vor_status find_all(struct find *find, const struct vor_run *run, struct vor_error *err)
{
    size_t n = find->domain->n;
    vor_status status = measure_noise(find, run, err);

    VOR_THEN(status, vor_run_for(run, n, BLOCK, plane_block, find, err));
    VOR_THEN(status, vor_run_for(run, n, BLOCK, edge_block, find, err));
    for (size_t b = 0; status == VOR_OK && b < vor_blocks_of(n, BLOCK); b++) {
        find->edges->length += find->block[b].length;
        find->edges->flagged += find->block[b].flagged;
    }
    return status;
}

vor_status vor_edges_find(struct vor_edges *out, const struct vor_domain *domain,
                          const struct vor_run *run, struct vor_error *err)
{
    struct vor_edges edges = {0};
    struct find find = {.domain = domain, .edges = &edges};
    vor_status status;

    find.places = domain->n < VOR_DOMAIN_SAMPLED / 2 ? domain->n : VOR_DOMAIN_SAMPLED / 2;
    status = make_room(&find, run->memory, err);
    if (status == VOR_OK && domain->n >= VOR_CREASE_MIN)
        status = find_all(&find, run, err);
    VOR_FREE_ALL(run->memory, find.block, find.off2, find.normal);
    if (status == VOR_OK)
        *out = edges;
    else
        vor_edges_free(&edges);
    return status;
}

void vor_edges_free(struct vor_edges *edges)
{
    VOR_FREE_ALL(edges->memory, edges->foot, edges->direction, edges->strength, edges->flag);
    memset(edges, 0, sizeof *edges);
}
