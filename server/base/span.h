/** A step of a trace that began elsewhere (W3C Trace Context, level 1): what the header traceparent
 *  says, carried on. */
#ifndef VOR_SERVER_BASE_SPAN_H
#define VOR_SERVER_BASE_SPAN_H

enum {
    VOR_TRACE_ID_SIZE = 33,    /**< 32 digits and a NUL */
    VOR_SPAN_ID_SIZE = 17,     /**< 16 digits and a NUL */
    VOR_TRACEPARENT_SIZE = 56, /**< "00-TRACE-SPAN-FLAGS" and a NUL */
};

struct vor_span {
    char trace[VOR_TRACE_ID_SIZE]; /**< "" for none, as is id then */
    char id[VOR_SPAN_ID_SIZE];
    char flags[3];
};

/** Reads a traceparent. False, and *out is none, when text is none by the grammar: version 00, or a
 *  later one that goes on behind a hyphen; lower-case digits; neither id all zeros. */
int vor_span_parse(struct vor_span *out, const char *text);

/** A step of our own in the trace of `of`: the same trace and flags, a new id. None where `of` is,
 * or where there are no random numbers. */
void vor_span_begin(struct vor_span *out, const struct vor_span *of);

/** As a traceparent, "" for none. Returns out. */
const char *vor_span_text(const struct vor_span *span, char out[VOR_TRACEPARENT_SIZE]);

#endif
