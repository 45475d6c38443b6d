/** Bytes from outside, fit to be shown in a message. */
#ifndef VOR_BASE_QUOTE_H
#define VOR_BASE_QUOTE_H

#include <stddef.h>

/** Writes bytes as printable ASCII: '"', '\' and what is not printable as \xNN, "..." where it was
 *  cut to fit. out (size >= 8) is always NUL-terminated. Returns out. */
const char *vor_quote(char *out, size_t size, const void *bytes, size_t length);

#endif
