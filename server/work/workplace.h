/** A place where runs happen: a worker process, and a seat for each run.
 *
 *  The process has lives: from its start until it ends, by itself or by us. A seat belongs to one
 *  life. When the life ends, each of its seats gets a note of how it ended; a thread that waits at
 *  the seat finds its channel closed, and reads the note. Not thread-safe, but for the board. What
 *  waits for a process (spawn, reap) is apart from what notes that it has begun or ended. */
#ifndef VOR_SERVER_WORK_WORKPLACE_H
#define VOR_SERVER_WORK_WORKPLACE_H

#include "server/proc/zygote.h"
#include "server/work/wire.h"

#include <stdint.h>

enum { VOR_NOBODY = -1 };

struct vor_seat {
    int taken;
    uint64_t life; /**< that it belongs to */
    /* Once that has ended: */
    int is_innocent; /**< it was ended because of another run */
    int is_only;     /**< no other ran at its end */
    char how[64];    /**< "signal 11" */
};

struct vor_workplace {
    struct vor_board *board;
    int board_fd;
    int is_up;
    int is_changing;        /**< the caller's: it is being started or ended */
    struct vor_child child; /**< while it is up */
    uint64_t life;          /**< number of the last one, from 1 */
    unsigned beats;         /**< when they were last looked at */
    double beat;            /**< when they had changed */
    struct vor_seat seat[VOR_SEATS];
};

/** Makes a place, all zero before, with a board that says so many threads and bytes.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_workplace_init(struct vor_workplace *workplace, unsigned threads,
                                            size_t memory, struct vor_error *err);

/** Ends its process, if there is one. It may be all zero. */
void vor_workplace_free(struct vor_workplace *workplace);

/** Starts a process and waits until it is ready. Reads the board alone.
 *
 *  @retval VOR_E_NOMEM  its threads cannot be started
 *  @retval VOR_E_IO     there is none to be had */
VOR_NODISCARD vor_status vor_workplace_spawn(struct vor_child *child,
                                             const struct vor_workplace *workplace,
                                             struct vor_zygote *zygote, unsigned kind,
                                             struct vor_error *err);

/** A life begins, with that process. */
void vor_workplace_begin(struct vor_workplace *workplace, const struct vor_child *child);

/** How a process ended. */
struct vor_workplace_end {
    struct vor_child_end end;
    char how[64];
};

/** Ends the process, which is up.
 *
 *  @param[in] why  we end it; NULL where it has ended by itself, or nearly so */
void vor_workplace_reap(struct vor_workplace_end *out, struct vor_child *child, const char *why);

/** The life of a process that was reaped is over: notes at its seats how it ended.
 *
 *  @param[in] blamed  the seat because of which we ended it, or VOR_NOBODY */
void vor_workplace_end(struct vor_workplace *workplace, const struct vor_workplace_end *end,
                       int blamed);

/** Runs of the life at hand. */
unsigned vor_workplace_runs(const struct vor_workplace *workplace);

/** The listener of a run that was cancelled and whose caller has gone. */
extern const struct vor_listener vor_nobody;

#endif
