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

/** Shared memory. What comes first is written by the front before the worker starts. */
struct vor_board {
    unsigned threads;    /**< of the pool */
    size_t memory;       /**< bytes that the worker process may take; 0 for any */
    int has_codec;       /**< the worker has children encode results: */
    unsigned codec_kind; /**< as in struct vor_codec_place, as the next */
    enum vor_sandbox_kind sandbox;
    atomic_uint beats;           /**< the worker's ticker adds one every VOR_BEAT_SECONDS */
    atomic_int asked[VOR_SEATS]; /**< enum vor_answer of the listener of each run */
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

/** What a run says, in this order but for the last two, of which one comes. */
enum vor_said {
    VOR_SAID_STAGE,
    VOR_SAID_RECORD,
    VOR_SAID_WAITS, /**< its outputs wait for room on the disk */
    VOR_SAID_KEPT,  /**< the next bytes of what is kept in the row */
    VOR_SAID_DONE,
    VOR_SAID_FAILED,
    VOR_SAID_KINDS
};

/** Bytes of a part of what is kept in the row, and of all its parts: a report has 10 to 100 KB. */
enum { VOR_KEPT_PART = 32768, VOR_KEPT_MAX = 1 << 24 };

/** A message of a run. */
struct vor_message_said {
    enum vor_said what;
    union {
        enum vor_stage stage;
        struct vor_record record;
        char kept[VOR_KEPT_PART];
        struct vor_run_result result;
        struct vor_error error; /**< WAITS, FAILED */
    } of;
};

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
