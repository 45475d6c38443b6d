/** Function pointers through which core talks to its caller: progress goes up, cancel and stop come
 *  down. The clock comes the same way; core has none of its own. */
#ifndef VOR_BASE_WATCH_H
#define VOR_BASE_WATCH_H

#include <stddef.h>

/** What is known after a step of a run: core/report.h. */
struct vor_record;

enum vor_answer {
    VOR_CONTINUE, /**< go on */
    VOR_STOP,     /**< end now with the best cloud so far */
    VOR_CANCEL    /**< end now with nothing: VOR_E_CANCELLED */
};

/** Points while they move: point i lies at xyz[3 i ..] * unit + shift, relative to the origin of
 * the input. Borrowed for the call. */
struct vor_moving {
    const float *xyz; /**< n x 3 */
    size_t n;
    double unit, shift[3];
};

/** Bytes, one part of several. */
struct vor_part {
    void *bytes;
    size_t size;
};

/** Any member may be NULL. progress, points, checkpoint and clock are called from the thread that
 * runs the engine, poll from every thread of the pool before each block of work: it must be cheap
 * and thread-safe. Where there is a poll and the request limits the time, so must the clock be. */
struct vor_watch {
    void *ctx;
    enum vor_answer (*progress)(void *ctx, const struct vor_record *record);
    enum vor_answer (*poll)(void *ctx);
    /** Monotonic seconds; without it seconds are 0 and no budget ends. */
    double (*clock)(void *ctx);
    /** Before a progress: the points that its record is of. Nothing is computed for it. */
    void (*points)(void *ctx, const struct vor_moving *points, const struct vor_record *record);
    /** What another run of the same request goes on from (vor_run.saved), in parts that follow each
     *  other; borrowed for the call, and only read. No parts: this run went on from such bytes. */
    void (*checkpoint)(void *ctx, const struct vor_part *part, unsigned parts);
};

#endif
