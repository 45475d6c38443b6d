/** What the front and its children say to each other: the worker process (worker_main.h), and those
 * that do one piece of work with bytes (codec_child.h). All are forked from this very program and
 * never execute another, so structs travel as they are.
 *
 *  On the worker's channel the front sends a channel for each run (struct vor_run_request, with its
 *  descriptor). On that one it sends the order, and hears what the run says up to its end.  *
 * changes all the time and must not wait lies in memory that both have mapped. */
#ifndef VOR_SERVER_WORK_IPC_CODEC_H
#define VOR_SERVER_WORK_IPC_CODEC_H

#include "server/proc/channel.h"
#include "server/proc/sandbox.h"
#include "server/work/codec_work.h"
#include "server/work/run_executor.h"

#include <stdatomic.h>

/** Most runs at a time. */
enum { VOR_RUN_SLOTS = 64 };

/** Shared memory. What comes first is written by the front before the worker starts. */
struct vor_shared_state {
    unsigned threads;    /**< of the pool */
    size_t memory;       /**< bytes that the worker process may take; 0 for any */
    int has_codec;       /**< the worker has children encode results: */
    unsigned codec_kind; /**< as in struct vor_codec_place, as the next */
    enum vor_sandbox_kind sandbox;
    atomic_uint beats;               /**< the worker's ticker adds one every VOR_BEAT_SECONDS */
    atomic_int asked[VOR_RUN_SLOTS]; /**< enum vor_answer of the listener of each run */
    atomic_int is_looked_at[VOR_RUN_SLOTS]; /**< somebody looks at the points of the run */
};

#define VOR_BEAT_SECONDS 0.1

/** Makes memory that two processes share, all zero, which cannot be made shorter, as that would
 * kill the one that reads, and maps it.
 *
 *  @param[in]  protection, flags  as of mmap, besides MAP_SHARED
 *  @param[out] fd  through which another process maps it; close
 *  @return munmap; NULL, and errno says why */
void *vor_share(int *fd, size_t size, int protection, int flags);

/** NULL when it cannot be mapped. */
struct vor_shared_state *vor_shared_state_map(int fd);

/** Sent to the worker with one descriptor, the channel of a run. */
struct vor_run_request {
    unsigned slot; /**< of the run */
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

/** A message of a child: what a listener hears, then the next bytes of what is kept in the row
 *  (KEPT), and one of DONE and FAILED; or of one that works on bytes PART, and one of FOUND and
 *  FAILED. */
struct vor_message_said {
    enum vor_said what;
    union {
        enum vor_stage stage;
        struct vor_record record;
        struct vor_job_output file; /**< CHECKPOINT */
        struct vor_shown shown;     /**< POINTS */
        char kept[VOR_KEPT_PART];
        struct vor_run_result result;
        struct vor_error error; /**< WAITS, FAILED */
        uint32_t part;          /**< PART: bytes in the next slot of the ring */
        struct vor_codec_facts facts;
    } of;
};

/** Bytes of the value of a kind; 0 for KEPT, which has some. */
size_t vor_said_size(enum vor_said what);

/** Says one thing; `of` has `size` bytes, as its member of the union.
 *
 *  @retval VOR_E_IO  nobody is there any more */
VOR_NODISCARD vor_status vor_say(int channel, enum vor_said what, const void *of, size_t size);

/** Hears the next thing. What came is checked, as the child may have gone mad: texts end and can be
 *  shown, numbers that index a table do. PART and FOUND are the caller's to check.
 *
 *  @param[out] size  bytes of `of`
 *  @param[out] xyz   POINTS: VOR_PREVIEW_POINTS_MAX x 3; NULL where they are not wanted
 *
 *  @return as vor_channel_receive; VOR_CHANNEL_GONE also when what came makes no sense, and then
 *          out->what is VOR_SAID_KINDS */
enum vor_channel_event vor_hear(struct vor_message_said *out, size_t *size, float *xyz, int channel,
                                double seconds);

#endif
