/** Corners of a border (input/loops.h), and which of them follow each other. */
#ifndef VOR_INPUT_ROWS_H
#define VOR_INPUT_ROWS_H

#include "core/base/run.h"

#include <stddef.h>
#include <stdint.h>

/** A point that an empty disc touches, and the points at which the disc stops when it is turned
 *  around it (geom/opening.h). A point where two borders meet has two corners. */
struct vor_corner {
    uint32_t point;     /**< its number */
    uint32_t end[2];    /**< numbers of those points */
    float middle[2][3]; /**< where the disc's centre is then */
    float outward[3];   /**< unit vector to where the input does not go on */
    float spacing;      /**< of the input here */
};

/** No end: the row stops there. */
#define VOR_ROWS_NO_END SIZE_MAX

/** Joins corners to rows. End e of corner i is number 2 i + e; two ends are joined if the disc of
 *  one corner stops at the other and the other way round, in nearly the same place; then, of the
 *  ends left over, those whose discs nearly agree, the nearest first.
 *
 *  @param[out] mate    2 n: the end that each is joined to, or VOR_ROWS_NO_END
 *  @param[in]  corner  n, in the order of their points
 *  @param[in]  radius  of the discs, in the spacings of their corners
 *
 *  @retval VOR_E_NOMEM 450 bytes for each end left over do not fit
 *
 *  O(n log n), one thread. Depends on nothing but its arguments. */
VOR_NODISCARD vor_status vor_rows_join(size_t *mate, const struct vor_corner *corner, size_t n,
                                       double radius, struct vor_memory *memory,
                                       struct vor_error *err);

#endif
