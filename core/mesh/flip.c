#include "core/mesh/flip.h"

#include "core/base/linalg.h"
#include "core/input/sheet_walk.h"
#include "core/mesh/quality.h"

static double worse(const float *xyz, const uint32_t corner[2][3])
{
    return fmax(vor_triangle_strain(xyz, corner[0]), vor_triangle_strain(xyz, corner[1]));
}

/* Sine of an edge over the tangent planes at its ends, the larger. */
static double steepness(const struct vor_sheet *sheet, uint32_t i, uint32_t j)
{
    const float *a = &sheet->seeds->xyz[3 * (size_t)i], *b = &sheet->seeds->xyz[3 * (size_t)j];
    const float *m = &sheet->normal[3 * (size_t)i], *n = &sheet->normal[3 * (size_t)j];
    double up[2] = {0, 0}, length = sqrt(vor_distance2f(a, b));

    for (int c = 0; c < 3; c++) {
        double d = (double)b[c] - (double)a[c];

        up[0] += d * (double)m[c];
        up[1] += d * (double)n[c];
    }
    return length > 0 ? fmax(fabs(up[0]), fabs(up[1])) / length : 1;
}

/* Whether both triangles face the way that the two before did together. */
static int face_alike(const float *xyz, const uint32_t before[2][3], const uint32_t after[2][3])
{
    double sum[3] = {0, 0, 0}, n[3], length;

    for (int t = 0; t < 2; t++) {
        vor_triangle_normal(n, xyz, before[t]);
        for (int c = 0; c < 3; c++)
            sum[c] += n[c];
    }
    length = sqrt(vor_dot(sum, sum));
    for (int t = 0; t < 2; t++) {
        vor_triangle_normal(n, xyz, after[t]);
        if (!(vor_dot(n, sum) > VOR_SAME_WAY * length * sqrt(vor_dot(n, n))))
            return 0;
    }
    return 1;
}

/* Whether the edge from c to d may take the place of that from a to b: it is no steeper than this
 * one or than walks go over, or it would cut the corner of a crease off. */
int vor_flip_may(const struct vor_complex *complex, const struct vor_sheet *sheet, uint32_t a,
                 uint32_t b, const uint32_t third[2])
{
    uint32_t c = third[0], d = third[1], none[2];
    const uint32_t before[2][3] = {{a, b, c}, {b, a, d}}, after[2][3] = {{a, d, c}, {d, b, c}};

    return complex->degree[c] < VOR_AROUND_MOST && complex->degree[d] < VOR_AROUND_MOST &&
           face_alike(sheet->seeds->xyz, before, after) &&
           steepness(sheet, c, d) <=
               fmax(vor_sheet_arcs[VOR_SHEET_ARCS - 1], steepness(sheet, a, b)) &&
           vor_complex_edge(complex, c, d, none) == 0 && vor_sheet_joins(sheet, c, d);
}

/* Whether the triangles at the edge from c to d are better than those at that from a to b. */
static int pays(const struct vor_sheet *sheet, uint32_t a, uint32_t b, const uint32_t third[2])
{
    uint32_t c = third[0], d = third[1];
    const uint32_t before[2][3] = {{a, b, c}, {b, a, d}}, after[2][3] = {{a, d, c}, {d, b, c}};
    const float *xyz = sheet->seeds->xyz;

    /* rounding flips nothing back and forth */
    return worse(xyz, after) < (1 - VOR_ROUNDED) * worse(xyz, before);
}

/* How far point i is from the triangles that it should have, six or at a loop three, squared, with
 * `more` of them. */
static int off(const struct vor_complex *complex, const unsigned char *surrounded, uint32_t i,
               int more)
{
    int o = complex->degree[i] + more - (surrounded[i] ? 6 : 3);

    return o * o;
}

/* By how much that falls for the ends of the two edges. */
static int gain(const struct vor_complex *complex, const unsigned char *surrounded, uint32_t a,
                uint32_t b, const uint32_t third[2])
{
    int sum = 0;

    for (int k = 0; k < 2; k++) {
        uint32_t from = k == 0 ? a : b;

        if (complex->degree[from] <= (surrounded[from] ? 3 : 1))
            return 0;
        sum += off(complex, surrounded, from, 0) - off(complex, surrounded, from, -1);
        sum += off(complex, surrounded, third[k], 0) - off(complex, surrounded, third[k], 1);
    }
    return sum;
}

size_t vor_flip(struct vor_complex *complex, const struct vor_sheet *sheet,
                const unsigned char *surrounded)
{
    size_t flipped = 0;

    for (size_t i = 0; i < complex->n; i++)
        for (unsigned e = 0; e < 2 * (unsigned)complex->degree[i]; e++) {
            uint32_t a = (uint32_t)i, other[2], third[2];

            vor_complex_others(complex, complex->around[i * VOR_AROUND_MOST + e / 2], a, other);
            if (other[e % 2] < a || vor_complex_edge(complex, a, other[e % 2], third) != 2 ||
                third[0] != other[1 - e % 2] || /* it is looked at from its first triangle */
                !(surrounded != NULL ? gain(complex, surrounded, a, other[e % 2], third) > 0
                                     : pays(sheet, a, other[e % 2], third)) ||
                !vor_flip_may(complex, sheet, a, other[e % 2], third))
                continue;
            vor_complex_flip(complex, a, other[e % 2], third);
            flipped++;
        }
    return flipped;
}
