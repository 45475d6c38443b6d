#include "core/input/loops.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/geom/boundary.h"
#include "core/geom/opening.h"
#include "core/geom/plane.h"
#include "core/input/edges.h"
#include "core/input/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK = 256,             /* points of one task */
    NEAR = 30,               /* neighbours of a spacing, beside the point itself */
    FLAT = VOR_EDGES_NORMAL, /* points of a plane, where no list has one */
    SHEETS = 3 /* times as many neighbours are looked at where the domain has sheets */
};

/* Quantile of the neighbours' spacings that is the spacing at a border: those farther inside. At
 * 0.25 / 0.35 / 0.5 with a radius of 2.2: holes of five spacings found 20 / 20 / 17 of 20, balls
 * with a loop 1 / 0 / 0. */
#define INSIDE_QUANTILE 0.25

/* Spacings of all points together that a neighbour on the same flat sheet lies off the tangent
 * plane at most, where the domain has sheets and where it has none: there more than that is noise.
 */
#define LEVEL_SHEETS 0.35

/* Length of a loop, in spacings, from which on it counts: shorter ones are chance, three points
 * with an empty disc between them. At 10 / 14 with a radius of 2.3: balls with a loop 1 / 0 of 20,
 * holes of five spacings found 20 / 19. */
#define LEAST_LENGTH 14.0

/* Spacings from the last points to the border. */
#define BEYOND VOR_EDGE_ROOM

struct find {
    const struct vor_domain *domain;
    int normals;         /* there are such, by which sheets are told apart */
    unsigned flat;       /* points of a plane where there are none */
    float *spacing;      /* n */
    unsigned char *flag; /* n: 1 where an empty disc may touch */
    uint32_t *candidate; /* the flagged points */
    size_t candidates;
    struct vor_corner *corner; /* candidates x VOR_OPENINGS */
    unsigned char *corners_of; /* candidates: how many of them there are */
};

/* The points around one, itself first. */
struct around {
    unsigned k;
    uint32_t index[SHEETS * VOR_OPENING_NEAR];
    float distance2[SHEETS * VOR_OPENING_NEAR];
    float near[3 * VOR_OPENING_NEAR];
    double own[3]; /* middle of those this side of all creases, from the point */
};

/* Spacing of a square lattice as dense as k points in a disc. */
static double spacing_of(float far2, unsigned k)
{
    return sqrt(M_PI * (double)far2 / k);
}

/* Whether j lies on the sheet of i: no more than off over its plane, or as far as a surface gets
 * whose normal turns as theirs do. Along an arc that turns by an angle, the height over the
 * distance is the sine of half of it; from one parallel sheet to the other nothing turns. */
static int is_level(const struct vor_domain *domain, size_t i, size_t j, double off)
{
    const float *m = domain->graph.normal + 3 * i, *n = domain->graph.normal + 3 * j;
    const float *x = vor_domain_point(domain, i), *y = vor_domain_point(domain, j);
    double cosine = 0, across = 0;

    for (int c = 0; c < 3; c++) {
        cosine += (double)m[c] * (double)n[c];
        across += ((double)y[c] - (double)x[c]) * (double)m[c];
    }
    return fabs(across) <= off || across * across <= (1 - cosine * cosine) * vor_distance2f(x, y);
}

/* Leaves those on the sheet of point i, at most k. */
static void keep_level(struct around *around, const struct vor_domain *domain, size_t i, unsigned k)
{
    double off = (domain->known.sheets ? LEVEL_SHEETS : 1) *
                 spacing_of(around->distance2[around->k - 1], around->k);
    unsigned left = 0;

    for (unsigned j = 0; j < around->k && left < k; j++)
        if (is_level(domain, i, around->index[j], off)) {
            around->index[left] = around->index[j];
            around->distance2[left++] = around->distance2[j];
        }
    around->k = left;
}

/* Sine of the angle between the normals of two points. */
static double sine_of(double along[3], const struct vor_domain *domain, size_t i, size_t j)
{
    double n[3] = {0}, m[3] = {0};

    vor_to_doubles(n, domain->graph.normal + 3 * i);
    vor_to_doubles(m, domain->graph.normal + 3 * j);
    vor_cross(along, n, m);
    return sqrt(vor_dot(along, along));
}

static void find_own(struct around *around, const struct vor_domain *domain, size_t i)
{
    unsigned count = 0;

    memset(around->own, 0, sizeof around->own);
    for (unsigned j = 0; j < around->k; j++) {
        double along[3];

        if (sine_of(along, domain, i, around->index[j]) > VOR_LOOPS_CREASE)
            continue;
        count++;
        for (int c = 0; c < 3; c++)
            around->own[c] += (double)vor_domain_point(domain, around->index[j])[c] -
                              (double)vor_domain_point(domain, i)[c];
    }
    for (int c = 0; c < 3 && count > 0; c++)
        around->own[c] /= count;
}

