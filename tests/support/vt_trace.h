/** The records of a run, as the papers' curves show them. */
#ifndef VT_TRACE_H
#define VT_TRACE_H

#include "tests/support/vt_engine.h"

#define VT_TRACE_MAX 256

struct vt_trace {
    struct vor_record record[VT_TRACE_MAX]; /**< 0: after initialisation */
    size_t count;
    struct vor_watch watch;
};

/** Makes the engine's run write its records into trace. */
void vt_trace_attach(struct vt_trace *trace, struct vt_engine *engine);

/** First iteration whose delta is at most this; VT_TRACE_MAX when there is none. */
size_t vt_trace_reaches(const struct vt_trace *trace, double delta);

/** Least delta of the first `count` records. */
double vt_trace_best(const struct vt_trace *trace, size_t count);

#endif
