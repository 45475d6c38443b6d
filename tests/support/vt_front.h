/** A front with a worker process of the test's own kind, and what a run there tells. */
#ifndef VT_FRONT_H
#define VT_FRONT_H

#include "server/work/supervisor.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

struct vt_front {
    struct vor_zygote *zygote; /* malloc */
    struct vor_supervisor *supervisor;
};

/** Starts a zygote of these kinds and a supervisor; of config, zygotes, threads and memory are
 *  filled in. */
struct vt_front vt_front_start(const struct vor_child_kind *kinds, unsigned count,
                               struct vor_supervisor_config config);
void vt_front_stop(struct vt_front *front);

/** Workers of this process that have ended unasked so far. */
unsigned vt_front_crashes(void);

/** A run and what it told. */
struct vt_heard {
    const struct vt_front *front;
    int script, is_suspect; /**< as the test likes */
    int file;               /**< of the order, 0 for none */
    atomic_int asked;       /**< enum vor_answer */
    atomic_int is_over;
    atomic_int stages; /**< encoding was told so often */
    int records, waits, offers, resumed;
    FILE *offered;  /**< for a checkpoint, once; NULL: none */
    uint64_t saved; /**< bytes of that */
    struct vor_record record;
    struct vor_run_result result;
    struct vor_text kept;
    struct vor_error err;
    enum vor_run_end end;
    pthread_t thread;
};

/** A listener that notes what it hears, and answers heard->asked. */
struct vor_listener vt_listener_of(struct vt_heard *heard);

/** Runs an order to its end; heard->kept is the caller's to free. */
void vt_heard_run(struct vt_heard *heard, struct vor_run_executor *executor,
                  const struct vor_order *order);

/** An order of resample without files, with that much memory. */
struct vor_order vt_order_of(size_t memory);

#endif
