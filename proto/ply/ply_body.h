/** The rows behind a PLY header: skipping an element, reading one into columns. */
#ifndef VOR_PROTO_PLY_BODY_H
#define VOR_PROTO_PLY_BODY_H

#include "proto/ply/ply_header.h"

#include <stddef.h>
#include <stdint.h>

/** Where one property of every row goes. */
struct vor_ply_column {
    const struct vor_ply_property *property;
    int coordinate;        /**< 0 .. 2 for x y z; else -1 */
    enum vor_type to_type; /**< FLOAT32 or FLOAT64 for a coordinate, else the property's own */
    uint8_t *to;           /**< of row 0; NULL: read over it (every list) */
    size_t to_stride;
};

struct vor_ply_rows {
    size_t n;
    unsigned column_count;
    struct vor_ply_column columns[VOR_PLY_PROPERTIES_MAX];
};

/** The file and how far it has been read; at <= size always. */
struct vor_ply_body {
    const uint8_t *bytes;
    size_t size, at;
    enum vor_ply_encoding encoding;
    size_t not_finite; /**< where the first coordinate is that is not finite; 0 for none */
};

/** Checks that count rows of the element can be in the rest of the file, so that what is allocated
 *  for them is bounded by the file's size.
 *
 *  @retval VOR_E_FORMAT they cannot; byte_offset is the file's size */
VOR_NODISCARD vor_status vor_ply_rows_fit(const struct vor_ply_body *body,
                                          const struct vor_ply_element *element,
                                          struct vor_error *err);

/** Moves past an element, or reads one into its columns (one for each property, in their order).
 *
 *  A coordinate that is not finite is stored as it is and noted in the body.
 *
 *  @retval VOR_E_FORMAT    with byte_offset
 *
 *  Cost: one pass over the element (to skip rows of constant size: none); no memory. */
VOR_NODISCARD vor_status vor_ply_ascii_skip(struct vor_ply_body *body,
                                            const struct vor_ply_element *element,
                                            struct vor_error *err);
VOR_NODISCARD vor_status vor_ply_ascii_rows(struct vor_ply_body *body,
                                            const struct vor_ply_rows *rows, struct vor_error *err);
VOR_NODISCARD vor_status vor_ply_binary_skip(struct vor_ply_body *body,
                                             const struct vor_ply_element *element,
                                             struct vor_error *err);
VOR_NODISCARD vor_status vor_ply_binary_rows(struct vor_ply_body *body,
                                             const struct vor_ply_rows *rows,
                                             struct vor_error *err);

/** Takes the items of lists: item number `item` of the list in row `row`, as a double (exact for
 *  integers of up to 32 bits). What it answers other than VOR_OK ends the reading. */
struct vor_ply_items {
    void *ctx;
    vor_status (*take)(void *ctx, uint64_t row, uint64_t item, double value, struct vor_error *err);
};

/** Moves past an element and hands over the items of one of its lists, that of property number
 *  `list`.
 *
 *  @retval VOR_E_FORMAT with byte_offset
 *  @retval others       as items->take, with byte_offset
 *
 *  Cost: one pass over the element; no memory. */
VOR_NODISCARD vor_status vor_ply_ascii_items(struct vor_ply_body *body,
                                             const struct vor_ply_element *element, unsigned list,
                                             const struct vor_ply_items *items,
                                             struct vor_error *err);
VOR_NODISCARD vor_status vor_ply_binary_items(struct vor_ply_body *body,
                                              const struct vor_ply_element *element, unsigned list,
                                              const struct vor_ply_items *items,
                                              struct vor_error *err);

/** Scalars in a row or in memory: every value at base, stride bytes from the last. */
struct vor_ply_strided {
    uint8_t *base;
    size_t stride;
};

/** The same, only read. */
struct vor_ply_source {
    const uint8_t *base;
    size_t stride;
};

/** Copies `run` adjacent scalars of `size` bytes for each of n rows, reversing the bytes of each
 *  scalar where swap is set. */
void vor_ply_copy(struct vor_ply_strided to, struct vor_ply_source from, size_t n, size_t size,
                  size_t run, int swap);

/** A scalar as a double, exactly but for 64-bit integers; and a double as FLOAT32 or FLOAT64. */
double vor_ply_load(const uint8_t *from, enum vor_type type, int swap);
void vor_ply_store(uint8_t *to, enum vor_type type, double value);

/** True where the host's byte order is not the encoding's. */
int vor_ply_swaps(enum vor_ply_encoding encoding);

#endif
