/* Lists among points that move, against looking at every point: at every step, whoever is asked for
 * and whatever the points did since the lists were made. */
#include "core/base/linalg.h"
#include "core/knn/point_lists.h"
#include "tests/support/vt_engine.h"

#include <math.h>
#include <string.h>

enum { N_MAX = 1400, STEPS = 8, ASKED = 60, SHAPES = 6 };

#define FAR 0.3 /* spacings beyond which a point is a jumper */

struct flock {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_point_lists point_lists;
    struct vor_point_lists_view view;
    size_t n, looked, asked, searches, open;
    float distance2[N_MAX]; /* from the point at hand to each, by looking */
};

/* A cube, a surface, clusters, groups of coincident points, all of them in one place, or a surface
 * so small that jumpers are looked for in a grid. */
static void shape(struct vor_cloud *cloud, int kind, uint64_t seed, size_t n)
{
    size_t group = kind == 3 ? 25 : n;

    if (kind == 1 || kind == 5)
        vt_cloud_sphere(cloud, seed, n);
    else
        vt_cloud_cube(cloud, seed, n);
    for (size_t i = 0; kind == 2 && i < 3 * n; i++)
        cloud->xyz[i] = (float)(1e-3 * (double)cloud->xyz[i] + (double)(i / 3 % 7));
    for (size_t i = 0; kind == 5 && i < 3 * n; i++)
        cloud->xyz[i] *= 0.2f;
    for (size_t i = 0; (kind == 3 || kind == 4) && i < n; i++)
        memcpy(&cloud->xyz[3 * i], &cloud->xyz[3 * (i - i % group)], 3 * sizeof *cloud->xyz);
}

static void open_flock(struct flock *flock, int kind, uint64_t seed, size_t n, unsigned listed)
{
    memset(flock, 0, sizeof *flock);
    vt_engine_open(&flock->engine, 2);
    shape(&flock->cloud, kind, seed, n);
    flock->n = n;
    vt_assert_ok(vor_point_lists_init(&flock->point_lists, n, listed, &vt_memory, &vt_err));
    ck_assert(!vor_point_lists_look(&flock->view, &flock->point_lists, flock->cloud.xyz,
                                    FAR)); /* no lists */
}

static void close_flock(struct flock *flock)
{
    vor_point_lists_free(&flock->point_lists);
    vor_cloud_free(&flock->cloud);
    vt_engine_close(&flock->engine);
}

static void look_from(struct flock *flock, size_t i)
{
    const float *xyz = flock->cloud.xyz;

    for (size_t j = 0; j < flock->n; j++) {
        float x = xyz[3 * i] - xyz[3 * j], y = xyz[3 * i + 1] - xyz[3 * j + 1],
              z = xyz[3 * i + 2] - xyz[3 * j + 2];

        flock->distance2[j] = x * x + y * y + z * z;
    }
}

static double nearest_other(const struct flock *flock, size_t i)
{
    float best = INFINITY;

    for (size_t j = 0; j < flock->n; j++)
        best = j != i && flock->distance2[j] < best ? flock->distance2[j] : best;
    return sqrt((double)best);
}

static int is_jumper(const struct flock *flock, size_t i)
{
    for (unsigned j = 0; j < flock->view.jumpers; j++)
        if (flock->view.jumper[j] == i)
            return 1;
    return 0;
}

/* The look of the swarm at the positions is that of the one who compares each with its anchor. */
static int check_look(struct flock *flock)
{
    const struct vor_point_lists *swarm = &flock->point_lists;
    double limit = FAR * swarm->spacing, drift = 0;
    unsigned far = 0, strangers = 0;
    int use = vor_point_lists_look(&flock->view, swarm, flock->cloud.xyz, FAR);

    for (size_t i = 0; i < flock->n; i++) {
        double moved = sqrt(vor_distance2f(&flock->cloud.xyz[3 * i], &swarm->anchor[3 * i]));

        far += moved > limit;
        drift = moved > limit ? drift : fmax(drift, moved);
        if (use)
            strangers += is_jumper(flock, i) != (moved > limit);
    }
    ck_assert_int_eq(use, far <= VOR_POINT_LISTS_JUMPERS_MIN);
    if (!use)
        return 0;
    ck_assert_uint_eq(strangers, 0);
    ck_assert_uint_eq(flock->view.jumpers, far);
    ck_assert_ptr_eq(flock->view.xyz, flock->cloud.xyz);
    ck_assert_double_eq_tol(flock->view.drift, drift, 1e-12);
    return 1;
}

