/** Makes bytes from outside printable. */
#ifndef VOR_BASE_QUOTE_H
#define VOR_BASE_QUOTE_H

#include <stddef.h>

/** Writes bytes as printable ASCII: '"', '\' and unprintable ones as \xNN, with "..." at the end if
 *  they are cut to fit.
 *
 *  @param[out] out  size >= 8 bytes; always NUL-terminated
 *
 *  @return out */
const char *vor_quote(char *out, size_t size, const void *bytes, size_t length);

/** The same in memory of the block around. */
#define VOR_QUOTED(size, bytes, length) vor_quote((char[size]){0}, size, bytes, length)

#endif
