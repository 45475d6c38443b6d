/** The header of a PLY file: what its elements and properties are and where its data begins. */
#ifndef VOR_PROTO_PLY_HEADER_H
#define VOR_PROTO_PLY_HEADER_H

#include "core/cloud/cloud.h"

#include <stddef.h>
#include <stdint.h>

enum { VOR_PLY_ELEMENTS_MAX = 16, VOR_PLY_PROPERTIES_MAX = 64, VOR_PLY_LINE_MAX = 1024 };

enum vor_ply_encoding { VOR_PLY_ASCII, VOR_PLY_LITTLE, VOR_PLY_BIG };

/** A scalar, or a list: a count of count_type, then that many scalars of type. */
struct vor_ply_property {
    const char *name; /**< inside the file's bytes, not terminated */
    size_t name_length;
    int list;
    enum vor_type count_type, type;
};

struct vor_ply_element {
    const char *name; /**< inside the file's bytes, not terminated */
    size_t name_length;
    size_t offset;  /**< of the line that declares it */
    uint64_t count; /**< as declared, not yet believed; what exceeds 64 bits is UINT64_MAX */
    unsigned property_count;
    struct vor_ply_property properties[VOR_PLY_PROPERTIES_MAX];
};

struct vor_ply_header {
    enum vor_ply_encoding encoding;
    size_t body; /**< offset of the first byte after the header */
    unsigned element_count;
    struct vor_ply_element elements[VOR_PLY_ELEMENTS_MAX];
};

/** Reads a header of at most limit bytes, whatever the data behind it.
 *
 *  @retval VOR_E_FORMAT it is not one, with byte_offset at the line at fault
 *
 *  Cost: O(length of the header), no memory. */
VOR_NODISCARD vor_status vor_ply_header_read(struct vor_ply_header *out, const uint8_t *bytes,
                                             size_t size, size_t limit, struct vor_error *err);

/** True where the first line is "ply", with blanks behind it or not. */
int vor_ply_is(const uint8_t *bytes, size_t size);

/** What ends a line of the header: '\n', which a '\r' may stand before, or '\r' in files of the old
 *  Macintosh. */
uint8_t vor_ply_line_stop(const uint8_t *bytes, size_t size);

/** True for a line "comment ..." or "obj_info ...". */
int vor_ply_is_remark(const char *at, size_t size);

/** True when the element, or the property, has that name. */
int vor_ply_named(const char *name, size_t length, const char *want);

/** True when it has it in the same letters or in others. */
int vor_ply_alike(const char *name, size_t length, const char *want);

/** The property of that name, or else one that has it in other letters ("Red", "X"); a scalar where
 *  is_scalar says so. VOR_PLY_PROPERTIES_MAX where there is none. */
unsigned vor_ply_find(const struct vor_ply_element *element, const char *name, int is_scalar);

/** Fails, and says where in the file. */
#define VOR_PLY_FAIL(err, offset, ...)                                                             \
    vor_fail_at(err, vor_fail(err, VOR_E_FORMAT, __VA_ARGS__), offset)

#endif
