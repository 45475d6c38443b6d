/* Oracle: insertion that looks at every pair and every point instead of a queue and an index. */
#include "core/base/linalg.h"
#include "core/geom/patch.h"
#include "core/lop/insert.h"
#include "core/lop/latent.h"
#include "core/lop/power.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_lop.h"

#include <float.h>
#include <string.h>

enum { BEGUN_MAX = 320, MANY = 900 };

static const double pi = 3.14159265358979323846;

/* A pair, as its later point keeps it. */
struct pair {
    uint32_t partner;
    float clearance2; /* the square of its clearance */
    float key;
};

struct twin {
    struct vor_lop_samples samples;
    struct vor_lop_latent latent;
    double rho;
    size_t begun;
    float reach[MANY];
    struct pair pair[MANY][VOR_LOP_PAIRS];
};

static const float *place(const struct twin *twin, size_t i)
{
    return &twin->samples.xyz[3 * i];
}

static const float *normal(const struct twin *twin, size_t i)
{
    return &twin->samples.normal[3 * i];
}

static double cosine(const float *a, const float *b)
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static void middle(const struct twin *twin, size_t i, size_t j, float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = (float)(((double)place(twin, i)[c] + (double)place(twin, j)[c]) / 2);
}

/* Square of the distance from the middle of pair (i, j) to the line through k along its normal;
 * infinite where k does not count. In float, as the index has it: else equal keys would differ. */
static float to_line2(const struct twin *twin, size_t i, size_t j, size_t k)
{
    const float *x = place(twin, k), *n = normal(twin, k);
    const float *a = normal(twin, i), *b = normal(twin, j);
    float half2 = (float)(vor_distance2f(place(twin, i), place(twin, j)) / 4), m[3], d2, along, off;
    float d[3], with_a = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
    float with_b = n[0] * b[0] + n[1] * b[1] + n[2] * b[2];

    middle(twin, i, j, m);
    for (int c = 0; c < 3; c++)
        d[c] = m[c] - x[c];
    d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    along = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
    off = d2 - along * along;
    if (d2 > half2 || fmaxf(with_a, with_b) < (float)-VOR_SAME_WAY)
        return INFINITY;
    return off > 0 ? off : 0;
}

static float key_of(const struct twin *twin, size_t i, size_t j, float clearance2)
{
    double turned = 2 - fmax(cosine(normal(twin, i), normal(twin, j)), 0), least = 0;
    float m[3];

    middle(twin, i, j, m);
    for (int c = 0; c < 3; c++)
        least = fmax(least, VOR_ROUNDED * fabs((double)m[c]));
    if (!((double)clearance2 > least * least))
        return 0;
    return (float)(vor_lop_power(turned, twin->rho) * sqrt((double)clearance2));
}

/* Whether points i and j lie on two sheets, one over the other. */
static int stacked(const struct twin *twin, uint32_t i, uint32_t j, double distance2)
{
    const float *n = normal(twin, i), *m = normal(twin, j);
    double along = 0, length2 = 2 + 2 * cosine(n, m);

    for (int c = 0; c < 3; c++)
        along +=
            ((double)n[c] + (double)m[c]) * ((double)place(twin, i)[c] - (double)place(twin, j)[c]);
    return along * along > VOR_LOP_STACKED * VOR_LOP_STACKED * distance2 * length2;
}

/* Whether pair a comes before b, of the same point. */
static int before(const struct pair *a, const struct pair *b)
{
    return a->key > b->key || (a->key >= b->key && a->partner < b->partner);
}

/* Keeps the best pairs of point i with the points up to `end`. */
static void find_pairs(struct twin *twin, size_t i, size_t end)
{
    for (int p = 0; p < VOR_LOP_PAIRS; p++)
        twin->pair[i][p] = (struct pair){UINT32_MAX, INFINITY, 0};
    for (size_t j = 0; j < end; j++) {
        double d2 = vor_distance2f(place(twin, i), place(twin, j));
        double own = (double)twin->reach[i], others = (double)twin->reach[j];
        struct pair pair = {(uint32_t)j, (float)(d2 / 4), 0};
        int p = VOR_LOP_PAIRS;

        if (i != j && stacked(twin, (uint32_t)i, (uint32_t)j, d2))
            continue;
        if (i < twin->begun && others < VOR_LOP_REACH_PART * sqrt(d2))
            continue;
        if (i == j || d2 > own * own || (j > i && d2 <= others * others) ||
            cosine(normal(twin, i), normal(twin, j)) < -VOR_SAME_WAY)
            continue;
        for (size_t k = 0; k < end; k++)
            pair.clearance2 = fminf(pair.clearance2, to_line2(twin, i, j, k));
        pair.key = key_of(twin, i, j, pair.clearance2);
        for (; p > 0 && before(&pair, &twin->pair[i][p - 1]); p--)
            if (p < VOR_LOP_PAIRS)
                twin->pair[i][p] = twin->pair[i][p - 1];
        if (p < VOR_LOP_PAIRS)
            twin->pair[i][p] = pair;
    }
}

/* The mean distance to the nearest few, times the reach of insertion. */
static float reach_of(const struct twin *twin, size_t i)
{
    double nearest[VOR_PATCH_HEXAGON], sum = 0;
    int count = 0;

    for (size_t j = 0; j < twin->begun; j++) {
        double d2 = vor_distance2f(place(twin, i), place(twin, j));
        int at = count < VOR_PATCH_HEXAGON ? count++ : VOR_PATCH_HEXAGON;

        if (j == i) {
            count -= at < VOR_PATCH_HEXAGON;
            continue;
        }
        for (; at > 0 && nearest[at - 1] > d2; at--)
            if (at < VOR_PATCH_HEXAGON)
                nearest[at] = nearest[at - 1];
        if (at < VOR_PATCH_HEXAGON)
            nearest[at] = d2;
    }
    for (int k = 0; k < count; k++)
        sum += sqrt(nearest[k]);
    return (float)(VOR_LOP_PARTNERS * sum / count);
}

