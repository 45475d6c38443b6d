/** The only two things that travel upward: progress and cancel, through function pointers given
 * from above. The clock comes the same way; core has none of its own. */
#ifndef VOR_BASE_WATCH_H
#define VOR_BASE_WATCH_H

#include <stdint.h>

/** What is known after an iteration or some steps of the polish: the same record in SSE, NDJSON and
 *  trace. Iteration 0 is the state after initialisation. During the polish, iteration stays at the
 *  last one, and so does energy. */
struct vor_record {
    uint32_t iteration;
    uint32_t polish; /**< steps of the polish done; 0 while iterations go on */
    double delta;    /**< uniformity, Xiao 2024 Eq. 6; no unit, lower is better */
    double sigma;    /**< Xiao 2024 Sec. V-B, in the cloud's unit */
    double epsilon;  /**< Xiao 2024 Sec. V-B, in (0, 1] */
    double energy;   /**< Xiao 2024 Eq. 2, in the cloud's unit to the fourth power */
    double max_move; /**< longest move of a point in this iteration, in the cloud's unit */
    uint64_t held;   /**< points the boundary restriction held back in this iteration */
    double seconds;  /**< since the run began, by the watch's clock */
};

enum vor_answer {
    VOR_CONTINUE, /**< go on */
    VOR_STOP,     /**< end now with the best cloud so far */
    VOR_CANCEL    /**< end now with nothing: VOR_E_CANCELLED */
};

/** Any member may be NULL. progress and clock are called from the thread that runs the engine, poll
 *  from every thread of the pool before each block of work: it must be cheap and thread-safe. */
struct vor_watch {
    void *ctx;
    enum vor_answer (*progress)(void *ctx, const struct vor_record *record);
    enum vor_answer (*poll)(void *ctx);
    double (*clock)(
        void *ctx); /**< monotonic seconds; without it, seconds are 0 and no budget ends */
};

#endif
