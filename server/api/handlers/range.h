/** Byte ranges (RFC 9110, section 14). */
#ifndef VOR_SERVER_API_HANDLERS_RANGE_H
#define VOR_SERVER_API_HANDLERS_RANGE_H

#include <stdbool.h>
#include <stdint.h>

enum vor_range {
    VOR_RANGE_WHOLE, /**< no range, several, or one that cannot be read: send everything */
    VOR_RANGE_PART,  /**< *offset and *length are set */
    VOR_RANGE_OUTSIDE
};

/** Reads a Range header (may be NULL) against a representation of `size` bytes. */
enum vor_range vor_range_parse(const char *text, uint64_t size, uint64_t *offset, uint64_t *length);

#endif
