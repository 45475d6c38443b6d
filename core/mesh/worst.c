#include "core/mesh/worst.h"

#include "core/base/linalg.h"
#include "core/mesh/flip.h"
#include "core/mesh/quality.h"
#include "core/mesh/relax.h"

#include <stdlib.h>
#include <string.h>

/* Strain (mesh/quality.h) above which triangles are made better: that of 45 degrees between edges
 * as long as each other. */
#define BAD ((4 - M_SQRT2) / sqrt(6))

/* The last step of the search is this part of the first: it is halved four times. */
enum { SMALLEST_PART = 1 << 4 };

/* Times that all points around a flipped edge move: in steps together, of which later ones change
 * next to nothing, and one by one. */
enum { NUDGES = VOR_RELAX_STEPS, SWEEPS = 2 * VOR_RELAX_ROUNDS };

/* How much worse a flip may make triangles before points are moved one by one: strains above 1 are
 * twice as much. With 2^5, the smallest angle of fandisk to 10,000 is 39.4 in the place of 45.1.
 * Before the last step together it is its square: of bunny's flips that make them better in the
 * end, one in 40 has more, of others half. After the sweeps it is the third, the seventh and the
 * 15th root: of the former, one in twenty has 2^2.6 and more after one sweep, 2^0.8 after two, of
 * the latter three in four. Points whose triangles are as much less bad than all stay. */
enum { WORSE_MOST = 1 << 8 };

/* A triangle and its strain. */
struct bad {
    double strain;
    uint32_t triangle;
};

/* What changes as a point moves. */
struct kept {
    float xyz[3], normal[3], near;
    struct vor_last_fit fit;
};

/* Points of the triangles at four points. */
enum { RING_SIZE = 4 * (VOR_AROUND_MOST + 2) };

struct ring {
    unsigned n;
    uint32_t point[RING_SIZE];
};

/* Flips that are tried together, as the edges that they made: no more than triangles at a point. Of
 * seven clouds with folds, none went on for more than five; one, two and four were kept. */
struct flips {
    unsigned n;
    uint32_t made[VOR_AROUND_MOST][2];
};

/* The triangles around a point, as it moves: each is the point, then its other corners. */
struct fan {
    unsigned n;
    int by_angle;
    float corner[VOR_AROUND_MOST][9];
};

struct worst {
    struct vor_complex *complex;
    struct vor_sheet *sheet;
    struct vor_seeds *seeds;
    size_t fixed;
    const struct vor_recall *how;
    unsigned char *movable; /* n: the point may move, which flips do not change */
    unsigned char *tried;   /* n: edges there were flipped in vain, none near with success since */
    struct bad *bad;        /* a triangle each, `count` are set */
    size_t count, left;     /* left: flips that may be tried */
    int by_angle;           /* see strain_of */
    vor_status status;      /* of what ran on the pool's thread */
    struct vor_error *err;
};

/* How bad a triangle is, from 1 on: its strain, or by its angle, the strain of the least strained
 * triangle with as small an angle. What that has above 1 is no less than half of what its own has,
 * so that one of 44 degrees is about as bad as an obtuse one with Q_t = .76 (mesh/quality.h). */
static double strain_of(const float *xyz, const uint32_t corner[3], int by_angle)
{
    double strain = vor_triangle_strain(xyz, corner), cosine;

    if (!by_angle)
        return strain;
    cosine = vor_triangle_sharpest(xyz, corner);
    return cosine < 1 ? fmax((1 + strain) / 2, (2 - cosine) / sqrt(3 * (1 - cosine * cosine)))
                      : INFINITY;
}

static int is_bad(const struct worst *worst, const uint32_t corner[3])
{
    return strain_of(worst->seeds->xyz, corner, worst->by_angle) > BAD;
}

