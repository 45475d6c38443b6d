/* The cells of a result as polygons: areas, corners, attributes. */
#include "tests/support/vt_ask.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { IN = 8000, POINTS = 500 };

static void open_soup(struct vt_engine *engine, unsigned threads, size_t points)
{
    vt_engine_open(engine, threads);
    vor_spec_preset(&engine->spec, vor_process_find("mesh"));
    vt_ask_set(engine, "soup=true iterations=6 polish=20");
    if (points > 0)
        vt_engine_count(engine, "points", points);
}

/* The soup of POINTS points on a cloud, with one more parameter. */
static void soup_of(struct vt_meshed *out, const struct vor_cloud *in, const char *name,
                    const char *value)
{
    struct vt_engine engine;

    open_soup(&engine, 2, POINTS);
    if (name != NULL)
        vt_engine_set(&engine, name, value);
    vt_assert_ok(vt_engine_mesh(out, in, &engine));
    vt_engine_close(&engine);
}

static const float *corner(const struct vt_meshed *souped, size_t t, int c)
{
    return &souped->cloud.xyz[3 * (size_t)souped->mesh.triangle[3 * t + (size_t)c]];
}

static void normal_of(const struct vt_meshed *souped, size_t t, double out[3])
{
    const float *a = corner(souped, t, 0), *b = corner(souped, t, 1), *c = corner(souped, t, 2);
    double u[3], v[3];

    for (int d = 0; d < 3; d++) {
        u[d] = (double)b[d] - (double)a[d];
        v[d] = (double)c[d] - (double)a[d];
    }
    for (int d = 0; d < 3; d++)
        out[d] = u[(d + 1) % 3] * v[(d + 2) % 3] - u[(d + 2) % 3] * v[(d + 1) % 3];
}

static double area_of(const struct vt_meshed *souped)
{
    double area = 0, n[3];

    for (size_t t = 0; t < souped->mesh.count; t++) {
        normal_of(souped, t, n);
        area += sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
    }
    return area;
}

/* Every point is the corner of one face, of three or more, whose points follow each other. */
static void assert_sound(const struct vt_meshed *souped)
{
    const struct vor_mesh *mesh = &souped->mesh;
    size_t next = 0, faces = 0;

    for (size_t t = 0, run; t < mesh->count; t += run) {
        run = vor_mesh_run(mesh, t);
        for (size_t r = 0; r < run; r++) {
            ck_assert_uint_eq(mesh->triangle[3 * (t + r)], next);
            ck_assert_uint_eq(mesh->triangle[3 * (t + r) + 1], next + r + 1);
            ck_assert_uint_eq(mesh->triangle[3 * (t + r) + 2], next + r + 2);
        }
        next += run + 2;
        faces++;
    }
    ck_assert_uint_eq(next, souped->cloud.n);
    ck_assert_uint_eq(souped->report.mesh_polygons, faces);
    ck_assert_uint_eq(souped->report.mesh_points, next);
    ck_assert_uint_eq(souped->report.points_out, POINTS);
    ck_assert_int_eq(souped->report.has_mesh, 1);
}

VT_TEST_FIGURES(polygons_cover_a_sphere_and_a_torus, VT_FEWER(VT_SOAK_LOOPS(2, 20)))
{
    for (int shape = 0; shape < VT_SMOOTH; shape++) {
        struct vor_cloud in;
        struct vt_meshed souped;

        vt_shapes[shape].make(&in, (uint64_t)_i, IN);
        soup_of(&souped, &in, NULL, NULL);
        assert_sound(&souped);
        ck_assert_double_eq_tol(area_of(&souped) / vt_shapes[shape].area, 1, 0.02);
        ck_assert_double_lt(vt_off_mean(&vt_shapes[shape], &souped.cloud), 0.02);
        vt_meshed_free(&souped);
        vor_cloud_free(&in);
    }
}

VT_TEST_FIGURES(cells_of_a_square_end_where_it_does, 0)
{
    struct vor_cloud in;
    struct vt_meshed souped;

    vt_cloud_square(&in, 3, IN);
    soup_of(&souped, &in, NULL, NULL);
    assert_sound(&souped);
    ck_assert_uint_eq(souped.report.mesh_polygons, POINTS);
    ck_assert_double_eq_tol(area_of(&souped), 1, 0.05);
    vt_meshed_free(&souped);
    vor_cloud_free(&in);
}

/* Normals are as those of the points, which on a sphere point away from its middle. */
VT_TEST_FIGURES(corners_have_the_values_of_their_point_and_faces_its_side, 0)
{
    struct vor_cloud in;
    struct vt_meshed souped;
    struct vor_attribute *number;
    const struct vor_attribute *normal, *got;

    vt_cloud_sphere(&in, 5, IN);
    vt_assert_ok(vor_cloud_add_attribute(&in, "number", VOR_GENERIC, VOR_UINT32, 1, &number, NULL));
    for (uint32_t i = 0; i < IN; i++)
        memcpy((char *)number->data + i * sizeof i, &i, sizeof i);
    soup_of(&souped, &in, "normals", "fit");
    assert_sound(&souped);
    normal = vor_cloud_find(&souped.cloud, VOR_NORMAL);
    got = vor_cloud_find_name(&souped.cloud, "number");
    ck_assert_ptr_nonnull(normal);
    ck_assert_ptr_nonnull(got);
    for (size_t t = 0; t < souped.mesh.count; t++) {
        uint32_t first = souped.mesh.triangle[3 * t];
        double n[3], cosine = 0;

        normal_of(&souped, t, n);
        for (size_t c = 0; c < 3; c++) {
            uint32_t at = souped.mesh.triangle[3 * t + c];

            ck_assert_double_eq(vor_attribute_scalar(got, at), vor_attribute_scalar(got, first));
            cosine += n[c] * vor_attribute_scalar(normal, 3 * first + c);
            ck_assert_double_eq(vor_attribute_scalar(normal, 3 * at + c),
                                vor_attribute_scalar(normal, 3 * first + c));
        }
        ck_assert_double_ge(cosine, 0);
    }
    vt_meshed_free(&souped);
    vor_cloud_free(&in);
}
