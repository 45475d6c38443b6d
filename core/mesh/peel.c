#include "core/mesh/peel.h"

#include "core/base/linalg.h"

vor_status vor_peel(struct vor_complex *complex, struct vor_error *err)
{
    unsigned char *border = vor_calloc(complex->memory, complex->n, 1);

    if (border == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", complex->n);
    for (size_t t = 0; t < complex->count; t++)
        for (int c = 0; c < 3 && complex->triangle[3 * t] != VOR_COMPLEX_GONE; c++)
            if (vor_complex_is_open(complex, t, c)) {
                border[complex->triangle[3 * t + (size_t)c]] = 1;
                border[complex->triangle[3 * t + (size_t)(c + 1) % 3]] = 1;
            }
    for (size_t t = 0; t < complex->count; t++) {
        const uint32_t *corner = &complex->triangle[3 * t];

        if (corner[0] != VOR_COMPLEX_GONE &&
            (border[corner[0]] || border[corner[1]] || border[corner[2]]))
            vor_complex_remove(complex, (uint32_t)t);
    }
    vor_complex_prune(complex);
    vor_free(complex->memory, border);
    return VOR_OK;
}

/* Cosine of the angle at x between the ways to a and b. */
static double cosine_at(const float *x, const float *a, const float *b)
{
    double to_a[3], to_b[3];

    vor_way(to_a, x, a);
    vor_way(to_b, x, b);
    return vor_dot(to_a, to_b) / sqrt(fmax(vor_dot(to_a, to_a) * vor_dot(to_b, to_b), 1e-300));
}

void vor_peel_notches(struct vor_complex *complex, const float *xyz)
{
    for (size_t t = 0; t < complex->count; t++) {
        const uint32_t *corner = &complex->triangle[3 * t];

        for (int c = 0; c < 3 && corner[0] != VOR_COMPLEX_GONE; c++) {
            const float *x = &xyz[3 * (size_t)corner[(c + 2) % 3]];

            if (vor_complex_is_open(complex, t, c) &&
                !vor_complex_is_open(complex, t, (c + 1) % 3) &&
                !vor_complex_is_open(complex, t, (c + 2) % 3) &&
                cosine_at(x, &xyz[3 * (size_t)corner[c]], &xyz[3 * (size_t)corner[(c + 1) % 3]]) <
                    VOR_PEEL_BLUNT)
                vor_complex_remove(complex, (uint32_t)t);
        }
    }
}
