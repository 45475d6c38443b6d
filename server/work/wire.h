/** What the front and the worker process say to each other. The worker process is forked from this
 *  very program and never executes another, so structs travel as they are.
 *
 *  On the worker's channel the front sends a channel for each run (struct vor_summons, with its
 *  descriptor). On that one it sends the order, and hears stages, records and the end. What changes
 *  all the time and must not wait lies on a board in memory that both have mapped. */
#ifndef VOR_SERVER_WORK_WIRE_H
#define VOR_SERVER_WORK_WIRE_H

#include "server/proc/channel.h"
#include "server/proc/sandbox.h"
#include "server/work/run_executor.h"

#include <stdatomic.h>

/** Most runs at a time. */
enum { VOR_SEATS = 64 };

/** Words of the points of one seat: whole pages of 4 KiB, so that they can be given back. */
enum { VOR_SHOWN_WORDS = (3 * VOR_PREVIEW_POINTS_MAX + 1023) / 1024 * 1024 };

/** Where the points of a run are, for who looks: written by the worker, read by the front, neither
 *  of which ever waits for the other. The sequence is odd while it is written; a reader that finds
 * it changed has read nothing. */
struct vor_showing {
    atomic_int is_looked_at; /**< the front's */
    atomic_uint sequence;    /**< the worker's, as the rest */
    atomic_uint count, iteration, polish;
    _Atomic uint64_t origin[3]; /**< bits of doubles */
};

/** Shared memory. What comes first is written by the front before the worker starts. Pages of
 * points that nobody has looked at take no memory. */
struct vor_board {
    unsigned threads;    /**< of the pool */
    size_t memory;       /**< bytes that the worker process may take; 0 for any */
    int has_codec;       /**< the worker has children encode results: */
    unsigned codec_kind; /**< as in struct vor_codec_place, as the next */
    enum vor_sandbox_kind sandbox;
    atomic_uint beats;           /**< the worker's ticker adds one every VOR_BEAT_SECONDS */
    atomic_int asked[VOR_SEATS]; /**< enum vor_answer of the listener of each run */
    struct vor_showing showing[VOR_SEATS];
    _Alignas(4096) _Atomic uint32_t shown[VOR_SEATS][VOR_SHOWN_WORDS]; /**< bits of floats */
};

#define VOR_BEAT_SECONDS 0.1

/** Makes a board, all zero, and a descriptor through which another process maps it.
 *
 *  @param[out] out  vor_board_unmap; *fd: close
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_board_create(struct vor_board **out, int *fd, struct vor_error *err);

/** NULL when it cannot be mapped. */
struct vor_board *vor_board_map(int fd);

/** board may be NULL. */
void vor_board_unmap(struct vor_board *board);

/** The worker's: writes at most VOR_PREVIEW_POINTS_MAX points of a run. */
void vor_board_show(struct vor_board *board, unsigned seat, const struct vor_shown *shown);

/** The front's: the points last written, if they are others than those of *sequence, which becomes
 *  theirs.
 *
 *  @param[out] out  its moving.xyz is xyz
 *  @param[out] xyz  VOR_PREVIEW_POINTS_MAX x 3
 *  @return false when there are none, or they are just being written */
int vor_board_look(struct vor_board *board, unsigned seat, unsigned *sequence,
                   struct vor_shown *out, float *xyz);

/** The front's: nobody looks at a seat, and what it showed is given back. */
void vor_board_look_away(struct vor_board *board, unsigned seat);

/** Sent to the worker with one descriptor, the channel of a run. */
struct vor_summons {
    unsigned seat; /**< of the run on the board */
};

/** Sends an order and its files.
 *
 *  @retval VOR_E_IO  nobody is there any more */
VOR_NODISCARD vor_status vor_order_send(int channel, const struct vor_order *order,
                                        struct vor_error *err);

/** Receives one; its descriptors are the caller's to close (vor_order_close), also after a failure.
 *
 *  @retval VOR_E_IO  nothing comes in `seconds`, or no order */
VOR_NODISCARD vor_status vor_order_receive(struct vor_order *out, int channel, double seconds,
                                           struct vor_error *err);

void vor_order_close(struct vor_order *order);

/** Says that an order has no files. */
void vor_order_forget(struct vor_order *order);

/** The front's: offers the run a file for a checkpoint, if the listener has one. */
void vor_offer_send(int channel, const struct vor_listener *listener);

/** The run's: the file that was offered last, the caller's to close; -1 for none. Does not wait. */
int vor_offer_receive(int channel);

/** Bytes of a part of what is kept in the row, and of all its parts: a report has 10 to 100 KB. */
enum { VOR_KEPT_PART = 32768, VOR_KEPT_MAX = 1 << 24 };

/** A message of a run: what a listener hears, then the next bytes of what is kept in the row
 *  (KEPT), and one of the last two. */
struct vor_message_said {
    enum vor_said what;
    union {
        enum vor_stage stage;
        struct vor_record record;
        struct vor_job_output file; /**< CHECKPOINT */
        char kept[VOR_KEPT_PART];
        struct vor_run_result result;
        struct vor_error error; /**< WAITS, FAILED */
    } of;
};

/** Bytes of the value of a kind; 0 for KEPT, which has some. */
size_t vor_said_size(enum vor_said what);

/** Says one thing; `of` has `size` bytes, as its member of the union.
 *
 *  @retval VOR_E_IO  nobody is there any more */
VOR_NODISCARD vor_status vor_say(int channel, enum vor_said what, const void *of, size_t size);

/** Hears the next thing. What came is checked, as the run may have gone mad: strings end, numbers
 *  that index a table do.
 *
 *  @param[out] size  bytes of `of`
 *
 *  @return as vor_channel_receive; VOR_CHANNEL_GONE also when what came makes no sense */
enum vor_channel_event vor_hear(struct vor_message_said *out, size_t *size, int channel,
                                double seconds);

#endif
