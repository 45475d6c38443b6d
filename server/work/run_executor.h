/** Where a run of a job happens: an order goes there, records and stages come back while it runs,
 *  and at last its outcome. The side that orders has the store, the names of blobs and the job. The
 *  side that runs gets file descriptors and numbers, opens nothing and knows no other job.
 *
 *  There are two: one on a pool of this process (for tests, below), and one in a process of its own
 *  (supervisor.h). */
#ifndef VOR_SERVER_WORK_RUN_EXECUTOR_H
#define VOR_SERVER_WORK_RUN_EXECUTOR_H

#include "core/base/parallel.h"
#include "proto/text.h"
#include "server/jobs/preview.h"
#include "server/store/row.h"

#include <stddef.h>
#include <stdint.h>

/** What is to be run. A plain value that owns nothing. */
struct vor_order {
    struct vor_spec spec; /**< checked; its process outlives the run */
    unsigned format;      /**< of the main input: that of the result unless spec names one */
    double seconds_read;  /**< decoding the inputs took, for the report */
    size_t memory;        /**< bytes that the run may have */
    int is_suspect;       /**< it ran where something crashed, and is to be kept apart */
    uint64_t every;       /**< as in struct vor_run */
    union {
        struct {
            int input[VOR_INPUTS_MAX];   /**< the dump of each input (proto/dump.h), open for
                                              reading, in the order of the process's inputs; -1 for
                                              one that did not come. Borrowed, as the next */
            int output[VOR_OUTPUTS_MAX]; /**< an empty file for each output, open for writing; -1
                                              for what goes into the row */
            int saved; /**< the checkpoint of a lost attempt, open for reading; -1 for none */
        };
        int file[VOR_INPUTS_MAX + VOR_OUTPUTS_MAX + 1]; /**< all of them */
    };
};

/** What came of it. */
struct vor_run_result {
    struct vor_job_output output[VOR_OUTPUTS_MAX]; /**< as written to the files */
    int has_report;                                /**< the process has one */
    struct vor_report report;
    char message[128]; /**< a sentence for people: "300 points after 12 iterations, ..." */
};

/** What a run says, and the value that comes with it, which is borrowed. */
enum vor_said {
    VOR_SAID_STAGE,      /**< enum vor_stage: the next one begins */
    VOR_SAID_RECORD,     /**< struct vor_record */
    VOR_SAID_RESUMED,    /**< nothing: it went on from order.saved */
    VOR_SAID_CHECKPOINT, /**< struct vor_job_output: the listener's file is written; bytes 0: it
                              is not to be used */
    VOR_SAID_WAITS,      /**< struct vor_error, a VOR_E_IO: the outputs wait for room on the disk */
    VOR_SAID_POINTS,     /**< struct vor_shown: as they move, while somebody looks at them, at most
                              once in VOR_PREVIEW_SECONDS */
    VOR_SAID_KEPT,       /**< from here between processes alone (wire.h) */
    VOR_SAID_DONE,
    VOR_SAID_PART,
    VOR_SAID_FOUND,
    VOR_SAID_FAILED,
    VOR_SAID_KINDS
};

/** Whom a run talks to. asked is called from any thread, often, and must be quick; the others from
 *  one thread at a time. */
struct vor_listener {
    void *ctx;
    enum vor_answer (*asked)(void *ctx);
    void (*said)(void *ctx, enum vor_said what, const void *of);
    /** An empty file for a checkpoint, -1: none is wanted now. The run writes it, says so, and has
     * no more to do with it. May be NULL: none ever is. */
    int (*file)(void *ctx);
    /** Whether somebody looks at the points as they move; as asked. May be NULL: nobody does. */
    int (*is_looked_at)(void *ctx);
};

/** How a run ended. */
enum vor_run_end {
    VOR_RUN_DONE,    /**< result and kept say what came of it */
    VOR_RUN_FAILED,  /**< err says why; VOR_E_CANCELLED as the listener answered */
    VOR_RUN_CRASHED, /**< the process that ran it has ended without a word: err says how. It, or
                     another run there, is to blame */
    VOR_RUN_CRASHED_ALONE, /**< the same, and no other ran there */
    VOR_RUN_DISTURBED /**< nothing came of it, and it is not to blame: the process was ended because
                           of another run, or there is none; err says why */
};

/** A place for runs; a driver's struct begins with this. */
struct vor_run_executor {
    unsigned threads; /**< that the runs there share */
    int is_apart;     /**< a run that crashes takes neither this process with it nor, where it is a
                           suspect, another run */
    /** Runs an order and waits for its end. Any thread; as many at a time as the driver says.
     *
     *  @param[out] result  set when VOR_RUN_DONE is returned
     *  @param[out] kept    initialised; then has the output that is kept in the row, as JSON; empty
     *                      for none
     *  @param[out] err     set unless VOR_RUN_DONE is returned */
    enum vor_run_end (*run)(struct vor_run_executor *executor, const struct vor_order *order,
                            const struct vor_listener *listener, struct vor_run_result *result,
                            struct vor_text *kept, struct vor_error *err);
};

#endif
