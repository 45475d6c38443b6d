/** UTF-8, RFC 3629. */
#ifndef VOR_BASE_UTF8_H
#define VOR_BASE_UTF8_H

#include <stddef.h>

/** Length in bytes, 1 .. 4, of the UTF-8 character at p, where `left` bytes may be read; 0 when it
 *  is none (overlong, surrogate, beyond U+10FFFF, cut off, or left is 0). */
size_t vor_utf8_length(const unsigned char *p, size_t left);

/** The number of characters; -1 when one is a control character (of ASCII, or U+0080 to U+009F) or
 * not UTF-8. */
long vor_utf8_count(const char *text);

/** True when text is UTF-8 without control characters: so it comes back unchanged from JSON, a
 * query and a terminal. */
int vor_utf8_is_plain(const char *text, size_t size);

#endif
