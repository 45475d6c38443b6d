/* repair=auto: faults that are made by hand in a lattice are mended, and of a mesh the triangles
 * become better, or if it is smooth the cells, the same for any number of threads. */
#include "core/mesh/repair.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

enum { SIDE = 20, IN = 12000, POINTS = 1500 };

/* Six triangles around each point inside. */
static void make_lattice(struct vor_complex *complex, struct vor_seeds *seeds)
{
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        uint32_t r = i / SIDE, c = i % SIDE, up = i + SIDE;
        float x[3] = {4 + 3 * (float)c + 1.5F * (float)(r % 2), 4 + 2.6F * (float)r, 0};

        vor_domain_normalise(seeds->domain, x, &seeds->xyz[3 * (size_t)i]);
        if (r + 1 == SIDE || c + 1 == SIDE)
            continue;
        vt_assert_ok(vor_complex_add(complex, (uint32_t[]){i, i + 1, up + r % 2}, &vt_err));
        vt_assert_ok(vor_complex_add(complex, (uint32_t[]){i + (r + 1) % 2, up + 1, up}, &vt_err));
    }
}

/* Flips an edge, which leaves two pairs of points with five and seven triangles; collapses another
 * and splits a third one, which leaves a point too few and one too many. */
static void make_faults(struct vor_complex *complex, struct vor_seeds *seeds)
{
    const uint32_t a = 5 * SIDE + 4, b = a + 1, c = 14 * SIDE + 14, d = 5 * SIDE + 14;
    uint32_t third[2];

    ck_assert_uint_eq(vor_complex_edge(complex, d, d + 1, third), 2);
    vor_complex_flip(complex, d, d + 1, third);
    for (size_t e = 0; e < 3; e++)
        seeds->xyz[3 * (size_t)b + e] =
            (seeds->xyz[3 * (size_t)c + e] + seeds->xyz[3 * (size_t)(c + 1) + e]) / 2;
    vt_assert_ok(
        vor_complex_split(complex, c, c + 1, b, vor_complex_collapse(complex, a, b), &vt_err));
}

static size_t faults(const struct vor_complex *complex)
{
    size_t found = 0;

    for (uint32_t i = 0; i < complex->n; i++)
        found += vor_complex_surrounds(complex, i) && complex->degree[i] != 6;
    return found;
}

VT_TEST(faults_in_a_lattice_are_mended)
{
    const struct vor_recall how = {.slack = VOR_SEEDS_SLACK};
    struct vt_engine engine;
    struct vor_cloud in;
    struct vor_domain domain;
    struct vor_seeds seeds;
    struct vor_sheet sheet;
    struct vor_complex complex;

    vt_engine_open(&engine, 2);
    vt_cloud_lattice(&in, 70);
    vt_assert_ok(vor_domain_init(&domain, &in, &engine.run, &vt_err));
    vt_assert_ok(vor_seeds_init(&seeds, &domain, SIDE * SIDE, vt_policy, &engine.run, &vt_err));
    vt_assert_ok(vor_complex_init(&complex, seeds.n, &vt_memory, &vt_err));
    make_lattice(&complex, &seeds);
    ck_assert_uint_eq(faults(&complex), 0);
    make_faults(&complex, &seeds);
    ck_assert_uint_eq(faults(&complex), 4 + 3 + 3);
    vt_assert_ok(vor_seeds_index(&seeds, &engine.run, &vt_err));
    vt_assert_ok(vor_sheet_find(&sheet, &seeds, NULL, &engine.run, &vt_err));
    vt_assert_ok(vor_repair(&complex, &sheet, &seeds, 0, &how, &vt_err));
    ck_assert_uint_eq(faults(&complex), 0);
    for (uint32_t i = 0; i < complex.n; i++)
        ck_assert_uint_gt(complex.degree[i], 0);
    vor_complex_free(&complex);
    vor_sheet_free(&sheet);
    vor_seeds_free(&seeds);
    vor_domain_free(&domain);
    vor_cloud_free(&in);
    vt_engine_close(&engine);
}

static void mesh_of(struct vt_meshed *out, const struct vor_cloud *in, unsigned threads,
                    const char *method, const char *repair)
{
    struct vt_engine engine;

    vt_engine_open(&engine, threads);
    vor_spec_preset(&engine.spec, vor_process_find("mesh"));
    vt_engine_count(&engine, "points", POINTS);
    vt_engine_set(&engine, "polish", "30");
    vt_engine_set(&engine, "method", method);
    vt_engine_set(&engine, "repair", repair);
    vt_assert_ok(vt_engine_mesh(out, in, &engine));
    vt_engine_close(&engine);
}