/* The crease between point i and a neighbour: the line in which their tangent planes meet. */
struct crease {
    double along[3];      /* unit vector */
    double across[3];     /* in the plane of i, from its side to the crease */
    double beyond[3];     /* in the plane of the neighbour, from the crease to it */
    double before, after; /* how far the crease is from i, and the neighbour from the crease */
    double shift;         /* of the neighbour along the crease */
};

/* Finds the crease between i and j. False where the surface hardly bends. */
static int find_crease(struct crease *out, const struct vor_domain *domain,
                       const struct around *around, size_t i, size_t j)
{
    double n[3] = {0}, m[3] = {0}, d[3] = {0}, sine = sine_of(out->along, domain, i, j);

    if (!(sine > VOR_LOOPS_CREASE))
        return 0;
    vor_to_doubles(n, domain->graph.normal + 3 * i);
    vor_to_doubles(m, domain->graph.normal + 3 * j);
    for (int c = 0; c < 3; c++) {
        out->along[c] /= sine;
        d[c] = (double)vor_domain_point(domain, j)[c] - (double)vor_domain_point(domain, i)[c];
    }
    vor_cross(out->across, out->along, n);
    out->before = vor_dot(d, m) / vor_dot(out->across, m);
    out->shift = vor_dot(d, out->along);
    for (int c = 0; c < 3; c++)
        out->beyond[c] = d[c] - out->shift * out->along[c] - out->before * out->across[c];
    out->after = sqrt(vor_dot(out->beyond, out->beyond));
    if (!(out->after > 0))
        return 0;
    /* A point on the crease is on neither side of it; the points around it are. */
    if (out->before < vor_dot(around->own, out->across)) {
        out->before = -out->before;
        for (int c = 0; c < 3; c++)
            out->across[c] = -out->across[c];
    }
    for (int c = 0; c < 3; c++)
        out->beyond[c] /= out->after;
    return 1;
}

/* Lays a neighbour beyond a crease out in the plane of point i, as if the surface were unfolded. */
static void unfold(float out[3], const struct vor_domain *domain, const struct around *around,
                   size_t i, size_t j)
{
    struct crease crease;

    memcpy(out, vor_domain_point(domain, j), 3 * sizeof *out);
    if (find_crease(&crease, domain, around, i, j))
        for (int c = 0; c < 3; c++)
            out[c] =
                (float)((double)vor_domain_point(domain, i)[c] + crease.shift * crease.along[c] +
                        (crease.before + crease.after) * crease.across[c]);
}

/* Lays a place in the plane of i beyond the crease towards j back onto the plane of j. */
static void fold(float out[3], const double place[3], const struct vor_domain *domain,
                 const struct around *around, size_t i, size_t j)
{
    struct crease crease;
    double d[3], far = 0;

    for (int c = 0; c < 3; c++)
        d[c] = place[c] - (double)vor_domain_point(domain, i)[c];
    if (find_crease(&crease, domain, around, i, j))
        far = fmax(vor_dot(d, crease.across) - crease.before, 0);
    for (int c = 0; c < 3; c++)
        out[c] = (float)(place[c] + (far > 0 ? far * (crease.beyond[c] - crease.across[c]) : 0));
}

static void search(struct around *out, const struct find *find, size_t i, unsigned k)
{
    const struct vor_domain *domain = find->domain;
    unsigned all = find->normals && domain->known.sheets ? SHEETS * k : k;

    out->k = all < domain->n ? all : (unsigned)domain->n;
    vor_knn_search(domain->knn, vor_domain_point(domain, i), 1, out->k, out->index, out->distance2);
    if (find->normals) {
        keep_level(out, domain, i, k);
        find_own(out, domain, i);
    }
    for (unsigned j = 0; j < out->k; j++)
        if (find->normals)
            unfold(&out->near[3 * j], domain, out, i, out->index[j]);
        else
            memcpy(&out->near[3 * j], vor_domain_point(domain, out->index[j]),
                   3 * sizeof *out->near);
}

/* The normal of the lists if there is one, else that of a plane. */
static void normal_of(double normal[3], const struct find *find, size_t i,
                      const struct around *around)
{
    const float *known = find->normals ? &find->domain->graph.normal[3 * i] : NULL;
    struct vor_plane plane;

    if (known == NULL) {
        vor_plane_fit(&plane, find->domain->xyz, around->index,
                      around->k < find->flat ? around->k : find->flat);
        known = plane.normal;
    }
    vor_to_doubles(normal, known);
}

static unsigned openings_at(struct vor_opening *out, const struct find *find, size_t i,
                            const struct around *around, double radius)
{
    const float *p = vor_domain_point(find->domain, i);
    double x[3] = {(double)p[0], (double)p[1], (double)p[2]}, normal[3];

    normal_of(normal, find, i, around);
    return vor_openings_find(out, around->near, around->k, x, normal, radius);
}

