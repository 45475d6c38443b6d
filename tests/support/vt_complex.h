/** Complexes of triangles, made. */
#ifndef VT_COMPLEX_H
#define VT_COMPLEX_H

#include "core/mesh/complex.h"
#include "tests/support/vt.h"

/** Adds two triangles for each square of a lattice of side x side points, numbered row by row from
 *  `first` on. */
static inline void vt_complex_lattice(struct vor_complex *complex, uint32_t first, uint32_t side)
{
    for (uint32_t row = 0; row + 1 < side; row++)
        for (uint32_t column = 0; column + 1 < side; column++) {
            uint32_t at = first + row * side + column;

            vt_assert_ok(
                vor_complex_add(complex, (const uint32_t[]){at, at + 1, at + side}, &vt_err));
            vt_assert_ok(vor_complex_add(
                complex, (const uint32_t[]){at + 1, at + side + 1, at + side}, &vt_err));
        }
}

#endif