/* Worst first; of as bad ones, the smaller number. */
static int worse_first(const void *a, const void *b)
{
    const struct bad *x = a, *y = b;

    if (x->strain < y->strain || x->strain > y->strain)
        return x->strain > y->strain ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

static void find_fan(struct fan *fan, const struct worst *worst, uint32_t i)
{
    const struct vor_complex *complex = worst->complex;

    fan->n = complex->degree[i];
    fan->by_angle = worst->by_angle;
    for (unsigned t = 0; t < fan->n; t++) {
        uint32_t other[2];

        vor_complex_others(complex, complex->around[(size_t)i * VOR_AROUND_MOST + t], i, other);
        vor_gather(&fan->corner[t][3], worst->seeds->xyz, other, 2);
    }
}

/* How bad they are with the point at x: eighth powers of how far their strains are above 1, in sum;
 * where that is not less than `enough`, at least so much. */
static double badness_from(struct fan *fan, const float x[3], double enough)
{
    static const uint32_t corner[3] = {0, 1, 2};
    double sum = 0;

    for (unsigned t = 0; t < fan->n && sum < enough; t++) {
        double over;

        memcpy(fan->corner[t], x, 3 * sizeof *x);
        over = strain_of(fan->corner[t], corner, fan->by_angle) - 1;
        over *= over * over * over;
        sum += over * over;
    }
    return sum;
}

/* The same of those around point i as it is. */
static double badness_around(const struct worst *worst, uint32_t i, double enough)
{
    struct fan fan;

    find_fan(&fan, worst, i);
    return badness_from(&fan, &worst->seeds->xyz[3 * (size_t)i], enough);
}

/* Whether a triangle around point i has turned over against what it was, as `before` has their
 * normals. */
static int has_turned(const struct worst *worst, uint32_t i, double before[][3])
{
    const struct vor_complex *complex = worst->complex;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];
        double normal[3];

        vor_triangle_normal(normal, worst->seeds->xyz, &complex->triangle[3 * (size_t)at]);
        if (!(vor_dot(normal, before[t]) >
              VOR_SAME_WAY * sqrt(vor_dot(normal, normal) * vor_dot(before[t], before[t]))))
            return 1;
    }
    return 0;
}

/* The normals of the triangles around point i, and the mean length of the edges. */
static double normals_of(const struct worst *worst, uint32_t i, double normal[][3])
{
    const struct vor_complex *complex = worst->complex;
    const float *xyz = worst->seeds->xyz;
    double length = 0;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t], other[2];

        vor_triangle_normal(normal[t], xyz, &complex->triangle[3 * (size_t)at]);
        vor_complex_others(complex, at, i, other);
        length += sqrt(vor_distance2f(&xyz[3 * (size_t)i], &xyz[3 * (size_t)other[0]]));
    }
    return length / complex->degree[i];
}

/* Whether point i is as far from the input as points that hang (vor_attach_hanging). */
static int hangs(const struct worst *worst, uint32_t i)
{
    const struct vor_seeds *seeds = worst->seeds;

    return (double)worst->sheet->near[i] >
           VOR_HOLE_INSIDE *
               fmax(sqrt(seeds->area / (double)seeds->n), seeds->last_fit[i].surface.spacing);
}

static struct kept keep(const struct worst *worst, uint32_t i)
{
    struct kept kept = {.near = worst->sheet->near[i], .fit = worst->seeds->last_fit[i]};

    memcpy(kept.xyz, &worst->seeds->xyz[3 * (size_t)i], sizeof kept.xyz);
    memcpy(kept.normal, &worst->sheet->normal[3 * (size_t)i], sizeof kept.normal);
    return kept;
}

static void take_back(const struct worst *worst, uint32_t i, const struct kept *kept)
{
    worst->sheet->near[i] = kept->near;
    worst->seeds->last_fit[i] = kept->fit;
    memcpy(&worst->seeds->xyz[3 * (size_t)i], kept->xyz, sizeof kept->xyz);
    memcpy(&worst->sheet->normal[3 * (size_t)i], kept->normal, sizeof kept->normal);
}

/* Moves point i along its surface to where no triangle around it is bad, or they are least bad.
 * Always to the latter / so, mean quality of fandisk, two seeds: .9689, .9698 / .9694, .9704. */
