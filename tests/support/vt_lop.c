#include "tests/support/vt_lop.h"

#include <math.h>

/* Part of a lattice's pitch that samples are jittered by, to either side. */
#define JITTER 0.25

static const double pi = 3.14159265358979323846;

static void add(struct vor_lop_samples *out, const double xyz[3], const double normal[3])
{
    ck_assert_uint_lt(out->n, out->room);
    for (size_t c = 0; c < 3; c++) {
        out->xyz[3 * out->n + c] = (float)xyz[c];
        out->normal[3 * out->n + c] = (float)normal[c];
    }
    out->n++;
}

static double jittered(uint64_t seed, uint64_t index)
{
    return JITTER * (2 * vt_unit(seed, index) - 1);
}

void vt_lop_wedge_normals(double degrees, double out[2][3])
{
    double lean = (180 - degrees) / 2 * pi / 180; /* of each side against the plane z = 0 */

    for (int side = 0; side < 2; side++) {
        out[side][0] = (side ? 1 : -1) * sin(lean);
        out[side][1] = 0;
        out[side][2] = cos(lean);
    }
}

void vt_lop_wedge(struct vor_lop_samples *out, double degrees, size_t n, uint64_t seed,
                  double *spacing)
{
    double h = 1 / sqrt((double)n), normal[2][3], xyz[3];
    size_t rows = (size_t)(0.5 / h), columns = (size_t)(1 / h);
    uint64_t random = 0;

    vt_lop_wedge_normals(degrees, normal);
    vt_assert_ok(vor_lop_samples_init(out, 2 * rows * columns, &vt_memory, &vt_err));
    for (int side = 0; side < 2; side++)
        for (size_t row = 0; row < rows; row++)
            for (size_t column = 0; column < columns; column++, random += 2) {
                double away = ((double)row + 0.75 + jittered(seed, random)) * h;

                xyz[0] = (side ? 1 : -1) * away * normal[side][2];
                xyz[1] = ((double)column + 0.5 + jittered(seed, random + 1)) * h - 0.5;
                xyz[2] = -away * fabs(normal[side][0]);
                add(out, xyz, normal[side]);
            }
    *spacing = h;
}

void vt_lop_cube(struct vor_lop_samples *out, size_t n, uint64_t seed, double *spacing)
{
    size_t side = (size_t)sqrt((double)n / 6);
    double h = 1.2 / (double)side;
    uint64_t random = 0;

    vt_assert_ok(vor_lop_samples_init(out, 6 * side * side, &vt_memory, &vt_err));
    for (int face = 0; face < 6; face++)
        for (size_t i = 0; i < side * side; i++, random += 2) {
            double normal[3] = {0}, xyz[3];
            int axis = face / 2;

            normal[axis] = face % 2 ? 1 : -1;
            xyz[axis] = 0.6 * normal[axis];
            xyz[(axis + 1) % 3] = ((double)(i / side) + 0.5 + jittered(seed, random)) * h - 0.6;
            xyz[(axis + 2) % 3] = ((double)(i % side) + 0.5 + jittered(seed, random + 1)) * h - 0.6;
            add(out, xyz, normal);
        }
    *spacing = h;
}

void vt_lop_sphere(struct vor_lop_samples *out, size_t n, double *spacing)
{
    double golden = pi * (3 - sqrt(5.0));

    vt_assert_ok(vor_lop_samples_init(out, n, &vt_memory, &vt_err));
    for (size_t i = 0; i < n; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)n, r = sqrt(1 - z * z);
        double normal[3] = {r * cos(golden * (double)i), r * sin(golden * (double)i), z};
        double xyz[3] = {0.9 * normal[0], 0.9 * normal[1], 0.9 * normal[2]};

        add(out, xyz, normal);
    }
    *spacing = 0.9 * sqrt(4 * pi / (double)n);
}

void vt_lop_square(struct vor_lop_samples *out, size_t side, double z, double facing, double hole,
                   uint64_t seed)
{
    double normal[3] = {0, 0, facing}, h = 1 / (double)side;

    for (size_t i = 0; i < side * side; i++) {
        double xyz[3] = {((double)(i / side) + 0.5 + jittered(seed, 2 * i)) * h - 0.5,
                         ((double)(i % side) + 0.5 + jittered(seed, 2 * i + 1)) * h - 0.5, z};

        if (hypot(xyz[0], xyz[1]) >= hole)
            add(out, xyz, normal);
    }
}
