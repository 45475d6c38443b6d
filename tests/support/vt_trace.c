#include "tests/support/vt_trace.h"

#include <math.h>

static enum vor_answer add(void *ctx, const struct vor_record *record)
{
    struct vt_trace *trace = ctx;

    ck_assert_uint_lt(trace->count, VT_TRACE_MAX);
    trace->record[trace->count++] = *record;
    return VOR_CONTINUE;
}

void vt_trace_attach(struct vt_trace *trace, struct vt_engine *engine)
{
    trace->count = 0;
    trace->watch = (struct vor_watch){.ctx = trace, .progress = add};
    engine->run.watch = &trace->watch;
}

size_t vt_trace_reaches(const struct vt_trace *trace, double delta)
{
    for (size_t i = 0; i < trace->count; i++)
        if (trace->record[i].delta <= delta)
            return i;
    return VT_TRACE_MAX;
}

double vt_trace_best(const struct vt_trace *trace, size_t count)
{
    double best = INFINITY;

    for (size_t i = 0; i < count && i < trace->count; i++)
        best = fmin(best, trace->record[i].delta);
    return best;
}