/* After an index nobody has moved, and the spacing is the mean of the nearest distances; that is
 * looked at once. */
static void index_flock(struct flock *flock)
{
    uint64_t before = flock->point_lists.indexed;
    double sum = 0;

    vt_assert_ok(
        vor_point_lists_index(&flock->point_lists, flock->cloud.xyz, &flock->engine.run, &vt_err));
    ck_assert_uint_eq(flock->point_lists.indexed, before + 1);
    ck_assert(check_look(flock));
    ck_assert(flock->view.jumpers == 0 && flock->view.drift == 0);
    if (before > 0)
        return;
    for (size_t i = 0; i < flock->n; i++) {
        look_from(flock, i);
        sum += nearest_other(flock, i);
    }
    sum /= (double)flock->n;
    ck_assert_double_le(fabs(flock->point_lists.spacing - sum), 1e-6 * sum);
}

static void check_nearest(struct flock *flock, size_t i)
{
    double found = vor_point_lists_nearest(&flock->point_lists, &flock->view, i);

    if (found < 0) {
        ck_assert(found == -1);
        flock->open++;
    } else {
        ck_assert(found == nearest_other(flock, i));
    }
}

/* Marks the points and counts what should not be there: doubles, numbers of no point. */
static unsigned mark(unsigned char *marked, const struct flock *flock, const uint32_t *index,
                     unsigned count)
{
    unsigned wrong = 0;

    memset(marked, 0, N_MAX);
    for (unsigned j = 0; j < count; j++) {
        if (index[j] >= flock->n || marked[index[j]])
            wrong++;
        else
            marked[index[j]] = 1;
    }
    return wrong;
}

static void check_crowd(struct flock *flock, size_t i)
{
    struct vor_crowd crowd, again;
    unsigned char marked[N_MAX];
    unsigned searches = vor_point_lists_crowd(&crowd, &flock->point_lists, &flock->view, i);
    unsigned wrong = mark(marked, flock, crowd.index, crowd.count), missing = 0;
    int anew =
        memcmp(&flock->point_lists.place[3 * i], &flock->cloud.xyz[3 * i], 3 * sizeof(float)) == 0;

    ck_assert_uint_eq(wrong, 0);
    ck_assert(!marked[i]);
    for (unsigned j = 0; j < crowd.count; j++) {
        wrong += crowd.distance2[j] != flock->distance2[crowd.index[j]];
        wrong += j > 0 && crowd.distance2[j] < crowd.distance2[j - 1];
    }
    ck_assert_uint_eq(wrong, 0);
    for (size_t j = 0; j < flock->n; j++)
        missing += j != i && !marked[j] && sqrt((double)flock->distance2[j]) < crowd.sure;
    ck_assert_uint_eq(missing, 0);
    ck_assert_uint_ge(crowd.count, flock->point_lists.listed);
    ck_assert(searches == 0 || (searches == 1 && anew));
    if (flock->point_lists.listed + 1 == flock->n)
        ck_assert(searches == 0 && isinf(crowd.sure));
    else if (crowd.count >= 6 && flock->point_lists.listed >= 6 && !anew)
        ck_assert_double_gt(crowd.sure, 1.4 * sqrt((double)crowd.distance2[5]));
    flock->searches += searches;
    ck_assert_uint_eq(vor_point_lists_crowd(&again, &flock->point_lists, &flock->view, i), 0);
    ck_assert(again.count == crowd.count && again.sure == crowd.sure);
    ck_assert(memcmp(again.distance2, crowd.distance2, crowd.count * sizeof(float)) == 0);
}

static void check_wide(struct flock *flock, size_t i, size_t width)
{
    uint32_t index[N_MAX];
    float scratch[N_MAX];
    unsigned char marked[N_MAX];
    unsigned missing = 0;
    double sure =
        vor_point_lists_wide(&flock->point_lists, &flock->view, i, (unsigned)width, index, scratch);

    ck_assert_uint_eq(mark(marked, flock, index, (unsigned)width), 0);
    for (size_t j = 0; j < flock->n; j++)
        missing += j != i && !marked[j] && !is_jumper(flock, j) &&
                   sqrt((double)flock->distance2[j]) < sure;
    ck_assert_uint_eq(missing, 0);
    ck_assert_int_eq(isinf(sure) != 0, width == flock->n);
}