static void search(const struct worst *worst, uint32_t i, const struct vor_surface *surface)
{
    struct vor_seeds *seeds = worst->seeds;
    float *at = &seeds->xyz[3 * (size_t)i];
    double axis[3][3], normal[VOR_AROUND_MOST][3] = {{0}}, best, length, enough;
    struct fan fan;

    length = normals_of(worst, i, normal);
    vor_relax_axes(axis, worst->complex, seeds->xyz, i);
    find_fan(&fan, worst, i);
    best = badness_from(&fan, at, INFINITY);
    enough = vor_power(BAD - 1, 8);
    for (int part = 1; part <= SMALLEST_PART && best > enough; part *= 2) {
        double step = VOR_RELAX_STEP_MAX * length / part;
        float from[3];

        memcpy(from, at, sizeof from);
        for (int u = -1; u <= 1; u++)
            for (int v = -1; v <= 1; v++) {
                float before[3];
                double x[3], here;

                if ((u == 0 && v == 0) || best <= enough)
                    continue;
                memcpy(before, at, sizeof before);
                for (int c = 0; c < 3; c++)
                    x[c] = (double)from[c] + step * (u * axis[0][c] + v * axis[1][c]);
                vor_surface_put(surface, x);
                vor_to_floats(at, x);
                here = badness_from(&fan, at, best);
                if (here < best && !has_turned(worst, i, normal))
                    best = here;
                else
                    memcpy(at, before, sizeof before);
            }
    }
}

/* Moves point i to where the triangles around it are less bad. The surface there may be another
 * than that along which it was looked for. */
static void move(struct worst *worst, uint32_t i, unsigned worker)
{
    struct vor_seeds *seeds = worst->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    struct kept kept = keep(worst, i);
    int hung = hangs(worst, i);
    double bad;

    if (!worst->movable[i] || vor_seeds_recall(seeds, scratch, i, worst->how) == VOR_SURFACE_NONE)
        return;
    bad = badness_around(worst, i, INFINITY);
    search(worst, i, &scratch->onto);
    if (!(vor_distance2f(&seeds->xyz[3 * (size_t)i], kept.xyz) > 0))
        return;
    vor_sheet_put_one(worst->sheet, seeds, worst->how, scratch, i);
    if (!(badness_around(worst, i, bad) < (1 - VOR_ROUNDED) * bad) || (!hung && hangs(worst, i)))
        take_back(worst, i, &kept);
}

/* Moves point i a step towards the least sum of the strains of its triangles. */
static void nudge(struct worst *worst, uint32_t i, unsigned worker)
{
    const struct vor_complex *complex = worst->complex;
    struct vor_seeds *seeds = worst->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    double normal[VOR_AROUND_MOST][3] = {{0}}, x[3], step[2];
    float *at = &seeds->xyz[3 * (size_t)i], from[3];
    struct vor_relax_pull pull = {.triangles = 0};
    struct vor_frame frame;

    if (!worst->movable[i] || vor_seeds_recall(seeds, scratch, i, worst->how) == VOR_SURFACE_NONE)
        return;
    (void)normals_of(worst, i, normal);
    vor_relax_axes(frame.axis, complex, seeds->xyz, i);
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t other[2];

        vor_complex_others(complex, complex->around[(size_t)i * VOR_AROUND_MOST + t], i, other);
        vor_relax_add(&pull, &frame, at, &seeds->xyz[3 * (size_t)other[0]],
                      &seeds->xyz[3 * (size_t)other[1]]);
    }
    vor_relax_step(step, &pull);
    memcpy(from, at, sizeof from);
    for (int c = 0; c < 3; c++)
        x[c] = (double)from[c] + step[0] * frame.axis[0][c] + step[1] * frame.axis[1][c];
    vor_surface_put(&scratch->onto, x);
    vor_to_floats(at, x);
    if (has_turned(worst, i, normal))
        memcpy(at, from, sizeof from);
}

