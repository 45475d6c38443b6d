/** What a request must look like before anybody acts on it. Pure functions on strings. */
#ifndef VOR_SERVER_HTTP_REQUEST_CHECK_H
#define VOR_SERVER_HTTP_REQUEST_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    VOR_TARGET_MAX = 8192,  /**< bytes of a request target */
    VOR_FIELDS_MAX = 100,   /**< header fields of a request */
    VOR_HEADER_MAX = 32768, /**< bytes of a header block, request line and all */
    VOR_QUERY_MAX = 64      /**< pairs of a query */
};

struct vor_field {
    const char *name, *value;
};

/** A header block as it came; strings are borrowed for the request. */
struct vor_head {
    const char *target; /**< raw, as on the request line */
    const char *version;
    const char *block;  /**< where the target stood in the block as it came, if version, names and
                             values are still where they stood in it too; else NULL */
    size_t field_count; /**< VOR_FIELDS_MAX + 1 when there were more */
    struct vor_field fields[VOR_FIELDS_MAX];
};

/** First value of a field by name (any case), or NULL. */
const char *vor_head_find(const struct vor_head *head, const char *name);

/** The slug of the problem ("smuggled-framing", "malformed-request") and its sentence, or NULL when
 *  the head is sound. Never looks at the body.
 *
 *  The library hands over strings that end at the first NUL, and takes lines that end with a line
 *  feed alone and lines that are folded; from what lies between two strings of the block that is
 *  seen all the same. The end of the last line is not. */
const char *vor_head_check(const struct vor_head *head, const char **detail);

/** Declared length of the body: -1 chunked, 0 none. head has passed the request check. */
int64_t vor_head_length(const struct vor_head *head);

/** Splits and decodes the query in place: pairs point into text. Returns how many there are, or -1
 *  when an escape is malformed, a control byte is hidden in one, or there are more than max. */
int vor_query_split(char *text, struct vor_field *pairs, int max);

/** A name for a request: sane (may be NULL) if it is, else a random UUID. */
void vor_request_id_make(char out[72], const char *sane);

/** True when a list of entity tags (If-Match, If-None-Match) holds this one, quotes included, or is
 * a star. A weak one matches where takes_weak. list may be NULL. */
bool vor_etag_listed(const char *list, const char *etag, bool takes_weak);

#endif
