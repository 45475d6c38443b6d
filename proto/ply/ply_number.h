/** Numbers in ascii PLY files: decimal, bounded, correctly rounded. */
#ifndef VOR_PROTO_PLY_NUMBER_H
#define VOR_PROTO_PLY_NUMBER_H

#include "core/cloud/cloud.h"

#include <stddef.h>
#include <stdint.h>

/** Longest number that is read, in bytes: longer than any double's exact digits are in practice. */
enum { VOR_PLY_NUMBER_MAX = 127 };

enum vor_ply_number {
    VOR_PLY_NUMBER_OK,
    VOR_PLY_NUMBER_JUNK,     /**< not a number, or not a whole one for a type of integers */
    VOR_PLY_NUMBER_RANGE,    /**< a number that the type cannot hold */
    VOR_PLY_NUMBER_NONFINITE /**< nan or inf in a type that has them; *out is set */
};

/** Reads a whole token as a scalar of type and stores it at out (vor_type_size bytes, any
 *  alignment). A token is [+-] digits [. digits] [e [+-] digits] with at least one digit before the
 *  e, of a whole number for types of integers; for the others also nan, inf or infinity, or what C
 *  libraries print for these: nan(ind), 1.#QNAN, 1.#IND, 1.#INF. What is too small for a type of
 *  floats becomes 0.
 *
 *  The program must be in the "C" locale. Cost: O(length), no memory. */
enum vor_ply_number vor_ply_number_read(const uint8_t *token, size_t length, enum vor_type type,
                                        void *out);

#endif