/* The place of point i in a ring; after the last where it is not there. */
static unsigned find(const struct ring *ring, uint32_t i)
{
    unsigned k = 0;

    while (k < ring->n && ring->point[k] != i)
        k++;
    return k;
}

/* Adds the corners of the triangles of point i. */
static void add_around(struct ring *ring, const struct vor_complex *complex, uint32_t i)
{
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];

        for (size_t c = 0; c < 3; c++) {
            uint32_t corner = complex->triangle[3 * (size_t)at + c];
            unsigned k = find(ring, corner);

            ring->point[k] = corner;
            ring->n += k == ring->n;
        }
    }
}

static double badness_of(const struct worst *worst, const struct ring *ring)
{
    double sum = 0;

    for (unsigned k = 0; k < ring->n; k++)
        sum += badness_around(worst, ring->point[k], INFINITY);
    return sum;
}

/* What was tried near point i may be tried again. */
static void forget(struct worst *worst, uint32_t i)
{
    struct ring ring = {.n = 0};

    add_around(&ring, worst->complex, i);
    for (unsigned k = 0; k < ring.n; k++)
        worst->tried[ring.point[k]] = 0;
}

/* Moves the corners of a triangle, and if it stays bad the points around them. */
static void move_at(struct worst *worst, const uint32_t corner[3], unsigned worker)
{
    const struct vor_complex *complex = worst->complex;

    for (int c = 0; c < 3; c++)
        move(worst, corner[c], worker);
    for (int c = 0; c < 3; c++)
        for (unsigned t = 0; t < complex->degree[corner[c]] && is_bad(worst, corner); t++) {
            uint32_t at = complex->around[(size_t)corner[c] * VOR_AROUND_MOST + t], other[2];

            vor_complex_others(complex, at, corner[c], other);
            move(worst, other[0], worker);
        }
}

/* Moves the points around edges that were flipped. Returns whether the triangles are less bad than
 * `bad` in the end, and no point hangs that did not before. Points of triangles that lay over each
 * other are near each other at first, so there all steps together and a sweep are waited for. */
static int settle(struct worst *worst, const struct ring *ring, const struct kept *kept, double bad,
                  int folded, unsigned worker)
{
    struct vor_scratch *scratch = &worst->seeds->scratch[worker];
    unsigned power = 1;

    for (int left = NUDGES; left-- > 0;) {
        for (unsigned k = 0; k < ring->n; k++)
            nudge(worst, ring->point[k], worker);
        if (!folded && !(badness_of(worst, ring) < WORSE_MOST * (left > 0 ? WORSE_MOST : 1) * bad))
            return 0;
    }
    for (unsigned k = 0; k < ring->n; k++) {
        uint32_t i = ring->point[k];
        int hung = hangs(worst, i);

        if (!(vor_distance2f(&worst->seeds->xyz[3 * (size_t)i], kept[k].xyz) > 0))
            continue;
        vor_sheet_put_one(worst->sheet, worst->seeds, worst->how, scratch, i);
        if (hangs(worst, i) && !hung)
            return 0;
    }
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double now = badness_of(worst, ring);

        if (!(folded && sweep == 0) && !(vor_power(now / bad, power) < WORSE_MOST))
            return 0;
        for (unsigned k = 0; k < ring->n; k++)
            if (WORSE_MOST * badness_around(worst, ring->point[k], now) > now)
                move(worst, ring->point[k], worker);
        power += power + 1;
    }
    return badness_of(worst, ring) < (1 - VOR_ROUNDED) * bad;
}

/* Whether the edge from a to b, whose triangles have the third corners c and d, may be flipped: not
 * where points come farther from six triangles, squared and summed, than in a lattice. */
static int may_flip(const struct worst *worst, uint32_t a, uint32_t b, const uint32_t third[2])
{
    const unsigned char *degree = worst->complex->degree;

    return degree[third[0]] + degree[third[1]] <= degree[a] + degree[b] && degree[a] > 3 &&
           degree[b] > 3 && vor_flip_may(worst->complex, worst->sheet, a, b, third);
}