static void flag_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct find *find = ctx;
    struct vor_opening opening[VOR_OPENINGS];
    struct around around;
    double radius;

    search(&around, find, i, NEAR + 1);
    find->spacing[i] = (float)spacing_of(around.distance2[around.k - 1], around.k);
    /* at a straight border half of the disc of the neighbours is empty */
    radius = M_SQRT1_2 * VOR_LOOPS_RADIUS * (double)find->spacing[i];
    find->flag[i] = radius > 0 && openings_at(opening, find, i, &around, radius) > 0;
}

/* Spacing at point i: that of its neighbours, without those that lie at the border as well. */
static double spacing_at(const struct find *find, const struct around *around)
{
    unsigned k = around->k < NEAR + 1 ? around->k : NEAR + 1;
    float spacing[NEAR + 1];

    for (unsigned j = 0; j < k; j++)
        spacing[j] = find->spacing[around->index[j]];
    vor_sort_floats(spacing, k);
    return (double)spacing[vor_quantile_rank(INSIDE_QUANTILE, k)];
}

static void corner_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct find *find = ctx;
    struct vor_opening opening[VOR_OPENINGS];
    struct around around;

    for (size_t i = begin; i < end; i++) {
        uint32_t at = find->candidate[i];
        double spacing;
        unsigned count;

        search(&around, find, at, VOR_OPENING_NEAR);
        spacing = spacing_at(find, &around);
        count = openings_at(opening, find, at, &around, VOR_LOOPS_RADIUS * spacing);
        find->corners_of[i] = (unsigned char)count;
        for (unsigned o = 0; o < count; o++) {
            struct vor_corner *corner = &find->corner[VOR_OPENINGS * i + o];

            corner->point = at;
            corner->spacing = (float)spacing;
            for (int c = 0; c < 3; c++)
                corner->outward[c] = (float)opening[o].outward[c];
            for (int e = 0; e < 2; e++) {
                const double *middle = opening[o].middle[e];

                corner->end[e] = around.index[opening[o].end[e]];
                for (int c = 0; c < 3; c++)
                    corner->middle[e][c] = (float)middle[c];
                if (find->normals)
                    fold(corner->middle[e], middle, find->domain, &around, at, corner->end[e]);
            }
        }
    }
}

/* Looks for corners at all points; leaves them in find->corner, *count of them. */
static vor_status find_corners(struct find *find, size_t *count, const struct vor_run *run,
                               struct vor_error *err)
{
    size_t n = find->domain->n, found = 0;
    vor_status status = vor_run_rows(run, n, BLOCK, flag_row, find, err);

    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < n; i++)
        find->candidates += find->flag[i];
    status = VOR_MAKE_ALL(run->memory, err, find->candidates,
                          VOR_ARRAY(find->candidate, find->candidates, 1),
                          VOR_ARRAY(find->corners_of, find->candidates, 1),
                          VOR_ARRAY(find->corner, find->candidates, VOR_OPENINGS));
    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < n; i++)
        if (find->flag[i])
            find->candidate[found++] = (uint32_t)i;
    status = vor_run_for(run, find->candidates, BLOCK, corner_block, find, err);
    *count = 0;
    for (size_t i = 0; status == VOR_OK && i < find->candidates; i++)
        for (unsigned o = 0; o < find->corners_of[i]; o++)
            find->corner[(*count)++] = find->corner[VOR_OPENINGS * i + o];
    return status;
}

/* Rows of corners being walked along. */
struct walk {
    const struct vor_domain *domain;
    const struct vor_corner *corner;
    size_t n;
    size_t *mate;
    unsigned char *seen; /* n: 1 where a row went through already */
    struct vor_loops *loops;
};

/* The end across the corner, and the one that it is joined to. */
static size_t step(const struct walk *walk, size_t end)
{
    return walk->mate[end ^ 1];
}

/* Walks from an end, away from its corner's other one, to the end of the row, and marks it. Returns
 * how many corners it has. */
static size_t mark(const struct walk *walk, size_t end)
{
    size_t count = 0;

    while (end != VOR_ROWS_NO_END && !walk->seen[end / 2]) {
        walk->seen[end / 2] = 1;
        count++;
        end = step(walk, end);
    }
    return count;
}

/* What is summed up along a loop. */
struct sums {
    double length, bend, spacing, centre[3];
};

/* Adds the line between two corners. A disc moved outward by a step makes it longer by that step
 * times what is added to bend. */
