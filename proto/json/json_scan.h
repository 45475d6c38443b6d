/** Checks a stranger's JSON before cJSON sees it, for what cJSON lets pass: 01, 1., 0x10, 1e999,
 * \u0000 (which cuts a string short), raw control characters, what is not UTF-8, and bombs, which
 * cost it 41 bytes of memory for a byte of text. */
#ifndef VOR_PROTO_JSON_SCAN_H
#define VOR_PROTO_JSON_SCAN_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** What a text must keep to before cJSON sees it. */
#define VOR_JSON_SIZE_MAX ((size_t)1 << 20)
#define VOR_JSON_DEPTH_MAX 32
#define VOR_JSON_TOKENS_MAX 20000 /**< values, keys and opening brackets */
#define VOR_JSON_NUMBER_LENGTH_MAX 63

/** Where the keys of a text stand, in the order in which they stand. */
struct vor_json_keys {
    uint32_t *offsets; /**< room for VOR_JSON_TOKENS_MAX */
    size_t count;
};

/** Checks a text without reading it: RFC 8259 to the letter, within the limits above, valid UTF-8,
 *  no NUL and no \u0000, numbers that fit a double, and nothing after the value. Does not look for
 *  duplicate keys, but notes where the keys stand; keys may be NULL.
 *
 *  @retval VOR_E_REQUEST byte_offset says where and the message why; limit and got are set when a
 *                        limit was exceeded
 *
 *  O(size) time, no memory. */
VOR_NODISCARD vor_status vor_json_scan(const char *bytes, size_t size, struct vor_json_keys *keys,
                                       struct vor_error *err);

#endif
