/** Bytes as text that may stand in a URL and a header: base64url (RFC 4648, 5) without padding. */
#ifndef VOR_SERVER_BASE_BASE64_H
#define VOR_SERVER_BASE_BASE64_H

#include <stddef.h>
#include <stdint.h>

/** Bytes of the text of `size` bytes, with its NUL. */
#define VOR_BASE64_SIZE(size) (((size)*4 + 2) / 3 + 1)

/** Writes the text of size bytes: VOR_BASE64_SIZE(size) bytes. */
void vor_base64_write(const uint8_t *bytes, size_t size, char *out);

/** Reads a text that vor_base64_write has written.
 *
 *  @return how many bytes there are; -1 when the text holds another character, is of no such
 *          length, ends with bits that are not 0, or is of more than max bytes */
long vor_base64_read(const char *text, uint8_t *out, size_t max);

#endif