/* Once lists are renewed no crowd is searched for. */
static void renew(struct flock *flock, uint64_t seed)
{
    uint32_t who[ASKED] = {0};
    struct vor_crowd crowd;
    size_t count = flock->n < ASKED ? flock->n : ASKED, first = seed % (flock->n - count + 1);

    for (size_t a = 0; a < count; a++)
        who[a] = (uint32_t)(first + a);
    (void)vor_point_lists_renew(&flock->point_lists, &flock->view, who, count);
    for (size_t a = 0; a < count; a++)
        ck_assert_uint_eq(vor_point_lists_crowd(&crowd, &flock->point_lists, &flock->view, who[a]),
                          0);
}

/* Asks for some of the points, the jumpers among them. */
static void check_all(struct flock *flock, uint64_t seed)
{
    if (seed % 3 == 0)
        renew(flock, seed);
    for (size_t a = 0; a < ASKED && a < flock->n; a++) {
        size_t i = flock->n <= ASKED ? a : (size_t)vor_rng_below(seed, 61, a, flock->n);
        size_t width = 1 + (size_t)vor_rng_below(seed, 62, a, flock->n);

        if (a < flock->view.jumpers && a < 10)
            i = flock->view.jumper[a];
        look_from(flock, i);
        check_nearest(flock, i);
        check_crowd(flock, i);
        check_nearest(flock, i);
        check_wide(flock, i, a % 16 ? (width < 100 ? width : 1 + width % 100) : flock->n);
        flock->asked++;
    }
}

/* Every point goes up to `step` spacings, `jumpers` of them somewhere else altogether: beside
 * another point, or onto it. */
static void wander(struct flock *flock, uint64_t seed, double step, size_t jumpers)
{
    float *xyz = flock->cloud.xyz;

    step *= flock->point_lists.spacing / sqrt(3);
    for (size_t i = 0; i < 3 * flock->n; i++)
        xyz[i] += (float)(step * (2 * vt_unit(seed, i) - 1));
    for (size_t j = 0; j < jumpers; j++) {
        size_t who = (size_t)vor_rng_below(seed, 63, j, flock->n);
        size_t where = (size_t)vor_rng_below(seed, 64, j, flock->n);

        for (size_t c = 0; c < 3; c++)
            xyz[3 * who + c] =
                xyz[3 * where + c] +
                (float)(j % 3 ? 0.5 * flock->point_lists.spacing * vt_unit(seed + 1, 3 * j + c)
                              : 0);
    }
}

static void walk(struct flock *flock, uint64_t seed, double step, size_t jumpers)
{
    index_flock(flock);
    check_all(flock, seed);
    for (uint64_t s = 1; s <= STEPS; s++) {
        wander(flock, 100 * seed + 2 * s, step, s % 3 == 1 ? jumpers : 0);
        if (!check_look(flock))
            index_flock(flock);
        else
            flock->looked++;
        check_all(flock, seed + s);
    }
}

VT_TEST_LOOP(lists_tell_what_a_look_at_every_point_does, VT_FEWER(28))
{
    static const size_t counts[7] = {2, 3, 8, 21, 60, 400, N_MAX};
    static const unsigned most[3] = {20, 6, VOR_POINT_LISTS_LISTED_MAX};
    static const double steps[4] = {0, 0.01, 0.1, 0.8};
    static const size_t jumpers[4] = {0, 5, 40, 70};
    size_t n = counts[_i % 7];

    for (int kind = 0; kind < SHAPES; kind++)
        for (int s = 0; s < 4; s++) {
            static struct flock flock;
            unsigned listed = most[(_i + s) % 3];

            listed = listed < n ? listed : (unsigned)n - 1;
            open_flock(&flock, kind, (uint64_t)_i, n, listed);
            walk(&flock, (uint64_t)(10 * _i + s), steps[s], jumpers[(s + _i / 7) % 4]);
            close_flock(&flock);
        }
}

/* On a surface, or they would be of no use: the index is not made anew, and hardly searched. */
VT_TEST_LOOP(small_steps_are_answered_from_the_lists, 5)
{
    static struct flock flock;

    open_flock(&flock, 1, (uint64_t)_i, 1000, 20);
    walk(&flock, (uint64_t)_i, 0.02, 20);
    ck_assert_uint_eq(flock.point_lists.indexed, 1);
    ck_assert_uint_eq(flock.looked, STEPS);
    ck_assert_uint_le(flock.searches, flock.asked / 10);
    ck_assert_uint_le(flock.open, flock.asked / 10);
    close_flock(&flock);
}
