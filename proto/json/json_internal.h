/** What the files behind proto/json/json.h share. */
#ifndef VOR_PROTO_JSON_INTERNAL_H
#define VOR_PROTO_JSON_INTERNAL_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** Bytes of the UTF-8 character at p, of which `left` bytes are there: 1 .. 4, or 0 when it is none
 *  (overlong, surrogate, beyond U+10FFFF, cut off). */
size_t vor_utf8_length(const unsigned char *p, size_t left);

/** Where the keys of a text stand, in the order in which they stand. */
struct vor_json_keys {
    uint32_t *offsets; /**< room for VOR_JSON_TOKENS_MAX */
    size_t count;
};

/** vor_json_scan that also notes the keys; keys may be NULL. */
VOR_NODISCARD vor_status vor_json_scan_keys(const char *bytes, size_t size,
                                            struct vor_json_keys *keys, struct vor_error *err);

#endif
