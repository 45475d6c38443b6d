/* Clouds that are hardly clouds: exactly the points asked for and no NaN, or a status that says why
 * (RELIABILITY T5, G10). */
#include "tests/support/vt_ask.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { N = 400 };

static float unit(size_t i, size_t c)
{
    return (float)vt_unit(5, 3 * i + c);
}

/* Coordinate c of point i of a shape. */
#define SHAPE(name, value)                                                                         \
    static float name(size_t i, size_t c)                                                          \
    {                                                                                              \
        (void)i;                                                                                   \
        return (float)(value);                                                                     \
    }

SHAPE(two_far_clusters, 0.1f * unit(i, c) + (i % 2 && c == 0 ? 1000 : 0))
SHAPE(two_very_far_clusters, unit(i, c) + (i % 2 ? 1e9f : 0))
SHAPE(one_far_outlier, i == 77 && c == 1 ? 1e9f : unit(i, c))
SHAPE(denormals, unit(i, c) * 1e-40f)
SHAPE(tiny, unit(i, c) * 1e-36f)
SHAPE(huge, (2 * unit(i, c) - 1) * 1e38f)
SHAPE(largest, unit(i, c) < 0.5f ? -FLT_MAX : FLT_MAX)
SHAPE(corners, i >> c & 1)
SHAPE(coplanar, c == 2 ? 7 : unit(i, c))
SHAPE(tilted_plane, c == 2 ? unit(i, 0) + 2 * unit(i, 1) : unit(i, c))
SHAPE(half_duplicates, unit(i / 2, c))
SHAPE(hundredfold_duplicates, unit(i / 100, c))
SHAPE(grid, c == 0 ? i % 25 : c == 1 ? i / 25 : 0)
SHAPE(solid_grid, c == 0 ? i % 8 : c == 1 ? i / 8 % 8 : i / 64)
SHAPE(ribbon, c == 0 ? 100 * unit(i, c) : c == 1 ? 1e-3f * unit(i, c) : 0)
SHAPE(needle, c == 0 ? 100 * unit(i, c) : 1e-5f * unit(i, c))
SHAPE(cross, c == i % 2 ? 2 * unit(i, c) - 1 : 0)
SHAPE(circle, c == 0 ? cos((double)i) : c == 1 ? sin((double)i) : 0)
SHAPE(helix, c == 0 ? cos(0.1 * (double)i) : c == 1 ? sin(0.1 * (double)i) : 0.01 * (double)i)
SHAPE(parallel_sheets, c == 2 ? 1e-4f * (float)(i % 2) : unit(i, c))
SHAPE(solid_ball, (float)vt_normal(5, 3 * i + c))
SHAPE(line_and_a_point, i == 3 ? (float)(c == 1) : c == 0 ? unit(i, c) : 0)
SHAPE(gathered, powf(unit(i, c), 12))
SHAPE(shifted, unit(i, c) + (c == 2 ? 0 : 6e6f))
SHAPE(mixed_scales, ldexpf(unit(i, c), -(int)(i % 60)))
SHAPE(crossing_planes, c == i % 2 ? 0.5f : unit(i, c))
SHAPE(pairs, unit(i / 2, c) + 1e-6f * (float)(i % 2))
SHAPE(one_place, (float)c)
SHAPE(line, (c == 0) ? unit(i, 0) : 0)
SHAPE(slanted_line, i *(c + 1))
SHAPE(two_places, i % 2 * (c + 1))
SHAPE(three_places, i % 3 == c)

/* must: 1 a result, 0 a refusal, -1 either. */
static const struct {
    const char *name;
    float (*at)(size_t i, size_t c);
    int must;
} shapes[] = {{"two far clusters", two_far_clusters, 1},
              {"two very far clusters", two_very_far_clusters, -1},
              {"one far outlier", one_far_outlier, -1},
              {"denormals", denormals, -1},
              {"tiny", tiny, 1},
              {"huge", huge, 1},
              {"largest", largest, -1},
              {"corners", corners, 1},
              {"coplanar", coplanar, 1},
              {"tilted plane", tilted_plane, 1},
              {"half duplicates", half_duplicates, 1},
              {"hundredfold duplicates", hundredfold_duplicates, 1},
              {"grid", grid, 1},
              {"solid grid", solid_grid, 1},
              {"ribbon", ribbon, -1},
              {"needle", needle, -1},
              {"cross", cross, -1},
              {"circle", circle, 1},
              {"helix", helix, 1},
              {"parallel sheets", parallel_sheets, 1},
              {"solid ball", solid_ball, 1},
              {"line and a point", line_and_a_point, -1},
              {"gathered", gathered, 1},
              {"shifted", shifted, -1},
              {"mixed scales", mixed_scales, 1},
              {"crossing planes", crossing_planes, 1},
              {"pairs", pairs, 1},
              {"one place", one_place, 0},
              {"line", line, 0},
              {"slanted line", slanted_line, 0},
              {"two places", two_places, 0},
              {"three places", three_places, 0}};