/* Lowers the clearances of all pairs to what point k leaves them. */
static void lower_all(struct twin *twin, size_t k)
{
    for (size_t i = 0; i < k; i++)
        for (int p = 0; p < VOR_LOP_PAIRS; p++) {
            struct pair *pair = &twin->pair[i][p];

            if (!(pair->key > 0))
                continue;
            pair->clearance2 = fminf(pair->clearance2, to_line2(twin, i, pair->partner, k));
            pair->key = fminf(pair->key, key_of(twin, i, pair->partner, pair->clearance2));
        }
}

static void insert_one(struct twin *twin)
{
    size_t k = twin->samples.n, best = 0;
    struct vor_lop_point end[2], point;
    struct pair *first = &twin->pair[0][0];
    double clearance;
    float base[3];

    for (size_t i = 0; i < k; i++)
        for (int p = 0; p < VOR_LOP_PAIRS; p++) {
            struct pair *pair = &twin->pair[i][p];

            if (pair->key > first->key || (i == best && before(pair, first))) {
                first = pair;
                best = i;
            }
        }
    for (int l = 0; l < 2; l++) {
        size_t at = l ? first->partner : best;

        memcpy(end[l].xyz, place(twin, at), sizeof end[l].xyz);
        memcpy(end[l].normal, normal(twin, at), sizeof end[l].normal);
    }
    middle(twin, best, first->partner, base);
    if (!vor_lop_latent_put(&point, &twin->latent, base, end) && first->key > FLT_MIN) {
        first->key = FLT_MIN; /* after all others */
        return;
    }
    memcpy(&twin->samples.xyz[3 * k], point.xyz, sizeof point.xyz);
    memcpy(&twin->samples.normal[3 * k], point.normal, sizeof point.normal);
    clearance = sqrt((double)first->clearance2);
    twin->reach[k] =
        (float)fmin(VOR_LOP_PARTNERS * clearance,
                    ((double)twin->reach[best] + (double)twin->reach[first->partner]) / 2);
    first->key = 0;
    lower_all(twin, k);
    find_pairs(twin, k, k + 1);
    twin->samples.n++;
}

static void make_shape(struct vor_lop_samples *out, int shape, double *spacing)
{
    if (shape % 3 == 0)
        vt_lop_cube(out, BEGUN_MAX, (uint64_t)shape, spacing);
    else if (shape % 3 == 1)
        vt_lop_sphere(out, 300, spacing);
    else
        vt_lop_wedge(out, 100, BEGUN_MAX, (uint64_t)shape, spacing);
    for (size_t i = 0; i < out->n; i += 7) /* normals that no other sample agrees with */
        memcpy(&out->normal[3 * i], &out->normal[3 * ((i + 55) % out->n)], 3 * sizeof(float));
}

static void open_twin(struct twin *twin, int shape, const struct vor_lop_insert_how *how,
                      const struct vor_run *run)
{
    struct vor_lop_samples made;
    double spacing;

    make_shape(&made, shape, &spacing);
    vt_assert_ok(vor_lop_samples_init(&twin->samples, MANY, &vt_memory, &vt_err));
    memcpy(twin->samples.xyz, made.xyz, 3 * made.n * sizeof(float));
    memcpy(twin->samples.normal, made.normal, 3 * made.n * sizeof(float));
    twin->samples.n = twin->begun = made.n;
    twin->rho = how->rho;
    vor_lop_samples_free(&made);
    vt_assert_ok(vor_lop_latent_init(&twin->latent, &twin->samples, how->sigma_n, how->sigma_p, run,
                                     &vt_err));
    for (size_t i = 0; i < twin->begun; i++)
        twin->reach[i] = reach_of(twin, i);
    for (size_t i = 0; i < twin->begun; i++)
        find_pairs(twin, i, twin->begun);
}

VT_TEST_LOOP(points_come_in_the_order_that_looking_at_every_pair_gives, VT_SOAK_LOOPS(9, 60))
{
    static const double rho[] = {0, 5, 2.5};
    static struct twin twin;
    struct vor_domain domain = {.unit = 1};
    struct vor_lop_insert_how how = {.rho = rho[_i / 3 % 3], .sigma_n = 15 * pi / 180};
    struct vor_lop_samples samples;
    struct vor_outcome told;
    struct vt_engine engine;
    double spacing;

    memset(&told, 0, sizeof told);
    make_shape(&samples, _i, &spacing);
    how.sigma_p = 2 * spacing;
    vt_engine_open(&engine, 2);
    how.spec = &engine.spec;
    open_twin(&twin, _i, &how, &engine.run);
    while (twin.samples.n < MANY)
        insert_one(&twin);
    vt_assert_ok(vor_lop_insert(&samples, MANY, &how, &domain, &told, &engine.run, &vt_err));
    vt_engine_close(&engine);
    for (size_t i = 0; i < MANY; i++) {
        ck_assert_mem_eq(&samples.xyz[3 * i], place(&twin, i), 3 * sizeof(float));
        ck_assert_mem_eq(&samples.normal[3 * i], normal(&twin, i), 3 * sizeof(float));
    }
    vor_lop_samples_free(&samples);
    vor_lop_samples_free(&twin.samples);
    vor_lop_latent_free(&twin.latent);
}
