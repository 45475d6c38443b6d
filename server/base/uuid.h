/** Identifiers (RFC 9562): of jobs UUID version 7, 48 bits of time and 74 random ones. And random
 *  numbers. */
#ifndef VOR_SERVER_BASE_UUID_H
#define VOR_SERVER_BASE_UUID_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11" and its NUL: always lower case, safe in a file name. */
struct vor_uuid {
    char text[37];
};

/** A fresh identifier from the wall clock and the kernel's random numbers. Sorts by time as text,
 *  to the millisecond. Thread-safe.
 *
 *  @retval VOR_E_IO the kernel gives no random numbers */
VOR_NODISCARD vor_status vor_uuid_make(struct vor_uuid *out, struct vor_error *err);

/** Writes the form above; the bits of version and variant are set. */
void vor_uuid_write(struct vor_uuid *out, const uint8_t bytes[16], unsigned version);

/** Random bytes of the kernel, 256 at most, good enough for secrets. Thread-safe.
 *
 *  @retval VOR_E_IO it gives none */
VOR_NODISCARD vor_status vor_random_fill(void *out, size_t size, struct vor_error *err);

/** Reads exactly the form above (36 characters, lower case); false when text is anything else. */
int vor_uuid_parse(struct vor_uuid *out, const char *text, size_t length);

/** True for 1 to 36 characters that such a form may begin with. */
int vor_uuid_begins(const char *text, size_t length);

#endif