/* The cosine between the normals of the triangles at an edge, which is below 0 where they lie over
 * each other; 0 too where a flip could not put a shorter edge in its place. */
static double fold_at(const struct worst *worst, uint32_t a, uint32_t b, const uint32_t third[2])
{
    const struct vor_complex *complex = worst->complex;
    const uint32_t corner[2][3] = {{a, b, third[0]}, {b, a, third[1]}};
    const float *xyz = worst->seeds->xyz;
    uint32_t none[2];
    double normal[2][3];

    if (complex->degree[a] <= 3 || complex->degree[b] <= 3 ||
        complex->degree[third[0]] >= VOR_AROUND_MOST ||
        complex->degree[third[1]] >= VOR_AROUND_MOST ||
        vor_complex_edge(complex, third[0], third[1], none) != 0 ||
        !(vor_distance2f(&xyz[3 * (size_t)third[0]], &xyz[3 * (size_t)third[1]]) <
          vor_distance2f(&xyz[3 * (size_t)a], &xyz[3 * (size_t)b])) ||
        !vor_triangle_unit_normal(normal[0], xyz, corner[0]) ||
        !vor_triangle_unit_normal(normal[1], xyz, corner[1]))
        return 0;
    return vor_dot(normal[0], normal[1]);
}

static void undo(struct worst *worst, struct flips *flips)
{
    while (flips->n > 0) {
        const uint32_t *made = flips->made[--flips->n];
        uint32_t third[2];

        (void)vor_complex_edge(worst->complex, made[0], made[1], third);
        vor_complex_flip(worst->complex, made[0], made[1], third);
    }
}

/* Flips an edge, and then beside the last one the edge of the deepest fold, `most` in all. Returns
 * whether there are as many. */
static int flip_on(struct worst *worst, const struct ring *ring, struct flips *flips,
                   const uint32_t edge[2], unsigned most)
{
    uint32_t end[2] = {edge[0], edge[1]}, third[2], next[2] = {0, 0};
    double fold = -1;

    for (flips->n = 0; flips->n < most && fold < 0;) {
        (void)vor_complex_edge(worst->complex, end[0], end[1], third);
        vor_complex_flip(worst->complex, end[0], end[1], third);
        memcpy(flips->made[flips->n++], third, sizeof third);
        fold = 0;
        for (int side = 0; side < 4; side++) {
            uint32_t a = end[side / 2], b = third[side % 2], over[2];
            double here;

            if (vor_complex_edge(worst->complex, a, b, over) != 2 ||
                find(ring, over[0]) == ring->n || find(ring, over[1]) == ring->n)
                continue;
            here = fold_at(worst, a, b, over);
            if (here < fold) {
                fold = here;
                next[0] = a;
                next[1] = b;
            }
        }
        memcpy(end, next, sizeof end);
    }
    return flips->n == most;
}

/* Flips the edge from a to b, if there is one, and moves the points around it, if that makes the
 * triangles there less bad. Where they lie over each other, edges beside it are flipped with it, as
 * many more as suffice. */
static void try_flip(struct worst *worst, uint32_t a, uint32_t b, unsigned worker)
{
    struct vor_complex *complex = worst->complex;
    struct kept kept[RING_SIZE];
    struct ring ring = {.n = 0};
    struct flips flips = {.n = 0};
    uint32_t third[2], edge[2] = {a, b};
    double bad;
    int folded;

    if (worst->left == 0 || vor_complex_edge(complex, a, b, third) != 2)
        return;
    folded = fold_at(worst, a, b, third) < 0;
    if (!folded && !may_flip(worst, a, b, third))
        return;
    worst->left--;
    add_around(&ring, complex, a);
    add_around(&ring, complex, b);
    add_around(&ring, complex, third[0]);
    add_around(&ring, complex, third[1]);
    for (unsigned k = 0; k < ring.n; k++)
        kept[k] = keep(worst, ring.point[k]);
    bad = badness_of(worst, &ring);
    for (unsigned most = 1; most <= (folded ? VOR_AROUND_MOST : 1); most++) {
        int all = flip_on(worst, &ring, &flips, edge, most);

        if (all && settle(worst, &ring, kept, bad, folded, worker)) {
            for (unsigned k = 0; k < ring.n; k++)
                forget(worst, ring.point[k]);
            return;
        }
        for (unsigned k = 0; k < ring.n; k++)
            take_back(worst, ring.point[k], &kept[k]);
        undo(worst, &flips);
        if (!all)
            return;
    }
}