static void add_line(struct sums *sums, const struct walk *walk, const struct vor_corner *from,
                     const struct vor_corner *to)
{
    const float *a = vor_domain_point(walk->domain, from->point),
                *b = vor_domain_point(walk->domain, to->point);
    double length = sqrt(vor_distance2f(a, b)), bend = 0;

    for (int c = 0; c < 3; c++) {
        bend += ((double)b[c] - (double)a[c]) * ((double)to->outward[c] - (double)from->outward[c]);
        sums->centre[c] += length * 0.5 * ((double)a[c] + (double)b[c]);
    }
    sums->bend += length > 0 ? bend / length : 0;
    sums->length += length;
    sums->spacing += (double)from->spacing;
}

/* Takes the loop through a corner that no row went through, unless it is too short. */
static void take_loop(const struct walk *walk, size_t first)
{
    struct vor_loops *loops = walk->loops;
    struct vor_loop loop = {.first = loops->points};
    struct sums sums = {0};
    size_t end = 2 * first;

    do {
        size_t next = step(walk, end);

        walk->seen[end / 2] = 1;
        loops->point[loop.first + loop.count++] = walk->corner[end / 2].point;
        add_line(&sums, walk, &walk->corner[end / 2], &walk->corner[next / 2]);
        end = next;
    } while (end != 2 * first);
    sums.spacing /= (double)loop.count;
    if (loop.count < VOR_LOOPS_LEAST || sums.length < LEAST_LENGTH * sums.spacing)
        return;
    loop.length = sums.length + BEYOND * sums.spacing * sums.bend;
    loop.turns = -sums.bend / (2 * M_PI);
    loop.spacing = sums.spacing;
    for (int c = 0; c < 3; c++)
        loop.centre[c] = sums.centre[c] / sums.length;
    loops->points += loop.count;
    loops->loop[loops->count++] = loop;
}

static int longer(const void *left, const void *right)
{
    const struct vor_loop *a = left, *b = right;

    if (a->length != b->length)
        return a->length > b->length ? -1 : 1;
    return (a->first > b->first) - (a->first < b->first);
}

/* Makes the loops of n corners. */
static vor_status make_loops(struct vor_loops *loops, const struct find *find, size_t n,
                             const struct vor_run *run, struct vor_error *err)
{
    struct walk walk = {.domain = find->domain, .corner = find->corner, .n = n, .loops = loops};
    vor_status status;

    status =
        VOR_MAKE_ALL(run->memory, err, n, VOR_ARRAY(walk.mate, n, 2), VOR_ZEROED(walk.seen, n, 1),
                     VOR_ARRAY(loops->point, n, 1), VOR_ARRAY(loops->loop, n / VOR_LOOPS_LEAST, 1));
    if (status == VOR_OK) {
        status = vor_rows_join(walk.mate, walk.corner, n, VOR_LOOPS_RADIUS, run->memory, err);
        if (status == VOR_OK) {
            /* Marks the rows that stop somewhere, and counts the long ones. */
            for (size_t end = 0; end < 2 * walk.n; end++)
                if (walk.mate[end] == VOR_ROWS_NO_END && !walk.seen[end / 2])
                    loops->open += mark(&walk, end) >= VOR_LOOPS_LEAST;
            for (size_t i = 0; i < walk.n; i++)
                if (!walk.seen[i])
                    take_loop(&walk, i);
            qsort(loops->loop, loops->count, sizeof *loops->loop, longer);
        }
    }
    VOR_FREE_ALL(run->memory, walk.seen, walk.mate);
    return status;
}

vor_status vor_loops_find(struct vor_loops *out, const struct vor_domain *domain,
                          const struct vor_run *run, struct vor_error *err)
{
    /* Planes through the nearest few follow noise, where fits take more points than that. */
    int noisy = domain->known.neighbors.usual > VOR_NEIGHBORS_FEWEST && !domain->known.sheets;
    struct find find = {.domain = domain,
                        .normals = !noisy && vor_graph_has_normals(&domain->graph),
                        .flat = noisy ? NEAR + 1 : FLAT};
    struct vor_loops loops = {.memory = run->memory};
    vor_status status = VOR_OK;
    size_t corners = 0;

    find.spacing = vor_malloc(run->memory, domain->n, sizeof *find.spacing);
    find.flag = vor_malloc(run->memory, domain->n, sizeof *find.flag);
    if (find.spacing == NULL || find.flag == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    else if (domain->n >= VOR_LOOPS_LEAST)
        status = find_corners(&find, &corners, run, err);
    VOR_THEN(status, make_loops(&loops, &find, corners, run, err));
    VOR_FREE_ALL(run->memory, find.corner, find.corners_of, find.candidate, find.flag,
                 find.spacing);
    if (status == VOR_OK)
        *out = loops;
    else
        vor_loops_free(&loops);
    return status;
}

void vor_loops_free(struct vor_loops *loops)
{
    VOR_FREE_ALL(loops->memory, loops->point, loops->loop);
    memset(loops, 0, sizeof *loops);
}
