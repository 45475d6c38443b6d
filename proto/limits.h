/** What a decoder may allocate and accept before it has seen the data. */
#ifndef VOR_PROTO_LIMITS_H
#define VOR_PROTO_LIMITS_H

#include "core/spec.h"

#include <stddef.h>

struct vor_limits {
    size_t points; /**< most points a cloud may declare; more is VOR_E_LIMIT before decoding */
    size_t header_bytes; /**< of a PLY header */
    int strict_draco;    /**< of Draco only point clouds of bitstream 2.3 without metadata */
    int drop_invalid;    /**< leave out points that are not finite; 0: VOR_E_NONFINITE */
    int keep_doubles;    /**< keep coordinates that a cloud's positions do not hold (exact) */
    int keep_faces; /**< enum vor_spec_faces; needed ones are refused with VOR_E_FACES where a file
                       has none, and kept ones say which triangles are a polygon. At most two
                       triangles for each of `points` */
};

/** Sets what a job needs of its clouds: drop_invalid, keep_doubles and keep_faces. */
void vor_limits_want(struct vor_limits *limits, const struct vor_spec *spec);

#define VOR_LIMITS_DEFAULT                                                                         \
    {                                                                                              \
        .points = 50000000, .header_bytes = 65536                                                  \
    }

#endif