/* Flips edges around the corners of a triangle as long as it is bad, unless that was tried. */
static void flip_at(struct worst *worst, const uint32_t *corner, unsigned worker)
{
    unsigned char *tried = worst->tried;
    struct ring ring = {.n = 0};

    if (tried[corner[0]] && tried[corner[1]] && tried[corner[2]])
        return;
    for (int c = 0; c < 3; c++) {
        tried[corner[c]] = 1;
        add_around(&ring, worst->complex, corner[c]);
    }
    for (unsigned k = 0; k < ring.n; k++)
        for (unsigned j = 0; j < k && is_bad(worst, corner); j++)
            try_flip(worst, ring.point[j], ring.point[k], worker);
}

/* Lists the bad triangles. */
static void list(struct worst *worst)
{
    const struct vor_complex *complex = worst->complex;

    worst->count = 0;
    for (uint32_t t = 0; t < complex->count; t++) {
        const uint32_t *corner = &complex->triangle[3 * (size_t)t];

        if (corner[0] != VOR_COMPLEX_GONE && is_bad(worst, corner))
            worst->bad[worst->count++] =
                (struct bad){strain_of(worst->seeds->xyz, corner, worst->by_angle), t};
    }
    qsort(worst->bad, worst->count, sizeof *worst->bad, worse_first);
}

/* Does something with each bad triangle. */
static void for_each(struct worst *worst, unsigned worker,
                     void (*visit)(struct worst *, const uint32_t *, unsigned))
{
    list(worst);
    for (size_t k = 0; k < worst->count && worst->status == VOR_OK; k++) {
        worst->status = vor_run_answered(vor_run_poll(&worst->seeds->run), worst->err);
        if (worst->status == VOR_OK)
            visit(worst, &worst->complex->triangle[3 * (size_t)worst->bad[k].triangle], worker);
    }
}

static void improve_on_one(void *ctx, VOR_UNUSED size_t begin, VOR_UNUSED size_t end,
                           unsigned worker)
{
    struct worst *worst = ctx;

    for (int pass = 0; pass < 3 * VOR_RELAX_ROUNDS && worst->left > 0; pass++) {
        if (pass == VOR_RELAX_ROUNDS) {
            worst->by_angle = 1;
            memset(worst->tried, 0, worst->seeds->n);
        }
        for_each(worst, worker, move_at);
        for_each(worst, worker, flip_at);
    }
}

vor_status vor_worst_improve(struct vor_complex *complex, struct vor_sheet *sheet,
                             struct vor_seeds *seeds, size_t fixed, const struct vor_recall *how,
                             struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct worst worst = {complex, sheet, seeds, fixed, how, .err = err};
    vor_status status;

    worst.left = seeds->n;
    status = VOR_MAKE_ALL(memory, err, seeds->n, VOR_ARRAY(worst.movable, seeds->n, 1),
                          VOR_ZEROED(worst.tried, seeds->n, 1),
                          VOR_ARRAY(worst.bad, complex->count + 1, 1));
    for (uint32_t i = 0; i < seeds->n && status == VOR_OK; i++)
        worst.movable[i] = i + fixed < seeds->n && vor_complex_surrounds(complex, i);
    if (status == VOR_OK)
        status = vor_run_for(&seeds->run, 1, 1, improve_on_one, &worst, err);
    if (status == VOR_OK)
        status = worst.status;
    VOR_FREE_ALL(memory, worst.bad, worst.tried, worst.movable);
    return status;
}
