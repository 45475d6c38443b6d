/* Triangles that pass through others: beside a twin that looks at all pairs. */
#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/mesh/crossing.h"
#include "tests/support/vt_complex.h"
#include "tests/support/vt_engine.h"

#include <string.h>

enum { SIDE = 24, EACH = SIDE * SIDE, N = 2 * EACH, TRIANGLES = 4 * (SIDE - 1) * (SIDE - 1) };

/* Two uneven lattices that cross along the line x = 0.5, one of them slanted. */
struct bed {
    struct vt_engine engine;
    struct vor_domain domain;
    struct vor_graph graph;
    struct vor_seeds seeds;
    struct vor_sheet sheet;
    struct vor_complex complex;
    float xyz[3 * N];
};

static void start(struct bed *bed, unsigned threads, uint64_t seed, int sheets)
{
    memset(bed, 0, sizeof *bed);
    vt_engine_open(&bed->engine, threads);
    for (size_t i = 0; i < N; i++) {
        float *x = &bed->xyz[3 * i];
        size_t k = i % EACH, row = k / SIDE;

        x[0] = (float)(((double)(k % SIDE) + 0.4 * vor_rng_unit(seed, 1, 2 * i)) / SIDE);
        x[1] = (float)(((double)row + 0.4 * vor_rng_unit(seed, 1, 2 * i + 1)) / SIDE);
        x[2] = i < EACH ? 0 : (float)(0.3 * ((double)x[0] - 0.5));
    }
    bed->domain.known.grown = bed->domain.known.sheets = sheets;
    bed->seeds.n = N;
    bed->seeds.xyz = bed->xyz;
    bed->seeds.domain = &bed->domain;
    bed->sheet.seeds = &bed->seeds;
    bed->sheet.graph = &bed->graph;
    vt_assert_ok(vor_complex_init(&bed->complex, N, &vt_memory, &vt_err));
    vt_complex_lattice(&bed->complex, 0, SIDE);
    vt_complex_lattice(&bed->complex, EACH, SIDE);
}

static void end(struct bed *bed)
{
    vor_complex_free(&bed->complex);
    vt_engine_close(&bed->engine);
    vt_assert_no_leak();
}

/* Moller and Trumbore 1997: whether the edge from a to b meets triangle t. */
static int meets(const struct bed *bed, uint32_t a, uint32_t b, const uint32_t t[3])
{
    double e[2][3], d[3], o[3], p[3], q[3], det, u, v, w;

    for (int c = 0; c < 3; c++) {
        double corner = (double)bed->xyz[3 * t[0] + (size_t)c];

        e[0][c] = (double)bed->xyz[3 * t[1] + (size_t)c] - corner;
        e[1][c] = (double)bed->xyz[3 * t[2] + (size_t)c] - corner;
        o[c] = (double)bed->xyz[3 * a + (size_t)c] - corner;
        d[c] = (double)bed->xyz[3 * b + (size_t)c] - (double)bed->xyz[3 * a + (size_t)c];
    }
    vor_cross(p, d, e[1]);
    det = vor_dot(e[0], p);
    u = vor_dot(o, p) / det;
    vor_cross(q, o, e[0]);
    v = vor_dot(d, q) / det;
    w = vor_dot(e[1], q) / det;
    return det != 0 && u > 0 && v > 0 && u + v < 1 && w > 0 && w < 1;
}

static int cross(const struct bed *bed, const uint32_t s[3], const uint32_t t[3])
{
    for (int c = 0; c < 3; c++)
        if (meets(bed, s[c], s[(c + 1) % 3], t) || meets(bed, t[c], t[(c + 1) % 3], s))
            return 1;
    return 0;
}

/* Marks those of the first triangles that pass through one of the other lattice. */
static size_t mark(const struct bed *bed, unsigned char marked[TRIANGLES])
{
    const uint32_t *triangle = bed->complex.triangle;
    size_t count = 0;

    memset(marked, 0, TRIANGLES);
    for (size_t s = 0; s < TRIANGLES; s++)
        for (size_t t = s + 1; t < TRIANGLES; t++)
            if (triangle[3 * s] != VOR_COMPLEX_GONE && triangle[3 * t] != VOR_COMPLEX_GONE &&
                (triangle[3 * s] < EACH) != (triangle[3 * t] < EACH) &&
                cross(bed, &triangle[3 * s], &triangle[3 * t]))
                marked[s] = marked[t] = 1;
    for (size_t t = 0; t < TRIANGLES; t++)
        count += marked[t];
    return count;
}

/* Points that lose triangles may have two fans then, of which the larger stays. */
START_TEST(triangles_that_pass_through_others_go_and_no_more)
{
    static struct bed bed;
    unsigned char marked[TRIANGLES], left[TRIANGLES];
    size_t crossing, gone = 0;

    start(&bed, 2, (uint64_t)_i, 1);
    crossing = mark(&bed, marked);
    ck_assert_uint_gt(crossing, 2 * SIDE);
    vt_assert_ok(vor_crossing_drop(&bed.complex, &bed.sheet, &bed.engine.run, &vt_err));
    for (size_t t = 0; t < TRIANGLES; t++) {
        int is_gone = bed.complex.triangle[3 * t] == VOR_COMPLEX_GONE;

        ck_assert_msg(is_gone || !marked[t], "triangle %zu passes through another and stays", t);
        gone += (size_t)is_gone;
    }
    ck_assert_uint_eq(mark(&bed, left), 0);
    ck_assert_msg(10 * gone <= 11 * crossing, "%zu are gone, %zu cross", gone, crossing);
    end(&bed);
}
END_TEST

START_TEST(without_sheets_all_triangles_stay)
{
    static struct bed bed;

    start(&bed, 1, 1, 0);
    vt_assert_ok(vor_crossing_drop(&bed.complex, &bed.sheet, &bed.engine.run, &vt_err));
    for (size_t t = 0; t < TRIANGLES; t++)
        ck_assert(bed.complex.triangle[3 * t] != VOR_COMPLEX_GONE);
    end(&bed);
}
END_TEST

START_TEST(one_and_three_threads_leave_the_same_triangles)
{
    static struct bed one, three;

    start(&one, 1, (uint64_t)_i, 1);
    start(&three, 3, (uint64_t)_i, 1);
    vt_assert_ok(vor_crossing_drop(&one.complex, &one.sheet, &one.engine.run, &vt_err));
    vt_assert_ok(vor_crossing_drop(&three.complex, &three.sheet, &three.engine.run, &vt_err));
    ck_assert_mem_eq(one.complex.triangle, three.complex.triangle,
                     3 * TRIANGLES * sizeof *one.complex.triangle);
    vor_complex_free(&one.complex);
    vt_engine_close(&one.engine);
    end(&three);
}
END_TEST

static vor_status try_drop(void *ctx)
{
    struct bed *bed = ctx;

    return vor_crossing_drop(&bed->complex, &bed->sheet, &bed->engine.run, &vt_err);
}

START_TEST(memory_that_ends_is_an_error_and_leaks_nothing)
{
    static struct bed bed;

    start(&bed, 1, 1, 1);
    vt_fail_each(try_drop, &bed);
    end(&bed);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("crossing");

    vt_add_figures(suite, triangles_that_pass_through_others_go_and_no_more, 2);
    vt_add(suite, without_sheets_all_triangles_stay);
    vt_add_loop(suite, one_and_three_threads_leave_the_same_triangles, 1);
    vt_add(suite, memory_that_ends_is_an_error_and_leaks_nothing);
    return vt_run(suite);
}