VT_TEST_LOOP(triangles_become_better, VT_SOAK_LOOPS(2, 20))
{
    static void (*const make[])(struct vor_cloud *, uint64_t, size_t) = {
        vt_cloud_sphere, vt_cloud_torus, vt_cloud_square, vt_cloud_box, vt_cloud_box};
    /* The least of 20 seeds: -.0051, -.0051, -.0077, .0119; .0168. */
    static const double more[] = {-0.006, -0.006, -0.010, 0.010, 0.010};

    for (size_t s = 0; s < sizeof make / sizeof *make; s++) {
        int sharp = s == 4; /* sheared; with more shear most faces count as sheets: no repair */
        struct vor_cloud in;
        struct vt_meshed plain, mended[3];

        make[s](&in, sharp ? 1 : (uint64_t)_i + 1, IN);
        for (size_t i = 0; sharp && i < in.n; i++)
            in.xyz[3 * i] += 0.3F * in.xyz[3 * i + 2];
        mesh_of(&plain, &in, 2, "cvt", "none");
        for (unsigned t = 0; t < 3; t++) {
            mesh_of(&mended[t], &in, t + 1, "cvt", "auto");
            ck_assert_uint_eq(vt_cloud_hash(&mended[t].cloud), vt_cloud_hash(&mended[0].cloud));
            ck_assert_uint_eq(mended[t].mesh.count, mended[0].mesh.count);
            ck_assert_mem_eq(mended[t].mesh.triangle, mended[0].mesh.triangle,
                             3 * mended[0].mesh.count * sizeof(uint32_t));
        }
        ck_assert_uint_eq(mended[0].cloud.n, POINTS);
        ck_assert_int_eq(mended[0].report.mesh_manifold, VOR_YES);
        ck_assert_int_eq(mended[0].report.mesh_closed, plain.report.mesh_closed);
        ck_assert_double_eq(mended[0].report.mesh_euler, plain.report.mesh_euler);
        ck_assert(s > 1 || mended[0].report.eta < plain.report.eta); /* neither creases nor */
        ck_assert(s > 1 || mended[0].report.delta < 0.95 * plain.report.delta); /* borders */
        ck_assert_double_gt(mended[0].report.mesh_quality_mean - plain.report.mesh_quality_mean,
                            more[s]);
        ck_assert_double_ge(mended[0].report.mesh_angle_min, s == 2 ? 37 : 44);
        for (unsigned t = 0; t < 3; t++)
            vt_meshed_free(&mended[t]);
        vt_meshed_free(&plain);
        vor_cloud_free(&in);
    }
}

/* Points within .01 of no face of the cube that looks as they do, but for 26 degrees. */
static size_t count_wrong(const struct vor_cloud *cube)
{
    const float *normal = vor_cloud_find(cube, VOR_NORMAL)->data;
    size_t wrong = 0;

    for (size_t i = 0; i < cube->n; i++) {
        double best = -1;

        for (size_t face = 0; face < 6; face++) {
            double x = (double)cube->xyz[3 * i + face % 3], n = (double)normal[3 * i + face % 3];

            if (fabs(face < 3 ? x : 1 - x) < 0.01)
                best = fmax(best, face < 3 ? -n : n);
        }
        wrong += best < 0.9;
    }
    return wrong;
}

/* A method's normals are those of where its points are at last. Of 1,500, 21 to 38 were wrong where
 * points kept theirs as they moved, and 53 to 72 after a repair; at most 6 are. */
VT_TEST_LOOP(normals_go_with_the_surface, VT_SOAK_LOOPS(2, 20))
{
    struct vor_cloud in;
    struct vt_meshed plain, mended[3];

    vt_cloud_box(&in, (uint64_t)_i + 1, IN);
    mesh_of(&plain, &in, 2, "ear", "none");
    for (unsigned t = 0; t < 3; t++) {
        mesh_of(&mended[t], &in, t + 1, "ear", "auto");
        ck_assert_uint_eq(vt_cloud_hash(&mended[t].cloud), vt_cloud_hash(&mended[0].cloud));
    }
    ck_assert_uint_le(count_wrong(&plain.cloud), 6);
    ck_assert_uint_le(count_wrong(&mended[0].cloud), 6);
    ck_assert_double_gt(mended[0].report.mesh_quality_mean, plain.report.mesh_quality_mean + 0.015);
    ck_assert_double_ge(mended[0].report.mesh_angle_min, 44);
    ck_assert_uint_eq(mended[0].cloud.n, POINTS);
    ck_assert_int_eq(mended[0].report.mesh_closed, VOR_YES);
    ck_assert_int_eq(mended[0].report.mesh_manifold, VOR_YES);
    for (unsigned t = 0; t < 3; t++)
        vt_meshed_free(&mended[t]);
    vt_meshed_free(&plain);
    vor_cloud_free(&in);
}
