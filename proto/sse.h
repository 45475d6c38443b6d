/** Server-sent events, both ends, by the grammar of the WHATWG HTML standard, section 9.2. */
#ifndef VOR_PROTO_SSE_H
#define VOR_PROTO_SSE_H

#include "core/base/status.h"
#include "proto/text.h"

#include <stddef.h>

/** Appends "retry: MS" and a blank line: how long a client waits before it comes back. */
void vor_sse_retry(struct vor_text *text, unsigned retry_ms);

/** Appends one event. id and name hold no CR, LF or NUL, and either may be NULL: left out. data of
 *  several lines (CR, LF or CRLF) becomes as many data lines; every line end arrives as LF. */
void vor_sse_event(struct vor_text *text, const char *id, const char *name, const char *data,
                   size_t size);

/** Appends ": hb" and a blank line: nothing for the client, but a dead one is noticed. */
void vor_sse_heartbeat(struct vor_text *text);

#define VOR_SSE_LINE_MAX ((size_t)64 << 10)
#define VOR_SSE_DATA_MAX ((size_t)1 << 20)

/** An event that has arrived; valid during the call. */
struct vor_sse_arrival {
    const char *id;   /**< the last id seen in the stream, "" when none */
    const char *name; /**< "message" when the event has none; cut at a NUL */
    const char *data; /**< size bytes and a NUL; as they came, not checked for UTF-8 */
    size_t size;
};

/** Called once for each event with data; anything but 0 ends the feed with VOR_E_CANCELLED. */
typedef int (*vor_sse_handler)(void *ctx, const struct vor_sse_arrival *event);

/** Reads a stream as it comes in, in pieces of any size. Lines end with CR, LF or CRLF; a byte
 *  order mark at the start, comments and unknown fields are skipped; an id with a NUL is ignored;
 *  an event the stream ends within is dropped. */
struct vor_sse_parser {
    vor_sse_handler handler;
    void *ctx;
    struct vor_text line, name, data, id;
    struct vor_text pending_id; /**< becomes id when its event is complete */
    int seen_cr;                /**< the last byte was CR: an LF now belongs to it */
    int seen_data;              /**< the event has a data field */
    int first_line;             /**< where the byte order mark may stand */
    int retry_ms;               /**< what the server asked for; -1 as long as it has not */
};

void vor_sse_parser_init(struct vor_sse_parser *parser, vor_sse_handler handler, void *ctx);
void vor_sse_parser_free(struct vor_sse_parser *parser);

/** Forgets a broken-off line and event but keeps the last id and retry: the stream begins anew. */
void vor_sse_parser_restart(struct vor_sse_parser *parser);

/** The last id that was completed by an event's end, for Last-Event-ID; "" when none. */
const char *vor_sse_parser_last_id(const struct vor_sse_parser *parser);

/** Takes the next bytes.
 *
 *  @retval VOR_E_LIMIT     a line beyond VOR_SSE_LINE_MAX or data beyond VOR_SSE_DATA_MAX bytes
 *                          (limit and got are set); restart the parser or free it
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED the handler said so
 *
 *  O(size). Memory stays below VOR_SSE_LINE_MAX + VOR_SSE_DATA_MAX and their doubling. */
VOR_NODISCARD vor_status vor_sse_feed(struct vor_sse_parser *parser, const void *bytes, size_t size,
                                      struct vor_error *err);

#endif
