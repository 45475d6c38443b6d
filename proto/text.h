/** Text that is being written. */
#ifndef VOR_PROTO_TEXT_H
#define VOR_PROTO_TEXT_H

#include "core/base/status.h"

#include <stddef.h>

/** Text that grows up to a cap. A failure sticks: later additions are dropped, so a writer checks
 *  once, at its end. Not thread-safe. */
struct vor_text {
    char *data;  /**< size bytes and a NUL after them; NULL as long as nothing was added */
    size_t size; /**< without the NUL */
    size_t capacity;
    size_t cap; /**< most bytes, without the NUL */
    int comma;  /**< the JSON writer's: a value stands before the next one */
    int failed; /**< out of memory, or beyond the cap */
};

#define VOR_TEXT_CAP_DEFAULT ((size_t)64 << 20)

/** An empty text of at most cap bytes; 0 is VOR_TEXT_CAP_DEFAULT. No clean-up until it grows. */
void vor_text_init(struct vor_text *text, size_t cap);

/** Frees the bytes and leaves the text empty, with its cap. */
void vor_text_free(struct vor_text *text);

/** Empties the text but keeps its memory; forgets a failure. */
void vor_text_clear(struct vor_text *text);

/** Appends bytes as they are. append goes on with the JSON document at hand; the others start a new
 * one behind the bytes: no comma precedes its first value. */
void vor_text_append(struct vor_text *text, const void *bytes, size_t size);
void vor_text_add(struct vor_text *text, const void *bytes, size_t size);
void vor_text_puts(struct vor_text *text, const char *string);
/** Appends a string as a part of a URL: all but letters, digits and "-._~" is escaped. */
void vor_text_escape(struct vor_text *text, const char *string);
void vor_text_printf(struct vor_text *text, const char *format, ...) VOR_PRINTF(2, 3);

/** The write of a sink (struct vor_sink) whose ctx is a text; -1 once something was dropped. */
int vor_text_take(void *text, const void *bytes, size_t size);

/** @retval VOR_E_NOMEM something was dropped: no memory, or beyond the cap */
VOR_NODISCARD vor_status vor_text_status(const struct vor_text *text, struct vor_error *err);

/** The control characters of ASCII but the tab and NUL, for strpbrk and its like. */
#define VOR_CONTROLS                                                                               \
    "\1\2\3\4\5\6\7\10\12\13\14\15\16\17\20\21\22\23\24\25\26\27\30\31\32\33\34\35\36\37\177"

/** Bytes up to the first CR or LF. */
size_t vor_line_length(const char *text, size_t size);

#endif