enum { SHAPES = sizeof shapes / sizeof shapes[0] };

static void assert_result(const struct vor_cloud *out, const struct vor_report *report, size_t n,
                          const char *name)
{
    ck_assert_msg(out->n == n, "%s: %zu points, want %zu", name, out->n, n);
    for (size_t i = 0; i < 3 * n; i++)
        ck_assert_msg(isfinite(out->xyz[i]), "%s: coordinate %zu is %g", name, i,
                      (double)out->xyz[i]);
    ck_assert_msg(isfinite(report->delta) && isfinite(report->spacing_mean) &&
                      isfinite(report->epsilon) && isfinite(report->sigma) &&
                      isfinite(report->area),
                  "%s: the report is not finite", name);
}

static void run_shape(int shape, size_t points, size_t n, const char *boundary)
{
    const char *name = shapes[shape].name;
    struct vt_engine engine;
    struct vor_cloud in, out;
    struct vor_report report;
    vor_status status;

    vt_cloud_make(&in, points);
    for (size_t i = 0; i < 3 * points; i++)
        in.xyz[i] = shapes[shape].at(i / 3, i % 3);
    vt_assert_ok(vor_cloud_check(&in, &vt_err));
    vt_engine_open(&engine, 2);
    vt_engine_count(&engine, "points", n);
    vt_ask_set(&engine, "iterations=4 polish=6 normals=fit");
    vt_engine_set(&engine, "boundary", boundary);
    vor_cloud_init(&out, &vt_memory);
    status = vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err);
    if (status == VOR_OK) {
        ck_assert_msg(shapes[shape].must != 0, "%s: a result of what has no surface", name);
        assert_result(&out, &report, n, name);
    } else {
        ck_assert_msg(status == VOR_E_DEGENERATE, "%s: %s", name, vt_err.message);
        ck_assert_msg(shapes[shape].must != 1, "%s, %zu of %zu: %s", name, n, points,
                      vt_err.message);
        ck_assert(vt_err.message[0] != '\0' && out.n == 0);
    }
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}

VT_TEST_LOOP(a_strange_cloud_gives_exactly_the_points_asked_for_or_says_why_not, VT_ONCE(SHAPES))
{
    run_shape(_i, N, 100, "keep");
    run_shape(_i, N, 100, "free");
    run_shape(_i, N, N + 1, "keep");
    run_shape(_i, N, 5, "keep");
    run_shape(_i, N, 1, "keep");
}

VT_TEST(a_cloud_without_a_surface_is_refused_at_every_size)
{
    for (int shape = 0; shape < SHAPES; shape++)
        for (size_t points = 1; points <= 3; points++) {
            struct vt_engine engine;
            struct vor_cloud in, out;
            struct vor_report report;

            vt_cloud_make(&in, points);
            for (size_t i = 0; i < 3 * points; i++)
                in.xyz[i] = shapes[shape].at(i / 3, i % 3);
            vt_engine_open(&engine, 1);
            vt_engine_set(&engine, "points", "3");
            vor_cloud_init(&out, &vt_memory);
            vt_assert_fails(VOR_E_DEGENERATE,
                            vt_run_engine(&out, &report, &in, &engine.spec, &engine.run, &vt_err));
            ck_assert_ptr_nonnull(strstr(vt_err.message, "at least 4"));
            vor_cloud_free(&in);
            vt_engine_close(&engine);
            vt_assert_no_leak();
        }
}

/* The corners of a square: as small as a surface gets. */
VT_TEST(four_points_make_one_to_sixty_four)
{
    for (size_t n = 1; n <= 64; n += 7) {
        static const float square[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
        struct vt_engine engine;
        struct vor_cloud in, out;
        struct vor_report report;

        vt_cloud_make(&in, 4);
        memcpy(in.xyz, square, sizeof square);
        vt_engine_open(&engine, 1);
        vt_engine_count(&engine, "points", n);
        vt_engine_resample(&engine, &out, &report, &in);
        assert_result(&out, &report, n, "square");
        for (size_t i = 0; i < n; i++)
            ck_assert(out.xyz[3 * i + 2] == 0);
        vor_cloud_free(&out);
        vor_cloud_free(&in);
        vt_engine_close(&engine);
    }
}
